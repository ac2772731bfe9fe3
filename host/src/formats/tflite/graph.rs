//! A graph of int8 operators: tensors, operators and named data, to and from the bytes of a `.tflite` file.
//!
//! One subgraph. Counts are limited before anything is allocated for them.

use std::borrow::Cow;

use super::reader::Table;
use super::schema::{self, Kind, OptionSlots, slot};
use super::writer::{Field, Node, finish};
use super::{TfliteError, require};

/// Most tensors, buffers and operator codes that are read.
const MOST_TENSORS: usize = 1024;
/// Most operators that are read.
const MOST_OPERATORS: usize = 256;
/// Most scales of a tensor that are read.
const MOST_SCALES: usize = 1024;
/// Most axes of a tensor that are read, and inputs or outputs of an operator.
const MOST_AXES: usize = 8;

/// A tensor: an activation, or weights with their data.
#[derive(Debug, Clone, PartialEq)]
pub struct Tensor<'a> {
    pub name: String,
    /// Lengths of its axes.
    pub shape: Vec<i32>,
    pub kind: u8,
    /// Little-endian values of a constant; empty otherwise.
    pub data: Cow<'a, [u8]>,
    /// Scales: one, or one per index of `axis`; empty if not quantised.
    pub scales: Vec<f32>,
    /// Zero points, as many as scales.
    pub zeros: Vec<i64>,
    /// The axis several scales belong to.
    pub axis: i32,
}

/// Options of an operator; those it does not have keep their neutral value.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Options {
    pub padding: u8,
    /// Strides along width and height.
    pub stride: [i32; 2],
    /// Window's width and height.
    pub filter: [i32; 2],
    pub activation: u8,
    /// Dilation along width and height.
    pub dilation: [i32; 2],
    pub depth_multiplier: i32,
    /// Factor of a softmax's logits.
    pub beta: f32,
}

impl Options {
    /// Stride and dilation 1, no activation.
    pub const NEUTRAL: Options = Options {
        padding: schema::SAME,
        stride: [1; 2],
        filter: [1; 2],
        activation: 0,
        dilation: [1; 2],
        depth_multiplier: 1,
        beta: 1.0,
    };
}

#[derive(Debug, Clone, PartialEq)]
pub struct Operator {
    pub kind: Kind,
    /// Tensors it reads; -1 for one that is left out.
    pub inputs: Vec<i32>,
    pub outputs: Vec<i32>,
    pub options: Options,
}

#[derive(Debug, Clone, PartialEq)]
pub struct Graph<'a> {
    /// What it is, in words.
    pub description: String,
    pub tensors: Vec<Tensor<'a>>,
    /// Operators in the order they run.
    pub operators: Vec<Operator>,
    /// Tensors given from outside.
    pub inputs: Vec<i32>,
    /// Tensors that are the answer.
    pub outputs: Vec<i32>,
    /// Data by name that no operator uses.
    pub metadata: Vec<(String, Cow<'a, [u8]>)>,
}

