//! Runs every case of a suite through the core and prints the digest of every stage.
//!
//! Arguments: the suite file; `log=FILE` for defmt records; `dump=STAGE:FILE` for all values of one stage, little-endian.
//! One slot of samples is in memory at a time.
#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(not(target_os = "none"))]
fn main() {
    eprintln!("this is firmware: build it with firmware-sim/build");
}

#[cfg(target_os = "none")]
mod firmware {
    use rand_core::SeedableRng;
    use sdp3_core::digest::{Digest, DigestProbe};
    use sdp3_core::dims::{Beat, Complex, FFT_LEN};
    use sdp3_core::dsn::{Classification, Kernels, Model, WinogradF2, scratch_bytes};
    use sdp3_core::early_exit::EarlyExit;
    use sdp3_core::pipeline::{Pipeline, PipelineMemory};
    use sdp3_core::probe::Probe;
    use sdp3_core::scheduler::{Plan, Sequencer, SlotUse, USERS};
    use sdp3_core::selftest;
    use sdp3_core::signal::clutter::Gram;
    use sdp3_core::signal::stft::{FixedStft, FloatStft, Stft};
    use sdp3_core::values::{Sink, Stage, Values};
    use sdp3_firmware_sim::rt::{instructions, paint_stack, stack_used, start_counter};
    use sdp3_firmware_sim::semihosting::{File, arguments, exit, println};
    use sdp3_firmware_sim::static_cell::ConstStaticCell;
    use sdp3_firmware_sim::{log, semihosting};

    /// The largest configuration: a slot of 2048 complex samples and as many references, 1000 slots, 110 frames, 16 channels behind a
    /// stride of 1. Places for one convolution of 32 channels, four of 16, or 16 of 8: some are packed ahead, some when they run.
    type Memory = PipelineMemory<2048, 1000, 1000, 110, { scratch_bytes(110, 16, 1) }, 2048, 4096>;
    static MEMORY: ConstStaticCell<Memory> = ConstStaticCell::new(Memory::new());
    static SLOT: ConstStaticCell<[i16; 4096]> = ConstStaticCell::new([0; 4096]);
    static MODEL: ConstStaticCell<[u8; 1 << 17]> = ConstStaticCell::new([0; 1 << 17]);

    /// One stage's values on their way to a file.
    struct Dump {
        stage: Stage,
        file: File,
        buffer: heapless::Vec<u8, 4096>,
    }

    impl Dump {
        fn flush(&mut self) {
            if !self.file.write(&self.buffer) {
                fail("the values cannot be written");
            }
            self.buffer.clear();
        }
    }

    impl Sink for Dump {
        fn value<const N: usize>(&mut self, stage: Stage, bytes: [u8; N]) {
            if stage != self.stage {
                return;
            }
            if self.buffer.extend_from_slice(&bytes).is_err() {
                self.flush();
                let _ = self.buffer.extend_from_slice(&bytes); // it is empty now
            }
        }
    }

    /// `STAGE:FILE`.
    fn dump(text: &str) -> Dump {
        let Some((stage, path)) = text.split_once(':') else { fail("dump=STAGE:FILE has no colon") };
        let Some(stage) = Stage::named(stage) else { fail("no such stage") };
        let Some(file) = File::create(path) else { fail("the file for values cannot be made") };
        Dump { stage, file, buffer: heapless::Vec::new() }
    }

    /// Digests and, if wanted, values.
    struct Both<'a>(&'a mut DigestProbe, Option<&'a mut Values<Dump>>);

