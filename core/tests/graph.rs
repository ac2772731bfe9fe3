//! Graphs: what the parser refuses, and that steps, memory plan and interruptions change no bit.

use sdp3_core::dsn::ModelError;
use sdp3_core::dsn::winograd::{WinogradKernels, WinogradMemory};
use sdp3_core::graph::format::{HEADER_LEN, OPERATOR_LEN};
use sdp3_core::graph::{Graph, Kind, Progress};
use sdp3_core::simd::dual_mac::{DualMac, Plain};

const INPUT: usize = 6 * 5 * 2;

/// A convolution 3x3 of stride (1, 2) with three outputs, and the average of its output: `[6, 5, 2] -> [6, 3, 3] -> [1, 1, 3]`.
fn network() -> Vec<u8> {
    let mut parameters: Vec<u8> = [1 << 30, 1_900_000_000, 1_i32 << 30].map(i32::to_le_bytes).concat();
    parameters.extend([100, -2000, 31_i32].map(i32::to_le_bytes).concat());
    parameters.extend([-7_i8, -8, -6, 0].map(|shift| shift as u8));
    parameters.extend((0..3 * 9 * 2).map(|k| (k * 37 + 11) as u8));
    parameters.resize(parameters.len().next_multiple_of(4), 0);
    let mut operators = operator(1, [3, 3], [1, 2], [1, 1], [6, 5, 2], [6, 3, 3], [56, 0], &parameters);
    operators.extend(operator(5, [0, 0], [1, 1], [0, 0], [6, 3, 3], [1, 1, 3], [0, 56], &[]));
    let mut file = b"SDPG\x01\0\x02\0\0\0\0\0".to_vec();
    file.extend((56 + INPUT as u32).to_le_bytes());
    file.extend([6_u16, 5, 2].map(u16::to_le_bytes).as_flattened());
    file.extend([3, 4]);
    file.extend([0.5_f32, 0.25].map(f32::to_le_bytes).as_flattened());
    file.extend(56_u32.to_le_bytes());
    file.extend([0; 4]);
    assert_eq!(file.len(), HEADER_LEN);
    file.extend(operators);
    closed(file)
}

#[allow(clippy::too_many_arguments)] // a line of the layout
fn operator(
    kind: u8,
    window: [u8; 2],
    stride: [u8; 2],
    padding: [u8; 2],
    input: [u16; 3],
    output: [u16; 3],
    places: [u32; 2],
    parameters: &[u8],
) -> Vec<u8> {
    let mut bytes = vec![kind, 3, 4, 0x80, 0x7f, 0];
    bytes.extend([window, stride, padding].as_flattened());
    bytes.extend([input, output].as_flattened().iter().flat_map(|n| n.to_le_bytes()));
    bytes.extend([places[0], places[1], 0, parameters.len() as u32].map(u32::to_le_bytes).as_flattened());
    assert_eq!(bytes.len(), OPERATOR_LEN);
    bytes.extend(parameters);
    bytes
}

/// With length and checksum.
fn closed(mut file: Vec<u8>) -> Vec<u8> {
    let length = file.len() as u32 + 4;
    file[8..12].copy_from_slice(&length.to_le_bytes());
    let checksum = sdp3_core::crc32::crc32(&file);
    file.extend(checksum.to_le_bytes());
    file
}

fn altered(at: usize, bytes: &[u8]) -> Vec<u8> {
    let mut file = network();
    file.truncate(file.len() - 4);
    file[at..at + bytes.len()].copy_from_slice(bytes);
    closed(file)
}

fn outcome(at: usize, bytes: &[u8]) -> Result<(), ModelError> {
    Graph::parse(&altered(at, bytes)).map(|_| ())
}

fn image(seed: i32) -> Vec<i8> {
    (0..INPUT as i32).map(|k| (k * k * 13 + k * seed) as i8).collect()
}

/// All outputs, and the number of steps.
fn run(graph: &Graph<'_>, image: &[i8]) -> (Vec<i8>, usize) {
    let mut arena = vec![0; graph.arena()];
    graph.input_mut(&mut arena).copy_from_slice(image);
    let (mut progress, mut all) = (Progress::new(), Vec::new());
    for steps in 1.. {
        let step = graph.step(&mut progress, &mut arena).expect("it is not done");
        if step.done {
            all.extend_from_slice(&arena[step.node.output.range()]);
        }
        if step.last {
            assert_eq!(progress, Progress::new());
            assert!(all.ends_with(graph.output(&arena)));
            return (all, steps);
        }
    }
    unreachable!()
}

