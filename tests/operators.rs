//! Any int8 network: LiteRT's own answers for small files of every operator, files that are refused, and the paper's network as a graph.
//!
//! The vectors and the Python program that made them are `tests/oracles/operators.{json,py}`; `tests/networks` compares whole networks.

use rand_core::SeedableRng;
use rand_xoshiro::Xoshiro256PlusPlus;
use sdp3::formats::graph_file::{GraphNetwork, Operator};
use sdp3::formats::model_file::{QuantizedNetwork, with_graph};
use sdp3::formats::tflite::{ImportDefaults, export, import_graph, import_model};
use sdp3::network::interchange::header;
use sdp3::network::operator_outputs::Network;
use sdp3::network::parameters::Architecture;
use sdp3_core::dsn::winograd::{WinogradKernels, WinogradMemory};
use sdp3_core::dsn::{Model, Portable};
use sdp3_core::graph::{Graph, Kind, Progress, Window};
use sdp3_core::selftest;
use sdp3_tests::networks::{images, layers, quantized};
use sdp3_tests::vectors::{bytes, list, signed};
use sdp3_tests::{call, outcome, program};
use serde_json::Value;

fn golden() -> Value {
    serde_json::from_str(include_str!("oracles/operators.json")).expect("JSON")
}

#[test]
fn every_operator_has_litert_s_bits() {
    let (mut compared, golden) = (0, golden());
    for case in list(&golden["cases"]) {
        let graph = import_graph(&bytes(&case["file"])).unwrap_or_else(|e| panic!("{}: {e}", case["name"]));
        let network = Network::parse(&graph).unwrap_or_else(|e| panic!("{}: {e}", case["name"]));
        let found = network.run(&signed(&case["inputs"]), true).expect("inputs");
        let expected = signed(&case["layers"]);
        assert_eq!(found.len(), expected.len(), "{}", case["name"]);
        let first = found.iter().zip(&expected).position(|(a, b)| a != b);
        assert_eq!(first, None, "{}", case["name"]);
        compared += found.len();
    }
    assert_eq!((list(&golden["cases"]).len(), compared), (71, 12_544));
}

#[test]
fn what_the_core_does_not_have_is_refused_by_name() {
    let golden = golden();
    for case in list(&golden["refused"]) {
        let message = case["message"].as_str().expect("text");
        match import_graph(&bytes(&case["file"])) {
            Ok(_) => panic!("{} is taken", case["name"]),
            Err(error) => {
                let error = error.to_string();
                assert!(error.contains(message), "{}: {error}, without {message:?}", case["name"]);
            }
        }
    }
    assert!(list(&golden["refused"]).len() >= 30);
}

/// Networks of the paper's topology, for 200 sensing slots.
fn exported() -> Vec<(QuantizedNetwork, Vec<u8>)> {
    let architecture = |channels, stem_stride| Architecture { channels, blocks: 2, stem_stride, classes: 5 };
    [(8, 1), (16, 2), (4, 2)]
        .map(|(channels, stem_stride)| {
            let network = quantized(architecture(channels, stem_stride), 10, 3);
            let file = export(&network).expect("a file");
            (network, file)
        })
        .into()
}

#[test]
fn the_papers_network_as_a_graph_has_the_same_bits() {
    for (network, file) in exported() {
        let model = network.to_bytes().expect("a model file");
        let graph = import_graph(&file).expect("a graph");
        let made = images(10, 16, 2, 5);
        for k in 0..made.len() {
            // the stem before its pooling is no layer of the paper's network, which never holds it
            let expected = layers(&model, made.image(k)).concat();
            let found = Network::parse(&graph).expect("a graph").run(made.image(k), true).expect("an image");
            assert!(found.ends_with(&expected), "image {k}");
        }
    }
}

