//! The program of `docs/porting.md`: what a port of the radar module needs. The stations include it as it is, and so does a test on
//! the host. `board` is the port's own.
#![allow(unsafe_code)] // the section

use crate::{board, static_cell::ConstStaticCell}; // of the crate static_cell
// docs/porting.md and core/README.md show what follows
use sdp3_core::{Progress, RadarModule, Retained, SensingLayout, Settings, Shape, SlotAction, radar_memory};

const SHAPE: Shape = Shape::of(board::MODEL).expect("a model"); // MODEL: include_bytes!("model.sdp3")
static MEMORY: ConstStaticCell<radar_memory!(SHAPE)> = ConstStaticCell::new(<radar_memory!(SHAPE)>::new());
#[unsafe(link_section = ".uninit.retained")] // RAM that start-up leaves alone
static RETAINED: Retained = Retained::new();

/// The slot interrupt. At the end of the transfer: `slots.samples_ready()`.
pub fn slot(slots: &mut board::Slots, number: u32) {
    match slots.begin(number) {
        SlotAction::Sense(buffer) => board::start_transfer(&mut buffer.0),
        SlotAction::Serve(user) => board::transmit(user),
        SlotAction::Idle => {}
    }
}

/// Start-up, then the idle loop.
pub fn run() -> Result<(), sdp3_core::Error> {
    let settings =
        Settings { layout: SensingLayout::new(4000, 3, 1000)?, rates: board::BITS, threshold: 2.0 };
    let (slots, mut task) = RadarModule::single(board::MODEL, settings, MEMORY.take(), &RETAINED)?.split();
    board::start(slots, &mut task); // from here on `slots` belongs to the interrupt
    loop {
        match task.poll() {
            Progress::Event(event) => board::report(&task, event),
            Progress::Busy => {}
            Progress::Idle => board::sleep(),
        }
    }
}
