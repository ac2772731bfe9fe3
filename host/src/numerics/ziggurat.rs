//! Normal numbers by Marsaglia and Tsang's ziggurat (2000) with 256 layers.
//!
//! A word of random bits is a layer and a place in it. 98.9 % of the places lie inside their layer. A place at a layer's edge takes a
//! second word and is kept or not, one in the tail takes two at a time until it is kept. Many numbers are made from blocks of words,
//! in vectors: every word of a block is taken for the first of a number, and the words that others turn out to have used are passed over.

use super::vectors::vectorised;
use super::xoshiro::Generator;
use std::sync::LazyLock;

const LAYERS: usize = 256;
/// Where the tail begins, and the area of each layer.
const TAIL: f64 = 3.654_152_885_361_009;
const AREA: f64 = 0.004_928_673_233_974_655;

/// What rounding may change in bounds of the density, and more.
const SURELY: f64 = 1.0 - 1e-12;

/// Words of a block, and as many as one mask has bits.
const BLOCK: usize = 512;
const MASK: usize = 64;
/// Fewest numbers that are made from blocks.
const FEWEST: usize = 64;

/// Widths and heights of the layers.
struct Ziggurat {
    x: [f64; LAYERS + 1],
    y: [f64; LAYERS + 1],
}

static ZIGGURAT: LazyLock<Ziggurat> = LazyLock::new(|| {
    let density = |x: f64| libm::exp(-0.5 * x * x);
    let mut x = [0.0; LAYERS + 1];
    x[0] = AREA / density(TAIL);
    x[1] = TAIL;
    for i in 2..LAYERS {
        x[i] = (-2.0 * libm::log(AREA / x[i - 1] + density(x[i - 1]))).sqrt();
    }
    let y = x.map(density);
    Ziggurat { x, y }
});

/// Uniform in 0..1.
#[inline(always)]
pub fn uniform(bits: u64) -> f64 {
    (bits >> 11) as f64 / (1_u64 << 53) as f64
}

#[inline(always)]
fn layer(bits: u64) -> usize {
    (bits & 255) as usize
}

impl Ziggurat {
    /// The place of these bits, and whether it lies inside its layer.
    #[inline(always)]
    fn place(&self, bits: u64) -> (f64, bool) {
        // a signed 53-bit fraction from the upper bits
        let u = ((bits as i64) >> 11) as f64 / (1_i64 << 52) as f64;
        let x = u * self.x[layer(bits)];
        (x, x.abs() < self.x[layer(bits) + 1])
    }

    /// The places of the first `count` words, and bits of those outside their layer. Arguments, not fields: the compiler puts the loop into
    /// vectors since it knows them to be apart.
    #[inline(always)]
    fn places(
        &self,
        words: &[u64; BLOCK],
        places: &mut [f64; BLOCK],
        outside: &mut [u64; BLOCK / MASK],
        count: usize,
    ) {
        let groups = words.as_chunks::<MASK>().0.iter().zip(places.as_chunks_mut::<MASK>().0).zip(outside);
        for ((words, places), outside) in groups.take(count.div_ceil(MASK)) {
            let mut mask = 0;
            for k in 0..MASK {
                let (x, inside) = self.place(words[k]);
                places[k] = x;
                mask |= u64::from(!inside) << k;
            }
            *outside = mask;
        }
    }

    /// Whether the place of `first`, at its layer's edge, is kept by the word that follows: whether the height that the word states lies
    /// below the density. Nearly always bounds of the density decide, of which the exponential is not needed.
    fn keeps(&self, first: u64, second: u64, place: f64) -> bool {
        let [low, high] = [0, 1].map(|above| self.y[layer(first) + above]);
        let height = low + (high - low) * uniform(second);
        // the density over that of the layer's end is exp(rise): above the series' first terms, below one over those of exp(-rise)
        let end = self.x[layer(first)];
        let rise = 0.5 * (end * end - place * place);
        if height < SURELY * low * (1.0 + rise * (1.0 + rise * (0.5 + rise / 6.0))) {
            return true;
        }
        if SURELY * height * (1.0 - rise * (1.0 - rise * (0.5 - rise / 6.0))) > low {
            return false;
        }
        height < libm::exp(-0.5 * place * place)
    }
}

