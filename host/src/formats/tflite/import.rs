//! From a `.tflite` graph of the network's operators to the radar module's network.
//!
//! The operators are walked in the order they run; each must be what the network has at that place. Multipliers are
//! made of the file's scales as TensorFlow Lite makes them.

use super::export::METADATA;
use super::graph::Graph;
use super::operators::operators;
use super::schema::Kind;
use super::traversal::{Traversal, grid};
use super::{TfliteError, require};
use crate::formats::model_file::{self, Block, Preprocessing, QuantizedNetwork, ROWS};
use sdp3_core::graph::Kind as CoreKind;

/// What a foreign file does not say.
#[derive(Debug, Clone)]
pub struct ImportDefaults {
    /// From raw slots to the image; its sensing slots are set to the first of `sensing_slots` with the image's frames,
    /// else to the fewest that give them.
    pub preprocessing: Preprocessing,
    /// Numbers of sensing slots in use.
    pub sensing_slots: Vec<u16>,
    /// Class names, used if there are as many as logits; `class 0` and so on otherwise.
    pub classes: Vec<String>,
}

/// Reads a network of the radar module's topology; the image's pixel is the intensity - 128, whatever its scale.
///
/// # Errors
/// The field that is not what the network has at that place, with its value and what it must be.
pub fn import(file: &[u8], import_defaults: &ImportDefaults) -> Result<QuantizedNetwork, TfliteError> {
    let graph = Graph::parse(file)?;
    let [input] = graph.inputs[..] else {
        return Err(TfliteError::value("number of inputs", graph.inputs.len(), "1"));
    };
    let mut walk = Traversal { graph: &graph, next: 0, x: input, shape: [0; 3] };
    let image = graph.tensor(input, "image")?;
    grid(image)?;
    let frames = match image.shape[..] {
        [1, rows, frames, 1] if rows == i32::from(ROWS) && (2..=u16::MAX.into()).contains(&frames) => {
            frames as u16
        }
        _ => {
            return Err(TfliteError::value(
                "image: shape",
                format!("{:?}", image.shape),
                "[1, 64, frames, 1]",
            ));
        }
    };
    walk.shape = [usize::from(ROWS), usize::from(frames), 1];
    let (stem, stride) = walk.conv("stem", Kind::Conv, 3)?;
    let c = stem.biases.len();
    walk.pool("pool", Kind::MaxPool)?;
    let mut blocks = Vec::new();
    while walk.upcoming() == Some(Kind::DepthwiseConv) {
        let name = |layer: &str| format!("block {} {layer}", blocks.len());
        let skip = walk.x;
        let (affine, _) = walk.conv(&name("affine"), Kind::DepthwiseConv, 1)?;
        let (conv1, _) = walk.conv(&name("conv1"), Kind::Conv, 3)?;
        let (conv2, _) = walk.conv(&name("conv2"), Kind::Conv, 3)?;
        let outputs = [&affine, &conv1, &conv2].map(|layer| layer.biases.len());
        require(
            outputs == [c; 3],
            &name("layers: output channels"),
            format!("{outputs:?}"),
            &format!("{:?}", [c; 3]),
        )?;
        let add = walk.add(&name("add"), skip)?;
        blocks.push(Block { affine, conv1, conv2, add });
    }
    walk.pool("mean", Kind::AveragePool)?;
    let (head, _) = walk.conv("logits", Kind::Conv, 1)?;
    // the radar module has its own softmax, and other axes change nothing
    while let Some(Kind::Reshape | Kind::Softmax) = walk.upcoming() {
        walk.pass("behind the logits")?;
    }
    let rest = graph.operators.len() - walk.next;
    require(rest == 0, "number of operators behind the logits", rest, "0")?;
    require(
        graph.outputs == [walk.x],
        "subgraph outputs",
        format!("{:?}", graph.outputs),
        "the last tensor",
    )?;
    let sizes = [c, blocks.len(), head.biases.len()];
    let stated = stated(&graph, frames, sizes)?;
    let (preprocessing, classes) = stated.map_or_else(|| assumed(import_defaults, frames, sizes[2]), Ok)?;
    let network = QuantizedNetwork { preprocessing, classes, stem_stride: stride as u8, stem, blocks, head };
    network.to_bytes()?;
    Ok(network)
}

