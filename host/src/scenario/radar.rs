//! The radar: where it is, what it sends, and what its converter delivers.
//!
//! Sweep and converter are free: [`Radar::config`] is what the radar module and every model file know of them.

use super::Scenario;
use super::rules::Rules;
use schemars::JsonSchema;
use sdp3_core::config::{self, RadarConfig, RangeGate, SampleFormat};
use serde::{Deserialize, Serialize};
use std::path::PathBuf;

/// What a sample is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Format {
    /// In-phase and quadrature.
    Complex,
    /// One value: a receiver with one mixer.
    Real,
}

/// Where the received sweep is mixed with the sent one.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Dechirp {
    /// After the converter, which samples the received sweep at a rate equal to the bandwidth.
    Digital,
    /// Before the converter, which samples the beat signal.
    Analog,
}

/// How the antenna's gain depends on the direction.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum AntennaPattern {
    /// The same gain in every direction: no antenna's, the paper's.
    Constant,
    /// The element of 3GPP TR 38.901 Table 7.3-1, its beam width from the gain.
    Element,
    /// A measured table, `radar.antenna_table`.
    Table,
}

/// Values of the analogue front end where a scenario states none.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum FrontEnd {
    /// No phase noise, leakage, offset or compression; I and Q equal and in quadrature.
    Ideal,
    /// A real module's: a direct-conversion receiver below 10 GHz, a single-chip transceiver from there on.
    Typical,
}

/// The radar at the base station: position, sweep, converter and front end.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Radar {
    /// Position in m.
    pub position_m: [f64; 3],
    /// Carrier frequency in Hz, at which the sweep begins.
    pub carrier_hz: f64,
    /// Swept bandwidth in Hz.
    pub bandwidth_hz: f64,
    /// Duration of the sampled part of a sweep in s.
    pub sweep_s: f64,
    /// Sampling rate in Hz, which is the bandwidth of the receiver's noise.
    pub sample_rate_hz: f64,
    /// Samples of a sweep; 1 of a Doppler sensor, which sends a constant frequency.
    pub samples: u16,
    /// What a sample is.
    pub format: Format,
    /// Significant bits of a value.
    pub converter_bits: u8,
    /// Whether they are the upper bits of 16, the lower ones zero; else the value is sign-extended.
    pub left_justified: bool,
    /// Where the received sweep is mixed with the sent one.
    pub dechirp: Dechirp,
    /// Range samples kept of a slot: blocks of the sweep, or cells of the range gate.
    pub range_samples: u8,
    /// First bin of the range gate, in bins of c / (2 B); 0 without a gate.
    pub first_bin: u16,
    /// Bins of each range sample of the gate; 0: no gate, the sweep's blocks are summed.
    pub bins_per_sample: u8,
    /// Corner in Hz of the AC coupling of a Doppler sensor, two sections of first order; 0: none.
    pub ac_coupling_hz: f64,
    /// Transmit power in W.
    pub power_w: f64,
    /// Gain of the transmit antenna and of the receive antenna, each, in dB.
    pub antenna_gain_db: f64,
    /// How the gain depends on the direction.
    pub antenna_pattern: AntennaPattern,
    /// CSV of azimuth and elevation from boresight in degrees and gain in dB, of the pattern `table`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub antenna_table: Option<PathBuf>,
    /// Point in m that the antenna looks at; absent: the torso of the person sensed where the recording begins.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub boresight_m: Option<[f64; 3]>,
    /// Level of the side lobes below the main lobe in dB, each way: the lowest gain of `element`; with `constant`, how others than the
    /// person sensed are seen.
    pub sidelobe_db: f64,
    /// Receiver noise figure in dB (290 K), both sidebands of the mixer counted.
    pub noise_figure_db: f64,
    /// Head room between the strongest expected echo and the converter's full scale in dB.
    pub headroom_db: f64,
    /// Values of the analogue front end that are not stated: none, or a real module's.
    pub front_end: FrontEnd,
    /// Oscillator's phase noise at 1 MHz in dBc/Hz, at this carrier; -200: none; absent: by `front_end`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub phase_noise_dbc_hz: Option<f64>,
    /// Bandwidth in Hz of the oscillator's loop, within which its phase noise is flat; absent: the module's for the carrier.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub phase_noise_loop_hz: Option<f64>,
    /// Floor of the phase noise in dBc/Hz; absent: the module's for the carrier.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub phase_noise_floor_dbc_hz: Option<f64>,
    /// Standard deviation of a further phase from slot to slot, white and the same for every delay, in degrees.
    pub phase_noise_deg: f64,
    /// Transmit power over its leakage into the receiver in dB, a high-pass filter there counted; 200: none; absent: by `front_end`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub isolation_db: Option<f64>,
    /// Input power in dBm that compresses the receiver by 1 dB; 100: never; absent: by `front_end`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub compression_dbm: Option<f64>,
    /// Gain mismatch of Q against I in dB; absent: by `front_end`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub iq_gain_db: Option<f64>,
    /// Deviation of I and Q from quadrature in degrees; absent: by `front_end`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub iq_phase_deg: Option<f64>,
    /// Magnitude of mixer's and converter's constant offset in parts of full scale; absent: by `front_end`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub dc_offset: Option<f64>,
}

