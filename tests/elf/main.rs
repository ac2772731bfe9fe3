//! What lies in the firmware's programs: what `tests/footprint` and `tests/no-panic` run.
//!
//! `elf footprint FIRMWARE` prints flash, RAM and stack of every configuration on every machine and holds the limits;
//! `elf stack FIRMWARE` prints the worst-case stack found without running them, of programs with reported frames;
//! `elf no-panic FIRMWARE` looks for panics and an allocator in them;
//! `elf board NAME FILE FLASH RAM` checks a program for a board with memories given as `ADDRESS+LENGTH`, several with commas.

mod board;
mod calls;
mod stack;

use object::{Object, ObjectSection, ObjectSymbol, SectionFlags, SymbolKind};
use sdp3::conformance::qemu::{MACHINES, machines, run};
use sdp3::scenario::Class;
use sdp3::simulator::calibration::stored_rho;
use sdp3::simulator::dataset::{Set, recording};
use sdp3_core::{dsn::Shape, radar_memory};
use sdp3_testkit::models::{DSN_200, DSN_1000};
use std::path::Path;
use std::process::ExitCode;
use std::time::Duration;

type Result<T> = std::result::Result<T, Box<dyn std::error::Error>>;

/// The default model's sizes.
const DEFAULT: Shape = Shape::of(DSN_1000).expect("a model");

/// A configuration of the station and what it may take.
struct Configuration {
    program: &'static str,
    words: &'static str,
    slots: u32,
    ram_limit: u64,
    flash_limit: u64,
}

const CONFIGURATIONS: [Configuration; 4] = [
    Configuration {
        program: "station",
        words: "default: N_s = 1000, C = 16, supervision",
        slots: 1000,
        ram_limit: 128 * 1024,
        flash_limit: 256 * 1024,
    },
    Configuration {
        program: "station-early-exit",
        words: "default with a second network at N_s = 200",
        slots: 1000,
        ram_limit: 128 * 1024,
        flash_limit: 256 * 1024,
    },
    Configuration {
        program: "station-small",
        words: "small: N_s = 200, C = 8",
        slots: 200,
        ram_limit: 56 * 1024,
        flash_limit: 256 * 1024,
    },
    Configuration {
        program: "station-signed",
        words: "small, signed models only",
        slots: 200,
        ram_limit: 56 * 1024,
        flash_limit: 256 * 1024,
    },
];

/// Bytes of code and constants, and of statics.
fn sections(elf: &[u8]) -> Result<(u64, u64)> {
    let file = object::File::parse(elf)?;
    let (mut flash, mut ram) = (0, 0);
    for section in file.sections() {
        let SectionFlags::Elf { sh_flags } = section.flags() else { continue };
        if sh_flags & u64::from(object::elf::SHF_ALLOC) == 0 {
            continue;
        }
        match section.name()? {
            ".bss" | ".uninit" => ram += section.size(),
            // initial values lie in flash and are copied to RAM
            ".data" => (flash, ram) = (flash + section.size(), ram + section.size()),
            _ => flash += section.size(),
        }
    }
    Ok((flash, ram))
}

/// Runs the station on its recording in `recordings` and returns the stack it painted over; everything else it says must be good.
fn painted_stack(
    folder: &Path,
    machine: &str,
    configuration: &Configuration,
    recordings: &Path,
) -> Result<u64> {
    let programs = machines(folder, configuration.program);
    let program = programs.iter().find(|p| p.name == machine).ok_or("no such machine")?;
    let text = run(program, recordings, &[configuration.program.to_owned()], Duration::from_secs(600))?;
    let word = |name: &str| {
        let line = text.lines().find_map(|line| line.trim().strip_prefix(name));
        line.ok_or_else(|| format!("{machine}, {}: no {name:?} in {text:?}", configuration.program))
    };
    word("done")?;
    word("recognised ")?;
    if word("faults ")? != "0" {
        return Err(format!("{machine}, {}: faults were reported: {text:?}", configuration.program).into());
    }
    Ok(word("stack ")?.parse()?)
}

fn footprint(folder: &Path, wanted: &[&str]) -> Result<bool> {
    let scenario = sdp3_tests::printed_room();
    let rho = stored_rho(&scenario).0;
    let temporary = tempfile::tempdir()?;
    let mut good = true;
    for configuration in &CONFIGURATIONS {
        let slots =
            recording(&scenario, rho, 5, Set::Demo, Class::AdultWalking, 0, configuration.slots).slots;
        std::fs::write(temporary.path().join(configuration.program), slots.to_le_bytes())?;
        println!(
            "{} ({}); at most {} KiB RAM, {} KiB flash",
            configuration.words,
            configuration.program,
            configuration.ram_limit / 1024,
            configuration.flash_limit / 1024
        );
        println!("  {:<14}{:>10}{:>12}{:>12}{:>12}", "machine", "flash", "statics", "stack", "RAM");
        for machine in wanted {
            let elf = std::fs::read(folder.join(machine).join(configuration.program))?;
            let (flash, statics) = sections(&elf)?;
            let stack = painted_stack(folder, machine, configuration, temporary.path())?;
            let fits = flash <= configuration.flash_limit && statics + stack <= configuration.ram_limit;
            // the limits are a microcontroller's, with 32 bits
            let wide = machine.starts_with("cortex-a");
            good &= fits || wide;
            let verdict = match (fits, wide) {
                (true, _) => "",
                (false, true) => "  (64 bits: no limit)",
                (false, false) => "  OVER",
            };
            println!("  {machine:<14}{flash:>10}{statics:>12}{stack:>12}{:>12}{verdict}", statics + stack);
        }
    }
    for (words, model) in [("default", DSN_1000), ("small", DSN_200)] {
        let shape = Shape::of(model).ok_or("no model")?;
        println!(
            "const sizes, {words}: pipeline {}, its scratch {}",
            shape.required_bytes(),
            shape.scratch_bytes()
        );
    }
    println!("const size, default: RadarMemory::BYTES = {}", <radar_memory!(DEFAULT)>::BYTES);
    Ok(good)
}

