//! Global average pooling before the head.
//!
//! TFLite AVERAGE_POOL_2D over the whole image; the scale passes through.

/// The average of some channels over all pixels, halves away from zero: of `[pixels, channels]` those from `first` on.
///
/// `channels`, `first` and the length of `output` are multiples of four. Cost: three instructions a value.
pub fn average(input: &[i8], channels: usize, first: usize, output: &mut [i8]) {
    let pixels = ((input.len() / channels.max(1)) as i32).max(1);
    let ((input, _), (output, _)) = (input.as_chunks::<4>(), output.as_chunks_mut::<4>());
    for (group, out) in output.iter_mut().enumerate() {
        let mut sums = [0; 4];
        for four in input.iter().skip(first / 4 + group).step_by((channels / 4).max(1)) {
            for k in 0..4 {
                sums[k] += i32::from(four[k]);
            }
        }
        *out = sums.map(|sum| {
            let half = if sum > 0 { pixels / 2 } else { -(pixels / 2) };
            ((sum + half) / pixels).clamp(-128, 127) as i8
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn average_rounds_halves_away_from_zero() {
        let input = [1, -1, 7, 0, 9, 9, 127, -128, 2, -2, 8, 0, 8, 9, 127, -128];
        let mut out = [0; 8];
        average(&input, 8, 0, &mut out);
        assert_eq!(out, [2, -2, 8, 0, 9, 9, 127, -128]);
        average(&input, 8, 4, &mut out[..4]);
        assert_eq!(out[..4], [9, 9, 127, -128]);
    }
}