impl<'a> Graph<'a> {
    /// Reads a file; constants stay where they are.
    ///
    /// # Errors
    /// A reference out of the file, an operator the network does not have, more of something than is read.
    pub fn parse(file: &'a [u8]) -> Result<Graph<'a>, TfliteError> {
        let model = Table::root(file, schema::IDENTIFIER)?;
        let version = model.i32(slot::MODEL_VERSION, 0, "version")?;
        require(version == schema::SCHEMA_VERSION, "version", version, "3")?;
        let buffers = model.tables(slot::MODEL_BUFFERS, MOST_TENSORS, "buffers")?;
        let subgraphs = model.tables(slot::MODEL_SUBGRAPHS, MOST_AXES, "subgraphs")?;
        let [graph] = subgraphs[..] else {
            return Err(TfliteError::value("number of subgraphs", subgraphs.len(), "1"));
        };
        let tensors = graph.tables(slot::GRAPH_TENSORS, MOST_TENSORS, "tensors")?;
        let tensors =
            tensors.iter().enumerate().map(|(i, t)| tensor(i, t, &buffers)).collect::<Result<_, _>>()?;
        let codes = model.tables(slot::MODEL_CODES, MOST_TENSORS, "operator codes")?;
        let codes = codes.iter().map(operator_code).collect::<Result<Vec<_>, _>>()?;
        let operators = graph.tables(slot::GRAPH_OPERATORS, MOST_OPERATORS, "operators")?;
        let operators =
            operators.iter().enumerate().map(|(i, o)| operator(i, o, &codes)).collect::<Result<_, _>>()?;
        let mut metadata = Vec::new();
        for entry in model.tables(slot::MODEL_METADATA, MOST_AXES, "metadata")? {
            let name = entry.text(slot::METADATA_NAME, "metadata name")?;
            let index = entry.i32(slot::METADATA_BUFFER, 0, "metadata buffer")?;
            metadata.push((name, Cow::Borrowed(constant(&buffers, index, "metadata buffer")?)));
        }
        Ok(Graph {
            description: model.text(slot::MODEL_DESCRIPTION, "description")?,
            tensors,
            operators,
            inputs: indices(&graph, slot::GRAPH_INPUTS, "subgraph inputs")?,
            outputs: indices(&graph, slot::GRAPH_OUTPUTS, "subgraph outputs")?,
            metadata,
        })
    }

    pub fn to_bytes(&self) -> Vec<u8> {
        // buffer 0 is the empty one of all tensors without data
        let mut buffers = vec![Node::Table(Vec::new())];
        let mut buffer = |data: &[u8]| {
            let node = Field::Ref(Node::Bytes(data.to_vec()));
            buffers.push(Node::Table(vec![(slot::BUFFER_DATA, node)]));
            buffers.len() as i32 - 1
        };
        let tensor = |t: &Tensor<'_>| {
            let index = if t.data.is_empty() { 0 } else { buffer(&t.data) };
            let quantization = vec![
                (slot::QUANTIZATION_SCALE, Field::Ref(Node::F32s(t.scales.clone()))),
                (slot::QUANTIZATION_ZERO, Field::Ref(Node::I64s(t.zeros.clone()))),
                (slot::QUANTIZATION_AXIS, Field::I32(t.axis)),
            ];
            Node::Table(vec![
                (slot::TENSOR_SHAPE, Field::Ref(Node::I32s(t.shape.clone()))),
                (slot::TENSOR_TYPE, Field::U8(t.kind)),
                (slot::TENSOR_BUFFER, Field::I32(index)),
                (slot::TENSOR_NAME, Field::Ref(Node::Text(t.name.clone()))),
                (slot::TENSOR_QUANTIZATION, Field::Ref(Node::Table(quantization))),
            ])
        };
        let tensors = self.tensors.iter().map(tensor).collect();
        let metadata = self.metadata.iter().map(|(name, data)| {
            let index = Field::I32(buffer(data));
            let name = Field::Ref(Node::Text(name.clone()));
            Node::Table(vec![(slot::METADATA_NAME, name), (slot::METADATA_BUFFER, index)])
        });
        let metadata = Node::Nodes(metadata.collect());
        let mut used = Kind::ALL.to_vec();
        used.retain(|kind| self.operators.iter().any(|o| o.kind == *kind));
        let codes = used.iter().map(|kind| {
            Node::Table(vec![
                (slot::CODE_SMALL, Field::U8(kind.code() as u8)),
                (slot::CODE_VERSION, Field::I32(kind.version())),
                (slot::CODE, Field::I32(kind.code())),
            ])
        });
        let operators = self.operators.iter().map(|o| o.node(&used)).collect();
        let graph = Node::Table(vec![
            (slot::GRAPH_TENSORS, Field::Ref(Node::Nodes(tensors))),
            (slot::GRAPH_INPUTS, Field::Ref(Node::I32s(self.inputs.clone()))),
            (slot::GRAPH_OUTPUTS, Field::Ref(Node::I32s(self.outputs.clone()))),
            (slot::GRAPH_OPERATORS, Field::Ref(Node::Nodes(operators))),
            (slot::GRAPH_NAME, Field::Ref(Node::Text("main".into()))),
        ]);
        let model = vec![
            (slot::MODEL_VERSION, Field::I32(schema::SCHEMA_VERSION)),
            (slot::MODEL_CODES, Field::Ref(Node::Nodes(codes.collect()))),
            (slot::MODEL_SUBGRAPHS, Field::Ref(Node::Nodes(vec![graph]))),
            (slot::MODEL_DESCRIPTION, Field::Ref(Node::Text(self.description.clone()))),
            (slot::MODEL_BUFFERS, Field::Ref(Node::Nodes(buffers))),
            (slot::MODEL_METADATA, Field::Ref(metadata)),
        ];
        finish(Node::Table(model), schema::IDENTIFIER)
    }
}

