//! The rules of a scenario, checked once: no other module has to check a value.

use super::overrides::{ORIGIN, Override};
use super::rules::{Rule, Rules};
use super::{Advance, Scenario, ScenarioError, SpectrogramSettings};
use crate::error::Invalid;
use crate::text::is_printable;
use sdp3_core::dims::FFT_LEN;
use sdp3_core::signal::clutter::SvdRange;
use sdp3_core::signal::front_end::Preprocessing;

impl Scenario {
    /// Name of the file in a folder of results that holds the scenario they are of.
    pub const FILE: &str = "scenario.toml";

    /// Largest N_s studied.
    pub fn largest_sensing_slots(&self) -> u32 {
        self.frame.sensing_slots.iter().copied().max().unwrap_or(0)
    }

    /// Time between two sensing slots in s.
    pub fn interval_s(&self) -> f64 {
        self.frame.slot_s * f64::from(self.frame.spacing_slots + 1)
    }

    /// Time between the responses of the room that rho correlates, in s.
    pub fn rho_interval_s(&self) -> f64 {
        match self.channel.advance {
            Advance::SensingSlot => self.interval_s(),
            Advance::Slot => self.frame.slot_s,
        }
    }

    /// Length of a period in s.
    pub fn period_s(&self) -> f64 {
        self.frame.slot_s * f64::from(self.frame.period_slots)
    }

    /// The fewest sensing slots of a recording: four windows of the spectrogram.
    pub fn least_sensing_slots(&self) -> u32 {
        u32::from(self.spectrogram.window) + 3 * u32::from(self.spectrogram.hop)
    }

    /// Checks every value; `origin` (a file, or `command line`) begins each message.
    ///
    /// # Errors
    ///
    /// [`ScenarioError::Invalid`] for the first value outside its range.
    pub fn check(&self, origin: &str) -> Result<(), ScenarioError> {
        self.errors(origin, &[]).into_iter().next().map_or(Ok(()), Err)
    }

    /// Every value outside its range, with the override that set it or else `origin` as where it is from.
    pub(super) fn errors(&self, origin: &str, set: &[Override]) -> Vec<ScenarioError> {
        let broken = self.rules().into_iter().filter(|rule| !rule.holds);
        let error = |rule: Rule| {
            let overridden = set.iter().any(|one| one.sets(&rule.field));
            let origin = if overridden { ORIGIN } else { origin };
            Invalid::new(rule.field, rule.value, rule.legal).at(origin).into()
        };
        broken.map(error).collect()
    }

    /// Every rule for this scenario's values, and whether it holds.
    pub fn rules(&self) -> Vec<Rule> {
        let mut rules = Rules::default();
        let c = &mut rules;
        self.check_room(c);
        self.check_radar(c);
        self.radar.check_front_end(c);
        c.within("channel.rho", self.channel.rho.unwrap_or(1.0), 0.0, 1.0);
        c.within("channel.k_factor_db", self.channel.k_factor_db, -20.0, 80.0);
        c.within("channel.clutter_gain_db", self.channel.clutter_gain_db, -60.0, 60.0);
        c.within("channel.scattering", self.channel.scattering, 0.0, 1.0);
        self.check_name(c);
        self.check_frame(c);
        self.check_target(c);
        self.check_learning(c);
        self.check_communication(c);
        self.check_trade(c);
        rules.list
    }

    /// It becomes part of scripts, pages, tables and terminals.
    fn check_name(&self, c: &mut Rules) {
        let plain = self.name.starts_with(char::is_alphanumeric) && self.name.chars().all(is_printable);
        let legal = "1 to 100 printable characters, the first a letter or digit";
        c.legal("name", format!("{:?}", self.name), plain && self.name.chars().count() <= 100, legal);
    }

    fn check_target(&self, c: &mut Rules) {
        let t = &self.target;
        c.ground("target.start_m", &t.start_m, &self.room.size_m);
        for (k, point) in t.waypoints_m.iter().enumerate() {
            c.ground(&format!("target.waypoints_m[{k}]"), point, &self.room.size_m);
        }
        c.count("target.others (how many)", t.others.len() as u32, 0, 8);
        for (k, other) in t.others.iter().enumerate() {
            c.ground(&format!("target.others[{k}].start_m"), &other.start_m, &self.room.size_m);
            c.within(
                &format!("target.others[{k}].heading_deg"),
                other.heading_deg.unwrap_or(0.0),
                -360.0,
                360.0,
            );
        }
        c.within("target.heading_spread_deg", self.target.heading_spread_deg, 0.0, 180.0);
        c.within("target.speed_jitter", self.target.speed_jitter, 0.0, 0.5);
        // nobody is taller than the room
        let tallest = self.room.size_m[2].min(2.5);
        c.interval("target.adult_height_m", &self.target.adult_height_m, 0.5, tallest);
        c.interval("target.child_height_m", &self.target.child_height_m, 0.5, tallest);
        if c.list.iter().all(|rule| rule.holds) {
            self.check_walks(c);
        }
    }

