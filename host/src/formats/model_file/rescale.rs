//! Scale ratios of the int8 network: a real number as multiplier and shift, and the weight scale behind such a pair.
//!
//! TensorFlow Lite's `QuantizeMultiplier`; scales are f32 in every file format, their ratio is taken in f64.

/// `ratio` as a Q31 multiplier and a shift to the left: `ratio = multiplier / 2^31 * 2^shift`.
///
/// Rounded half up; 0 where the ratio is below 2^-32, `None` where it needs a shift above 7 or is no number.
pub fn multiplier(ratio: f64) -> Option<(i32, i8)> {
    if !ratio.is_finite() || ratio < 0.0 {
        return None;
    }
    let (fraction, mut shift) = libm::frexp(ratio);
    let mut q31 = (fraction * f64::from(1u32 << 31) + 0.5).floor() as i64;
    if q31 == 1 << 31 {
        (q31, shift) = (1 << 30, shift + 1);
    }
    match shift {
        ..-31 => Some((0, 0)),
        -31..=7 => Some((q31 as i32, shift as i8)),
        _ => None,
    }
}

/// Ratio of scales of a layer with weights: `in_scale weight_scale / out_scale`.
pub fn ratio(in_scale: f32, weight_scale: f32, out_scale: f32) -> f64 {
    f64::from(in_scale) * f64::from(weight_scale) / f64::from(out_scale)
}

/// The three ratios of an addition of scales `a` and `b` into scale `sum`, with 20 guard bits: skip, branch, sum.
pub fn add_ratios(a: f32, b: f32, sum: f32) -> [f64; 3] {
    let twice = 2.0 * f64::from(a.max(b));
    [f64::from(a) / twice, f64::from(b) / twice, twice / (f64::from(1u32 << 20) * f64::from(sum))]
}

/// Multiplier, shift to the left and least difference of a softmax of logits of so many nat a step, for differences in Q5.26; `None` where a
/// step is at most 2^-26. TensorFlow Lite's `PreprocessSoftmaxScaling` and `CalculateInputRadius`.
pub fn softmax_words(step: f64) -> Option<[i32; 3]> {
    let scaled = Some(step * f64::from(1 << 26)).filter(|scaled| *scaled > 1.0)?;
    let (fraction, mut shift) = libm::frexp(scaled.min(f64::from(i32::MAX)));
    let mut q31 = (fraction * f64::from(1_u32 << 31)).round() as i64;
    if q31 == 1 << 31 {
        (q31, shift) = (1 << 30, shift + 1);
    }
    let least = -(31.0 * f64::from(1 << 26) / libm::exp2(f64::from(shift))).floor();
    Some([q31 as i32, shift, least as i32])
}

/// The f32 weight scale of which the ratio gives exactly `pair`; `None` if no f32 does.
///
/// A multiplier has 31 bits and a scale 24, so only pairs that came from f32 scales have one.
pub fn weight_scale(pair: (i32, i8), in_scale: f32, out_scale: f32) -> Option<f32> {
    let (q31, shift) = pair;
    // any ratio below 2^-32 has the multiplier 0
    let real =
        if q31 == 0 { libm::exp2(-40.0) } else { f64::from(q31) * libm::exp2(f64::from(shift) - 31.0) };
    let near = (real * f64::from(out_scale) / f64::from(in_scale)) as f32;
    let legal =
        |scale: &f32| scale.is_normal() && multiplier(ratio(in_scale, *scale, out_scale)) == Some(pair);
    [near, near.next_down(), near.next_up()].into_iter().find(legal)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn multipliers_are_tflites() {
        // QuantizeMultiplier of TensorFlow Lite: fraction in [0.5, 1) as Q31 and a power of two.
        assert_eq!(multiplier(0.5), Some((1 << 30, 0)));
        assert_eq!(multiplier(1.0), Some((1 << 30, 1)));
        assert_eq!(multiplier(0.75), Some((1_610_612_736, 0)));
        assert_eq!(multiplier(0.1), Some((1_717_986_918, -3)));
        assert_eq!(multiplier(1.0 - 1e-12), Some((1 << 30, 1)), "rounds up to the next power");
        assert_eq!(multiplier(127.9).unwrap().1, 7);
        assert_eq!(multiplier(128.0), None);
        assert_eq!(multiplier(f64::NAN), None);
        assert_eq!(multiplier(libm::exp2(-32.0)), Some((1 << 30, -31)));
        assert_eq!(multiplier(libm::exp2(-33.0)), Some((0, 0)));
    }

    #[test]
    fn softmax_words_are_tflites() {
        // a step of 1/8 nat is 2^23 = 0.5 2^24 in Q5.26; 124 differences of 2^24 stay below 31
        assert_eq!(softmax_words(0.125), Some([1 << 30, 24, -124]));
        assert_eq!(softmax_words(0.1).map(|words| words[1]), Some(23));
        // a step so large that only the largest logit counts
        assert_eq!(softmax_words(1e6), Some([i32::MAX, 31, 0]));
        assert_eq!(
            (softmax_words(libm::exp2(-26.0)), softmax_words(0.0), softmax_words(f64::NAN)),
            (None, None, None)
        );
    }

    #[test]
    fn a_weight_scale_is_found_again_from_its_multiplier() {
        let mut state = 1_u32;
        let mut next = || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            // between 2^-9 and 2
            f32::from_bits(0x3B00_0000 + (state >> 4) % 0x0500_0000)
        };
        for _ in 0..100_000 {
            let (a, w, y) = (next(), next() / 64.0, next());
            let pair = multiplier(ratio(a, w, y)).unwrap();
            let found = weight_scale(pair, a, y).unwrap();
            assert_eq!(multiplier(ratio(a, found, y)), Some(pair));
        }
        assert!(weight_scale((0, 0), 0.1, 0.2).is_some());
        // two f32 scales are 128 steps of the multiplier apart, so that most multipliers have none
        let exact = multiplier(ratio(1.0, 0.7, 1.0)).unwrap();
        assert_eq!(weight_scale((exact.0 + 50, exact.1), 1.0, 1.0), None);
    }
}
