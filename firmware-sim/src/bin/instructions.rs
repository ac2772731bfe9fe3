//! Counts the instructions of each stage of the chain and prints them, one `work <name> <instructions>` a line.
//!
//! Networks have random numbers of the sizes that peers are measured at. Every layer is also computed by the plain
//! loops, and an output that differs ends the run.
#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(not(target_os = "none"))]
fn main() {
    eprintln!("this is firmware: build it with firmware-sim/build");
}

#[cfg(target_os = "none")]
mod firmware {
    use rand_core::{Rng, SeedableRng};
    use sdp3_core::config::RadarConfig;
    use sdp3_core::crc32::crc32;
    use sdp3_core::digest::DigestProbe;
    use sdp3_core::dims::{Beat, Complex, FFT_LEN};
    use sdp3_core::dsn::winograd::{WinogradKernels, WinogradMemory, WinogradSizes};
    use sdp3_core::dsn::{Kernels, Model, Network, Portable, image_mut, scratch_bytes};
    use sdp3_core::early_exit::EarlyExit;
    use sdp3_core::pipeline::{Pipeline, PipelineMemory};
    use sdp3_core::probe::Probe;
    use sdp3_core::signal::clutter::{ADAPTIVE, Gram, SvdRange, clutter_projection};
    use sdp3_core::signal::stft::{FixedStft, FloatStft, NativeStft, Stft};
    use sdp3_firmware_sim::rt::{Single, instructions, start_counter};
    use sdp3_firmware_sim::semihosting::{exit, println};
    use sdp3_testkit::random_model::{Numbers, Size, write};
    use sdp3_testkit::signals::noise;

    /// Memory for the largest of the networks below.
    type Largest = PipelineMemory<0, 1000, { SCRATCH.div_ceil(8) }, 19200, 1024>;
    const SCRATCH: usize = scratch_bytes(64, 16, 1);
    static NETWORK: Single<[i8; SCRATCH]> = Single::new([0; SCRATCH]);
    static MEMORY: Single<Largest> = Single::new(Largest::new());
    static MODEL: Single<[u8; 1 << 17]> = Single::new([0; 1 << 17]);

    /// Sums instructions by kind of work: what was done since the last event belongs to the next.
    struct Shares {
        last: u64,
        empty: u64,
        counts: [u64; KINDS.len()],
        /// Events of each kind.
        events: [u64; KINDS.len()],
        /// The last frame: the log magnitudes of the frame before it are part of the count.
        frame: u64,
    }

    const KINDS: [&str; 12] = [
        "dechirp",
        "gram",
        "projection",
        "slow-time",
        "frames",
        "log-magnitude",
        "stem",
        "batch-norm",
        "convolution",
        "addition",
        "head",
        "softmax",
    ];

    impl Shares {
        fn new() -> Self {
            let none = [0; KINDS.len()];
            let mut shares = Shares { last: 0, empty: 0, counts: none, events: none, frame: 0 };
            shares.start();
            shares.add(0);
            shares.empty = shares.counts[0];
            (shares.counts, shares.events) = (none, none);
            shares.start();
            shares
        }

        /// Forgets what was done since the last event.
        fn start(&mut self) {
            self.last = instructions();
        }

        fn add(&mut self, kind: usize) -> u64 {
            let spent = instructions().wrapping_sub(self.last).saturating_sub(self.empty);
            self.counts[kind] += spent;
            self.events[kind] += 1;
            self.last = instructions();
            spent
        }

        /// Mean of a kind's events.
        fn mean(&self, kind: &str) -> u64 {
            let kind = KINDS.iter().position(|k| *k == kind).unwrap_or(0);
            self.counts[kind] / self.events[kind].max(1)
        }
    }

    impl Probe for Shares {
        fn beat(&mut self, _beat: &Beat) {
            self.add(0);
        }
        fn gram(&mut self, _gram: &Gram) {
            self.start();
        }
        fn projection(&mut self, _projection: &Beat) {
            self.add(2);
        }
        fn slow_time(&mut self, _slow_time: &[Complex<i32>]) {
            self.add(3);
        }
        fn frame(&mut self, _k: usize, _spectrum: &[Complex<f32>; FFT_LEN]) {
            self.frame = self.add(4);
        }
        fn fixed_frame(&mut self, _k: usize, _spectrum: &[Complex<i32>; FFT_LEN]) {
            self.frame = self.add(4);
        }
        fn image(&mut self, _image: &[i8]) {
            self.add(5);
        }
        fn layer(&mut self, index: usize, activations: &[i8]) {
            let head = activations.len() <= 32;
            let kind = if index == 0 { 6 } else { [9, 7, 8, 8][index % 4] };
            self.add(if head { 10 } else { kind });
        }
        fn logits(&mut self, _logits: &[i8]) {
            self.add(10);
        }
        fn confidence(&mut self, _confidence: f32) {
            self.add(11);
        }
    }