/// Words that were drawn, and the generator of those after them.
struct Drawn<'a, G> {
    words: &'a [u64],
    generator: G,
}

impl<G: Generator> Drawn<'_, G> {
    fn next(&mut self) -> u64 {
        match self.words.split_first() {
            Some((first, rest)) => {
                self.words = rest;
                *first
            }
            None => self.generator.next(),
        }
    }

    /// The number of which these bits are the first and lie outside their layer. Words go in and out: a generator's stay in registers.
    #[cold]
    #[inline(never)]
    fn outside(mut self, mut bits: u64) -> (Self, f64) {
        let ziggurat = &*ZIGGURAT;
        loop {
            let (x, inside) = ziggurat.place(bits);
            if inside {
                return (self, x);
            }
            if layer(bits) == 0 {
                let x = if x < 0.0 { -self.tail() } else { self.tail() };
                return (self, x);
            }
            if ziggurat.keeps(bits, self.next(), x) {
                return (self, x);
            }
            bits = self.next();
        }
    }

    fn tail(&mut self) -> f64 {
        loop {
            let x = -libm::log(1.0 - uniform(self.next())) / TAIL;
            let y = -libm::log(1.0 - uniform(self.next()));
            if 2.0 * y > x * x {
                return TAIL + x;
            }
        }
    }
}

/// Fills with normal numbers of mean 0 and variance 1. The generator is returned as it is after the words that were used.
#[inline]
pub fn fill<G: Generator>(mut generator: G, mut values: &mut [f64]) -> G {
    if values.len() >= FEWEST {
        let mut block = Block::new();
        while values.len() >= FEWEST {
            let made;
            (generator, made) = block.fill(generator, values);
            values = &mut values[made..];
        }
    }
    one_by_one(generator, values)
}

#[inline]
fn one_by_one<G: Generator>(generator: G, values: &mut [f64]) -> G {
    let ziggurat = &*ZIGGURAT;
    let mut drawn = Drawn { words: &[], generator };
    for value in values {
        let bits = drawn.generator.next();
        let (x, inside) = ziggurat.place(bits);
        *value = x;
        if !inside {
            (drawn, *value) = drawn.outside(bits);
        }
    }
    drawn.generator
}

/// A block of words, and each word's place.
struct Block {
    words: [u64; BLOCK],
    places: [f64; BLOCK],
    /// Bits of places that lie outside their layer.
    outside: [u64; BLOCK / MASK],
}

impl Block {
    fn new() -> Self {
        Block { words: [0; BLOCK], places: [0.0; BLOCK], outside: [0; BLOCK / MASK] }
    }

    /// Makes numbers from as many words as there are values or a block has; how many numbers. Every word is used: a number takes at least
    /// one.
    fn fill<G: Generator>(&mut self, mut generator: G, values: &mut [f64]) -> (G, usize) {
        let count = values.len().min(BLOCK);
        generator.fill(&mut self.words[..count]);
        let (ziggurat, Block { words, places, outside }) = (&*ZIGGURAT, &mut *self);
        vectorised(
            #[inline(always)]
            || ziggurat.places(words, places, outside, count),
        );
        let (mut from, mut made) = (0, 0);
        for at in self.edges(count) {
            // the second word of the one before
            if at < from {
                continue;
            }
            let run = at - from;
            values[made..made + run].copy_from_slice(&self.places[from..at]);
            made += run;
            if layer(self.words[at]) == 0 || at + 1 == count {
                let drawn = Drawn { words: &self.words[at + 1..count], generator };
                let (drawn, value) = drawn.outside(self.words[at]);
                values[made] = value;
                (from, made) = (count - drawn.words.len(), made + 1);
                generator = drawn.generator;
            } else {
                values[made] = self.places[at];
                let kept = ziggurat.keeps(self.words[at], self.words[at + 1], self.places[at]);
                (from, made) = (at + 2, made + usize::from(kept));
            }
        }
        let run = count - from;
        values[made..made + run].copy_from_slice(&self.places[from..count]);
        (generator, made + run)
    }

