//! Calls in a RISC-V program without relocations.

use super::Result;
use object::{Object, ObjectSection, ObjectSymbol, SectionKind, SymbolKind};

const AUIPC: u32 = 0x17;
const JALR: u32 = 0x67;
const JAL: u32 = 0x6f;

/// The address that a jump goes to, if it is relative to the program counter. `upper` are the registers' values by `auipc`.
fn destination(at: u32, word: u32, upper: &mut [u32; 32]) -> Option<u32> {
    let (rd, rs1) = ((word >> 7 & 31) as usize, (word >> 15 & 31) as usize);
    match word & 0x7f {
        AUIPC => {
            upper[rd] = at.wrapping_add(word & 0xffff_f000);
            None
        }
        JALR => Some(upper[rs1].wrapping_add((word.cast_signed() >> 20).cast_unsigned())),
        JAL => {
            let sign = (word.cast_signed() >> 11).cast_unsigned() & 0xfff0_0000;
            let offset = sign | word & 0xf_f000 | word >> 9 & 0x800 | word >> 20 & 0x7fe;
            Some(at.wrapping_add(offset))
        }
        _ => None,
    }
}

/// Names of the functions that jump to `target`. Jumps of 16 bits are left out: the compiler has them within a function only, and
/// the linker makes none while the target's features do not allow it.
pub fn callers(file: &object::File, target: u64) -> Result<Vec<String>> {
    let mut found = Vec::new();
    for function in file.symbols().filter(|s| s.kind() == SymbolKind::Text && s.size() > 0) {
        let section = file.section_by_index(function.section_index().ok_or("a function in no section")?)?;
        if section.kind() != SectionKind::Text {
            continue;
        }
        let Some(code) = section.data_range(function.address(), function.size())? else { continue };
        let (mut offset, mut upper) = (0, [0; 32]);
        while let Some(bytes) = code.get(offset..offset + 2) {
            if bytes[0] & 3 != 3 {
                offset += 2;
                continue;
            }
            let Some(&word) = code[offset..].first_chunk() else { break };
            let at = function.address() as u32 + offset as u32;
            if destination(at, u32::from_le_bytes(word), &mut upper).map(u64::from) == Some(target) {
                found.push(function.name()?.to_owned());
                break;
            }
            offset += 4;
        }
    }
    Ok(found)
}
