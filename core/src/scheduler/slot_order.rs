//! Which user a communication slot belongs to: each user's slots spread evenly, the one due first goes first.
//!
//! Slot j = 0, 1, ... of a user with n of C slots has its window in the slots from floor(j C / n) up to, not including,
//! ceil((j + 1) C / n): the windows of proportionate fairness (Baruah, Cohen, Plaxton and Varvel, 1996). Serving the earliest due
//! time among open windows never misses one (unit jobs, one server, demand equal to supply), so at every moment every user
//! has its exact proportion to less than one slot.

use super::layout::USERS;
use crate::supervision::retained::State;

/// The window of a user's next slot.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
struct Window {
    /// First slot of the window, floor(j C / n).
    opens: u32,
    /// Slot before which it is due, ceil((j + 1) C / n).
    due: u32,
    /// j C modulo n.
    rest: u32,
    share: u32,
    served: u32,
}

impl Window {
    /// The first of `share` windows in `slots` slots; never open without a share.
    fn first(share: u32, slots: u32) -> Self {
        match share {
            0 => Window { opens: u32::MAX, due: u32::MAX, rest: 0, share, served: 0 },
            _ => Window { opens: 0, due: slots.div_ceil(share), rest: 0, share, served: 0 },
        }
    }

    /// The next window in `slots` slots.
    fn advance(&mut self, slots: u32) {
        let whole = slots.checked_div(self.share).unwrap_or(0);
        let part = slots - whole * self.share;
        self.served += 1;
        let rest = self.rest + part;
        let carry = u32::from(rest >= self.share);
        self.opens += whole + carry;
        self.rest = rest - carry * self.share;
        // ceil((j C mod n + C) / n) beyond floor(j C / n)
        let ahead = self.rest + part;
        self.due = self.opens + whole + u32::from(ahead > 0) + u32::from(ahead > self.share);
    }
}

impl State for Window {
    #[inline(always)]
    fn words(&mut self, visit: &mut impl FnMut(&mut u32)) {
        let Window { opens, due, rest, share, served } = self;
        [opens, due, rest, share, served].into_iter().for_each(visit);
    }
}

/// The order of a run of communication slots.
#[derive(Debug, Clone, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub(crate) struct SlotOrder {
    windows: [Window; USERS],
    users: u32,
    slots: u32,
    elapsed: u32,
}

impl SlotOrder {
    /// The order for shares of at most [`USERS`] users. Their sum is the number of slots, below 2^31.
    pub fn new(shares: &[u32]) -> Self {
        let slots = shares.iter().copied().fold(0, u32::saturating_add);
        let mut windows = [Window::first(0, 0); USERS];
        windows.iter_mut().zip(shares).for_each(|(window, &share)| *window = Window::first(share, slots));
        SlotOrder { windows, users: shares.len().min(USERS) as u32, slots, elapsed: 0 }
    }

    /// The user of the next slot; `None` if no user has a slot left. Cost: O(K), one division.
    #[allow(clippy::should_implement_trait)] // slots go on after a `None`
    pub fn next(&mut self) -> Option<usize> {
        let (mut first, mut due) = (None, u32::MAX);
        for (k, window) in self.windows.iter().enumerate().take(self.users as usize) {
            if window.opens <= self.elapsed && window.due < due {
                (first, due) = (Some(k), window.due);
            }
        }
        self.elapsed += 1;
        let window = first.and_then(|k| self.windows.get_mut(k))?;
        if window.served >= window.share {
            return None;
        }
        window.advance(self.slots);
        first
    }

    /// Slots each user has had.
    pub fn served(&self) -> [u32; USERS] {
        self.windows.map(|window| window.served)
    }
}

impl State for SlotOrder {
    fn words(&mut self, visit: &mut impl FnMut(&mut u32)) {
        // one by one: in a loop every word would be compared with the end of the memory
        let [a, b, c, d, e, f, g, h] = &mut self.windows;
        a.words(visit);
        b.words(visit);
        c.words(visit);
        d.words(visit);
        e.words(visit);
        f.words(visit);
        g.words(visit);
        h.words(visit);
        [&mut self.users, &mut self.slots, &mut self.elapsed].into_iter().for_each(visit);
    }
}
