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
