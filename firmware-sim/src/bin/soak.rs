//! The guarded station through many slots: memory that stays flat, sensing that never drifts.
//!
//! Argument: `slots=N`. Recordings are seeded noise; periods have 4000 slots, every fourth of which may sense. Prints the digest of
//! all uses and verdicts, and the deepest stack after a hundredth of the slots and at the end. Exit code 0 if no sensing slot lay
//! elsewhere, nothing was told, and the stack did not grow; 1 if not.
#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(not(target_os = "none"))]
fn main() {
    eprintln!("this is firmware: build it with firmware-sim/build");
}

#[cfg(target_os = "none")]
mod firmware {
    use rand_core::SeedableRng;
    use sdp3_core::digest::Digest;
    use sdp3_core::dsn::Shape;
    use sdp3_core::early_exit::{Anytime, Exit};
    use sdp3_core::memory_for;
    use sdp3_core::scheduler::{Sensing, SlotUse};
    use sdp3_core::supervision::{Guarded, Intact, Watch};
    use sdp3_firmware_sim::rt::{Single, paint_stack, stack_used};
    use sdp3_firmware_sim::semihosting::{arguments, exit, println};
    use sdp3_testkit::campaign::{SAMPLES, slot};
    use sdp3_testkit::signals::noise;

    static MODEL: &[u8] = sdp3_testkit::models::DSN_200;
    const SHAPE: Shape = match Shape::of(MODEL) {
        Some(shape) => shape,
        None => panic!("dsn-200.sdp3 is no model"),
    };
    type Small = memory_for!(SHAPE);
    static MEMORY: Single<Small> = Single::new(Small::new());
    const PERIOD: u32 = 4000;

    #[allow(unsafe_code)] // the symbol that start-up calls
    #[unsafe(no_mangle)]
    extern "C" fn firmware_main() -> ! {
        paint_stack();
        let mut buffer = [0; 1024];
        let mut words = arguments(&mut buffer).split_ascii_whitespace();
        let wanted = words.next().and_then(|word| word.strip_prefix("slots=")?.parse::<u32>().ok());
        let (Some(slots), Some(memory)) = (wanted, MEMORY.take()) else { exit(2) };
        let (Ok((intact, model)), Ok(sensing)) = (Intact::accept(MODEL), Sensing::new(PERIOD, 3, PERIOD / 4))
        else {
            exit(2)
        };
        let mut buffers = memory.view();
        let Ok(kernels) = buffers.take_kernels(&model) else { exit(2) };
        let Ok(receiver) = Anytime::new([Exit::alone(model, kernels)], 2.0, buffers) else { exit(2) };
        // the radio's number wraps on the way
        let first = (slots / 2).wrapping_neg();
        let watch = Watch::new(sensing, [1500, 2500, 3000, 0, 0, 0, 0, 0], first);
        let mut station = Guarded::new(watch, receiver, [intact].into_iter().collect());
        let mut rng = rand_xoshiro::Xoshiro128PlusPlus::seed_from_u64(3);
        let mut samples = [0; SAMPLES];
        let (mut digest, mut early) = (Digest::new(), 0);
        let (mut verdicts, mut sensed, mut elsewhere, mut told) = (0_u32, 0_u32, 0_u32, 0_u32);
        for n in 0..slots {
            let number = first.wrapping_add(n);
            let begun = station.begin(number);
            told += begun.troubles.len() as u32;
            digest.value([match begun.slot {
                SlotUse::Communication(k) => k,
                SlotUse::Sensing => 254,
                SlotUse::Idle => 255,
            }]);
            if begun.slot == SlotUse::Sensing {
                sensed += 1;
                elsewhere += u32::from((n % PERIOD) % 4 != 0);
                noise(&mut rng, &mut samples);
                match station.sensed(number, &slot(&samples)) {
                    Ok(Some(verdict)) => {
                        verdicts += 1;
                        verdict.answer.logits.iter().for_each(|logit| digest.value(logit.to_le_bytes()));
                    }
                    Ok(None) => (),
                    Err(_) => told += 1,
                }
            }
            if n == slots / 100 {
                early = stack_used();
            }
        }
        let stack = stack_used();
        println(format_args!(
            "{slots} slots, {sensed} of them sensing, {verdicts} verdicts, digest {:016x}",
            digest.hash()
        ));
        println(format_args!(
            "sensing elsewhere {elsewhere}, troubles {told}, stack {early} bytes early, {stack} at the end"
        ));
        exit(usize::from(elsewhere != 0 || told != 0 || stack != early))
    }
}
