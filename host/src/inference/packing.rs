//! A model's numbers in the order in which vectors read them.
//!
//! Convolution, per group of sixteen outputs: biases, [`Rescale`], then for each row of the kernel its words. A word
//! holds the weights of two or four successive inputs of a lane's output. The input's zero point is in the bias; where
//! inputs are u8 = i8 + 128, so is the 128. DualMac of inputs in sixteens are packed for [`winograd`] instead:
//! words by point. BatchNormRelu, per phase of sixteen values: biases, weights, [`Rescale`].

use super::winograd;
use crate::dsn::add::Add;
use crate::dsn::batch_norm::BatchNormRelu;
use crate::dsn::conv::Conv;
use crate::dsn::per_channel::PerChannelQuant;
use crate::simd::{LANES, Line, MAX_ACCUMULATOR, Rescale, set_lane};

/// Lines of an addition: two offsets and three [`Rescale`]s.
pub const ADD_LINES: usize = 2 + 15;

/// Vectors after which the channels begin at lane 0 again.
pub const fn phases(channels: usize) -> usize {
    let low = channels & channels.wrapping_neg();
    if channels == 0 || low >= LANES { channels.div_ceil(LANES) } else { channels / low }
}

/// Whether convolutions of pairs with so many inputs are transformed.
pub const fn transforms(inputs: usize) -> bool {
    inputs.is_multiple_of(LANES)
}

/// Whether a term of an addition is exactly one half: multiplier 2^30, shift 0.
pub const fn is_half(multiplier: i32, shift: i8) -> bool {
    multiplier == 1 << 30 && shift == 0
}

/// Fills lines one layer after the other.
pub struct Packer<'a> {
    lines: &'a mut [Line],
    used: usize,
    inputs: usize,
}

impl<'a> Packer<'a> {
    /// Packs for words of `inputs` inputs.
    pub fn new(lines: &'a mut [Line], inputs: usize) -> Self {
        Packer { lines, used: 0, inputs }
    }

    fn push(&mut self, line: Line) -> Option<()> {
        *self.lines.get_mut(self.used)? = line;
        self.used += 1;
        Some(())
    }

    fn push_rescale(&mut self, lines: &Rescale) -> Option<()> {
        lines.iter().try_for_each(|&line| self.push(line))
    }

    /// Runs a layer's packing; forgets what it wrote if it gives up.
    fn layer(&mut self, pack: impl FnOnce(&mut Self) -> Option<()>) -> Option<usize> {
        let start = self.used;
        let done = pack(self);
        if done.is_none() {
            self.used = start;
        }
        done.map(|()| start)
    }

    /// A convolution's lines; `None` if vectors cannot compute it.
    pub fn convolution(&mut self, conv: &Conv<'_>) -> Option<usize> {
        self.layer(|packer| {
            (0..conv.layer.channels.div_ceil(LANES)).try_for_each(|group| packer.group(conv, LANES * group))
        })
    }

    /// Sixteen outputs of a convolution.
    fn group(&mut self, conv: &Conv<'_>, first: usize) -> Option<()> {
        let layer = &conv.layer;
        let taps = 9 * conv.inputs;
        let offset = i32::from(layer.in_zp) + if self.inputs == 4 { 128 } else { 0 };
        let (mut biases, mut rescale) = (Line::ZERO, [Line::ZERO; 5]);
        for (lane, bias) in biases.0.iter_mut().enumerate().take(layer.channels.saturating_sub(first)) {
            let weights = layer.weights.get((first + lane) * taps..)?.get(..taps)?;
            *bias = start(layer, first + lane, weights, offset)?;
            let (multiplier, shift) = layer.scale(first + lane);
            set_lane(&mut rescale, lane, multiplier, shift, layer.out_zp).then_some(())?;
        }
        self.push(biases)?;
        self.push_rescale(&rescale)?;
        if self.inputs == 2 && transforms(conv.inputs) {
            return self.points(conv, first);
        }
        // the stem's one input has three taps in a row and a fourth of weight zero
        let run = (3 * conv.inputs).next_multiple_of(4);
        for word in 0..3 * run / self.inputs {
            let (row, input) = (word * self.inputs / run, word * self.inputs % run);
            let mut line = Line::ZERO;
            for (lane, packed) in line.0.iter_mut().enumerate().take(layer.channels - first) {
                let at = (first + lane) * taps + row * 3 * conv.inputs;
                let weight = |k: usize| {
                    let inside = input + k < 3 * conv.inputs;
                    if inside { layer.weights.get(at + input + k).map_or(0, |&w| w as i8) } else { 0 }
                };
                *packed = if self.inputs == 4 {
                    i32::from_le_bytes([0, 1, 2, 3].map(|k| weight(k) as u8))
                } else {
                    i32::from(weight(0)) & 0xffff | i32::from(weight(1)) << 16
                };
            }
            self.push(line)?;
        }
        Some(())
    }