    /// Indices below `count` of the places outside their layers, ascending.
    fn edges(&self, count: usize) -> impl Iterator<Item = usize> + use<> {
        let (masks, mut group) = (self.outside, 0);
        let mut mask = masks[0];
        std::iter::from_fn(move || {
            while mask == 0 {
                group += 1;
                mask = *masks.get(group)?;
            }
            let at = MASK * group + mask.trailing_zeros() as usize;
            mask &= mask - 1;
            (at < count).then_some(at)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::super::xoshiro::{Substreams, Xoshiro256PlusPlus};
    use super::*;

    #[test]
    fn bounds_of_the_density_decide_as_the_density_does() {
        let mut generator = Xoshiro256PlusPlus::new([5, 4, 3, 2]);
        let (mut kept, mut edges) = (0, 0);
        while edges < 200_000 {
            let first = generator.next();
            let (place, inside) = ZIGGURAT.place(first);
            if inside || layer(first) == 0 {
                continue;
            }
            edges += 1;
            let [low, high] = [0, 1].map(|above| ZIGGURAT.y[layer(first) + above]);
            let density = libm::exp(-0.5 * place * place);
            // any word, and those at, near and around the density
            let most = (1_u64 << 53) - 1;
            let at = (((density - low) / (high - low) * most as f64) as u64).min(most);
            let beside = [0, 1 << 8, 1 << 16, 1 << 32]
                .map(|step| [at.saturating_sub(step) << 11, (at + step).min(most) << 11]);
            for second in beside.into_iter().flatten().chain([generator.next()]) {
                let exact = low + (high - low) * uniform(second) < density;
                assert_eq!(ZIGGURAT.keeps(first, second, place), exact, "{first} {second}");
                kept += u32::from(exact);
            }
        }
        assert!((500_000..1_300_000).contains(&kept), "{kept}");
    }

    #[test]
    fn blocks_make_the_numbers_that_are_made_one_by_one() {
        let lengths = [1, 63, 64, 65, 127, 511, 512, 513, 600, 2000, 5000];
        let (mut tails, mut borders) = (0, 0);
        for seed in 0..300 {
            let mut plain = Xoshiro256PlusPlus::new([seed, 1, 2, 3]);
            let (mut blocks, mut substreams) = (plain.clone(), Substreams::of(&plain));
            for length in lengths {
                let [mut found, mut found_many, mut expected] = [(); 3].map(|()| vec![0.0; length]);
                // a block with its last word at an edge
                let mut next = blocks.clone();
                let last = (0..length.min(BLOCK)).map(|_| next.next()).last().unwrap();
                borders += u32::from(!ZIGGURAT.place(last).1);
                blocks = fill(blocks, &mut found);
                fill(&mut substreams, &mut found_many);
                plain = one_by_one(plain, &mut expected);
                let bits = |values: &[f64]| values.iter().map(|x| x.to_bits()).collect::<Vec<_>>();
                assert_eq!(bits(&found), bits(&expected), "seed {seed}, {length} numbers");
                assert_eq!(bits(&found_many), bits(&expected), "seed {seed}, {length} numbers of substreams");
                // and as many words are used
                assert_eq!(blocks, plain, "seed {seed}, {length} numbers");
                tails += expected.iter().filter(|x| x.abs() > TAIL).count();
            }
        }
        assert!(tails > 300 && borders > 10, "{tails} {borders}");
    }
}
