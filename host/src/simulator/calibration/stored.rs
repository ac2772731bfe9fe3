//! The look-up table of rho by carrier, scenario and motion.
//!
//! Section III-C of the paper: "we can store the values of rho for typical scenarios in a look-up table". `sdp3 calibrate --table`
//! writes it again: the paper's experiments and the measured recordings as they were found, and what the hybrid channel of one
//! person needs to stand for a room with a second one.

use super::SURROGATES;
use super::sensor::SensorSimulation;
use crate::scenario::{Class, Scenario};
use crate::simulator::dataset::Set;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// First lines of the table's file.
pub const HEADER: &str = "\
# AR(1) coefficient rho of the room channel, by carrier, slot interval, scenario and motion.
# `sdp3 calibrate --table FILE` writes it again: rows that rest on experiments stay, computed ones are computed.

";

/// A row of the table.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Stored {
    /// Carrier in Hz.
    pub carrier_hz: f64,
    /// Interval of the sensing slots in s; rho is one of slots.
    pub interval_s: f64,
    /// Whether a second person moves.
    pub interferer: bool,
    /// The motion: a class, or `any`.
    pub motion: String,
    /// AR(1) coefficient rho of the room channel.
    pub rho: f64,
    /// Divergence at this rho and at rho = 1, where a curve was computed.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub kl: Option<[f64; 2]>,
    /// Where it comes from.
    pub source: String,
}

/// The table.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Table {
    /// Its rows.
    pub entry: Vec<Stored>,
}

/// The table that is part of the program.
pub fn table() -> Table {
    toml::from_str(include_str!("rho_table.toml")).expect("the table is part of the program")
}

/// The stored rho of the nearest carrier (5 % count as equal) with one person, whoever else is simulated: rows that rest on experiments
/// before computed ones, then the nearest slot interval, then rows for any motion. And where it comes from.
pub fn stored_rho(scenario: &Scenario) -> (f64, String) {
    nearest(scenario).map_or((0.997, String::new()), |s| {
        let (ghz, ms) = (s.carrier_hz / 1e9, s.interval_s * 1e3);
        (s.rho, format!("stored table, {} motion at {ghz:.3} GHz, {ms} ms: {}", s.motion, s.source))
    })
}

/// The scenario's rho, or else the stored one.
pub fn rho_of(scenario: &Scenario) -> f64 {
    scenario.channel.rho.unwrap_or_else(|| stored_rho(scenario).0)
}

/// What is wrong with the stored rho for this scenario, in words: a row of another carrier or slot interval (5 % count as equal).
pub fn stored_elsewhere(scenario: &Scenario) -> Option<String> {
    let row = nearest(scenario)?;
    let (carrier_hz, interval_s) = (scenario.radar.carrier_hz, scenario.interval_s());
    let differs = |a: f64, b: f64| libm::log(a / b).abs() > 0.05;
    if !differs(row.carrier_hz, carrier_hz) && !differs(row.interval_s, interval_s) {
        return None;
    }
    let words =
        |hz: f64, s: f64| format!("{:.3} GHz and {} ms between sensing slots", hz / 1e9, number(s * 1e3));
    Some(format!(
        "rho = {} is the stored one of {}, but the scenario has {}, where rho may be another: `sdp3 calibrate --measured FILE` finds \
         it on a recording, channel.rho states it",
        row.rho,
        words(row.carrier_hz, row.interval_s),
        words(carrier_hz, interval_s)
    ))
}

/// A number without the last digits of a product.
fn number(x: f64) -> f64 {
    (x * 1e6).round() / 1e6
}

/// The row that answers for a scenario.
fn nearest(scenario: &Scenario) -> Option<Stored> {
    let table = table();
    let apart = |a: f64, b: f64| libm::log(a / b).abs();
    let rank = |s: &&Stored| {
        let carrier = (apart(s.carrier_hz, scenario.radar.carrier_hz) / 0.05).round();
        let interval = apart(s.interval_s, scenario.interval_s());
        (carrier, s.source.starts_with(COMPUTED), interval, s.motion != "any")
    };
    // a second person is simulated: a rho that was fitted to absorb one would count it twice
    let matching = table.entry.iter().filter(|s| !s.interferer);
    let nearest = matching.min_by(|a, b| rank(a).partial_cmp(&rank(b)).unwrap_or(std::cmp::Ordering::Equal));
    nearest.or(table.entry.first()).cloned()
}

