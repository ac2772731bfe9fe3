//! A program for a board, read without running it: what is loaded where, the vector table, the space for the stack, panics.

use super::{Result, calls::callers, functions, sections};
use object::{Architecture, Object, ObjectSegment, ObjectSymbol};
use std::ops::Range;

/// Least bytes of RAM for the stack: the deepest painted one is below 35 KiB, of `conformance`.
const STACK: u64 = 36 * 1024;
/// Panics of drivers: their set-up checks its arguments. What an index or a slice of the signal chain could bring is not among them.
const OF_DRIVERS: [&str; 8] = [
    "9panic_fmt",
    "9panicking5panic",
    "panic_const",
    "unwrap_failed",
    "expect_failed",
    "panic_nounwind",
    "assert_failed",
    "rust_begin_unwind",
];

/// Functions of drivers, and of the formatting of their messages, that index with a check; for RISC-V, where calls are read.
const INDEXING: [&str; 5] =
    ["7esp_hal", "$LT$esp_hal..", "handle_interrupts", "__mktime", "escape_debug_ext"];

/// `ADDRESS+LENGTH`, the address hexadecimal, the length in KiB.
fn memory(text: &str) -> Result<Range<u64>> {
    let parts = text.split_once('+').and_then(|(at, kib)| {
        Some((u64::from_str_radix(at.strip_prefix("0x")?, 16).ok()?, kib.parse::<u64>().ok()?))
    });
    let (at, kib) = parts.ok_or_else(|| format!("{text}: not ADDRESS+KIB"))?;
    Ok(at..at + 1024 * kib)
}

/// The words at a virtual address.
fn words<const N: usize>(file: &object::File, at: u64) -> Result<[u32; N]> {
    for segment in file.segments() {
        if let Ok(Some(bytes)) = segment.data_range(at, 4 * N as u64) {
            let word = |k: usize| u32::from_le_bytes([0, 1, 2, 3].map(|byte| bytes[4 * k + byte]));
            return Ok(std::array::from_fn(word));
        }
    }
    Err(format!("nothing is loaded at {at:#x}").into())
}

/// Prints a line of the table; false if anything is not as it must be.
pub fn check(name: &str, path: &str, flash: &str, ram: &str) -> Result<bool> {
    let flash = flash.split(',').map(memory).collect::<Result<Vec<_>>>()?;
    let ram = memory(ram)?;
    let bytes = std::fs::read(path).map_err(|error| format!("{path}: {error}"))?;
    let file = object::File::parse(&*bytes)?;
    let symbol = |name: &str| file.symbols().find(|s| s.name() == Ok(name)).map(|s| s.address());
    let mut wrong = Vec::new();

    let mut loaded = 0;
    for segment in object::read::elf::ElfFile32::<object::Endianness>::parse(&*bytes)?.elf_program_headers() {
        use object::read::elf::ProgramHeader;
        let endian = object::Endianness::Little;
        let (kind, at, size) = (segment.p_type(endian), segment.p_paddr(endian), segment.p_filesz(endian));
        if kind != object::elf::PT_LOAD || size == 0 {
            continue;
        }
        loaded += u64::from(size);
        let (at, end) = (u64::from(at), u64::from(at) + u64::from(size));
        if !flash.iter().any(|range| range.contains(&at) && end <= range.end) {
            wrong.push(format!("{at:#x}..{end:#x} is loaded outside flash"));
        }
    }
    let entry = file.entry() & !1;
    if !flash.iter().any(|range| range.contains(&entry)) {
        wrong.push(format!("entry at {entry:#x}, outside flash"));
    }
    if file.architecture() == Architecture::Arm {
        let table = symbol("__vector_table").ok_or("no vector table")?;
        let [stack, reset] = words::<2>(&file, table)?.map(u64::from);
        if !(ram.start < stack && stack <= ram.end && stack % 8 == 0) {
            wrong.push(format!("the stack begins at {stack:#x}, not at the end of RAM or below"));
        }
        if reset != entry | 1 {
            wrong.push(format!("the reset vector is {reset:#x}, the entry {entry:#x}"));
        }
    }
    let (_, statics) = sections(&bytes)?;
    let mut free = (ram.end - ram.start).saturating_sub(statics);
    // less where code lies in RAM, too
    if let (Some(top), Some(end)) = (symbol("_stack_start"), symbol("_stack_end")) {
        free = free.min(top.saturating_sub(end));
        if !(ram.contains(&end) && top <= ram.end) {
            wrong.push(format!("the stack is {end:#x}..{top:#x}, outside RAM"));
        }
    }
    let statics = ram.end - ram.start - free;
    if free < STACK {
        wrong.push(format!("{free} bytes are left for the stack, of {STACK}"));
    }
    let (count, bad) = functions(&bytes)?;
    let (drivers, ours): (Vec<_>, Vec<_>) =
        bad.iter().partition(|name| OF_DRIVERS.iter().any(|part| name.contains(part)));
    for name in ours {
        let calls = match (file.architecture(), symbol(name)) {
            (Architecture::Riscv32, Some(at)) => callers(&file, at)?,
            _ => Vec::new(),
        };
        let of_driver = |caller: &String| INDEXING.iter().any(|part| caller.contains(part));
        if calls.is_empty() || !calls.iter().all(of_driver) {
            wrong.push(format!("panics or allocates: {name} {}", calls.join(" ")));
        }
    }
    if count < 10 {
        wrong.push("no symbols".into());
    }
    println!(
        "{name:<28}{loaded:>10}{statics:>10}{free:>10}{:>8}  {}",
        drivers.len(),
        if wrong.is_empty() { "good" } else { "WRONG" }
    );
    wrong.iter().for_each(|what| println!("  {what}"));
    Ok(wrong.is_empty())
}
