//! The same schedule by a plain loop, to compare speeds: every slot evaluates the definition and every user's lag.

use sdp3_core::scheduler::{Plan, SlotUse};

/// Plays `periods` of a plan; `each` sees every slot.
///
/// Slot j senses iff j mod (N_m + 1) = 1 and j <= N_s (N_m + 1); the others go to the user that lags its proportion most.
pub fn play(plan: &Plan, periods: u32, mut each: impl FnMut(SlotUse)) {
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
