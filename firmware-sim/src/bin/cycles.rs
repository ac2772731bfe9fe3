//! Instructions and cycles of every stage of a recognition at N_s = 200 and 1000, and of a slot's decision, by the processor's own
//! counters; `tests/cycles` runs it on the RTL of two RISC-V cores.
//!
//! A line `stage <N_s> <stage> <events> <instructions> <cycles>` for each stage, 0 without such counters, and `digest <N_s> <what>
//! <digest>` of the values. The entry of the table `firmware_marks` that begins the measurement of network k is 32 k + 31, and the
//! one that ends it for stage s 32 k + s; a line `mark <number> <N_s> <stage>` says so.
#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(not(target_os = "none"))]
fn main() {
    eprintln!("this is firmware: build it with firmware-sim/build");
}

#[cfg(target_os = "none")]
mod firmware {
    use rand_core::SeedableRng;
    use sdp3_core::config::RadarConfig;
    use sdp3_core::digest::Digest;
    use sdp3_core::dims::{Beat, Complex, FFT_LEN};
    use sdp3_core::dsn::{Model, Shape};
    use sdp3_core::early_exit::EarlyExit;
    use sdp3_core::pipeline::{Pipeline, PipelineBuffers};
    use sdp3_core::probe::Probe;
    use sdp3_core::scheduler::{Plan, Sequencer, SlotUse};
    use sdp3_core::signal::clutter::Gram;
    use sdp3_core::{pipeline_memory, selftest};
    use sdp3_firmware_sim::rt::{counters, mark};
    use sdp3_firmware_sim::semihosting::{exit, println};
    use sdp3_firmware_sim::static_cell::ConstStaticCell;
    use sdp3_testkit::models::{DSN_200, DSN_1000};
    use sdp3_testkit::signals::noise;

    const SMALL: Shape = Shape::of(DSN_200).expect("a model");
    const LARGE: Shape = Shape::of(DSN_1000).expect("a model");
    static SMALL_MEMORY: ConstStaticCell<pipeline_memory!(SMALL)> =
        ConstStaticCell::new(<pipeline_memory!(SMALL)>::new());
    static LARGE_MEMORY: ConstStaticCell<pipeline_memory!(LARGE)> =
        ConstStaticCell::new(<pipeline_memory!(LARGE)>::new());

    /// What is measured; `Nothing` is the cost of measuring.
    #[derive(Clone, Copy)]
    enum Stage {
        Nothing,
        Decision,
        Dechirp,
        Gram,
        Eigenvectors,
        Projection,
        Frames,
        Quantisation,
        Stem,
        BatchNorm,
        Convolution,
        Addition,
        Head,
        Softmax,
    }

    const NAMES: [&str; 14] = [
        "nothing",
        "decision",
        "dechirp",
        "gram",
        "eigenvectors",
        "projection",
        "frames",
        "quantisation",
        "stem",
        "batch-norm",
        "convolution",
        "addition",
        "head",
        "softmax",
    ];

    /// Sums instructions and cycles by stage: what was done since the last event belongs to the next.
    struct Stages {
        /// The first of this network's marks.
        marks: usize,
        last: [u32; 2],
        empty: [u32; 2],
        sums: [[u32; 2]; NAMES.len()],
        events: [u32; NAMES.len()],
        image: Digest,
        logits: Digest,
        class: u8,
    }

    impl Stages {
        fn new(network: usize) -> Self {
            let none = [0; NAMES.len()];
            let mut stages = Stages {
                marks: 32 * network,
                last: [0; 2],
                empty: [0; 2],
                sums: [[0; 2]; NAMES.len()],
                events: none,
                image: Digest::new(),
                logits: Digest::new(),
                class: u8::MAX,
            };
            // the second time the code is in the caches
            for _ in 0..2 {
                stages.empty = [0; 2];
                stages.sums = [[0; 2]; NAMES.len()];
                stages.events = none;
                stages.start();
                stages.add(Stage::Nothing);
                stages.empty = stages.sums[Stage::Nothing as usize];
            }
            stages
        }

        /// Forgets what was done since the last event.
        #[inline(never)] // else the builds for QEMU and for RTL inline differently, and their instructions differ
        fn start(&mut self) {
            mark(self.marks + 31);
            self.last = counters();
        }

        #[inline(never)]
        fn add(&mut self, stage: Stage) {
            let now = counters();
            let stage = stage as usize;
            mark(self.marks + stage);
            for k in 0..2 {
                let spent = now[k].wrapping_sub(self.last[k]).saturating_sub(self.empty[k]);
                self.sums[stage][k] = self.sums[stage][k].wrapping_add(spent);
            }
            self.events[stage] += 1;
            self.start();
        }

