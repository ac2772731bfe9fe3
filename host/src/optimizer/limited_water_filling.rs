//! Water-filling where a sub-carrier carries a limited number of bits.
//!
//! A sub-carrier of the signal-to-noise ratio x carries f(x) = min(log2(1 + 1 / (1 / x + e^2)), b) bits: e is the transmitter's error
//! vector magnitude, b the largest modulation. f is concave, so the best shares s_m of the power have one multiplier p: a sub-carrier
//! of gamma_m takes s_m with df / ds_m = p, nothing where gamma_m < p, and no more than reaches b. With x = s_m gamma_m this
//! is (1 + (1 + e^2) x) (1 + e^2 x) = gamma_m / p, a quadratic equation; p follows by bisection from sum s_m = 1. Where every
//! sub-carrier reaches b with less than the whole power, the rest is of no use and stays unspent.

use super::water_filling::{self, Allocation};
use crate::numerics::bisection::bisect;

/// What limits the bits of a sub-carrier.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Limits {
    /// Square of the error vector magnitude; 0: an ideal transmitter.
    pub error: f64,
    /// Bits of the largest modulation; infinite: no limit.
    pub modulation_bit: f64,
}

/// Share of the modulation's bits from which on a sub-carrier counts as full.
const FULL: f64 = 1.0 - 1e-9;

impl Limits {
    /// No limits.
    pub const NONE: Limits = Limits { error: 0.0, modulation_bit: f64::INFINITY };

    /// Bits in a symbol at the signal-to-noise ratio `snr`.
    pub fn bits(&self, snr: f64) -> f64 {
        let found = libm::log2(1.0 + snr / (1.0 + self.error * snr));
        // at the ratio that is enough, the logarithm rounds to either side
        if snr >= self.enough() { self.modulation_bit } else { found.min(self.modulation_bit) }
    }

    /// The signal-to-noise ratio beyond which nothing is gained; infinite where the error keeps below the modulation's bits.
    pub fn enough(&self) -> f64 {
        let wanted = libm::exp2(self.modulation_bit) - 1.0;
        let left = 1.0 - self.error * wanted;
        if wanted.is_finite() && left > 0.0 { wanted / left } else { f64::INFINITY }
    }

    /// Whether a sub-carrier with these bits carries the most that the modulation lets it.
    pub fn full(&self, bits: f64) -> bool {
        bits >= self.modulation_bit * FULL
    }

    /// The signal-to-noise ratio at which another share of the power is worth its multiplier, `ratio` = gamma / p.
    fn worth(&self, ratio: f64) -> f64 {
        if ratio <= 1.0 {
            return 0.0;
        }
        // a e^2 x^2 + (a + e^2) x - (ratio - 1) = 0 with a = 1 + e^2, without cancellation
        let a = 1.0 + self.error;
        let root = (1.0 + 4.0 * a * self.error * ratio).sqrt();
        (2.0 * (ratio - 1.0) / (a + self.error + root)).min(self.enough())
    }
}

/// `gamma`: signal-to-noise ratio of each sub-carrier if it had all the power. Zero and negative ones get nothing.
pub fn allocate(gamma: &[f64], limits: Limits) -> Allocation {
    if limits == Limits::NONE {
        return water_filling::allocate(gamma);
    }
    let most = limits.enough();
    let positive = || gamma.iter().copied().filter(|&g| g > 0.0);
    let spent = |multiplier: f64| positive().map(|g| limits.worth(g / multiplier) / g).sum::<f64>();
    let multiplier = match positive().map(|g| most / g).sum::<f64>() {
        all if all <= 1.0 => 0.0,
        _ => multiplier(positive().fold(0.0, f64::max), spent),
    };
    let share = |g: f64| match g > 0.0 {
        false => 0.0,
        true if multiplier == 0.0 => most / g,
        true => limits.worth(g / multiplier) / g,
    };
    let shares: Vec<f64> = gamma.iter().map(|&g| share(g)).collect();
    let rate_bit = shares.iter().zip(gamma).map(|(s, g)| limits.bits(s * g.max(0.0))).sum();
    Allocation { shares, rate_bit }
}

