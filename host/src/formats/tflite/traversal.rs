//! One step through a `.tflite` graph: an operator that must be the network's at that place, as a layer.
//!
//! Shapes are followed from the image on, whatever the file says of its activations, as TensorFlow Lite does.

use super::graph::{Graph, Operator, Tensor};
use super::schema::{self, ACTIVATIONS, INT8, INT32, Kind, SAME, VALID};
use super::{TfliteError, require};
use crate::formats::model_file::rescale::{add_ratios, multiplier, ratio};
use crate::formats::model_file::{Add, QuantizedLayer};

/// Smallest and largest int8 value a fused activation lets pass; `None` for one the radar module does not have.
pub fn activation_range(activation: u8, scale: f32, zero: i8) -> Option<(i8, i8)> {
    // halves away from zero, saturating: TensorFlow Lite's CalculateActivationRangeQuantized
    let at = |real: f32| (f32::from(zero) + (real / scale).round()).clamp(-128.0, 127.0) as i8;
    match activation {
        0 => Some((-128, 127)),
        1 => Some((at(0.0), 127)),
        2 => Some((at(-1.0), at(1.0))),
        3 => Some((at(0.0), at(6.0))),
        _ => None,
    }
}

/// The one scale and zero point of an int8 activation.
pub fn grid(tensor: &Tensor<'_>) -> Result<(f32, i8), TfliteError> {
    let field = |what: &str| format!("tensor {:?}: {what}", tensor.name);
    require(tensor.kind == INT8, &field("type"), schema::type_name(tensor.kind), "INT8")?;
    require(tensor.data.is_empty(), &field("data"), format!("{} bytes", tensor.data.len()), "absent")?;
    let ([scale], [zero]) = (&tensor.scales[..], &tensor.zeros[..]) else {
        return Err(TfliteError::value(field("number of scales"), tensor.scales.len(), "1"));
    };
    require(scale.is_normal() && *scale > 0.0, &field("scale"), scale, "finite and above 0")?;
    let zero =
        i8::try_from(*zero).map_err(|_| TfliteError::value(field("zero point"), zero, "-128 to 127"))?;
    Ok((*scale, zero))
}

impl<'a> Graph<'a> {
    /// A tensor by its index.
    pub fn tensor(&self, index: i32, field: &str) -> Result<&Tensor<'a>, TfliteError> {
        let tensors = &self.tensors;
        let found = usize::try_from(index).ok().and_then(|i| tensors.get(i));
        found.ok_or_else(|| {
            TfliteError::value(format!("{field}: tensor"), index, format!("0..{}", tensors.len()))
        })
    }

    /// Biases in steps of the accumulator; zeros where there are none.
    pub fn biases(
        &self,
        index: i32,
        name: &str,
        outputs: usize,
        in_scale: f32,
        scales: &[f32],
    ) -> Result<Vec<i32>, TfliteError> {
        if index == -1 {
            return Ok(vec![0; outputs]);
        }
        let (bias, field) = (self.tensor(index, name)?, |what: &str| format!("{name}: bias: {what}"));
        require(bias.kind == INT32, &field("type"), schema::type_name(bias.kind), "INT32")?;
        require(
            bias.data.len() == 4 * outputs,
            &field("bytes"),
            bias.data.len(),
            &(4 * outputs).to_string(),
        )?;
        require(bias.zeros.iter().all(|&z| z == 0), &field("zero points"), format!("{:?}", bias.zeros), "0")?;
        if bias.scales.len() == outputs {
            for (&found, &scale) in bias.scales.iter().zip(scales) {
                let step = f64::from(in_scale) * f64::from(scale);
                let near = (f64::from(found) - step).abs() <= 1e-3 * step + f64::from(f32::MIN_POSITIVE);
                let legal = format!("{step:e}, input scale times weight scale");
                require(near, &field("scale"), format!("{found:e}"), &legal)?;
            }
        }
        let (words, _) = bias.data.as_chunks::<4>();
        Ok(words.iter().map(|w| i32::from_le_bytes(*w)).collect())
    }
}

/// Where the traversal of the graph is.
pub struct Traversal<'g, 'a> {
    pub graph: &'g Graph<'a>,
    pub next: usize,
    /// The activation the next operator must read.
    pub x: i32,
    /// Its height, width and channels.
    pub shape: [usize; 3],
}

impl<'g, 'a> Traversal<'g, 'a> {
    /// What the next operator is.
    pub fn upcoming(&self) -> Option<Kind> {
        self.graph.operators.get(self.next).map(|o| o.kind)
    }

    /// The next operator, which must be of this kind; its output becomes the activation.
    fn take(&mut self, name: &str, kind: Kind) -> Result<(&'g Operator, (f32, i8)), TfliteError> {
        let field = format!("operator {} ({name})", self.next);
        let Some(operator) = self.graph.operators.get(self.next) else {
            return Err(TfliteError::value(field, "missing", kind.name()));
        };
        require(operator.kind == kind, &field, operator.kind.name(), kind.name())?;
        let [output] = operator.outputs[..] else {
            return Err(TfliteError::value(
                format!("{field}: number of outputs"),
                operator.outputs.len(),
                "1",
            ));
        };
        let grid = grid(self.graph.tensor(output, &field)?)?;
        (self.next, self.x) = (self.next + 1, output);
        Ok((operator, grid))
    }

