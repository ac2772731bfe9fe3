//! The downlink to a communication receiver: its sub-carriers' responses and their expected power gains.
//!
//! Eq. (H_sub) averaged over draws of the scenario's channel model between base station and receiver. Antennas are isotropic; the
//! same draws serve every position, so nearer is better. Every draw is a channel of its own: rho, the correlation from slot to slot,
//! plays no part. `communication.people` puts the people of the scenario into every draw, otherwise the room is empty.

use super::target::Target;
use super::{Complex64, Scene, model, phasor};
use crate::numerics::random::Random;
use crate::scenario::{Class, Scenario};
use crate::simulator::body::Vec3;
use crate::simulator::dataset::scene_people;
use std::f64::consts::PI;

/// Stream number of the links' random draws.
const STREAM: u64 = 101;
/// Stream number of the people in them.
const PEOPLE_STREAM: u64 = 102;

/// `|H_m|^2` of the sub-carriers in each of `communication.draws` draws, one draw after the other.
pub fn subcarrier_draws(
    scenario: &Scenario,
    receiver: Vec3,
    seed: u64,
) -> impl Iterator<Item = Vec<f64>> + use<'_> {
    let responses =
        (0..scenario.communication.draws).map(move |draw| response(scenario, receiver, seed, draw));
    responses.map(|h| h.iter().map(|z| z.norm_sqr()).collect())
}

/// `E |H_m|^2` of every sub-carrier, averaged over so many draws, each of which `see` is shown.
pub fn expected(count: u32, draws: impl Iterator<Item = Vec<f64>>, mut see: impl FnMut(&[f64])) -> Vec<f64> {
    let mut gains = Vec::new();
    for draw in draws {
        gains.resize(draw.len(), 0.0);
        gains.iter_mut().zip(&draw).for_each(|(gain, h)| *gain += 1.0 / f64::from(count) * h);
        see(&draw);
    }
    gains
}

/// H_m of one draw, `[subcarrier]`.
pub fn response(scenario: &Scenario, receiver: Vec3, seed: u64, draw: u32) -> Vec<Complex64> {
    let station = scenario.radar.position_m;
    let random = Random::new(seed, STREAM, 0, u64::from(draw));
    let mut channel = model(scenario, station, receiver, 1.0, random);
    let (people, time_s) = match scenario.communication.people {
        true => people(scenario, seed, draw),
        false => (Vec::new(), 0.0),
    };
    let scene = Scene { slot: 0, time_s, from: station, to: receiver, people: &people };
    let mut paths = Vec::new();
    channel.paths(&scene, &mut paths);
    let m = scenario.communication.used_subcarriers();
    let spacing_hz = scenario.communication.spacing_hz();
    let mut tones: Vec<(Complex64, Complex64)> =
        paths.iter().map(|p| (p.gain, phasor(-2.0 * PI * spacing_hz * p.delay_s))).collect();
    (0..m)
        .map(|_| {
            let h = tones.iter().map(|(value, _)| value).sum();
            tones.iter_mut().for_each(|(value, step)| *value *= *step);
            h
        })
        .collect()
}

/// Everybody in the room in a draw, the person sensed with a random one of the classes, and a random time of the longest recording.
/// They are the same for every receiver.
fn people(scenario: &Scenario, seed: u64, draw: u32) -> (Vec<Target>, f64) {
    let mut random = Random::new(seed, PEOPLE_STREAM, 0, u64::from(draw));
    let class = Class::ALL[(random.bits() % Class::ALL.len() as u64) as usize];
    let lasts_s = scenario.interval_s() * f64::from(scenario.largest_sensing_slots());
    let time_s = lasts_s * random.uniform();
    let mut people = scene_people(scenario, class, &mut random);
    // the radar's antenna looks at the person sensed; the link's antennas are isotropic
    people.iter_mut().for_each(|person| person.gain = 1.0);
    (people, time_s)
}

/// Whether the links depend on the size of the room: one draw in this room and in a larger one.
pub fn knows_walls(scenario: &Scenario) -> bool {
    let Some(&user) = scenario.communication.cases.iter().flatten().next() else { return false };
    let mut larger = scenario.clone();
    larger.room.size_m = larger.room.size_m.map(|size| size + 1.0);
    response(scenario, user, 1, 0) != response(&larger, user, 1, 0)
}