impl Default for Radar {
    fn default() -> Self {
        Radar {
            position_m: [1.5, 1.0, 1.0],
            carrier_hz: 3.5e9,
            bandwidth_hz: 10e6,
            sweep_s: 100e-6,
            sample_rate_hz: 10e6,
            samples: 1000,
            format: Format::Complex,
            converter_bits: 16,
            left_justified: false,
            dechirp: Dechirp::Digital,
            range_samples: 8,
            first_bin: 0,
            bins_per_sample: 0,
            ac_coupling_hz: 0.0,
            power_w: 1.0,
            antenna_gain_db: 25.0,
            antenna_pattern: AntennaPattern::Element,
            antenna_table: None,
            boresight_m: None,
            sidelobe_db: 30.0,
            noise_figure_db: 10.0,
            headroom_db: 12.0,
            front_end: FrontEnd::Typical,
            phase_noise_dbc_hz: None,
            phase_noise_loop_hz: None,
            phase_noise_floor_dbc_hz: None,
            phase_noise_deg: 0.0,
            isolation_db: None,
            compression_dbm: None,
            iq_gain_db: None,
            iq_phase_deg: None,
            dc_offset: None,
        }
    }
}

impl Radar {
    /// The core's form of sweep and converter: part of every model file.
    pub fn config(&self) -> RadarConfig {
        let (first_bin, bins_per_sample) = (self.first_bin, self.bins_per_sample);
        RadarConfig {
            samples: self.samples,
            format: match self.format {
                Format::Complex => SampleFormat::Complex,
                Format::Real => SampleFormat::Real,
            },
            converter_bits: self.converter_bits,
            left_justified: self.left_justified,
            dechirp: match self.dechirp {
                Dechirp::Digital => config::Dechirp::Digital,
                Dechirp::Analog => config::Dechirp::Analog,
            },
            range_samples: self.range_samples,
            gate: (bins_per_sample > 0).then_some(RangeGate { first_bin, bins_per_sample }),
        }
    }

    /// Whether the sweep and the converter are the paper's: 10 MHz in 100 us, 1000 complex samples, dechirped in the radar module.
    pub fn is_papers(&self) -> bool {
        self.config() == RadarConfig::PAPER && self.bandwidth_hz == 10e6
    }

    /// This radar with sweep and converter of another.
    pub fn with_sweep_of(&self, other: &Radar) -> Radar {
        Radar {
            bandwidth_hz: other.bandwidth_hz,
            sweep_s: other.sweep_s,
            sample_rate_hz: other.sample_rate_hz,
            samples: other.samples,
            format: other.format,
            converter_bits: other.converter_bits,
            left_justified: other.left_justified,
            dechirp: other.dechirp,
            range_samples: other.range_samples,
            first_bin: other.first_bin,
            bins_per_sample: other.bins_per_sample,
            ac_coupling_hz: other.ac_coupling_hz,
            ..self.clone()
        }
    }

    /// Sweep rate in Hz/s.
    pub fn sweep_rate(&self) -> f64 {
        self.bandwidth_hz / self.sweep_s
    }

    /// Frequency at the sweep's middle in Hz: that of the Doppler shift.
    pub fn centre_hz(&self) -> f64 {
        self.carrier_hz + 0.5 * self.bandwidth_hz
    }
}

