//! From any `.tflite` graph of the radar module's operators to its operators.
//!
//! Shapes are followed from the input on; a RESHAPE is another view of the same bytes. Multipliers are made of the file's scales as
//! LiteRT's reference kernels make them: `sdp3_core::graph` computes the same bits.

use super::graph::{Graph, Operator, Tensor};
use super::schema::{self, INT8, Kind, SAME};
use super::traversal::{grid, range};
use super::{TfliteError, require};
use crate::formats::graph_file::{self, GraphNetwork};
use crate::formats::model_file::rescale::{add_ratios, multiplier, ratio, softmax_words};
use sdp3_core::graph::{Kind as CoreKind, Window};

/// Most values of a softmax's row: of more, LiteRT's sum of exponentials overflows.
const MOST_PROBABILITIES: usize = 511;
const NO_WINDOW: Window = Window { size: [1; 2], stride: [1; 2], padding: [0; 2] };

/// What is known of a tensor that holds an activation: which it is, and its axes behind the batch.
#[derive(Debug, Clone, PartialEq, Eq)]
struct Activation {
    number: usize,
    axes: Vec<usize>,
}

impl Activation {
    /// Height, width and channels; fewer axes are the last ones.
    fn shape(&self) -> [usize; 3] {
        let mut shape = [1; 3];
        let from = 3_usize.saturating_sub(self.axes.len());
        shape[from..].iter_mut().zip(&self.axes).for_each(|(to, axis)| *to = *axis);
        shape
    }

    fn values(&self) -> usize {
        self.axes.iter().product()
    }
}

/// Reads the operators.
///
/// # Errors
/// The first operator or field that the radar module does not have, with its value and what it must be.
pub fn operators(graph: &Graph<'_>) -> Result<GraphNetwork, TfliteError> {
    let ([input], [output]) = (&graph.inputs[..], &graph.outputs[..]) else {
        let found = format!("{} and {}", graph.inputs.len(), graph.outputs.len());
        return Err(TfliteError::value("number of inputs and outputs", found, "1 and 1"));
    };
    let mut reader = Reader {
        graph,
        known: vec![None; graph.tensors.len()],
        network: GraphNetwork { activations: Vec::new(), operators: Vec::new(), input: 0, grids: Vec::new() },
    };
    let tensor = graph.tensor(*input, "input")?;
    let (axes, grid) = (axes(tensor, "input")?, grid(tensor)?);
    reader.define(*input, axes, grid);
    for (number, operator) in graph.operators.iter().enumerate() {
        reader.operator(operator, &format!("operator {number} ({})", operator.kind.name()))?;
    }
    graph.tensor(*output, "output")?;
    let last = reader.known[*output as usize].as_ref().is_some_and(|a| a.number == reader.network.output());
    require(last, "output: tensor", output, "what the last operator writes")?;
    Ok(reader.network)
}

/// Axes behind a batch of one.
fn axes(tensor: &Tensor<'_>, field: &str) -> Result<Vec<usize>, TfliteError> {
    let lengths: Option<Vec<usize>> =
        tensor.shape.iter().map(|&n| usize::try_from(n).ok().filter(|n| *n > 0)).collect();
    match lengths.as_deref() {
        Some([1, rest @ ..]) if (1..=3).contains(&rest.len()) && rest.iter().all(|&n| n <= 65_535) => {
            Ok(rest.to_vec())
        }
        _ => {
            let legal = "[1, height, width, channels], or fewer axes behind the 1, each 1 to 65535";
            Err(TfliteError::value(format!("{field}: shape"), format!("{:?}", tensor.shape), legal))
        }
    }
}

struct Reader<'g, 'a> {
    graph: &'g Graph<'a>,
    /// By the file's tensors.
    known: Vec<Option<Activation>>,
    network: GraphNetwork,
}

impl Reader<'_, '_> {
    /// A new activation in tensor `tensor`; returns its number.
    fn define(&mut self, tensor: i32, axes: Vec<usize>, grid: (f32, i8)) -> usize {
        let activation = Activation { number: self.network.activations.len(), axes };
        self.network.activations.push(activation.shape());
        self.network.grids.push(grid);
        let number = activation.number;
        self.known[tensor as usize] = Some(activation);
        number
    }

