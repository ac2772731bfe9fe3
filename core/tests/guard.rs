//! The guarded station with a real model: every trouble is told once, and a recording with a gap begins anew or ends.

mod support;

use rand_core::SeedableRng;
use rand_xoshiro::Xoshiro128PlusPlus;
use sdp3_core::dims::{Iq, SLOT_SAMPLES, Slot};
use sdp3_core::dsn::{ModelError, Shape};
use sdp3_core::early_exit::{Anytime, Exit};
use sdp3_core::memory_for;
use sdp3_core::scheduler::{Sensing, SlotUse};
use sdp3_core::supervision::station::Trouble;
use sdp3_core::supervision::{Fault, Guarded, Intact, SampleFault, Watch};
use sdp3_testkit::campaign::{self, CERTAIN, SCHEDULE, holds, recording};
use sdp3_testkit::signals::noise;
use support::slot;

static MODEL: &[u8] = sdp3_testkit::models::DSN_200;
const SHAPE: Shape = match Shape::of(MODEL) {
    Some(shape) => shape,
    None => panic!("dsn-200.sdp3 is no model"),
};
type Memory = memory_for!(SHAPE);

/// Slots of a period; every fourth of them may sense, 250 in all, for recordings of 200.
const PERIOD: u32 = 1000;
/// The radio's number of the first slot: it wraps in the second period.
const FIRST: u32 = u32::MAX - 1500;

/// What the radio does in a slot.
#[derive(Clone, Copy, PartialEq)]
enum Act {
    /// Asks for its use; gives the samples of a sensing slot.
    Works,
    /// The samples do not come.
    Loses,
    /// All samples are the same.
    Dies,
    /// The same number again, then works.
    Repeats,
    /// The samples are given twice.
    Doubles,
    /// The samples come with the number of the slot before.
    Misnumbers,
    /// So many slots pass unnoticed.
    Sleeps(u32),
}

/// What came of two periods: sensing slots, and in which of them the verdicts came; what was told, and in which slot.
#[derive(Debug, Default, PartialEq)]
struct Log {
    sensing: [u32; 2],
    verdicts: Vec<(u32, u32)>,
    told: Vec<(u32, Trouble)>,
}

/// Two periods in which the radio does `act` in slot `at` and works in the others.
fn play(at: u32, act: Act) -> Log {
    let mut memory = Box::new(Memory::new());
    let (intact, model) = Intact::accept(MODEL).expect("a model");
    let mut buffers = memory.view();
    let kernels = buffers.take_kernels(&model).expect("enough memory");
    let receiver: Anytime<_> =
        Anytime::new([Exit::alone(model, kernels)], 2.0, buffers).expect("enough memory");
    let sensing = Sensing::new(PERIOD, 3, PERIOD / 4).expect("legal");
    let watch = Watch::new(sensing, [1500, 2500, 0, 0, 0, 0, 0, 0], FIRST);
    let mut station = Guarded::new(watch, receiver, [intact].into_iter().collect());
    let mut rng = Xoshiro128PlusPlus::seed_from_u64(5);
    let mut samples = [0; 2 * SLOT_SAMPLES];
    let mut log = Log::default();
    let mut n = 0;
    while n < 2 * PERIOD {
        let act = if n == at { act } else { Act::Works };
        if let Act::Sleeps(slots) = act {
            n += slots;
        }
        let number = FIRST.wrapping_add(n);
        let mut begun = station.begin(number);
        log.told.extend(begun.troubles.iter().map(|trouble| (n, *trouble)));
        if act == Act::Repeats {
            let again = station.begin(number);
            assert_eq!(again.slot, begun.slot, "the same use again");
            begun = again;
            log.told.extend(begun.troubles.iter().map(|trouble| (n, *trouble)));
        }
        if begun.slot == SlotUse::Sensing {
            let count = &mut log.sensing[(n / PERIOD) as usize];
            *count += 1;
            noise(&mut rng, &mut samples);
            let samples = slot(&samples);
            let mut give = |number, samples: &Slot| match station.sensed(number, samples) {
                Ok(Some(verdict)) => {
                    assert!(verdict.stop && verdict.exit == 0);
                    log.verdicts.push((n / PERIOD, *count));
                }
                Ok(None) => (),
                Err(trouble) => log.told.push((n, trouble)),
            };
            match act {
                Act::Loses => (),
                Act::Dies => give(number, &[Iq { i: 7, q: 7 }; SLOT_SAMPLES]),
                Act::Misnumbers => {
                    give(number.wrapping_sub(1), &samples);
                    give(number, &samples);
                }
                Act::Doubles => {
                    give(number, &samples);
                    give(number, &samples);
                }
                _ => give(number, &samples),
            }
        }
        n += 1;
    }
    log
}

