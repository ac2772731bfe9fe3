//! Faults on purpose: the core's campaigns on every processor of this machine, and what spoiled samples cost in accuracy.

pub mod spoiled;

use crate::pipeline::Failure;
use crate::predictor::receiver::OwnedBuffers;
use crate::results::{FaultRow, FaultTable};
use rand_core::SeedableRng;
use rand_xoshiro::Xoshiro128PlusPlus;
use rayon::prelude::*;
use sdp3_core::dsn::Portable;
use sdp3_core::early_exit::{Anytime, Exit};
use sdp3_core::supervision::campaign::{CERTAIN, KINDS, Outcome, digest, recording, run};
use sdp3_core::supervision::{Guarded, Intact};

/// Faults of a part: each has a seed of its own, so that the counts depend on no number of threads.
pub const PART: u64 = 100_000;

/// Disturbed recordings of a part: eight of each kind.
pub const RECORDINGS: u64 = 8 * recording::KINDS.len() as u64;

/// `events` faults against each guard by itself, in parts whose seeds are `seed`, `seed + 1`, ...; `model` is a model file. With the
/// table, whether no fault of schedule or model was silent and no promise broke.
pub fn guards(seed: u64, events: u64, model: &[u8], progress: &(dyn Fn(u64) + Sync)) -> (FaultTable, bool) {
    let parts = in_parts(events, PART, progress, |number, events| {
        let mut rng = Xoshiro128PlusPlus::seed_from_u64(seed.wrapping_add(number));
        run(&mut rng, events, model, &mut model.to_vec()).to_vec()
    });
    table(&KINDS, CERTAIN, (events, PART), &parts)
}

/// `events` disturbed recordings of the model's N_s through the whole chain, in parts like those of [`guards`].
///
/// # Errors
///
/// A model that the core refuses.
pub fn recordings(
    seed: u64,
    events: u64,
    model: &[u8],
    progress: &(dyn Fn(u64) + Sync),
) -> Result<(FaultTable, bool), Failure> {
    let parts = in_parts(events, RECORDINGS, progress, |number, events| {
        let (intact, model) = Intact::accept(model).map_err(|e| e.to_string())?;
        let watch = recording::watch(model.sensing_slots() as u32).map_err(|e| e.to_string())?;
        let mut buffers = OwnedBuffers::for_model(&model);
        let receiver: Anytime<_> = Anytime::new([Exit::alone(model, Portable)], 2.0, buffers.view())?;
        let mut station = Guarded::new(watch, receiver, [intact].into_iter().collect());
        let seed = seed.wrapping_add(number);
        Ok(recording::run::<Xoshiro128PlusPlus, _, _>(&mut station, seed, events).to_vec())
    });
    let parts = parts.into_iter().collect::<Result<Vec<_>, Failure>>()?;
    Ok(table(&recording::KINDS, recording::KINDS.len(), (events, RECORDINGS), &parts))
}

/// Part by part, with its number and size, on all processors.
fn in_parts<O: Send>(
    events: u64,
    part: u64,
    progress: &(dyn Fn(u64) + Sync),
    each: impl Fn(u64, u64) -> O + Sync,
) -> Vec<O> {
    let parts = events.div_ceil(part);
    let one = |number: u64| {
        let found = each(number, part.min(events - number * part));
        progress(parts);
        found
    };
    (0..parts).into_par_iter().map(one).collect()
}

/// The sum of all parts; the first `certain` kinds must never be silent.
fn table(
    kinds: &[&str],
    certain: usize,
    (events, part): (u64, u64),
    parts: &[Vec<Outcome>],
) -> (FaultTable, bool) {
    let mut all = vec![Outcome::default(); kinds.len()];
    for table in parts {
        all.iter_mut().zip(table).for_each(|(sum, outcome)| sum.add(outcome));
    }
    let held = all.iter().enumerate().all(|(kind, o)| {
        o.broken == 0
            && (kind >= certain || (o.silent == 0 && o.detected == o.injected && o.recovered == o.injected))
    });
    let row = |(kind, o): (&&str, &Outcome)| FaultRow {
        kind: (*kind).into(),
        injected: o.injected,
        detected: o.detected,
        recovered: o.recovered,
        silent: o.silent,
        broken: o.broken,
    };
    let found = FaultTable {
        events,
        events_of_part: events.min(part),
        digest_of_part: format!("{:016x}", parts.first().map_or(0, |first| digest(first))),
        rows: kinds.iter().zip(&all).map(row).collect(),
    };
    (found, held)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn counts_depend_on_the_seed_alone() {
        let model = crate::formats::model_file::tests::network().to_bytes().unwrap();
        let (found, held) = guards(5, 2 * PART + 1000, &model, &|_| ());
        assert!(held, "{:#?}", found.rows);
        assert_eq!(found.rows.iter().map(|row| row.injected).sum::<u64>(), 2 * PART + 1000);
        let one = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
        let (again, _) = one.install(|| guards(5, 2 * PART + 1000, &model, &|_| ()));
        assert_eq!(again, found);
        assert_ne!(guards(6, PART, &model, &|_| ()).0.digest_of_part, found.digest_of_part);
    }

    #[test]
    fn disturbed_recordings_of_any_model_are_told_and_the_next_is_whole() {
        let model = crate::formats::model_file::tests::network().to_bytes().unwrap();
        let (found, held) = recordings(5, RECORDINGS + 12, &model, &|_| ()).unwrap();
        assert!(held && found.rows.iter().all(|row| row.detected == 9), "{:#?}", found.rows);
        let one = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
        assert_eq!(one.install(|| recordings(5, RECORDINGS + 12, &model, &|_| ())).unwrap().0, found);
        assert!(recordings(5, 1, &model[1..], &|_| ()).is_err());
    }
}