impl Operator {
    /// Its table; the code is its place among those used.
    fn node(&self, used: &[Kind]) -> Node {
        let code = used.iter().position(|kind| *kind == self.kind).unwrap_or(0) as i32;
        let mut fields = vec![
            (slot::OPERATOR_CODE, Field::I32(code)),
            (slot::OPERATOR_INPUTS, Field::Ref(Node::I32s(self.inputs.clone()))),
            (slot::OPERATOR_OUTPUTS, Field::Ref(Node::I32s(self.outputs.clone()))),
        ];
        if let Some(slots) = self.kind.option_slots() {
            fields.push((slot::OPERATOR_OPTIONS_TYPE, Field::U8(self.kind.options_type())));
            fields.push((slot::OPERATOR_OPTIONS, Field::Ref(Node::Table(self.options.fields(&slots)))));
        }
        Node::Table(fields)
    }
}

impl Options {
    /// Those the operator has.
    fn fields(&self, slots: &OptionSlots) -> Vec<(usize, Field)> {
        let mut fields = vec![(slots.activation, Field::U8(self.activation))];
        let pairs =
            [(slots.stride, self.stride), (slots.filter, self.filter), (slots.dilation, self.dilation)];
        for (at, pair) in pairs.into_iter().filter_map(|(slots, pair)| Some((slots?, pair))) {
            fields.extend([(at[0], Field::I32(pair[0])), (at[1], Field::I32(pair[1]))]);
        }
        if slots.stride.is_some() {
            fields.push((0, Field::U8(self.padding)));
        }
        fields.extend(slots.depth_multiplier.map(|at| (at, Field::I32(self.depth_multiplier))));
        fields
    }

    /// Reads those the operator has.
    fn parse(
        stated: &Table<'_>,
        slots: &OptionSlots,
        field: &dyn Fn(&str) -> String,
    ) -> Result<Options, TfliteError> {
        let pair = |slots: Option<[usize; 2]>, default: i32, what: &str| match slots {
            Some([w, h]) => {
                Ok([stated.i32(w, default, &field(what))?, stated.i32(h, default, &field(what))?])
            }
            None => Ok::<_, TfliteError>([1; 2]),
        };
        let byte = |slot: Option<usize>, what: &str| slot.map_or(Ok(0), |at| stated.u8(at, 0, &field(what)));
        let multiplier = |at| stated.i32(at, 0, &field("depth multiplier"));
        Ok(Options {
            padding: byte(slots.stride.map(|_| 0), "padding")?,
            stride: pair(slots.stride, 0, "stride")?,
            filter: pair(slots.filter, 0, "filter")?,
            activation: byte(Some(slots.activation), "activation")?,
            dilation: pair(slots.dilation, 1, "dilation")?,
            depth_multiplier: slots.depth_multiplier.map_or(Ok(1), multiplier)?,
            ..Options::NEUTRAL
        })
    }
}

fn indices(table: &Table<'_>, slot: usize, field: &str) -> Result<Vec<i32>, TfliteError> {
    Ok(table.words(slot, MOST_AXES, field)?.into_iter().map(i32::from_le_bytes).collect())
}

/// Data of a buffer.
fn constant<'a>(buffers: &[Table<'a>], index: i32, field: &str) -> Result<&'a [u8], TfliteError> {
    let found = usize::try_from(index).ok().and_then(|i| buffers.get(i));
    let buffer = found.ok_or_else(|| {
        TfliteError::value(field, index, format!("0..{}, one of the buffers", buffers.len()))
    })?;
    require(!buffer.has(slot::BUFFER_OFFSET), field, "outside of the flatbuffer", "inside")?;
    buffer.vector(slot::BUFFER_DATA, 1, field)
}