/// Slot of the `k`-th sensing slot of the first period, from 1.
const fn sensing(k: u32) -> u32 {
    4 * (k - 1)
}

fn log(sensing: [u32; 2], verdicts: &[(u32, u32)], told: &[(u32, Trouble)]) -> Log {
    Log { sensing, verdicts: verdicts.to_vec(), told: told.to_vec() }
}

#[test]
fn a_working_radio_is_told_nothing_and_its_sensing_ends_with_the_verdict() {
    assert_eq!(play(0, Act::Works), log([200, 200], &[(0, 200), (1, 200)], &[]));
}

#[test]
fn a_recording_with_a_gap_begins_anew_while_there_are_slots_for_it() {
    // the 50th of 250 sensing slots is the last whose loss leaves 200
    for k in [1, 2, 30, 50] {
        let anew = |told| log([k + 200, 200], &[(0, k + 200), (1, 200)], &[told]);
        let missing = (sensing(k) + 1, Trouble::Missing);
        assert_eq!(play(sensing(k), Act::Loses), anew(missing), "lost: {k}");
        let silent = (sensing(k), Trouble::Samples(SampleFault::Silent));
        assert_eq!(play(sensing(k), Act::Dies), anew(silent), "silent: {k}");
    }
    for k in [51, 120, 199] {
        let ended = |told| log([k, 200], &[(1, 200)], &[told]);
        let missing = (sensing(k) + 1, Trouble::Missing);
        assert_eq!(play(sensing(k), Act::Loses), ended(missing), "lost: {k}");
        let silent = (sensing(k), Trouble::Samples(SampleFault::Silent));
        assert_eq!(play(sensing(k), Act::Dies), ended(silent), "silent: {k}");
    }
}

#[test]
fn samples_that_nobody_waits_for_change_nothing() {
    let undisturbed = |at| log([200, 200], &[(0, 200), (1, 200)], &[(at, Trouble::Unasked)]);
    for k in [1, 77, 200] {
        assert_eq!(play(sensing(k), Act::Doubles), undisturbed(sensing(k)), "{k}");
        assert_eq!(play(sensing(k), Act::Misnumbers), undisturbed(sensing(k)), "{k}");
    }
}

#[test]
fn a_slot_given_again_is_told_and_changes_nothing() {
    for at in [0, 1, sensing(40), sensing(40) + 2, sensing(200), 900] {
        let told = [(at, Trouble::Slot(Fault::Repeated))];
        assert_eq!(play(at, Act::Repeats), log([200, 200], &[(0, 200), (1, 200)], &told), "{at}");
    }
}

