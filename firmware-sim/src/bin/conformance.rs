//! Runs every case of a suite through the core and prints the digest of every stage.
//!
//! Arguments: the suite file; `log=FILE` for defmt records; `dump=STAGE:FILE` for all values of one stage, little-endian.
#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(not(target_os = "none"))]
fn main() {
    eprintln!("this is firmware: build it with firmware-sim/build");
}

#[cfg(target_os = "none")]
mod firmware {
    use core::fmt::Arguments;
    use sdp3_conformance::{Machine, run};
    use sdp3_core::dsn::scratch_bytes;
    use sdp3_core::pipeline::PipelineMemory;
    use sdp3_core::values::{Sink, Stage, Values};
    use sdp3_firmware_sim::log;
    use sdp3_firmware_sim::rt::{instructions, paint_stack, stack_used, start_counter};
    use sdp3_firmware_sim::semihosting::{File, arguments, exit, println};
    use sdp3_firmware_sim::static_cell::ConstStaticCell;

    /// The largest configuration: a slot of 2048 complex samples and as many references, 1000 slots, 110 frames, 16 channels behind a
    /// stride of 1. Places for one convolution of 32 channels, four of 16, or 16 of 8: some are packed ahead, some when they run.
    type Memory = PipelineMemory<2048, 1000, { scratch_bytes(110, 16, 1).div_ceil(8) }, 2048, 4096>;
    static MEMORY: ConstStaticCell<Memory> = ConstStaticCell::new(Memory::new());
    static SLOT: ConstStaticCell<[i16; 4096]> = ConstStaticCell::new([0; 4096]);
    static MODEL: ConstStaticCell<[u8; 1 << 17]> = ConstStaticCell::new([0; 1 << 17]);

    /// The suite in a file of the emulator's host.
    struct Emulator(File);

    impl Emulator {
        /// Goes on reading at this byte.
        fn seek(&mut self, at: usize) -> bool {
            self.0.position() == at || self.0.seek(at)
        }
    }

    impl Machine for Emulator {
        fn read(&mut self, at: usize, buffer: &mut [u8]) -> bool {
            self.seek(at) && self.0.read(buffer)
        }
        fn read_values(&mut self, at: usize, buffer: &mut [i16]) -> bool {
            self.seek(at) && self.0.read_values(buffer)
        }
        fn print(&mut self, line: Arguments<'_>) {
            println(line);
        }
        fn count(&mut self) -> u64 {
            instructions()
        }
        fn stack(&mut self) -> usize {
            stack_used()
        }
    }

    /// One stage's values on their way to a file, if they are wanted.
    struct Dump {
        to: Option<(Stage, File)>,
        buffer: heapless::Vec<u8, 4096>,
    }

    impl Dump {
        fn flush(&mut self) {
            if self.to.as_mut().is_some_and(|(_, file)| !file.write(&self.buffer)) {
                fail("the values cannot be written");
            }
            self.buffer.clear();
        }
    }

    impl Sink for Dump {
        fn value<const N: usize>(&mut self, stage: Stage, bytes: [u8; N]) {
            if !self.to.as_ref().is_some_and(|(wanted, _)| *wanted == stage) {
                return;
            }
            if self.buffer.extend_from_slice(&bytes).is_err() {
                self.flush();
                let _ = self.buffer.extend_from_slice(&bytes); // it is empty now
            }
        }
    }

    /// `STAGE:FILE`.
    fn dump(text: &str) -> (Stage, File) {
        let Some((stage, path)) = text.split_once(':') else { fail("dump=STAGE:FILE has no colon") };
        let Some(stage) = Stage::named(stage) else { fail("no such stage") };
        let Some(file) = File::create(path) else { fail("the file for values cannot be made") };
        (stage, file)
    }

    /// Ends the run with a message and exit code 2.
    fn fail(what: &str) -> ! {
        defmt::error!("{=str}", what);
        println(format_args!("error: {what}"));
        exit(2)
    }

    #[allow(unsafe_code)] // the symbol that start-up calls
    #[unsafe(no_mangle)]
    extern "C" fn firmware_main() -> ! {
        paint_stack();
        start_counter();
        let mut buffer = [0; 1024];
        let mut words = arguments(&mut buffer).split_ascii_whitespace();
        let Some(path) = words.next() else { fail("no suite file given") };
        let mut values = Values(Dump { to: None, buffer: heapless::Vec::new() });
        for word in words {
            match word.split_once('=') {
                Some(("log", path)) if log::open(path) => (),
                Some(("dump", text)) => values.0.to = Some(dump(text)),
                _ => fail("an argument is neither log=FILE nor dump=STAGE:FILE"),
            }
        }
        let Some(file) = File::open(path) else { fail("the suite file cannot be opened") };
        let mut machine = Emulator(file);
        if let Err(failure) = run(&mut machine, MEMORY.take(), SLOT.take(), MODEL.take(), &mut values) {
            failure.report(&mut machine);
            exit(2)
        }
        values.0.flush();
        exit(0)
    }
}