    fn fail(what: &str) -> ! {
        println(format_args!("error: {what}"));
        exit(2)
    }

    /// What computes the layers.
    #[derive(Clone, Copy, PartialEq)]
    enum By {
        /// F(4x3, 3x3), with so many places for packed convolutions.
        Winograd(usize),
        /// The plain loops.
        Loops,
    }

    /// Every convolution packed ahead, for the networks of two blocks below.
    const AHEAD: By = By::Winograd(5);

    /// The part of a buffer that is wanted.
    fn part<T>(memory: &mut [T], length: usize) -> &mut [T] {
        let Some(part) = memory.get_mut(..length) else { fail("packed weights do not fit") };
        part
    }

    /// Counts a recognition of noise; all stages' values go to `probe`.
    fn count<T: Stft>(model: &Model<'_>, memory: &mut Largest, by: By, probe: &mut DigestProbe) -> Shares {
        let (mut buffers, exit) = (memory.view(), [EarlyExit::single(*model)]);
        let WinogradMemory { vectors, words } = core::mem::take(&mut buffers.kernels);
        let By::Winograd(places) = by else {
            return recognise(Pipeline::<_, T>::with_kernels(exit, 2.0, buffers, Portable), probe);
        };
        let sizes = WinogradSizes::new(model.channels(), places);
        let memory =
            WinogradMemory { vectors: part(vectors, sizes.vectors), words: part(words, sizes.words) };
        let Some(kernels) = WinogradKernels::new(model, memory) else { fail("packed weights do not fit") };
        recognise(Pipeline::<_, T>::with_kernels(exit, 2.0, buffers, kernels), probe)
    }

    /// Instructions of the largest step of a network with nothing packed ahead.
    fn largest_step(model: &Model<'_>, memory: &mut Largest) -> u64 {
        let buffers = memory.view();
        let mut kernels = WinogradKernels::shared(buffers.kernels);
        let Some(scratch) = NETWORK.take() else { fail("memory is taken") };
        image_mut(scratch, model.frames()).fill(1);
        let (mut network, mut largest) = (Network::new(), 0);
        loop {
            let before = instructions();
            let logits = network.step(model, scratch, &mut kernels, &mut ());
            largest = instructions().wrapping_sub(before).max(largest);
            if logits.is_some() {
                return largest;
            }
        }
    }

    /// Instructions of the projection of 1000 slots, a static echo in noise, with this first component: from range samples to weights.
    fn projection(first: u8, memory: &mut Largest) -> u64 {
        let beats = memory.view().front_end.beats;
        let mut rng = rand_xoshiro::Xoshiro128PlusPlus::seed_from_u64(5);
        for beat in beats.iter_mut() {
            for z in beat {
                *z = Complex::new((1 << 24) + (rng.next_u32() as i32 >> 14), rng.next_u32() as i32 >> 14);
            }
        }
        let before = instructions();
        core::hint::black_box(clutter_projection(beats, SvdRange { first, last: 8 }));
        instructions().wrapping_sub(before)
    }

    fn recognise<K: Kernels, T: Stft>(
        pipeline: Result<Pipeline<'_, '_, K, T>, sdp3_core::Error>,
        probe: &mut DigestProbe,
    ) -> Shares {
        let Ok(mut pipeline) = pipeline else { fail("a network does not fit its memory") };
        let mut shares = Shares::new();
        let mut slot = [0; RadarConfig::PAPER.values_per_slot()];
        let slots = pipeline.first_exit_slots();
        let mut rng = rand_xoshiro::Xoshiro128PlusPlus::seed_from_u64(3);
        for _ in 1..slots {
            noise(&mut rng, &mut slot);
            shares.start();
            let _ = pipeline.push(&slot, &mut shares);
            shares.add(1);
        }
        // the last one begins the recognition
        noise(&mut rng, &mut slot);
        let _ = pipeline.push(&slot, &mut shares);
        shares.start();
        let _ = pipeline.classify(&mut shares);
        // once more for the values
        pipeline.reset();
        let mut rng = rand_xoshiro::Xoshiro128PlusPlus::seed_from_u64(3);
        for _ in 0..slots {
            noise(&mut rng, &mut slot);
            let _ = pipeline.push(&slot, probe);
        }
        if pipeline.classify(probe).is_none() {
            fail("a recording cannot be classified");
        }
        shares
    }

