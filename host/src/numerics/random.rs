//! Random numbers of a recording: a function of (seed, set, class, index) alone, the same on every machine.
//!
//! [`xoshiro`](super::xoshiro) for bits; Gaussians by the [`ziggurat`].

use super::xoshiro::{Generator, Substreams, Xoshiro256PlusPlus};
use super::ziggurat;
use rand_core::Rng;
use std::f64::consts::FRAC_1_SQRT_2;

/// Gaussians in one call from which on a stream's words are drawn as substreams.
const MANY: usize = 1000;

/// Where words come from.
#[derive(Debug, Clone)]
enum Source {
    One(Xoshiro256PlusPlus),
    /// Many at a time.
    Substreams(Box<Substreams>),
}

/// A seeded stream.
#[derive(Debug, Clone)]
pub struct Random {
    source: Source,
}

impl Random {
    /// The stream of a recording: its set, class and index, each mixed into the seed.
    pub fn new(seed: u64, set: u64, class: u64, index: u64) -> Self {
        let mut state = seed;
        let words = [0x5d, set, class, index].map(|key| {
            // SplitMix64's finaliser
            state = (state ^ key.wrapping_mul(0xd1b5_4a32_d192_ed03)).wrapping_add(0x9e37_79b9_7f4a_7c15);
            let mut z = state;
            z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
            z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
            state = z ^ (z >> 31);
            state
        });
        Random { source: Source::One(Xoshiro256PlusPlus::new(words)) }
    }

    /// Uniform in 0..1.
    pub fn uniform(&mut self) -> f64 {
        ziggurat::uniform(self.bits())
    }

    /// 64 random bits.
    pub fn bits(&mut self) -> u64 {
        match &mut self.source {
            Source::One(generator) => generator.next(),
            Source::Substreams(many) => (&mut **many).next(),
        }
    }

    /// Laplacian with mean 0 and variance 1.
    pub fn laplacian(&mut self) -> f64 {
        let u = 2.0 * self.uniform() - 1.0;
        let size = -FRAC_1_SQRT_2 * libm::log(1.0 - u.abs());
        if u < 0.0 { -size } else { size }
    }

    /// Normal with mean 0 and variance 1.
    #[inline]
    pub fn gaussian(&mut self) -> f64 {
        let mut one = [0.0];
        self.gaussians(&mut one);
        one[0]
    }

    /// Fills with what as many calls of [`Random::gaussian`] draw.
    #[inline]
    pub fn gaussians(&mut self, values: &mut [f64]) {
        match &mut self.source {
            Source::One(generator) if values.len() < MANY => {
                *generator = ziggurat::fill(generator.clone(), values);
            }
            Source::One(generator) => {
                let mut many = Box::new(Substreams::of(generator));
                ziggurat::fill(&mut *many, values);
                self.source = Source::Substreams(many);
            }
            Source::Substreams(many) => {
                ziggurat::fill(&mut **many, values);
            }
        }
    }

    /// Gamma distribution of a shape, with rate 1: Marsaglia and Tsang (2000).
    pub fn gamma(&mut self, shape: f64) -> f64 {
        let raised = if shape < 1.0 { shape + 1.0 } else { shape };
        let d = raised - 1.0 / 3.0;
        let c = 1.0 / (9.0 * d).sqrt();
        let drawn = loop {
            let x = self.gaussian();
            let v = (1.0 + c * x) * (1.0 + c * x) * (1.0 + c * x);
            let u = 1.0 - self.uniform();
            if v > 0.0 && libm::log(u) < 0.5 * x * x + d - d * v + d * libm::log(v) {
                break d * v;
            }
        };
        let lowered = if shape < 1.0 { libm::pow(1.0 - self.uniform(), 1.0 / shape) } else { 1.0 };
        drawn * lowered
    }

