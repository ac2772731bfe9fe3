//! What is simulated for the paper's items: the two settings, the carriers, and what stands for the paper's experiment.

use super::Size;
use crate::experiments::carriers::at_carrier;
use crate::scenario::{Class, Interior, Model, Other, Scenario, builtin};

/// The settings that are set beside each other.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Settings {
    /// The paper's, its room's transient and its training included.
    AsPrinted,
    /// The scenario's.
    Here,
}

impl Settings {
    pub const BOTH: [Settings; 2] = [Settings::AsPrinted, Settings::Here];

    pub fn name(self) -> &'static str {
        match self {
            Settings::AsPrinted => "as-printed",
            Settings::Here => "here",
        }
    }

    pub fn words(self) -> &'static str {
        match self {
            Settings::AsPrinted => "as printed",
            Settings::Here => "here",
        }
    }
}

/// Passes over the images with the settings as printed, by which the loss has converged: few recordings make few steps.
fn printed_epochs(size: Size) -> u32 {
    match size {
        Size::Quick => 100,
        Size::Paper => 200,
    }
}

/// A scenario at a carrier.
pub fn scenario(base: &Scenario, size: Size, settings: Settings, carrier_hz: f64) -> Scenario {
    let mut found = base.clone();
    if settings == Settings::AsPrinted {
        found = builtin::named("as-printed".as_ref()).map_or_else(Scenario::default, |it| it.scenario());
        let (to, from) = (&mut found.learning, &base.learning);
        (to.train_per_class, to.test_per_class) = (from.train_per_class, from.test_per_class);
        (to.channels, to.blocks, to.stem_stride) = (from.channels, from.blocks, from.stem_stride);
        to.epochs = printed_epochs(size);
        found.frame.sensing_slots.clone_from(&base.frame.sensing_slots);
    }
    at_carrier(&found, carrier_hz)
}

/// What stands for the paper's experiment, of which nothing is public, and is not the hybrid channel: a furnished room by ray tracing, with
/// rough surfaces and diffraction, in which somebody else stands; the scenario's antenna and front end with I and Q further out
/// of balance; people with twice the spread of speeds.
pub fn experiment(base: &Scenario, size: Size, carrier_hz: f64) -> Scenario {
    let mut found = scenario(base, size, Settings::Here, carrier_hz);
    found.channel.model = Model::RayTracing;
    (found.channel.interior, found.channel.scattering) = (Interior::Furnished, 0.4);
    found.channel.diffraction = true;
    found.target.others = vec![Other { class: Class::Standing, start_m: [0.6, 2.8], heading_deg: None }];
    (found.radar.iq_gain_db, found.radar.iq_phase_deg) = (Some(0.5), Some(2.0));
    found.target.speed_jitter = (2.0 * found.target.speed_jitter).min(0.5);
    found
}

/// The paper's baseline: ray tracing in a bare room with smooth walls, in which nothing stands in the way of a wave.
pub fn ray_tracing(mut scenario: Scenario) -> Scenario {
    let channel = &mut scenario.channel;
    channel.model = Model::RayTracing;
    (channel.interior, channel.scattering, channel.diffraction) = (Interior::Bare, 0.0, false);
    (channel.shadowing, channel.occlusion, channel.double_bounce) = (false, false, false);
    scenario
}

/// What is added to a seed for the experiment's own people.
pub const OTHERS: u64 = 1 << 40;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::experiments::carriers::CARRIERS_HZ;

    #[test]
    fn all_scenarios_are_legal_and_unlike_each_other() {
        let base = Scenario::default();
        let mut seen: Vec<Scenario> = Vec::new();
        for carrier_hz in CARRIERS_HZ {
            for size in [Size::Quick, Size::Paper] {
                let both = Settings::BOTH.map(|settings| scenario(&base, size, settings, carrier_hz));
                for found in both.into_iter().chain([experiment(&base, size, carrier_hz)]) {
                    found.check("test").unwrap();
                    assert_eq!(found.frame.sensing_slots, base.frame.sensing_slots);
                    if !seen.contains(&found) {
                        seen.push(found);
                    }
                }
            }
        }
        // the size is in the settings as printed alone
        assert_eq!(seen.len(), 2 * (2 + 1 + 1));
    }
}
