//! Runs the conformance suite in flash and prints the digest of every stage.
#![no_std]
#![no_main]

use cortex_m_rt::entry;
use sdp3_board_support::line::Board;
use sdp3_board_support::linked::data;
use sdp3_board_support::suite::{MODEL_BYTES, SLOT_VALUES, SuiteMemory};
use sdp3_conformance::run;
use sdp3_stm32f405::{board, cycle_counter};
use static_cell::ConstStaticCell;

static MEMORY: ConstStaticCell<SuiteMemory> = ConstStaticCell::new(SuiteMemory::new());
static SLOT: ConstStaticCell<[i16; SLOT_VALUES]> = ConstStaticCell::new([0; SLOT_VALUES]);
static MODEL: ConstStaticCell<[u8; MODEL_BYTES]> = ConstStaticCell::new([0; MODEL_BYTES]);

#[entry]
fn main() -> ! {
    if let Some(board) = board() {
        let mut machine = Board { suite: data(), serial: board.uart, cycles: cycle_counter() };
        if let Err(failure) = run(&mut machine, MEMORY.take(), SLOT.take(), MODEL.take(), &mut ()) {
            failure.report(&mut machine);
        }
    }
    loop {
        cortex_m::asm::wfi();
    }
}