/// How a computed row's source begins.
const COMPUTED: &str = "computed: ";
/// Motions of the computed rows.
const MOTIONS: [Class; 3] = [Class::AdultWalking, Class::AdultPacing, Class::AdultStepping];

/// The table, recomputed: rows from experiments are kept, computed ones are computed again.
///
/// A computed row says which rho makes the one-person channel of scenario 1 look most like recordings of `motion` in a room
/// with rho = 0.997, without (scenario 1) and with (scenario 2) a second person walking in it.
pub fn regenerate(seed: u64, progress: super::Progress) -> Table {
    let mut entry: Vec<Stored> =
        table().entry.into_iter().filter(|s| !s.source.starts_with(COMPUTED)).collect();
    let carriers = [3.5e9, 24.125e9, 60e9];
    let total = (carriers.len() * MOTIONS.len() * 2) as u64;
    let mut done = 0;
    for carrier_hz in carriers {
        for class in MOTIONS {
            for interferer in [false, true] {
                let mut room = Scenario::default();
                room.radar.carrier_hz = carrier_hz;
                if carrier_hz > 30e9 {
                    // at 60 GHz every slot senses
                    room.frame.spacing_slots = 0;
                }
                let single = room.clone();
                room.channel.interferer = interferer;
                let surrogate = SensorSimulation::new(&room, seed, class, false, 1000);
                let sensor = SensorSimulation::new(&single, seed, class, false, 1000);
                let measured = surrogate.counts(PAPER_RHO, Set::Surrogate, SURROGATES);
                let (curve, _, best) = sensor.search(&measured, &|_, _| ());
                let last = curve.len() - 1;
                let round = |x: f64| (x * 1e4).round() / 1e4;
                entry.push(Stored {
                    carrier_hz,
                    interval_s: room.interval_s(),
                    interferer,
                    motion: class.name().into(),
                    rho: curve[best].rho,
                    kl: Some([round(curve[best].kl), round(curve[last].kl)]),
                    source: format!(
                        "{COMPUTED}{SURROGATES} simulated recordings with rho = {PAPER_RHO}{}, fitted by the one-person \
                         channel; `sdp3 calibrate --table rho_table.toml --seed {seed}`",
                        if interferer { " and a second person walking" } else { "" }
                    ),
                });
                done += 1;
                progress(done, total);
            }
        }
    }
    Table { entry }
}

/// The paper's rho of a room with one person.
const PAPER_RHO: f64 = 0.997;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_table_knows_the_papers_rooms() {
        let mut scenario = Scenario::default();
        assert_eq!(stored_rho(&scenario).0, 0.997);
        scenario.frame.spacing_slots = 0;
        scenario.radar.carrier_hz = 60.2e9;
        assert_eq!(stored_rho(&scenario).0, 0.997);
        scenario.radar.carrier_hz = 60e9;
        scenario.channel.interferer = true;
        assert_eq!(stored_rho(&scenario).0, 0.997);
    }

    #[test]
    fn the_nearest_carrier_answers_and_says_so() {
        let mut scenario = Scenario::default();
        scenario.radar.carrier_hz = 24.0e9;
        let (rho, source) = stored_rho(&scenario);
        assert!(source.contains("24.125 GHz") && source.contains("sdp3 calibrate"), "{source}");
        assert!((0.98..0.997).contains(&rho));
        scenario.radar.carrier_hz = 77e9;
        assert!(stored_rho(&scenario).1.contains("60.000 GHz"));
    }

    #[test]
    fn a_row_of_another_carrier_or_interval_is_stated() {
        let mut scenario = Scenario::default();
        assert_eq!(stored_elsewhere(&scenario), None);
        scenario.radar.carrier_hz = 5.8e9;
        scenario.frame.slot_s = 1e-3;
        let words = stored_elsewhere(&scenario).unwrap();
        for word in ["rho = 0.99", "3.500 GHz and 1 ms", "5.800 GHz and 4 ms", "channel.rho"] {
            assert!(words.contains(word), "{word} is not in: {words}");
        }
        scenario = Scenario::default();
        scenario.frame.spacing_slots = 0;
        assert!(stored_elsewhere(&scenario).unwrap().contains("0.25 ms"));
    }
}
