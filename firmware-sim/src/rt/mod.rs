//! Start-up, semihosting call, slot timer, instruction counter, stack paint and single-owner statics: all the unsafe code.
//!
//! Each unsafe block says why it is sound. Start-up relies on no loader: it sets the stack (and its limit, where the processor
//! has one), copies the initial values of `.data` from code memory, clears `.bss`, leaves `.uninit` alone, enables the FPU and
//! calls `firmware_main`. A static that is to survive a reset is put there by `#[unsafe(link_section = ".uninit.NAME")]`.
//! A processor family has one file of its own.
//!
//! The virtual clock: the emulator advances time by a constant amount an instruction, so that a free-running counter of the
//! machine counts instructions and a timer that is compared with it interrupts every so many. All of it is derived from that
//! one counter. Its resolution is one tick: 0.5 to 0.8 instructions on Cortex-M, 1.6 on RISC-V, 1 on AArch64.
#![allow(unsafe_code)]

mod counters;
#[cfg_attr(target_arch = "arm", path = "cortex_m.rs")]
#[cfg_attr(target_arch = "riscv32", path = "riscv.rs")]
#[cfg_attr(target_arch = "aarch64", path = "aarch64.rs")]
mod family;

use core::cell::UnsafeCell;
use core::sync::atomic::{AtomicBool, Ordering};
pub use counters::{MARKS, counters, mark};
use family::trap;
pub use family::{reset, wait};

unsafe extern "C" {
    static mut _stack_limit: u32;
    static mut _stack_top: u32;
    /// The program's share of a timer interrupt; nothing where it has none (`memory/sections.ld`).
    fn firmware_tick();
}

#[unsafe(no_mangle)]
extern "C" fn firmware_no_tick() {}

/// Virtual picoseconds of a tick of the counter and of an instruction, in lowest terms: see `machines`.
const TICK: u64 = number(env!("SDP3_TICK_PS")) / COMMON;
const INSTRUCTION: u64 = number(env!("SDP3_INSTRUCTION_PS")) / COMMON;
const COMMON: u64 = {
    let (mut a, mut b) = (number(env!("SDP3_TICK_PS")), number(env!("SDP3_INSTRUCTION_PS")));
    while b > 0 {
        (a, b) = (b, a % b);
    }
    a
};

/// Instructions of a slot of 250 us at the machine's clock.
pub const SLOT: u32 = number(env!("SDP3_SLOT_INSTRUCTIONS")) as u32;

const fn number(text: &str) -> u64 {
    match u64::from_str_radix(text, 10) {
        Ok(number) => number,
        Err(_) => panic!("not a number"),
    }
}

/// Instructions in so many ticks.
fn from_ticks(ticks: u64) -> u64 {
    ticks * TICK / INSTRUCTION
}

/// Semihosting call; the result of the emulator.
pub(crate) fn call(operation: usize, block: &mut [usize; 4]) -> isize {
    // SAFETY: the emulator reads and writes the four words of the block, which are exclusive and outlive the call, and writes to the
    // buffers that `semihosting` put there from live exclusive slices.
    unsafe { trap(operation, block.as_mut_ptr() as usize) }
}

/// Prints zero-terminated text.
pub(crate) fn write0(text: &[u8; 128]) {
    // SAFETY: SYS_WRITE0 reads up to the zero that ends the text; `semihosting::print` leaves the last byte zero.
    unsafe { trap(0x04, text.as_ptr() as usize) };
}

/// The slot timer, in ticks of the counter.
struct Timer {
    /// When the current slot began by the clock: it may have been later.
    due: u64,
    /// When the next one begins; never, before [`start_ticks`].
    next: u64,
    /// A slot: whole ticks, and the rest in parts of a tick, of which it has [`TICK`].
    period: (u64, u64),
    /// Parts of a tick left over from the slots before.
    rest: u64,
    /// Slots begun.
    slots: u32,
    /// Ticks spent in interrupts.
    interrupted: u64,
}

struct TimerCell(UnsafeCell<Timer>);

// SAFETY: only `timer` uses it, with interrupts masked, on one core.
unsafe impl Sync for TimerCell {}

static TIMER: TimerCell = TimerCell(UnsafeCell::new(Timer {
    due: 0,
    next: u64::MAX,
    period: (u64::MAX, 0),
    rest: 0,
    slots: 0,
    interrupted: 0,
}));

/// Calls `f` with the timer and the counter, with interrupts masked. It must not call this function.
fn timer<R>(f: impl FnOnce(&mut Timer, u64) -> R) -> R {
    // SAFETY: interrupts are masked and `f` is not nested: this is the only reference.
    family::masked(|| f(unsafe { &mut *TIMER.0.get() }, family::ticks()))
}

