//! An addition as one linear form of its inputs, with the same output for every pair of them.
//!
//! TFLite's ADD requantises three times. Its output has 8 bits, so that a single rounding of the whole,
//! `(a x + b y + c) >> shift` in 32 bits, gives the same where a and b are near enough. They are searched for around the
//! ratios of the scales and compared with all 65 536 pairs: c must keep every output on its side of its borders.

use super::simd::{I32x16, LANES};
use sdp3_core::dsn::add::Add;

/// Steps of a and b that are tried around the ratios.
const REACH: i32 = 40;

/// `(a x + b y + c) >> shift` for inputs x and y; the output's range is yet to be kept.
#[derive(Debug)]
pub struct LinearAdd {
    /// a and b.
    pub weights: [I32x16; 2],
    /// c.
    pub start: I32x16,
    /// The shift to the right: the largest for which sums stay below 2^31.
    pub shift: u32,
}

/// The outputs of every x, each with every y, both from -128 up.
fn outputs(add: &Add) -> Vec<i8> {
    let branch: Vec<i8> = (i8::MIN..=i8::MAX).collect();
    let mut out: Vec<i8> = branch.iter().flat_map(|&x| [x; 256]).collect();
    out.chunks_exact_mut(256).for_each(|out| add.forward(out, &branch));
    out
}

/// A pair of inputs and the least or largest that `a x + b y + c` may be there.
type Border = (i64, i64, i64);

/// The least c above all lower borders, or the largest below all upper ones.
fn offsets(borders: &[Border], [a, b]: [i32; 2]) -> impl Iterator<Item = i64> {
    borders.iter().map(move |&(x, y, border)| border - i64::from(a) * x - i64::from(b) * y)
}

/// Of all pairs, those where a form near these weights can miss a border: lower and upper ones. Outputs at an end of the
/// range have no border there.
fn borders(add: &Add, weights: [i32; 2], shift: u32) -> [Vec<Border>; 2] {
    let outputs = outputs(add);
    let pairs = || (-128_i64..128).flat_map(|x| (-128_i64..128).map(move |y| (x, y))).zip(&outputs);
    let border = |out: i8| i64::from(out) << shift;
    let mut low: Vec<_> =
        pairs().filter(|&(_, &out)| out > add.act_min).map(|((x, y), &out)| (x, y, border(out))).collect();
    let mut high: Vec<_> = pairs()
        .filter(|&(_, &out)| out < add.act_max)
        .map(|((x, y), &out)| (x, y, border(out) + (1 << shift) - 1))
        .collect();
    // a step of a weight moves a sum by 128 at most
    let reach = 4 * 128 * i64::from(REACH);
    let most = offsets(&low, weights).max().unwrap_or(i64::MIN);
    let least = offsets(&high, weights).min().unwrap_or(i64::MAX);
    low.retain(|&at| offsets(&[at], weights).all(|c| c >= most - reach));
    high.retain(|&at| offsets(&[at], weights).all(|c| c <= least + reach));
    [low, high]
}

/// The linear form of an addition; `None` if none is near.
pub fn find(add: &Add) -> Option<LinearAdd> {
    let scale =
        |multiplier: i32, shift: i8| f64::from(multiplier) * f64::from(shift).exp2() / f64::from(1_u32 << 31);
    let whole = scale(add.out_multiplier, add.out_shift) * f64::from(1 << 20);
    let ratios = [0, 1].map(|k| whole * scale(add.multiplier[k], add.shift[k]));
    let zeros = add.in_zp.iter().zip(ratios).map(|(&zero, ratio)| f64::from(zero) * ratio).sum::<f64>();
    let largest = 128.0 * (ratios[0] + ratios[1]) + (f64::from(add.out_zp) - zeros).abs() + 1.0;
    let shift = (0..24).rfind(|&shift| largest * f64::from(1 << shift) < f64::from(i32::MAX))?;
    let near = ratios.map(|ratio| (ratio * f64::from(1 << shift)).round() as i32);
    let [lower, upper] = borders(add, near, shift);
    let mut steps: Vec<[i32; 2]> =
        (-REACH..=REACH).flat_map(|a| (-REACH..=REACH).map(move |b| [a, b])).collect();
    steps.sort_by_key(|[a, b]| a.abs() + b.abs());
    let (weights, start) = steps.into_iter().find_map(|[a, b]| {
        let weights = [near[0] + a, near[1] + b];
        let (low, high) = (offsets(&lower, weights).max()?, offsets(&upper, weights).min()?);
        let start = low.midpoint(high);
        let sum = 128 * weights.iter().map(|&w| i64::from(w).abs()).sum::<i64>() + start.abs();
        (low <= high && sum <= i64::from(i32::MAX)).then_some((weights, start as i32))
    })?;
    Some(LinearAdd { weights: weights.map(|w| I32x16([w; LANES])), start: I32x16([start; LANES]), shift })
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand_core::{Rng, SeedableRng};
    use rand_xoshiro::Xoshiro128PlusPlus;

    /// Scales and zero points as quantisation makes them.
    fn random(rng: &mut Xoshiro128PlusPlus) -> Add {
        let mut uniform =
            |low: f64, high: f64| low + (high - low) * f64::from(rng.next_u32()) / f64::from(u32::MAX);
        let [left, right] = [(); 2].map(|()| uniform(-4.0, -2.0).exp());
        let twice = 2.0 * left.max(right);
        let out = twice / 2.0 * uniform(-0.3, 0.5).exp();
        let quantize = |ratio: f64| {
            let exponent = ratio.log2().floor() + 1.0;
            ((ratio / exponent.exp2() * f64::from(1_u32 << 31)) as i32, exponent as i8)
        };
        let scales = [quantize(left / twice), quantize(right / twice)];
        let (out_multiplier, out_shift) = quantize(twice / out / f64::from(1 << 20));
        let act_min = if uniform(0.0, 1.0) < 0.5 { -128 } else { -20 };
        Add {
            in_zp: [(); 2].map(|()| uniform(-128.0, 127.0) as i8),
            out_zp: uniform(-60.0, 60.0) as i8,
            act_min,
            act_max: 127,
            multiplier: scales.map(|(multiplier, _)| multiplier),
            out_multiplier,
            shift: scales.map(|(_, shift)| shift),
            out_shift,
        }
    }

    #[test]
    fn every_pair_has_the_output_of_the_addition() {
        let mut rng = Xoshiro128PlusPlus::seed_from_u64(1);
        for _ in 0..40 {
            let add = random(&mut rng);
            let form = find(&add).expect("a form");
            let [a, b] = form.weights.map(|w| w.0[0]);
            for (pair, out) in (0..).zip(outputs(&add)) {
                let (x, y) = (pair / 256 - 128, pair % 256 - 128);
                let sum = a
                    .checked_mul(x)
                    .and_then(|ax| ax.checked_add(b.checked_mul(y)?)?.checked_add(form.start.0[0]));
                let value = sum.expect("32 bits") >> form.shift;
                assert_eq!(
                    value.clamp(add.act_min.into(), add.act_max.into()),
                    i32::from(out),
                    "{add:?}: {x} + {y}"
                );
            }
        }
    }
}