    /// The activation that an operator reads, with scale and zero point.
    fn activation(&self, tensor: i32, field: &str) -> Result<(Activation, f32, i8), TfliteError> {
        let found = self.graph.tensor(tensor, field)?;
        let known = self.known.get(tensor as usize).cloned().flatten();
        let known = known.ok_or_else(|| {
            let legal = "one that an operator before has written";
            TfliteError::value(format!("{field}: input"), format!("tensor {tensor} {:?}", found.name), legal)
        })?;
        let (scale, zero) = grid(found)?;
        Ok((known, scale, zero))
    }

    fn operator(&mut self, operator: &Operator, field: &str) -> Result<(), TfliteError> {
        let [output] = operator.outputs[..] else {
            let found = operator.outputs.len();
            return Err(TfliteError::value(format!("{field}: number of outputs"), found, "1"));
        };
        let input = operator.inputs.first().copied().unwrap_or(-1);
        let (activation, in_scale, in_zero) = self.activation(input, field)?;
        let (out_scale, out_zero) = grid(self.graph.tensor(output, field)?)?;
        let scales = [in_scale, out_scale];
        let legal = operator.kind.legal_inputs();
        let found = operator.inputs.len();
        require(legal.contains(&found), &format!("{field}: number of inputs"), found, &format!("{legal:?}"))?;
        if operator.kind == Kind::Reshape {
            let axes = axes(self.graph.tensor(output, field)?, field)?;
            let same = axes.iter().product::<usize>() == activation.values();
            require(
                same,
                &format!("{field}: values"),
                format!("{axes:?}"),
                &format!("{}", activation.values()),
            )?;
            self.same_grid(field, [(in_scale, in_zero), (out_scale, out_zero)])?;
            self.known[output as usize] = Some(Activation { axes, ..activation });
            return Ok(());
        }
        let mut made = graph_file::Operator {
            kind: CoreKind::Softmax,
            input: activation.number,
            input_shape: activation.shape(),
            second: None,
            output: 0,
            window: NO_WINDOW,
            zero_points: [in_zero, out_zero, 0],
            activation: range(field, operator.options.activation, out_scale, out_zero)?.into(),
            parameters: Vec::new(),
        };
        let axes = match operator.kind {
            Kind::Conv | Kind::DepthwiseConv => {
                self.convolution(operator, &activation, scales, field, &mut made)?
            }
            Kind::FullyConnected => self.dense(operator, &activation, scales, field, &mut made)?,
            Kind::Add => self.addition(operator, &activation, scales, field, &mut made)?,
            Kind::MaxPool | Kind::AveragePool => {
                self.same_grid(field, [(in_scale, in_zero), (out_scale, out_zero)])?;
                made.kind =
                    if operator.kind == Kind::MaxPool { CoreKind::MaxPool } else { CoreKind::AveragePool };
                let [w, h] = operator.options.filter;
                let axes = self.window(operator, &activation, [h, w], field, &mut made)?;
                [&axes[..2], &activation.axes[2..]].concat()
            }
            Kind::Softmax => {
                softmax(operator, &activation, in_scale, (out_scale, out_zero), field, &mut made)?;
                activation.axes.clone()
            }
            Kind::Reshape => return Ok(()),
        };
        made.output = self.define(output, axes, (out_scale, out_zero));
        self.network.operators.push(made);
        Ok(())
    }

    fn same_grid(&self, field: &str, [before, after]: [(f32, i8); 2]) -> Result<(), TfliteError> {
        let legal = format!("{before:?}, the input's");
        require(before == after, &format!("{field}: scale and zero point"), format!("{after:?}"), &legal)
    }

    /// The window of a convolution or pooling; returns height and width of the output.
    fn window(
        &self,
        operator: &Operator,
        activation: &Activation,
        size: [i32; 2],
        field: &str,
        made: &mut graph_file::Operator,
    ) -> Result<Vec<usize>, TfliteError> {
        let [height, width, _] = activation.axes[..] else {
            let legal = "height, width and channels";
            return Err(TfliteError::value(
                format!("{field}: axes of the input"),
                activation.axes.len(),
                legal,
            ));
        };
        let o = &operator.options;
        require(o.dilation == [1; 2], &format!("{field}: dilation"), format!("{:?}", o.dilation), "[1, 1]")?;
        let mut out = Vec::new();
        let strides = [o.stride[1], o.stride[0]];
        for (axis, length) in [height, width].into_iter().enumerate() {
            let byte = |what: &str, value: i32| {
                let legal = (1..=255).contains(&value);
                require(legal, &format!("{field}: {what}"), value, "1 to 255").map(|()| value as usize)
            };
            if o.padding != SAME && size[axis] as usize == length {
                // one window over all of the axis, however long
                (made.window.size[axis], made.window.stride[axis]) = (0, 1);
                out.push(1);
                continue;
            }
            let (stride, window) = (byte("stride", strides[axis])?, byte("window", size[axis])?);
            let (outputs, padding) = if o.padding == SAME {
                let outputs = length.div_ceil(stride);
                (outputs, ((outputs - 1) * stride + window).saturating_sub(length) / 2)
            } else {
                let legal = format!("at most {length}, the input's length");
                require(window <= length, &format!("{field}: window"), window, &legal)?;
                ((length - window) / stride + 1, 0)
            };
            made.window.size[axis] = window as u8;
            made.window.stride[axis] = stride as u8;
            made.window.padding[axis] = padding as u8;
            out.push(outputs);
        }
        Ok(out)
    }

