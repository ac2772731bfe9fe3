//! The firmware's programs under QEMU: the station recognises what the host does, and its defmt records can be read.

use sdp3::conformance::qemu::{Firmware, QemuError, machines, run};
use sdp3::conformance::suite::{ScheduleCase, Suite, stimuli};
use sdp3::formats::slots::Slots;
use sdp3::network::memory::OwnedMemory;
use sdp3::scenario::Class;
use sdp3::simulator::calibration::stored_rho;
use sdp3::simulator::dataset::{Set, recording};
use sdp3_core::dsn::Model;
use sdp3_core::signal::stft::FixedStft;
use sdp3_testkit::models::DSN_200;
use sdp3_tests::{call, outcome, program};
use std::path::Path;
use std::time::Duration;

const LIMIT: Duration = Duration::from_secs(300);

/// A program on the two machines that `firmware-sim/build` always makes for the main job.
fn built(name: &str) -> Vec<Firmware> {
    let folder = program().ancestors().nth(2).expect("target").join("firmware");
    let wanted = ["cortex-m4f", "riscv32imac"];
    machines(&folder, name).into_iter().filter(|machine| wanted.contains(&machine.name)).collect()
}

/// Every record of a log in words: level and text.
fn records(firmware: &Firmware, log: &Path) -> Vec<String> {
    let reader = program().ancestors().nth(2).expect("target").join("defmt/release/sdp3-defmt");
    assert!(reader.is_file(), "{} is missing: run tests/run, or tests/defmt/build first", reader.display());
    let arguments = [&firmware.elf, log].map(|path| path.to_str().expect("a plain path"));
    let (code, records, error) = outcome(&call(&reader, &arguments));
    assert_eq!(code, 0, "{error}");
    records.lines().map(str::to_owned).collect()
}

fn walk(slots: u32) -> Slots {
    let scenario = sdp3_tests::printed_room();
    recording(&scenario, stored_rho(&scenario).0, 5, Set::Demo, Class::AdultWalking, 0, slots).slots
}

#[test]
fn the_stations_recognise_what_the_host_does_and_log_it() {
    let folder = tempfile::Builder::new().prefix("with a space ").tempdir().expect("a folder");
    let slots = walk(200);
    let file = folder.path().join("walk");
    std::fs::write(&file, slots.to_le_bytes()).expect("a file of slots");

    let parsed = Model::parse(DSN_200).expect("a model");
    let mut memory = OwnedMemory::for_model(&parsed);
    // the arithmetic of microcontrollers
    let mut pipeline = memory.pipeline::<FixedStft>(parsed).expect("enough memory");
    slots.iter().for_each(|slot| pipeline.push(slot, &mut ()).expect("room"));
    let answer = pipeline.classify(&mut ()).expect("complete");
    let class = parsed.class_name(usize::from(answer.class));

    for name in ["station-small", "station-signed"] {
        for firmware in built(name) {
            let log = folder.path().join("log");
            let arguments = ["walk", "log"].map(str::to_owned);
            let text = run(&firmware, folder.path(), &arguments, LIMIT).expect("it runs");
            let says = |line: &str| text.lines().any(|l| l.trim() == line);
            assert!(says(&format!("recognised {class}")), "{}: {text}", firmware.name);
            assert!(says("faults 0") && says("periods 1") && says("done"), "{}: {text}", firmware.name);
            let records = records(&firmware, &log);
            assert_eq!(records.len(), 2, "{records:?}");
            assert!(
                records[0].starts_with("info Period(PeriodReport { period: 1, replanned: true,"),
                "{records:?}"
            );
            let expected = format!("class: {}, confidence: {:?}", answer.class, answer.confidence);
            assert!(records[1].contains(&expected), "{records:?} should say {expected}");
        }
    }
}

#[test]
fn a_damaged_model_is_refused_in_the_log_by_its_reason() {
    let folder = tempfile::Builder::new().prefix("with a space ").tempdir().expect("a folder");
    let mut bytes = DSN_200.to_vec();
    bytes[1000] ^= 4;
    let schedule = ScheduleCase { period: 40, spacing: 3, sensing: 5, shares: vec![35] };
    let suite = Suite { cases: stimuli(&bytes, 2, 1), schedule };
    let file = folder.path().join("suite");
    std::fs::write(&file, suite.to_bytes()).expect("a suite");
    for firmware in built("conformance") {
        let log = folder.path().join("log");
        let arguments = ["suite", "log=log"].map(str::to_owned);
        match run(&firmware, folder.path(), &arguments, LIMIT) {
            Err(QemuError::Output { reason, .. }) => {
                assert!(reason.contains("the core refuses a model"), "{reason}")
            }
            other => panic!("{}: {other:?}", firmware.name),
        }
        let records = records(&firmware, &log);
        let has = |level: &str, text: &str| records.iter().any(|r| r.starts_with(level) && r.contains(text));
        assert!(has("info", "suite opened: 10 cases"), "{records:?}");
        assert!(has("error", "Checksum { stated: "), "{records:?}");
    }
}