    /// Without turns a walk may lead through a wall: refused, with the time at which it would.
    fn check_walks(&self, c: &mut Rules) {
        let t = &self.target;
        if t.turns || t.waypoints_m.len() > 1 || t.capture.is_some() {
            return;
        }
        let slots = self.learning.training_slots(self.largest_sensing_slots());
        let duration = self.interval_s() * f64::from(slots);
        let speed = 0.5 * t.adult_height_m[1] * (1.0 + 3.0 * t.speed_jitter);
        let [x, y] = t.start_m;
        let radar = self.radar.position_m;
        let towards = libm::atan2(radar[1] - y, radar[0] - x);
        let mut soonest = f64::INFINITY;
        for step in -180..=180 {
            let heading = towards + f64::from(step) / 180.0 * t.heading_spread_deg.to_radians();
            for (axis, d) in [libm::cos(heading), libm::sin(heading)].into_iter().enumerate() {
                let room = if d > 0.0 { self.room.size_m[axis] - t.start_m[axis] } else { t.start_m[axis] };
                soonest = soonest.min(room / (d.abs() * speed).max(1e-12));
            }
        }
        let legal = format!(
            "true, or a start, heading and duration that stay inside the room: a walk would leave it after {soonest:.2} s \
             of {duration:.2} s"
        );
        c.legal("target.turns", false, soonest >= duration, &legal);
    }

    fn check_frame(&self, c: &mut Rules) {
        let f = &self.frame;
        c.within("frame.slot_s", f.slot_s, 100e-6, 0.1);
        c.count("frame.period_slots", f.period_slots, 1, 1_000_000);
        c.count("frame.spacing_slots", f.spacing_slots, 0, 1000);
        let s = &self.spectrogram;
        c.count("spectrogram.window", u32::from(s.window), 2, FFT_LEN as u32);
        c.beside("spectrogram.hop", f64::from(s.hop), [1.0, f64::from(s.window)], "at most the window");
        c.within("spectrogram.beta", f64::from(s.beta), 0.0, 40.0);
        // there are as many components as range samples
        let components = u32::from(self.radar.range_samples).clamp(1, 8);
        c.count("spectrogram.first_kept", u32::from(s.first_kept), 0, components);
        let kept = [f64::from(s.first_kept.max(1)), 8.0];
        c.beside("spectrogram.last_kept", f64::from(s.last_kept), kept, "at least the first");
        c.legal("spectrogram.bins_per_row", s.bins_per_row, matches!(s.bins_per_row, 1 | 2 | 4), "1, 2 or 4");
        c.within("spectrogram.range_db", s.range_db, 1.0, 190.0);
        let one_window = u32::from(s.window).saturating_mul(f.spacing_slots.saturating_add(1));
        let legal = format!(
            "at least {one_window}: one STFT window of {} sensing slots, N_m = {} slots apart",
            s.window, f.spacing_slots
        );
        c.legal("frame.period_slots", f.period_slots, f.period_slots >= one_window, &legal);
        let shown = format!("{:?}", f.sensing_slots);
        let ascending = f.sensing_slots.windows(2).all(|pair| pair[0] < pair[1]);
        c.legal(
            "frame.sensing_slots",
            &shown,
            !f.sensing_slots.is_empty() && ascending,
            "a non-empty ascending list",
        );
        let most = (f.period_slots / (f.spacing_slots.saturating_add(1))).min(4000);
        // the image needs a column behind the stem and its pooling
        let least = self.least_sensing_slots();
        for &slots in &f.sensing_slots {
            let legal = format!(
                "{least} to {most}: N_s must fill four windows and N_s (N_m + 1) <= N = {} with N_m = {}",
                f.period_slots, f.spacing_slots
            );
            c.legal("frame.sensing_slots", slots, (least..=most).contains(&slots), &legal);
        }
    }