    /// An operator that changes no answer.
    pub fn pass(&mut self, name: &str) -> Result<(), TfliteError> {
        let operator = &self.graph.operators[self.next];
        let field = format!("operator {} ({name})", self.next);
        let first = operator.inputs.first().copied().unwrap_or(-1);
        let legal = format!("{}, the tensor before", self.x);
        require(first == self.x, &format!("{field}: input"), first, &legal)?;
        let [output] = operator.outputs[..] else {
            return Err(TfliteError::value(
                format!("{field}: number of outputs"),
                operator.outputs.len(),
                "1",
            ));
        };
        (self.next, self.x) = (self.next + 1, output);
        Ok(())
    }

    /// A layer with weights `[O][k][k][I]`, or `[1][1][1][O]` of a depthwise one; also its stride.
    pub fn conv(&mut self, name: &str, kind: Kind, k: usize) -> Result<(QuantizedLayer, usize), TfliteError> {
        let (in_scale, in_zero) = grid(self.graph.tensor(self.x, name)?)?;
        let (input, inputs) = (self.x, self.shape[2]);
        let (operator, (out_scale, out_zero)) = self.take(name, kind)?;
        let field = |what: &str| format!("{name}: {what}");
        let (&[first, weights], bias) = match operator.inputs.split_first_chunk::<2>() {
            Some((both, rest)) => (both, rest.first().copied().unwrap_or(-1)),
            None => {
                return Err(TfliteError::value(field("number of inputs"), operator.inputs.len(), "2 or 3"));
            }
        };
        require(first == input, &field("input"), first, &format!("{input}, the tensor before"))?;
        let o = operator.options;
        let stem = name == "stem";
        let fits = o.stride[0] == o.stride[1] && (o.stride[0] == 1 || (stem && o.stride[0] == 2));
        require(
            fits,
            &field("stride"),
            format!("{:?}", o.stride),
            if stem { "[1, 1] or [2, 2]" } else { "[1, 1]" },
        )?;
        require(k == 1 || o.padding == SAME, &field("padding"), o.padding, "0, SAME")?;
        require(o.dilation == [1; 2], &field("dilation"), format!("{:?}", o.dilation), "[1, 1]")?;
        require(o.depth_multiplier == 1, &field("depth multiplier"), o.depth_multiplier, "1")?;
        let stride = o.stride[0] as usize;

        let weights = self.graph.tensor(weights, name)?;
        let shape: Vec<usize> = weights.shape.iter().map(|&n| usize::try_from(n).unwrap_or(0)).collect();
        let (outputs, expected, axis) = match (kind, &shape[..]) {
            (Kind::DepthwiseConv, _) => (inputs, vec![1, 1, 1, inputs], 3),
            (_, &[outputs, ..]) if (1..=MOST_CHANNELS).contains(&outputs) => {
                (outputs, vec![outputs, k, k, inputs], 0)
            }
            _ => (0, vec![0, k, k, inputs], 0),
        };
        let legal = match outputs {
            0 => format!("[1 to {MOST_CHANNELS}, {k}, {k}, {inputs}]"),
            _ => format!("{expected:?}"),
        };
        require(
            outputs > 0 && shape == expected,
            &field("shape of the weights"),
            format!("{:?}", weights.shape),
            &legal,
        )?;
        let scales = per_channel(weights, &field("weights"), outputs, axis)?;
        let count = expected.iter().product::<usize>();
        let bytes = weights.data.len();
        require(bytes == count, &field("bytes of the weights"), bytes, &count.to_string())?;
        let biases = self.graph.biases(bias, name, outputs, in_scale, scales)?;

        let mut layer = QuantizedLayer {
            in_scale,
            out_scale,
            in_zero,
            out_zero,
            act_min: 0,
            act_max: 0,
            multipliers: Vec::with_capacity(outputs),
            shifts: Vec::with_capacity(outputs),
            biases,
            weights: weights.data.iter().map(|&w| w as i8).collect(),
        };
        (layer.act_min, layer.act_max) = range(name, o.activation, out_scale, out_zero)?;
        for (channel, (&scale, kernel)) in
            scales.iter().zip(layer.weights.chunks_exact(count / outputs)).enumerate()
        {
            let at = |what: &str| format!("{name}: channel {channel}: {what}");
            let ratio = ratio(in_scale, scale, out_scale);
            let pair = multiplier(ratio);
            let (m, shift) =
                pair.ok_or_else(|| TfliteError::value(at("ratio of scales"), ratio, "below 128"))?;
            let sum: i64 = kernel.iter().map(|&w| i64::from(w).abs()).sum();
            let largest = 255 * sum + i64::from(layer.biases[channel]).abs();
            let limit = 1_i64 << (31 - shift.max(0));
            require(largest < limit, &at("largest accumulator"), largest, &format!("below {limit}"))?;
            layer.multipliers.push(m);
            layer.shifts.push(shift);
        }
        self.shape = [self.shape[0].div_ceil(stride), self.shape[1].div_ceil(stride), outputs];
        Ok((layer, stride))
    }

