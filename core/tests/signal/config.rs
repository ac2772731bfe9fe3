//! Tests of `config`.

use sdp3_core::config::*;

#[test]
fn shipped_configurations_are_valid_and_survive_their_bytes() {
    for config in [RadarConfig::PAPER, RadarConfig::BGT60, RadarConfig::IWR] {
        assert!(config.is_valid());
        assert_eq!(RadarConfig::from_bytes(config.to_bytes()), Some(config));
    }
    assert_eq!(RadarConfig::PAPER.to_bytes(), [0; 8]);
    assert_eq!((RadarConfig::PAPER.shift(), RadarConfig::PAPER.values_per_slot()), (12, 2000));
    assert_eq!((RadarConfig::BGT60.shift(), RadarConfig::BGT60.reference_len()), (12, 1024));
}

#[test]
fn what_does_not_fit_is_refused() {
    let paper = RadarConfig::PAPER;
    for wrong in [
        RadarConfig { samples: 63, range_samples: 1, ..paper },
        RadarConfig { samples: 2056, ..paper },
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
