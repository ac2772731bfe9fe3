//! Runs a graph on one input and prints the checksum and the instructions of every operator: `work <operator> <crc32> <instructions>`.
//!
//! Both are files of the machine that runs the emulator: `network.graph` and `input.bin` in its folder.
#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(not(target_os = "none"))]
fn main() {
    eprintln!("this is firmware: build it with firmware-sim/build");
}

#[cfg(target_os = "none")]
mod firmware {
    use sdp3_core::crc32::Crc32;
    use sdp3_core::dsn::winograd::{WinogradKernels, WinogradMemory};
    use sdp3_core::graph::{Kind, Progress};
    use sdp3_core::simd::dual_mac::I16x8;
    use sdp3_firmware_sim::graph_files::{fail, load};
    use sdp3_firmware_sim::rt::{Single, instructions, start_counter};
    use sdp3_firmware_sim::semihosting::{exit, println};

    static NETWORK: Single<[u8; 1 << 18]> = Single::new([0; 1 << 18]);
    static INPUT: Single<[u8; 1 << 16]> = Single::new([0; 1 << 16]);
    static ARENA: Single<[i8; 1 << 17]> = Single::new([0; 1 << 17]);
    static SCRATCH: Single<[i8; 1 << 14]> = Single::new([0; 1 << 14]);
    static VECTORS: Single<[I16x8; 1 << 12]> = Single::new([[0; 4]; 1 << 12]);
    static WORDS: Single<[i32; 1 << 9]> = Single::new([0; 1 << 9]);

    #[allow(unsafe_code)] // the symbol that start-up calls
    #[unsafe(no_mangle)]
    extern "C" fn firmware_main() -> ! {
        start_counter();
        let (Some(network), Some(input), Some(arena)) = (NETWORK.take(), INPUT.take(), ARENA.take()) else {
            fail("memory is taken")
        };
        let graph = load(network, input, arena);
        let sizes = graph.winograd_sizes();
        let (Some(scratch), Some(vectors), Some(words)) = (SCRATCH.take(), VECTORS.take(), WORDS.take())
        else {
            fail("memory is taken")
        };
        if graph.kernel_scratch() > scratch.len()
            || sizes.vectors > vectors.len()
            || sizes.words > words.len()
        {
            fail("the memory of the kernels is too small")
        }
        let mut kernels = WinogradKernels::shared(WinogradMemory { vectors, words });
        let (mut progress, mut all, mut largest) = (Progress::new(), 0, 0);
        let mut operator = 0;
        loop {
            let before = instructions();
            let step = graph.step_by(&mut progress, arena, &mut kernels, scratch);
            let count = instructions() - before;
            let Some(step) = step else { fail("a step is missing") };
            (operator, largest) = (operator + count, largest.max(count));
            if step.done {
                let values = arena.get(step.node.output.range()).unwrap_or(&[]);
                let checksum =
                    values.iter().fold(Crc32::new(), |sum, &value| sum.update(&[value as u8])).finish();
                let kind = step.node.kind.map_or("", Kind::name);
                println(format_args!("work {}-{kind} {checksum:08x} {operator}", step.operator));
                (all, operator) = (all + operator, 0);
            }
            if step.last {
                break;
            }
        }
        let memory = graph.arena() + graph.kernel_scratch() + sizes.total();
        println(format_args!("all {all} largest-step {largest} memory {memory}"));
        exit(0)
    }
}