        fn print(&self, slots: usize) {
            for (k, stage) in NAMES.iter().enumerate() {
                let [instructions, cycles] = self.sums[k];
                println(format_args!("mark {} {slots} {stage}", self.marks + k));
                println(format_args!("stage {slots} {stage} {} {instructions} {cycles}", self.events[k]));
            }
            println(format_args!("digest {slots} image {:016x}", self.image.hash()));
            println(format_args!("digest {slots} logits {:016x}", self.logits.hash()));
            println(format_args!("digest {slots} class {}", self.class));
        }
    }

    impl Probe for Stages {
        fn beat(&mut self, _beat: &Beat) {
            self.add(Stage::Dechirp);
        }
        fn gram(&mut self, _gram: &Gram) {
            self.add(Stage::Gram);
        }
        fn projection(&mut self, _projection: &Beat) {
            self.add(Stage::Eigenvectors);
        }
        fn slow_time(&mut self, _slow_time: &[Complex<i32>]) {
            self.add(Stage::Projection);
        }
        fn frame(&mut self, _k: usize, _spectrum: &[Complex<f32>; FFT_LEN]) {
            self.add(Stage::Frames);
        }
        fn fixed_frame(&mut self, _k: usize, _spectrum: &[Complex<i32>; FFT_LEN]) {
            self.add(Stage::Frames);
        }
        fn image(&mut self, image: &[i8]) {
            self.add(Stage::Quantisation);
            image.iter().for_each(|pixel| self.image.value(pixel.to_le_bytes()));
            self.start();
        }
        fn layer(&mut self, index: usize, activations: &[i8]) {
            let stage = match index {
                0 => Stage::Stem,
                _ if activations.len() <= 32 => Stage::Head,
                _ => [Stage::Addition, Stage::BatchNorm, Stage::Convolution, Stage::Convolution][index % 4],
            };
            self.add(stage);
        }
        fn logits(&mut self, logits: &[i8]) {
            self.add(Stage::Head);
            logits.iter().for_each(|logit| self.logits.value(logit.to_le_bytes()));
            self.start();
        }
        fn class(&mut self, class: u8) {
            self.class = class;
        }
        fn confidence(&mut self, _confidence: f32) {
            self.add(Stage::Softmax);
        }
    }

    fn fail(what: &str) -> ! {
        println(format_args!("error: {what}"));
        exit(2)
    }

    /// The decisions of a period, one after the other.
    fn decide(stages: &mut Stages, sensing: u32) {
        let shares = [(4000 - sensing) / 4, (4000 - sensing) / 4, (4000 - sensing) / 2];
        let Ok(plan) = Plan::new(4000, 3, sensing, &shares) else { fail("not a plan") };
        let mut sequencer = Sequencer::new(&plan);
        let mut digest = Digest::new();
        for _ in 0..4000 {
            stages.start();
            let decision = sequencer.next_slot();
            stages.add(Stage::Decision);
            digest.value([match decision {
                SlotUse::Communication(user) => user,
                _ => u8::MAX,
            }]);
        }
        println(format_args!("digest {sensing} decisions {:016x}", digest.hash()));
    }

    /// A recognition of noise.
    #[inline(never)]
    fn recognise(network: usize, bytes: &[u8], buffers: PipelineBuffers<'_>) {
        let Ok(model) = Model::parse(bytes) else { fail("a network is refused") };
        let Ok(mut pipeline) = <Pipeline<'_, '_>>::new([EarlyExit::single(model)], 2.0, buffers) else {
            fail("a network does not fit its memory")
        };
        let mut stages = Stages::new(network);
        let mut slot = [0; RadarConfig::PAPER.values_per_slot()];
        let slots = model.sensing_slots();
        let mut rng = rand_xoshiro::Xoshiro128PlusPlus::seed_from_u64(3);
        for k in 1..=slots {
            noise(&mut rng, &mut slot);
            stages.start();
            if pipeline.push(&slot, &mut stages).is_err() {
                fail("a slot is refused");
            }
            if k < slots {
                stages.add(Stage::Gram); // the last slot's ends where the recognition begins
            }
        }
        if pipeline.classify(&mut stages).is_none() {
            fail("a recording cannot be classified");
        }
        decide(&mut stages, slots as u32);
        stages.print(slots);
    }

    #[allow(unsafe_code)] // the symbol that start-up calls
    #[unsafe(no_mangle)]
    extern "C" fn firmware_main() -> ! {
        let mut rng = rand_xoshiro::Xoshiro128PlusPlus::seed_from_u64(3);
        if selftest::run(&mut rng) != selftest::KNOWN_ANSWERS {
            println(format_args!("error: the self test of the signal chain failed"));
            exit(1)
        }
        println(format_args!("self test passed"));
        recognise(0, DSN_200, SMALL_MEMORY.take().view());
        recognise(1, DSN_1000, LARGE_MEMORY.take().view());
        println(format_args!("done"));
        exit(0)
    }
}