    /// The networks, and the memory they are computed in.
    struct Bench {
        memory: &'static mut Largest,
        model: &'static mut [u8],
    }

    impl Bench {
        /// Counts a network by the Winograd kernels and by the plain loops, in this order, and compares their layers.
        fn both<T: Stft>(&mut self, size: Size, by: By) -> [Shares; 2] {
            let length = write(size, 1, Numbers::Trained, crc32, self.model);
            let bytes = self.model.get(..length).unwrap_or(&[]);
            let Ok(model) = Model::parse(bytes) else { fail("a network is refused") };
            let (mut found, mut expected) = (DigestProbe::new(), DigestProbe::new());
            let shares = count::<T>(&model, self.memory, by, &mut found);
            let plain = count::<T>(&model, self.memory, By::Loops, &mut expected);
            for ((stage, found), (_, expected)) in found.stages().zip(expected.stages()) {
                if found != expected {
                    println(format_args!("error: {stage} differs from the plain loops'"));
                    exit(1);
                }
            }
            [shares, plain]
        }

        /// The largest step of a network that has nothing packed ahead.
        fn largest_step(&mut self, size: Size) -> u64 {
            let length = write(size, 1, Numbers::Trained, crc32, self.model);
            let Ok(model) = Model::parse(part(self.model, length)) else { fail("a network is refused") };
            largest_step(&model, self.memory)
        }

        /// A network's mean convolution, packed ahead and packed when it runs, and its stem.
        fn layers(&mut self, name: &str, channels: usize, stride: u8, frames: u16) -> u64 {
            let size = Size { channels, stride, blocks: 2, slots: 8 + 4 * (frames - 1), window: 8, hop: 4 };
            let [ahead, _] = self.both::<NativeStft>(size, AHEAD);
            let [when_run, _] = self.both::<NativeStft>(size, By::Winograd(1));
            println(format_args!("work {name} {}", ahead.mean("convolution")));
            println(format_args!("work {name}-with-packing {}", when_run.mean("convolution")));
            ahead.mean("stem")
        }
    }

    fn work(name: &str, instructions: u64) {
        println(format_args!("work {name} {instructions}"));
    }

    #[allow(unsafe_code)] // the symbol that start-up calls
    #[unsafe(no_mangle)]
    extern "C" fn firmware_main() -> ! {
        start_counter();
        let (Some(memory), Some(model)) = (MEMORY.take(), MODEL.take()) else { fail("memory is taken") };
        let mut bench = Bench { memory, model };
        let stem = bench.layers("conv-32x32x16-16", 16, 1, 64);
        work("stem-64x64x1-16-pooled", stem);
        bench.layers("conv-16x16x32-32", 32, 2, 64);
        bench.layers("conv-32x64x8-8", 8, 1, 128);
        // the default network, as the station computes it
        let whole = Size { channels: 16, stride: 2, blocks: 5, slots: 1000, window: 128, hop: 8 };
        let [shares, plain] = bench.both::<NativeStft>(whole, By::Winograd(1));
        work("network-step-largest", bench.largest_step(whole));
        let [fixed, adaptive] = [2, ADAPTIVE].map(|first| projection(first, bench.memory));
        work("clutter-1000-slots", fixed);
        work("clutter-1000-slots-adaptive", adaptive);
        work("dechirp-slot", shares.mean("dechirp"));
        work("gram-slot", shares.mean("gram"));
        let single = Size { slots: 144, blocks: 1, ..whole };
        work("stft-frame", bench.both::<FixedStft>(single, By::Winograd(1))[0].frame);
        work("stft-frame-f32", bench.both::<FloatStft>(single, By::Winograd(1))[0].frame);
        for (kind, count) in KINDS.iter().zip(shares.counts) {
            println(format_args!("work chain-{kind} {count}"));
        }
        work("chain", shares.counts.iter().sum());
        work("chain-by-plain-loops", plain.counts.iter().sum());
        println(format_args!("done"));
        exit(0)
    }
}
