//! What is said before the work begins: warnings of results that would say little, and notes of settings without effect.

use super::Job;
use crate::scenario::{Class, Room};
use crate::simulator::channel::link::knows_walls;
use crate::simulator::{calibration, validity};

/// A standard deviation of an accuracy, in points, that needs no warning.
const MOST_UNCERTAIN_POINTS: f64 = 5.0;

impl Job {
    /// A warning if limbs of people of these classes alias.
    pub fn warn_of_aliasing(&self, classes: &[Class]) {
        if let Some(aliasing) = validity::aliasing(&self.scenario, classes) {
            self.progress.note("simulate", &format!("warning: {aliasing}"));
        }
    }

    /// A note if people come nearer than the antenna's far field.
    pub fn note_near_field(&self) {
        if let Some([nearest, far]) = validity::near_field(&self.scenario) {
            let text = format!(
                "the antenna's far field begins at {far:.1} m (2 D^2 / lambda) and people come as near as {nearest:.1} m, where its pattern \
                 and the radar equation are approximations"
            );
            self.progress.note("simulate", &text);
        }
    }

    /// A warning if the stored rho, which is used where the scenario states none, is of another carrier or slot interval.
    pub fn warn_of_rho(&self) {
        let stored =
            self.scenario.channel.rho.is_none().then(|| calibration::stored_elsewhere(&self.scenario));
        if let Some(text) = stored.flatten() {
            self.progress.note("calibrate", &format!("warning: {text}"));
        }
    }

    /// A note if the room was set to a size that the links do not depend on.
    pub fn note_room(&self) {
        let s = &self.scenario;
        let of_links = s.room != Room::default() && s.communication.slot_bit.is_none();
        if of_links && !knows_walls(s) {
            let text = format!(
                "room.size_m = {:?} does not change the throughput: links of channel.model = {} have no walls here; those of \
                 ray-tracing have, and those of dahc with channel.mode = rician or channel.clusters = 80211ay",
                s.room.size_m,
                s.channel.model.name()
            );
            self.progress.note("optimize", &text);
        }
    }

    /// A warning if so few recordings are tested that an accuracy says little.
    pub fn warn_of_few_tests(&self) {
        let tested = self.scenario.learning.test_per_class * Class::ALL.len() as u32;
        // a share of n is uncertain by at most 0.5 / sqrt(n), one standard deviation
        let points = 50.0 / f64::from(tested).sqrt();
        if points > MOST_UNCERTAIN_POINTS {
            let text = format!(
                "warning: an accuracy over {tested} test recordings is uncertain by up to {points:.0} points; with \
                 learning.test_per_class = 100 by up to 2"
            );
            self.progress.note("test", &text);
        }
    }
}
