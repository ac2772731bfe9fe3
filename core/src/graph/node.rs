//! One operator of a graph: a view of its bytes, and the legal range of every field.

use super::dense::Dense;
use super::format::OPERATOR_LEN;
use super::softmax::Softmax;
use crate::dsn::ModelError;
use crate::dsn::add::Add;
use crate::dsn::established;
use crate::dsn::model::error::{check, check_multiplier, check_shift};
use crate::dsn::per_channel::PerChannelQuant;
use core::ops::Range;

/// What an operator does; names and arithmetic are TFLite's. The numbers are the file's.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[repr(u8)]
pub enum Kind {
    /// CONV_2D.
    Convolution = 1,
    /// DEPTHWISE_CONV_2D, with a depth multiplier where it has more outputs than inputs.
    DepthwiseConvolution = 2,
    /// ADD of two tensors of the same shape.
    Add = 3,
    /// MAX_POOL_2D.
    MaxPool = 4,
    /// AVERAGE_POOL_2D.
    AveragePool = 5,
    /// SOFTMAX over the channels.
    Softmax = 6,
    /// FULLY_CONNECTED: a window over the whole input, requantised in f64 as LiteRT does.
    FullyConnected = 7,
}

impl Kind {
    /// All of them.
    pub const ALL: [Kind; 7] = [
        Kind::Convolution,
        Kind::DepthwiseConvolution,
        Kind::Add,
        Kind::MaxPool,
        Kind::AveragePool,
        Kind::Softmax,
        Kind::FullyConnected,
    ];

    fn of(code: u8) -> Option<Kind> {
        Kind::ALL.into_iter().find(|kind| *kind as u8 == code)
    }

    /// Its name in TFLite's schema.
    pub const fn name(self) -> &'static str {
        match self {
            Kind::Convolution => "CONV_2D",
            Kind::DepthwiseConvolution => "DEPTHWISE_CONV_2D",
            Kind::Add => "ADD",
            Kind::MaxPool => "MAX_POOL_2D",
            Kind::AveragePool => "AVERAGE_POOL_2D",
            Kind::Softmax => "SOFTMAX",
            Kind::FullyConnected => "FULLY_CONNECTED",
        }
    }
}

/// An activation: int8, `[height, width, channels]`, at a place of the arena.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Tensor {
    /// Its first byte in the arena.
    pub at: u32,
    /// Rows.
    pub height: u16,
    /// Columns.
    pub width: u16,
    /// Channels, which lie together.
    pub channels: u16,
}

impl Tensor {
    /// Its height, width and channels.
    pub fn shape(&self) -> [usize; 3] {
        [self.height, self.width, self.channels].map(usize::from)
    }

    /// Bytes of it; of a checked graph at most its arena.
    pub fn bytes(&self) -> usize {
        self.shape().into_iter().fold(1, usize::saturating_mul)
    }

    /// Its bytes in the arena.
    pub fn range(&self) -> Range<usize> {
        let at = self.at as usize;
        at..at.saturating_add(self.bytes())
    }

    pub(super) fn fits(&self, arena: u32) -> bool {
        (1..=arena as usize).contains(&self.bytes()) && self.range().end <= arena as usize
    }
}

/// The window of a convolution or a pooling.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Window {
    /// Height and width; zeros for the whole input.
    pub size: [u8; 2],
    /// Strides along the rows and the columns.
    pub stride: [u8; 2],
    /// Rows and columns of padding before the input.
    pub padding: [u8; 2],
}

/// One operator.
#[derive(Debug, Clone, Copy)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Node<'m> {
    /// What it does; `None` only of no bytes.
    pub kind: Option<Kind>,
    /// What it reads.
    pub input: Tensor,
    /// An addition's second input: where it lies.
    pub second: u32,
    /// What it writes.
    pub output: Tensor,
    /// Its window.
    pub window: Window,
    /// Zero points of input, output and an addition's second input.
    pub zero_points: [i8; 3],
    /// Least and largest output.
    pub activation: [i8; 2],
    parameters: &'m [u8],
}

/// A field of a constant length; zeros behind the end.
fn array<const N: usize>(bytes: &[u8], at: usize) -> [u8; N]
where
    [u8; N]: Default,
{
    bytes.get(at..).and_then(|rest| rest.first_chunk()).copied().unwrap_or_default()
}

fn word(bytes: &[u8], at: usize) -> i32 {
    i32::from_le_bytes(array(bytes, at))
}

impl<'m> Node<'m> {
    /// Bytes of the operator that a byte string begins with; `None` if it ends before they are stated.
    pub(super) fn length(bytes: &[u8]) -> Option<usize> {
        let stated = bytes.get(36..OPERATOR_LEN)?.first_chunk()?;
        (u32::from_le_bytes(*stated) as usize).checked_add(OPERATOR_LEN)
    }

