//! The program of `docs/porting.md`: what a port of the radar module needs, and what the firmware here runs.

use crate::board::{Board, report, sleep};
use sdp3_core::radar::{Progress, RadarModule, Settings, SlotAction, SlotContext};
use sdp3_core::supervision::retained::Retained;
use sdp3_core::{Error, dsn::Shape, radar_memory, scheduler::SensingLayout};
use static_cell::ConstStaticCell;

static MODEL: &[u8] = sdp3_testkit::models::DSN_1000; // a port: include_bytes!("dsn-1000.sdp3")
const SHAPE: Shape = Shape::of(MODEL).expect("a model");
static MEMORY: ConstStaticCell<radar_memory!(SHAPE)> = ConstStaticCell::new(<radar_memory!(SHAPE)>::new());
#[unsafe(link_section = ".uninit.retained")] // RAM that start-up leaves alone
static RETAINED: Retained = Retained::new();

/// The slot interrupt.
pub fn slot(slots: &mut SlotContext<{ SHAPE.slot_values() }>, number: u32, board: &mut impl Board) {
    match slots.begin(number) {
        SlotAction::Sense(buffer) => board.start_transfer(&mut buffer.0), // at its end: slots.samples_ready()
        SlotAction::Serve(user) => board.transmit(user),
        SlotAction::Idle => {}
    }
}

/// Start-up and the idle loop.
pub fn run(board: impl FnOnce(SlotContext<{ SHAPE.slot_values() }>)) -> Result<(), Error> {
    let layout = SensingLayout::new(4000, 3, 1000)?;
    let settings = Settings { layout, rates: [1500, 2500, 3000, 0, 0, 0, 0, 0], threshold: 2.0 };
    let (slots, mut processing) = RadarModule::single(MODEL, settings, MEMORY.take(), &RETAINED)?.split();
    board(slots); // the interrupt's from now on
    loop {
        match processing.poll() {
            Progress::Event(event) => report(event),
            Progress::Busy => {}
            Progress::Idle => sleep(),
        }
    }
}
