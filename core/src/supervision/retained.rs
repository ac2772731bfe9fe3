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
        debug_assert_eq!(at, WORDS, "the state has as many words as memory is kept for");
        checksum.store(made, Relaxed);
    }

    /// All words, the even copy first: for a debugger, and for tests that change them.
    pub fn words(&self) -> &[AtomicU32] {
        self.copies.as_flattened()
    }

    /// Words of the memory.
    pub const LEN: usize = 2 * COPY;
}

/// A state on its way between two contexts, under the same checksum.
#[derive(Debug)]
pub(crate) struct Message<S> {
    state: S,
    checksum: u32,
}

impl<S: State + Clone> Message<S> {
    pub fn new(mut state: S) -> Self {
        let checksum = Self::sum(&mut state);
        Message { state, checksum }
    }

    /// Whether it has not changed on the way.
    pub fn is_intact(&self) -> bool {
        Self::sum(&mut self.state.clone()) == self.checksum
    }

    /// The state.
    pub fn state(&self) -> &S {
        &self.state
    }

    #[inline(always)]
    fn sum(state: &mut S) -> u32 {
        let mut made = SEED;
        state.words(&mut |word| made = mix(made, *word));
        made
    }
}

/// Visits a flag as 0 or 1; any other word is 1.
pub(crate) fn flag(flag: &mut bool, visit: &mut impl FnMut(&mut u32)) {
    let mut word = u32::from(*flag);
    visit(&mut word);
    *flag = word != 0;
}
