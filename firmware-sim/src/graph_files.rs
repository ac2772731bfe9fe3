//! A network and its first input, from files of the machine that runs the emulator: `network.graph` and `input.bin` in its folder.

use crate::semihosting::{exit, file_into, println};
use sdp3_core::graph::Graph;

/// Reads both into memory, and the input into the arena; ends the program if they do not fit.
pub fn load<'a>(network: &'a mut [u8], input: &mut [u8], arena: &mut [i8]) -> Graph<'a> {
    let Some(network) = file_into("network.graph", network) else {
        fail("no network.graph, or it is too large")
    };
    let Some(input) = file_into("input.bin", input) else { fail("no input.bin, or it is too large") };
    let Ok(graph) = Graph::parse(network) else { fail("network.graph is refused") };
    if graph.arena() > arena.len() || graph.input().bytes() != input.len() {
        fail("the arena is too small, or the input is another network's")
    }
    for (to, from) in graph.input_mut(arena).iter_mut().zip(input) {
        *to = *from as i8;
    }
    graph
}

/// Says what is wrong and ends the program with exit code 2.
pub fn fail(what: &str) -> ! {
    println(format_args!("error: {what}"));
    exit(2)
}