/// The convolution of [`network`] by its definition, in 64 bits, then the average.
fn by_definition(image: &[i8]) -> Vec<i8> {
    let weight = |o: usize, y: usize, x: usize, c: usize| {
        i64::from((((o * 9 + y * 3 + x) * 2 + c) * 37 + 11) as u8 as i8)
    };
    let (bias, multiplier, shift) =
        ([100, -2000, 31_i64], [1 << 30, 1_900_000_000, 1_i32 << 30], [-7, -8, -6]);
    let mut out = Vec::new();
    for (y, x, o) in (0..6 * 3 * 3).map(|k| (k / 9, k / 3 % 3, k % 3)) {
        let mut sum = bias[o];
        for (i, j, c) in (0..18).map(|k| (k / 6, k / 2 % 3, k % 2)) {
            let (row, column) = ((y + i).checked_sub(1), (2 * x + j).checked_sub(1));
            if let (Some(row @ 0..6), Some(column @ 0..5)) = (row, column) {
                sum += (i64::from(image[(row * 5 + column) * 2 + c]) - 3) * weight(o, i, j, c);
            }
        }
        let value = sdp3_core::fixed::requantize(sum as i32, multiplier[o], shift[o]) + 4;
        out.push(value.clamp(-128, 127) as i8);
    }
    for o in 0..3 {
        let sum: i32 = (0..18).map(|pixel| i32::from(out[3 * pixel + o])).sum();
        out.push(((f64::from(sum) / 18.0).abs() + 0.5).floor().copysign(f64::from(sum)) as i8);
    }
    out
}

#[test]
fn operators_are_their_definitions() {
    let file = network();
    let graph = Graph::parse(&file).expect("a graph");
    let kinds: Vec<_> = graph.nodes().map(|node| node.kind).collect();
    assert_eq!(kinds, [Some(Kind::Convolution), Some(Kind::AveragePool)]);
    assert_eq!((graph.bytes(), graph.products()), (file.len(), 54 * 18));
    assert_eq!((graph.scales(), graph.zero_points()), ([0.5, 0.25], [3, 4]));
    for seed in 0..20 {
        let (found, steps) = run(&graph, &image(seed));
        assert_eq!(found, by_definition(&image(seed)), "{seed}");
        assert_eq!(steps, 2, "small operators take a step each");
    }
}

#[test]
fn a_large_window_is_gathered_in_parts() {
    // 40 x 40 of 41 x 40 values with a row of padding before: two outputs of five channels
    let weight = |k: usize| (k * 53 + 7) as u8;
    let mut parameters =
        [[1_500_000_000_i32; 5].map(i32::to_le_bytes), [90_000; 5].map(i32::to_le_bytes)].concat().concat();
    parameters.extend([0xf4; 5]); // -12
    parameters.resize(parameters.len().next_multiple_of(4), 0);
    parameters.extend((0..5 * 1600).map(weight));
    let operators = operator(1, [40, 40], [1, 1], [1, 0], [41, 40, 1], [2, 1, 5], [12, 0], &parameters);
    let mut file = b"SDPG\x01\0\x01\0\0\0\0\0".to_vec();
    file.extend((12 + 1640_u32).to_le_bytes());
    file.extend([41_u16, 40, 1].map(u16::to_le_bytes).as_flattened());
    file.extend([3, 4]);
    file.extend([0.5_f32, 0.25].map(f32::to_le_bytes).as_flattened());
    file.extend(12_u32.to_le_bytes());
    file.extend([0; 4]);
    file.extend(operators);
    let file = closed(file);
    let graph = Graph::parse(&file).expect("a graph");
    let image: Vec<i8> = (0..1640).map(|k| (k * k + 3 * k) as i8).collect();
    let (found, _) = run(&graph, &image);
    let expected = (0..10).map(|k| {
        let (y, o) = (k / 5, k % 5);
        let products = (0..1600_usize).filter_map(|tap| {
            let at = (y * 40 + tap).checked_sub(40)?;
            Some((i32::from(image[at]) - 3) * i32::from(weight(1600 * o + tap) as i8))
        });
        let sum = 90_000 + products.sum::<i32>();
        (sdp3_core::fixed::requantize(sum, 1_500_000_000, -12) + 4).clamp(-128, 127) as i8
    });
    assert_eq!(found, expected.collect::<Vec<_>>());
    assert!(found.iter().any(|&value| value.unsigned_abs() < 127), "{found:?}");
}

