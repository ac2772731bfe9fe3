//! Injects faults and prints the counts of their outcomes and the digest of all counts.
//!
//! Arguments: `seed=N`; `events=N`, faults of schedule, model and samples; `recordings=N`, faults during recordings, from dechirp to
//! network. Exit code 0 if no fault of schedule, model or recording was silent and no invariant broke, 1 if one did.
#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(not(target_os = "none"))]
fn main() {
    eprintln!("this is firmware: build it with firmware-sim/build");
}

#[cfg(target_os = "none")]
mod firmware {
    use rand_core::SeedableRng;
    use rand_xoshiro::Xoshiro128PlusPlus;
    use sdp3_core::dsn::Shape;
    use sdp3_core::early_exit::{Anytime, Exit};
    use sdp3_core::memory_for;
    use sdp3_core::supervision::{Guarded, Intact};
    use sdp3_firmware_sim::rt::Single;
    use sdp3_firmware_sim::semihosting::{arguments, exit, println};
    use sdp3_testkit::campaign::{CERTAIN, KINDS, Outcome, digest, holds, recording, run};

    static MODEL: &[u8] = sdp3_testkit::models::DSN_200;
    const SHAPE: Shape = match Shape::of(MODEL) {
        Some(shape) => shape,
        None => panic!("dsn-200.sdp3 is no model"),
    };
    type Small = memory_for!(SHAPE);
    static MEMORY: Single<Small> = Single::new(Small::new());
    static COPY: Single<[u8; 1 << 14]> = Single::new([0; 1 << 14]);

    /// Prints the outcomes and their digest. Returns whether every kind occurred and no invariant broke, with nothing silent in the
    /// first `certain` kinds.
    fn print(what: &str, kinds: &[&str], certain: usize, table: &[Outcome], events: u64) -> bool {
        kinds.iter().zip(table).for_each(|(kind, o)| println(format_args!("{kind:<32}{o}")));
        println(format_args!("{what} {:016x} of {events}", digest(table)));
        holds(table, certain) && (events < kinds.len() as u64 || table.iter().all(|o| o.injected > 0))
    }

    #[allow(unsafe_code)] // the symbol that start-up calls
    #[unsafe(no_mangle)]
    extern "C" fn firmware_main() -> ! {
        let mut buffer = [0; 1024];
        let (mut seed, mut events, mut recordings) = (1_u64, 1000_u64, 12_u64);
        for word in arguments(&mut buffer).split_ascii_whitespace() {
            match word.split_once('=').map(|(name, value)| (name, value.parse())) {
                Some(("seed", Ok(number))) => seed = number,
                Some(("events", Ok(number))) => events = number,
                Some(("recordings", Ok(number))) => recordings = number,
                _ => {
                    println(format_args!("an argument is none of seed=N, events=N, recordings=N"));
                    exit(2)
                }
            }
        }
        let (Some(copy), Some(memory)) = (COPY.take(), MEMORY.take()) else { exit(2) };
        let mut rng = Xoshiro128PlusPlus::seed_from_u64(seed);
        let table = run(&mut rng, events, MODEL, copy);
        let mut held = print("digest", &KINDS, CERTAIN, &table, events);
        let Ok((intact, model)) = Intact::accept(MODEL) else { exit(2) };
        let Ok(watch) = recording::watch(model.sensing_slots() as u32) else { exit(2) };
        let mut buffers = memory.view();
        let Ok(kernels) = buffers.take_kernels(&model) else { exit(2) };
        let Ok(receiver) = Anytime::new([Exit::alone(model, kernels)], 2.0, buffers) else { exit(2) };
        let mut station = Guarded::new(watch, receiver, [intact].into_iter().collect());
        let table = recording::run::<Xoshiro128PlusPlus, _, _>(&mut station, seed, recordings);
        held &= print("recordings", &recording::KINDS, recording::KINDS.len(), &table, recordings);
        exit(usize::from(!held))
    }
}
