//! `38901`: 3GPP TR 38.901 (release 19) indoor office, every step of clause 7.5, and the sensing additions of clause 7.9.
//!
//! | step | what | where |
//! |---|---|---|
//! | 2 | line of sight by the probability of an open office | [`parameters::in_sight`] |
//! | 3 | path loss | [`Parameters::loss_db`] |
//! | 4 | correlated large-scale parameters | [`clusters::large_scale`] |
//! | 5 | delays, scaled in line of sight | [`clusters::delays`], [`clusters::delay_scaling`] |
//! | 6 | powers; clusters below -25 dB removed | [`clusters::powers`], [`clusters::strong_enough`] |
//! | 7 | azimuths and zeniths at both ends, aligned with the line of sight | [`angles`], [`Procedure::link`] |
//! | 8 | coupling of rays at both ends | [`angles::coupling`] |
//! | 9, 10 | cross-polarisation and phases | [`polarisation::draw`] |
//! | 11 | sub-clusters of the two strongest, coefficients | [`procedure::SUB_CLUSTERS`], [`Communication`] |
//! | 12 | path loss and shadowing applied | [`Communication`] |
//! | 7.6.3 | spatial consistency | [`variables::Fields`] |
//! | 7.6.4.2 | blockage by people, model B | [`super::shadowing`] |
//! | 7.6.9 | absolute time of arrival | [`Link::excess_s`] |
//! | 7.9.4.1 | the channel of a person | [`target::Cascade`] |
//! | 7.9.4.2 | the radar's background | [`background::background`] |
//!
//! QuaDRiGa's clusters are those of [`Office`].

mod angles;
mod background;
mod clusters;
mod link;
mod office;
mod parameters;
mod polarisation;
mod procedure;
mod target;
mod variables;

pub use office::Office;
pub use parameters::Parameters;

use super::field::Field;
use super::ieee80211ay::rotated;
use super::shadowing::{Screen, others, transmission};
use super::target::direct;
use super::{Blocks, ChannelModel, Path, Scene, Sensor, carrier_phase, wavelength};
use crate::numerics::random::Random;
use crate::scenario::Scenario;
use crate::simulator::body::{Vec3, add, dot, norm, scale, sub};
use background::{Setting, background};
use link::Link;
use parameters::in_sight;
use polarisation::{DIRECT, received};
use procedure::Procedure;
use target::Cascade;
use variables::Fields;

/// Rays of a cluster.
const RAYS: usize = 20;
/// How far away a plane wave begins that passes a screen, in m.
const FAR_M: f64 = 1e4;

/// Direction of a ray: offsets from the direct path's azimuth and elevation.
pub fn direction(towards: Vec3, [azimuth, elevation]: [f64; 2]) -> Vec3 {
    rotated(towards, [azimuth, elevation])
}

/// Length of a vector between two points in m.
pub fn between(a: Vec3, b: Vec3) -> f64 {
    norm(sub(a, b))
}

/// The link to a user who may walk.
#[derive(Debug)]
struct Communication {
    fields: Fields,
    procedure: Procedure,
    /// Where the user was first.
    start: Vec3,
    /// The link at a place that has not moved.
    held: Option<(Vec3, Link)>,
}

impl Communication {
    fn new(ends: (Vec3, Vec3), possible: bool, setting: Setting, random: &mut Random) -> Self {
        let los = in_sight(possible, ends.0, ends.1, random);
        let parameters = Parameters::indoor_office(setting.carrier_hz, los);
        let fields = Fields::new(&parameters, random);
        let procedure = Procedure::new(parameters, &fields.at(ends.1), setting.room_m, random);
        Communication { fields, procedure, start: ends.1, held: None }
    }

