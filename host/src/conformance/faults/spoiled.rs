//! What spoiled samples cost: the same recordings untouched, spoiled before a station that trusts its converter, and spoiled before
//! the guarded one.
//!
//! Every slot is spoiled with the same probability, by a fault of random strength ([`Spoil::random`]). The guarded station has all
//! sensing slots of a period for a recording of N_s.

use crate::pipeline::Failure;
use crate::predictor::receiver::OwnedBuffers;
use crate::results::SpoiledRow;
use crate::scenario::{Class, Scenario};
use crate::simulator::dataset::{Set, recording};
use crate::simulator::random::Random;
use rand_core::SeedableRng;
use rand_xoshiro::Xoshiro128PlusPlus;
use rayon::prelude::*;
use sdp3_core::dims::Slot;
use sdp3_core::dsn::{Model, Portable};
use sdp3_core::early_exit::{Anytime, Exit};
use sdp3_core::scheduler::{Sensing, SlotUse};
use sdp3_core::supervision::campaign::samples::Spoil;
use sdp3_core::supervision::station::Trouble;
use sdp3_core::supervision::{Guarded, Intact, Watch};

/// Stream number of which slots are spoiled.
const STREAM: u64 = 207;
/// Probability that a slot is spoiled.
pub const SHARE: f64 = 0.005;
/// What is done, in the order of [`Spoil::random`].
const KINDS: [&str; 5] = ["silent", "bit stuck", "saturated", "offset", "glitch"];

/// Untouched, or one of [`KINDS`]: recordings; slots the guarded station asked for, those of them that were spoiled and refused;
/// recordings right and without a verdict.
#[derive(Debug, Clone, Copy, Default)]
struct Counts {
    recordings: u32,
    asked: u64,
    spoiled: u64,
    refused: u64,
    unguarded: u32,
    guarded: u32,
    without: u32,
}

impl Counts {
    fn and(self, other: Counts) -> Counts {
        Counts {
            recordings: self.recordings + other.recordings,
            asked: self.asked + other.asked,
            spoiled: self.spoiled + other.spoiled,
            refused: self.refused + other.refused,
            unguarded: self.unguarded + other.unguarded,
            guarded: self.guarded + other.guarded,
            without: self.without + other.without,
        }
    }
}

/// The accuracy untouched, and a row a kind, over `per_class` recordings of each class.
///
/// # Errors
///
/// A model the core refuses.
pub fn cost(
    scenario: &Scenario,
    rho: f64,
    seed: u64,
    model: &[u8],
    per_class: u32,
    progress: &(dyn Fn(u64) + Sync),
) -> Result<(f64, Vec<SpoiledRow>), Failure> {
    let frame = &scenario.frame;
    let most = frame.period_slots / (frame.spacing_slots + 1);
    let sensing = Sensing::new(frame.period_slots, frame.spacing_slots, most).map_err(|e| e.to_string())?;
    Intact::accept(model).map_err(|e| e.to_string())?;
    let all = per_class * Class::ALL.len() as u32;
    let each = (0..all).into_par_iter().map(|n| {
        let class = Class::ALL[n as usize % Class::ALL.len()];
        let whole = recording(scenario, rho, seed, Set::Demo, class, 10_000 + n / 5, most).slots;
        let whole: Vec<Slot> = whole.iter().map(crate::formats::slots::old_slot).collect();
        let mut counts = [Counts::default(); KINDS.len() + 1];
        for (kind, counts) in counts.iter_mut().enumerate() {
            let (slots, spoiled) = spoil(&whole, kind, u64::from(n), seed);
            *counts = play(model, sensing, class as u8, &slots, &spoiled)?;
        }
        progress(u64::from(all));
        Ok::<_, Failure>(counts)
    });
    let total = each.try_reduce(
        || [Counts::default(); KINDS.len() + 1],
        |a, b| Ok(std::array::from_fn(|k| a[k].and(b[k]))),
    )?;
    let share = |part: u32| f64::from(part) / f64::from(total[0].recordings.max(1));
    let row = |(name, c): (&&str, &Counts)| SpoiledRow {
        kind: (*name).into(),
        recordings: c.recordings,
        slots: c.spoiled as f64 / c.asked.max(1) as f64,
        refused: c.refused as f64 / c.spoiled.max(1) as f64,
        unguarded: share(c.unguarded),
        guarded: share(c.guarded),
        without_verdict: share(c.without),
    };
    Ok((share(total[0].unguarded), KINDS.iter().zip(&total[1..]).map(row).collect()))
}

/// A copy with some slots spoiled, and which; kind 0 leaves all as they are.
fn spoil(whole: &[Slot], kind: usize, recording: u64, seed: u64) -> (Vec<Slot>, Vec<bool>) {
    let mut slots = whole.to_vec();
    let mut spoiled = vec![false; slots.len()];
    let Some(kind) = kind.checked_sub(1) else { return (slots, spoiled) };
    let mut random = Random::new(seed, STREAM, kind as u64, recording);
    let mut rng = Xoshiro128PlusPlus::seed_from_u64(random.bits());
    for (slot, spoiled) in slots.iter_mut().zip(&mut spoiled) {
        if random.uniform() < SHARE {
            Spoil::random(kind, &mut rng).apply(slot);
            *spoiled = true;
        }
    }
    (slots, spoiled)
}

fn alone<'m>(model: &Model<'m>) -> Exit<'m, Portable> {
    Exit::alone(model.clone(), Portable)
}

/// One recording before both stations.
fn play(
    file: &[u8],
    sensing: Sensing,
    truth: u8,
    slots: &[Slot],
    spoiled: &[bool],
) -> Result<Counts, Failure> {
    let (intact, model) = Intact::accept(file).map_err(|e| e.to_string())?;
    let mut counts = Counts { recordings: 1, ..Default::default() };
    let mut buffers = OwnedBuffers::for_model(&model);
    let mut trusting: Anytime<_> = Anytime::new([alone(&model)], 2.0, buffers.view())?;
    let verdict = slots.iter().find_map(|slot| trusting.push(slot, &mut ()));
    counts.unguarded = u32::from(verdict.is_some_and(|v| v.class == truth));
    let receiver: Anytime<_> = Anytime::new([alone(&model)], 2.0, buffers.view())?;
    let files = [intact].into_iter().collect();
    let mut station = Guarded::new(Watch::new(sensing, [1, 0, 0, 0, 0, 0, 0, 0], 0), receiver, files);
    let (mut signal, mut said) = (slots.iter().zip(spoiled), None);
    for number in 0..sensing.period() {
        if station.begin(number).slot != SlotUse::Sensing {
            continue;
        }
        let Some((slot, &spoiled)) = signal.next() else { break };
        let answer = station.sensed(number, slot);
        if answer == Err(Trouble::Unasked) {
            continue; // the verdict has been given
        }
        counts.asked += 1;
        counts.spoiled += u64::from(spoiled);
        counts.refused += u64::from(answer.is_err());
        said = answer.unwrap_or(None).or(said);
    }
    counts.without = u32::from(said.is_none());
    counts.guarded = u32::from(said.is_some_and(|v| v.class == truth));
    Ok(counts)
}
