//! The plain station: recordings begin with their period, end when the receiver is sure, and begin anew after a loss.

mod support;

use sdp3_core::dims::Slot;
use sdp3_core::dsn::{Model, Portable};
use sdp3_core::early_exit::{Anytime, Exit};
use sdp3_core::scheduler::{Scheduler, Sensing, SlotUse};
use sdp3_core::station::Station;
use support::{Memory, noise_slots, random_model};

const PERIOD: u32 = 1000;

/// What is lost: no slot, the n-th sensing slot of the first period (from 1), or the communication slot behind it.
#[derive(Clone, Copy, PartialEq)]
enum Lost {
    Nothing,
    Sensing(u32),
    Communication(u32),
}

/// Of two periods: sensing slots, and before how many of them each verdict of which exit came.
#[derive(Debug, Default, PartialEq)]
struct Log {
    sensing: [u32; 2],
    verdicts: [Vec<(u32, u8)>; 2],
}

/// Exits after 144 and 200 slots, `wanted` sensing slots of every four, stopping at this confidence.
fn play(wanted: u32, threshold: f32, lost: Lost) -> Log {
    let files = [144, 200].map(|slots| random_model(slots, 1));
    let models = files.each_ref().map(|file| Model::parse(file).expect("a model"));
    let mut memory = Memory::of(&models[1]);
    let exits = models.map(|model| Exit::alone(model, Portable));
    let receiver: Anytime<_> = Anytime::new(exits, threshold, memory.view()).expect("enough memory");
    let sensing = Sensing::new(PERIOD, 3, wanted).expect("legal");
    let mut station = Station::new(Scheduler::new(sensing, [4, 3, 3, 0, 0, 0, 0, 0]), receiver);
    let samples: Slot = noise_slots(1, 1)[0];
    let mut log = Log::default();
    for n in 0..2 * PERIOD {
        let period = (n / PERIOD) as usize;
        let slot = station.begin();
        assert_ne!(slot, SlotUse::Idle);
        let sensing = slot == SlotUse::Sensing;
        log.sensing[period] += u32::from(sensing);
        let count = log.sensing[period];
        let losing = match lost {
            Lost::Nothing => false,
            Lost::Sensing(at) => period == 0 && sensing && count == at,
            Lost::Communication(at) => period == 0 && !sensing && count == at,
        };
        if losing {
            station.lose(slot);
        } else if sensing {
            let verdict = station.sensed(&samples);
            log.verdicts[period].extend(verdict.map(|verdict| (count, verdict.exit)));
        }
    }
    log
}

fn both(sensing: u32, verdicts: &[(u32, u8)]) -> Log {
    Log { sensing: [sensing; 2], verdicts: [verdicts.to_vec(), verdicts.to_vec()] }
}

#[test]
fn sensing_ends_when_the_receiver_is_sure() {
    assert_eq!(play(250, 2.0, Lost::Nothing), both(200, &[(144, 0), (200, 1)]));
    assert_eq!(play(250, 0.0, Lost::Nothing), both(144, &[(144, 0)]));
}

#[test]
fn no_recording_crosses_a_period() {
    // the second exit never has its slots
    assert_eq!(play(170, 2.0, Lost::Nothing), both(170, &[(144, 0)]));
}

#[test]
fn a_lost_sensing_slot_begins_anew_or_ends_sensing() {
    let usual = both(144, &[(144, 0)]);
    for (lost, sensing, verdict) in
        [(1, 145, Some(145)), (50, 194, Some(194)), (106, 250, Some(250)), (107, 107, None), (144, 144, None)]
    {
        let log = play(250, 0.0, Lost::Sensing(lost));
        assert_eq!((log.sensing[0], log.verdicts[0].first().map(|v| v.0)), (sensing, verdict), "{lost}");
        assert_eq!((log.sensing[1], &log.verdicts[1]), (144, &usual.verdicts[1]), "the next one is as usual");
    }
}

#[test]
fn a_lost_communication_slot_changes_no_recording() {
    assert_eq!(play(250, 0.0, Lost::Communication(50)), both(144, &[(144, 0)]));
    assert_eq!(play(250, 0.0, Lost::Communication(144)), both(144, &[(144, 0)]));
}
