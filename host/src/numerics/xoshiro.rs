//! Xoshiro256++ (Blackman and Vigna, "Scrambled linear pseudorandom number generators", 2019), and its words by jump-ahead: eight
//! consecutive substreams of one stream side by side, in vectors.
//!
//! A step is linear over GF(2) in the 256 bits of the state, and so is a jump of many steps: a matrix of 256 by 256 bits.

use super::vectors::vectorised;
use std::sync::LazyLock;

/// Words of a substream, and substreams side by side.
const SUBSTREAM: usize = 2048;
const LANES: usize = 8;

/// A generator of 64-bit words.
pub trait Generator {
    /// The next word.
    fn next(&mut self) -> u64;

    /// The next words, as many as the slice holds.
    #[inline(always)]
    fn fill(&mut self, words: &mut [u64]) {
        words.iter_mut().for_each(|word| *word = self.next());
    }
}

type State = [u64; 4];

/// The generator, word by word.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Xoshiro256PlusPlus(State);

impl Xoshiro256PlusPlus {
    /// Of a state, not all of it 0.
    pub fn new(state: State) -> Self {
        Xoshiro256PlusPlus(state)
    }
}

impl Generator for Xoshiro256PlusPlus {
    #[inline(always)]
    fn next(&mut self) -> u64 {
        let [a, b, c, d] = &mut self.0;
        let word = a.wrapping_add(*d).rotate_left(23).wrapping_add(*a);
        let shifted = *b << 17;
        *c ^= *a;
        *d ^= *b;
        *b ^= *c;
        *a ^= *d;
        *c ^= shifted;
        *d = d.rotate_left(45);
        word
    }
}

/// A word of eight states.
type Lanes = [u64; LANES];

#[inline(always)]
fn lanes(word: impl Fn(usize) -> u64) -> Lanes {
    std::array::from_fn(word)
}

#[inline(always)]
fn xor(a: Lanes, b: Lanes) -> Lanes {
    lanes(
        #[inline(always)]
        |n| a[n] ^ b[n],
    )
}

/// [`Xoshiro256PlusPlus`] of eight states; their words, and the states after them.
#[inline(always)]
fn step([a, b, c, d]: [Lanes; 4]) -> (Lanes, [Lanes; 4]) {
    let word = lanes(
        #[inline(always)]
        |n| a[n].wrapping_add(d[n]).rotate_left(23).wrapping_add(a[n]),
    );
    let shifted = lanes(
        #[inline(always)]
        |n| b[n] << 17,
    );
    let (c, d) = (xor(c, a), xor(d, b));
    let (b, a) = (xor(b, c), xor(a, d));
    let rotated = lanes(
        #[inline(always)]
        |n| d[n].rotate_left(45),
    );
    (word, [a, b, xor(c, shifted), rotated])
}

/// A jump's matrix: the state to which each single bit leads.
type JumpMatrix = [State; 64 * 4];

fn jump(matrix: &JumpMatrix, state: &State) -> State {
    let mut to = [0; 4];
    for (bit, image) in matrix.iter().enumerate() {
        if state[bit / 64] >> (bit % 64) & 1 == 1 {
            to.iter_mut().zip(image).for_each(|(to, image)| *to ^= image);
        }
    }
    to
}

/// Over one substream, and over the seven others.
static JUMPS: LazyLock<[JumpMatrix; 2]> = LazyLock::new(|| {
    let one: JumpMatrix = std::array::from_fn(|bit| {
        let mut state = [0; 4];
        state[bit / 64] = 1 << (bit % 64);
        let mut generator = Xoshiro256PlusPlus(state);
        generator.next();
        generator.0
    });
    let then = |first: &JumpMatrix, second: &JumpMatrix| first.map(|state| jump(second, &state));
    let substream = (0..SUBSTREAM.ilog2()).fold(one, |matrix, _| then(&matrix, &matrix));
    let others = (1..LANES - 1).fold(substream, |matrix, _| then(&matrix, &substream));
    [substream, others]
});

/// The words of one stream, 16384 at a time.
#[derive(Debug, Clone)]
pub struct Substreams {
    /// States at which the next substreams begin, `[word][substream]`.
    states: [Lanes; 4],
    words: Vec<[u64; SUBSTREAM]>,
    used: usize,
}

impl Substreams {
    /// The words that a generator draws from here on.
    pub fn of(generator: &Xoshiro256PlusPlus) -> Self {
        let (mut states, mut state) = ([[0; LANES]; 4], generator.0);
        for lane in 0..LANES {
            states.iter_mut().zip(state).for_each(|(to, word)| to[lane] = word);
            state = jump(&JUMPS[0], &state);
        }
        Substreams { states, words: vec![[0; SUBSTREAM]; LANES], used: LANES * SUBSTREAM }
    }

    /// Draws the next substreams, and jumps to those behind them.
    fn make(&mut self) {
        let (Substreams { states, words, used }, others) = (self, &JUMPS[1]);
        *used = 0;
        vectorised(
            #[inline(always)]
            || {
                let mut now = *states;
                for from in (0..SUBSTREAM).step_by(LANES) {
                    // eight words of eight substreams are transposed in registers
                    let mut some = [[0; LANES]; LANES];
                    for word in &mut some {
                        (*word, now) = step(now);
                    }
                    for (lane, words) in words.iter_mut().enumerate() {
                        for k in 0..LANES {
                            words[from + k] = some[k][lane];
                        }
                    }
                }
                let mut begin = [[0; LANES]; 4];
                for (bit, image) in others.iter().enumerate() {
                    let word = now[bit / 64];
                    let mask = lanes(
                        #[inline(always)]
                        |n| 0_u64.wrapping_sub(word[n] >> (bit % 64) & 1),
                    );
                    for k in 0..4 {
                        let before = begin[k];
                        begin[k] = lanes(
                            #[inline(always)]
                            |n| before[n] ^ (image[k] & mask[n]),
                        );
                    }
                }
                *states = begin;
            },
        );
    }
}

impl Generator for &mut Substreams {
    fn next(&mut self) -> u64 {
        let mut word = [0];
        self.fill(&mut word);
        word[0]
    }

    fn fill(&mut self, mut words: &mut [u64]) {
        while !words.is_empty() {
            if self.used == LANES * SUBSTREAM {
                self.make();
            }
            let made = &self.words.as_flattened()[self.used..];
            let (now, later) = words.split_at_mut(words.len().min(made.len()));
            now.copy_from_slice(&made[..now.len()]);
            self.used += now.len();
            words = later;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand_core::{Rng, SeedableRng};

    #[test]
    fn words_are_those_of_the_published_generator() {
        let state = [1, 2, 3, 0x9e37_79b9_7f4a_7c15];
        let bytes: Vec<u8> = state.iter().flat_map(|word: &u64| word.to_le_bytes()).collect();
        let mut published = rand_xoshiro::Xoshiro256PlusPlus::from_seed(bytes.try_into().unwrap());
        let mut one = Xoshiro256PlusPlus::new(state);
        let mut substreams = Substreams::of(&one);
        let mut many = &mut substreams;
        // of lengths that divide no substream, more than 16384 in all
        for length in (0..40).map(|k| 1 + 811 * (k % 3)) {
            let mut words = vec![0; length];
            many.fill(&mut words);
            for word in words {
                let expected = published.next_u64();
                assert_eq!([one.next(), word], [expected; 2]);
            }
        }
    }
}