    /// A pooling, of 2x2 pixels or over the whole image.
    pub fn pool(&mut self, name: &str, kind: Kind) -> Result<(), TfliteError> {
        let (input, [h, w, c]) = (self.x, self.shape);
        let before = grid(self.graph.tensor(input, name)?)?;
        let (operator, after) = self.take(name, kind)?;
        let field = |what: &str| format!("{name}: {what}");
        require(
            operator.inputs == [input],
            &field("inputs"),
            format!("{:?}", operator.inputs),
            &format!("[{input}]"),
        )?;
        require(
            before == after,
            &field("scale and zero point"),
            format!("{after:?}"),
            &format!("{before:?}, the input's"),
        )?;
        let o = operator.options;
        let window = if kind == Kind::MaxPool { [2; 2] } else { [w as i32, h as i32] };
        require(o.filter == window, &field("window"), format!("{:?}", o.filter), &format!("{window:?}"))?;
        let whole = kind == Kind::MaxPool && h % 2 == 0 && w % 2 == 0;
        require(
            o.padding == VALID || (whole && o.padding == SAME),
            &field("padding"),
            o.padding,
            "1, VALID",
        )?;
        let steps = kind != Kind::MaxPool || o.stride == window;
        require(steps, &field("stride"), format!("{:?}", o.stride), &format!("{window:?}"))?;
        let everything = range(name, o.activation, after.0, after.1)? == (-128, 127);
        require(everything, &field("activation"), ACTIVATIONS[usize::from(o.activation)], "NONE")?;
        self.shape = if kind == Kind::MaxPool { [h / 2, w / 2, c] } else { [1, 1, c] };
        Ok(())
    }

    /// The sum of the skip and the activation before, in either order.
    pub fn add(&mut self, name: &str, skip: i32) -> Result<Add, TfliteError> {
        let branch = self.x;
        let ((in1_scale, in1_zero), (in2_scale, in2_zero)) =
            (grid(self.graph.tensor(skip, name)?)?, grid(self.graph.tensor(branch, name)?)?);
        let (operator, (out_scale, out_zero)) = self.take(name, Kind::Add)?;
        let inputs = &operator.inputs[..];
        let both = inputs == [skip, branch] || inputs == [branch, skip];
        let legal = format!("[{skip}, {branch}], the block's input and its branch");
        require(both, &format!("{name}: inputs"), format!("{inputs:?}"), &legal)?;
        let mut pairs = [(0, 0); 3];
        for (pair, ratio) in pairs.iter_mut().zip(add_ratios(in1_scale, in2_scale, out_scale)) {
            let found = multiplier(ratio).filter(|_| ratio < 1.0);
            *pair = found
                .ok_or_else(|| TfliteError::value(format!("{name}: ratio of scales"), ratio, "below 1"))?;
        }
        let (act_min, act_max) = range(name, operator.options.activation, out_scale, out_zero)?;
        let (multipliers, shifts) = (pairs.map(|p| p.0), pairs.map(|p| p.1));
        Ok(Add {
            in1_scale,
            in2_scale,
            out_scale,
            in1_zero,
            in2_zero,
            out_zero,
            act_min,
            act_max,
            multipliers,
            shifts,
        })
    }
}

/// Most output channels of a layer: the radar module's limit.
const MOST_CHANNELS: usize = sdp3_core::dsn::conv::MAX_CHANNELS;

/// Scales of int8 weights, one per output channel, zero points 0.
fn per_channel<'t>(
    tensor: &'t Tensor<'_>,
    field: &str,
    outputs: usize,
    axis: i32,
) -> Result<&'t [f32], TfliteError> {
    require(tensor.kind == INT8, &format!("{field}: type"), schema::type_name(tensor.kind), "INT8")?;
    let (scales, legal) = (&tensor.scales[..], format!("{outputs}, one per output channel"));
    require(scales.len() == outputs, &format!("{field}: number of scales"), scales.len(), &legal)?;
    require(tensor.axis == axis, &format!("{field}: quantized dimension"), tensor.axis, &axis.to_string())?;
    for (channel, (scale, &zero)) in scales.iter().zip(&tensor.zeros).enumerate() {
        let at = |what: &str| format!("{field}: {what} of channel {channel}");
        require(scale.is_normal() && *scale > 0.0, &at("scale"), scale, "finite and above 0")?;
        require(zero == 0, &at("zero point"), zero, "0")?;
    }
    Ok(scales)
}

pub fn range(name: &str, activation: u8, scale: f32, zero: i8) -> Result<(i8, i8), TfliteError> {
    activation_range(activation, scale, zero).ok_or_else(|| {
        let found = ACTIVATIONS.get(usize::from(activation)).copied().unwrap_or("unknown");
        TfliteError::value(format!("{name}: activation"), found, "NONE, RELU, RELU_N1_TO_1 or RELU6")
    })
}