#[test]
fn skipped_slots_are_a_gap_only_if_they_were_to_sense() {
    let skipped = |slots, sensing| Trouble::Slot(Fault::Skipped { slots, sensing });
    // three between two sensing slots
    let told = [(sensing(9) + 4, skipped(3, 0))];
    assert_eq!(play(sensing(9) + 1, Act::Sleeps(3)), log([200, 200], &[(0, 200), (1, 200)], &told));
    // nine with three of them: the eight sensed before are lost with them
    let told = [(sensing(9) + 9, skipped(9, 3))];
    assert_eq!(play(sensing(9), Act::Sleeps(9)), log([8 + 200, 200], &[(0, 208), (1, 200)], &told));
    // after the verdict nobody minds
    let told = [(905, skipped(5, 0))];
    assert_eq!(play(900, Act::Sleeps(5)), log([200, 200], &[(0, 200), (1, 200)], &told));
    // from the last slot of a period into the next one: 49 of its sensing slots are not needed
    for (slots, sensing) in [(1, 1), (6, 2), (62, 16)] {
        let told = [(PERIOD + slots, skipped(slots, sensing))];
        assert_eq!(play(PERIOD, Act::Sleeps(slots)), log([200, 200], &[(0, 200), (1, 200)], &told));
    }
    // fifteen sensing slots skipped after 35: 200 are left with the one that tells it; after 36 too few
    let told = [(sensing(36) + 60, skipped(60, 15))];
    assert_eq!(play(sensing(36), Act::Sleeps(60)), log([35 + 200, 200], &[(0, 235), (1, 200)], &told));
    let told = [(sensing(37) + 60, skipped(60, 15))];
    assert_eq!(play(sensing(37), Act::Sleeps(60)), log([36, 200], &[(1, 200)], &told));
    // an outage begins a new period, of 1000 slots from there: 296, ..., 1296, ...
    let outage = (sensing(50) + 100, Trouble::Slot(Fault::Outage { slots: 100 }));
    assert_eq!(play(sensing(50), Act::Sleeps(100)), log([49 + 176, 24 + 176], &[(1, 24)], &[outage]));
}

#[test]
fn faults_of_the_schedule_are_detected_once_and_no_invariant_breaks() {
    let table = campaign::run(&mut Xoshiro128PlusPlus::seed_from_u64(8), 40_000, &[], &mut []);
    assert!(holds(&table, CERTAIN), "{table:#?}");
    assert!(table[..SCHEDULE].iter().all(|o| o.injected > 1800));
    // corrupted samples are detected as far as they show
    assert!(table[CERTAIN..].iter().all(|o| o.injected == o.detected + o.silent));
    let [silent, stuck, _, _, glitch] = table[CERTAIN..] else { panic!("kinds of samples") };
    assert_eq!((silent.silent, stuck.silent, glitch.detected), (0, 0, 0));
}

#[test]
fn faults_during_recordings_are_reported_and_the_next_classification_is_the_same() {
    let mut memory = Box::new(Memory::new());
    let (intact, model) = Intact::accept(MODEL).expect("a model");
    let watch = recording::watch(model.sensing_slots() as u32).expect("legal");
    let mut buffers = memory.view();
    let kernels = buffers.take_kernels(&model).expect("enough memory");
    let receiver: Anytime<_> =
        Anytime::new([Exit::alone(model, kernels)], 2.0, buffers).expect("enough memory");
    let mut station = Guarded::new(watch, receiver, [intact].into_iter().collect());
    let each = 6;
    let events = each * recording::KINDS.len() as u64;
    let table = recording::run::<Xoshiro128PlusPlus, _, _>(&mut station, 9, events);
    assert!(holds(&table, table.len()) && table.iter().all(|o| o.injected == each), "{table:#?}");
}

#[test]
fn a_model_is_looked_at_byte_by_byte() {
    let (intact, model) = Intact::accept(MODEL).expect("a model");
    assert_eq!(model.sensing_slots(), 200);
    assert_eq!((intact.check(), intact.against(MODEL)), (Ok(()), Ok(())));
    let mut copy = MODEL.to_vec();
    let changed = |bytes: &[u8]| matches!(intact.against(bytes), Err(ModelError::Checksum { stated, computed }) if stated != computed);
    for at in (0..copy.len()).step_by(97) {
        copy[at] ^= 1 << (at % 8);
        assert!(changed(&copy), "byte {at}");
        copy[at] ^= 1 << (at % 8);
    }
    assert_eq!(intact.against(&copy), Ok(()));
    assert!(changed(&MODEL[..MODEL.len() - 1]));
    copy.push(0);
    assert!(changed(&copy));
    copy.truncate(500);
    assert!(Intact::accept(&copy).is_err());
}
