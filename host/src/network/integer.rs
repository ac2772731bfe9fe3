//! An int8 network in TFLite's reference arithmetic, in its plainest form: for the predictor's tests alone.
//!
//! 64-bit sums, no kernels; gemmlowp's double rounding.

use super::float_network::same_padding;
use crate::formats::model_file::{QuantizedLayer, QuantizedNetwork};

/// Rounding doubling high multiplication, then rounding division by a power of two.
fn rescale(acc: i64, multiplier: i32, shift: i8) -> i64 {
    let ab = (acc << shift.max(0)) * i64::from(multiplier);
    let high = (ab + if ab >= 0 { 1 << 30 } else { 1 - (1 << 30) }) / (1 << 31);
    let e = u32::from(shift.min(0).unsigned_abs());
    let (mask, rest) = ((1i64 << e) - 1, high & ((1i64 << e) - 1));
    (high >> e) + i64::from(rest > (mask >> 1) + i64::from(high < 0))
}

impl QuantizedLayer {
    /// An output from its accumulator.
    pub fn out(&self, channel: usize, acc: i64) -> i64 {
        let y = rescale(acc, self.multipliers[channel], self.shifts[channel]) + i64::from(self.out_zero);
        y.clamp(i64::from(self.act_min), i64::from(self.act_max))
    }

    /// 3x3 convolution of `[h][w][i]`.
    fn convolve(&self, x: &[i64], [h, w, inputs]: [usize; 3], stride: usize) -> Vec<i64> {
        let ((out_h, top), (out_w, left)) = (same_padding(h, stride), same_padding(w, stride));
        let mut y = Vec::new();
        for (r, c, o) in (0..out_h)
            .flat_map(|r| (0..out_w).map(move |c| (r, c)))
            .flat_map(|(r, c)| (0..self.biases.len()).map(move |o| (r, c, o)))
        {
            let mut acc = i64::from(self.biases[o]);
            for tap in 0..9 {
                let row = (r * stride + tap / 3).wrapping_sub(top);
                let column = (c * stride + tap % 3).wrapping_sub(left);
                for i in (0..inputs).filter(|_| row < h && column < w) {
                    let v = x[(row * w + column) * inputs + i] - i64::from(self.in_zero);
                    acc += v * i64::from(self.weights[(o * 9 + tap) * inputs + i]);
                }
            }
            y.push(self.out(o, acc));
        }
        y
    }
}

/// Logits of the int8 network.
pub fn infer(n: &QuantizedNetwork, image: &[i8]) -> Vec<f32> {
    let (c, stride) = (n.channels(), usize::from(n.stem_stride));
    let frames = image.len() / 64;
    let x: Vec<i64> = image.iter().map(|&p| i64::from(p)).collect();
    let x = n.stem.convolve(&x, [64, frames, 1], stride);
    let (wide, h, w) = (frames.div_ceil(stride), 64usize.div_ceil(stride) / 2, frames.div_ceil(stride) / 2);
    let mut x: Vec<i64> = (0..h * w * c)
        .map(|k| {
            let (r, col, i) = (k / (w * c), k / c % w, k % c);
            let taps = [(0, 0), (0, 1), (1, 0), (1, 1)];
            taps.map(|(a, b)| x[((2 * r + a) * wide + 2 * col + b) * c + i]).into_iter().max().unwrap()
        })
        .collect();
    for block in &n.blocks {
        let a = &block.affine;
        let t = x.iter().enumerate().map(|(k, v)| {
            let weighted = (v - i64::from(a.in_zero)) * i64::from(a.weights[k % c]);
            a.out(k % c, i64::from(a.biases[k % c]) + weighted)
        });
        let t = block.conv1.convolve(&t.collect::<Vec<_>>(), [h, w, c], 1);
        let t = block.conv2.convolve(&t, [h, w, c], 1);
        let s = &block.add;
        for (x, t) in x.iter_mut().zip(&t) {
            let part = |v: i64, zero: i8, k: usize| {
                rescale((v - i64::from(zero)) << 20, s.multipliers[k], s.shifts[k])
            };
            let sum = part(*x, s.in1_zero, 0) + part(*t, s.in2_zero, 1);
            let y = rescale(sum, s.multipliers[2], s.shifts[2]) + i64::from(s.out_zero);
            *x = y.clamp(i64::from(s.act_min), i64::from(s.act_max));
        }
    }
    let pixels = (h * w) as i64;
    let mean: Vec<i64> = (0..c)
        .map(|i| {
            let sum: i64 = x.iter().skip(i).step_by(c).sum();
            (sum + if sum > 0 { pixels / 2 } else { -(pixels / 2) }) / pixels
        })
        .collect();
    let head = |o: usize| {
        let row = &n.head.weights[o * c..(o + 1) * c];
        let dot: i64 =
            row.iter().zip(&mean).map(|(&w, m)| i64::from(w) * (m - i64::from(n.head.in_zero))).sum();
        let q = n.head.out(o, i64::from(n.head.biases[o]) + dot);
        (q - i64::from(n.head.out_zero)) as f32 * n.head.out_scale
    };
    (0..n.classes.len()).map(head).collect()
}
