//! Whose turn a communication slot is: every receiver's turns spread evenly, the turn due first goes first.
//!
//! Turn j = 0, 1, ... of a receiver with n of C slots belongs into the slots from floor(j C / n) up to, not including,
//! ceil((j + 1) C / n): the windows of proportionate fairness (Baruah, Cohen, Plaxton and Varvel, 1996). Serving the earliest due
//! time among open windows never misses one (unit jobs, one server, demand equal to supply), so at every moment every receiver
//! has its exact proportion to less than one slot.

use super::layout::RECEIVERS;
use crate::state::State;

/// One receiver's next turn.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
struct Turn {
    /// First slot of the window, floor(j C / n).
    opens: u32,
    /// Slot before which the turn is due, ceil((j + 1) C / n).
    due: u32,
    /// C / n, rounded down.
    whole: u32,
    /// C modulo n.
    part: u32,
    /// j C modulo n.
    rest: u32,
    /// n.
    share: u32,
    /// j.
    served: u32,
}

impl Turn {
    /// The first of `share` turns in `slots` slots; never open without a share.
    fn first(share: u32, slots: u32) -> Self {
        let never = Turn { opens: u32::MAX, due: u32::MAX, whole: 0, part: 0, rest: 0, share: 0, served: 0 };
        match (slots.checked_div(share), slots.checked_rem(share)) {
            (Some(whole), Some(part)) => {
                let due = whole + u32::from(part > 0);
                Turn { opens: 0, due, whole, part, rest: 0, share, served: 0 }
            }
            _ => never,
        }
    }

    /// The turn after this one.
    fn advance(&mut self) {
        self.served += 1;
        let rest = self.rest + self.part;
        let carry = u32::from(rest >= self.share);
        self.opens += self.whole + carry;
        self.rest = rest - carry * self.share;
        // ceil((j C mod n + C) / n) beyond floor(j C / n)
        let ahead = self.rest + self.part;
        self.due = self.opens + self.whole + u32::from(ahead > 0) + u32::from(ahead > self.share);
    }
}

impl State for Turn {
    fn words(&mut self, visit: &mut impl FnMut(&mut u32)) {
        let Turn { opens, due, whole, part, rest, share, served } = self;
        [opens, due, whole, part, rest, share, served].into_iter().for_each(visit);
    }
}

/// The turns of a run of communication slots.
#[derive(Debug, Clone, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Turns {
    turns: [Turn; RECEIVERS],
    receivers: u32,
    played: u32,
}

impl Turns {
    /// Turns for shares of at most [`RECEIVERS`] receivers, whose sum is the number of slots, below 2^31.
    pub fn new(shares: &[u32]) -> Self {
        let slots = shares.iter().copied().fold(0, u32::saturating_add);
        let mut turns = [Turn::first(0, 0); RECEIVERS];
        turns.iter_mut().zip(shares).for_each(|(turn, &share)| *turn = Turn::first(share, slots));
        Turns { turns, receivers: shares.len().min(RECEIVERS) as u32, played: 0 }
    }

    /// The receiver of the next slot; `None` if nobody has a turn left. Cost: O(K), no division, no multiplication.
    #[allow(clippy::should_implement_trait)] // slots go on after a `None`
    pub fn next(&mut self) -> Option<usize> {
        let (mut first, mut due) = (None, u32::MAX);
        for (k, turn) in self.turns.iter().enumerate().take(self.receivers as usize) {
            if turn.opens <= self.played && turn.due < due {
                (first, due) = (Some(k), turn.due);
            }
        }
        self.played += 1;
        let turn = first.and_then(|k| self.turns.get_mut(k))?;
        if turn.served >= turn.share {
            return None;
        }
        turn.advance();
        first
    }

    /// Turns each receiver has had.
    pub fn served(&self) -> [u32; RECEIVERS] {
        self.turns.map(|turn| turn.served)
    }
}

impl State for Turns {
    fn words(&mut self, visit: &mut impl FnMut(&mut u32)) {
        self.turns.iter_mut().for_each(|turn| turn.words(visit));
        [&mut self.receivers, &mut self.played].into_iter().for_each(visit);
    }
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;
    use rand_core::{Rng, SeedableRng};

    #[test]
    fn every_prefix_is_proportionate_to_less_than_one_slot() {
        let mut rng = rand_xoshiro::Xoshiro128PlusPlus::seed_from_u64(2);
        for _ in 0..2000 {
            let receivers = 1 + rng.next_u32() as usize % RECEIVERS;
            let shares: std::vec::Vec<u32> =
                (0..receivers).map(|_| (rng.next_u32() % 300) >> (rng.next_u32() % 8)).collect();
            let slots: u32 = shares.iter().sum();
            let mut turns = Turns::new(&shares);
            let mut had = std::vec![0_u32; receivers];
            for played in 1..=slots {
                had[turns.next().expect("a turn in every slot")] += 1;
                for (&had, &share) in had.iter().zip(&shares) {
                    // |had - played share / slots| < 1
                    let lag = i64::from(had) * i64::from(slots) - i64::from(played) * i64::from(share);
                    assert!(lag.abs() < i64::from(slots), "{shares:?} {played}");
                }
            }
            assert_eq!((&had, turns.next()), (&shares, None));
            assert_eq!(&turns.served()[..receivers], &shares[..]);
        }
    }
}
