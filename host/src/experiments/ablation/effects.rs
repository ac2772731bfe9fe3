//! The effects of the ablation study: settings of the scenario with an effect and without it, at each carrier.

use crate::experiments::carriers::CARRIERS_HZ;
use crate::experiments::changed;
use crate::scenario::{Clusters, Scenario, ScenarioError};

/// An effect, and the fields that put it in and take it away, as `--set` takes them.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Effect {
    /// Its name.
    pub name: &'static str,
    /// Fields with the effect.
    pub with: &'static [&'static str],
    /// The same fields without it.
    pub without: &'static [&'static str],
}

/// The effects, one at a time away from the scenario: `with` or `without` states what the default scenario has. A further effect is a
/// further line.
pub const EFFECTS: &[Effect] = &[
    effect("the room fades as printed", &["channel.mode=paper"], &["channel.mode=rician"]),
    effect("fluctuation of the room", &["channel.k_factor_db=15"], &["channel.k_factor_db=80"]),
    effect("antenna pattern", &["radar.antenna_pattern=element"], &["radar.antenna_pattern=constant"]),
    effect("people shadow the room", &["channel.shadowing=true"], &["channel.shadowing=false"]),
    effect("the torso hides limbs", &["channel.occlusion=true"], &["channel.occlusion=false"]),
    effect("clusters of 802.11ay", &["channel.clusters=80211ay"], &["channel.clusters=80211ax"]),
    effect("second person", &["channel.interferer=true"], &["channel.interferer=false"]),
    effect("front end of a real module", &["radar.front_end=typical"], &["radar.front_end=ideal"]),
    effect(
        "adaptive clutter removal, against d = 1",
        &["spectrogram.first_kept=0"],
        &["spectrogram.first_kept=1"],
    ),
    effect(
        "adaptive clutter removal, against d = 2",
        &["spectrogram.first_kept=0"],
        &["spectrogram.first_kept=2"],
    ),
    effect("phase noise of the front end", &["radar.front_end=typical"], &["radar.phase_noise_dbc_hz=-200"]),
    effect("beta of the Kaiser window", &["spectrogram.beta=4"], &["spectrogram.beta=10"]),
    effect("eight windows of a recording", &["learning.windows=8"], &["learning.windows=1"]),
    effect("masked rows", &["learning.mask_rows=12"], &["learning.mask_rows=0"]),
];

const fn effect(
    name: &'static str,
    with: &'static [&'static str],
    without: &'static [&'static str],
) -> Effect {
    Effect { name, with, without }
}

/// The scenario at a carrier. At 60 GHz it is that of the built-in `radar-60ghz`: sensing slots follow one another, as many more as
/// make the same time of observation and between frames, with four bins a row. Clusters that follow the carrier are stated: those of the
/// carrier.
pub fn at(scenario: &Scenario, carrier_hz: f64) -> Scenario {
    let mut found = scenario.clone();
    found.radar.carrier_hz = carrier_hz;
    if found.channel.clusters == Clusters::ByCarrier {
        let high = found.channel.clusters.share_80211ay(carrier_hz) > 0.5;
        found.channel.clusters = if high { Clusters::Ieee80211ay } else { Clusters::Ieee80211ax };
    }
    if carrier_hz == CARRIERS_HZ[1] {
        let spacing = std::mem::take(&mut found.frame.spacing_slots);
        found.frame.sensing_slots.iter_mut().for_each(|slots| *slots *= spacing + 1);
        found.spectrogram.bins_per_row = 4;
        found.spectrogram.hop *= (spacing + 1) as u16;
    }
    found
}

impl Effect {
    /// The scenario with the effect and without it.
    ///
    /// # Errors
    ///
    /// A value that is illegal in this scenario.
    pub fn arms(&self, scenario: &Scenario) -> Result<[Scenario; 2], ScenarioError> {
        let set = |fields| changed(scenario, fields, "ablation");
        Ok([set(self.with)?, set(self.without)?])
    }

    /// Its name as part of a file's.
    pub fn key(&self) -> String {
        let name = self.name.to_lowercase();
        let words = name.split(|c: char| !c.is_ascii_alphanumeric() && c != '.');
        words.filter(|word| !word.is_empty()).collect::<Vec<_>>().join("-")
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scenario::Override;
    use crate::scenario::builtin::named;
    use std::collections::BTreeSet;

    #[test]
    fn every_effect_is_one_step_away_from_the_default_at_both_carriers() {
        for carrier_hz in CARRIERS_HZ {
            let base = at(&Scenario::default(), carrier_hz);
            base.check("ablation").unwrap();
            for effect in EFFECTS {
                let fields = effect.with.iter().chain(effect.without);
                assert!(fields.clone().all(|field| field.parse::<Override>().is_ok()), "{}", effect.name);
                let [with, without] = effect.arms(&base).unwrap();
                assert_ne!(with, without, "{}", effect.name);
                assert!(with == base || without == base, "{}: neither is the default", effect.name);
            }
        }
    }

    #[test]
    fn names_make_files_of_their_own() {
        let keys: BTreeSet<String> = EFFECTS.iter().map(Effect::key).collect();
        assert_eq!(keys.len(), EFFECTS.len());
        assert!(keys.contains("clusters-of-802.11ay"), "{keys:?}");
    }

    #[test]
    fn at_60_ghz_the_radar_looks_as_long_as_at_3_5() {
        let base = Scenario::default();
        let [low, high] = CARRIERS_HZ.map(|carrier_hz| at(&base, carrier_hz));
        assert_eq!(
            (low.channel.clusters, high.channel.clusters),
            (Clusters::Ieee80211ax, Clusters::Ieee80211ay)
        );
        let lasts = |s: &Scenario| s.interval_s() * f64::from(s.largest_sensing_slots());
        assert!((lasts(&low) / lasts(&high) - 1.0).abs() < 1e-12);
        assert_eq!(high.frame.sensing_slots, [800, 1200, 1600, 2000, 2400, 4000]);
        let built_in = named("radar-60ghz".as_ref()).unwrap().scenario();
        let frames = |s: &Scenario| f64::from(s.spectrogram.hop) * s.interval_s();
        assert!((frames(&low) / frames(&high) - 1.0).abs() < 1e-12);
        assert_eq!(high.spectrogram.bins_per_row, built_in.spectrogram.bins_per_row);
        assert_eq!((high.radar, high.frame.spacing_slots), (built_in.radar, built_in.frame.spacing_slots));
    }
}