    /// Bytes of the operator.
    pub(super) fn bytes(&self) -> usize {
        OPERATOR_LEN + self.parameters.len()
    }

    /// A view of an operator's bytes.
    pub(super) fn view(bytes: &'m [u8]) -> Self {
        let [kind, in_zp, out_zp, low, high, second_zp, h, w, sh, sw, top, left] = array::<12>(bytes, 0);
        let two = |at: usize| u16::from_le_bytes(array(bytes, at));
        let tensor = |place: usize, shape: usize| Tensor {
            at: word(bytes, place) as u32,
            height: two(shape),
            width: two(shape + 2),
            channels: two(shape + 4),
        };
        Node {
            kind: Kind::of(kind),
            input: tensor(24, 12),
            output: tensor(28, 18),
            second: word(bytes, 32) as u32,
            window: Window { size: [h, w], stride: [sh, sw], padding: [top, left] },
            zero_points: [in_zp, out_zp, second_zp].map(|byte| byte as i8),
            activation: [low, high].map(|byte| byte as i8),
            parameters: bytes.get(OPERATOR_LEN..).unwrap_or(&[]),
        }
    }

    /// Height and width of the window in pixels.
    pub fn window_size(&self) -> [usize; 2] {
        let [height, width, _] = self.input.shape();
        let [h, w] = self.window.size.map(usize::from);
        [if h == 0 { height } else { h }, if w == 0 { width } else { w }]
    }

    /// Weights of an output value of a convolution, values of a pooling's window.
    pub fn taps(&self) -> usize {
        let [h, w] = self.window_size();
        match self.kind {
            Some(Kind::Convolution | Kind::FullyConnected) => {
                h.saturating_mul(w).saturating_mul(usize::from(self.input.channels))
            }
            Some(Kind::DepthwiseConvolution | Kind::MaxPool | Kind::AveragePool) => h.saturating_mul(w),
            _ => 1,
        }
    }

    /// Weights of a convolution.
    fn weights(&self) -> usize {
        self.taps().saturating_mul(usize::from(self.output.channels))
    }

    /// Multiply-accumulates of a run; padding counts.
    pub fn products(&self) -> u64 {
        match self.kind {
            Some(Kind::Convolution | Kind::DepthwiseConvolution | Kind::FullyConnected) => {
                (self.output.bytes() as u64).saturating_mul(self.taps() as u64)
            }
            _ => 0,
        }
    }

