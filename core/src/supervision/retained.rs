//! The slot context's state in memory that survives a reset: two copies, written in turn.
//!
//! A slot reads the newer copy, checks it, and writes its successor over the older one. A reset or a bit flip at any moment leaves
//! one whole copy, at most one slot old. Every word of a copy and its sequence number are under a checksum.

use core::sync::atomic::{AtomicU32, Ordering::Relaxed};

/// An object with a state of a fixed number of words.
pub(crate) trait State {
    /// Visits every word in a fixed order; what the visitor leaves in a word becomes the state.
    fn words(&mut self, visit: &mut impl FnMut(&mut u32));
}

/// Words of a slot context's state.
pub(crate) const WORDS: usize = 83;

/// Sequence number, state, checksum.
const COPY: usize = WORDS + 2;

/// Memory for a slot context's state. In a section that start-up leaves alone it survives a reset.
///
/// `static RETAINED: Retained = Retained::new();`, with `#[unsafe(link_section = ".uninit")]` where there is such a section.
#[derive(Debug)]
pub struct Retained {
    copies: [[AtomicU32; COPY]; 2],
}

/// What [`Retained::load`] found.
pub(crate) enum Loaded {
    /// The state saved last.
    Newest(u32),
    /// The state saved before the last, which is damaged.
    Previous(u32),
    /// Nothing whole.
    Nothing,
}

/// A running checksum.
///
/// A step maps the checksum so far, for one word, and the word, for one checksum so far, one to one (an odd factor, an xor with
/// the own upper half): a change within one word always changes the result; of changes in more than one word 2^-32 do not.
/// CRC-32 would take five times as long in the slot interrupt.
#[inline(always)]
fn mix(checksum: u32, word: u32) -> u32 {
    let product = (checksum ^ word).wrapping_mul(0x85eb_ca6b);
    product ^ product >> 16
}

/// What a checksum begins with.
const SEED: u32 = 0x9e37_79b9;

impl Retained {
    /// Memory without a state.
    #[allow(clippy::new_without_default)] // it belongs into a `static`
    pub const fn new() -> Self {
        Retained { copies: [const { [const { AtomicU32::new(0) }; COPY] }; 2] }
    }

    /// Reads the newest whole copy into `state`; `sequence` is the number it was saved by, if that is known.
    pub(crate) fn load(&self, sequence: Option<u32>, state: &mut impl State) -> Loaded {
        let [even, odd] = self.copies.each_ref().map(|[first, ..]| first.load(Relaxed));
        let newest = match sequence {
            Some(sequence) => sequence,
            None if even.wrapping_sub(odd) < 1 << 31 => even,
            None => odd,
        };
        if self.read(newest, state) {
            return Loaded::Newest(newest);
        }
        let [other, last] = [newest.wrapping_sub(1), if newest == even { odd } else { even }];
        if self.read(other, state) {
            return Loaded::Previous(other);
        }
        // after a reset the number itself may be what has changed
        let retry = sequence.is_none() && last != other && self.read(last, state);
        if retry { Loaded::Previous(last) } else { Loaded::Nothing }
    }

    /// Reads the copy with this number; false if it is not whole.
    fn read(&self, sequence: u32, state: &mut impl State) -> bool {
        let [even, odd] = &self.copies;
        let [number, words @ .., checksum] = if sequence.is_multiple_of(2) { even } else { odd };
        if number.load(Relaxed) != sequence {
            return false;
        }
        let mut found = mix(SEED, sequence);
        let mut at = 0; // a constant at every word, unlike an iterator's place
        state.words(&mut |word| {
            *word = words.get(at).map_or(0, |kept| kept.load(Relaxed));
            at += 1;
            found = mix(found, *word);
        });
        found == checksum.load(Relaxed)
    }

    /// Writes a state over the older copy.
    pub(crate) fn save(&self, sequence: u32, state: &mut impl State) {
        let [even, odd] = &self.copies;
        let [number, words @ .., checksum] = if sequence.is_multiple_of(2) { even } else { odd };
        number.store(sequence, Relaxed);
        let mut made = mix(SEED, sequence);
        let mut at = 0;
        state.words(&mut |word| {
            made = mix(made, *word);
            words.get(at).into_iter().for_each(|kept| kept.store(*word, Relaxed));
            at += 1;
        });
        checksum.store(made, Relaxed);
    }

