//! Any bytes are a graph or refused; one that is taken runs to its end in its own arena.
#![no_main]

use libfuzzer_sys::fuzz_target;
use sdp3_core::graph::{Graph, Progress};
use sdp3_fuzz::set_checksum;

/// Multiply-accumulates of a graph that is run: sound ones can be slow.
const PRODUCTS: u64 = 1 << 20;

fn judge(file: &[u8], image: &[u8]) {
    let Ok(graph) = Graph::parse(file) else { return };
    assert_eq!((graph.bytes(), graph.nodes().count() > 0), (file.len(), true));
    let values: u64 = graph.nodes().map(|node| (node.output.bytes() * node.taps()) as u64).sum();
    if values > PRODUCTS {
        return;
    }
    let mut arena: Vec<i8> =
        (0..graph.arena()).map(|k| image.get(k % image.len().max(1)).map_or(0, |&b| b as i8)).collect();
    let mut progress = Progress::new();
    while let Some(step) = graph.step(&mut progress, &mut arena) {
        if step.last {
            break;
        }
    }
    assert_eq!(graph.output(&arena).len(), graph.output_tensor().bytes());
}

fuzz_target!(|data: &[u8]| {
    judge(data, data);
    // the same content behind an envelope that is whole
    if data.len() >= 84 {
        let mut file = data.to_vec();
        file[..6].copy_from_slice(b"SDPG\x01\0");
        set_checksum(&mut file);
        judge(&file, data);
    }
});
