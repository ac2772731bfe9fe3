//! Runs every case of a suite through the core and prints the digest of every stage.
//!
//! The machine is behind one trait: an emulator reads the suite from a file, a board asks for it over a serial line. One slot of
//! samples is in memory at a time. The suite's format is that of `host/src/conformance/suite.rs`, and what is printed is read by
//! `host/src/conformance/transcript.rs`.
#![no_std]

mod both;

use both::Both;
use core::fmt::Arguments;
use rand_core::SeedableRng;
use sdp3_core::Error;
use sdp3_core::digest::{Digest, DigestProbe};
use sdp3_core::dsn::{Classification, Kernels, Model, WinogradKernels};
use sdp3_core::early_exit::EarlyExit;
use sdp3_core::pipeline::{Pipeline, PipelineBuffers, PipelineMemory};
use sdp3_core::probe::Probe;
use sdp3_core::scheduler::{Plan, Sequencer, SlotUse, USERS};
use sdp3_core::selftest;
use sdp3_core::signal::stft::{FixedStft, FloatStft, Stft};

/// What the suite needs of a machine.
pub trait Machine {
    /// Fills the buffer with the suite's bytes from `at` on; false if it ends before.
    fn read(&mut self, at: usize, buffer: &mut [u8]) -> bool;

    /// Fills the buffer with the little-endian values from byte `at` on.
    fn read_values(&mut self, at: usize, buffer: &mut [i16]) -> bool {
        let mut bytes = [0; 256];
        let (mut at, mut whole) = (at, true);
        for values in buffer.chunks_mut(bytes.len() / 2) {
            let bytes = bytes.get_mut(..2 * values.len()).unwrap_or_default();
            whole &= self.read(at, bytes);
            at += bytes.len();
            for (value, pair) in values.iter_mut().zip(bytes.as_chunks().0) {
                *value = i16::from_le_bytes(*pair);
            }
        }
        whole
    }

    /// Prints a line.
    fn print(&mut self, line: Arguments<'_>);

    /// Instructions or cycles so far.
    fn count(&mut self) -> u64;

    /// Most bytes of stack used so far.
    fn stack(&mut self) -> usize;
}

/// Memory for one pipeline after another.
pub trait Memory {
    /// The buffers.
    fn buffers(&mut self) -> PipelineBuffers<'_>;
}

impl<const A: usize, const B: usize, const C: usize, const D: usize, const E: usize> Memory
    for PipelineMemory<A, B, C, D, E>
{
    fn buffers(&mut self) -> PipelineBuffers<'_> {
        self.view()
    }
}

/// Why a suite cannot be run.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum Failure {
    /// What is wrong with the suite or with the machine's memory.
    Suite(&'static str),
    /// What the core says of a model, and what it was asked.
    Core(&'static str, Error),
}

impl Failure {
    /// Logs and prints it.
    pub fn report(&self, machine: &mut impl Machine) {
        let what = match self {
            Failure::Suite(what) => what,
            Failure::Core(what, error) => {
                defmt::error!("{}", error);
                what
            }
        };
        defmt::error!("{=str}", what);
        machine.print(format_args!("error: {what}"));
    }
}

type Done<T> = Result<T, Failure>;

const TRUNCATED: Failure = Failure::Suite("the suite file is truncated");

/// What every case works with.
struct Work<'w, M, B> {
    machine: &'w mut M,
    memory: &'w mut B,
    slot: &'w mut [i16],
    /// Byte of the suite that is read next.
    at: usize,
}

impl<M: Machine, B> Work<'_, M, B> {
    fn read(&mut self, buffer: &mut [u8]) -> Done<()> {
        if !self.machine.read(self.at, buffer) {
            return Err(TRUNCATED);
        }
        self.at += buffer.len();
        Ok(())
    }

    fn words<const N: usize>(&mut self) -> Done<[u32; N]> {
        let mut words = [0; N];
        for word in &mut words {
            let mut bytes = [0; 4];
            self.read(&mut bytes)?;
            *word = u32::from_le_bytes(bytes);
        }
        Ok(words)
    }
}

/// Runs the whole suite: self test, cases, schedule. `slot` holds one slot's values and `model` one model's bytes; every value of
/// every stage goes to `probe` as well.
///
/// # Errors
///
/// [`Failure`]: the suite is damaged, or a case needs more memory than there is.
pub fn run(
    machine: &mut impl Machine,
    memory: &mut impl Memory,
    slot: &mut [i16],
    model: &mut [u8],
    probe: &mut impl Probe,
) -> Result<(), Failure> {
    let mut rng = rand_xoshiro::Xoshiro128PlusPlus::seed_from_u64(3);
    let found = selftest::run(&mut rng);
    machine.print(format_args!("selftest {:016x}", found[1]));
    if found != selftest::KNOWN_ANSWERS {
        defmt::warn!("the self test of the signal chain failed"); // the suite reports the stage
    }
    let mut work = Work { machine, memory, slot, at: 0 };
    let mut magic = [0; 4];
    work.read(&mut magic)?;
    let [version, cases] = work.words()?;
    if magic != *b"SDPS" || version != 3 {
        return Err(Failure::Suite("not a suite file of version 3"));
    }
    defmt::info!("suite opened: {=u32} cases", cases);
    for index in 0..cases {
        case(index, &mut work, model, probe)?;
    }
    schedule(&mut work)?;
    let stack = work.machine.stack();
    work.machine.print(format_args!("stack {stack}"));
    work.machine.print(format_args!("done"));
    Ok(())
}