    /// Weights, biases and scales of a fully connected layer.
    pub fn dense(&self) -> Dense<'m> {
        let channels = usize::from(self.output.channels);
        let field =
            |at: usize, length: usize| established(self.parameters.get(at..at.saturating_add(length)));
        Dense {
            zero_points: [self.zero_points[0], self.zero_points[1]],
            activation: self.activation,
            ratios: field(0, 8 * channels).as_chunks().0,
            biases: field(8 * channels, 4 * channels).as_chunks().0,
            weights: field(12 * channels, self.weights()),
        }
    }

    /// Weights, biases and scales of a convolution.
    pub fn quantization(&self) -> PerChannelQuant<'m> {
        let channels = usize::from(self.output.channels);
        let field =
            |at: usize, length: usize| established(self.parameters.get(at..at.saturating_add(length)));
        let words = |at: usize| field(at, 4 * channels).as_chunks().0;
        PerChannelQuant {
            in_zp: self.zero_points[0],
            out_zp: self.zero_points[1],
            act_min: self.activation[0],
            act_max: self.activation[1],
            channels,
            multipliers: words(0),
            biases: words(4 * channels),
            shifts: field(8 * channels, channels),
            weights: field(8 * channels + channels.next_multiple_of(4), self.weights()),
        }
    }

    /// Scales of an addition.
    pub fn addition(&self) -> Add {
        let [s0, s1, out_shift, _] = array::<4>(self.parameters, 12).map(|byte| byte as i8);
        let [left, out_zp, right] = self.zero_points;
        Add {
            in_zp: [left, right],
            out_zp,
            act_min: self.activation[0],
            act_max: self.activation[1],
            multiplier: [word(self.parameters, 0), word(self.parameters, 4)],
            out_multiplier: word(self.parameters, 8),
            shift: [s0, s1],
            out_shift,
        }
    }

    /// Scale of a softmax.
    pub fn softmax(&self) -> Softmax {
        let [multiplier, shift, least] = [0, 4, 8].map(|at| word(self.parameters, at));
        Softmax { multiplier, shift, least_difference: least }
    }

    /// Where an addition's second input lies.
    pub(super) fn second_range(&self) -> Range<usize> {
        Tensor { at: self.second, ..self.input }.range()
    }

    /// Bytes of the parameters that the kind has.
    fn parameters_len(&self) -> usize {
        let channels = usize::from(self.output.channels);
        match self.kind {
            Some(Kind::Convolution | Kind::DepthwiseConvolution) => {
                let before = 8 * channels + channels.next_multiple_of(4);
                before.saturating_add(self.weights().checked_next_multiple_of(4).unwrap_or(usize::MAX))
            }
            Some(Kind::FullyConnected) => {
                let weights = self.weights().checked_next_multiple_of(4).unwrap_or(usize::MAX);
                weights.saturating_add(12 * channels)
            }
            Some(Kind::Add) => 16,
            Some(Kind::Softmax) => 12,
            _ => 0,
        }
    }

    /// A view of an operator's bytes, with every field in its legal range for an arena of so many bytes.
    pub(super) fn checked(bytes: &'m [u8], arena: u32) -> Result<Self, ModelError> {
        let [code] = array(bytes, 0);
        let node = Self::view(bytes);
        let kind = node.kind.ok_or(ModelError::Field { name: "operator.kind", value: i64::from(code) })?;
        let (input, output) = (node.input, node.output);
        check("operator.input", i64::from(input.at), input.fits(arena))?;
        check("operator.output", i64::from(output.at), output.fits(arena))?;
        let apart =
            |other: Range<usize>| other.end <= output.range().start || output.range().end <= other.start;
        check("operator.output", i64::from(output.at), apart(input.range()))?;
        let [low, high] = node.activation;
        check("operator.act_min", i64::from(low), low <= high)?;
        node.check_shapes(kind)?;
        let (need, have) = (node.parameters_len(), node.parameters.len());
        check("operator.parameters", have as i64, need == have)?;
        match kind {
            Kind::Convolution | Kind::DepthwiseConvolution => {
                let quant = node.quantization();
                for o in 0..quant.channels {
                    let (multiplier, shift) = quant.scale(o);
                    check_multiplier("operator.multiplier", multiplier)?;
                    check_shift("operator.shift", shift)?;
                }
            }
            Kind::Add => {
                let second = Tensor { at: node.second, ..input };
                check(
                    "operator.second",
                    i64::from(node.second),
                    second.fits(arena) && apart(second.range()),
                )?;
                let add = node.addition();
                for (multiplier, shift) in add
                    .multiplier
                    .into_iter()
                    .chain([add.out_multiplier])
                    .zip(add.shift.into_iter().chain([add.out_shift]))
                {
                    check_multiplier("operator.multiplier", multiplier)?;
                    check_shift("operator.shift", shift)?;
                }
            }
            Kind::FullyConnected => node.dense().check()?,
            Kind::Softmax => node.softmax().check(usize::from(output.channels))?,
            Kind::MaxPool | Kind::AveragePool => {}
        }
        let unused = kind != Kind::Add && (node.second != 0 || node.zero_points[2] != 0);
        check("operator.second", i64::from(node.second), !unused)?;
        Ok(node)
    }

    /// Shapes of input and output agree, and every window covers a pixel of the input.
    fn check_shapes(&self, kind: Kind) -> Result<(), ModelError> {
        let ([height, width, channels], [rows, columns, outputs]) = (self.input.shape(), self.output.shape());
        let fits = match kind {
            Kind::Convolution => true,
            Kind::FullyConnected => [rows, columns] == [1, 1] && self.window.size == [0, 0],
            Kind::DepthwiseConvolution => outputs.is_multiple_of(channels),
            Kind::MaxPool | Kind::AveragePool => outputs == channels,
            Kind::Add | Kind::Softmax => [height, width, channels] == [rows, columns, outputs],
        };
        check("operator.channels", outputs as i64, fits)?;
        if matches!(kind, Kind::Add | Kind::Softmax) {
            let none = Window { size: [1; 2], stride: [1; 2], padding: [0; 2] };
            return check("operator.window", 0, self.window == none);
        }
        let [h, w] = self.window_size();
        let Window { stride: [down, right], padding: [top, left], .. } = self.window;
        for (length, out, size, stride, padding) in
            [(height, rows, h, down, top), (width, columns, w, right, left)]
        {
            let (stride, padding) = (usize::from(stride), usize::from(padding));
            check("operator.stride", stride as i64, stride > 0)?;
            check("operator.padding", padding as i64, padding < size)?;
            check("operator.output", out as i64, out.saturating_sub(1) * stride < length + padding)?;
        }
        Ok(())
    }
}
