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
#[path = "../../../core/src/dsn/random_model.rs"]
mod random_model;

#[cfg(target_os = "none")]
mod firmware {
    use super::random_model::{Numbers, Size, write};
    use rand_core::SeedableRng;
    use sdp3_core::clutter::{Gram, Weights};
    use sdp3_core::digest::DigestProbe;
    use sdp3_core::dsn::model::crc32;
    use sdp3_core::dsn::tiled::{Tiled, TiledBuffers};
    use sdp3_core::dsn::{Kernels, Model, Portable, scratch_bytes};
    use sdp3_core::frame::{Beat, Complex, Iq, SLOT_SAMPLES, Slot};
    use sdp3_core::probe::Probe;
    use sdp3_core::receiver::{Memory, Receiver};
    use sdp3_core::selftest;
    use sdp3_core::stft::{FixedBins, FixedStft, ShortTime, Spectrum, Stft};
    use sdp3_firmware_sim::rt::{Single, instructions, start_counter};
    use sdp3_firmware_sim::semihosting::{exit, println};

    /// Memory for the largest of the networks below.
    type Largest = Memory<1000, 128, { scratch_bytes(64, 16, 1) }>;
    static MEMORY: Single<Largest> = Single::new(Largest::new());
    static MODEL: Single<[u8; 1 << 17]> = Single::new([0; 1 << 17]);

    /// Packed weights of each of the networks below.
    type Packed = TiledBuffers<8192, 8192, 20480>;
    static PACKED: Single<Packed> = Single::new(Packed::new());

    /// Sums instructions by kind of work: what was done since the last event belongs to the next.
    struct Shares {
        last: u64,
        empty: u64,
        counts: [u64; KINDS.len()],
        /// Events of each kind.
        events: [u64; KINDS.len()],
        /// The last frame: the grey levels of the frame before it are part of the count.
        frame: u64,
    }

    const KINDS: [&str; 12] = [
        "dechirp",
        "gram",
        "weights",
        "projection",
        "frames",
        "grey",
        "stem",
        "affine",
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
        fn weights(&mut self, _weights: &Weights) {
            self.add(2);
        }
        fn slow_time(&mut self, _slow_time: &[Complex<i32>]) {
            self.add(3);
        }
        fn frame(&mut self, _k: usize, _spectrum: &Spectrum) {
            self.frame = self.add(4);
        }
        fn fixed_frame(&mut self, _k: usize, _spectrum: &FixedBins) {
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

    /// Runs a recording of noise through a network by `kernels`; all stages' values go to `probe`.
    fn recognise<K: Kernels, T: ShortTime>(
        model: &Model<'_>,
        memory: &mut Largest,
        kernels: K,
        probe: &mut impl Probe,
        pushed: impl Fn(&mut Shares),
        shares: &mut Shares,
    ) {
        let receiver = Receiver::<K, T>::with_arithmetic(model.clone(), memory.view(), kernels);
        let Ok(mut receiver) = receiver else { fail("a network does not fit its memory") };
        let mut rng = rand_xoshiro::Xoshiro128PlusPlus::seed_from_u64(3);
        let mut slot: Slot = [Iq { i: 0, q: 0 }; SLOT_SAMPLES];
        while receiver.missing() > 0 {
            selftest::noise(&mut rng, &mut slot);
            shares.start();
            let _ = receiver.push(&slot, shares);
            pushed(shares);
        }
        shares.start();
        let _ = receiver.classify(shares);
        let _ = receiver.classify(probe);
    }

    /// Measures a network and compares its layers with the plain loops'.
    fn measure<T: ShortTime>(size: Size, memory: &mut Largest, packed: &mut Packed, model: &mut [u8]) -> Shares {
        let length = write(size, 1, Numbers::Trained, crc32, model);
        let Ok(model) = Model::parse(model.get(..length).unwrap_or(&[])) else { fail("a network is refused") };
        let mut shares = Shares::new();
        let (mut found, mut expected) = (DigestProbe::new(), DigestProbe::new());
        let Some(kernels) = Tiled::new(&model, packed.view()) else { fail("packed weights do not fit") };
        let pushed = |shares: &mut Shares| {
            shares.add(1);
        };
        recognise::<_, T>(&model, memory, kernels, &mut found, pushed, &mut shares);
        recognise::<_, T>(&model, memory, Portable, &mut expected, |_| (), &mut Shares::new());
        for ((stage, found), (_, expected)) in found.stages().zip(expected.stages()) {
            if found != expected {
                println(format_args!("error: {stage} differs from the plain loops'"));
                exit(1);
            }
        }
        shares
    }

    fn work(name: &str, instructions: u64) {
        println(format_args!("work {name} {instructions}"));
    }

    #[allow(unsafe_code)] // the symbol that start-up calls
    #[unsafe(no_mangle)]
    extern "C" fn firmware_main() -> ! {
        start_counter();
        let (Some(memory), Some(packed), Some(model)) = (MEMORY.take(), PACKED.take(), MODEL.take()) else {
            fail("memory is taken")
        };
        let size = |channels, stride, blocks, frames: u16| Size {
            channels,
            stride,
            blocks,
            slots: 8 + 4 * (frames - 1),
            window: 8,
            hop: 4,
        };
        let sixteen = measure::<FixedStft>(size(16, 1, 2, 64), memory, packed, model);
        work("conv-32x32x16-16", sixteen.mean("convolution"));
        work("stem-64x64x1-16-pooled", sixteen.mean("stem"));
        work("conv-16x16x32-32", measure::<FixedStft>(size(32, 2, 2, 64), memory, packed, model).mean("convolution"));
        work("conv-32x64x8-8", measure::<FixedStft>(size(8, 1, 2, 128), memory, packed, model).mean("convolution"));
        let whole = Size { channels: 8, stride: 1, blocks: 5, slots: 1000, window: 128, hop: 8 };
        let shares = measure::<FixedStft>(whole, memory, packed, model);
        work("dechirp-slot", shares.mean("dechirp"));
        work("gram-slot", shares.mean("gram"));
        work("stft-frame", shares.frame);
        let single = Size { slots: 144, blocks: 1, ..whole };
        let float = measure::<Stft>(single, memory, packed, model);
        work("stft-frame-f32", float.frame);
        for (kind, count) in KINDS.iter().zip(shares.counts) {
            println(format_args!("work chain-{kind} {count}"));
        }
        work("chain", shares.counts.iter().sum());
        println(format_args!("done"));
        exit(0)
    }
}
