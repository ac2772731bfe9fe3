//! From the radar module's network to a `.tflite` graph that computes the same bits.
//!
//! Multipliers become weight scales again: the f32 scale that TensorFlow Lite converts into exactly that multiplier.
//! What another runtime does not need, preprocessing and class names, travels as metadata under [`METADATA`].

use std::borrow::Cow;

use super::graph::{Graph, Operator, Options, Tensor};
use super::schema::{ACTIVATIONS, INT8, INT32, Kind, VALID};
use super::traversal::activation_range;
use super::{TfliteError, require};
use crate::formats::model_file::rescale::{add_ratios, multiplier, weight_scale};
use crate::formats::model_file::{Add, HEADER_BYTES, NAME_BYTES, QuantizedLayer, QuantizedNetwork, ROWS};

/// Name of the metadata: header and class names as in the model file.
pub const METADATA: &str = "sdp3";

/// Writes a network as `.tflite`: int8, per-channel weights, batch of one.
///
/// # Errors
/// A field the format cannot say: a multiplier that comes from no f32 scales, or an activation range that is no
/// fused activation's.
pub fn export(network: &QuantizedNetwork) -> Result<Vec<u8>, TfliteError> {
    let file = network.to_bytes()?;
    let head = HEADER_BYTES + NAME_BYTES * network.classes.len();
    let frames = usize::from(network.preprocessing.frames());
    let stride = usize::from(network.stem_stride);
    let (c, rows) = (network.channels(), usize::from(ROWS));
    let mut g = Builder { tensors: Vec::new(), operators: Vec::new(), shape: [rows, frames, 1] };
    let stem = &network.stem;
    g.activation("image", stem.in_scale, stem.in_zero);
    g.conv("stem", stem, 3, stride)?;
    g.shape = [g.shape[0] / 2, g.shape[1] / 2, c];
    g.pool("pool", Kind::MaxPool, [2; 2], (stem.out_scale, stem.out_zero));
    for (b, block) in network.blocks.iter().enumerate() {
        let name = |layer: &str| format!("block {b} {layer}");
        let skip = g.last();
        g.conv(&name("affine"), &block.affine, 0, 1)?;
        g.conv(&name("conv1"), &block.conv1, 3, 1)?;
        g.conv(&name("conv2"), &block.conv2, 3, 1)?;
        g.add(&name("add"), &block.add, skip)?;
    }
    let window = [g.shape[1] as i32, g.shape[0] as i32];
    g.shape = [1, 1, c];
    let (scale, zero) =
        network.blocks.last().map_or((stem.out_scale, stem.out_zero), |b| (b.add.out_scale, b.add.out_zero));
    g.pool("mean", Kind::AveragePool, window, (scale, zero));
    g.conv("logits", &network.head, 1, 1)?;
    let description = format!("deep spectrogram network, int8, classes: {}", network.classes.join(", "));
    let graph = Graph {
        description,
        inputs: vec![0],
        outputs: vec![g.last()],
        tensors: g.tensors,
        operators: g.operators,
        metadata: vec![(METADATA.to_owned(), Cow::Borrowed(&file[..head]))],
    };
    Ok(graph.to_bytes())
}

/// A chain of operators; the last tensor is the input of the next.
struct Builder<'a> {
    tensors: Vec<Tensor<'a>>,
    operators: Vec<Operator>,
    /// Height, width and channels of the last activation.
    shape: [usize; 3],
}

