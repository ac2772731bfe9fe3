//! The int8 networks of a run on recordings simulated again, as in a room of another rho: nothing is trained.
//!
//! The recordings are the run's test recordings, simulated in the scenario that is given, with the same random draws. In the run's own
//! scenario and at its rho the accuracies are the run's. They may be tested in parts, in any order.

use super::evaluation::{Networks, RefusedModel};
use super::spectrograms::{Part, Recordings};
use crate::error::Invalid;
use crate::results::{CurvePoint, Retested, RetestedAccuracy};
use crate::scenario::Scenario;
use std::ops::Range;

/// Networks, and the recordings to test them on.
pub struct Retest<'a> {
    networks: Networks<'a>,
    recordings: Recordings<'a>,
}

impl<'a> Retest<'a> {
    /// Of model files, one for each N_s of the scenario.
    ///
    /// # Errors
    ///
    /// A model that the core refuses.
    pub fn new(
        scenario: &'a Scenario,
        rho: f64,
        seed: u64,
        models: &'a [Vec<u8>],
    ) -> Result<Self, RefusedModel> {
        let per_class = scenario.learning.test_per_class;
        Ok(Retest {
            networks: Networks::parse(models, &scenario.frame.sensing_slots)?,
            recordings: Recordings { scenario, rho, seed, part: Part::Test, per_class },
        })
    }

    /// How many recordings there are.
    pub fn recordings(&self) -> u32 {
        self.recordings.count()
    }

    /// How many of the recordings of these numbers each network recognises; numbers beyond the last are left out.
    pub fn part(&self, items: Range<u32>, progress: &(dyn Fn(u64, u64) + Sync)) -> Retested {
        let all = self.recordings();
        let items = items.start.min(all)..items.end.min(all);
        let found = self.networks.some_recordings(&self.recordings, items, progress);
        let network = |(index, &sensing_slots): (usize, &u32)| {
            RetestedAccuracy::new(sensing_slots, found.right(index) as u32, found.truth.len() as u32)
        };
        Retested { rho: self.recordings.rho, accuracy: found.slots.iter().enumerate().map(network).collect() }
    }
}

impl RetestedAccuracy {
    /// So many recognised of so many tested.
    pub fn new(sensing_slots: u32, recognised: u32, tested: u32) -> Self {
        let int8 = f64::from(recognised) / f64::from(tested.max(1));
        RetestedAccuracy { sensing_slots, recognised, tested, int8 }
    }
}

impl Retested {
    /// The test of which these are parts, in any order.
    ///
    /// # Errors
    ///
    /// No part; parts of different tests.
    pub fn joined(parts: &[Retested]) -> Result<Self, Invalid> {
        let slots = |part: &Retested| part.accuracy.iter().map(|a| a.sensing_slots).collect::<Vec<_>>();
        let [first, others @ ..] = parts else {
            return Err(Invalid::new("parts of the test", 0, "at least 1"));
        };
        let mut whole = first.clone();
        for part in others {
            Invalid::unless(part.rho == whole.rho, "rho", part.rho, whole.rho)?;
            let (found, must) = (slots(part), slots(&whole));
            Invalid::unless(found == must, "sensing_slots", format!("{found:?}"), format!("{must:?}"))?;
            for (sum, one) in whole.accuracy.iter_mut().zip(&part.accuracy) {
                let (recognised, tested) = (sum.recognised + one.recognised, sum.tested + one.tested);
                *sum = RetestedAccuracy::new(sum.sensing_slots, recognised, tested);
            }
        }
        Ok(whole)
    }

    /// Recordings that every network was tested on.
    pub fn tested(&self) -> u32 {
        self.accuracy.first().map_or(0, |network| network.tested)
    }

    /// The points of the learning curve.
    pub fn points(&self) -> Vec<CurvePoint> {
        let point = |network: &RetestedAccuracy| CurvePoint {
            sensing_slots: f64::from(network.sensing_slots),
            accuracy: network.int8,
            tested: Some(f64::from(network.tested)),
            std: None,
        };
        self.accuracy.iter().map(point).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::network::evaluation::Networks;
    use sdp3_testkit::models::{DSN_200, DSN_1000};

    fn scenario() -> Scenario {
        let mut scenario = Scenario::default();
        (scenario.frame.sensing_slots, scenario.learning.test_per_class) = (vec![200, 1000], 3);
        // as the models have it
        (scenario.spectrogram.first_kept, scenario.spectrogram.range_db) = (2, 50.0);
        scenario
    }

    #[test]
    fn parts_make_the_whole_on_any_number_of_threads() {
        let (scenario, files) = (scenario(), [DSN_200.to_vec(), DSN_1000.to_vec()]);
        let retest = Retest::new(&scenario, 0.98, 4, &files).expect("models");
        let whole = retest.part(0..u32::MAX, &|_, _| ());
        assert_eq!((whole.tested(), retest.recordings()), (15, 15));
        let one = rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("a thread");
        let parts = one.install(|| [8..100, 0..4, 4..8, 15..20].map(|items| retest.part(items, &|_, _| ())));
        assert_eq!(parts.each_ref().map(Retested::tested), [7, 4, 4, 0]);
        assert_eq!(Retested::joined(&parts).expect("parts of one test"), whole);

        let Recordings { rho, seed, part, per_class, .. } = retest.recordings;
        let same = Recordings { scenario: &scenario, rho, seed, part, per_class };
        let networks = Networks::parse(&files, &scenario.frame.sensing_slots).expect("models");
        let answers = networks.recordings(&same, &|_, _| ());
        for (index, network) in whole.accuracy.iter().enumerate() {
            assert_eq!(network.int8, answers.accuracy(index));
        }
        let other = Retest::new(&scenario, 0.9, 4, &files).expect("models");
        assert_ne!(
            other.networks.recordings(&other.recordings, &|_, _| ()),
            answers,
            "rho changes the recordings"
        );
    }
}
