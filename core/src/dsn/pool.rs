//! Global average pooling before the head.
//!
//! TFLite AVERAGE_POOL_2D over the whole image; the scale passes through.

/// The average of some channels over all pixels, halves away from zero: of `[pixels, channels]` those from `first` on.
pub fn average(input: &[i8], channels: usize, first: usize, output: &mut [i8]) {
    let pixels = (input.len() / channels.max(1)).max(1) as i32;
    for (c, out) in output.iter_mut().enumerate() {
        let sum: i32 = input.iter().skip(first + c).step_by(channels.max(1)).map(|&x| i32::from(x)).sum();
        let half = if sum > 0 { pixels / 2 } else { -(pixels / 2) };
        *out = ((sum + half) / pixels).clamp(-128, 127) as i8;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn average_rounds_halves_away_from_zero() {
        let mut out = [0; 3];
        average(&[1, -1, 7, 2, -2, 8], 3, 0, &mut out);
        assert_eq!(out, [2, -2, 8]);
        average(&[1, -1, 7, 2, -2, 8], 3, 1, &mut out[..1]);
        assert_eq!(out, [-2, -2, 8]);
    }
}
