//! Start-up, semihosting call, timer, instruction counter, stack paint and single-owner statics: all the unsafe code.
//!
//! Each unsafe block says why it is sound. QEMU loads the ELF's segments and starts with zeroed memory, so nothing is
//! copied or cleared. A processor family has one file of its own.
#![allow(unsafe_code)]

#[cfg_attr(target_arch = "arm", path = "cortex_m.rs")]
#[cfg_attr(target_arch = "riscv32", path = "riscv.rs")]
#[cfg_attr(target_arch = "aarch64", path = "aarch64.rs")]
mod family;

use core::cell::UnsafeCell;
use core::sync::atomic::{AtomicBool, Ordering};
use family::trap;
pub use family::{start_ticks, wait};

unsafe extern "C" {
    static mut _bss_end: u32;
    static mut _stack_top: u32;
    /// The program's share of a timer interrupt; nothing where it has none (`memory/sections.ld`).
    fn firmware_tick();
}

#[unsafe(no_mangle)]
extern "C" fn firmware_no_tick() {}

/// Called by every timer interrupt.
fn tick() {
    // SAFETY: the program's handler, or the one above.
    unsafe { firmware_tick() };
}

/// Picoseconds of a tick of the timer that counts instructions: see `machines`.
#[cfg(target_arch = "arm")]
const TICK_PS: u64 = picoseconds(env!("SDP3_TICK_PS"));

#[cfg(target_arch = "arm")]
const fn picoseconds(text: &str) -> u64 {
    match u64::from_str_radix(text, 10) {
        Ok(number) => number,
        Err(_) => panic!("SDP3_TICK_PS is no number"),
    }
}

/// Semihosting call; the result of the emulator.
pub(crate) fn call(operation: usize, block: &[usize; 4]) -> isize {
    // SAFETY: the emulator reads the four words of the block, which outlive the call, and writes only to the buffers whose
    // addresses `semihosting` put there from live exclusive slices.
    unsafe { trap(operation, block.as_ptr() as usize) }
}

/// Prints zero-terminated text.
pub(crate) fn write0(text: &[u8; 128]) {
    // SAFETY: SYS_WRITE0 reads up to the zero that ends the text; `semihosting::print` leaves the last byte zero.
    unsafe { trap(0x04, text.as_ptr() as usize) };
}

/// Starts the counter behind [`instructions`]; not together with [`start_ticks`].
pub fn start_counter() {
    family::start_counter();
}

/// Instructions executed since [`start_counter`], 64 bits, under the `-icount` of `machines`.
///
/// Cortex-M: SysTick at 25 MHz has a resolution of 0.6 instructions (20 MHz: 0.8; 32 MHz: 0.5); its turns are counted
/// by an interrupt of some twenty instructions every 2^24 ticks. RISC-V and AArch64: exact.
pub fn instructions() -> u64 {
    family::instructions()
}

const PAINT: u32 = 0xACED_C0DE;

/// Fills the free memory below the stack with a pattern.
#[inline(never)]
pub fn paint_stack() {
    let here = 0_u32;
    let bottom = &raw mut _bss_end;
    // a kilobyte below this frame is left alone
    let top = (&raw const here as usize).saturating_sub(1024);
    let words = top.saturating_sub(bottom as usize) / 4;
    for k in 0..words {
        // SAFETY: between the end of the statics and the stack nothing lives.
        unsafe { bottom.add(k).write_volatile(PAINT) };
    }
}

/// Bytes of stack used since [`paint_stack`].
pub fn stack_used() -> usize {
    let (bottom, top) = (&raw const _bss_end, &raw const _stack_top as usize);
    let mut k = 0;
    // SAFETY: reads memory between the statics and the stack's top.
    while unsafe { bottom.add(k).read_volatile() } == PAINT {
        k += 1;
    }
    top - (bottom as usize + 4 * k)
}

/// A static with one owner.
pub struct Single<T> {
    value: UnsafeCell<T>,
    taken: AtomicBool,
}

// SAFETY: `take` hands the value out once.
unsafe impl<T> Sync for Single<T> {}

impl<T> Single<T> {
    /// A static value.
    pub const fn new(value: T) -> Self {
        Single { value: UnsafeCell::new(value), taken: AtomicBool::new(false) }
    }

    /// The value, the first time.
    pub fn take(&'static self) -> Option<&'static mut T> {
        if self.taken.swap(true, Ordering::AcqRel) {
            return None;
        }
        // SAFETY: the flag lets exactly one caller pass, ever.
        Some(unsafe { &mut *self.value.get() })
    }
}

/// A value that a program gives to its interrupt handler, once, before it starts the interrupt.
pub struct Owned<T> {
    value: UnsafeCell<Option<T>>,
    given: AtomicBool,
    busy: AtomicBool,
}

// SAFETY: `give` writes before any reader is let in, and `busy` lets one in at a time.
unsafe impl<T: Send> Sync for Owned<T> {}

impl<T> Owned<T> {
    /// Nothing yet.
    pub const fn new() -> Self {
        Owned { value: UnsafeCell::new(None), given: AtomicBool::new(false), busy: AtomicBool::new(true) }
    }

    /// Hands the value over; a second one is dropped.
    pub fn give(&self, value: T) {
        if !self.given.swap(true, Ordering::AcqRel) {
            // SAFETY: the first and only giver; nobody is let in while `busy` is up, as it was from the beginning.
            unsafe { *self.value.get() = Some(value) };
            self.busy.store(false, Ordering::Release);
        }
    }

    /// Lets the handler use it, if it has been given and nobody else is using it.
    pub fn with(&self, f: impl FnOnce(&mut T)) {
        if self.busy.swap(true, Ordering::AcqRel) {
            return;
        }
        // SAFETY: `busy` was down and is up now: nobody else is here.
        if let Some(value) = unsafe { &mut *self.value.get() } {
            f(value);
        }
        self.busy.store(false, Ordering::Release);
    }
}

impl<T> Default for Owned<T> {
    fn default() -> Self {
        Self::new()
    }
}