impl Scenario {
    pub(super) fn check_radar(&self, c: &mut Rules) {
        let r = &self.radar;
        c.inside("radar.position_m", &r.position_m, &self.room.size_m);
        c.within("radar.carrier_hz", r.carrier_hz, 0.5e9, 100e9);
        c.within("radar.bandwidth_hz", r.bandwidth_hz, 1e6, 10e9);
        c.beside("radar.sweep_s", r.sweep_s, [1e-6, self.frame.slot_s], "at most a slot");
        c.within("radar.sample_rate_hz", r.sample_rate_hz, 1e5, 1e8);
        let doppler = r.dechirp == Dechirp::Analog && r.bins_per_sample == 0;
        c.count("radar.samples", r.samples.into(), if doppler { 1 } else { 64 }, 2048);
        let product = (r.sweep_s * r.sample_rate_hz).round();
        let fits = (f64::from(r.samples) - r.sweep_s * r.sample_rate_hz).abs() < 1e-3;
        c.legal(
            "radar.samples",
            r.samples,
            fits,
            &format!("{product} (fixed): radar.sweep_s times radar.sample_rate_hz"),
        );
        c.count("radar.converter_bits", r.converter_bits.into(), 8, 16);
        c.count("radar.range_samples", r.range_samples.into(), 1, 8);
        self.check_dechirp(c);
        let highest = if r.samples == 1 { 0.25 / self.interval_s() } else { 0.0 };
        let legal = "a Doppler sensor's, of radar.samples = 1, up to a quarter of the rate of sensing slots";
        c.beside("radar.ac_coupling_hz", r.ac_coupling_hz, [0.0, highest], legal);
        c.within("radar.power_w", r.power_w, 1e-12, 1e3);
        c.within("radar.antenna_gain_db", r.antenna_gain_db, -10.0, 60.0);
        c.within("radar.sidelobe_db", r.sidelobe_db, 0.0, 60.0);
        // from 6 dB on the element has a beam; side lobes A_m below it radiate the gain alone where the gain is A_m
        let beam = r.antenna_pattern != AntennaPattern::Element
            || r.antenna_gain_db < 6.0
            || r.antenna_gain_db < r.sidelobe_db;
        let legal = format!("below radar.sidelobe_db = {}, or no element has this gain", r.sidelobe_db);
        c.legal("radar.antenna_gain_db", r.antenna_gain_db, beam, &legal);
        let table = r.antenna_pattern == AntennaPattern::Table;
        let shown = r.antenna_table.as_ref().map_or("missing".into(), |file| file.display().to_string());
        let legal = "a file where radar.antenna_pattern is table, and nothing else";
        c.legal("radar.antenna_table", shown, r.antenna_table.is_some() == table, legal);
        if let Some(point) = &r.boresight_m {
            let apart = point.iter().zip(&r.position_m).map(|(a, b)| (a - b) * (a - b)).sum::<f64>() > 1e-4;
            c.legal("radar.boresight_m", format!("{point:?}"), apart, "another point than radar.position_m");
            point.iter().for_each(|&x| c.within("radar.boresight_m", x, -100.0, 200.0));
        }
        c.within("radar.noise_figure_db", r.noise_figure_db, 0.0, 40.0);
        c.within("radar.headroom_db", r.headroom_db, 0.0, 60.0);
    }

