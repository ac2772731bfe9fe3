//! The analogue front end: what a scenario states of it, and a real module's values where it states nothing.

use super::radar::{Format, FrontEnd, Radar};
use super::rules::Rules;

/// At and below this level there is no phase noise, in dBc/Hz.
const NO_PHASE_NOISE: f64 = -200.0;
/// From this isolation on there is no leakage, in dB.
const NO_LEAKAGE: f64 = 200.0;
/// From this input power on there is no compression, in dBm.
const NO_COMPRESSION: f64 = 100.0;

/// Phase noise of an oscillator in a phase-locked loop: flat within the loop, falling with the square of the frequency beyond, a
/// floor.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Spectrum {
    /// Level at 1 MHz of the part that falls, in 1/Hz.
    pub level: f64,
    /// Bandwidth of the loop in Hz.
    pub loop_hz: f64,
    /// Floor in 1/Hz.
    pub floor: f64,
}

impl Spectrum {
    /// Single-sideband phase noise L at an offset, in 1/Hz; it is the two-sided spectral density of the phase in rad^2/Hz.
    pub fn at(&self, offset_hz: f64) -> f64 {
        self.level * 1e12 / (offset_hz * offset_hz + self.loop_hz * self.loop_hz) + self.floor
    }
}

/// The front end that a radar has: stated values and, where there are none, those that [`FrontEnd`] selects.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Effects {
    /// The oscillator's phase noise.
    pub spectrum: Option<Spectrum>,
    /// Transmit power over leakage at the receiver in dB.
    pub isolation_db: Option<f64>,
    /// Magnitude of the offset in parts of the converter's full scale.
    pub dc_offset: f64,
    /// Input power of 1 dB compression in dBm.
    pub compression_dbm: Option<f64>,
    /// Whether an attenuator keeps the compression above the converter's full scale: with a module's value, not with a stated one.
    pub attenuator: bool,
    /// Gain of Q over that of I in dB.
    pub iq_gain_db: f64,
    /// Deviation of I and Q from quadrature in degrees.
    pub iq_phase_deg: f64,
}

/// A real module's values.
struct Module {
    /// Frequency to which the phase noise belongs, in Hz.
    reference_hz: f64,
    level_dbc_hz: f64,
    loop_hz: f64,
    floor_dbc_hz: f64,
    isolation_db: f64,
    dc_offset: f64,
    compression_dbm: f64,
    iq_gain_db: f64,
    iq_phase_deg: f64,
}

/// Analog Devices ADF4351 at 3.3 GHz: -134 dBc/Hz at 1 MHz; -104 dBc/Hz in the loop, from its normalised floor of -220 dBc/Hz, a
/// phase detector at 25 MHz and a division by 132: the two meet at 30 kHz; -145 dBc/Hz at 5 MHz leaves a floor of -148 dBc/Hz.
/// LTC5584: 1 dB compression at 13 dBm, image rejection 45 dB, here in equal parts of gain and phase. Separate antennas.
const DIRECT_CONVERSION: Module = Module {
    reference_hz: 3.3e9,
    level_dbc_hz: -134.0,
    loop_hz: 30e3,
    floor_dbc_hz: -148.0,
    isolation_db: 40.0,
    dc_offset: 0.002,
    compression_dbm: 13.0,
    iq_gain_db: 0.07,
    iq_phase_deg: 0.46,
};

/// TI's transceivers for 76 to 81 GHz (data sheet SWRS330): -95 dBc/Hz at 1 MHz, 1 dB compression at -7 dBm. Infineon's
/// BGT60TR13C has -80 dBc/Hz at 100 kHz, which a loop of 100 kHz gives. Isolation: 35 dB between antennas, 30 dB by the high-pass
/// filter (second order, from 300 kHz, SWRS330) at the leakage's beat. Floor, offset and quadrature (image rejection 37 dB) are assumed.
const SINGLE_CHIP: Module = Module {
    reference_hz: 77e9,
    level_dbc_hz: -95.0,
    loop_hz: 100e3,
    floor_dbc_hz: -130.0,
    isolation_db: 65.0,
    dc_offset: 0.002,
    compression_dbm: -7.0,
    iq_gain_db: 0.2,
    iq_phase_deg: 1.0,
};