/// Reads any int8 network as a model file: of the radar module's topology, or a graph from its image to the logits, without a softmax
/// behind them. Also its sensing slots.
///
/// # Errors
/// The first operator or field that the radar module does not have, with its value and what it must be.
pub fn import_model(file: &[u8], import_defaults: &ImportDefaults) -> Result<(Vec<u8>, u16), TfliteError> {
    if let Ok(network) = import(file, import_defaults) {
        return Ok((network.to_bytes()?, network.preprocessing.sensing_slots));
    }
    let graph = Graph::parse(file)?;
    let mut network = operators(&graph)?;
    if network.operators.len() > 1 {
        network.operators.pop_if(|last| last.kind == CoreKind::Softmax);
    }
    let ends = [network.input, network.output()].map(|activation| network.activations[activation]);
    let ([rows, frames, 1], [1, 1, classes]) = (ends[0], ends[1]) else {
        return Err(not_an_image(ends));
    };
    let fits = rows == usize::from(ROWS)
        && (2..=usize::from(u16::MAX)).contains(&frames)
        && (2..=16).contains(&classes);
    if !fits {
        return Err(not_an_image(ends));
    }
    let stated = stated(&graph, frames as u16, [0, 0, classes])?;
    let (preprocessing, classes) =
        stated.map_or_else(|| assumed(import_defaults, frames as u16, classes), Ok)?;
    let graph = network.to_bytes()?;
    Ok((model_file::with_graph(&preprocessing, &classes, &graph)?, preprocessing.sensing_slots))
}

fn not_an_image(ends: [[usize; 3]; 2]) -> TfliteError {
    let legal = "[64, frames, 1] and [1, 1, 2 to 16]; a network of other sizes is imported as FILE.graph";
    TfliteError::value("input and output of a radar model", format!("{:?} and {:?}", ends[0], ends[1]), legal)
}

/// Reads any int8 network as the bytes of a graph of its own.
///
/// # Errors
/// The first operator or field that the radar module does not have, with its value and what it must be.
pub fn import_graph(file: &[u8]) -> Result<Vec<u8>, TfliteError> {
    Ok(operators(&Graph::parse(file)?)?.to_bytes()?)
}

/// Preprocessing and class names from the file's own metadata.
fn stated(
    graph: &Graph<'_>,
    frames: u16,
    sizes: [usize; 3],
) -> Result<Option<(Preprocessing, Vec<String>)>, TfliteError> {
    let Some((_, data)) = graph.metadata.iter().find(|(name, _)| name == METADATA) else { return Ok(None) };
    let field = format!("metadata {METADATA:?}");
    let wrong = |value: String, legal: &str| Err(TfliteError::value(field.as_str(), value, legal));
    let Some((header, names)) = model_file::header_and_names(data) else {
        return wrong(format!("{} bytes", data.len()), "a model file's header and class names");
    };
    let found = [header.sizes[0], header.sizes[1], header.sizes[2]].map(usize::from);
    if found != sizes {
        return wrong(format!("{found:?} channels, blocks, classes"), &format!("{sizes:?}, as the graph"));
    }
    let stated = header.preprocessing.frames();
    if stated != frames {
        return wrong(format!("for {stated} frames"), &format!("for {frames}, as the image"));
    }
    Ok(Some((header.preprocessing, names)))
}

/// Preprocessing and class names from outside.
fn assumed(
    s: &ImportDefaults,
    frames: u16,
    classes: usize,
) -> Result<(Preprocessing, Vec<String>), TfliteError> {
    let with = |sensing_slots: u16| Preprocessing { sensing_slots, ..s.preprocessing };
    let p = &s.preprocessing;
    let fewest = u32::from(p.window_len) + u32::from(p.hop) * u32::from(frames - 1);
    let fewest = u16::try_from(fewest).map_err(|_| {
        TfliteError::value(
            "image: frames",
            frames,
            format!("fewer, {fewest} sensing slots are above {}", u16::MAX),
        )
    })?;
    let known = s.sensing_slots.iter().copied().find(|&n| with(n).frames() == frames);
    let names = match s.classes.len() == classes {
        true => s.classes.clone(),
        false => (0..classes).map(|k| format!("class {k}")).collect(),
    };
    Ok((with(known.unwrap_or(fewest)), names))
}