    /// The methods of [`Probe`], each for both.
    macro_rules! both {
        ($($method:ident($($name:ident: $type:ty),*);)*) => {
            impl Probe for Both<'_> {
                $(fn $method(&mut self, $($name: $type),*) {
                    self.0.$method($($name),*);
                    if let Some(values) = &mut self.1 {
                        values.$method($($name),*);
                    }
                })*
            }
        };
    }

    both! {
        beat(beat: &Beat);
        gram(gram: &Gram);
        projection(projection: &Beat);
        slow_time(slow_time: &[Complex<i32>]);
        frame(k: usize, spectrum: &[Complex<f32>; FFT_LEN]);
        fixed_frame(k: usize, spectrum: &[Complex<i32>; FFT_LEN]);
        image(image: &[i8]);
        layer(index: usize, activations: &[i8]);
        logits(logits: &[i8]);
        class(class: u8);
        confidence(confidence: f32);
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
        let mut wanted = None;
        for word in words {
            match word.split_once('=') {
                Some(("log", path)) if log::open(path) => (),
                Some(("dump", text)) => wanted = Some(Values(dump(text))),
                _ => fail("an argument is neither log=FILE nor dump=STAGE:FILE"),
            }
        }
        let Some(mut file) = File::open(path) else { fail("the suite file cannot be opened") };
        let mut rng = rand_xoshiro::Xoshiro128PlusPlus::seed_from_u64(3);
        let found = selftest::run(&mut rng);
        println(format_args!("selftest {:016x}", found[1]));
        if found != selftest::KNOWN_ANSWERS {
            defmt::warn!("the self test of the signal chain failed"); // the suite reports the stage
        }
        let mut magic = [0; 4];
        if !file.read(&mut magic) || magic != *b"SDPS" || file.word() != Some(3) {
            fail("not a suite file of version 3");
        }
        let Some(cases) = file.word() else { fail("the suite file is truncated") };
        defmt::info!("suite opened: {=u32} cases", cases);
        let mut work = Work { file, memory: MEMORY.take(), slot: SLOT.take() };
        let model = MODEL.take();
        for index in 0..cases {
            case(index, &mut work, model, wanted.as_mut());
        }
        if let Some(Values(dump)) = &mut wanted {
            dump.flush();
        }
        schedule(&mut work.file);
        println(format_args!("stack {}", stack_used()));
        semihosting::print("done\n");
        exit(0)
    }

    /// What every case works with.
    struct Work {
        file: File,
        memory: &'static mut Memory,
        slot: &'static mut [i16; 4096],
    }

    fn case(index: u32, work: &mut Work, model: &mut [u8], dump: Option<&mut Values<Dump>>) {
        let mut words = [0; 4];
        for word in &mut words {
            let Some(read) = work.file.word() else { fail("the suite file is truncated") };
            *word = read as usize;
        }
        let [length, slots, transform, values] = words;
        let Some(bytes) = model.get_mut(..length.next_multiple_of(4)) else {
            fail("a model is larger than 128 KiB")
        };
        if !work.file.read(bytes) {
            fail("the suite file is truncated");
        }
        defmt::info!("case {=u32}: {=usize} slots", index, slots);
        let parsed = match Model::parse(bytes.get(..length).unwrap_or(bytes)) {
            Ok(parsed) => parsed,
            Err(error) => {
                defmt::error!("{}", error);
                fail("the core refuses a model")
            }
        };
        if parsed.radar().values_per_slot() != values {
            fail("a slot has another length than its model's");
        }
        let (digests, count) = match transform {
            0 => recording::<FloatStft>(index, parsed, work, slots, dump),
            1 => recording::<FixedStft>(index, parsed, work, slots, dump),
            _ => fail("a transform is neither 0 nor 1"),
        };
        for (stage, digest) in digests.stages() {
            println(format_args!("case {index} {stage} {} {:016x}", digest.count(), digest.hash()));
        }
        println(format_args!("case {index} instructions {count}"));
    }

    /// Recognises a recording twice: every stage's digest, then the instructions of it all. Tests the network of the first case.
    fn recording<T: Stft>(
        index: u32,
        model: Model<'_>,
        work: &mut Work,
        slots: usize,
        dump: Option<&mut Values<Dump>>,
    ) -> (DigestProbe, u64) {
        let Work { file, memory, slot } = work;
        let Some(slot) = slot.get_mut(..model.radar().values_per_slot()) else { fail("a slot is too long") };
        let mut buffers = memory.view();
        let Some(kernels) = WinogradF2::new(&model, core::mem::take(&mut buffers.kernels)) else {
            fail("a network needs more memory than there is")
        };
        let exit = EarlyExit::single(model);
        let mut pipeline = match Pipeline::<_, T>::with_kernels([exit], 2.0, buffers, kernels) {
            Ok(pipeline) => pipeline,
            Err(error) => {
                defmt::error!("{}", error);
                fail("a model needs more memory than there is")
            }
        };
        let mut rng = rand_xoshiro::Xoshiro128PlusPlus::seed_from_u64(u64::from(index));
        if index == 0 && !pipeline.self_test(&mut rng) {
            defmt::warn!("the self test of a network failed");
        }
        let mut digests = DigestProbe::new();
        let first = file.position();
        let (seen, _) = recognise(&mut pipeline, file, slots, slot, &mut Both(&mut digests, dump));
        if !file.seek(first) {
            fail("the suite file cannot be read again");
        }
        pipeline.reset();
        let (again, count) = recognise(&mut pipeline, file, slots, slot, &mut ());
        if again != seen {
            fail("a recording is recognised otherwise the second time");
        }
        let padding = (2 * slots * slot.len()).next_multiple_of(4) - 2 * slots * slot.len();
        if !file.read([0; 3].get_mut(..padding).unwrap_or_default()) {
            fail("the suite file is truncated");
        }
        defmt::info!("recognised {=u8} with {=f32}", seen.class, seen.confidence);
        (digests, count)
    }

    /// Reads the slots, one at a time, and recognises them: the classification, and the instructions without the reading.
    fn recognise<K: Kernels, T: Stft>(
        pipeline: &mut Pipeline<'_, '_, K, T>,
        file: &mut File,
        slots: usize,
        slot: &mut [i16],
        probe: &mut impl Probe,
    ) -> (Classification, u64) {
        let mut count = 0;
        for _ in 0..slots {
            if !file.read_values(slot) {
                fail("the suite file is truncated");
            }
            let before = instructions();
            if pipeline.push(slot, probe).is_err() {
                fail("a recording is longer than its model's");
            }
            count += instructions().wrapping_sub(before);
        }
        let before = instructions();
        let Some(classification) = pipeline.classify(probe) else {
            fail("a recording is shorter than its model's")
        };
        (classification, count + instructions().wrapping_sub(before))
    }

    fn schedule(file: &mut File) {
        let mut words = [0; 4];
        words.iter_mut().for_each(|word| *word = file.word().unwrap_or(0));
        let [period, spacing, sensing, users] = words;
        let mut shares = [0; USERS];
        let Some(shares) = shares.get_mut(..users as usize) else { fail("too many users") };
        shares.iter_mut().for_each(|share| *share = file.word().unwrap_or(0));
        let mut digest = Digest::new();
        if let Ok(plan) = Plan::new(period, spacing, sensing, shares) {
            let mut sequencer = Sequencer::new(&plan);
            for _ in 0..period {
                match sequencer.next_slot() {
                    SlotUse::Communication(k) => digest.value([k]),
                    _ => digest.value([u8::MAX]),
                }
            }
        }
        println(format_args!("schedule {} {:016x}", digest.count(), digest.hash()));
    }
}
