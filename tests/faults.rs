//! Injects faults into the core on all processors of this machine, and measures what corrupted samples cost in accuracy.
//!
//! `tests/faults` runs it and compares the two digests it prints with those of the firmware. Exit code 0 if no certain fault was
//! silent and no invariant broke, 1 if one did, 2 for a wrong argument.

use rand_core::SeedableRng;
use rand_xoshiro::Xoshiro128PlusPlus;
use rayon::prelude::*;
use sdp3::predictor::receiver::OwnedBuffers;
use sdp3::scenario::{Class, Scenario};
use sdp3::simulator::calibration::stored_rho;
use sdp3::simulator::dataset::{Set, recording};
use sdp3::simulator::random::Random;
use sdp3_core::dims::Slot;
use sdp3_core::dsn::{Model, Portable};
use sdp3_core::early_exit::{Anytime, Exit};
use sdp3_core::scheduler::{Sensing, SlotUse};
use sdp3_core::supervision::station::Trouble;
use sdp3_core::supervision::{Guarded, Intact, Watch};
use sdp3_testkit::campaign::samples::Corruption;
use sdp3_testkit::campaign::{self, CERTAIN, HEADER, KINDS, Outcome, SAMPLES, digest, holds};
use sdp3_testkit::models::DSN_200;
use std::process::ExitCode;

type Error = Box<dyn std::error::Error + Send + Sync>;
type Result<T> = std::result::Result<T, Error>;

/// Faults of a part. Each part has a seed of its own, so that the counts do not depend on the number of threads.
const PART: u64 = 100_000;
/// Faults for one recording with a fault.
const FAULTS_PER_RECORDING: u64 = 1000;
/// Recordings of a part: eight of each kind.
const RECORDINGS: u64 = 8 * campaign::recording::KINDS.len() as u64;

/// Stream of random numbers that says which slots are corrupted.
const STREAM: u64 = 207;
/// Probability that a slot is corrupted.
const SHARE: f64 = 0.005;
/// Kinds of corruption, in the order of [`Corruption`].
const CORRUPTIONS: [&str; 5] = ["silent", "bit stuck", "saturated", "offset", "glitch"];

/// A part of the faults against schedule, model and samples.
fn faults(seed: u64, events: u64) -> Result<Vec<Outcome>> {
    let mut rng = Xoshiro128PlusPlus::seed_from_u64(seed);
    Ok(campaign::run(&mut rng, events, DSN_200, &mut DSN_200.to_vec()).to_vec())
}

/// A part of the faults during recordings.
fn recordings(seed: u64, events: u64) -> Result<Vec<Outcome>> {
    let (intact, model) = Intact::accept(DSN_200)?;
    let watch = campaign::recording::watch(model.sensing_slots() as u32)?;
    let mut buffers = OwnedBuffers::for_model(&model);
    let receiver: Anytime<_> = Anytime::new([Exit::alone(model, Portable)], 2.0, buffers.view())?;
    let mut station = Guarded::new(watch, receiver, [intact].into_iter().collect());
    Ok(campaign::recording::run::<Xoshiro128PlusPlus, _, _>(&mut station, seed, events).to_vec())
}

/// Injects `events` faults in parts of `part` with the seeds `seed`, `seed + 1`, ..., and prints the sum of the outcomes and the
/// digest of the first part. Returns whether it holds with the first `certain` kinds never silent.
fn table(
    name: &str,
    kinds: &[&str],
    certain: usize,
    (seed, events, part): (u64, u64, u64),
    inject: impl Fn(u64, u64) -> Result<Vec<Outcome>> + Sync,
) -> Result<bool> {
    let one = |number: u64| inject(seed.wrapping_add(number), part.min(events - number * part));
    let parts: Vec<_> = (0..events.div_ceil(part)).into_par_iter().map(one).collect::<Result<_>>()?;
    let mut sum = vec![Outcome::default(); kinds.len()];
    parts.iter().for_each(|part| sum.iter_mut().zip(part).for_each(|(sum, outcome)| sum.add(outcome)));
    println!("{:<32}{HEADER}", "fault");
    kinds.iter().zip(&sum).for_each(|(kind, outcome)| println!("{kind:<32}{outcome}"));
    println!("{name} {:016x} of {}\n", parts.first().map_or(0, |first| digest(first)), events.min(part));
    Ok(holds(&sum, certain))
}

