//! Injects faults and prints the counts of their outcomes and the digest of all counts.
//!
//! Arguments: `seed=N`; `events=N`, faults of schedule and samples; `recordings=N`, faults during recordings, from dechirp to
//! network. Exit code 0 if no certain fault was silent and no invariant broke, 1 if one did.
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
    use sdp3_core::radar::RadarModule;
    use sdp3_core::radar_memory;
    use sdp3_core::supervision::retained::Retained;
    use sdp3_firmware_sim::rt::Single;
    use sdp3_firmware_sim::semihosting::{arguments, exit, println};
    use sdp3_testkit::campaign::environment::Contexts;
    use sdp3_testkit::campaign::recording::{self, Recordings, exits, settings, shorten};
    use sdp3_testkit::campaign::schedule::Schedule;
    use sdp3_testkit::campaign::{CERTAIN, KINDS, Outcome, digest, holds, run};

    const FILE: &[u8] = sdp3_testkit::models::DSN_200;
    const SHAPE: Shape = match Shape::of(FILE) {
        Some(shape) => shape,
        None => panic!("dsn-200.sdp3 is no model"),
    };
    const NEED: u32 = SHAPE.sensing_slots as u32;
    const VALUES: usize = SHAPE.slot_values();
    type Memory = radar_memory!(SHAPE);

    /// One for the schedule, one for the recordings, and one for each reset.
    static MEMORIES: [Single<Memory>; 8] = [const { Single::new(Memory::new()) }; 8];
    static RETAINED: [Retained; 2] = [const { Retained::new() }; 2];
    /// The models of both exits in memory that can be written.
    static MODELS: [Single<[u8; FILE.len()]>; 2] = [const { Single::new([0; FILE.len()]) }; 2];

    fn memory() -> Option<&'static mut Memory> {
        MEMORIES.iter().find_map(Single::take)
    }

    fn contexts(files: [&'static [u8]; 2], retained: &'static Retained) -> Option<Contexts<VALUES>> {
        let module = RadarModule::new(&exits(files)?, settings(NEED).ok()?, memory()?, retained);
        Some(module.ok()?.split())
    }

    /// Prints the outcomes and their digest. Returns whether every kind occurred and no invariant broke, with nothing silent in the
    /// first `certain` kinds.
    fn print(what: &str, kinds: &[&str], certain: usize, table: &[Outcome], events: u64) -> bool {
        kinds.iter().zip(table).for_each(|(kind, o)| println(format_args!("{kind:<32}{o}")));
        println(format_args!("{what} {:016x} of {events}", digest(table)));
        holds(table, certain) && (events < kinds.len() as u64 || table.iter().all(|o| o.injected > 0))
    }

    /// All faults; `None`: there is no memory left.
    fn all(seed: u64, events: u64, recordings: u64) -> Option<bool> {
        let ([schedule, recorded], settings) = (&RETAINED, settings(NEED).ok()?);
        let (first, last) = (MODELS[0].take()?, MODELS[1].take()?);
        first.copy_from_slice(FILE);
        shorten(first);
        last.copy_from_slice(FILE);
        let files: [&'static [u8]; 2] = [first, last];
        let mut rng = Xoshiro128PlusPlus::seed_from_u64(seed);
        let module = RadarModule::single(FILE, settings, memory()?, schedule).ok()?;
        let mut radio = Schedule::new(module.split(), &settings, schedule, NEED, &mut rng);
        let mut held = print("digest", &KINDS, CERTAIN, &run(&mut radio, &mut rng, events), events);
        let mut radio = Recordings::new(NEED, files, recorded, || contexts(files, recorded), seed)?;
        let kinds = &recording::KINDS;
        held &= print("recordings", kinds, kinds.len(), &radio.run(recordings), recordings);
        Some(held)
    }

    #[allow(unsafe_code)] // the symbol that start-up calls
    #[unsafe(no_mangle)]
    extern "C" fn firmware_main() -> ! {
        let mut buffer = [0; 1024];
        let (mut seed, mut events, mut recordings) = (1_u64, 1000_u64, 16_u64);
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
        match all(seed, events, recordings) {
            Some(held) => exit(usize::from(!held)),
            None => {
                println(format_args!("there is no memory for another module"));
                exit(2)
            }
        }
    }
}
