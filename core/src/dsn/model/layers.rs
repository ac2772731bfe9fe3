//! Where each layer lies in a model file, views of them, and the legal range of every field.
//!
//! [`crate::dsn::format`] is the layout.

use super::error::{check, check_multiplier, check_shift};
use super::{HEADER_LEN, Model, ModelError, NAME_LEN};
#[cfg(feature = "graph")]
use crate::dims::ROWS;
use crate::dsn::add::Add;
use crate::dsn::batch_norm::BatchNormRelu;
use crate::dsn::conv::Conv;
use crate::dsn::established;
use crate::dsn::head::Head;
use crate::dsn::per_channel::PerChannelQuant;
#[cfg(feature = "graph")]
use crate::graph::Graph;

/// One residual block.
#[derive(Debug, Clone, Copy)]
pub struct Block<'m> {
    /// The first normalisation, with its ReLU.
    pub batch_norm: BatchNormRelu<'m>,
    /// Both convolutions.
    pub convs: [Conv<'m>; 2],
    /// The skip's addition.
    pub add: Add,
}

/// What begins a layer: kind, zero points of input and output, activation range, second input's zero point, zeros.
const PREFIX: usize = 8;

/// Bytes of an addition: three scales, three multipliers, three shifts and a zero.
const ADD_LEN: usize = PREFIX + 12 + 12 + 4;

/// Bytes before the multipliers of a layer with weights: the scales of input and output.
const QUANT_PREFIX: usize = PREFIX + 8;

/// Bytes of a layer with `taps` weights for each of `channels`.
const fn quant_len(channels: usize, taps: usize) -> usize {
    QUANT_PREFIX + 8 * channels + channels.next_multiple_of(4) + (channels * taps).next_multiple_of(4)
}

const fn block_len(channels: usize) -> usize {
    quant_len(channels, 1) + 2 * quant_len(channels, 9 * channels) + ADD_LEN
}

/// The bytes of a field or a layer.
#[inline(always)]
fn field(bytes: &[u8], at: usize, length: usize) -> &[u8] {
    established(bytes.get(at..at + length))
}

/// The bytes of a field of a constant length.
#[inline(always)]
fn array<const N: usize>(bytes: &[u8], at: usize) -> [u8; N]
where
    [u8; N]: Default,
{
    established(bytes.get(at..).and_then(|rest| rest.first_chunk()).copied())
}

fn view(bytes: &[u8], channels: usize, taps: usize) -> PerChannelQuant<'_> {
    let [_, in_zp, out_zp, act_min, act_max, ..] = array::<PREFIX>(bytes, 0).map(|byte| byte as i8);
    let words = |at: usize| field(bytes, at, 4 * channels).as_chunks().0;
    let (biases, shifts) = (QUANT_PREFIX + 4 * channels, QUANT_PREFIX + 8 * channels);
    PerChannelQuant {
        in_zp,
        out_zp,
        act_min,
        act_max,
        channels,
        multipliers: words(QUANT_PREFIX),
        biases: words(biases),
        shifts: field(bytes, shifts, channels),
        weights: field(bytes, shifts + channels.next_multiple_of(4), channels * taps),
    }
}

fn add(bytes: &[u8]) -> Add {
    let [_, left, out_zp, act_min, act_max, right, ..] = array::<PREFIX>(bytes, 0).map(|byte| byte as i8);
    let multiplier = |k: usize| i32::from_le_bytes(array(bytes, PREFIX + 12 + 4 * k));
    let [s0, s1, out_shift, _] = array::<4>(bytes, PREFIX + 24).map(|byte| byte as i8);
    Add {
        in_zp: [left, right],
        out_zp,
        act_min,
        act_max,
        multiplier: [multiplier(0), multiplier(1)],
        out_multiplier: multiplier(2),
        shift: [s0, s1],
        out_shift,
    }
}

impl<'m> Model<'m> {
    fn stem_at(&self) -> usize {
        HEADER_LEN + NAME_LEN * self.classes()
    }

    fn blocks_at(&self) -> usize {
        self.stem_at() + quant_len(self.channels(), 9)
    }

    /// The head is the last layer.
    fn head_at(&self) -> usize {
        self.content.len().saturating_sub(quant_len(self.classes(), self.channels()))
    }

    /// Bytes that header, names and layers need: the length of a checked model's content.
    pub(super) fn content_len(&self) -> usize {
        let blocks = self.blocks() * block_len(self.channels());
        self.blocks_at() + blocks + quant_len(self.classes(), self.channels())
    }