/// Counts over recordings with one kind of corruption, or none.
#[derive(Debug, Clone, Copy, Default)]
struct Counts {
    recordings: u32,
    /// Slots that the supervised station asked for, those of them that were corrupted, and those it refused.
    asked: u32,
    corrupted: u32,
    refused: u32,
    /// Recordings classified correctly without and with supervision, and those that it left without a class.
    trusting: u32,
    supervised: u32,
    without: u32,
}

impl std::ops::Add for Counts {
    type Output = Counts;

    fn add(self, other: Counts) -> Counts {
        Counts {
            recordings: self.recordings + other.recordings,
            asked: self.asked + other.asked,
            corrupted: self.corrupted + other.corrupted,
            refused: self.refused + other.refused,
            trusting: self.trusting + other.trusting,
            supervised: self.supervised + other.supervised,
            without: self.without + other.without,
        }
    }
}

/// Prints the accuracy over `per_class` recordings of each class: untouched, and a row for each kind of corruption.
///
/// The supervised station may use all sensing slots of a period for one recording.
fn cost(seed: u64, per_class: u32) -> Result<()> {
    let mut scenario = Scenario::default();
    scenario.frame.sensing_slots = vec![200];
    let rho = stored_rho(&scenario).0;
    let frame = &scenario.frame;
    let most = frame.period_slots / (frame.spacing_slots + 1);
    let sensing = Sensing::new(frame.period_slots, frame.spacing_slots, most)?;
    let classes = Class::ALL.len() as u32;
    let each = (0..per_class * classes).into_par_iter().map(|n| {
        let class = Class::ALL[(n % classes) as usize];
        let whole = recording(&scenario, rho, seed, Set::Demo, class, 10_000 + n / classes, most).slots;
        let mut counts = [Counts::default(); CORRUPTIONS.len() + 1];
        for (kind, counts) in counts.iter_mut().enumerate() {
            let (slots, corrupted) = corrupt(&whole, kind, u64::from(n), seed);
            *counts = classify(sensing, class as u8, &slots, &corrupted)?;
        }
        Ok::<_, Error>(counts)
    });
    let none = || [Counts::default(); CORRUPTIONS.len() + 1];
    let total = each.try_reduce(none, |a, b| Ok(std::array::from_fn(|k| a[k] + b[k])))?;
    let share = |part: u32, all: u32| f64::from(part) / f64::from(all.max(1));
    println!("untouched recordings recognised: {:.3}", share(total[0].trusting, total[0].recordings));
    println!(
        "{:<12}{:>12}{:>17}{:>10}{:>14}{:>12}{:>15}",
        "corrupted",
        "recordings",
        "slots corrupted",
        "refused",
        "unsupervised",
        "supervised",
        "without class"
    );
    for (kind, c) in CORRUPTIONS.iter().zip(&total[1..]) {
        println!(
            "{kind:<12}{:>12}{:>17.4}{:>10.3}{:>14.3}{:>12.3}{:>15.3}",
            c.recordings,
            share(c.corrupted, c.asked),
            share(c.refused, c.corrupted),
            share(c.trusting, c.recordings),
            share(c.supervised, c.recordings),
            share(c.without, c.recordings)
        );
    }
    Ok(())
}

