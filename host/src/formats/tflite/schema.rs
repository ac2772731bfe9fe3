//! Numbers of TensorFlow Lite's schema: codes, field numbers, operator versions.
//!
//! From the public `schema.fbs`; only what the network's operators need.

/// Identifier of a file.
pub const IDENTIFIER: [u8; 4] = *b"TFL3";
/// Version of the schema.
pub const SCHEMA_VERSION: i32 = 3;

/// `TensorType` of float32.
pub const FLOAT32: u8 = 0;
/// `TensorType` of int32.
pub const INT32: u8 = 2;
/// `TensorType` of int8.
pub const INT8: u8 = 9;

/// `Padding`: the output is as large as the input over the stride.
pub const SAME: u8 = 0;
/// `Padding`: only whole windows.
pub const VALID: u8 = 1;

/// Names of `ActivationFunctionType`, by code.
pub const ACTIVATIONS: [&str; 6] = ["NONE", "RELU", "RELU_N1_TO_1", "RELU6", "TANH", "SIGN_BIT"];

/// Name of a `TensorType`.
pub fn type_name(code: u8) -> String {
    let names =
        ["FLOAT32", "FLOAT16", "INT32", "UINT8", "INT64", "STRING", "BOOL", "INT16", "COMPLEX64", "INT8"];
    names.get(usize::from(code)).map_or_else(|| format!("type {code}"), |name| (*name).to_owned())
}

/// Field numbers of the tables.
pub mod slot {
    pub const MODEL_VERSION: usize = 0;
    pub const MODEL_CODES: usize = 1;
    pub const MODEL_SUBGRAPHS: usize = 2;
    pub const MODEL_DESCRIPTION: usize = 3;
    pub const MODEL_BUFFERS: usize = 4;
    pub const MODEL_METADATA: usize = 6;
    /// `OperatorCode`; the code where it is below 127.
    pub const CODE_SMALL: usize = 0;
    pub const CODE_VERSION: usize = 2;
    pub const CODE: usize = 3;
    pub const GRAPH_TENSORS: usize = 0;
    pub const GRAPH_INPUTS: usize = 1;
    pub const GRAPH_OUTPUTS: usize = 2;
    pub const GRAPH_OPERATORS: usize = 3;
    pub const GRAPH_NAME: usize = 4;
    pub const TENSOR_SHAPE: usize = 0;
    pub const TENSOR_TYPE: usize = 1;
    pub const TENSOR_BUFFER: usize = 2;
    pub const TENSOR_NAME: usize = 3;
    pub const TENSOR_QUANTIZATION: usize = 4;
    pub const QUANTIZATION_SCALE: usize = 2;
    pub const QUANTIZATION_ZERO: usize = 3;
    pub const QUANTIZATION_AXIS: usize = 6;
    pub const OPERATOR_CODE: usize = 0;
    pub const OPERATOR_INPUTS: usize = 1;
    pub const OPERATOR_OUTPUTS: usize = 2;
    pub const OPERATOR_OPTIONS_TYPE: usize = 3;
    pub const OPERATOR_OPTIONS: usize = 4;
    /// Factor of a softmax's logits (f32).
    pub const SOFTMAX_BETA: usize = 0;
    pub const BUFFER_DATA: usize = 0;
    /// `Buffer`; data outside of the flatbuffer.
    pub const BUFFER_OFFSET: usize = 1;
    pub const METADATA_NAME: usize = 0;
    pub const METADATA_BUFFER: usize = 1;
}

/// An operator of the network.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    Add,
    AveragePool,
    Conv,
    /// Convolution of each channel by itself.
    DepthwiseConv,
    /// Every value of the input times a weight; not in the paper's network.
    FullyConnected,
    MaxPool,
    /// Other axes of the same values.
    Reshape,
    /// Probabilities.
    Softmax,
}

/// Field numbers of an operator's options; `None` where they have no such field.
#[derive(Clone, Copy)]
pub struct OptionSlots {
    pub activation: usize,
    /// Strides along width and height; padding is number 0 wherever there are strides.
    pub stride: Option<[usize; 2]>,
    /// Window's width and height.
    pub filter: Option<[usize; 2]>,
    pub depth_multiplier: Option<usize>,
    /// Dilation along width and height.
    pub dilation: Option<[usize; 2]>,
}