    /// The weights of sixteen outputs at the points of [`winograd`].
    fn points(&mut self, conv: &Conv<'_>, first: usize) -> Option<()> {
        for point in 0..winograd::POINTS {
            for input in (0..conv.inputs).step_by(2) {
                let mut line = Line::ZERO;
                for (lane, packed) in line.0.iter_mut().enumerate() {
                    let weight = |input: usize| {
                        let at = |tap: usize| ((first + lane) * 9 + tap) * conv.inputs + input;
                        let tap = |tap| conv.layer.weights.get(at(tap)).map_or(0, |&w| i32::from(w as i8));
                        let kernel = [0, 1, 2].map(|row| [0, 1, 2].map(|column| tap(3 * row + column)));
                        winograd::point(&kernel, point)
                    };
                    *packed = weight(input) & 0xffff | weight(input + 1) << 16;
                }
                self.push(line)?;
            }
        }
        Some(())
    }

    /// An affine layer's lines; `None` if vectors cannot compute it.
    pub fn affine(&mut self, affine: &BatchNormRelu<'_>) -> Option<usize> {
        let layer = &affine.layer;
        self.layer(|packer| {
            for phase in 0..phases(layer.channels) {
                let (mut biases, mut weights) = (Line::ZERO, Line::ZERO);
                let mut rescale = [Line::ZERO; 5];
                for (lane, (bias, weight)) in biases.0.iter_mut().zip(&mut weights.0).enumerate() {
                    let channel = (phase * LANES + lane) % layer.channels.max(1);
                    let w = layer.weights.get(channel..)?.get(..1)?;
                    *bias = start(layer, channel, w, i32::from(layer.in_zp))?;
                    *weight = w.first().map_or(0, |&w| i32::from(w as i8));
                    let (multiplier, shift) = layer.scale(channel);
                    set_lane(&mut rescale, lane, multiplier, shift, layer.out_zp).then_some(())?;
                }
                packer.push(biases)?;
                packer.push(weights)?;
                packer.push_rescale(&rescale)?;
            }
            Some(())
        })
    }

    /// An addition's lines; `None` if vectors cannot compute it.
    pub fn add(&mut self, add: &Add) -> Option<usize> {
        self.layer(|packer| {
            let terms = [0, 1].map(|k| (add.zero[k], add.multiplier[k], add.shift[k]));
            for (zero, multiplier, shift) in terms {
                let guard = if is_half(multiplier, shift) { 19 } else { 20 };
                packer.push(Line([-(i32::from(zero) << guard); LANES]))?;
            }
            let [(_, m0, s0), (_, m1, s1)] = terms;
            let sum = (add.out_multiplier, add.out_shift);
            for ((multiplier, shift), zero) in [((m0, s0), 0), ((m1, s1), 0), (sum, add.out_zp)] {
                let mut rescale = [Line::ZERO; 5];
                let unused = zero == 0 && is_half(multiplier, shift);
                for lane in 0..LANES {
                    (unused || set_lane(&mut rescale, lane, multiplier, shift, zero)).then_some(())?;
                }
                packer.push_rescale(&rescale)?;
            }
            Some(())
        })
    }
}

/// What the sum of a channel starts with: its bias less `offset` times its weights; `None` if the sum could leave
/// +-[`MAX_ACCUMULATOR`].
fn start(layer: &PerChannelQuant<'_>, channel: usize, weights: &[u8], offset: i32) -> Option<i32> {
    let bias = layer.bias(channel);
    let (mut sum, mut largest) = (0_i64, i64::from(bias).abs());
    for &w in weights {
        sum += i64::from(w as i8);
        largest += 255 * i64::from(w as i8).abs();
    }
    (largest < MAX_ACCUMULATOR).then(|| bias.wrapping_sub(offset.wrapping_mul(sum as i32)))
}