    /// Inverts the bits of `mask` in word `at` (modulo [`Retained::LEN`]): what a particle does, for tests of a whole system.
    pub fn flip(&self, at: usize, mask: u32) {
        if let Some(word) = self.copies.as_flattened().get(at % Self::LEN) {
            word.store(word.load(Relaxed) ^ mask, Relaxed);
        }
    }

    /// Words of the memory.
    pub const LEN: usize = 2 * COPY;
}

/// Visits a flag as 0 or 1; any other word is 1.
pub(crate) fn flag(flag: &mut bool, visit: &mut impl FnMut(&mut u32)) {
    let mut word = u32::from(*flag);
    visit(&mut word);
    *flag = word != 0;
}

#[cfg(test)]
mod tests {
    use super::*;

    #[derive(Clone, Copy, PartialEq, Debug)]
    struct Words([u32; WORDS]);

    impl State for Words {
        fn words(&mut self, visit: &mut impl FnMut(&mut u32)) {
            self.0.iter_mut().for_each(visit);
        }
    }

    fn state(number: u32) -> Words {
        Words(core::array::from_fn(|k| number.wrapping_mul(0x9e37_79b1) ^ k as u32))
    }

    /// Two states saved, the second number being `last`.
    fn saved(last: u32) -> Retained {
        let retained = Retained::new();
        for number in [last.wrapping_sub(1), last] {
            retained.save(number, &mut state(number));
        }
        retained
    }

    #[test]
    fn the_newest_whole_copy_is_found_with_and_without_its_number() {
        for last in [1, 2, 77, 0, u32::MAX] {
            for known in [None, Some(last)] {
                let (retained, mut found) = (saved(last), state(9));
                assert!(matches!(retained.load(known, &mut found), Loaded::Newest(n) if n == last));
                assert_eq!(found, state(last));
            }
        }
    }

    #[test]
    fn every_change_within_a_word_is_found_and_leaves_the_other_copy() {
        for at in 0..Retained::LEN {
            for mask in (0..32).map(|bit| 1 << bit).chain([0xff, 0xffff_0000, u32::MAX]) {
                let (retained, mut found) = (saved(8), state(9));
                retained.flip(at, mask);
                let newest = at < COPY; // even numbers lie first
                match retained.load(Some(8), &mut found) {
                    Loaded::Newest(8) => assert!(!newest && found == state(8), "word {at}, {mask:#x}"),
                    Loaded::Previous(7) => assert!(newest && found == state(7), "word {at}, {mask:#x}"),
                    _ => panic!("word {at}, {mask:#x}"),
                }
            }
        }
    }

    #[test]
    fn a_reset_within_a_write_loses_nothing() {
        // the write of number 9 over number 7 stops after any word
        for stop in 0..COPY {
            let (before, after) = (saved(8), saved(8));
            after.save(9, &mut state(9));
            for (to, from) in before.copies[1].iter().zip(&after.copies[1]).take(stop) {
                to.store(from.load(Relaxed), Relaxed);
            }
            let mut found = state(0);
            let loaded = before.load(None, &mut found);
            let number = match loaded {
                Loaded::Newest(n) | Loaded::Previous(n) => n,
                Loaded::Nothing => panic!("stopped after {stop}"),
            };
            assert_eq!((number, found), (8, state(8)), "stopped after {stop}");
        }
    }

    #[test]
    fn memory_that_nothing_was_written_to_is_not_a_state() {
        for word in [0, u32::MAX, 0xAAAA_AAAA, 0x5555_5555, 0xDEAD_BEEF] {
            let retained = Retained::new();
            retained.copies.as_flattened().iter().for_each(|kept| kept.store(word, Relaxed));
            assert!(matches!(retained.load(None, &mut state(0)), Loaded::Nothing), "{word:#x}");
        }
    }

    #[test]
    fn flags_are_words_and_come_back() {
        for (word, on) in [(0, false), (1, true), (2, true), (u32::MAX, true)] {
            let mut state = !on;
            flag(&mut state, &mut |seen| {
                assert_eq!(*seen, u32::from(!on));
                *seen = word;
            });
            assert_eq!(state, on);
        }
    }
}