/// A 3x3 convolution of stride 1 over `[height, width, inputs]`; the last output has this shift.
fn convolution((height, width): (u16, u16), inputs: u16, outputs: u16, last: i8) -> Vec<u8> {
    let count = usize::from(outputs);
    let mut parameters =
        vec![1_300_000_000_i32; count].into_iter().flat_map(i32::to_le_bytes).collect::<Vec<_>>();
    parameters.extend((0..i32::from(outputs)).flat_map(|o| (o * 37 - 500).to_le_bytes()));
    parameters.extend(vec![-9_i8 as u8; count - 1]);
    parameters.push(last as u8);
    parameters.extend((0..count * 9 * usize::from(inputs)).map(|k| (k * k * 31 + k * 7 + 11) as u8));
    let shape = |channels| [height, width, channels];
    let [input, output] =
        [inputs, outputs].map(|channels| u32::from(height) * u32::from(width) * u32::from(channels));
    let operators =
        operator(1, [3, 3], [1, 1], [1, 1], shape(inputs), shape(outputs), [output, 0], &parameters);
    let mut file = b"SDPG\x01\0\x01\0\0\0\0\0".to_vec();
    file.extend((output + input).to_le_bytes());
    file.extend(shape(inputs).map(u16::to_le_bytes).as_flattened());
    file.extend([3, 4]);
    file.extend([0.5_f32, 0.25].map(f32::to_le_bytes).as_flattened());
    file.extend(output.to_le_bytes());
    file.extend([0; 4]);
    file.extend(operators);
    closed(file)
}

/// The outputs by the kernels over `mac`, and whether the plain loops ended it.
fn by_kernels<P: DualMac>(graph: &Graph<'_>, image: &[i8], mac: P) -> (Vec<i8>, bool) {
    let sizes = graph.winograd_sizes();
    let (mut vectors, mut words) = (vec![[0; 4]; sizes.vectors], vec![0; sizes.words]);
    let memory = WinogradMemory { vectors: &mut vectors, words: &mut words };
    let mut kernels = WinogradKernels::shared_with_mac(mac, memory);
    let (mut arena, mut scratch) = (vec![0; graph.arena()], vec![0; graph.kernel_scratch()]);
    graph.input_mut(&mut arena).copy_from_slice(image);
    let mut progress = Progress::new();
    loop {
        let step =
            graph.step_by(&mut progress, &mut arena, &mut kernels, &mut scratch).expect("it is not done");
        if step.last {
            return (graph.output(&arena).to_vec(), kernels.is_portable());
        }
    }
}

#[test]
fn the_kernels_of_wide_and_of_colour_convolutions_change_no_bit() {
    for (inputs, outputs) in [(3, 8), (3, 16), (3, 32), (64, 64), (8, 8), (16, 16), (32, 32)] {
        // one, two and more blocks, whole and in part
        for size in [(6, 3), (5, 4), (8, 5), (9, 8), (1, 18), (18, 6)] {
            // no kernel has a shift of -21: of 64 channels it is met after three quarters are computed
            for (last, plain) in [(-8, false), (-21, true)] {
                let file = convolution(size, inputs, outputs, last);
                let graph = Graph::parse(&file).expect("a graph");
                assert!(graph.nodes().all(|node| node.is_covered()), "{inputs} to {outputs}");
                let image: Vec<i8> =
                    (0..graph.input().bytes() as i32).map(|k| (k * k * 17 + k * 5) as i8).collect();
                let expected = run(&graph, &image).0;
                assert!(expected.iter().filter(|value| value.unsigned_abs() < 127).count() > 20);
                let found = by_kernels(&graph, &image, Plain::<false>);
                assert_eq!(found, (expected.clone(), plain), "{inputs} to {outputs}, {size:?}");
                assert_eq!(by_kernels(&graph, &image, Plain::<true>), (expected, plain), "in the wide order");
            }
        }
    }
    for (inputs, outputs) in [(3, 64), (4, 16), (16, 32), (64, 32)] {
        let file = convolution((6, 4), inputs, outputs, -8);
        assert!(Graph::parse(&file).is_ok_and(|graph| graph.nodes().all(|node| !node.is_covered())));
    }
}