/// dB as a ratio of powers.
fn ratio(db: f64) -> f64 {
    libm::pow(10.0, db / 10.0)
}

impl Radar {
    fn module(&self) -> &'static Module {
        if self.carrier_hz < 10e9 { &DIRECT_CONVERSION } else { &SINGLE_CHIP }
    }

    /// What its front end does.
    pub fn effects(&self) -> Effects {
        let module = self.module();
        let typical = self.front_end == FrontEnd::Typical;
        let or =
            |stated: Option<f64>, module: f64, off: f64| stated.unwrap_or(if typical { module } else { off });
        // an oscillator that is multiplied up has as many times the phase
        let scaled_db = 20.0 * libm::log10(self.centre_hz() / module.reference_hz);
        let level = or(self.phase_noise_dbc_hz, module.level_dbc_hz + scaled_db, NO_PHASE_NOISE);
        let floor = self.phase_noise_floor_dbc_hz.unwrap_or(module.floor_dbc_hz + scaled_db);
        let isolation_db = or(self.isolation_db, module.isolation_db, NO_LEAKAGE);
        let compression_dbm = or(self.compression_dbm, module.compression_dbm, NO_COMPRESSION);
        let quadrature = if self.format == Format::Real { 0.0 } else { 1.0 };
        Effects {
            spectrum: (level > NO_PHASE_NOISE).then(|| Spectrum {
                level: ratio(level),
                loop_hz: self.phase_noise_loop_hz.unwrap_or(module.loop_hz),
                floor: ratio(floor),
            }),
            isolation_db: (isolation_db < NO_LEAKAGE).then_some(isolation_db),
            dc_offset: or(self.dc_offset, module.dc_offset, 0.0),
            compression_dbm: (compression_dbm < NO_COMPRESSION).then_some(compression_dbm),
            attenuator: self.compression_dbm.is_none(),
            iq_gain_db: or(self.iq_gain_db, quadrature * module.iq_gain_db, 0.0),
            iq_phase_deg: or(self.iq_phase_deg, quadrature * module.iq_phase_deg, 0.0),
        }
    }

    pub(super) fn check_front_end(&self, c: &mut Rules) {
        let stated = [
            ("radar.phase_noise_dbc_hz", self.phase_noise_dbc_hz, [NO_PHASE_NOISE, -70.0]),
            ("radar.phase_noise_loop_hz", self.phase_noise_loop_hz, [1e3, 1e6]),
            ("radar.phase_noise_floor_dbc_hz", self.phase_noise_floor_dbc_hz, [NO_PHASE_NOISE, -90.0]),
            ("radar.isolation_db", self.isolation_db, [0.0, NO_LEAKAGE]),
            ("radar.dc_offset", self.dc_offset, [0.0, 0.5]),
            ("radar.compression_dbm", self.compression_dbm, [-100.0, NO_COMPRESSION]),
            ("radar.iq_gain_db", self.iq_gain_db, [-6.0, 6.0]),
            ("radar.iq_phase_deg", self.iq_phase_deg, [-30.0, 30.0]),
        ];
        for (field, value, [low, high]) in stated {
            c.within(field, value.unwrap_or(0.0_f64.clamp(low, high)), low, high);
        }
        c.within("radar.phase_noise_deg", self.phase_noise_deg, 0.0, 90.0);
        if self.format == Format::Real {
            for (field, value) in
                [("radar.iq_gain_db", self.iq_gain_db), ("radar.iq_phase_deg", self.iq_phase_deg)]
            {
                let value = value.unwrap_or(0.0);
                c.legal(field, value, value == 0.0, "0 (fixed): real samples have no quadrature");
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scenario::Scenario;
    use crate::scenario::builtin::named;

    fn effects(name: &str, set: &[&str]) -> Effects {
        let set: Vec<_> = set.iter().map(|one| one.parse().unwrap()).collect();
        named(name.as_ref()).unwrap().scenario().with(&set, "built in").unwrap().radar.effects()
    }

    const OFF: [&str; 6] = [
        "radar.phase_noise_dbc_hz=-200",
        "radar.isolation_db=200",
        "radar.dc_offset=0",
        "radar.compression_dbm=100",
        "radar.iq_gain_db=0",
        "radar.iq_phase_deg=0",
    ];

    #[test]
    fn one_word_selects_a_module_and_each_field_switches_its_effect() {
        for name in ["conference-room", "radar-24ghz", "bgt60", "iwr"] {
            let ideal = effects(name, &["radar.front_end=ideal"]);
            let none = Effects { attenuator: ideal.attenuator, ..ideal };
            assert_eq!((none.spectrum, none.isolation_db, none.compression_dbm), (None, None, None));
            assert_eq!((none.dc_offset, none.iq_gain_db, none.iq_phase_deg), (0.0, 0.0, 0.0));
            let typical = effects(name, &["radar.front_end=typical"]);
            assert!(typical.spectrum.is_some() && typical.isolation_db.is_some() && typical.dc_offset > 0.0);
            assert!(typical.compression_dbm.is_some() && typical.attenuator);
            // real samples have no quadrature
            assert_eq!(typical.iq_gain_db > 0.0 && typical.iq_phase_deg > 0.0, name != "bgt60");
            let mut set = vec!["radar.front_end=typical"];
            set.extend(OFF);
            let off = effects(name, &set);
            assert_eq!(Effects { attenuator: none.attenuator, ..off }, none, "{name}");
        }
    }

    #[test]
    fn a_stated_value_is_taken_with_either_word_and_not_scaled() {
        for word in ["radar.front_end=ideal", "radar.front_end=typical"] {
            let found = effects("iwr", &[word, "radar.phase_noise_dbc_hz=-100", "radar.compression_dbm=-20"]);
            let spectrum = found.spectrum.unwrap();
            assert!((10.0 * libm::log10(spectrum.level) + 100.0).abs() < 1e-9);
            assert_eq!((found.compression_dbm, found.attenuator), (Some(-20.0), false));
        }
    }

    #[test]
    fn typical_phase_noise_is_that_of_the_data_sheets() {
        let at = |name, hz| {
            10.0 * libm::log10(effects(name, &["radar.front_end=typical"]).spectrum.unwrap().at(hz))
        };
        // BGT60TR13C at 60 GHz, SWRS330 at 76 to 81 GHz, ADF4351 brought from 3.3 to 3.5 GHz
        assert!((at("bgt60", 100e3) + 80.0).abs() < 0.5 && (at("bgt60", 1e6) + 97.0).abs() < 0.5);
        assert!((at("iwr", 1e6) + 95.0).abs() < 0.5);
        for (hz, dbc_hz) in [(1e3, -103.5), (1e6, -133.5), (5e6, -144.5)] {
            let found = at("conference-room", hz);
            assert!((found - dbc_hz).abs() < 1.0, "{hz}: {found}");
        }
    }

    #[test]
    fn real_samples_take_no_quadrature() {
        let refused = |set: &str| {
            let bgt60: Scenario = named("bgt60".as_ref()).unwrap().scenario();
            bgt60.with(&[set.parse().unwrap()], "built in").unwrap_err().to_string()
        };
        assert!(refused("radar.iq_gain_db=1").contains("no quadrature"));
        assert!(refused("radar.phase_noise_dbc_hz=-60").contains("-200 to -70"));
    }
}
