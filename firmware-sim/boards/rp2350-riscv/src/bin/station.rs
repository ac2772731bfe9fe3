//! The program of `docs/porting.md` on recorded slots; after 10 000 slots it prints what it has seen, and goes on.
#![no_std]
#![no_main]

extern crate static_cell;

#[path = "../../../../src/porting.rs"]
mod porting;

use rp235x_hal::entry;

/// Runs the program.
#[entry]
fn main() -> ! {
    if board::power_on() {
        match porting::run() {
            Ok(()) => board::say(format_args!("error: the idle loop ended")),
            Err(error) => board::say(format_args!("error: {error}")),
        }
    }
    loop {
        riscv::asm::wfi();
    }
}

mod interrupt {
    #![allow(unsafe_code)] // the name by which the HAL calls it

    #[unsafe(no_mangle)]
    #[allow(non_snake_case)]
    fn TIMER0_IRQ_0() {
        crate::board::slot_interrupt();
    }
}

mod board {
    use core::cell::RefCell;
    use core::fmt::Arguments;
    use critical_section::Mutex;
    pub use sdp3_board_support::station::BITS;
    use sdp3_board_support::{line::print, linked::data, station::Station};
    use sdp3_core::dsn::Shape;
    use sdp3_core::radar::{Event, ProcessingContext, SlotContext};
    use sdp3_rp2350_riscv::{SlotTimer, Uart, board};
    pub use sdp3_testkit::models::DSN_200 as MODEL;

    const VALUES: usize = Shape::of(MODEL).expect("a model").slot_values();
    /// The slot interrupt's context.
    pub type Slots = SlotContext<VALUES>;
    type Task = ProcessingContext<VALUES>;

    static STATION: Station = Station::new(data);
    static SLOTS: Mutex<RefCell<Option<Slots>>> = Mutex::new(RefCell::new(None));
    static UART: Mutex<RefCell<Option<Uart>>> = Mutex::new(RefCell::new(None));
    static TIMER: Mutex<RefCell<Option<SlotTimer>>> = Mutex::new(RefCell::new(None));

    /// Sets the board up and tests the signal chain.
    pub fn power_on() -> bool {
        let Some(board) = board() else { return false };
        critical_section::with(|cs| {
            *UART.borrow_ref_mut(cs) = Some(board.uart);
            *TIMER.borrow_ref_mut(cs) = Some(board.timer);
        });
        STATION.test_signal_chain(say)
    }

    /// Prints a line. Slot interrupts come in between.
    pub fn say(line: Arguments<'_>) {
        let uart = critical_section::with(|cs| UART.borrow_ref_mut(cs).take());
        let Some(mut uart) = uart else { return };
        print(&mut uart, line);
        critical_section::with(|cs| *UART.borrow_ref_mut(cs) = Some(uart));
    }

    /// The slot timer's interrupt.
    pub fn slot_interrupt() {
        critical_section::with(|cs| {
            if let Some(timer) = TIMER.borrow_ref_mut(cs).as_mut() {
                timer.again();
            }
            if let Some(slots) = SLOTS.borrow_ref_mut(cs).as_mut() {
                crate::porting::slot(slots, STATION.run.begin());
                if STATION.run.transferred() {
                    slots.samples_ready();
                }
            }
            if TIMER.borrow_ref(cs).as_ref().is_some_and(SlotTimer::late) {
                STATION.run.late();
            }
        });
    }

    /// Copies the samples of a slot: there is no sensor.
    pub fn start_transfer(buffer: &mut [i16]) {
        STATION.start_transfer(buffer);
    }

    /// The radio, which is not part of this program.
    pub fn transmit(_user: u8) {}

    /// Tests the networks, then starts the slot timer.
    pub fn start(slots: Slots, task: &mut Task) {
        if !STATION.test_networks(task, say) {
            return;
        }
        critical_section::with(|cs| {
            *SLOTS.borrow_ref_mut(cs) = Some(slots);
            if let Some(timer) = TIMER.borrow_ref_mut(cs).as_mut() {
                timer.start();
            }
        });
    }

    /// Logs and counts an event, and prints a recognition.
    pub fn report(task: &Task, event: Event) {
        STATION.report(task, &event, say);
    }

    /// Sleeps until the next interrupt; prints the counts once they are of enough slots.
    pub fn sleep() {
        STATION.counts(say);
        riscv::asm::wfi();
    }
}