#[test]
fn the_kernels_of_firmware_change_no_bit_of_a_graph() {
    for (network, file) in exported() {
        let bytes = import_graph(&file).expect("a graph");
        let graph = Graph::parse(&bytes).expect("a graph");
        let covered = graph.nodes().filter(|node| node.is_covered()).count();
        // four channels are too few for a convolution
        assert_eq!(covered, if network.channels() == 4 { 4 } else { 8 });
        let sizes = graph.winograd_sizes();
        let (mut vectors, mut words) = (vec![[0; 4]; sizes.vectors], vec![0; sizes.words]);
        let memory = WinogradMemory { vectors: &mut vectors, words: &mut words };
        let (mut kernels, mut scratch) = (WinogradKernels::shared(memory), vec![0; graph.kernel_scratch()]);
        let made = images(10, 16, 2, 5);
        for k in 0..made.len() {
            let mut arena = vec![0; graph.arena()];
            graph.input_mut(&mut arena).copy_from_slice(made.image(k));
            let (mut progress, mut found) = (Progress::new(), Vec::new());
            loop {
                let step =
                    graph.step_by(&mut progress, &mut arena, &mut kernels, &mut scratch).expect("a step");
                if step.done {
                    assert!(!step.node.is_covered() || !kernels.is_portable(), "operator {}", step.operator);
                    found.extend_from_slice(&arena[step.node.output.range()]);
                }
                if step.last {
                    break;
                }
            }
            let expected =
                Network::parse(&bytes).expect("a graph").run(made.image(k), true).expect("an image");
            assert_eq!(found, expected, "image {k}");
        }
    }
}

#[test]
fn a_model_with_a_graph_is_classified_like_the_papers_network() {
    for (network, file) in exported() {
        let graph = import_graph(&file).expect("a graph");
        let model = with_graph(&network.preprocessing, &network.classes, &graph).expect("a model file");
        let plain = network.to_bytes().expect("a model file");
        let [model, plain] = [&model, &plain].map(|file| Model::parse(file).expect("a model"));
        assert_eq!((model.channels(), model.graph().map(|graph| graph.nodes().count())), (0, Some(12)));
        assert_eq!(model.shape().scratch_bytes(), model.graph().expect("a graph").arena());
        assert_eq!(model.logit_scale(), plain.logit_scale());
        let made = images(10, 16, 2, 5);
        let classify =
            |model, image: &[i8]| sdp3::network::inference::Classifier::new(model).classify(image, &mut ());
        for k in 0..made.len() {
            assert_eq!(classify(model, made.image(k)), classify(plain, made.image(k)), "image {k}");
        }
    }
}

#[test]
fn the_self_test_of_a_graph_passes_with_the_kernels_of_firmware() {
    let (network, file) = exported().remove(1);
    let graph = import_graph(&file).expect("a graph");
    let bytes = with_graph(&network.preprocessing, &network.classes, &graph).expect("a model file");
    let model = Model::parse(&bytes).expect("a model");
    let sizes = model.shape().winograd_sizes();
    let (mut vectors, mut words) = (vec![[0; 4]; sizes.vectors], vec![0; sizes.words]);
    let memory = WinogradMemory { vectors: &mut vectors, words: &mut words };
    let mut kernels = WinogradKernels::new(&model, memory).expect("memory of its sizes");
    // a longer scratch than its own: the image lies at the end
    let mut scratch = vec![0; model.shape().scratch_bytes() + 100];
    let found =
        selftest::network(&model, &mut scratch, &mut kernels, &mut Xoshiro256PlusPlus::seed_from_u64(1));
    assert_eq!(found, None);
    // one operator alone
    let operators = GraphNetwork {
        activations: vec![[64, 10, 1], [1, 1, 5]],
        operators: vec![Operator {
            kind: Kind::FullyConnected,
            input: 0,
            input_shape: [64, 10, 1],
            second: None,
            output: 1,
            window: Window { size: [0; 2], stride: [1; 2], padding: [0; 2] },
            zero_points: [0; 3],
            activation: [-128, 127],
            parameters: [[0.01_f64.to_le_bytes(); 5].concat(), vec![0; 20], vec![1; 640 * 5]].concat(),
        }],
        input: 0,
        grids: vec![(1.0, 0); 2],
    };
    let graph = operators.to_bytes().expect("a graph");
    let bytes = with_graph(&network.preprocessing, &network.classes, &graph).expect("a model file");
    let model = Model::parse(&bytes).expect("a model");
    let mut scratch = vec![0; model.shape().scratch_bytes()];
    assert_eq!(
        selftest::network(&model, &mut scratch, &mut Portable, &mut Xoshiro256PlusPlus::seed_from_u64(1)),
        None
    );
}

