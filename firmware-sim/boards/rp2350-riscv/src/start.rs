//! What the start-up of an image needs: its definition, the cycle counter, a panic handler.
#![allow(unsafe_code)]

use core::arch::asm;
use core::panic::PanicInfo;
use rp235x_hal::block::ImageDef;

/// What the boot ROM looks for.
#[unsafe(link_section = ".start_block")]
#[used]
static IMAGE: ImageDef = ImageDef::secure_exe();

/// Lets the counters count: after a reset they are inhibited.
pub fn enable_counters() {
    // SAFETY: writes mcountinhibit (0x320), which changes nothing but the counters.
    unsafe { asm!("csrw 0x320, zero", options(nomem, nostack)) }
}

#[panic_handler]
fn panic(what: &PanicInfo<'_>) -> ! {
    riscv::interrupt::machine::disable();
    defmt::error!("{}", defmt::Display2Format(what));
    loop {
        riscv::asm::wfi();
    }
}

/// Lets interrupts through; each is masked until it is wanted.
pub fn enable_interrupts() {
    // SAFETY: called once at start-up, outside of critical sections.
    unsafe { rp235x_hal::arch::interrupt_enable() };
}
