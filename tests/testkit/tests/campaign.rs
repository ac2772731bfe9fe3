//! A short fault campaign on the radar module.

use rand_core::SeedableRng;
use rand_xoshiro::Xoshiro128PlusPlus;
use sdp3_core::dsn::Shape;
use sdp3_core::radar::RadarModule;
use sdp3_core::radar_memory;
use sdp3_core::supervision::retained::Retained;
use sdp3_testkit::campaign::environment::Contexts;
use sdp3_testkit::campaign::recording::{Recordings, exits, settings, shorten};
use sdp3_testkit::campaign::schedule::Schedule;
use sdp3_testkit::campaign::{CERTAIN, KINDS, holds, recording, run};
use sdp3_testkit::models::DSN_200;

const SHAPE: Shape = Shape::of(DSN_200).expect("a model");
const NEED: u32 = SHAPE.sensing_slots as u32;
type Memory = radar_memory!(SHAPE);

fn contexts(retained: &'static Retained) -> Option<Contexts<{ SHAPE.slot_values() }>> {
    let memory: &'static mut Memory = Box::leak(Box::new(Memory::new()));
    let settings = settings(NEED).expect("a layout");
    Some(RadarModule::single(DSN_200, settings, memory, retained).expect("a module").split())
}

#[test]
fn faults_of_the_schedule_and_corrupted_samples_are_found() {
    let retained: &'static Retained = Box::leak(Box::new(Retained::new()));
    let mut rng = Xoshiro128PlusPlus::seed_from_u64(1);
    let settings = settings(NEED).expect("a layout");
    let contexts = contexts(retained).expect("contexts");
    let mut schedule = Schedule::new(contexts, &settings, retained, NEED, &mut rng);
    let table = run(&mut schedule, &mut rng, 100 * KINDS.len() as u64);
    KINDS.iter().zip(&table).for_each(|(kind, outcome)| println!("{kind:<32}{outcome}"));
    assert!(holds(&table, CERTAIN));
    assert!(table.iter().all(|outcome| outcome.injected == 100));
}

#[test]
fn recordings_survive_faults() {
    let retained: &'static Retained = Box::leak(Box::new(Retained::new()));
    // changed in place
    let files: [&'static [u8]; 2] = [true, false].map(|short| {
        let file = DSN_200.to_vec().leak();
        if short {
            shorten(file);
        }
        &*file
    });
    let make = || {
        let memory: &'static mut Memory = Box::leak(Box::new(Memory::new()));
        let module = RadarModule::new(&exits(files)?, settings(NEED).ok()?, memory, retained);
        Some(module.ok()?.split())
    };
    let mut recordings = Recordings::new(NEED, files, retained, make, 1).expect("a module");
    let table = recordings.run(5 * recording::KINDS.len() as u64);
    recording::KINDS.iter().zip(&table).for_each(|(kind, outcome)| println!("{kind:<32}{outcome}"));
    assert!(holds(&table, table.len()));
}
