//! Instructions of a sensing slot and of a recognition against the slot's 250 us: what `tests/realtime` runs.

use sdp3::conformance::qemu::{Firmware, MACHINES, machines, run};
use std::path::Path;
use std::process::ExitCode;
use std::time::Duration;

type Result<T> = std::result::Result<T, Box<dyn std::error::Error>>;

/// Clocks in MHz: a Cortex-M4F, a faster one, a Cortex-M7.
const CLOCKS_MHZ: [f64; 3] = [168.0, 240.0, 480.0];
/// T_s in microseconds.
const SLOT_US: f64 = 250.0;
/// The cycle model: cycles of an instruction. See [`ASSUMPTIONS`].
const CYCLES_PER_INSTRUCTION: f64 = 1.4;

const ASSUMPTIONS: &str = "\
Instructions are counted under QEMU, exactly but for the timer's resolution. Cycles are NOT: they are instructions times 1.4, the
ratio a Cortex-M4F model (loads 2 cycles, 1 if pipelined; taken branches +2; vdiv, vsqrt 14; no wait states of the flash) gives
for an f32 FFT; it gives 1.2 to 1.3 for the int8 layers. Not checked on silicon. Caches, wait states and the DMA's share of the
bus come on top; a dual-issue Cortex-M7 needs fewer. A recording is N_s = 1000 slots of noise, the network C = 8, stride 2.";

/// Instructions of one slot's dechirp and Gram update, and of one recognition's other stages by name.
struct Counts {
    dechirp: f64,
    gram: f64,
    rest: Vec<(String, f64)>,
}

fn counts(firmware: &Firmware) -> Result<Counts> {
    let text = run(firmware, &[], Duration::from_secs(600))?;
    let lines: Vec<(&str, f64)> = text
        .lines()
        .filter_map(|line| line.trim().split_once(' '))
        .map(|(name, count)| Ok((name, count.parse()?)))
        .collect::<std::result::Result<_, std::num::ParseFloatError>>()?;
    let [("slots", slots), ("dechirp", dechirp), ("gram", gram), rest @ ..] = &lines[..] else {
        return Err(format!("{}: {text:?}", firmware.name).into());
    };
    if rest.len() != 4 || !text.trim_end().ends_with("done") {
        return Err(format!("{}: {text:?}", firmware.name).into());
    }
    let rest = rest.iter().map(|(name, count)| ((*name).to_owned(), *count)).collect();
    Ok(Counts { dechirp: dechirp / slots, gram: gram / slots, rest })
}

fn table(folder: &Path, wanted: &[&str]) -> Result<bool> {
    let mut good = true;
    println!("{ASSUMPTIONS}\n");
    println!(
        "{:<14}{:>34}{:>46}",
        "", "instructions of one sensing slot", "share of the slot's 250 us, by the cycle model"
    );
    print!("{:<14}{:>12}{:>10}{:>12}", "machine", "dechirp", "gram", "both");
    CLOCKS_MHZ.iter().for_each(|clock| print!("{:>12} MHz", clock));
    println!();
    let mut recognitions = Vec::new();
    for firmware in machines(folder, "realtime").into_iter().filter(|m| wanted.contains(&m.name)) {
        let c = counts(&firmware)?;
        let both = c.dechirp + c.gram;
        print!("{:<14}{:>12.0}{:>10.0}{both:>12.0}", firmware.name, c.dechirp, c.gram);
        for clock in CLOCKS_MHZ {
            let share = both * CYCLES_PER_INSTRUCTION / (clock * SLOT_US);
            good &= share < 1.0;
            print!("{:>14.1} %", 100.0 * share);
        }
        println!();
        recognitions.push((firmware.name, c.rest));
    }
    println!("\nThe rest, once a recording: instructions, and slots of 250 us by the cycle model");
    let names: Vec<&str> =
        recognitions.iter().flat_map(|(_, rest)| rest).map(|(name, _)| name.as_str()).take(4).collect();
    print!("{:<14}", "machine");
    names.iter().for_each(|name| print!("{name:>13}"));
    print!("{:>13}", "sum");
    CLOCKS_MHZ.iter().for_each(|clock| print!("{:>9} MHz", clock));
    println!();
    for (machine, rest) in &recognitions {
        let sum: f64 = rest.iter().map(|(_, count)| count).sum();
        print!("{machine:<14}");
        rest.iter().for_each(|(_, count)| print!("{count:>13.0}"));
        print!("{sum:>13.0}");
        for clock in CLOCKS_MHZ {
            print!("{:>13.0}", (sum * CYCLES_PER_INSTRUCTION / (clock * SLOT_US)).ceil());
        }
        println!();
    }
    Ok(good && recognitions.len() == wanted.len())
}

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let words: Vec<&str> = arguments.iter().map(String::as_str).collect();
    let done = match &words[..] {
        [folder] => table(Path::new(folder), &MACHINES),
        [folder, wanted @ ..] => table(Path::new(folder), wanted),
        _ => Err("usage: realtime FIRMWARE [MACHINE...]".into()),
    };
    match done {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => ExitCode::from(1),
        Err(error) => {
            eprintln!("realtime: {error}");
            ExitCode::from(2)
        }
    }
}
