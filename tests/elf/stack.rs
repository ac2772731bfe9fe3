//! Worst-case stack of a linked program, from the frame of every function and the calls between them.
//!
//! Needs a program built with `-Zemit-stack-sizes -Clink-arg=--emit-relocs`. Functions of the compiler's own library were
//! built without: they are leaves of soft arithmetic and memory moves, and each counts with [`UNKNOWN`] bytes.

use object::{Object, ObjectSection, ObjectSymbol, RelocationTarget, SectionKind, SymbolKind};
use std::collections::{BTreeMap, HashMap};

/// Bytes a function without a known frame is taken to need.
const UNKNOWN: u64 = 128;

/// What was found.
#[derive(Debug)]
pub struct WorstCase {
    /// Bytes from start-up's call to the deepest one.
    pub bytes: u64,
    /// Bytes of the timer's interrupt handler and what it calls, without what the processor pushes.
    pub interrupt: u64,
    /// Functions with unknown frames.
    pub unknown: usize,
}

/// A function: where it ends, its name, its frame if known, and what it calls.
struct Function {
    end: u64,
    name: String,
    frame: Option<u64>,
    calls: Vec<u64>,
}

/// Reads `.stack_sizes`: address and ULEB128 size, one after the other.
fn frames(mut bytes: &[u8], pointer: usize) -> BTreeMap<u64, u64> {
    let mut found = BTreeMap::new();
    while bytes.len() > pointer {
        let (address, rest) = bytes.split_at(pointer);
        let address = address.iter().rev().fold(0_u64, |value, &byte| value << 8 | u64::from(byte));
        let length = rest.iter().position(|byte| byte & 0x80 == 0).map_or(rest.len(), |last| last + 1);
        let size =
            rest[..length].iter().rev().fold(0_u64, |value, &byte| value << 7 | u64::from(byte & 0x7f));
        found.insert(address & !1, size);
        bytes = &rest[length..];
    }
    found
}

/// Bytes below `at`, memoised; a cycle is an error, for it has no bound.
fn depth(
    at: u64,
    functions: &BTreeMap<u64, Function>,
    known: &mut HashMap<u64, Option<u64>>,
) -> Result<u64, String> {
    let Some(function) = functions.get(&at) else { return Ok(0) };
    match known.get(&at) {
        Some(Some(bytes)) => return Ok(*bytes),
        Some(None) => return Err(format!("{} calls itself: no bound", function.name)),
        None => known.insert(at, None),
    };
    let mut below = 0;
    for &call in &function.calls {
        below = below.max(depth(call, functions, known)?);
    }
    let bytes = below + function.frame.unwrap_or(UNKNOWN);
    known.insert(at, Some(bytes));
    Ok(bytes)
}

/// The worst case of a program.
///
/// # Errors
///
/// A program without the sections named above, or one that calls in a circle.
pub fn worst_case(elf: &[u8]) -> Result<WorstCase, Box<dyn std::error::Error>> {
    let file = object::File::parse(elf)?;
    let pointer = if file.is_64() { 8 } else { 4 };
    let sizes = file.section_by_name(".stack_sizes").ok_or("no .stack_sizes in the program")?;
    let frames = frames(sizes.data()?, pointer);
    let mut functions = BTreeMap::new();
    for symbol in file.symbols().filter(|symbol| symbol.kind() == SymbolKind::Text && symbol.size() > 0) {
        let begin = symbol.address() & !1;
        let name = symbol.name().unwrap_or_default().to_owned();
        let frame = frames.get(&begin).copied();
        functions.insert(begin, Function { end: begin + symbol.size(), name, frame, calls: Vec::new() });
    }
    let mut relocated = 0;
    for section in file.sections().filter(|section| section.kind() == SectionKind::Text) {
        for (at, relocation) in section.relocations() {
            let RelocationTarget::Symbol(index) = relocation.target() else { continue };
            let target = file.symbol_by_index(index)?.address() & !1;
            relocated += 1;
            if !functions.contains_key(&target) {
                continue;
            }
            // a jump within a function is no call
            let caller = functions.range_mut(..=at).next_back().map(|(begin, function)| (*begin, function));
            if let Some((begin, function)) = caller.filter(|(begin, f)| at < f.end && *begin != target) {
                debug_assert!(begin <= at);
                function.calls.push(target);
            }
        }
    }
    if relocated == 0 {
        return Err("the program was linked without --emit-relocs".into());
    }
    let mut known = HashMap::new();
    let mut of = |name: &str| -> Result<u64, String> {
        let begin = functions.iter().find(|(_, function)| function.name == name).map(|(begin, _)| *begin);
        depth(begin.ok_or_else(|| format!("no function {name}"))?, &functions, &mut known)
    };
    let handler = ["firmware_systick", "firmware_trap", "firmware_interrupt"]
        .into_iter()
        .find(|name| functions.values().any(|function| function.name == *name))
        .ok_or("no interrupt handler")?;
    let (bytes, interrupt) = (of("firmware_main")?, of(handler)?);
    let unknown =
        known.keys().filter(|begin| functions.get(begin).is_some_and(|f| f.frame.is_none())).count();
    Ok(WorstCase { bytes, interrupt, unknown })
}