    /// Steps 11 and 12, with the blockage of people.
    fn paths(&mut self, scene: &Scene, screens: &[Screen], setting: Setting, paths: &mut Vec<Path>) {
        if self.held.as_ref().is_none_or(|(place, _)| *place != scene.to) {
            self.held = Some((scene.to, self.procedure.link(&self.fields.at(scene.to))));
        }
        let lambda = wavelength(setting.carrier_hz);
        let (Some((_, link)), Some(straight)) = (&self.held, direct(scene, lambda)) else { return };
        let loss = self.procedure.parameters.loss_db(scene.distance_m(), setting.carrier_hz);
        let gain = libm::pow(10.0, (link.shadow_db - loss) / 10.0);
        if link.direct > 0.0 {
            let kept = transmission(screens, &[(scene.from, scene.to)], lambda);
            let unit = straight.gain / straight.gain.norm() * received(&DIRECT, setting.polarisation);
            paths.push(Path { gain: unit * ((gain * link.direct).sqrt() * kept), ..straight });
        }
        let moved = sub(scene.to, self.start);
        for ray in &link.rays {
            let arrival = direction(straight.arrival, ray.arrival);
            let kept = transmission(screens, &[(scene.to, add(scene.to, scale(arrival, FAR_M)))], lambda);
            // the phase turns as the user moves along the ray
            let phase =
                carrier_phase(-dot(arrival, moved), lambda) * received(&ray.matrix, setting.polarisation);
            paths.push(Path {
                gain: phase * ((gain * ray.power).sqrt() * kept),
                delay_s: straight.delay_s + link.excess_s + ray.delay_s,
                departure: direction(straight.departure, ray.departure),
                arrival,
            });
        }
    }
}

/// What there is without people.
#[derive(Debug)]
enum Background {
    Communication(Box<Communication>),
    /// The radar's, which never changes, and its range samples once they were asked for.
    Radar(Vec<Path>, Option<Blocks>),
}

#[derive(Debug)]
pub struct IndoorOffice {
    setting: Setting,
    /// Whether links may be in line of sight, and whether people block.
    line_of_sight: bool,
    shadowing: bool,
    background: Background,
    /// Of each person, drawn where it first stands.
    people: Vec<Cascade>,
    random: Random,
}

impl IndoorOffice {
    /// Draws the channel between two ends; the radar's where they are one.
    pub fn new(scenario: &Scenario, ends: (Vec3, Vec3), mut random: Random) -> Self {
        let channel = &scenario.channel;
        let setting = Setting {
            carrier_hz: scenario.radar.carrier_hz,
            room_m: scenario.room.size_m.into_iter().fold(0.0, f64::max),
            polarisation: channel.polarisation,
        };
        let background = match ends.0 == ends.1 {
            true => Background::Radar(background(ends.0, setting, &mut random), None),
            false => Background::Communication(Box::new(Communication::new(
                ends,
                channel.line_of_sight,
                setting,
                &mut random,
            ))),
        };
        IndoorOffice {
            setting,
            line_of_sight: channel.line_of_sight,
            shadowing: channel.shadowing,
            background,
            people: Vec::new(),
            random,
        }
    }

    fn screens(&self, scene: &Scene) -> Vec<Screen> {
        let people = scene.people.iter().filter(|_| self.shadowing);
        people.map(|person| Screen::of(person, scene.time_s)).collect()
    }

    /// The channels by way of people.
    fn people(&mut self, scene: &Scene, screens: &[Screen], paths: &mut Vec<Path>) {
        let lambda = wavelength(self.setting.carrier_hz);
        for (number, person) in scene.people.iter().enumerate() {
            if number == self.people.len() {
                let cascade = Cascade::new(person, scene, self.line_of_sight, self.setting, &mut self.random);
                self.people.push(cascade);
            }
            let kept = others(scene, screens, number, scene.time_s, lambda);
            self.people[number].paths(person, scene, kept, paths);
        }
    }
}

impl ChannelModel for IndoorOffice {
    fn paths(&mut self, scene: &Scene, paths: &mut Vec<Path>) {
        let screens = self.screens(scene);
        match &mut self.background {
            Background::Radar(constant, _) => paths.extend_from_slice(constant),
            Background::Communication(link) => link.paths(scene, &screens, self.setting, paths),
        }
        self.people(scene, &screens, paths);
    }