impl Kind {
    pub const ALL: [Kind; 8] = [
        Kind::Add,
        Kind::AveragePool,
        Kind::Conv,
        Kind::DepthwiseConv,
        Kind::FullyConnected,
        Kind::MaxPool,
        Kind::Reshape,
        Kind::Softmax,
    ];

    pub fn code(self) -> i32 {
        match self {
            Kind::Add => 0,
            Kind::AveragePool => 1,
            Kind::Conv => 3,
            Kind::DepthwiseConv => 4,
            Kind::FullyConnected => 9,
            Kind::MaxPool => 17,
            Kind::Reshape => 22,
            Kind::Softmax => 25,
        }
    }

    /// Its name in the schema.
    pub fn name(self) -> &'static str {
        match self {
            Kind::Add => "ADD",
            Kind::AveragePool => "AVERAGE_POOL_2D",
            Kind::Conv => "CONV_2D",
            Kind::DepthwiseConv => "DEPTHWISE_CONV_2D",
            Kind::FullyConnected => "FULLY_CONNECTED",
            Kind::MaxPool => "MAX_POOL_2D",
            Kind::Reshape => "RESHAPE",
            Kind::Softmax => "SOFTMAX",
        }
    }

    /// First version of the operator that knows int8, per channel where it has weights.
    pub fn version(self) -> i32 {
        match self {
            Kind::Conv | Kind::DepthwiseConv => 3,
            Kind::FullyConnected => 4,
            Kind::Add | Kind::AveragePool | Kind::MaxPool | Kind::Softmax => 2,
            Kind::Reshape => 1,
        }
    }

    /// How many inputs it may have.
    pub fn legal_inputs(self) -> std::ops::RangeInclusive<usize> {
        match self {
            Kind::AveragePool | Kind::MaxPool | Kind::Softmax => 1..=1,
            Kind::Reshape => 1..=2,
            Kind::Add => 2..=2,
            Kind::Conv | Kind::DepthwiseConv | Kind::FullyConnected => 2..=3,
        }
    }

    pub fn options_type(self) -> u8 {
        match self {
            Kind::Conv => 1,
            Kind::DepthwiseConv => 2,
            Kind::AveragePool | Kind::MaxPool => 5,
            Kind::FullyConnected => 8,
            Kind::Add => 11,
            Kind::Reshape => 17,
            Kind::Softmax => 9,
        }
    }

    /// Where its options are; `None` for operators with options that are not needed.
    pub fn option_slots(self) -> Option<OptionSlots> {
        let none =
            OptionSlots { activation: 0, stride: None, filter: None, depth_multiplier: None, dilation: None };
        let strided = OptionSlots { stride: Some([1, 2]), ..none };
        Some(match self {
            Kind::Add | Kind::FullyConnected => none,
            Kind::AveragePool | Kind::MaxPool => {
                OptionSlots { activation: 5, filter: Some([3, 4]), ..strided }
            }
            Kind::Conv => OptionSlots { activation: 3, dilation: Some([4, 5]), ..strided },
            Kind::DepthwiseConv => {
                OptionSlots { activation: 4, depth_multiplier: Some(3), dilation: Some([5, 6]), ..strided }
            }
            Kind::Reshape | Kind::Softmax => return None,
        })
    }
}

/// Name of any `BuiltinOperator`, for messages.
pub fn operator_name(code: i32) -> String {
    let others = [
        (2, "CONCATENATION"),
        (6, "DEQUANTIZE"),
        (14, "LOGISTIC"),
        (18, "MUL"),
        (19, "RELU"),
        (21, "RELU6"),
        (32, "CUSTOM"),
        (34, "PAD"),
        (39, "TRANSPOSE"),
        (40, "MEAN"),
        (41, "SUB"),
        (67, "TRANSPOSE_CONV"),
        (99, "SQUARED_DIFFERENCE"),
        (114, "QUANTIZE"),
        (117, "HARD_SWISH"),
    ];
    let ours = Kind::ALL.map(|kind| (kind.code(), kind.name()));
    let found = ours.iter().chain(&others).find(|(c, _)| *c == code);
    found.map_or_else(|| format!("builtin operator {code}"), |(_, name)| (*name).to_owned())
}