    fn convolution(
        &self,
        operator: &Operator,
        activation: &Activation,
        scales: [f32; 2],
        field: &str,
        made: &mut graph_file::Operator,
    ) -> Result<Vec<usize>, TfliteError> {
        let weights = self.graph.tensor(operator.inputs[1], field)?;
        let inputs = activation.axes.last().copied().unwrap_or(0);
        let depthwise = operator.kind == Kind::DepthwiseConv;
        let (h, w, outputs, axis) = match weights.shape[..] {
            [1, h, w, o] if depthwise && (o as usize).is_multiple_of(inputs) => (h, w, o, 3),
            [o, h, w, i] if !depthwise && i as usize == inputs => (h, w, o, 0),
            _ => {
                let legal = match depthwise {
                    true => format!("[1, height, width, a multiple of {inputs}]"),
                    false => format!("[outputs, height, width, {inputs}]"),
                };
                return Err(wrong_shape(weights, field, &legal));
            }
        };
        made.kind = if depthwise { CoreKind::DepthwiseConvolution } else { CoreKind::Convolution };
        let mut axes = self.window(operator, activation, [h, w], field, made)?;
        axes.push(outputs as usize);
        let (weight_scales, values) = self.weights(weights, axis, outputs, field)?;
        let mut shifts = Vec::new();
        for (channel, &scale) in weight_scales.iter().enumerate() {
            let ratio = ratio(scales[0], scale, scales[1]);
            let at = || format!("{field}: channel {channel}: ratio of scales");
            let (q31, shift) =
                multiplier(ratio).ok_or_else(|| TfliteError::value(at(), ratio, "below 128"))?;
            made.parameters.extend(q31.to_le_bytes());
            shifts.push(shift as u8);
        }
        self.append_biases(operator, field, scales[0], &weight_scales, made)?;
        made.append_padded(&shifts);
        made.append_padded(values);
        Ok(axes)
    }

    fn dense(
        &self,
        operator: &Operator,
        activation: &Activation,
        scales: [f32; 2],
        field: &str,
        made: &mut graph_file::Operator,
    ) -> Result<Vec<usize>, TfliteError> {
        let weights = self.graph.tensor(operator.inputs[1], field)?;
        let inputs = activation.values();
        let outputs = match weights.shape[..] {
            [outputs, i] if i as usize == inputs => outputs,
            _ => return Err(wrong_shape(weights, field, &format!("[outputs, {inputs}]"))),
        };
        made.kind = CoreKind::FullyConnected;
        made.window.size = [0; 2];
        let (weight_scales, values) = self.weights(weights, 0, outputs, field)?;
        for (channel, &scale) in weight_scales.iter().enumerate() {
            let ratio = ratio(scales[0], scale, scales[1]);
            let field = format!("{field}: channel {channel}: ratio of scales");
            require(ratio <= 128.0, &field, ratio, "at most 128")?;
            made.parameters.extend(ratio.to_le_bytes());
        }
        self.append_biases(operator, field, scales[0], &weight_scales, made)?;
        made.append_padded(values);
        Ok(vec![outputs as usize])
    }

    /// Adds the biases that an operator has, or zeros, to the parameters.
    fn append_biases(
        &self,
        operator: &Operator,
        field: &str,
        in_scale: f32,
        weight_scales: &[f32],
        made: &mut graph_file::Operator,
    ) -> Result<(), TfliteError> {
        let tensor = operator.inputs.get(2).copied().unwrap_or(-1);
        let biases = self.graph.biases(tensor, field, weight_scales.len(), in_scale, weight_scales)?;
        made.parameters.extend(biases.iter().flat_map(|bias| bias.to_le_bytes()));
        Ok(())
    }

