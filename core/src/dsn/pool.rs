//! Pooling: 2x2 maximum behind the stem, global average before the head.
//!
//! TFLite MAX_POOL_2D (2x2, stride 2, VALID) and AVERAGE_POOL_2D over the whole image; scales pass through.

/// The maximum over pairs of columns of two rows: `[width, channels]` twice to `[width / 2, channels]`.
pub fn max_rows(upper: &[i8], lower: &[i8], channels: usize, output: &mut [i8]) {
    let channels = channels.max(1);
    let (mut upper, mut lower) = (upper.chunks_exact(channels), lower.chunks_exact(channels));
    for out in output.chunks_exact_mut(channels) {
        let pixels = (upper.next(), upper.next(), lower.next(), lower.next());
        let (Some(up_left), Some(up_right), Some(low_left), Some(low_right)) = pixels else { return };
        let four = up_left.iter().zip(up_right).zip(low_left.iter().zip(low_right));
        for (out, ((a, b), (c, d))) in out.iter_mut().zip(four) {
            *out = *a.max(b).max(c.max(d));
        }
    }
}

/// The average over all pixels, halves away from zero: `[pixels, channels]` to `[channels]`.
pub fn average(input: &[i8], channels: usize, output: &mut [i8]) {
    let pixels = input.len() / channels.max(1);
    for (c, out) in output.iter_mut().take(channels).enumerate() {
        let sum: i32 = input.iter().skip(c).step_by(channels.max(1)).map(|&x| i32::from(x)).sum();
        *out = mean(sum, pixels);
    }
}

/// `sum / pixels`, halves away from zero.
pub(super) fn mean(sum: i32, pixels: usize) -> i8 {
    let pixels = pixels.max(1) as i32;
    let half = pixels / 2;
    let mean = if sum > 0 { (sum + half) / pixels } else { (sum - half) / pixels };
    mean.clamp(-128, 127) as i8
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn maximum_of_each_square() {
        let mut out = [0; 2];
        max_rows(&[1, -5, 3, -7], &[0, 9, -1, -2], 1, &mut out);
        assert_eq!(out, [9, 3]);
    }

    #[test]
    fn average_rounds_halves_away_from_zero() {
        let mut out = [0; 2];
        average(&[1, -1, 2, -2], 2, &mut out);
        assert_eq!(out, [2, -2]);
    }
}
