//! The layout of a graph: the operators of any int8 network in the order they run, each with the place of its tensors.
//!
//! Little-endian; every part is a multiple of four bytes. A graph stands in a model file in the place of the layers, or is a file of
//! its own.
//!
//! | header byte | field |
//! |---|---|
//! | 0..4, 4..6, 6..8, 8..12 | `SDPG`, version, number of operators, length with the checksum |
//! | 12..16 | bytes of the arena that holds all activations |
//! | 16..22 | height, width and channels of the input (u16 each) |
//! | 22, 23 | zero point of the input and of the output |
//! | 24..32 | scale of the input and of the output (f32 each) |
//! | 32..36 | where the input lies in the arena |
//! | 36..40 | zeros |
//!
//! Then the operators, then the CRC-32 (IEEE 802.3) of everything before it.
//!
//! | operator byte | field |
//! |---|---|
//! | 0 | [`Kind`](super::Kind) |
//! | 1..6 | zero points of input and output, least and largest output, zero point of an addition's second input |
//! | 6..12 | height and width of the window (zeros: of the input), its strides, rows and columns of padding before the input |
//! | 12..18, 18..24 | height, width, channels of input and output (u16 each) |
//! | 24..36 | where input, output and an addition's second input lie in the arena (u32 each) |
//! | 36..40 | bytes of its parameters |
//! | 40.. | parameters |
//!
//! Parameters of a convolution: multipliers and biases (i32 each, by output channel), shifts (i8), weights (i8):
//! `[output, height, width, input]`, or `[height, width, output]` of a depthwise one; shifts and weights each with zeros up to a
//! multiple of four. Of a fully connected layer: ratios (f64) and biases (i32), weights `[output, input]` with zeros up to a multiple of
//! four. Of an addition: three multipliers (i32: both inputs, sum), three shifts (i8), a zero. Of a softmax: multiplier
//! (i32), shift (i32), least difference (i32). Poolings have none.

/// First bytes of a graph.
pub const MAGIC: [u8; 4] = *b"SDPG";
/// Version of the layout.
pub const VERSION: u16 = 1;
/// Bytes of the header.
pub const HEADER_LEN: usize = 40;
/// Bytes of an operator before its parameters.
pub const OPERATOR_LEN: usize = 40;
/// Most operators.
pub const MAX_OPERATORS: usize = 256;
/// Most bytes of activations.
pub const MAX_ARENA: usize = 1 << 24;
