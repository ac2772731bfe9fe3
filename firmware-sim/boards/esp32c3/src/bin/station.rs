//! The program of `docs/porting.md` on recorded slots; after 10 000 slots it prints what it has seen, and goes on.
#![no_std]
#![no_main]

extern crate static_cell;

#[path = "../../../../src/porting.rs"]
mod porting;

use esp_hal::interrupt::{Priority, wait_for_interrupt};

#[esp_hal::main]
fn main() -> ! {
    if board::power_on() {
        match porting::run() {
            Ok(()) => board::say(format_args!("error: the idle loop ended")),
            Err(error) => board::say(format_args!("error: {error}")),
        }
    }
    loop {
        wait_for_interrupt();
    }
}

#[esp_hal::handler(priority = Priority::max())]
fn slot_interrupt() {
    board::slot_interrupt();
}

mod board {
    use core::fmt::Arguments;
    use sdp3_board_support::interrupt_station::InterruptStation;
    pub use sdp3_board_support::station::BITS;
    use sdp3_core::dsn::Shape;
    use sdp3_core::radar::{Event, ProcessingContext, SlotContext};
    use sdp3_esp32c3::{SlotTimer, Uart, board, recording};
    pub use sdp3_testkit::models::DSN_200 as MODEL;

    const VALUES: usize = Shape::of(MODEL).expect("a model").slot_values();
    /// The slot interrupt's context.
    pub type Slots = SlotContext<VALUES>;
    type Task = ProcessingContext<VALUES>;

    static STATION: InterruptStation<Uart, SlotTimer, VALUES> = InterruptStation::new(recording);

    /// Sets the board up and tests the signal chain.
    pub fn power_on() -> bool {
        let Some(mut board) = board() else { return false };
        board.timer.set_handler(crate::slot_interrupt);
        STATION.power_on(board.uart, board.timer)
    }

    /// Prints a line.
    pub fn say(line: Arguments<'_>) {
        STATION.say(line);
    }

    /// The slot timer's interrupt.
    pub fn slot_interrupt() {
        STATION.interrupt(crate::porting::slot);
    }

    /// Copies the samples of a slot: there is no sensor.
    pub fn start_transfer(buffer: &mut [i16]) {
        STATION.start_transfer(buffer);
    }

    /// The radio, which is not part of this program.
    pub fn transmit(_user: u8) {}

    /// Tests the networks, then starts the slot timer.
    pub fn start(slots: Slots, task: &mut Task) {
        STATION.start(slots, task);
    }

    /// Logs and counts an event, and prints a recognition.
    pub fn report(task: &Task, event: Event) {
        STATION.report(task, &event);
    }

    /// Sleeps until the next interrupt; prints the counts once they are of enough slots.
    pub fn sleep() {
        STATION.counts();
        super::wait_for_interrupt();
    }
}
