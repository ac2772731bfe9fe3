//! The radar module through many slots: memory that stays flat, sensing that never drifts.
//!
//! Argument: `slots=N`. Recordings are seeded noise; periods have 4000 slots, every fourth of which may sense. Prints the digest of
//! all uses and logits, and the deepest stack after a hundredth of the slots, two periods at least, and at the end. Exit code 0 if no sensing slot lay
//! elsewhere, no fault was reported, and the stack did not grow; 1 if not.
#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(not(target_os = "none"))]
fn main() {
    eprintln!("this is firmware: build it with firmware-sim/build");
}

#[cfg(target_os = "none")]
mod firmware {
    use rand_core::SeedableRng;
    use sdp3_core::digest::Digest;
    use sdp3_core::radar::Event;
    use sdp3_core::{Progress, RadarModule, Retained, Shape, SlotAction, radar_memory};
    use sdp3_firmware_sim::rt::{paint_stack, stack_used};
    use sdp3_firmware_sim::semihosting::{arguments, exit, println};
    use sdp3_firmware_sim::static_cell::ConstStaticCell;
    use sdp3_firmware_sim::station::settings;
    use sdp3_testkit::models::DSN_200;
    use sdp3_testkit::signals::noise;

    const SHAPE: Shape = Shape::of(DSN_200).expect("a model");
    static MEMORY: ConstStaticCell<radar_memory!(SHAPE)> =
        ConstStaticCell::new(<radar_memory!(SHAPE)>::new());
    static RETAINED: Retained = Retained::new();

    #[allow(unsafe_code)] // the symbol that start-up calls
    #[unsafe(no_mangle)]
    extern "C" fn firmware_main() -> ! {
        paint_stack();
        let mut buffer = [0; 1024];
        let mut words = arguments(&mut buffer).split_ascii_whitespace();
        let wanted = words.next().and_then(|word| word.strip_prefix("slots=")?.parse::<u32>().ok());
        let (Some(slots), Ok(settings)) = (wanted, settings()) else { exit(2) };
        let period = settings.layout.period();
        let Ok(module) = RadarModule::single(DSN_200, settings, MEMORY.take(), &RETAINED) else { exit(2) };
        let (mut context, mut task) = module.split();
        // the radio's number wraps on the way
        let first = (slots / 2).wrapping_neg();
        let mut rng = rand_xoshiro::Xoshiro128PlusPlus::seed_from_u64(3);
        let (mut digest, mut early) = (Digest::new(), 0);
        let (mut classified, mut sensed, mut elsewhere, mut faults) = (0_u32, 0_u32, 0_u32, 0_u32);
        for n in 0..slots {
            let (used, senses) = match context.begin(first.wrapping_add(n)) {
                SlotAction::Sense(buffer) => {
                    noise(&mut rng, &mut buffer.0);
                    (254, true)
                }
                SlotAction::Serve(user) => (user, false),
                SlotAction::Idle => (255, false),
            };
            digest.value([used]);
            if senses {
                sensed += 1;
                elsewhere += u32::from(!(n % period).is_multiple_of(4));
                context.samples_ready();
            }
            loop {
                match task.poll() {
                    Progress::Idle => break,
                    Progress::Event(Event::Classification { classification, .. }) => {
                        classified += 1;
                        classification.logits.iter().for_each(|logit| digest.value(logit.to_le_bytes()));
                    }
                    Progress::Event(Event::Fault(_)) => faults += 1,
                    Progress::Busy | Progress::Event(Event::Period(_)) => {}
                }
            }
            if n == (slots / 100).max(2 * period) {
                early = stack_used();
            }
        }
        let stack = stack_used();
        println(format_args!(
            "{slots} slots, {sensed} of them sensing, {classified} classifications, digest {:016x}",
            digest.hash()
        ));
        println(format_args!(
            "sensing elsewhere {elsewhere}, faults {faults}, stack {early} bytes early, {stack} at the end"
        ));
        exit(usize::from(elsewhere != 0 || faults != 0 || stack != early))
    }
}