    /// Poisson distribution by Knuth's product of uniforms, for means up to some hundred. Cost: O(mean).
    pub fn poisson(&mut self, mean: f64) -> u32 {
        let (least, mut product, mut count) = (libm::exp(-mean), self.uniform(), 0);
        while product > least {
            product *= self.uniform();
            count += 1;
        }
        count
    }
}

/// Normal with mean 0 and variance 1 from any generator, by Box and Muller (1958), the second value left unused. Weights before training
/// are drawn so: the same in every version.
pub fn box_muller(random: &mut impl Rng) -> f64 {
    // in (0, 1], 53 bits
    let mut uniform = || ((random.next_u64() >> 11) + 1) as f64 / (1_u64 << 53) as f64;
    let radius = (-2.0 * libm::log(uniform())).sqrt();
    radius * libm::cos(std::f64::consts::TAU * uniform())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gaussians_have_the_moments_and_tails_of_the_normal_law() {
        let mut random = Random::new(1, 2, 3, 4);
        let n = 2_000_000;
        let (mut m1, mut m2, mut m4, mut beyond) = (0.0, 0.0, 0.0, [0_u32; 4]);
        for _ in 0..n {
            let x = random.gaussian();
            m1 += x;
            m2 += x * x;
            m4 += x * x * x * x;
            for (k, count) in beyond.iter_mut().enumerate() {
                *count += u32::from(x.abs() > 1.0 + k as f64);
            }
        }
        let n = f64::from(n);
        assert!((m1 / n).abs() < 3e-3 && (m2 / n - 1.0).abs() < 4e-3 && (m4 / n - 3.0).abs() < 3e-2);
        // P(|x| > 1, 2, 3, 4)
        for (count, p) in beyond.iter().zip([0.317_310_5, 0.045_500_3, 0.002_699_8, 6.334e-5]) {
            let sigma = (n * p).sqrt();
            assert!((f64::from(*count) - n * p).abs() < 5.0 * sigma, "{count} of {}", n * p);
        }
    }

    #[test]
    fn gamma_and_poisson_have_their_means_and_variances() {
        let mut random = Random::new(1, 2, 3, 5);
        let n = 200_000;
        let mut moments = |draw: &dyn Fn(&mut Random) -> f64| {
            let (mut sum, mut squares) = (0.0, 0.0);
            for _ in 0..n {
                let x = draw(&mut random);
                (sum, squares) = (sum + x, squares + x * x);
            }
            let mean = sum / f64::from(n);
            (mean, squares / f64::from(n) - mean * mean)
        };
        for expected in [0.4, 1.0, 2.5, 12.0] {
            let found = [moments(&|r| r.gamma(expected)), moments(&|r| f64::from(r.poisson(expected)))];
            for (mean, variance) in found {
                assert!((mean / expected - 1.0).abs() < 0.015, "{mean} {expected}");
                assert!((variance / expected - 1.0).abs() < 0.03, "{variance} {expected}");
            }
        }
    }

    #[test]
    fn many_gaussians_at_once_are_those_drawn_one_by_one() {
        let (mut at_once, mut single) = (Random::new(1, 2, 3, 6), Random::new(1, 2, 3, 6));
        for length in [MANY - 1, MANY, 3, 17 * MANY, 1] {
            let mut values = vec![0.0; length];
            at_once.gaussians(&mut values);
            assert!(values.iter().all(|value| value.to_bits() == single.gaussian().to_bits()), "{length}");
            assert_eq!(at_once.bits(), single.bits(), "{length}");
        }
        assert!(matches!((at_once.source, single.source), (Source::Substreams(_), Source::One(_))));
    }

    #[test]
    fn streams_differ_in_every_key() {
        let first = |a, b, c, d| Random::new(a, b, c, d).bits();
        let base = first(1, 0, 0, 0);
        assert_eq!(base, first(1, 0, 0, 0));
        for other in [first(2, 0, 0, 0), first(1, 1, 0, 0), first(1, 0, 1, 0), first(1, 0, 0, 1)] {
            assert_ne!(base, other);
        }
    }
}
