//! Runs the firmware `realtime` at every machine's clock, prints what it measured, and finds the lowest clock: what
//! `tests/realtime` runs.

use std::collections::HashMap;
use std::path::Path;
use std::process::{Command, ExitCode};
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

type Result<T> = std::result::Result<T, Box<dyn std::error::Error + Send + Sync>>;

/// The machines, their clocks and cycles of an instruction.
const TABLE: &str = include_str!("../firmware-sim/machines");
/// T_s in microseconds.
const SLOT_US: f64 = 250.0;
/// Slots of a run, and of one that looks for the lowest clock: four periods and what follows the last.
const SLOTS: u32 = 100_000;
const STEADY: u32 = 17_000;
const SEED: u32 = 1;
/// Seconds after which a run is given up.
const PATIENCE: &str = "900";
/// Most instructions of all calls to the slot context in a slot, and of one step of processing.
const SLOT_CONTEXT: u64 = 2500;
const POLL: u64 = 48_000;
const LIMITED: [&str; 4] = ["cortex-m4f", "cortex-m7", "cortex-m33", "cortex-m55"];

struct Machine {
    name: &'static str,
    clock: f64,
    cycles: f64,
}

impl Machine {
    fn all() -> Result<Vec<Machine>> {
        let rows = TABLE.lines().filter(|line| !line.starts_with('#') && !line.contains("| - "));
        rows.map(|row| match row.split('|').map(str::trim).collect::<Vec<_>>()[..] {
            [name, _, _, _, _, clock, cycles, _] => {
                Ok(Machine { name, clock: clock.parse()?, cycles: cycles.parse()? })
            }
            _ => Err(format!("firmware-sim/machines: {row}").into()),
        })
        .collect()
    }

    /// Instructions of a slot at a clock in MHz.
    fn slot(&self, clock: f64) -> u32 {
        (SLOT_US * clock / self.cycles) as u32
    }
}

/// What a run printed.
struct Run {
    good: bool,
    text: String,
    counts: HashMap<String, u64>,
}

impl Run {
    fn new(folder: &Path, machine: &Machine, clock: f64, slots: u32, faults: u32) -> Result<Self> {
        let folder = folder.join(machine.name);
        let emulator = std::fs::read_to_string(folder.join("emulator"))?;
        let slot = machine.slot(clock);
        let arguments =
            format!("arg=slots={slots},arg=slot={slot},arg=seed={SEED},arg=exits=2,arg=faults={faults}");
        let output = Command::new("timeout")
            .arg(PATIENCE)
            .args(emulator.split_ascii_whitespace())
            .args(["-nographic", "-monitor", "none", "-serial", "none", "-semihosting-config"])
            .arg(format!("enable=on,target=native,{arguments}"))
            .arg("-kernel")
            .arg(folder.join("realtime"))
            .output()?;
        // semihosting text comes on stderr or stdout, by machine
        let text = String::from_utf8_lossy(&[output.stdout, output.stderr].concat()).into_owned();
        let counts: HashMap<_, _> = text
            .lines()
            .filter_map(|line| line.trim().split_once(' '))
            .filter_map(|(name, count)| Some((name.to_owned(), count.parse().ok()?)))
            .collect();
        if !matches!(output.status.code(), Some(0 | 1)) || counts.get("slots") != Some(&u64::from(slots)) {
            return Err(format!("{} at {clock} MHz: {}\n{text}", machine.name, output.status).into());
        }
        Ok(Run { good: output.status.success(), text, counts })
    }

    fn count(&self, name: &str) -> u64 {
        self.counts.get(name).copied().unwrap_or(u64::MAX)
    }
}

/// Whether every period but the last is recognised by both exits, and nothing is late or lost.
fn keeps_up(folder: &Path, machine: &Machine, clock: f64) -> Result<bool> {
    let run = Run::new(folder, machine, clock, STEADY, 0)?;
    let over = run.count("periods") - 1;
    Ok(run.good && run.count("first-exit") >= over && run.count("last-exit") >= over)
}

/// The lowest whole number of MHz at which nothing is late or lost.
fn lowest_clock(folder: &Path, machine: &Machine) -> Result<u32> {
    let (mut below, mut enough) = (0, machine.clock as u32);
    if !keeps_up(folder, machine, enough.into())? {
        return Err(format!("{}: {enough} MHz are not enough", machine.name).into());
    }
    while enough - below > 1 {
        let clock = below.midpoint(enough);
        if keeps_up(folder, machine, clock.into())? { enough = clock } else { below = clock }
    }
    Ok(enough)
}

