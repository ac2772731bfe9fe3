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
    use sdp3_core::dims::{Beat, Complex, Iq, SLOT_SAMPLES, Slot};
    use sdp3_core::dsn::winograd::WinogradF2;
    use sdp3_core::dsn::{Model, scratch_bytes};
    use sdp3_core::pipeline::{Memory, Receiver};
    use sdp3_core::probe::Probe;
    use sdp3_core::scheduler::{Plan, Sequencer, SlotUse, USERS};
    use sdp3_core::selftest;
    use sdp3_core::signal::clutter::{Gram, Weights};
    use sdp3_core::signal::stft::{FixedBins, FixedStft, FloatStft, Spectrum, Stft};
    use sdp3_core::values::{Sink, Stage, Values};
    use sdp3_firmware_sim::rt::{Single, instructions, paint_stack, stack_used, start_counter};
    use sdp3_firmware_sim::semihosting::{File, arguments, exit, println};
    use sdp3_firmware_sim::{log, semihosting};

    /// The largest configuration: 1000 slots, 110 frames, 16 channels behind a stride of 1. Places for one convolution of 32
    /// channels, four of 16, or 16 of 8: some are packed ahead, some when they run.
    type Standard = Memory<1000, 110, { scratch_bytes(110, 16, 1) }, 2048, 4096>;
    static MEMORY: Single<Standard> = Single::new(Standard::new());
    static MODEL: Single<[u8; 1 << 17]> = Single::new([0; 1 << 17]);

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
        weights(weights: &Weights);
        slow_time(slow_time: &[Complex<i32>]);
        frame(k: usize, spectrum: &Spectrum);
        fixed_frame(k: usize, spectrum: &FixedBins);
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
        let answer = selftest::run(&mut rng);
        println(format_args!("selftest {answer:016x}"));
        if answer != selftest::KNOWN_ANSWER {
            defmt::warn!("self test: {=u64:x} instead of {=u64:x}", answer, selftest::KNOWN_ANSWER);
        }
        let (Some(memory), Some(model)) = (MEMORY.take(), MODEL.take()) else { fail("memory is taken") };
        let mut magic = [0; 4];
        if !file.read(&mut magic) || magic != *b"SDPS" || file.word() != Some(2) {
            fail("not a suite file of version 2");
        }
        let Some(cases) = file.word() else { fail("the suite file is truncated") };
        defmt::info!("suite opened: {=u32} cases", cases);
        for index in 0..cases {
            case(index, &mut file, memory, model, wanted.as_mut());
        }
        if let Some(Values(dump)) = &mut wanted {
            dump.flush();
        }
        schedule(&mut file);
        println(format_args!("stack {}", stack_used()));
        semihosting::print("done\n");
        exit(0)
    }

    fn case(
        index: u32,
        file: &mut File,
        memory: &mut Standard,
        model: &mut [u8],
        dump: Option<&mut Values<Dump>>,
    ) {
        let (Some(length), Some(slots), Some(transform)) = (file.word(), file.word(), file.word()) else {
            fail("the suite file is truncated")
        };
        let (length, padded) = (length as usize, (length as usize).next_multiple_of(4));
        let Some(bytes) = model.get_mut(..padded) else { fail("a model is larger than 128 KiB") };
        if !file.read(bytes) {
            fail("the suite file is truncated");
        }
        defmt::info!("case {=u32}: {=u32} slots", index, slots);
        let parsed = match Model::parse(bytes.get(..length).unwrap_or(bytes)) {
            Ok(parsed) => parsed,
            Err(error) => {
                defmt::error!("{}", error);
                fail("the core refuses a model")
            }
        };
        let (digests, count) = match transform {
            0 => recording::<FloatStft>(parsed, file, slots, memory, dump),
            1 => recording::<FixedStft>(parsed, file, slots, memory, dump),
            _ => fail("a transform is neither 0 nor 1"),
        };
        for (stage, digest) in digests.stages() {
            println(format_args!("case {index} {stage} {} {:016x}", digest.count(), digest.hash()));
        }
        println(format_args!("case {index} instructions {count}"));
    }

    /// Reads a recording and recognises it: every stage's digest, and the instructions of it all.
    fn recording<T: Stft>(
        model: Model<'_>,
        file: &mut File,
        slots: u32,
        memory: &mut Standard,
        dump: Option<&mut Values<Dump>>,
    ) -> (DigestProbe, u64) {
        let mut receiver = match Receiver::<WinogradF2<'_>, T>::with_transform(model, memory.view()) {
            Ok(receiver) => receiver,
            Err(error) => {
                defmt::error!("{}", error);
                fail("a model needs more memory than there is")
            }
        };
        let mut digests = DigestProbe::new();
        let mut probe = Both(&mut digests, dump);
        let mut count = 0;
        let mut slot: Slot = [Iq { i: 0, q: 0 }; SLOT_SAMPLES];
        let mut raw = [0_u8; 4 * SLOT_SAMPLES];
        for _ in 0..slots {
            if !file.read(&mut raw) {
                fail("the suite file is truncated");
            }
            for (sample, bytes) in slot.iter_mut().zip(raw.chunks_exact(4)) {
                if let Some(bytes) = bytes.first_chunk::<4>() {
                    *sample = Iq::from_le_bytes(*bytes);
                }
            }
            if receiver.push(&slot, &mut probe).is_err() {
                fail("a recording is longer than its model's");
            }
        }
        let before = instructions();
        let Ok(answer) = receiver.classify(&mut ()) else { fail("a recording is shorter than its model's") };
        count += instructions().wrapping_sub(before);
        // once more under the probe, outside the count
        if receiver.classify(&mut probe).is_err() {
            fail("a recording cannot be classified twice");
        }
        // the slots' share: the last slot again, alone, times their number
        receiver.reset();
        let before = instructions();
        let _ = receiver.push(&slot, &mut ());
        count += instructions().wrapping_sub(before) * u64::from(slots);
        defmt::info!("recognised {=u8} with {=f32}", answer.class, answer.confidence);
        (digests, count)
    }

    fn schedule(file: &mut File) {
        let mut words = [0; 4];
        words.iter_mut().for_each(|word| *word = file.word().unwrap_or(0));
        let [period, spacing, sensing, receivers] = words;
        let mut shares = [0; USERS];
        let Some(shares) = shares.get_mut(..receivers as usize) else { fail("too many receivers") };
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