    /// What depends on where the sweep is dechirped and on the gate.
    fn check_dechirp(&self, c: &mut Rules) {
        let r = &self.radar;
        let (kept, bins) = (f64::from(r.range_samples), f64::from(r.bins_per_sample));
        if r.dechirp == Dechirp::Digital {
            let legal = format!("{} (fixed): digital dechirp samples at radar.bandwidth_hz", r.bandwidth_hz);
            c.legal("radar.sample_rate_hz", r.sample_rate_hz, r.sample_rate_hz == r.bandwidth_hz, &legal);
            let complex = r.format == Format::Complex;
            let legal = "complex (fixed): digital dechirp needs I and Q; analog takes real samples";
            c.legal("radar.format", format!("{:?}", r.format).to_lowercase(), complex, legal);
        }
        match r.dechirp {
            Dechirp::Digital => {
                c.beside("radar.bins_per_sample", bins, [0.0; 2], "a gate needs analog dechirp");
            }
            Dechirp::Analog => c.within("radar.bins_per_sample", bins, 0.0, 32.0),
        }
        let profile = match r.format {
            Format::Complex => f64::from(r.samples),
            Format::Real => f64::from(r.samples / 2),
        };
        let last = (profile - kept * bins).max(0.0);
        let legal = match r.bins_per_sample {
            0 => "radar.bins_per_sample = 0 says there is no gate",
            _ => "the gate must end within the range profile",
        };
        let last = if r.bins_per_sample == 0 { 0.0 } else { last };
        c.beside("radar.first_bin", r.first_bin.into(), [0.0, last], legal);
        if r.bins_per_sample == 0 {
            let divides = r.range_samples > 0 && r.samples.is_multiple_of(r.range_samples.into());
            let legal = format!("a divisor of radar.samples = {}: blocks are equally long", r.samples);
            c.legal("radar.range_samples", r.range_samples, divides, &legal);
        } else {
            let legal = format!(
                "at most {profile} / radar.bins_per_sample: the gate must end within the range profile"
            );
            c.legal("radar.range_samples", r.range_samples, kept * bins <= profile, &legal);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::builtin::named;
    use super::*;
    use std::path::Path;

    #[test]
    fn shipped_scenarios_are_the_cores_configurations() {
        let config = |name: &str| named(Path::new(name)).map(|one| one.scenario().radar.config());
        assert_eq!(config("conference-room"), Some(RadarConfig::PAPER));
        assert_eq!(config("bgt60"), Some(RadarConfig::BGT60));
        assert_eq!(config("iwr"), Some(RadarConfig::IWR));
    }

    #[test]
    fn what_the_rules_take_the_core_takes_and_nothing_else() {
        let mut legal = 0;
        let base = [
            Scenario::default(),
            named(Path::new("bgt60")).unwrap().scenario(),
            named(Path::new("iwr")).unwrap().scenario(),
        ];
        for mut scenario in base {
            let papers = scenario.radar.clone();
            for change in 0..600_u32 {
                let r = &mut scenario.radar;
                *r = papers.clone();
                let pick = |k: u32, n: u32| (change / k) % n;
                r.samples = [papers.samples, 64, 63, 1, 2048, 2049][pick(1, 6) as usize];
                match r.dechirp {
                    Dechirp::Digital => r.sweep_s = f64::from(r.samples) / r.sample_rate_hz,
                    // one sample needs no more than the lowest rate
                    Dechirp::Analog if r.samples == 1 => (r.sample_rate_hz, r.sweep_s) = (1e5, 1e-5),
                    Dechirp::Analog => r.sample_rate_hz = f64::from(r.samples) / r.sweep_s,
                }
                r.range_samples = [papers.range_samples, 0, 1, 5, 9][pick(6, 5) as usize];
                r.bins_per_sample = [papers.bins_per_sample, 0, 32, 33][pick(30, 4) as usize];
                r.first_bin = [papers.first_bin, 0, 40, 1024, 3][pick(120, 5) as usize];
                let mut rules = Rules::default();
                scenario.check_radar(&mut rules);
                let holds = rules.list.iter().all(|rule| rule.holds);
                let found = scenario.radar.config();
                // a first bin without a gate is refused here and unknown to the core
                let stray = scenario.radar.bins_per_sample == 0 && scenario.radar.first_bin != 0;
                assert_eq!(holds, found.is_valid() && !stray, "{:?}", scenario.radar);
                legal += u32::from(holds);
            }
        }
        assert!(legal > 50, "{legal}");
    }

    #[test]
    fn a_value_that_another_fixes_is_refused_with_that_value() {
        let refused = |set: &[&str], words: &[&str]| {
            let set: Vec<_> = set.iter().map(|one| one.parse().unwrap()).collect();
            let error = Scenario::default().with(&set, "built in").unwrap_err().to_string();
            words.iter().for_each(|word| assert!(error.contains(word), "{word} is not in: {error}"));
        };
        refused(&["radar.bandwidth_hz=20e6"], &["radar.sample_rate_hz is 10000000", "20000000 (fixed)"]);
        refused(&["radar.samples=500"], &["radar.samples is 500", "1000 (fixed): radar.sweep_s times"]);
        refused(&["radar.format=real"], &["radar.format is real", "complex (fixed)"]);
        refused(&["radar.bins_per_sample=4"], &["radar.bins_per_sample is 4", "0 (fixed)", "analog"]);
        refused(&["radar.first_bin=4"], &["radar.first_bin is 4", "0 (fixed)", "no gate"]);
        refused(
            &["radar.range_samples=3"],
            &["radar.range_samples is 3", "a divisor of radar.samples = 1000"],
        );
        let set = ["radar.bandwidth_hz=20e6", "radar.sample_rate_hz=20e6", "radar.samples=2000"];
        let set: Vec<_> = set.iter().map(|one| one.parse().unwrap()).collect();
        assert!(Scenario::default().with(&set, "built in").is_ok());
    }
}
