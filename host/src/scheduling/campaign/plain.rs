//! The same schedule by a plain loop, to compare speeds: every slot evaluates the definition and every user's lag.

use sdp3_core::scheduler::{Plan, Sequencer, SlotUse};
use std::time::Instant;

/// Plays `periods` of a plan; `each` sees every slot.
///
/// Slot j senses iff j mod (N_m + 1) = 1 and j <= N_s (N_m + 1); the others go to the user that lags its proportion most.
fn play(plan: &Plan, periods: u32, mut each: impl FnMut(SlotUse)) {
    let (step, slots) = (plan.spacing() + 1, plan.sensing());
    let others = f64::from(plan.period() - slots);
    for _ in 0..periods {
        let mut had = vec![0.0; plan.shares().len()];
        let mut played = 0.0;
        for j in 1..=plan.period() {
            if j % step == 1 % step && j <= slots * step {
                each(SlotUse::Sensing);
                continue;
            }
            played += 1.0;
            let lag = |k: usize| f64::from(plan.shares()[k]) * played / others - had[k];
            let most = (0..had.len()).fold(0, |best, k| if lag(k) > lag(best) { k } else { best });
            had[most] += 1.0;
            each(SlotUse::Communication(most as u8));
        }
    }
}

/// Decisions per second of the campaign, of the core's scheduler alone, and of the plainest loop, one after the other.
pub fn speeds(plan: &Plan, decisions: u64, took_s: f64) -> String {
    // the loop that repeats a plan counts its slots in 32 bits
    let most = u64::from(u32::MAX / plan.period()).min(10_000);
    let periods = (decisions / u64::from(plan.period())).clamp(1, most) as u32;
    let count = f64::from(periods) * f64::from(plan.period());
    let mut digest = 0_u64;
    let mut count_slot = |slot: SlotUse| {
        if let SlotUse::Communication(k) = slot {
            digest = digest.wrapping_mul(31).wrapping_add(u64::from(k));
        }
    };
    let begun = Instant::now();
    let mut sequencer = Sequencer::new(plan);
    (0..periods * plan.period()).for_each(|_| count_slot(sequencer.next_slot()));
    let core = begun.elapsed().as_secs_f64();
    let begun = Instant::now();
    play(plan, periods, &mut count_slot);
    let plain = begun.elapsed().as_secs_f64();
    std::hint::black_box(digest);
    let million = |count: f64, s: f64| count / s / 1e6;
    format!(
        "million decisions a second, one core: the whole simulation {:.1}, the scheduler {:.1}, a plain loop {:.1}; the scheduler \
         is {:.2} times the plain loop",
        million(decisions as f64, took_s),
        million(count, core),
        million(count, plain),
        plain / core
    )
}