    /// Scales of int8 weights, one for each of `outputs`, and the weights.
    fn weights<'t>(
        &self,
        tensor: &'t Tensor<'_>,
        axis: i32,
        outputs: i32,
        field: &str,
    ) -> Result<(Vec<f32>, &'t [u8]), TfliteError> {
        let field = format!("{field}: weights");
        require(tensor.kind == INT8, &format!("{field}: type"), schema::type_name(tensor.kind), "INT8")?;
        require((1..=65_535).contains(&outputs), &format!("{field}: outputs"), outputs, "1 to 65535")?;
        let count = tensor.scales.len();
        let legal = format!("1 or {outputs}, one per output channel");
        let fits = count == 1 || count == outputs as usize;
        require(fits, &format!("{field}: number of scales"), count, &legal)?;
        let along = count == 1 || tensor.axis == axis;
        require(along, &format!("{field}: quantized dimension"), tensor.axis, &axis.to_string())?;
        for (scale, &zero) in tensor.scales.iter().zip(&tensor.zeros) {
            require(
                scale.is_normal() && *scale > 0.0,
                &format!("{field}: scale"),
                scale,
                "finite and above 0",
            )?;
            require(zero == 0, &format!("{field}: zero point"), zero, "0")?;
        }
        let values =
            tensor.shape.iter().try_fold(1_usize, |all, &n| all.checked_mul(usize::try_from(n).ok()?));
        let legal = values.map_or_else(|| "fewer".to_owned(), |n| n.to_string());
        require(values == Some(tensor.data.len()), &format!("{field}: bytes"), tensor.data.len(), &legal)?;
        let scales = (0..outputs as usize).map(|k| tensor.scales[k % count]).collect();
        Ok((scales, &tensor.data))
    }

    fn addition(
        &self,
        operator: &Operator,
        activation: &Activation,
        [in_scale, out_scale]: [f32; 2],
        field: &str,
        made: &mut graph_file::Operator,
    ) -> Result<Vec<usize>, TfliteError> {
        let (second, second_scale, second_zero) = self.activation(operator.inputs[1], field)?;
        let (found, legal) = (format!("{:?}", second.axes), format!("{:?}, the first's", activation.axes));
        require(
            second.axes == activation.axes,
            &format!("{field}: axes of the second input"),
            found,
            &legal,
        )?;
        made.kind = CoreKind::Add;
        made.second = Some(second.number);
        made.zero_points[2] = second_zero;
        let mut shifts = Vec::new();
        for ratio in add_ratios(in_scale, second_scale, out_scale) {
            let found = multiplier(ratio).filter(|_| ratio < 1.0);
            let (q31, shift) = found
                .ok_or_else(|| TfliteError::value(format!("{field}: ratio of scales"), ratio, "below 1"))?;
            made.parameters.extend(q31.to_le_bytes());
            shifts.push(shift as u8);
        }
        made.parameters.extend(shifts);
        made.parameters.push(0);
        Ok(activation.axes.clone())
    }
}

fn wrong_shape(weights: &Tensor<'_>, field: &str, legal: &str) -> TfliteError {
    TfliteError::value(format!("{field}: shape of the weights"), format!("{:?}", weights.shape), legal)
}

fn softmax(
    operator: &Operator,
    activation: &Activation,
    in_scale: f32,
    (out_scale, out_zero): (f32, i8),
    field: &str,
    made: &mut graph_file::Operator,
) -> Result<(), TfliteError> {
    let depth = activation.axes.last().copied().unwrap_or(0);
    let legal = format!("1 to {MOST_PROBABILITIES}");
    require(depth <= MOST_PROBABILITIES, &format!("{field}: values of a row"), depth, &legal)?;
    let fits = (256.0 * out_scale - 1.0).abs() <= 1e-3 && out_zero == -128;
    let found = format!("{:?}", (out_scale, out_zero));
    require(fits, &format!("{field}: scale and zero point of the output"), found, "(0.00390625, -128)")?;
    let product = f64::from(operator.options.beta) * f64::from(in_scale);
    let words = softmax_words(product).ok_or_else(|| {
        TfliteError::value(format!("{field}: beta times the input's scale"), product, "above 2^-26")
    })?;
    made.parameters.extend(words.map(i32::to_le_bytes).as_flattened());
    Ok(())
}
