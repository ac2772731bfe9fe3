//! Injects faults into the core on all processors of this machine, and measures what those cost that are not found.
//!
//! `tests/faults` runs it and compares the first two digests it prints with those of the firmware. The third table has no equal
//! there: where a bit lies in packed weights, and what it changes in a spectrum, is a processor's own. Exit code 0 if no certain
//! fault was silent and no invariant broke, 1 if one did, 2 for a wrong argument.

use rand_core::SeedableRng;
use rand_xoshiro::Xoshiro128PlusPlus;
use rayon::prelude::*;
use sdp3::network::memory::OwnedMemory;
use sdp3::numerics::random::Random;
use sdp3::scenario::Class;
use sdp3::simulator::calibration::stored_rho;
use sdp3::simulator::dataset::{Set, recording};
use sdp3_core::dsn::{Model, Shape};
use sdp3_core::radar::{Event, Progress, RadarModule, Settings, SlotAction};
use sdp3_core::radar_memory;
use sdp3_core::scheduler::SensingLayout;
use sdp3_core::supervision::Fault;
use sdp3_core::supervision::retained::Retained;
use sdp3_testkit::campaign::environment::Contexts;
use sdp3_testkit::campaign::recording::{self, Recordings, exits, settings, shorten};
use sdp3_testkit::campaign::samples::{self, Corruption};
use sdp3_testkit::campaign::schedule::Schedule;
use sdp3_testkit::campaign::{self, CERTAIN, HEADER, KINDS, Outcome, digest, holds, unprotected};
use sdp3_testkit::models::DSN_200;
use std::fmt::Display;
use std::ops::Add;
use std::process::ExitCode;

type Error = Box<dyn std::error::Error + Send + Sync>;
type Result<T> = std::result::Result<T, Error>;

/// Faults of a part. Each part has a seed of its own, so that the counts do not depend on the number of threads.
const PART: u64 = 500 * KINDS.len() as u64;
/// Recordings of a part: four of each kind.
const RECORDINGS: u64 = 4 * recording::KINDS.len() as u64;
/// Likewise of those with a fault that nothing is meant to find.
const UNPROTECTED: u64 = 4 * unprotected::KINDS.len() as u64;
/// Slots of noise for each strength of a corruption.
const SLOTS: u32 = 10_000;

/// Stream of random numbers that says which slots are corrupted.
const STREAM: u64 = 207;
/// Probability that a slot is corrupted.
const SHARE: f64 = 0.005;

const SHAPE: Shape = Shape::of(DSN_200).expect("a model");
const NEED: u32 = SHAPE.sensing_slots as u32;
const VALUES: usize = SHAPE.slot_values();
type Memory = radar_memory!(SHAPE);

/// Memory for a module is `'static`, as on a microcontroller, and never given back.
fn contexts(settings: Settings, retained: &'static Retained) -> Result<Contexts<VALUES>> {
    let memory: &'static mut Memory = Box::leak(Box::new(Memory::new()));
    Ok(RadarModule::single(DSN_200, settings, memory, retained)?.split())
}

fn retained() -> &'static Retained {
    Box::leak(Box::new(Retained::new()))
}

/// A part of the faults against schedule and samples.
fn faults(seed: u64, events: u64) -> Result<Vec<Outcome>> {
    let (mut rng, settings, retained) =
        (Xoshiro128PlusPlus::seed_from_u64(seed), settings(NEED)?, retained());
    let mut schedule = Schedule::new(contexts(settings, retained)?, &settings, retained, NEED, &mut rng);
    Ok(campaign::run(&mut schedule, &mut rng, events).to_vec())
}

