//! The caches, and the memory that goes around them.
#![allow(unsafe_code)]

use core::cell::UnsafeCell;
use core::mem::MaybeUninit;
use core::sync::atomic::{AtomicBool, Ordering::Relaxed};
use cortex_m::asm::{dsb, isb};
use cortex_m::peripheral::{CPUID, MPU, SCB};
use sdp3_board_support::bgt60::DmaBuffer;

unsafe extern "C" {
    static _uncached_start: u8;
}

/// MPU_RASR: data, readable and writable, normal memory that is not cached, 2^12 bytes.
const UNCACHED_4K: u32 = 1 << 28 | 3 << 24 | 1 << 19 | 11 << 1 | 1;
/// MPU_CTRL: on; elsewhere the default memory map.
const ON: u32 = 1 << 2 | 1;

/// Takes the region UNCACHED of `memory.x` out of the data cache, then switches both caches on.
pub fn enable_caches(mpu: &mut MPU, scb: &mut SCB, cpuid: &mut CPUID) {
    // SAFETY: the region has the size and alignment of UNCACHED. The data cache is off, so that no line of it is cached. All other
    // memory stays as it is.
    unsafe {
        mpu.rnr.write(0);
        mpu.rbar.write(&raw const _uncached_start as u32);
        mpu.rasr.write(UNCACHED_4K);
        mpu.ctrl.write(ON);
    }
    dsb();
    isb();
    scb.enable_icache();
    scb.enable_dcache(cpuid);
}

struct Uncached(UnsafeCell<MaybeUninit<DmaBuffer>>);

// SAFETY: `dma_buffer` returns a reference once.
unsafe impl Sync for Uncached {}

#[unsafe(link_section = ".uncached")]
static BUFFER: Uncached = Uncached(UnsafeCell::new(MaybeUninit::uninit()));
static TAKEN: AtomicBool = AtomicBool::new(false);

/// The buffer of the SPI's DMA, once. Start-up does not write its memory: this does.
pub fn dma_buffer() -> Option<&'static mut DmaBuffer> {
    if TAKEN.swap(true, Relaxed) {
        return None;
    }
    // SAFETY: nobody else has a reference to it, and none is made again.
    let memory = unsafe { &mut *BUFFER.0.get() };
    Some(memory.write(DmaBuffer::new()))
}
