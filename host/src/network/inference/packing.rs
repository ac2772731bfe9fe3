//! A model's numbers in the order in which the vector kernels read them.
//!
//! The zero point of a layer's input is taken off the biases, so that kernels multiply the inputs as they are. Layers that
//! no vector form covers are not packed: a shift outside -20 to -1, or a sum that could leave +-2^30. Training and
//! TFLite's converter make none.

use super::layer::{OutputGroup, by_winograd};
use super::simd::{I32x16, LANES, MAX_ACCUMULATOR, Requantizer};
use super::winograd_f4;
use sdp3_core::dsn::add::Add;
use sdp3_core::dsn::batch_norm::BatchNormRelu;
use sdp3_core::dsn::conv::Conv;
use sdp3_core::dsn::per_channel::PerChannelQuant;
use std::array::from_fn;

/// Sixteen successive values of a batch normalisation.
#[derive(Debug)]
pub struct ChannelPhase {
    /// What the doubled sums start with.
    pub start: I32x16,
    /// Twice the weights, as i16 with zeros above.
    pub weights: I32x16,
    pub requantizer: Requantizer,
}

/// An addition: its two inputs, with guard bits, and their sum.
#[derive(Debug)]
pub struct PackedAdd {
    pub terms: [PackedTerm; 2],
    pub sum: Requantizer,
}

/// An input of an addition.
#[derive(Debug)]
pub struct PackedTerm {
    /// The zero point with guard bits, negated.
    pub offset: I32x16,
    /// Whether it is exactly halved, as the input of the larger scale is: multiplier 2^30, shift 0.
    pub half: bool,
    /// Of an input that is not halved.
    pub requantizer: Requantizer,
}

/// A convolution, for words of `word_inputs` inputs.
pub fn convolution(conv: &Conv<'_>, word_inputs: usize) -> Option<Vec<OutputGroup>> {
    (0..conv.quant.channels).step_by(LANES).map(|first| output_group(conv, first, word_inputs)).collect()
}

/// The sixteen outputs from `first` on.
fn output_group(conv: &Conv<'_>, first: usize, word_inputs: usize) -> Option<OutputGroup> {
    let (quant, taps) = (&conv.quant, 9 * conv.inputs);
    let lanes = LANES.min(quant.channels - first);
    // four inputs are multiplied as u8 = i8 + 128
    let offset = i32::from(quant.in_zp) + if word_inputs == 4 { 128 } else { 0 };
    let (mut start, mut requantizer) = (I32x16::ZERO, Requantizer::ZERO);
    for lane in 0..lanes {
        let channel = first + lane;
        start.0[lane] = first_sum(quant, channel, &quant.weights[channel * taps..][..taps], offset)?;
        let (multiplier, shift) = quant.scale(channel);
        requantizer.set_lane(lane, multiplier, shift, quant.out_zp)?;
    }
    let weight = |lane: usize, tap: usize| {
        if lane < lanes { i32::from(quant.weights[(first + lane) * taps + tap] as i8) } else { 0 }
    };
    let mut weights = Vec::new();
    if by_winograd(conv.inputs, word_inputs) {
        for point in 0..winograd_f4::POINTS {
            for input in (0..conv.inputs).step_by(2) {
                weights.push(words(2, |lane, k| {
                    let tap = |row, column| weight(lane, (3 * row + column) * conv.inputs + input + k);
                    winograd_f4::transform_weights(&from_fn(|row| from_fn(|column| tap(row, column))), point)
                }));
            }
        }
    } else {
        // the stem's one input has three taps in a row and a fourth of weight zero
        let row = 3 * conv.inputs;
        for ky in 0..3 {
            for tap in (0..row.next_multiple_of(4)).step_by(word_inputs) {
                weights.push(words(word_inputs, |lane, k| {
                    if tap + k < row { weight(lane, ky * row + tap + k) } else { 0 }
                }));
            }
        }
    }
    Some(OutputGroup { first, start, requantizer, weights })
}

/// One word of weights in each lane: two i16 or four i8.
fn words(word_inputs: usize, weight: impl Fn(usize, usize) -> i32) -> I32x16 {
    I32x16(from_fn(|lane| match word_inputs {
        2 => weight(lane, 0) & 0xffff | weight(lane, 1) << 16,
        _ => i32::from_le_bytes(from_fn(|k| weight(lane, k) as u8)),
    }))
}

/// A batch normalisation: phases after which the channels begin at lane 0 again.
pub fn batch_norm(layer: &BatchNormRelu<'_>) -> Option<Vec<ChannelPhase>> {
    let quant = &layer.quant;
    // channels are multiples of four
    let phases = (1..=quant.channels).find(|phases| (phases * LANES).is_multiple_of(quant.channels))?;
    let phase = |phase: usize| {
        let (mut start, mut weights) = (I32x16::ZERO, I32x16::ZERO);
        let mut requantizer = Requantizer::ZERO;
        for lane in 0..LANES {
            let channel = (phase * LANES + lane) % quant.channels;
            start.0[lane] =
                2 * first_sum(quant, channel, &quant.weights[channel..][..1], quant.in_zp.into())?;
            weights.0[lane] = (2 * i32::from(quant.weights[channel] as i8)) & 0xffff;
            let (multiplier, shift) = quant.scale(channel);
            requantizer.set_lane(lane, multiplier, shift, quant.out_zp)?;
        }
        Some(ChannelPhase { start, weights, requantizer })
    };
    (0..phases).map(phase).collect()
}

pub fn add(add: &Add) -> Option<PackedAdd> {
    let requantizer = |multiplier, shift, zero| {
        let mut requantizer = Requantizer::ZERO;
        (0..LANES).try_for_each(|lane| requantizer.set_lane(lane, multiplier, shift, zero))?;
        Some(requantizer)
    };
    let term = |k: usize| {
        let (multiplier, shift) = (add.multiplier[k], add.shift[k]);
        let half = (multiplier, shift) == (1 << 30, 0);
        let guard_bits = if half { 19 } else { 21 }; // what is requantised is doubled
        let offset = I32x16([-(i32::from(add.in_zp[k]) << guard_bits); LANES]);
        let requantizer = if half { Requantizer::ZERO } else { requantizer(multiplier, shift, 0)? };
        Some(PackedTerm { offset, half, requantizer })
    };
    let sum = requantizer(add.out_multiplier, add.out_shift, add.out_zp)?;
    Some(PackedAdd { terms: [term(0)?, term(1)?], sum })
}

/// What the sum of a channel starts with: its bias less `offset` times its weights; `None` if the sum could leave
/// +-[`MAX_ACCUMULATOR`].
fn first_sum(quant: &PerChannelQuant<'_>, channel: usize, weights: &[u8], offset: i32) -> Option<i32> {
    let bias = quant.bias(channel);
    let (mut sum, mut largest) = (0_i64, i64::from(bias).abs());
    for &w in weights {
        sum += i64::from(w as i8);
        largest += 255 * i64::from(w as i8).abs();
    }
    (largest < MAX_ACCUMULATOR).then(|| bias.wrapping_sub(offset.wrapping_mul(sum as i32)))
}