/// A copy with some slots corrupted, and which; kind 0 leaves all as they are.
fn corrupt(whole: &[Slot], kind: usize, recording: u64, seed: u64) -> (Vec<Slot>, Vec<bool>) {
    let mut slots = whole.to_vec();
    let mut corrupted = vec![false; slots.len()];
    let Some(kind) = kind.checked_sub(1) else { return (slots, corrupted) };
    let mut random = Random::new(seed, STREAM, kind as u64, recording);
    let mut rng = Xoshiro128PlusPlus::seed_from_u64(random.bits());
    for (slot, corrupted) in slots.iter_mut().zip(&mut corrupted) {
        if random.uniform() < SHARE {
            let mut samples = [0; SAMPLES];
            samples.as_chunks_mut().0.iter_mut().zip(&*slot).for_each(|(pair, x)| *pair = [x.i, x.q]);
            Corruption::random(kind, &mut rng).apply(&mut samples);
            *slot = campaign::slot(&samples);
            *corrupted = true;
        }
    }
    (slots, corrupted)
}

fn exit<'m>(model: &Model<'m>) -> Exit<'m, Portable> {
    Exit::alone(model.clone(), Portable)
}

/// One recording, classified by a station that trusts its converter and by a supervised one.
fn classify(sensing: Sensing, truth: u8, slots: &[Slot], corrupted: &[bool]) -> Result<Counts> {
    let (intact, model) = Intact::accept(DSN_200)?;
    let mut counts = Counts { recordings: 1, ..Default::default() };
    let mut buffers = OwnedBuffers::for_model(&model);
    let mut trusting: Anytime<_> = Anytime::new([exit(&model)], 2.0, buffers.view())?;
    let verdict = slots.iter().find_map(|slot| trusting.push(slot, &mut ()));
    counts.trusting = u32::from(verdict.is_some_and(|v| v.class == truth));
    let receiver: Anytime<_> = Anytime::new([exit(&model)], 2.0, buffers.view())?;
    let files = [intact].into_iter().collect();
    let mut station = Guarded::new(Watch::new(sensing, [1, 0, 0, 0, 0, 0, 0, 0], 0), receiver, files);
    let (mut signal, mut last) = (slots.iter().zip(corrupted), None);
    for number in 0..sensing.period() {
        if station.begin(number).slot != SlotUse::Sensing {
            continue;
        }
        let Some((slot, &corrupted)) = signal.next() else { break };
        let found = station.sensed(number, slot);
        if found == Err(Trouble::Unasked) {
            continue; // the recording has been classified
        }
        counts.asked += 1;
        counts.corrupted += u32::from(corrupted);
        counts.refused += u32::from(found.is_err());
        last = found.unwrap_or(None).or(last);
    }
    counts.without = u32::from(last.is_none());
    counts.supervised = u32::from(last.is_some_and(|v| v.class == truth));
    Ok(counts)
}

fn all(seed: u64, events: u64, per_class: u32) -> Result<bool> {
    let guarded = table("digest", &KINDS, CERTAIN, (seed, events, PART), faults)?;
    let kinds = campaign::recording::KINDS;
    let events = events.div_ceil(FAULTS_PER_RECORDING);
    let recorded = table("recordings", &kinds, kinds.len(), (seed, events, RECORDINGS), recordings)?;
    cost(seed, per_class)?;
    Ok(guarded && recorded)
}

fn main() -> ExitCode {
    let arguments: Option<Vec<u64>> = std::env::args().skip(1).map(|word| word.parse().ok()).collect();
    let done = match arguments.as_deref() {
        Some(&[seed, events, per_class]) => {
            u32::try_from(per_class).map_err(Error::from).and_then(|per_class| all(seed, events, per_class))
        }
        _ => Err("usage: faults SEED EVENTS RECORDINGS-OF-A-CLASS".into()),
    };
    match done {
        Ok(held) => {
            println!(
                "{}",
                if held { "no certain fault was silent, every invariant held" } else { "NOT HELD" }
            );
            ExitCode::from(u8::from(!held))
        }
        Err(error) => {
            eprintln!("faults: {error}");
            ExitCode::from(2)
        }
    }
}