#[test]
fn every_field_has_its_range() {
    assert_eq!(outcome(0, b"SDPG"), Ok(()));
    let field = |at: usize, bytes: &[u8], name: &'static str| match outcome(at, bytes) {
        Err(ModelError::Field { name: found, .. }) => assert_eq!(found, name, "byte {at}: {bytes:?}"),
        other => panic!("byte {at}: {bytes:?}: {other:?}, not {name}"),
    };
    assert_eq!(outcome(0, b"SDP3"), Err(ModelError::Magic));
    assert_eq!(outcome(4, &[2]), Err(ModelError::Version { found: 2 }));
    field(6, &[0, 0], "graph.operators");
    field(6, &[1, 1], "graph.operators");
    field(12, &[0; 4], "graph.arena");
    field(12, &[0, 0, 0, 2], "graph.arena");
    field(16, &[0, 0], "graph.input");
    field(32, &[57], "graph.input");
    for (at, scale) in [(24, 0.0_f32), (28, -1.0), (24, f32::NAN), (28, f32::INFINITY)] {
        field(at, &scale.to_le_bytes(), "graph.scale");
    }
    field(36, &[1], "graph.reserved");
    let (first, second) = (HEADER_LEN, HEADER_LEN + OPERATOR_LEN + 28 + 56);
    for kind in [0, 8, 255] {
        field(first, &[kind], "operator.kind");
    }
    field(first + 3, &[8, 7], "operator.act_min");
    field(first + 8, &[0], "operator.stride");
    field(first + 10, &[3], "operator.padding");
    field(first + 24, &[57], "operator.input");
    field(first + 12, &[0, 0], "operator.input");
    field(first + 28, &[3], "operator.output"); // overlaps the input
    field(first + 18, &[8], "operator.output"); // a window beyond the input
    field(first + 32, &[4], "operator.second");
    field(first + 16, &[1], "operator.parameters");
    field(first + OPERATOR_LEN, &[1, 0, 0, 0], "operator.multiplier");
    field(first + OPERATOR_LEN + 24, &[8], "operator.shift");
    field(second + 22, &[2], "operator.channels");
    field(second, &[6], "operator.channels"); // a softmax keeps its shape
    field(second, &[7], "operator.parameters");
    for at in 36..40 {
        assert!(outcome(first + at, &[0xff]).is_err() && outcome(second + at, &[0xff]).is_err());
    }
}

#[test]
fn a_part_or_a_changed_byte_is_no_graph() {
    let file = network();
    for length in 0..file.len() {
        assert!(Graph::parse(&file[..length]).is_err(), "{length}");
    }
    for at in 0..file.len() {
        let mut file = file.clone();
        file[at] ^= 0x10;
        assert!(Graph::parse(&file).is_err(), "{at}");
    }
}

#[test]
fn whatever_is_parsed_runs() {
    let length = network().len() - 4;
    let mut sound = 0;
    for at in (HEADER_LEN..length).filter(|at| !(8..12).contains(at)) {
        for value in [0, 1, 2, 7, 0x7f, 0x80, 0xff] {
            let file = altered(at, &[value]);
            if let Ok(graph) = Graph::parse(&file) {
                sound += 1;
                run(&graph, &vec![-1; graph.input().bytes()]);
            }
        }
    }
    assert!(sound > 500, "{sound}");
}

#[test]
fn an_arena_that_is_too_short_gives_nothing() {
    let file = network();
    let graph = Graph::parse(&file).expect("a graph");
    assert!(graph.input_mut(&mut [0; 100]).is_empty() && graph.output(&[0; 58]).is_empty());
    let mut arena = vec![0; graph.arena()];
    let mut progress = Progress::new();
    assert!(graph.step(&mut progress, &mut arena).is_some_and(|step| !step.last));
    assert!(graph.step(&mut progress, &mut arena[1..]).is_none());
    assert_eq!(progress, Progress::new());
    let longer = &mut vec![0; graph.arena() + 5];
    assert!(graph.step(&mut Progress::new(), longer).is_some());
}

#[test]
fn progress_of_another_graph_gives_nothing() {
    let (file, other) = (network(), altered(3 + HEADER_LEN + OPERATOR_LEN, &[0x41]));
    let single = convolution((6, 4), 4, 4, -8);
    let graph = Graph::parse(&file).expect("a graph");
    let mut arena = vec![0; 1 << 10];
    for file in [&other, &single] {
        let other = Graph::parse(file).expect("a graph");
        let mut progress = Progress::new();
        graph.step(&mut progress, &mut arena).expect("it is not done");
        assert!(other.step(&mut progress, &mut arena).is_none());
        assert_eq!(progress, Progress::new());
        assert!(other.step(&mut progress, &mut arena).is_some(), "from the beginning");
    }
    // a number that somebody else wrote
    let mut progress = Progress::new();
    progress.operator = 1;
    assert!(graph.step(&mut progress, &mut arena).is_none());
    graph.step(&mut progress, &mut arena).expect("it is not done");
    progress.operator = u32::MAX;
    assert!(graph.step(&mut progress, &mut arena).is_none());
    graph.step(&mut progress, &mut arena).expect("it is not done");
    progress.operator = 0;
    assert!(graph.step(&mut progress, &mut arena).is_some_and(|step| step.last));
}
