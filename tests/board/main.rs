//! Boards: what `tests/boards` runs.
//!
//! `board recording FILE` writes the recording that a board's station plays, 200 slots of a walking adult.
//! `board conformance SUITE BYTES COMMAND...` writes the cases of the conformance suite that fit a board to the file SUITE, at most
//! BYTES at a time, runs the COMMAND for each, and compares every digest it prints.
//! `board station COMMAND...` compares what a station recognises with what this machine does, and reads its counts.
//! The COMMAND runs the board's program and prints what comes over its serial line. Exit code 1 if anything differs.

mod serial;

use sdp3::conformance::digests::{compare, digests};
use sdp3::conformance::suite::{Case, Suite};
use sdp3::conformance::transcript::parse;
use sdp3::formats::slots::Slots;
use sdp3::network::memory::OwnedMemory;
use sdp3::scenario::Class;
use sdp3::simulator::calibration::stored_rho;
use sdp3::simulator::dataset::{Set, recording};
use sdp3_core::dsn::Model;
use sdp3_core::signal::stft::FixedStft;
use sdp3_testkit::models::DSN_200;
use std::process::ExitCode;

type Result<T> = std::result::Result<T, Box<dyn std::error::Error>>;

/// What `firmware-sim/boards/support/src/suite.rs` has memory for: sensing slots, channels, bytes of a model.
const LARGEST: (usize, usize, usize) = (200, 16, 24 * 1024);
/// Slots that the station plays before it prints its counts.
const PLAYED: u64 = 10_000;

fn walking_adult() -> Slots {
    let scenario = sdp3_tests::printed_room();
    recording(&scenario, stored_rho(&scenario).0, 5, Set::Demo, Class::AdultWalking, 0, 200).slots
}

/// Whether a board has memory for a case.
fn fits(case: &Case) -> bool {
    let (slots, channels, bytes) = LARGEST;
    let small = |model: Model| model.sensing_slots() <= slots && model.channels() <= channels;
    case.model.len() <= bytes && Model::parse(&case.model).is_ok_and(small)
}

/// The cases that fit a board, in files of at most so many bytes.
fn files(most: usize) -> Result<Vec<Suite>> {
    let Suite { cases, schedule } = sdp3_tests::suites::suite(10)?;
    let of = |cases| Suite { cases, schedule: schedule.clone() };
    let all = cases.len();
    let mut files: Vec<Suite> = Vec::new();
    for case in cases.into_iter().filter(fits) {
        let bytes = |suite: &Suite| suite.to_bytes().len();
        let single = of(vec![case]);
        let fits_last = files.last().is_some_and(|last| bytes(last) + bytes(&single) <= most);
        match files.last_mut() {
            Some(last) if fits_last => last.cases.extend(single.cases),
            _ if bytes(&single) <= most => files.push(single),
            _ => return Err(format!("a case takes {} bytes, of {most}", bytes(&single)).into()),
        }
    }
    let fitting: usize = files.iter().map(|suite| suite.cases.len()).sum();
    println!("{fitting} of {all} cases fit, {most} bytes at a time");
    Ok(files)
}

fn conformance(file: &str, most: &str, command: &[String]) -> Result<bool> {
    let (mut cases, mut compared, mut differ, mut stack) = (0, 0, 0, 0);
    for suite in &files(most.parse()?)? {
        std::fs::write(file, suite.to_bytes()).map_err(|error| format!("{file}: {error}"))?;
        let text = serial::lines(command)?;
        let there = parse(&text).map_err(|error| format!("{error}\n{text}"))?;
        let (verdict, _) = compare("board", &digests(suite)?, &there);
        cases += suite.cases.len();
        compared += verdict.compared;
        differ += verdict.mismatches;
        stack = there.stack_bytes.max(stack);
        if let Some(detail) = &verdict.detail {
            println!("  {detail}");
        }
    }
    println!("{cases} cases, {compared} digests compared, {differ} differ, stack {stack} bytes");
    Ok(compared > 0 && differ == 0)
}

/// What the station should recognise: its recording, in each period from the first slot on.
fn expected() -> Result<String> {
    let parsed = Model::parse(DSN_200)?;
    let mut memory = OwnedMemory::for_model(&parsed);
    let mut pipeline = memory.pipeline::<FixedStft>(parsed)?;
    for slot in walking_adult().iter() {
        pipeline.push(slot, &mut ())?;
    }
    let answer = pipeline.classify(&mut ()).ok_or("the recording is shorter than the model's")?;
    Ok(parsed.class_name(usize::from(answer.class)).to_owned())
}

fn station(command: &[String]) -> Result<bool> {
    let text = serial::lines(command)?;
    print!("{text}");
    let class = expected()?;
    let periods: Vec<&str> = text.lines().filter(|line| line.starts_with("period ")).collect();
    let right = periods.iter().filter(|line| line.ends_with(&format!(": {class}"))).count();
    let counts = text.lines().find_map(|line| line.strip_prefix("slots ")).ok_or("no counts were printed")?;
    let numbers: Vec<u64> =
        counts.split(|c: char| !c.is_ascii_digit()).filter_map(|word| word.parse().ok()).collect();
    let [slots, late, faults, recognitions] = numbers[..] else {
        return Err(format!("{counts:?} are not four counts").into());
    };
    println!("{right} of {} recognitions are this machine's, {class}", periods.len());
    let whole = slots / 4000;
    Ok(slots >= PLAYED && late == 0 && faults == 0 && recognitions >= whole && right as u64 == recognitions)
}

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let done =
        match &arguments[..] {
            [what, file] if what == "recording" => std::fs::write(file, walking_adult().to_le_bytes())
                .map(|()| true)
                .map_err(|e| format!("{file}: {e}").into()),
            [what, file, most, command @ ..] if what == "conformance" => conformance(file, most, command),
            [what, command @ ..] if what == "station" => station(command),
            _ => Err("usage: board recording FILE | conformance SUITE BYTES COMMAND... | station COMMAND..."
                .into()),
        };
    match done {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => ExitCode::from(1),
        Err(error) => {
            eprintln!("board: {error}");
            ExitCode::from(2)
        }
    }
}