fn tensor<'a>(index: usize, table: &Table<'a>, buffers: &[Table<'a>]) -> Result<Tensor<'a>, TfliteError> {
    let name = table.text(slot::TENSOR_NAME, &format!("tensor {index}: name"))?;
    let field = |what: &str| format!("tensor {index} {name:?}: {what}");
    let buffer = table.i32(slot::TENSOR_BUFFER, 0, &field("buffer"))?;
    let (mut scales, mut zeros, mut axis) = (Vec::new(), Vec::new(), 0);
    if let Some(q) = table.table(slot::TENSOR_QUANTIZATION, &field("quantization"))? {
        let words = q.words(slot::QUANTIZATION_SCALE, MOST_SCALES, &field("scales"))?;
        scales = words.into_iter().map(f32::from_le_bytes).collect();
        let (long, _) = q.vector(slot::QUANTIZATION_ZERO, 8, &field("zero points"))?.as_chunks::<8>();
        require(
            long.len() == scales.len(),
            &field("number of zero points"),
            long.len(),
            &scales.len().to_string(),
        )?;
        zeros = long.iter().map(|z| i64::from_le_bytes(*z)).collect();
        axis = q.i32(slot::QUANTIZATION_AXIS, 0, &field("quantized dimension"))?;
    }
    Ok(Tensor {
        shape: indices(table, slot::TENSOR_SHAPE, &field("shape"))?,
        kind: table.u8(slot::TENSOR_TYPE, schema::FLOAT32, &field("type"))?,
        data: Cow::Borrowed(constant(buffers, buffer, &field("buffer"))?),
        scales,
        zeros,
        axis,
        name,
    })
}

fn operator_code(table: &Table<'_>) -> Result<i32, TfliteError> {
    let small = i32::from(table.u8(slot::CODE_SMALL, 0, "operator code")?);
    Ok(small.max(table.i32(slot::CODE, 0, "operator code")?))
}

fn operator(index: usize, table: &Table<'_>, codes: &[i32]) -> Result<Operator, TfliteError> {
    let field = |what: &str| format!("operator {index}: {what}");
    let at = table.i32(slot::OPERATOR_CODE, 0, &field("code"))?;
    let found = usize::try_from(at).ok().and_then(|i| codes.get(i));
    let code = *found.ok_or_else(|| TfliteError::value(field("code"), at, format!("0..{}", codes.len())))?;
    let kind = Kind::ALL.into_iter().find(|kind| kind.code() == code).ok_or_else(|| {
        let legal = Kind::ALL.map(Kind::name).join(", ");
        TfliteError::value(
            format!("operator {index}"),
            schema::operator_name(code),
            format!("one of {legal}"),
        )
    })?;
    let mut options = Options::NEUTRAL;
    if let Some(slots) = kind.option_slots() {
        let found = table.u8(slot::OPERATOR_OPTIONS_TYPE, 0, &field("options' type"))?;
        let legal = format!("{} for {}", kind.options_type(), kind.name());
        require(found == kind.options_type(), &field("options' type"), found, &legal)?;
        let stated = table.table(slot::OPERATOR_OPTIONS, &field("options"))?;
        let stated = stated.ok_or_else(|| TfliteError::value(field("options"), "missing", "there"))?;
        options = Options::parse(&stated, &slots, &field)?;
    }
    if let (Kind::Softmax, Some(stated)) = (kind, table.table(slot::OPERATOR_OPTIONS, &field("options"))?) {
        options.beta = f32::from_bits(stated.i32(slot::SOFTMAX_BETA, 0, &field("beta"))? as u32);
    }
    Ok(Operator {
        kind,
        inputs: indices(table, slot::OPERATOR_INPUTS, &field("inputs"))?,
        outputs: indices(table, slot::OPERATOR_OUTPUTS, &field("outputs"))?,
        options,
    })
}