#[test]
fn a_network_of_another_topology_becomes_a_radar_model_or_says_why_not() {
    let preprocessing = header(&sdp3_tests::printed_room(), 0);
    let defaults = ImportDefaults { preprocessing, sensing_slots: vec![200], classes: Vec::new() };
    let golden = golden();
    let mut refused = 0;
    for case in list(&golden["cases"]) {
        // none of them takes an image of 64 rows
        let error = import_model(&bytes(&case["file"]), &defaults).expect_err("no radar model").to_string();
        assert!(error.contains("a network of other sizes is imported as FILE.graph"), "{error}");
        refused += 1;
    }
    assert_eq!(refused, 71);
}

#[test]
fn commands_import_show_and_run_a_graph() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = |name: &str| folder.path().join(name).display().to_string();
    let run = |arguments: &[&str]| outcome(&call(&program(), arguments));
    let golden = golden();
    let case = &list(&golden["cases"])[0];
    std::fs::write(at("n.tflite"), bytes(&case["file"])).expect("a file");
    assert_eq!(run(&["import", &at("n.tflite"), "--to", &at("n.graph")]).0, 0);
    let (code, shown, _) = run(&["model", "show", &at("n.graph"), "--json"]);
    let shown: Value = serde_json::from_str(&shown).expect("JSON");
    let shape = list(&shown["operators"][0]["input"]).iter().map(ToString::to_string).collect::<Vec<_>>();
    let (inputs, count) = (bytes(&case["inputs"]), &case["count"]);
    assert_eq!((code, shape.len()), (0, 3));
    let header = |descr: &str, rows: &str| {
        let axes = [&count.to_string(), rows, &shape[1], &shape[2]].map(str::to_owned).join(", ");
        format!("{:<117}\n", format!("{{'descr': '{descr}', 'fortran_order': False, 'shape': ({axes}), }}"))
    };
    let write = |name: &str, header: String| {
        let content = [b"\x93NUMPY\x01\x00\x76\x00", header.as_bytes(), &inputs].concat();
        std::fs::write(at(name), content).expect("a file");
    };
    write("in.npy", header("|i1", &shape[0]));
    assert_eq!(run(&["infer", &at("n.graph"), &at("in.npy"), "--to", &at("out.npy"), "--layers"]).0, 0);
    let found = std::fs::read(at("out.npy")).expect("a file");
    assert!(found.ends_with(&bytes(&case["layers"])) && found.starts_with(b"\x93NUMPY"));
    // inputs of another shape or type, and a file that is no network
    for (descr, rows, words) in [("|i1", "1000", "shape"), ("<f4", &shape[0], "type")] {
        write("bad.npy", header(descr, rows));
        let (code, _, error) = run(&["infer", &at("n.graph"), &at("bad.npy"), "--to", &at("none.npy")]);
        assert!(code == 2 && error.contains(words) && error.contains("bad.npy"), "{code} {error}");
    }
    let (code, _, error) = run(&["infer", &at("in.npy"), &at("in.npy"), "--to", &at("none.npy")]);
    assert!(code == 2 && error.contains("in.npy"), "{code} {error}");
    assert!(!std::path::Path::new(&at("none.npy")).exists());
}