/// Called by every timer interrupt. One that comes before the next slot is due only keeps the counter's high word.
fn timer_interrupt() {
    let (begins, entered) = timer(|timer, now| {
        let begins = now >= timer.next;
        if begins {
            timer.due = timer.next;
            timer.rest += timer.period.1;
            timer.next = timer.next.saturating_add(timer.period.0);
            if timer.rest >= TICK {
                timer.rest -= TICK;
                timer.next += 1;
            }
            timer.slots = timer.slots.wrapping_add(1);
        }
        family::set_alarm(timer.next);
        (begins, now)
    });
    if begins {
        // SAFETY: the program's handler, or the one above.
        unsafe { firmware_tick() };
    }
    timer(|timer, now| timer.interrupted += now - entered);
}

/// Starts the counter behind [`instructions`].
pub fn start_counter() {
    family::start_counter();
    timer(|timer, _| family::set_alarm(timer.next));
    family::enable_interrupt();
}

/// Calls `firmware_tick` every so many instructions, at most 2^24 ticks of the counter; starts the counter if need be.
///
/// Interrupt k is due k times the period after this call, rounded down to a tick: there is no drift. One that is served late
/// does not move the next, and none is left out.
pub fn start_ticks(instructions: u32) {
    start_counter();
    timer(|timer, now| {
        let length = u64::from(instructions.max(1)) * INSTRUCTION;
        timer.period = (length / TICK, length % TICK);
        timer.rest = timer.period.1;
        timer.next = now + timer.period.0;
        timer.slots = 0;
        family::set_alarm(timer.next);
    });
}

/// Slots begun since [`start_ticks`].
pub fn slots() -> u32 {
    timer(|timer, _| timer.slots)
}

/// Instructions since the current slot was due. Within `firmware_tick`: how late it is.
pub fn lateness() -> u64 {
    timer(|timer, now| from_ticks(now - timer.due))
}

/// Whether the next slot is due: within `firmware_tick`, whether it has come too late or taken too long.
pub fn pending() -> bool {
    timer(|timer, now| now >= timer.next)
}

/// Instructions executed since [`start_counter`], those in interrupts and the time asleep included.
///
/// The counter has 64 bits; on Cortex-M an interrupt of some sixty instructions every 2^24 ticks counts the overflows of its low word.
pub fn instructions() -> u64 {
    from_ticks(family::masked(family::ticks))
}

/// As [`instructions`], without those of interrupts (but for the entry and exit of the family's assembly, some hundred each).
pub fn foreground_instructions() -> u64 {
    timer(|timer, now| from_ticks(now - timer.interrupted))
}

const PAINT: u32 = 0xACED_C0DE;

/// Fills the free memory below the stack with a pattern.
#[inline(never)]
pub fn paint_stack() {
    let here = 0_u32;
    let bottom = &raw mut _stack_limit;
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
    let (bottom, top) = (&raw const _stack_limit, &raw const _stack_top as usize);
    let mut k = 0;
    // SAFETY: reads memory between the statics and the stack's top.
    while unsafe { bottom.add(k).read_volatile() } == PAINT {
        k += 1;
    }
    top - (bottom as usize + 4 * k)
}

/// Sets a flag and returns what it was. A load and a store with interrupts masked: not every processor can swap.
pub(crate) fn test_and_set(flag: &AtomicBool) -> bool {
    family::masked(|| {
        let before = flag.load(Ordering::Acquire);
        flag.store(true, Ordering::Relaxed);
        before
    })
}

/// A static with one owner.
pub struct Single<T> {
    value: UnsafeCell<T>,
    taken: AtomicBool,
}

// SAFETY: `take` hands the value out once.
unsafe impl<T: Send> Sync for Single<T> {}

impl<T> Single<T> {
    /// A static value.
    pub const fn new(value: T) -> Self {
        Single { value: UnsafeCell::new(value), taken: AtomicBool::new(false) }
    }

    /// The value, the first time.
    pub fn take(&'static self) -> Option<&'static mut T> {
        if test_and_set(&self.taken) {
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
        if !test_and_set(&self.given) {
            // SAFETY: the first and only giver; nobody is let in while `busy` is set, as it was from the beginning.
            unsafe { *self.value.get() = Some(value) };
            self.busy.store(false, Ordering::Release);
        }
    }

    /// Lets the handler use it, if it has been given and nobody else is using it.
    pub fn with(&self, f: impl FnOnce(&mut T)) {
        if test_and_set(&self.busy) {
            return;
        }
        // SAFETY: `busy` was clear and is set now: nobody else is here.
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