/// The least multiplier at which no more than the whole power is spent; at `high` nothing is.
fn multiplier(mut high: f64, spent: impl Fn(f64) -> f64) -> f64 {
    let mut low = high / 16.0;
    while spent(low) <= 1.0 {
        (low, high) = (low / 16.0, low);
    }
    bisect(low, high, |multiplier| spent(multiplier) > 1.0).1
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numerics::random::Random;

    /// Signal-to-noise ratios spread over 50 dB.
    fn channels(random: &mut Random, most: u64) -> Vec<f64> {
        let m = 1 + (random.bits() % most) as usize;
        (0..m).map(|_| libm::exp(4.0 + 3.0 * random.gaussian())).collect()
    }

    fn limits(random: &mut Random) -> Limits {
        let percent = [0.0, 3.5, 8.0, 17.5, 40.0][(random.bits() % 5) as usize];
        let bits = [1.0, 2.0, 4.0, 6.0, 8.0, f64::INFINITY][(random.bits() % 6) as usize];
        Limits { error: percent * percent / 1e4, modulation_bit: bits }
    }

    /// The best rate over shares of `1 / STEPS` of the power, each spent where it adds most: exact on that grid, the rate being concave
    /// in every share. The true optimum is at least that.
    fn in_steps(gamma: &[f64], limits: Limits, steps: u32) -> f64 {
        let mut spent = vec![0_u32; gamma.len()];
        let bits = |m: usize, n: u32| limits.bits(gamma[m] * f64::from(n) / f64::from(steps));
        for _ in 0..steps {
            let gain = |m: usize| bits(m, spent[m] + 1) - bits(m, spent[m]);
            let best = (0..gamma.len()).max_by(|&i, &j| gain(i).total_cmp(&gain(j))).unwrap();
            spent[best] += 1;
        }
        (0..gamma.len()).map(|m| bits(m, spent[m])).sum()
    }

    #[test]
    fn no_division_of_the_power_in_small_steps_is_better() {
        let mut random = Random::new(81, 0, 0, 0);
        for _ in 0..150 {
            let (gamma, limits) = (channels(&mut random, 6), limits(&mut random));
            let found = allocate(&gamma, limits);
            let power: f64 = found.shares.iter().sum();
            assert!(found.shares.iter().all(|s| *s >= 0.0) && power <= 1.0 + 1e-9, "{power}");
            let brute = in_steps(&gamma, limits, 4000);
            assert!(found.rate_bit >= brute - 1e-9, "{} {brute} {gamma:?} {limits:?}", found.rate_bit);
            // a step of the power is worth at most its multiplier everywhere: the grid comes as near
            assert!(found.rate_bit <= brute * 1.01 + 0.01, "{} {brute} {gamma:?} {limits:?}", found.rate_bit);
        }
    }

    #[test]
    fn every_sub_carrier_has_the_same_multiplier_or_a_reason() {
        let mut random = Random::new(82, 0, 0, 0);
        for _ in 0..300 {
            let (gamma, limits) = (channels(&mut random, 60), limits(&mut random));
            let Allocation { shares, .. } = allocate(&gamma, limits);
            let e = limits.error;
            let slope = |s: f64, g: f64| g / ((1.0 + (1.0 + e) * s * g) * (1.0 + e * s * g));
            let full = |s: f64, g: f64| limits.full(limits.bits(s * g));
            let inner: Vec<f64> = shares
                .iter()
                .zip(&gamma)
                .filter(|(s, g)| **s > 0.0 && !full(**s, **g))
                .map(|(s, g)| slope(*s, *g))
                .collect();
            let (low, high) = inner.iter().fold((f64::INFINITY, 0.0), |(l, h), &p| (p.min(l), p.max(h)));
            let spent = shares.iter().sum::<f64>();
            if inner.is_empty() {
                assert!(shares.iter().zip(&gamma).all(|(s, g)| full(*s, *g) || slope(0.0, *g) > 0.0));
                continue;
            }
            assert!((spent - 1.0).abs() < 1e-9 && high / low < 1.0 + 1e-6, "{spent} {low} {high}");
            for (s, g) in shares.iter().zip(&gamma) {
                // what has nothing would be worth less than the multiplier, what is full still more
                assert!(*s > 0.0 || *g <= high * (1.0 + 1e-6));
                assert!(!full(*s, *g) || slope(*s, *g) >= low * (1.0 - 1e-6));
            }
        }
    }

    #[test]
    fn without_limits_it_is_water_filling_to_the_bit() {
        let mut random = Random::new(83, 0, 0, 0);
        for _ in 0..100 {
            let gamma = channels(&mut random, 40);
            let exact = water_filling::allocate(&gamma);
            assert_eq!(allocate(&gamma, Limits::NONE), exact);
            // a limit that is never reached changes no more than roundings
            let far = allocate(&gamma, Limits { error: 0.0, modulation_bit: 60.0 });
            assert!((far.rate_bit / exact.rate_bit - 1.0).abs() < 1e-12);
            far.shares.iter().zip(&exact.shares).for_each(|(a, b)| assert!((a - b).abs() < 1e-12));
        }
    }

    #[test]
    fn the_rate_grows_with_the_modulation_and_falls_with_the_error() {
        let mut random = Random::new(84, 0, 0, 0);
        for _ in 0..50 {
            let gamma = channels(&mut random, 40);
            let rate =
                |error: f64, modulation_bit| allocate(&gamma, Limits { error, modulation_bit }).rate_bit;
            let rise = [1.0, 2.0, 4.0, 6.0, 8.0, 10.0, f64::INFINITY];
            for error in [0.0, 1e-3, 0.1] {
                for pair in rise.windows(2) {
                    let (less, more) = (rate(error, pair[0]), rate(error, pair[1]));
                    assert!(
                        less <= more * (1.0 + 1e-9) && less <= pair[0] * gamma.len() as f64 * (1.0 + 1e-9)
                    );
                }
            }
            for modulation_bit in rise {
                for pair in [0.0, 1e-4, 1e-2, 0.25].windows(2) {
                    assert!(rate(pair[1], modulation_bit) <= rate(pair[0], modulation_bit) * (1.0 + 1e-9));
                }
            }
        }
    }

    #[test]
    fn full_sub_carriers_leave_their_power_unspent() {
        // 256-QAM with an EVM of 3.5 %: 255 / (1 - 0.0035^0.. 255) is the ratio that is enough
        let limits = Limits { error: 0.035 * 0.035, modulation_bit: 8.0 };
        let enough = 255.0 / (1.0 - 0.035 * 0.035 * 255.0);
        assert!((limits.enough() / enough - 1.0).abs() < 1e-12);
        let found = allocate(&[10.0 * enough, 40.0 * enough, 0.0], limits);
        assert!((found.rate_bit - 16.0).abs() < 1e-9);
        assert!((found.shares[0] - 0.1).abs() < 1e-12 && (found.shares[1] - 0.025).abs() < 1e-12);
        assert_eq!(found.shares[2], 0.0);
        // an error of 10 % keeps below 6.66 bit whatever the power: 256-QAM is never full
        let rough = Limits { error: 0.01, modulation_bit: 8.0 };
        assert_eq!(rough.enough(), f64::INFINITY);
        let found = allocate(&[1e9], rough);
        assert!((found.rate_bit - libm::log2(101.0)).abs() < 1e-6 && (found.shares[0] - 1.0).abs() < 1e-9);
    }
}
