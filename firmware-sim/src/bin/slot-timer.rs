//! Checks the virtual clock: the slot timer does not drift, shows late interrupts, and the counter runs beside it.
//!
//! Arguments: `slots=N slot=INSTRUCTIONS`. Prints what it found; exit code 0 if all is well, 1 if not.
#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(not(target_os = "none"))]
fn main() {
    eprintln!("this is firmware: build it with firmware-sim/build");
}

#[cfg(target_os = "none")]
mod firmware {
    use core::sync::atomic::{AtomicU32, Ordering::Relaxed};
    use sdp3_firmware_sim::rt::{
        foreground_instructions, instructions, lateness, pending, slots, start_counter, start_ticks, wait,
    };
    use sdp3_firmware_sim::semihosting::{arguments, exit, println};

    /// An interrupt with work of its own of two and a half slots.
    const LONG: u32 = 100;

    /// Instructions of a slot.
    static SLOT: AtomicU32 = AtomicU32::new(0);
    /// Interrupts, the most that one was late, and those that ended when the next was already due.
    static INTERRUPTS: AtomicU32 = AtomicU32::new(0);
    static LATEST: AtomicU32 = AtomicU32::new(0);
    static OVERRUNS: AtomicU32 = AtomicU32::new(0);

    #[allow(unsafe_code)] // the symbol that the timer's interrupt calls
    #[unsafe(no_mangle)]
    extern "C" fn firmware_tick() {
        let late = lateness() as u32;
        let number = INTERRUPTS.load(Relaxed) + 1;
        INTERRUPTS.store(number, Relaxed);
        // the two after the long one are late on purpose
        if !(LONG + 1..=LONG + 2).contains(&number) {
            LATEST.store(LATEST.load(Relaxed).max(late), Relaxed);
        }
        if number == LONG {
            while lateness() < u64::from(SLOT.load(Relaxed)) * 5 / 2 {}
        }
        if pending() {
            OVERRUNS.store(OVERRUNS.load(Relaxed) + 1, Relaxed);
        }
    }

    /// Work with as many instructions wherever it is interrupted.
    #[inline(never)]
    fn work() -> u32 {
        (0..20_000_u32).fold(1, |sum, k| core::hint::black_box(sum.rotate_left(5) ^ k))
    }

    /// Instructions of [`work`] in the foreground.
    fn measured() -> u64 {
        let before = foreground_instructions();
        core::hint::black_box(work());
        foreground_instructions() - before
    }

    #[allow(unsafe_code)] // the symbol that start-up calls
    #[unsafe(no_mangle)]
    extern "C" fn firmware_main() -> ! {
        let mut buffer = [0; 1024];
        let mut words = arguments(&mut buffer).split_ascii_whitespace();
        let mut number =
            |name: &str| words.next().and_then(|word| word.strip_prefix(name)?.parse::<u32>().ok());
        let (Some(wanted), Some(slot)) = (number("slots="), number("slot=")) else { exit(2) };
        SLOT.store(slot, Relaxed);
        start_counter();
        let alone = measured();
        let begun = instructions();
        start_ticks(slot);
        let (mut most, mut steps) = (0, 0_u64);
        while slots() < wanted {
            // a tenth of the slots work, the others sleep
            if slots() % 10 == 0 {
                most = measured().max(most);
                steps += 1;
            } else {
                wait();
            }
        }
        // in the middle of the slot after, which nothing can round
        while lateness() < u64::from(slot / 2) {}
        let (count, took) = (slots(), instructions() - begun);
        let expected = (took / u64::from(slot)) as u32;
        let latest = LATEST.load(Relaxed);
        let overruns = OVERRUNS.load(Relaxed);
        println(format_args!(
            "slots {count}, by the counter {expected}; interrupts {}",
            INTERRUPTS.load(Relaxed)
        ));
        println(format_args!("latest {latest}, overruns {overruns}"));
        println(format_args!("work {alone}, interrupted at most {most}, {steps} times"));
        // before an interrupt on time there is only the entry of the machine's assembly and the timer's own work; the long one
        // and the one after it end when the next is due; what is not counted of an interrupt is the assembly
        let good = count == expected
            && INTERRUPTS.load(Relaxed) == count
            && latest < 250
            && overruns == 2
            && most >= alone
            && most < alone + 200 * (2 + alone / u64::from(slot));
        println(format_args!("{}", if good { "good" } else { "WRONG" }));
        exit(usize::from(!good))
    }
}