/// A row of the table, and what is wrong in it.
fn row(folder: &Path, machine: &Machine, short: bool) -> Result<(String, Vec<String>)> {
    let run = Run::new(folder, machine, machine.clock, SLOTS, 1)?;
    let lowest = if short { "-".to_owned() } else { lowest_clock(folder, machine)?.to_string() };
    let [late, lost, wrong, missed] =
        ["late", "lost", "wrong-faults", "missed-faults"].map(|name| run.count(name));
    let [context, poll] = ["slot-context", "poll"].map(|name| run.count(name));
    let [first, last] = ["first-exit", "last-exit"].map(|name| run.count(name));
    let text = format!(
        "{:<13}{:>6}{:>9}{context:>9}{poll:>8}{late:>6}{lost:>6}{:>8}{wrong:>7}{missed:>7}{first:>7}{last:>6}{:>8}{lowest:>8}",
        machine.name,
        machine.clock,
        machine.slot(machine.clock),
        run.count("reported-faults"),
        run.count("stack"),
    );
    let mut bad = Vec::new();
    let mut must = |good: bool, what: &str| {
        if !good {
            bad.push(format!("{}: {what}", machine.name));
        }
    };
    must(late == 0, "slots were late");
    must(lost == 0, "sensing slots were lost");
    must(wrong == 0, "faults were reported that were not injected");
    must(missed == 0, "injected faults were not reported");
    must(run.good, "the program found a violation");
    must(first > 0 && last > 0, "an exit classified nothing");
    must(machine.name != "cortex-m4f" || context <= SLOT_CONTEXT, "the slot context takes too long");
    must(!LIMITED.contains(&machine.name) || poll <= POLL, "a step of processing takes too long");
    let kinds = run.counts.iter().filter(|(name, _)| name.starts_with("injected-"));
    kinds.filter(|(_, count)| **count == 0).for_each(|(name, _)| must(false, &format!("{name}: never")));
    if !bad.is_empty() {
        bad.push(run.text);
    }
    Ok((text, bad))
}

fn table(folder: &Path, short: bool, wanted: &[&str]) -> Result<bool> {
    let machines: Vec<Machine> = Machine::all()?
        .into_iter()
        .filter(|machine| wanted.is_empty() || wanted.contains(&machine.name))
        .collect();
    println!(
        "{SLOTS} slots of {SLOT_US} us each, two early exits, churn and injected faults. Instructions are counted under QEMU; cycles are \
         NOT: they are\ninstructions times a stated factor. 'MHz' is the stated clock, 'lowest' the least at which four periods \
         have nothing late or lost.\n"
    );
    println!(
        "{:<13}{:>6}{:>9}{:>9}{:>8}{:>6}{:>6}{:>8}{:>7}{:>7}{:>7}{:>6}{:>8}{:>8}",
        "",
        "",
        "instr.",
        "worst",
        "worst",
        "slots",
        "slots",
        "faults",
        "false",
        "missed",
        "first",
        "last",
        "stack",
        "lowest"
    );
    println!(
        "{:<13}{:>6}{:>9}{:>9}{:>8}{:>6}{:>6}{:>8}{:>7}{:>7}{:>7}{:>6}{:>8}{:>8}",
        "machine",
        "MHz",
        "a slot",
        "context",
        "poll",
        "late",
        "lost",
        "found",
        "faults",
        "faults",
        "exit",
        "exit",
        "bytes",
        "MHz"
    );
    // as many at a time as there are processors
    let next = AtomicUsize::new(0);
    let rows = Mutex::new(HashMap::new());
    let workers = std::thread::available_parallelism().map_or(1, usize::from);
    std::thread::scope(|scope| {
        for _ in 0..workers {
            scope.spawn(|| {
                loop {
                    let at = next.fetch_add(1, Ordering::Relaxed);
                    let Some(machine) = machines.get(at) else { return };
                    let row = row(folder, machine, short);
                    let Ok(mut rows) = rows.lock() else { return };
                    rows.insert(at, row);
                }
            });
        }
    });
    let mut rows = rows.into_inner()?;
    let mut bad = Vec::new();
    for (at, machine) in machines.iter().enumerate() {
        match rows.remove(&at) {
            Some(Ok((text, found))) => {
                println!("{text}");
                bad.extend(found);
            }
            Some(Err(error)) => bad.push(error.to_string()),
            None => bad.push(format!("{}: did not run", machine.name)),
        }
    }
    bad.iter().for_each(|what| println!("\n{what}"));
    Ok(bad.is_empty() && !machines.is_empty() && wanted.len() <= machines.len())
}

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let words: Vec<&str> = arguments.iter().map(String::as_str).collect();
    let done = match &words[..] {
        [folder, "--short", wanted @ ..] => table(Path::new(folder), true, wanted),
        [folder, wanted @ ..] => table(Path::new(folder), false, wanted),
        [] => Err("usage: realtime FIRMWARE [--short] [MACHINE...]".into()),
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