    fn steady_beats(&mut self, scene: &Scene, interval_s: f64, sensor: &Sensor, beats: &mut [Blocks]) {
        let mut paths = Vec::new();
        for (n, beat) in beats.iter_mut().enumerate() {
            let scene = scene.later(n, interval_s);
            paths.clear();
            match &mut self.background {
                Background::Radar(constant, held) => {
                    let held = held.get_or_insert_with(|| {
                        let mut sum = Blocks::default();
                        sensor.add(&mut sum, constant);
                        sum
                    });
                    beat.iter_mut().zip(held).for_each(|(beat, constant)| *beat += *constant);
                    let screens = self.screens(&scene);
                    self.people(&scene, &screens, &mut paths);
                }
                Background::Communication(_) => self.paths(&scene, &mut paths),
            }
            sensor.add(beat, &paths);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::simulator::body::motion::{GroundTruth, Person};
    use crate::simulator::channel::target::Target;

    #[test]
    fn step_12_links_have_the_tables_path_loss_and_shadowing() {
        let mut scenario = Scenario::default();
        // by hand at 5 m, where every link may be in line of sight
        for (los, exact) in [(true, 55.37), (false, 57.62)] {
            scenario.channel.line_of_sight = los;
            let ends = ([0.0, 0.0, 3.0], [5.0, 0.0, 3.0]);
            let scene = Scene { slot: 0, time_s: 0.0, from: ends.0, to: ends.1, people: &[] };
            let mut losses: Vec<f64> = (0..3000)
                .map(|index| {
                    let mut model =
                        IndoorOffice::new(&scenario, ends, Random::new(12, 1, u64::from(los), index));
                    let mut paths = Vec::new();
                    model.paths(&scene, &mut paths);
                    -10.0 * libm::log10(paths.iter().map(|path| path.gain.norm_sqr()).sum::<f64>())
                })
                .collect();
            losses.sort_by(f64::total_cmp);
            let median = losses[losses.len() / 2];
            println!(
                "number: 38.901 step 12, median loss of a link of 5 m, line of sight {los}: {median:.2} dB (Table 7.4.1-1: {exact} dB)"
            );
            assert!((median - exact).abs() < 0.5, "{median}");
        }
    }

    #[test]
    fn blockage_by_a_person_is_model_bs() {
        // a person in the middle of 6 m at 60 GHz; the law by hand as in the tests of the screen
        let mut scenario = Scenario::default();
        scenario.radar.carrier_hz = 60e9;
        let truth = GroundTruth::standing(1.7, [3.0, 2.0]);
        let mut random = Random::new(1, 0, 0, 0);
        let person = Target::new(Person::new(truth, [10.0, 10.0, 3.0], &mut random), &mut random);
        let [x, y] = Screen::of(&person, 0.0).place;
        let ends = ([x - 3.0, y, 1.0], [x + 3.0, y, 1.0]);
        let people = [person];
        let direct = |people: &[Target]| {
            // the first path is the direct one: at 6 m 98.6 % of the links are in line of sight
            let mut model = IndoorOffice::new(&scenario, ends, Random::new(64, 1, 0, 0));
            let mut paths = Vec::new();
            model.paths(&Scene { slot: 0, time_s: 0.0, from: ends.0, to: ends.1, people }, &mut paths);
            paths
        };
        let (free, blocked) = (direct(&[]), direct(&people));
        let db = |path: usize| 10.0 * libm::log10(blocked[path].gain.norm_sqr() / free[path].gain.norm_sqr());
        let exact = 20.0 * libm::log10(1.0 - (0.4847_f64 + 0.4782) * (2.0 * 0.4096));
        println!(
            "number: 38.901 clause 7.6.4.2, a person in the middle of 6 m at 60 GHz {:.2} dB (eq. 7.6-29 by hand: {exact:.2} dB)",
            db(0)
        );
        assert!((db(0) - exact).abs() < 0.1, "{}", db(0));
        assert!((1..free.len()).all(|path| db(path) < 1.0) && (1..free.len()).any(|path| db(path) < -0.5));
    }

    #[test]
    fn range_samples_are_those_of_the_paths() {
        let scenario = Scenario::default();
        let radar = scenario.radar.position_m;
        let sensor = Sensor::of(&scenario);
        let model = || IndoorOffice::new(&scenario, (radar, radar), Random::new(3, 1, 0, 0));
        let scene = Scene { slot: 0, time_s: 0.0, from: radar, to: radar, people: &[] };
        let mut found = [Blocks::default(); 2];
        model().beats(&scene, 1e-3, &sensor, &mut found);
        let (mut exact, mut paths) = (Blocks::default(), Vec::new());
        model().paths(&scene, &mut paths);
        sensor.add(&mut exact, &paths);
        assert_eq!(found, [exact; 2]);
    }
}
