//! Runs every case of a suite through the core and prints the digest of every stage.
//!
//! Arguments: the suite file, and optionally a file for defmt records. One slot of samples is in memory at a time.
#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(not(target_os = "none"))]
fn main() {
    eprintln!("this is firmware: build it with firmware-sim/build");
}

#[cfg(target_os = "none")]
mod firmware {
    use rand_core::SeedableRng;
    use sdp3_core::digest::{Digest, DigestProbe};
    use sdp3_core::dsn::{Model, scratch_bytes};
    use sdp3_core::frame::{Iq, SLOT_SAMPLES, Slot};
    use sdp3_core::receiver::{Memory, Receiver};
    use sdp3_core::schedule::{Plan, RECEIVERS, Sequencer, SlotUse};
    use sdp3_core::selftest;
    use sdp3_firmware_sim::rt::{Single, instructions, paint_stack, stack_used, start_counter};
    use sdp3_firmware_sim::semihosting::{File, arguments, exit, println};
    use sdp3_firmware_sim::{log, semihosting};

    /// The largest configuration: 1000 slots, 110 frames, 16 channels behind a stride of 1.
    type Standard = Memory<1000, 110, { scratch_bytes(110, 16, 1) }>;
    static MEMORY: Single<Standard> = Single::new(Standard::new());
    static MODEL: Single<[u8; 1 << 17]> = Single::new([0; 1 << 17]);

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
        if let Some(path) = words.next() {
            log::open(path);
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
        if !file.read(&mut magic) || magic != *b"SDPS" || file.word() != Some(1) {
            fail("not a suite file of version 1");
        }
        let Some(cases) = file.word() else { fail("the suite file is truncated") };
        defmt::info!("suite opened: {=u32} cases", cases);
        for index in 0..cases {
            case(index, &mut file, memory, model);
        }
        schedule(&mut file);
        println(format_args!("stack {}", stack_used()));
        semihosting::print("done\n");
        exit(0)
    }

    fn case(index: u32, file: &mut File, memory: &mut Standard, model: &mut [u8]) {
        let (Some(length), Some(slots)) = (file.word(), file.word()) else {
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
        let mut receiver = match Receiver::new(parsed, memory.view()) {
            Ok(receiver) => receiver,
            Err(error) => {
                defmt::error!("{}", error);
                fail("a model needs more memory than there is")
            }
        };
        let mut probe = DigestProbe::new();
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
        for (stage, digest) in probe.stages() {
            println(format_args!("case {index} {stage} {} {:016x}", digest.count(), digest.hash()));
        }
        println(format_args!("case {index} instructions {count}"));
    }

    fn schedule(file: &mut File) {
        let mut words = [0; 4];
        words.iter_mut().for_each(|word| *word = file.word().unwrap_or(0));
        let [period, spacing, sensing, receivers] = words;
        let mut shares = [0; RECEIVERS];
        let Some(shares) = shares.get_mut(..receivers as usize) else { fail("too many receivers") };
        shares.iter_mut().for_each(|share| *share = file.word().unwrap_or(0));
        let mut digest = Digest::new();
        if let Ok(plan) = Plan::new(period, spacing, sensing, shares) {
            let mut sequencer = Sequencer::new(&plan);
            for _ in 0..period {
                match sequencer.next() {
                    SlotUse::Communication(k) => digest.value([k]),
                    _ => digest.value([u8::MAX]),
                }
            }
        }
        println(format_args!("schedule {} {:016x}", digest.count(), digest.hash()));
    }
}