fn static_stack(folder: &Path, wanted: &[&str]) -> Result<bool> {
    println!(
        "worst-case stack without running: {:<14}{:>10}{:>12}{:>24}",
        "machine", "main", "interrupt", "frames not known"
    );
    for machine in wanted {
        for configuration in &CONFIGURATIONS {
            let elf = std::fs::read(folder.join(machine).join(configuration.program))?;
            let worst = stack::worst_case(&elf)
                .map_err(|error| format!("{machine}, {}: {error}", configuration.program))?;
            println!(
                "  {:<32}{machine:<14}{:>10}{:>12}{:>24}",
                configuration.program, worst.bytes, worst.interrupt, worst.unknown
            );
        }
    }
    Ok(true)
}

/// Parts of the names of symbols that only a panic, or only an allocator, brings into a program.
const FORBIDDEN: [&str; 12] = [
    "panicking",
    "panic_fmt",
    "panic_bounds",
    "rust_begin_unwind",
    "unwrap_failed",
    "expect_failed",
    "slice_index",
    "copy_from_slice",
    "rust_alloc",
    "rust_dealloc",
    "alloc..",
    "malloc",
];

/// Functions of a program, and those with a forbidden name.
fn functions(elf: &[u8]) -> Result<(usize, Vec<String>)> {
    let file = object::File::parse(elf)?;
    let names: Vec<String> = file
        .symbols()
        .filter(|symbol| symbol.kind() == SymbolKind::Text && symbol.size() > 0)
        .filter_map(|symbol| symbol.name().ok().map(str::to_owned))
        .collect();
    let bad = names.iter().filter(|name| FORBIDDEN.iter().any(|part| name.contains(part))).cloned().collect();
    Ok((names.len(), bad))
}

fn no_panic(folder: &Path, wanted: &[&str]) -> Result<bool> {
    let mut good = true;
    println!("{:<14}{:<18}{:>10}  panics and allocators", "machine", "program", "functions");
    for machine in wanted {
        for program in CONFIGURATIONS.map(|c| c.program).into_iter().chain([
            "conformance",
            "scheduler",
            "soak",
            "faults",
            "graph",
        ]) {
            let (count, bad) = functions(&std::fs::read(folder.join(machine).join(program))?)?;
            // a stripped program would show nothing, good or bad
            good &= count >= 10;
            let verdict = match (bad.is_empty(), program) {
                (true, _) => "none".to_owned(),
                // elliptic curves are another crate's: what it brings is shown, and is not the chain's
                (false, "station-signed") => {
                    format!("not counted, of the signature's crate: {}", bad.join(", "))
                }
                (false, _) => {
                    good = false;
                    bad.join(", ")
                }
            };
            println!("{machine:<14}{program:<18}{count:>10}  {verdict}");
        }
        // the control: the signature's crate checks its indices
        let (_, bad) = functions(&std::fs::read(folder.join(machine).join("station-signed"))?)?;
        if bad.is_empty() {
            good = false;
            println!("{machine:<14}station-signed: no panic found, though it has some: the check is blind");
        }
    }
    Ok(good)
}

/// The machines asked for; all of them if none was.
fn or_all<'a>(wanted: &[&'a str]) -> Vec<&'a str> {
    if wanted.is_empty() { MACHINES.to_vec() } else { wanted.to_vec() }
}

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let words: Vec<&str> = arguments.iter().map(String::as_str).collect();
    let done =
        match &words[..] {
            ["footprint", folder, wanted @ ..] => footprint(Path::new(folder), &or_all(wanted)),
            ["stack", folder, wanted @ ..] => static_stack(Path::new(folder), &or_all(wanted)),
            ["no-panic", folder, wanted @ ..] => no_panic(Path::new(folder), &or_all(wanted)),
            ["board", name, file, flash, ram] => board::check(name, file, flash, ram),
            _ => Err("usage: elf footprint|stack|no-panic FIRMWARE [MACHINE...] | board NAME FILE FLASH RAM"
                .into()),
        };
    match done {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => ExitCode::from(1),
        Err(error) => {
            eprintln!("elf: {error}");
            ExitCode::from(2)
        }
    }
}
