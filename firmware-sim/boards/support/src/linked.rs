//! What the linker script says: the data in flash that is no part of the program, and how deep the stack has been.
#![allow(unsafe_code)]

unsafe extern "C" {
    static _flash_data_start: u8;
    static _flash_data_end: u8;
    static _stack_start: u32;
    static _stack_end: u32;
}

/// What the stack is painted with, as by `cortex-m-rt`.
const PAINT: u32 = 0xCCCC_CCCC;
/// Words at the end of the stack that a start-up may guard: they are not painted.
const GUARDED: usize = 16;
/// Words below the painter's frame that it does not paint, for its calls.
const MARGIN: usize = 64;

/// The part of flash that a recording or a suite is written to.
pub fn data() -> &'static [u8] {
    let (start, end) = (&raw const _flash_data_start, &raw const _flash_data_end);
    // SAFETY: `memory.x` gives this part of flash to nothing else. It is readable, any bytes are values, and no program writes it.
    unsafe { core::slice::from_raw_parts(start, end as usize - start as usize) }
}

/// Paints the free stack, where start-up does not. To be called before anything that is to be counted.
#[inline(never)]
pub fn paint_stack() {
    let here = 0_u32;
    let end = (&raw const here).wrapping_sub(MARGIN);
    let mut word = (&raw const _stack_end).wrapping_add(GUARDED).cast_mut();
    while word.cast_const() < end {
        // SAFETY: the word lies between the stack's end and this function's frame: it is writable, and nothing uses it.
        unsafe { word.write_volatile(PAINT) };
        word = word.wrapping_add(1);
    }
}

/// Bytes of stack used since start-up or [`paint_stack`].
pub fn stack_used() -> usize {
    let (lowest, top) = ((&raw const _stack_end).wrapping_add(GUARDED), &raw const _stack_start as usize);
    let mut word = lowest;
    // SAFETY: both symbols bound the stack, which is readable memory.
    while (word as usize) < top && unsafe { word.read_volatile() } == PAINT {
        word = word.wrapping_add(1);
    }
    top - word as usize
}
