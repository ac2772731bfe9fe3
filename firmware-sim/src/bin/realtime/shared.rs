//! What the timer interrupt and the idle loop share.

use core::sync::atomic::AtomicU32;
use sdp3_core::dsn::Shape;
use sdp3_core::supervision::retained::Retained;
use sdp3_testkit::models::DSN_1000;

/// The larger of the two models in everything.
pub const SHAPE: Shape = Shape::of(DSN_1000).expect("a model");
/// Values of a slot.
pub const VALUES: usize = SHAPE.slot_values();
/// Sensing slots of the first of two exits.
pub const FIRST_EXIT: u32 = 200;
/// Slots within which a report comes, and without a fault at the end.
pub const QUIET: u32 = 300;

#[allow(unsafe_code)] // a section that start-up leaves alone; the emulator's memory is zero at first
#[unsafe(link_section = ".uninit.retained")]
pub static RETAINED: Retained = Retained::new();
/// Timer interrupts so far.
pub static INTERRUPTS: AtomicU32 = AtomicU32::new(0);

/// Keeps the largest count so far.
pub fn maximum(worst: &mut u32, count: u64) {
    *worst = (*worst).max(count as u32);
}
