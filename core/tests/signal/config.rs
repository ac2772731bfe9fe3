//! Tests of `config`.

use sdp3_core::config::*;

#[test]
fn shipped_configurations_are_valid_and_survive_their_bytes() {
    let doppler = [RadarConfig::DOPPLER, RadarConfig::DOPPLER_IQ];
    for config in [RadarConfig::PAPER, RadarConfig::BGT60, RadarConfig::IWR].into_iter().chain(doppler) {
        assert!(config.is_valid());
        assert_eq!(RadarConfig::from_bytes(config.to_bytes()), Some(config));
    }
    assert_eq!(RadarConfig::PAPER.to_bytes(), [0; 8]);
    assert_eq!((RadarConfig::PAPER.shift(), RadarConfig::PAPER.values_per_slot()), (12, 2000));
    assert_eq!((RadarConfig::BGT60.shift(), RadarConfig::BGT60.reference_len()), (12, 1024));
    assert_eq!(doppler.map(|d| (d.shift(), d.values_per_slot(), d.reference_len())), [(0, 1, 0), (0, 2, 0)]);
}

#[test]
fn what_does_not_fit_is_refused() {
    let paper = RadarConfig::PAPER;
    for wrong in [
        RadarConfig { samples: 63, range_samples: 1, ..paper },
        RadarConfig { samples: 2056, ..paper },
        RadarConfig { samples: 63, ..RadarConfig::IWR },
        RadarConfig { samples: 0, ..RadarConfig::DOPPLER },
        RadarConfig { range_samples: 2, ..RadarConfig::DOPPLER },
        RadarConfig { dechirp: Dechirp::Digital, ..RadarConfig::DOPPLER },
        RadarConfig { samples: 1001, ..paper },
        RadarConfig { range_samples: 0, ..paper },
        RadarConfig { range_samples: 9, samples: 900, ..paper },
        RadarConfig { converter_bits: 7, ..paper },
        RadarConfig { converter_bits: 17, ..paper },
        RadarConfig { format: SampleFormat::Real, ..paper },
        RadarConfig { gate: RadarConfig::IWR.gate, ..paper },
        RadarConfig { gate: Some(RangeGate { first_bin: 33, bins_per_sample: 4 }), ..RadarConfig::BGT60 },
        RadarConfig { gate: Some(RangeGate { first_bin: 0, bins_per_sample: 33 }), ..RadarConfig::IWR },
    ] {
        assert!(!wrong.is_valid(), "{wrong:?}");
        assert_eq!(RadarConfig::from_bytes(wrong.to_bytes()), None);
    }
    assert_eq!(RadarConfig::from_bytes([0xe8, 3, 8, 16, 8, 0, 0, 0]), None, "an unknown flag");
    assert_eq!(RadarConfig::from_bytes([0xe8, 3, 8, 16, 0, 0, 1, 0]), None, "a first bin without a gate");
}

/// The rules of the fields' documentation, in whole numbers without a limit.
fn fits(c: &RadarConfig) -> bool {
    let (samples, count) = (i64::from(c.samples), i64::from(c.range_samples));
    let real = c.format == SampleFormat::Real;
    let analog = c.dechirp == Dechirp::Analog;
    let least = if analog && c.gate.is_none() { 1 } else { 64 };
    let ranges =
        (least..=2048).contains(&samples) && (1..=8).contains(&count) && (8..=16).contains(&c.converter_bits);
    ranges
        && match c.gate {
            None => (analog || !real) && samples % count == 0,
            Some(gate) => {
                let bins = i64::from(gate.bins_per_sample);
                let profile = if real { samples / 2 } else { samples };
                let inside = i64::from(gate.first_bin) + bins * count <= profile;
                analog && (1..=32).contains(&bins) && inside
            }
        }
}

#[test]
fn validity_and_bytes_follow_the_rules_at_every_edge() {
    let gates = [0, 1, 24, 31, 32, 48, 49, 192, 193, 0xffff].into_iter().flat_map(|first_bin| {
        [0, 1, 4, 8, 9, 32, 33, 255].map(|bins_per_sample| Some(RangeGate { first_bin, bins_per_sample }))
    });
    let gates: Vec<Option<RangeGate>> = std::iter::once(None).chain(gates).collect();
    let mut valid = 0;
    for samples in [0, 1, 2, 63, 64, 65, 127, 128, 129, 256, 1000, 1001, 2047, 2048, 2049, 0xffff] {
        for range_samples in 0..=9 {
            for converter_bits in [0, 7, 8, 12, 16, 17, 255] {
                for (format, dechirp, left_justified) in [
                    (SampleFormat::Real, Dechirp::Analog, false),
                    (SampleFormat::Real, Dechirp::Digital, true),
                    (SampleFormat::Complex, Dechirp::Analog, true),
                    (SampleFormat::Complex, Dechirp::Digital, false),
                ] {
                    for &gate in &gates {
                        let config = RadarConfig {
                            samples,
                            format,
                            converter_bits,
                            left_justified,
                            dechirp,
                            range_samples,
                            gate,
                        };
                        assert_eq!(config.is_valid(), fits(&config), "{config:?}");
                        let back = RadarConfig::from_bytes(config.to_bytes());
                        // no gate and one without bins have the same bytes, and zeros are the paper's
                        let ambiguous = gate.is_some_and(|gate| gate.bins_per_sample == 0) || samples == 0;
                        assert!(ambiguous || back == fits(&config).then_some(config), "{config:?}");
                        valid += usize::from(config.is_valid());
                    }
                }
            }
        }
    }
    assert!(valid > 1000, "{valid}");
}

#[test]
fn bytes_are_laid_out_as_documented() {
    assert_eq!(RadarConfig::BGT60.to_bytes(), [128, 0, 8, 12, 1 + 4, 4, 6, 0]);
    let gate = Some(RangeGate { first_bin: 0x102, bins_per_sample: 16 });
    let upper = RadarConfig { left_justified: true, gate, ..RadarConfig::IWR };
    assert_eq!(upper.to_bytes(), [0, 1, 8, 16, 2 + 4, 16, 2, 1]);
}
