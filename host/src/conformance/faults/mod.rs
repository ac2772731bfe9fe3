//! Faults on purpose: the core's campaign on every processor of this machine, and what spoiled samples cost in accuracy.

pub mod spoiled;

use crate::results::FaultRow;
use rand_core::SeedableRng;
use rand_xoshiro::Xoshiro128PlusPlus;
use rayon::prelude::*;
use sdp3_core::guard::campaign::{CERTAIN, KINDS, Table, digest, run};

/// Faults of a part: each has a seed of its own, so that the counts depend on no number of threads.
pub const PART: u64 = 100_000;

/// Outcomes, and the digest of the first part.
#[derive(Debug, Clone)]
pub struct Found {
    /// By kind.
    pub rows: Vec<FaultRow>,
    /// Of the first [`PART`] faults.
    pub digest_of_part: u64,
    /// Whether no fault of schedule or model was silent and no promise broke.
    pub held: bool,
}

/// Makes `events` faults, in parts whose seeds are `seed`, `seed + 1`, ...; `model` is a model file.
pub fn campaign(seed: u64, events: u64, model: &[u8], progress: &(dyn Fn(u64) + Sync)) -> Found {
    let parts = events.div_ceil(PART);
    let part = |number: u64| {
        let mut rng = Xoshiro128PlusPlus::seed_from_u64(seed.wrapping_add(number));
        let table = run(&mut rng, PART.min(events - number * PART), model, &mut model.to_vec());
        progress(parts);
        table
    };
    let tables: Vec<Table> = (0..parts).into_par_iter().map(part).collect();
    let mut all = Table::default();
    for table in &tables {
        all.iter_mut().zip(table).for_each(|(sum, outcome)| sum.add(outcome));
    }
    let held = all.iter().enumerate().all(|(kind, o)| {
        o.broken == 0
            && (kind >= CERTAIN || (o.silent == 0 && o.detected == o.injected && o.recovered == o.injected))
    });
    let row = |(kind, o): (&&str, &sdp3_core::guard::campaign::Outcome)| FaultRow {
        kind: (*kind).into(),
        injected: o.injected,
        detected: o.detected,
        recovered: o.recovered,
        silent: o.silent,
        broken: o.broken,
    };
    let rows = KINDS.iter().zip(&all).map(row).collect();
    Found { rows, digest_of_part: tables.first().map_or(0, digest), held }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn counts_depend_on_the_seed_alone() {
        let model = crate::formats::model_file::tests::network().to_bytes().unwrap();
        let found = campaign(5, 2 * PART + 1000, &model, &|_| ());
        assert!(found.held, "{:#?}", found.rows);
        assert_eq!(found.rows.iter().map(|row| row.injected).sum::<u64>(), 2 * PART + 1000);
        let one = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
        let again = one.install(|| campaign(5, 2 * PART + 1000, &model, &|_| ()));
        assert_eq!((again.rows, again.digest_of_part), (found.rows, found.digest_of_part));
        assert_ne!(campaign(6, PART, &model, &|_| ()).digest_of_part, found.digest_of_part);
    }
}
