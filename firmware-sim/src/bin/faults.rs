//! Breaks the guards on purpose and prints what became of every fault, and the digest of all counts.
//!
//! Arguments: `seed=N`, `events=N`. Exit code 0 if no fault of schedule or model was silent and no promise broke, 1 if one was.
#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(not(target_os = "none"))]
fn main() {
    eprintln!("this is firmware: build it with firmware-sim/build");
}

#[cfg(target_os = "none")]
mod firmware {
    use rand_core::SeedableRng;
    use sdp3_core::guard::campaign::{CERTAIN, KINDS, digest, run};
    use sdp3_firmware_sim::rt::Single;
    use sdp3_firmware_sim::semihosting::{arguments, exit, println};

    static MODEL: &[u8] = include_bytes!("../../models/dsn-200.sdp3");
    static COPY: Single<[u8; 1 << 14]> = Single::new([0; 1 << 14]);

    #[allow(unsafe_code)] // the symbol that start-up calls
    #[unsafe(no_mangle)]
    extern "C" fn firmware_main() -> ! {
        let mut buffer = [0; 1024];
        let (mut seed, mut events) = (1_u64, 1000_u64);
        for word in arguments(&mut buffer).split_ascii_whitespace() {
            match word.split_once('=').map(|(name, value)| (name, value.parse())) {
                Some(("seed", Ok(number))) => seed = number,
                Some(("events", Ok(number))) => events = number,
                _ => {
                    println(format_args!("an argument is neither seed=N nor events=N"));
                    exit(2)
                }
            }
        }
        let mut rng = rand_xoshiro::Xoshiro128PlusPlus::seed_from_u64(seed);
        let Some(copy) = COPY.take() else { exit(2) };
        let table = run(&mut rng, events, MODEL, copy);
        let mut held = true;
        for (kind, (name, o)) in KINDS.iter().zip(&table).enumerate() {
            println(format_args!(
                "{name:<30}{:>10}{:>10}{:>10}{:>10}{:>10}",
                o.injected, o.detected, o.recovered, o.silent, o.broken
            ));
            held &= o.broken == 0 && o.injected > 0;
            held &=
                kind >= CERTAIN || (o.detected == o.injected && o.recovered == o.injected && o.silent == 0);
        }
        println(format_args!("digest {:016x} of {events}", digest(&table)));
        exit(usize::from(!held))
    }
}
