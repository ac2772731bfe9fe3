//! Exchange of int8 networks: what is written is read, and what the network does not have is refused by name.

use std::borrow::Cow;

use super::graph::{Graph, Operator};
use super::schema::Kind;
use super::*;
use crate::formats::model_file::{Preprocessing, QuantizedNetwork};
use crate::network::interchange::header;
use crate::network::parameters::Architecture;
use crate::network::quantization::quantize;
use crate::network::synthetic::{stripes, trained_looking};
use crate::scenario::Scenario;

fn preprocessing() -> Preprocessing {
    header(&Scenario::default(), 201)
}

fn names() -> Vec<String> {
    ["a", "b", "c", "d", "e"].map(String::from).to_vec()
}

fn network(stem_stride: usize) -> QuantizedNetwork {
    let parameters = trained_looking(Architecture { channels: 8, blocks: 2, stem_stride, classes: 5 }, 11);
    quantize(&parameters, preprocessing(), &names(), &stripes(10, 2, 1)).unwrap().0
}

fn import_defaults() -> ImportDefaults {
    let preprocessing = Preprocessing { sensing_slots: 0, ..preprocessing() };
    ImportDefaults { preprocessing, sensing_slots: vec![150, 203, 204], classes: names() }
}

/// What the importer says to an exported network that was changed.
fn refusal(change: impl Fn(&mut Graph<'_>)) -> String {
    let file = export(&network(1)).unwrap();
    let mut graph = Graph::parse(&file).unwrap();
    change(&mut graph);
    import(&graph.to_bytes(), &import_defaults()).unwrap_err().to_string()
}

fn at(graph: &Graph<'_>, name: &str) -> usize {
    graph.tensors.iter().position(|t| t.name == name).unwrap()
}

#[test]
fn what_was_exported_is_imported() {
    for stride in [1, 2] {
        let network = network(stride);
        let file = export(&network).unwrap();
        assert_eq!(import(&file, &import_defaults()).unwrap(), network);
        let graph = Graph::parse(&file).unwrap();
        assert_eq!(graph.to_bytes(), file);
        assert_eq!(graph.operators.len(), 2 + 4 * 2 + 2);
        assert_eq!(graph.operators.iter().filter(|o| o.kind == Kind::Conv).count(), 1 + 2 * 2 + 1);
    }
}

#[test]
fn a_file_without_metadata_takes_classes_and_slots_from_the_defaults() {
    let file = export(&network(1)).unwrap();
    let mut graph = Graph::parse(&file).unwrap();
    graph.metadata.clear();
    // the other order of the sum, and an image in other units
    let adds = graph.operators.iter_mut().filter(|o| o.kind == Kind::Add);
    adds.for_each(|o| o.inputs.reverse());
    let found = import(&graph.to_bytes(), &import_defaults()).unwrap();
    assert_eq!((found.preprocessing.sensing_slots, &found.classes), (203, &names()));
    assert_eq!(found.blocks, network(1).blocks);
    let elsewhere = ImportDefaults { sensing_slots: vec![1000], classes: Vec::new(), ..import_defaults() };
    let found = import(&graph.to_bytes(), &elsewhere).unwrap();
    assert_eq!((found.preprocessing.sensing_slots, found.classes[4].as_str()), (200, "class 4"));
}

#[test]
fn a_softmax_behind_the_logits_is_passed_over() {
    use super::graph::Options;
    let file = export(&network(2)).unwrap();
    let mut graph = Graph::parse(&file).unwrap();
    for (kind, shape) in [(Kind::Reshape, vec![1, 5]), (Kind::Softmax, vec![1, 5])] {
        let last = graph.outputs[0];
        let mut tensor = graph.tensors[last as usize].clone();
        tensor.shape = shape;
        graph.tensors.push(tensor);
        graph.outputs = vec![graph.tensors.len() as i32 - 1];
        let (inputs, outputs) = (vec![last], graph.outputs.clone());
        graph.operators.push(Operator { kind, inputs, outputs, options: Options::NEUTRAL });
    }
    assert_eq!(import(&graph.to_bytes(), &import_defaults()).unwrap(), network(2));
    // anywhere else it is not one of the network's operators
    let error = refusal(|g| g.operators[1].kind = Kind::Softmax);
    assert_eq!(error, "operator 1 (pool) is SOFTMAX, must be MAX_POOL_2D");
}

#[test]
fn fused_activations_become_ranges() {
    use super::traversal::activation_range;
    assert_eq!(activation_range(0, 0.1, 5), Some((-128, 127)));
    assert_eq!(activation_range(1, 0.1, 5), Some((5, 127)));
    assert_eq!(activation_range(2, 0.1, 5), Some((-5, 15)));
    assert_eq!(activation_range(3, 0.1, 5), Some((5, 65)));
    assert_eq!(activation_range(3, 0.01, -128), Some((-128, 127)));
    assert_eq!(activation_range(4, 0.1, 5), None);
    let mut clipped = network(1);
    (clipped.blocks[0].conv1.act_min, clipped.blocks[0].conv1.act_max) = (-100, 3);
    let error = export(&clipped).unwrap_err().to_string();
    assert!(
        error.starts_with("block 0 conv1 activation range is -100 to 3, must be that of NONE"),
        "{error}"
    );
}

#[test]
fn multipliers_that_no_scale_gives_are_refused() {
    let mut network = network(1);
    network.blocks[1].conv2.multipliers[3] ^= 0x40;
    let error = export(&network).unwrap_err().to_string();
    assert!(error.starts_with("block 1 conv2 multiplier of channel 3 is "), "{error}");
}

#[test]
fn wrong_quantisation_is_refused() {
    let error = refusal(|g| {
        let i = at(g, "block 0 conv1 weights");
        (g.tensors[i].scales, g.tensors[i].zeros) = (vec![0.01], vec![0]);
    });
    assert_eq!(error, "block 0 conv1: weights: number of scales is 1, must be 8, one per output channel");
    let error = refusal(|g| {
        let i = at(g, "block 1 conv2 weights");
        g.tensors[i].zeros[2] = 5;
    });
    assert_eq!(error, "block 1 conv2: weights: zero point of channel 2 is 5, must be 0");
    let error = refusal(|g| {
        let i = at(g, "stem weights");
        g.tensors[i].scales[7] = f32::NAN;
    });
    assert_eq!(error, "stem: weights: scale of channel 7 is NaN, must be finite and above 0");
    let error = refusal(|g| {
        let i = at(g, "block 0 add");
        g.tensors[i].scales.clear();
        g.tensors[i].zeros.clear();
    });
    assert_eq!(error, "tensor \"block 0 add\": number of scales is 0, must be 1");
    let error = refusal(|g| {
        let i = at(g, "logits");
        g.tensors[i].zeros[0] = 128;
    });
    assert_eq!(error, "tensor \"logits\": zero point is 128, must be -128 to 127");
    let error = refusal(|g| {
        let i = at(g, "block 0 affine weights");
        g.tensors[i].axis = 0;
    });
    assert_eq!(error, "block 0 affine: weights: quantized dimension is 0, must be 3");
    let error = refusal(|g| {
        let i = at(g, "stem");
        g.tensors[i].scales[0] = 1e-9;
    });
    assert!(
        error.starts_with("stem: channel 0: ratio of scales is ") && error.ends_with("below 128"),
        "{error}"
    );
    let error = refusal(|g| {
        let i = at(g, "mean");
        g.tensors[i].scales[0] *= 2.0;
    });
    assert!(error.starts_with("mean: scale and zero point is ") && error.ends_with("the input's"), "{error}");
    let error = refusal(|g| {
        let i = at(g, "stem bias");
        g.tensors[i].scales[0] *= 2.0;
    });
    assert!(error.starts_with("stem: bias: scale is "), "{error}");
    let error = refusal(|g| {
        let i = at(g, "block 0 conv1 bias");
        g.tensors[i].data.to_mut()[..4].copy_from_slice(&i32::MIN.to_le_bytes());
    });
    assert!(error.starts_with("block 0 conv1: channel 0: largest accumulator is "), "{error}");
}

#[test]
fn another_graph_is_refused() {
    let error = refusal(|g| g.operators[1].kind = Kind::AveragePool);
    assert_eq!(error, "operator 1 (pool) is AVERAGE_POOL_2D, must be MAX_POOL_2D");
    let error = refusal(|g| g.operators[0].options.stride = [3, 3]);
    assert_eq!(error, "stem: stride is [3, 3], must be [1, 1] or [2, 2]");
    let error = refusal(|g| g.operators[3].options.padding = 1);
    assert_eq!(error, "block 0 conv1: padding is 1, must be 0, SAME");
    let error = refusal(|g| g.operators[3].options.activation = 4);
    assert_eq!(error, "block 0 conv1: activation is TANH, must be NONE, RELU, RELU_N1_TO_1 or RELU6");
    let error = refusal(|g| g.operators[4].inputs[0] = 0);
    assert!(error.starts_with("block 0 conv2: input is 0, must be "), "{error}");
    let error = refusal(|g| g.tensors[0].shape[1] = 32);
    assert_eq!(error, "image: shape is [1, 32, 10, 1], must be [1, 64, frames, 1]");
    let error = refusal(|g| g.tensors[0].kind = super::schema::FLOAT32);
    assert_eq!(error, "tensor \"image\": type is FLOAT32, must be INT8");
    let error = refusal(|g| g.operators.truncate(11));
    assert_eq!(error, "operator 11 (logits) is missing, must be CONV_2D");
    let error = refusal(|g| {
        let last = g.operators.len() - 1;
        let again: Operator = g.operators[last].clone();
        g.operators.push(again);
    });
    assert_eq!(error, "number of operators behind the logits is 1, must be 0");
    let error = refusal(|g| g.tensors[0].shape[2] = 11);
    assert!(error.contains("metadata \"sdp3\" is for 10 frames, must be for 11, as the image"), "{error}");
    let error = refusal(|g| g.metadata[0].1 = Cow::Borrowed(b"SDP3"));
    assert!(error.contains("metadata \"sdp3\" is 4 bytes"), "{error}");
    // every truncation of a file
    let file = export(&network(1)).unwrap();
    for length in 0..file.len() - 4 {
        assert!(import(&file[..length], &import_defaults()).is_err(), "{length}");
    }
    let error = import(&file[..100], &import_defaults()).unwrap_err().to_string();
    assert!(error.starts_with("truncated or damaged: "), "{error}");
    let error = import(b"not a flatbuffer", &import_defaults()).unwrap_err().to_string();
    assert_eq!(error, "file identifier is a fl, must be TFL3");
}

#[test]
fn an_operator_the_network_does_not_have_is_named() {
    let file = export(&network(1)).unwrap();
    // the operator codes are written in the order of Kind::ALL: ADD is 0 in both fields, MAX_POOL_2D 17 becomes MEAN
    let mut foreign = file.clone();
    let places: Vec<usize> = (0..file.len() - 4)
        .filter(|&i| file[i..i + 4] == [17, 0, 0, 0] && file[i - 4..i] == [2, 0, 0, 0])
        .collect();
    for i in places {
        foreign[i] = 40;
    }
    let error = import(&foreign, &import_defaults()).unwrap_err().to_string();
    assert!(error.contains("operator 1 is MEAN, must be one of ADD, AVERAGE_POOL_2D, CONV_2D"), "{error}");
}