    /// The input convolution.
    pub fn stem(&self) -> Conv<'m> {
        let quant =
            view(field(self.content, self.stem_at(), quant_len(self.channels(), 9)), self.channels(), 9);
        Conv { quant, inputs: 1, stride: self.stem_stride() }
    }

    /// Residual block `index`; `None` behind the last.
    pub fn block(&self, index: usize) -> Option<Block<'m>> {
        let block = || {
            let convs = [0, 1].map(|k| self.conv(index, k));
            Block { batch_norm: self.batch_norm(index), convs, add: self.add(index) }
        };
        (index < self.blocks()).then(block)
    }

    /// The bytes of residual block `index`, which is below [`Model::blocks`], from `at` on.
    fn block_bytes(&self, index: usize, at: usize) -> &'m [u8] {
        established(self.content.get(self.blocks_at() + index * block_len(self.channels()) + at..))
    }

    /// The first normalisation of block `index`, which is below [`Model::blocks`].
    pub(in crate::dsn) fn batch_norm(&self, index: usize) -> BatchNormRelu<'m> {
        BatchNormRelu { quant: view(self.block_bytes(index, 0), self.channels(), 1) }
    }

    /// Convolution `k`, 0 or 1, of block `index`, which is below [`Model::blocks`].
    pub(in crate::dsn) fn conv(&self, index: usize, k: usize) -> Conv<'m> {
        let c = self.channels();
        let bytes = self.block_bytes(index, quant_len(c, 1) + k * quant_len(c, 9 * c));
        Conv { quant: view(bytes, c, 9 * c), inputs: c, stride: 1 }
    }

    /// The addition of block `index`, which is below [`Model::blocks`].
    pub(in crate::dsn) fn add(&self, index: usize) -> Add {
        let c = self.channels();
        add(self.block_bytes(index, quant_len(c, 1) + 2 * quant_len(c, 9 * c)))
    }

    /// The fully connected layer.
    pub fn head(&self) -> Head<'m> {
        let bytes = field(self.content, self.head_at(), quant_len(self.classes(), self.channels()));
        Head { quant: view(bytes, self.classes(), self.channels()), inputs: self.channels() }
    }

    /// What one step of a logit is worth, in nat.
    pub fn logit_scale(&self) -> f32 {
        #[cfg(feature = "graph")]
        if let Some(graph) = self.graph() {
            return graph.scales()[1];
        }
        f32::from_le_bytes(array(self.content, self.head_at() + PREFIX + 4))
    }

    /// The graph in the layers' place: from the image, in the last bytes of its arena, to the logits.
    #[cfg(feature = "graph")]
    pub(super) fn check_graph(&self) -> Result<Graph<'m>, ModelError> {
        let bytes = self.content.get(self.stem_at()..).unwrap_or(&[]);
        let graph = Graph::parse(bytes)?;
        let (input, output) = (graph.input(), graph.output_tensor());
        check("graph.arena", graph.arena() as i64, graph.arena() == self.arena as usize)?;
        check("graph.input", input.bytes() as i64, input.shape() == [ROWS, self.frames(), 1])?;
        check("graph.input", i64::from(input.at), input.range().end == graph.arena())?;
        check("graph.output", output.bytes() as i64, output.shape() == [1, 1, self.classes()])?;
        Ok(graph)
    }

    /// Holds every layer to its legal ranges, in the file's order.
    pub(super) fn check_layers(&self) -> Result<(), ModelError> {
        let (c, classes) = (self.channels(), self.classes());
        let mut rest = field(self.content, self.stem_at(), self.content_len() - self.stem_at());
        check_quant(&mut rest, 1, c, 9)?;
        for _ in 0..self.blocks() {
            check_quant(&mut rest, 2, c, 1)?;
            check_quant(&mut rest, 1, c, 9 * c)?;
            check_quant(&mut rest, 1, c, 9 * c)?;
            check_add(&mut rest)?;
        }
        check_quant(&mut rest, 4, classes, c)
    }
}

/// Kind, range and zeros; then the scales.
fn check_prefix(bytes: &[u8], kind: u8, scales: &[&'static str]) -> Result<(), ModelError> {
    let [found, _, _, low, high, _, reserved @ ..] = array::<PREFIX>(bytes, 0);
    let reserved = u16::from_le_bytes(reserved);
    check("layer.kind", i64::from(found), found == kind)?;
    check("layer.act_min", i64::from(low as i8), low as i8 <= high as i8)?;
    check("layer.reserved", i64::from(reserved), reserved == 0)?;
    for (k, name) in scales.iter().enumerate() {
        let scale = f32::from_le_bytes(array(bytes, PREFIX + 4 * k));
        check(name, i64::from(scale.to_bits()), scale.is_finite() && scale > 0.0)?;
    }
    Ok(())
}

/// Takes the next bytes.
fn take<'m>(rest: &mut &'m [u8], length: usize) -> &'m [u8] {
    let (taken, left) = established(rest.split_at_checked(length));
    *rest = left;
    taken
}

fn check_quant(rest: &mut &[u8], kind: u8, channels: usize, taps: usize) -> Result<(), ModelError> {
    let bytes = take(rest, quant_len(channels, taps));
    check_prefix(bytes, kind, &["layer.in_scale", "layer.out_scale"])?;
    for multiplier in view(bytes, channels, taps).multipliers {
        check_multiplier("layer.multiplier", i32::from_le_bytes(*multiplier))?;
    }
    // the shifts with the zeros behind them
    let shifts = field(bytes, QUANT_PREFIX + 8 * channels, channels.next_multiple_of(4));
    shifts.iter().try_for_each(|&shift| check_shift("layer.shift", shift as i8))
}

fn check_add(rest: &mut &[u8]) -> Result<(), ModelError> {
    let bytes = take(rest, ADD_LEN);
    check_prefix(bytes, 3, &["add.in1_scale", "add.in2_scale", "add.out_scale"])?;
    let add = add(bytes);
    let [reserved] = array(bytes, ADD_LEN - 1);
    check("add.reserved", i64::from(reserved), reserved == 0)?;
    let mut multipliers = add.multiplier.into_iter().chain([add.out_multiplier]);
    multipliers.try_for_each(|multiplier| check_multiplier("add.multiplier", multiplier))?;
    add.shift.into_iter().chain([add.out_shift]).try_for_each(|shift| check_shift("add.shift", shift))
}
