//! Counts the instructions of every stage: of one sensing slot, and of one recognition at N_s = 1000.
//!
//! The signal is seeded noise. A stage is what runs between two calls of the probe; the probe itself costs some twenty
//! instructions a call.
#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(not(target_os = "none"))]
fn main() {
    eprintln!("this is firmware: build it with firmware-sim/build");
}

#[cfg(target_os = "none")]
mod firmware {
    use rand_core::SeedableRng;
    use sdp3_core::dims::{Beat, Complex, Iq, SLOT_SAMPLES, Slot};
    use sdp3_core::dsn::Model;
    use sdp3_core::pipeline::{Receiver, StandardMemory};
    use sdp3_core::probe::Probe;
    use sdp3_core::selftest::noise;
    use sdp3_core::signal::clutter::{Gram, Weights};
    use sdp3_firmware_sim::rt::{Single, instructions, start_counter};
    use sdp3_firmware_sim::semihosting::{exit, println};

    static MODEL: &[u8] = sdp3_testkit::models::DSN_1000;
    static MEMORY: Single<StandardMemory> = Single::new(StandardMemory::new());

    const STAGES: [&str; 6] = ["dechirp", "gram", "weights", "projection", "spectrogram", "network"];

    /// Instructions of each of [`STAGES`].
    struct Stopwatch {
        since: u64,
        counts: [u64; STAGES.len()],
    }

    impl Stopwatch {
        /// Begins to count.
        fn start(&mut self) {
            self.since = instructions();
        }

        /// What ran since the last call belongs to this stage.
        fn stop(&mut self, stage: usize) {
            let now = instructions();
            if let Some(count) = self.counts.get_mut(stage) {
                *count += now.wrapping_sub(self.since);
            }
            self.since = instructions();
        }
    }

    impl Probe for Stopwatch {
        fn beat(&mut self, _beat: &Beat) {
            self.stop(0);
        }
        fn gram(&mut self, _gram: &Gram) {
            self.start();
        }
        fn weights(&mut self, _weights: &Weights) {
            self.stop(2);
        }
        fn slow_time(&mut self, _slow_time: &[Complex<i32>]) {
            self.stop(3);
        }
        fn image(&mut self, _image: &[i8]) {
            self.stop(4);
        }
        fn confidence(&mut self, _confidence: f32) {
            self.stop(5);
        }
    }

    #[allow(unsafe_code)] // the symbol that start-up calls
    #[unsafe(no_mangle)]
    extern "C" fn firmware_main() -> ! {
        start_counter();
        let mut rng = rand_xoshiro::Xoshiro128PlusPlus::seed_from_u64(3);
        let (Ok(model), Some(memory)) = (Model::parse(MODEL), MEMORY.take()) else { exit(2) };
        let slots = model.sensing_slots() as u64;
        let Ok(mut receiver) = Receiver::new(model, memory.view()) else { exit(2) };
        let mut watch = Stopwatch { since: 0, counts: [0; STAGES.len()] };
        let mut slot: Slot = [Iq { i: 0, q: 0 }; SLOT_SAMPLES];
        for _ in 0..slots {
            noise(&mut rng, &mut slot);
            watch.start();
            let taken = receiver.push(&slot, &mut watch);
            watch.stop(1);
            if taken.is_err() {
                exit(2);
            }
        }
        if receiver.classify(&mut watch).is_err() {
            exit(2);
        }
        println(format_args!("slots {slots}"));
        for (name, count) in STAGES.into_iter().zip(watch.counts) {
            println(format_args!("{name} {count}"));
        }
        println(format_args!("done"));
        exit(0)
    }
}