impl Builder<'_> {
    fn last(&self) -> i32 {
        self.tensors.len() as i32 - 1
    }

    /// Holds the grid a layer reads to the one its input is on.
    fn continues(&self, name: &str, input: i32, scale: f32, zero: i8) -> Result<(), TfliteError> {
        let before = &self.tensors[input as usize];
        let same = before.scales == [scale] && before.zeros == [i64::from(zero)];
        let legal = format!("{:?} and {:?}, the output's of {:?}", before.scales, before.zeros, before.name);
        require(
            same,
            &format!("{name}: scale and zero point of its input"),
            format!("{scale} and {zero}"),
            &legal,
        )
    }

    /// An activation of the present shape.
    fn activation(&mut self, name: &str, scale: f32, zero: i8) -> i32 {
        let [h, w, c] = self.shape;
        self.tensors.push(Tensor {
            name: name.to_owned(),
            shape: [1, h, w, c].map(|n| n as i32).to_vec(),
            kind: INT8,
            data: Cow::Borrowed(&[]),
            scales: vec![scale],
            zeros: vec![zero.into()],
            axis: 0,
        });
        self.last()
    }

    fn constant(
        &mut self,
        name: String,
        shape: Vec<i32>,
        kind: u8,
        data: Vec<u8>,
        scales: Vec<f32>,
        axis: i32,
    ) -> i32 {
        let zeros = vec![0; scales.len()];
        self.tensors.push(Tensor { name, shape, kind, data: Cow::Owned(data), scales, zeros, axis });
        self.last()
    }

    /// A layer with weights; `kernel` 0 is the affine layer, a depthwise convolution.
    fn conv(
        &mut self,
        name: &str,
        layer: &QuantizedLayer,
        kernel: usize,
        stride: usize,
    ) -> Result<(), TfliteError> {
        let input = self.last();
        self.continues(name, input, layer.in_scale, layer.in_zero)?;
        let outputs = layer.biases.len();
        let mut scales = Vec::with_capacity(outputs);
        for (channel, pair) in layer.multipliers.iter().copied().zip(layer.shifts.iter().copied()).enumerate()
        {
            let scale = weight_scale(pair, layer.in_scale, layer.out_scale).ok_or_else(|| {
                TfliteError::value(
                    format!("{name} multiplier of channel {channel}"),
                    format!("{} with shift {}", pair.0, pair.1),
                    "that of an f32 weight scale (quantise the network again)",
                )
            })?;
            scales.push(scale);
        }
        let (kind, k) = if kernel == 0 { (Kind::DepthwiseConv, 1) } else { (Kind::Conv, kernel) };
        let (shape, axis) = match kind {
            Kind::DepthwiseConv => (vec![1, 1, 1, outputs as i32], 3),
            _ => (vec![outputs as i32, k as i32, k as i32, self.shape[2] as i32], 0),
        };
        let data = layer.weights.iter().map(|&w| w as u8).collect();
        let bias_scales = scales.iter().map(|s| layer.in_scale * s).collect();
        let weights = self.constant(format!("{name} weights"), shape, INT8, data, scales, axis);
        let data = layer.biases.iter().flat_map(|b| b.to_le_bytes()).collect();
        let bias = self.constant(format!("{name} bias"), vec![outputs as i32], INT32, data, bias_scales, 0);
        self.shape = [self.shape[0].div_ceil(stride), self.shape[1].div_ceil(stride), outputs];
        let output = self.activation(name, layer.out_scale, layer.out_zero);
        let activation = activation(name, (layer.act_min, layer.act_max), layer.out_scale, layer.out_zero)?;
        let options = Options { stride: [stride as i32; 2], activation, ..Options::NEUTRAL };
        self.operators.push(Operator {
            kind,
            inputs: vec![input, weights, bias],
            outputs: vec![output],
            options,
        });
        Ok(())
    }

    /// A pooling to the present shape.
    fn pool(&mut self, name: &str, kind: Kind, window: [i32; 2], (scale, zero): (f32, i8)) {
        let input = self.last();
        let output = self.activation(name, scale, zero);
        let options = Options { padding: VALID, stride: window, filter: window, ..Options::NEUTRAL };
        self.operators.push(Operator { kind, inputs: vec![input], outputs: vec![output], options });
    }

    /// Skip plus branch, the last activation.
    fn add(&mut self, name: &str, add: &Add, skip: i32) -> Result<(), TfliteError> {
        let branch = self.last();
        self.continues(name, skip, add.in1_scale, add.in1_zero)?;
        self.continues(name, branch, add.in2_scale, add.in2_zero)?;
        let ratios = add_ratios(add.in1_scale, add.in2_scale, add.out_scale);
        for (i, ratio) in ratios.into_iter().enumerate() {
            let (found, expected) = ((add.multipliers[i], add.shifts[i]), multiplier(ratio));
            if expected != Some(found) || ratio >= 1.0 {
                let legal = "below 1 and that of its scales";
                let field = format!("{name} multiplier {i}");
                return Err(TfliteError::value(field, format!("{} with shift {}", found.0, found.1), legal));
            }
        }
        let output = self.activation(name, add.out_scale, add.out_zero);
        let activation = activation(name, (add.act_min, add.act_max), add.out_scale, add.out_zero)?;
        let options = Options { activation, ..Options::NEUTRAL };
        let (inputs, outputs) = (vec![skip, branch], vec![output]);
        self.operators.push(Operator { kind: Kind::Add, inputs, outputs, options });
        Ok(())
    }
}

/// The fused activation with this range of int8 values.
fn activation(name: &str, range: (i8, i8), scale: f32, zero: i8) -> Result<u8, TfliteError> {
    let found = (0..ACTIVATIONS.len() as u8).find(|&a| activation_range(a, scale, zero) == Some(range));
    let legal = "that of NONE, RELU, RELU_N1_TO_1 or RELU6";
    found.ok_or_else(|| {
        TfliteError::value(format!("{name} activation range"), format!("{} to {}", range.0, range.1), legal)
    })
}