/// A module that makes recordings with two exits, of which the models lie in memory that can be written.
fn recordings(seed: u64) -> Result<Recordings<VALUES, impl FnMut() -> Option<Contexts<VALUES>>>> {
    let (settings, retained) = (settings(NEED)?, retained());
    let [first, last]: [&'static mut [u8]; 2] = [DSN_200.to_vec().leak(), DSN_200.to_vec().leak()];
    shorten(first);
    let files: [&'static [u8]; 2] = [first, last];
    let make = move || {
        let memory: &'static mut Memory = Box::leak(Box::new(Memory::new()));
        Some(RadarModule::new(&exits(files)?, settings, memory, retained).ok()?.split())
    };
    Ok(Recordings::new(NEED, files, retained, make, seed).ok_or("no module")?)
}

/// Injects `events` faults in parts of `part` with the seeds `seed`, `seed + 1`, ..., and prints the sum of the outcomes. Returns it
/// with the outcomes of the first part.
fn table<T: Copy + Default + Display + Add<Output = T> + Send>(
    header: &str,
    kinds: &[&str],
    (seed, events, part): (u64, u64, u64),
    inject: impl Fn(u64, u64) -> Result<Vec<T>> + Sync,
) -> Result<(Vec<T>, Vec<T>)> {
    let one = |number: u64| inject(seed.wrapping_add(number), part.min(events - number * part));
    let parts: Vec<_> = (0..events.div_ceil(part)).into_par_iter().map(one).collect::<Result<_>>()?;
    let mut sum = vec![T::default(); kinds.len()];
    parts.iter().flat_map(|part| part.iter().enumerate()).for_each(|(kind, &o)| sum[kind] = sum[kind] + o);
    println!("{:<32}{header}", "fault");
    kinds.iter().zip(&sum).for_each(|(kind, outcome)| println!("{kind:<32}{outcome}"));
    Ok((sum, parts.into_iter().next().unwrap_or_default()))
}

/// Prints how many of the slots of noise are refused, for every strength of a corruption.
fn strengths(seed: u64) {
    println!("{:<44}{:<10}{:>10}{:>10}", "corruption", "strength", "slots", "found");
    let all = samples::STRENGTHS.par_iter().map(|strength| samples::refused(strength, SLOTS, seed));
    for ((kind, strength, _), refused) in samples::STRENGTHS.iter().zip(all.collect::<Vec<_>>()) {
        println!("{kind:<44}{strength:<10}{SLOTS:>10}{:>10.4}", f64::from(refused) / f64::from(SLOTS));
    }
    println!();
}

/// Over recordings with one kind of corruption, in this order: recordings; slots that the module asked for, those of them that were
/// corrupted, and those it refused; recordings classified correctly without and with supervision, and those that it left without a
/// class.
type Counts = [u32; 7];

/// Prints the accuracy over `per_class` recordings of each class: untouched, and a row for each kind of corruption.
///
/// The module may use all sensing slots of a period for one recording.
fn cost(seed: u64, per_class: u32) -> Result<()> {
    let mut scenario = sdp3_tests::printed_room();
    scenario.frame.sensing_slots = vec![200];
    let rho = stored_rho(&scenario).0;
    let frame = &scenario.frame;
    let most = frame.period_slots / (frame.spacing_slots + 1);
    let layout = SensingLayout::new(frame.period_slots, frame.spacing_slots, most)?;
    let classes = Class::ALL.len() as u32;
    let each = (0..per_class * classes).into_par_iter().map(|n| {
        let class = Class::ALL[(n % classes) as usize];
        let raw = recording(&scenario, rho, seed, Set::Demo, class, 10_000 + n / classes, most).slots;
        let (mut contexts, mut number) =
            (contexts(Settings { layout, rates: [1, 0, 0, 0, 0, 0, 0, 0], threshold: 2.0 }, retained())?, 0);
        let mut counts = [Counts::default(); samples::KINDS.len() + 1];
        for (kind, counts) in counts.iter_mut().enumerate() {
            let mut values = raw.values.clone();
            let corrupted = corrupt(&mut values, kind, u64::from(n), seed);
            *counts =
                classify(&mut contexts, &mut number, layout.period(), class as u8, &values, &corrupted)?;
        }
        Ok::<_, Error>(counts)
    });
    let none = || [Counts::default(); samples::KINDS.len() + 1];
    let add = |a: Counts, b: Counts| std::array::from_fn(|k| a[k] + b[k]);
    let total = each.try_reduce(none, |a, b| Ok(std::array::from_fn(|k| add(a[k], b[k]))))?;
    let share = |part: u32, all: u32| f64::from(part) / f64::from(all.max(1));
    println!("untouched recordings recognised: {:.3}", share(total[0][4], total[0][0]));
    println!(
        "{:<26}{:>11}{:>16}{:>9}{:>14}{:>12}{:>15}",
        "corrupted",
        "recordings",
        "slots corrupted",
        "refused",
        "unsupervised",
        "supervised",
        "without class"
    );
    for (kind, [recordings, asked, corrupted, refused, unsupervised, supervised, without]) in
        samples::KINDS.iter().zip(&total[1..])
    {
        println!(
            "{kind:<26}{recordings:>11}{:>16.4}{:>9.3}{:>14.3}{:>12.3}{:>15.3}",
            share(*corrupted, *asked),
            share(*refused, *corrupted),
            share(*unsupervised, *recordings),
            share(*supervised, *recordings),
            share(*without, *recordings)
        );
    }
    Ok(())
}

/// Corrupts some slots, and says which; kind 0 leaves all as they are.
fn corrupt(values: &mut [i16], kind: usize, recording: u64, seed: u64) -> Vec<bool> {
    let slots = values.chunks_exact_mut(VALUES);
    let Some(kind) = kind.checked_sub(1) else { return vec![false; slots.len()] };
    let mut random = Random::new(seed, STREAM, kind as u64, recording);
    let mut rng = Xoshiro128PlusPlus::seed_from_u64(random.bits());
    slots
        .map(|slot| {
            let corrupted = random.uniform() < SHARE;
            if corrupted {
                Corruption::random(kind, &mut rng).apply(slot);
            }
            corrupted
        })
        .collect()
}

/// One recording, classified by a pipeline that trusts its converter, and by a module in one period.
fn classify(
    (slots, processing): &mut Contexts<VALUES>,
    number: &mut u32,
    period: u32,
    truth: u8,
    values: &[i16],
    corrupted: &[bool],
) -> Result<Counts> {
    let model = Model::parse(DSN_200)?;
    let mut memory = OwnedMemory::for_model(&model);
    let mut pipeline = memory.pipeline::<sdp3_core::signal::stft::NativeStft>(model)?;
    for slot in values.chunks_exact(VALUES).take(model.sensing_slots()) {
        pipeline.push(slot, &mut ())?;
    }
    let unsupervised = pipeline.classify(&mut ()).map(|found| found.class);
    let (mut asked, mut damaged, mut refused, mut supervised) = (0, 0, 0, None);
    let mut signal = values.chunks_exact(VALUES).zip(corrupted);
    for _ in 0..period {
        if let SlotAction::Sense(buffer) = slots.begin(*number)
            && let Some((slot, &corrupted)) = signal.next()
        {
            buffer.0.copy_from_slice(slot);
            slots.samples_ready();
            (asked, damaged) = (asked + 1, damaged + u32::from(corrupted));
        }
        *number = number.wrapping_add(1);
        loop {
            match processing.poll() {
                Progress::Idle => break,
                Progress::Event(Event::Fault(Fault::Samples(_))) => refused += 1,
                Progress::Event(Event::Classification { classification, .. }) => {
                    supervised = Some(classification.class);
                }
                _ => (),
            }
        }
    }
    let correct = |class: Option<u8>| u32::from(class == Some(truth));
    Ok([
        1,
        asked,
        damaged,
        refused,
        correct(unsupervised),
        correct(supervised),
        u32::from(supervised.is_none()),
    ])
}

fn all(seed: u64, events: u64, chains: u64, per_class: u32) -> Result<bool> {
    let (sum, first) = table(HEADER, &KINDS, (seed, events, PART), faults)?;
    println!("digest {:016x} of {}\n", digest(&first), events.min(PART));
    let mut held = holds(&sum, CERTAIN);
    let kinds = recording::KINDS;
    let one = |seed, events| Ok(recordings(seed)?.run(events).to_vec());
    let (sum, first) = table(HEADER, &kinds, (seed, chains, RECORDINGS), one)?;
    println!("recordings {:016x} of {}\n", digest(&first), chains.min(RECORDINGS));
    held &= holds(&sum, kinds.len());
    println!("not found:");
    let one = |seed, events| Ok(recordings(seed)?.run_unprotected(events).to_vec());
    let (sum, first) = table(unprotected::HEADER, &unprotected::KINDS, (seed, chains, UNPROTECTED), one)?;
    println!("unprotected {:016x} of {}\n", unprotected::digest(&first), chains.min(UNPROTECTED));
    held &= unprotected::holds(&sum);
    strengths(seed);
    cost(seed, per_class)?;
    Ok(held)
}

fn main() -> ExitCode {
    let arguments: Option<Vec<u64>> = std::env::args().skip(1).map(|word| word.parse().ok()).collect();
    let done = match arguments.as_deref() {
        Some(&[seed, events, chains, per_class]) => u32::try_from(per_class)
            .map_err(Error::from)
            .and_then(|per_class| all(seed, events, chains, per_class)),
        _ => Err("usage: faults SEED EVENTS RECORDINGS RECORDINGS-OF-A-CLASS".into()),
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