    fn check_learning(&self, c: &mut Rules) {
        let l = &self.learning;
        c.count("learning.train_per_class", l.train_per_class, 2, 100_000);
        c.count("learning.recording_slots", l.recording_slots, 1, 8000);
        c.count("learning.windows", l.windows, 1, 100);
        c.count("learning.test_per_class", l.test_per_class, 2, 100_000);
        c.count("learning.epochs", l.epochs, 1, 10_000);
        c.count("learning.batch", l.batch, 2, 10_000);
        c.within("learning.learning_rate", l.learning_rate, 1e-7, 1.0);
        c.within("learning.weight_decay", l.weight_decay, 0.0, 1.0);
        c.within("learning.mixup", l.mixup, 0.0, 1.0);
        c.count("learning.mask_rows", l.mask_rows, 0, 32);
        c.within("learning.validation", l.validation, 0.0, 0.5);
        let patient = l.patience == 0 || l.validation > 0.0;
        c.legal("learning.patience", l.patience, patient, "0 unless learning.validation is above 0");
        let legal = (4..=32).contains(&l.channels) && l.channels.is_multiple_of(4);
        c.legal("learning.channels", l.channels, legal, "a multiple of 4 in 4 to 32");
        c.within("learning.qat_above", l.qat_above, 0.0, 10.0);
        c.count("learning.qat_images", l.qat_images, 1, 1_000_000);
        c.count("learning.blocks", u32::from(l.blocks), 1, 8);
        c.count("learning.stem_stride", u32::from(l.stem_stride), 1, 2);
    }

    fn check_trade(&self, c: &mut Rules) {
        c.within("optimizer.accuracy_weight", self.optimizer.accuracy_weight, 0.0, 1.0);
        c.within("optimizer.zone_ratio", self.optimizer.zone_ratio, 1e-6, 1.0);
        let cases = [1.0, self.communication.cases.len() as f64];
        c.beside("optimizer.case", f64::from(self.optimizer.case), cases, "one of communication.cases");
    }
}

impl SpectrogramSettings {
    /// The core's form of these settings.
    pub fn preprocessing(&self) -> Preprocessing {
        // 50 dB are 16.61 octaves of power, 1063 level units of 1/64 octave
        let octaves = self.range_db / (10.0 * std::f64::consts::LOG10_2);
        Preprocessing {
            kept: SvdRange { first: self.first_kept, last: self.last_kept },
            window: self.window,
            beta: self.beta,
            hop: self.hop,
            bins_per_row: self.bins_per_row,
            range: (64.0 * octaves).round() as u16,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn refusal(toml: &str) -> String {
        let scenario: Scenario = toml::from_str(toml).expect("parses");
        scenario.check("room.toml").expect_err("refused").to_string()
    }

    #[test]
    fn the_default_is_legal_and_survives_its_own_toml() {
        let scenario = Scenario::default();
        scenario.check("default").unwrap();
        assert_eq!(toml::from_str::<Scenario>(&scenario.to_toml()).unwrap(), scenario);
    }

    #[test]
    fn fifty_decibels_are_1063_units() {
        let paper = SpectrogramSettings { beta: 10.0, first_kept: 2, range_db: 50.0, ..Default::default() };
        assert_eq!(paper.preprocessing(), Preprocessing::default());
    }

    #[test]
    fn refusals_name_file_field_value_and_range() {
        let text = refusal("[channel]\nrho = 1.5");
        assert_eq!(text, "room.toml: channel.rho is 1.5, must be 0 to 1");
        let text = refusal("[frame]\nsensing_slots = [200, 1001]");
        assert!(text.contains("frame.sensing_slots is 1001") && text.contains("to 1000"), "{text}");
        let text = refusal("[radar]\ncarrier_hz = nan");
        assert!(text.contains("radar.carrier_hz is NaN"), "{text}");
        let text = refusal("[communication]\ncases = [[[9.0, 1.0, 1.0]]]");
        assert!(text.contains("communication.cases[0][0] is [9.0, 1.0, 1.0]"), "{text}");
    }

    #[test]
    fn unknown_keys_are_refused() {
        let error = toml::from_str::<Scenario>("[radar]\ncarier_hz = 1e9").unwrap_err().to_string();
        assert!(error.contains("carier_hz") && error.contains("carrier_hz"), "{error}");
    }
}
