//! Faults against the schedule of a radar module: numbers of the radio, retained state, lost slots, and plans that change, at any
//! tick of the virtual clock.
//!
//! The periods are short and have no recording: the radio says of every sensing slot that it was lost.

use super::environment::{Contexts, Environment, Transfer};
use super::observer::{CATCH_UP, Copies};
use super::{Outcome, below};
use rand_core::Rng;
use sdp3_core::radar::Settings;
use sdp3_core::scheduler::{Planner, SensingLayout, SlotUse, USERS};
use sdp3_core::supervision::retained::Retained;

/// Kinds of faults, and two changes that are none.
pub const KINDS: [&str; 16] = [
    "slots skipped",
    "outage",
    "slot repeated",
    "slot late",
    "counter reset",
    "clock drifts",
    "counter wraps in a gap",
    "slots lost",
    "user vanished",
    "plan changed at the boundary",
    "sensing ended early",
    "newest copy, one bit",
    "newest copy, bits of a word",
    "older copy, one bit",
    "both copies, one bit each",
    "waiting plan, one bit",
];

/// Slots that a drifting clock gains or loses in one event.
const SLIPS: u32 = 4;

/// A module without recordings.
pub struct Schedule<const VALUES: usize>(Environment<VALUES>);

fn layout(rng: &mut impl Rng) -> SensingLayout {
    loop {
        let (period, spacing) = (20 + below(rng, 40), below(rng, 5));
        if let Ok(layout) = SensingLayout::new(period, spacing, below(rng, 20)) {
            return layout;
        }
    }
}

fn rates(rng: &mut impl Rng) -> [u32; USERS] {
    let mut rates = [0; USERS];
    let users = 1 + below(rng, USERS as u32);
    rates.iter_mut().take(users as usize).for_each(|rate| *rate = 1 + below(rng, 1000));
    rates
}

/// Any word of a copy, and one of its bits.
pub(super) fn one_bit(rng: &mut impl Rng) -> (u32, u32) {
    (below(rng, Retained::LEN as u32), 1 << below(rng, 32))
}

impl<const VALUES: usize> Schedule<VALUES> {
    /// Contexts made with these settings on `retained`, for a model that needs `need` sensing slots. The counter is about to wrap.
    pub fn new(
        contexts: Contexts<VALUES>,
        settings: &Settings,
        retained: &'static Retained,
        need: u32,
        rng: &mut impl Rng,
    ) -> Self {
        let planner = Planner::new(settings.layout, settings.rates);
        let number = u32::MAX - below(rng, 1000);
        let mut environment = Environment::new(contexts, retained, planner, &[need], number, None);
        environment.plan(&settings.rates, Some(layout(rng)));
        Schedule(environment)
    }

    /// Injects a fault of `kind`, an index of [`KINDS`], at a random slot; a whole period without a fault follows.
    pub(super) fn inject(&mut self, kind: usize, rng: &mut impl Rng, outcome: &mut Outcome) {
        let radio = &mut self.0;
        radio.begin_event();
        radio.play(1, Transfer::Lost);
        let (_, left) = radio.position();
        radio.play(below(rng, left - 2), Transfer::Lost);
        apply(radio, kind, rng);
        radio.finish(Transfer::Lost);
        let before = radio.violations();
        radio.whole_period(Transfer::Lost);
        let recovered = radio.violations() == before;
        radio.end_event(recovered, outcome);
    }
}

fn apply<const VALUES: usize>(radio: &mut Environment<VALUES>, kind: usize, rng: &mut impl Rng) {
    let (_, left) = radio.position();
    match kind {
        0 => radio.skip(1 + below(rng, (left - 1).min(CATCH_UP))),
        1 => radio.skip(left.min(CATCH_UP + 1) + below(rng, 500)),
        2 => radio.repeat(),
        3 => radio.late(radio.number.wrapping_sub(2 + below(rng, 1000))),
        4 => radio.count_from(radio.number.wrapping_sub(2 + below(rng, 1 << 30))),
        5 => drift(radio, 60, Transfer::Lost, rng),
        6 => {
            let before = 2 + below(rng, 10);
            radio.count_from(before.wrapping_neg());
            radio.play(before - 1, Transfer::Lost);
            // the last number before the wrap is among those skipped, or the next
            radio.skip(1 + below(rng, CATCH_UP));
        }
        7 => {
            for _ in 1..left {
                let slot = radio.slot(Transfer::Lost);
                if slot != SlotUse::Sensing && below(rng, 4) == 0 {
                    radio.slot_lost();
                }
            }
        }
        8 => {
            let mut rates = radio.rates();
            rates.iter_mut().filter(|rate| **rate > 0).take(1).for_each(|rate| *rate = 0);
            radio.plan(&rates, None);
        }
        9 => {
            radio.play(left - 1, Transfer::Lost);
            radio.plan(&rates(rng), Some(layout(rng)));
        }
        // too few are left for a recording
        10 => radio.play(left - 1, Transfer::Done),
        11 => radio.damage(Copies::Newest, one_bit(rng)),
        12 => {
            let (word, _) = one_bit(rng);
            radio.damage(Copies::Newest, (word, rng.next_u32().max(1)));
        }
        13 => radio.damage(Copies::Older, one_bit(rng)),
        14 => {
            radio.damage(Copies::Both, one_bit(rng));
            // the reports that wait, and the plan, take a step each, and a step takes a slot at most
            radio.play(11, Transfer::Lost);
            radio.invariant(!radio.unplanned());
        }
        _ => {
            while !radio.flip_plan(rng.next_u32()) {
                radio.plan(&rates(rng), Some(layout(rng)));
                radio.slot(Transfer::Lost);
                radio.wait();
            }
        }
    }
    radio.slot(Transfer::Lost);
}

/// The clock of the radio runs fast (a number is missing now and then) or slow (a number comes twice).
pub(super) fn drift<const VALUES: usize>(
    radio: &mut Environment<VALUES>,
    apart: u32,
    transfer: Transfer,
    rng: &mut impl Rng,
) {
    let fast = below(rng, 2) == 0;
    for _ in 0..SLIPS {
        radio.play(1 + below(rng, apart), transfer);
        if fast { radio.skip(1) } else { radio.repeat() }
    }
}
