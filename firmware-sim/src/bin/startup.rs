//! Checks what start-up does to memory that is full of other values: `.data` copied, `.bss` cleared, `.uninit` left alone.
//!
//! Arguments: `filled=BYTE` says that the emulator filled the machine's data memory with this byte before it started; without
//! it the program changes all three sections itself and resets the machine. `overflow` calls itself until the stack is
//! exhausted, which must end in exit code 102 where the processor has a stack limit. Exit code 0 if all is well, 1 if not.
#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(not(target_os = "none"))]
fn main() {
    eprintln!("this is firmware: build it with firmware-sim/build");
}

#[cfg(target_os = "none")]
mod firmware {
    use core::array::from_fn;
    use core::sync::atomic::{AtomicU32, Ordering::Relaxed};
    use sdp3_firmware_sim::rt::reset;
    use sdp3_firmware_sim::semihosting::{arguments, exit, println};

    type Words = [AtomicU32; 64];
    /// What the program writes over everything before a reset.
    const OTHER: u32 = 0x5A17_C0DE;

    const fn initial(k: usize) -> u32 {
        (k as u32 + 1).wrapping_mul(0x9E37_79B9)
    }

    const INITIAL: Words = {
        let mut words = [const { AtomicU32::new(0) }; 64];
        let mut k = 0;
        while k < words.len() {
            words[k] = AtomicU32::new(initial(k));
            k += 1;
        }
        words
    };

    static DATA: Words = INITIAL;
    static BSS: Words = [const { AtomicU32::new(0) }; 64];
    #[allow(unsafe_code)] // a section that start-up leaves alone; any bits are a value
    #[unsafe(link_section = ".uninit.startup")]
    static UNINIT: Words = [const { AtomicU32::new(0) }; 64];

    #[allow(unconditional_recursion)]
    #[inline(never)]
    fn overflow(depth: u32) -> u32 {
        let words = core::hint::black_box([depth; 64]);
        overflow(depth.wrapping_add(1)).wrapping_add(words[(depth % 64) as usize])
    }

    #[allow(unsafe_code)] // the symbol that start-up calls
    #[unsafe(no_mangle)]
    extern "C" fn firmware_main() -> ! {
        let mut buffer = [0; 1024];
        let argument = arguments(&mut buffer);
        if argument == "overflow" {
            overflow(0);
        }
        let filled = argument.strip_prefix("filled=").and_then(|byte| byte.parse::<u8>().ok());
        let values = |words: &Words| -> [u32; 64] { from_fn(|k| words[k].load(Relaxed)) };
        let kept = match filled {
            Some(byte) => [u32::from_ne_bytes([byte; 4]); 64],
            None => [OTHER; 64],
        };
        if filled.is_none() && values(&UNINIT) != kept {
            [&DATA, &BSS, &UNINIT].into_iter().flatten().for_each(|word| word.store(OTHER, Relaxed));
            reset();
        }
        let good = [values(&DATA) == from_fn(initial), values(&BSS) == [0; 64], values(&UNINIT) == kept];
        let words = |good| if good { "as it should be" } else { "WRONG" };
        println(format_args!("data {}, bss {}, uninit {}", words(good[0]), words(good[1]), words(good[2])));
        exit(usize::from(good != [true; 3]))
    }
}