fn case<M: Machine, B: Memory>(
    index: u32,
    work: &mut Work<'_, M, B>,
    model: &mut [u8],
    probe: &mut impl Probe,
) -> Done<()> {
    let [length, slots, transform, values] = work.words()?.map(|word| word as usize);
    let Some(bytes) = model.get_mut(..length.next_multiple_of(4)) else {
        return Err(Failure::Suite("a model is larger than its buffer"));
    };
    work.read(bytes)?;
    defmt::info!("case {=u32}: {=usize} slots", index, slots);
    let parsed = Model::parse(bytes.get(..length).unwrap_or(bytes))
        .map_err(|error| Failure::Core("the core refuses a model", error.into()))?;
    if parsed.radar().values_per_slot() != values {
        return Err(Failure::Suite("a slot has another length than its model's"));
    }
    let (digests, count) = match transform {
        0 => recording::<FloatStft, _, _>(index, parsed, work, slots, probe)?,
        1 => recording::<FixedStft, _, _>(index, parsed, work, slots, probe)?,
        _ => return Err(Failure::Suite("a transform is neither 0 nor 1")),
    };
    for (stage, digest) in digests.stages() {
        work.machine.print(format_args!("case {index} {stage} {} {:016x}", digest.count(), digest.hash()));
    }
    work.machine.print(format_args!("case {index} instructions {count}"));
    Ok(())
}

/// Recognises a recording twice: every stage's digest, then the count of it all. Tests the network of the first case.
fn recording<T: Stft, M: Machine, B: Memory>(
    index: u32,
    model: Model<'_>,
    work: &mut Work<'_, M, B>,
    slots: usize,
    probe: &mut impl Probe,
) -> Done<(DigestProbe, u64)> {
    let Work { machine, memory, slot, at } = work;
    let Some(slot) = slot.get_mut(..model.radar().values_per_slot()) else {
        return Err(Failure::Suite("a slot is too long"));
    };
    let mut buffers = memory.buffers();
    let Some(kernels) = WinogradKernels::new(&model, core::mem::take(&mut buffers.kernels)) else {
        return Err(Failure::Suite("a network needs more memory than there is"));
    };
    let exit = EarlyExit::single(model);
    let mut pipeline = Pipeline::<_, T>::with_kernels([exit], 2.0, buffers, kernels)
        .map_err(|error| Failure::Core("a model needs more memory than there is", error))?;
    let mut rng = rand_xoshiro::Xoshiro128PlusPlus::seed_from_u64(u64::from(index));
    if index == 0 && !pipeline.self_test(&mut rng) {
        defmt::warn!("the self test of a network failed");
    }
    let mut digests = DigestProbe::new();
    let (seen, _) = recognise(&mut pipeline, *machine, *at, slots, slot, &mut Both(&mut digests, probe))?;
    pipeline.reset();
    let (again, count) = recognise(&mut pipeline, *machine, *at, slots, slot, &mut ())?;
    if again != seen {
        return Err(Failure::Suite("a recording is recognised otherwise the second time"));
    }
    *at += (2 * slots * slot.len()).next_multiple_of(4);
    defmt::info!("recognised {=u8} with {=f32}", seen.class, seen.confidence);
    Ok((digests, count))
}

/// Reads the slots, one at a time, and recognises them: the classification, and the count without the reading.
fn recognise<K: Kernels, T: Stft>(
    pipeline: &mut Pipeline<'_, '_, K, T>,
    machine: &mut impl Machine,
    at: usize,
    slots: usize,
    slot: &mut [i16],
    probe: &mut impl Probe,
) -> Done<(Classification, u64)> {
    let mut count = 0;
    for index in 0..slots {
        if !machine.read_values(at + 2 * index * slot.len(), slot) {
            return Err(TRUNCATED);
        }
        let before = machine.count();
        if pipeline.push(slot, probe).is_err() {
            return Err(Failure::Suite("a recording is longer than its model's"));
        }
        count += machine.count().wrapping_sub(before);
    }
    let before = machine.count();
    let Some(classification) = pipeline.classify(probe) else {
        return Err(Failure::Suite("a recording is shorter than its model's"));
    };
    Ok((classification, count + machine.count().wrapping_sub(before)))
}

fn schedule<M: Machine, B>(work: &mut Work<'_, M, B>) -> Done<()> {
    let [period, spacing, sensing, users] = work.words()?;
    let mut shares = [0; USERS];
    let Some(shares) = shares.get_mut(..users as usize) else {
        return Err(Failure::Suite("too many users"));
    };
    for share in shares.iter_mut() {
        [*share] = work.words()?;
    }
    let mut digest = Digest::new();
    if let Ok(plan) = Plan::new(period, spacing, sensing, shares) {
        let mut sequencer = Sequencer::new(&plan);
        for _ in 0..period {
            match sequencer.next_slot() {
                SlotUse::Communication(k) => digest.value([k]),
                _ => digest.value([u8::MAX]),
            }
        }
    }
    work.machine.print(format_args!("schedule {} {:016x}", digest.count(), digest.hash()));
    Ok(())
}