#[cfg(test)]
mod tests {
    use super::super::{free_space, wavelength};
    use super::*;
    use crate::scenario::{Clusters, Model};

    /// The paper's room: its links are clusters alone.
    fn printed() -> Scenario {
        crate::scenario::builtin::named("as-printed".as_ref()).unwrap().scenario()
    }

    fn gains(scenario: &Scenario, receiver: Vec3) -> Vec<f64> {
        let draws = subcarrier_draws(scenario, receiver, 1);
        expected(scenario.communication.draws, draws, |_| ())
    }

    #[test]
    fn nearer_receivers_have_better_gains() {
        for clusters in [Clusters::Ieee80211ax, Clusters::Ieee80211ay] {
            let mut scenario = printed();
            scenario.channel.clusters = clusters;
            let mean = |p: Vec3| gains(&scenario, p).iter().sum::<f64>();
            assert!(mean([1.5, 2.8, 1.0]) > mean([1.5, 3.0, 1.0]));
            assert!(mean([2.3, 1.0, 1.0]) > mean([2.5, 1.0, 1.0]));
        }
    }

    #[test]
    fn people_change_every_models_links_a_little() {
        let mut scenario = Scenario::default();
        scenario.communication.draws = 40;
        scenario.target.others =
            vec![crate::scenario::Other { class: Class::Standing, start_m: [0.5, 3.5], heading_deg: None }];
        let user = [1.5, 3.0, 1.0];
        let total = |draws: &[Vec<f64>]| draws.iter().flatten().sum::<f64>();
        let draws = |scenario: &Scenario| subcarrier_draws(scenario, user, 1).collect::<Vec<_>>();
        for model in Model::ALL {
            scenario.channel.model = model;
            scenario.communication.people = false;
            let empty = draws(&scenario);
            scenario.communication.people = true;
            let filled = draws(&scenario);
            assert!(empty.iter().zip(&filled).all(|(a, b)| a != b), "{model:?}");
            let db = 10.0 * libm::log10(total(&filled) / total(&empty));
            assert!(db.abs() < 6.0, "{model:?}: {db} dB");
            assert_eq!(filled, draws(&scenario), "{model:?}");
        }
    }

    #[test]
    fn people_are_elsewhere_in_every_draw_and_the_same_for_every_receiver() {
        let scenario = Scenario::default();
        let found: Vec<_> = (0..60).map(|draw| people(&scenario, 1, draw)).collect();
        let classes = found.iter().map(|(people, _)| people[0].person.truth.class.name());
        assert_eq!(classes.collect::<std::collections::BTreeSet<_>>().len(), Class::ALL.len());
        let lasts_s = scenario.interval_s() * f64::from(scenario.largest_sensing_slots());
        assert!(found.iter().all(|(_, time_s)| (0.0..lasts_s).contains(time_s)));
        let centres: Vec<Vec3> = found.iter().map(|(people, time_s)| people[0].centre(*time_s)).collect();
        assert!(centres.windows(2).all(|pair| pair[0] != pair[1]));
    }

    #[test]
    fn only_models_with_reflections_at_walls_know_them() {
        assert!(knows_walls(&Scenario::default()));
        let mut scenario = printed();
        assert!(!knows_walls(&scenario));
        scenario.channel.clusters = Clusters::Ieee80211ay;
        assert!(knows_walls(&scenario));
        let known = Model::ALL.into_iter().filter(|&model| {
            scenario.channel.model = model;
            knows_walls(&scenario)
        });
        let known: Vec<&str> = known.map(Model::name).collect();
        assert_eq!(known, ["dahc", "primitive", "ray-tracing", "80211ay", "metis"]);
    }

    #[test]
    fn every_model_links_a_receiver_near_free_space() {
        let mut scenario = Scenario::default();
        let free = free_space(2.0, wavelength(3.5e9));
        for model in Model::ALL {
            scenario.channel.model = model;
            let gains = gains(&scenario, [1.5, 3.0, 1.0]);
            let mean = gains.iter().sum::<f64>() / gains.len() as f64;
            let db = 10.0 * libm::log10(mean / (free * free));
            assert!(db.abs() < 6.0, "{model:?}: {db} dB");
            assert!(gains.iter().all(|g| g.is_finite() && *g > 0.0));
        }
    }
}
