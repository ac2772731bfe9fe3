//! An ESP32-C3 with its radar module: clocks, serial line, slot timer, and the data that is linked in.
//!
//! The bootloader maps a program's segments to addresses and nothing else of the flash: a recording or a suite is a part of the
//! program.
#![no_std]

mod registers;

use core::panic::PanicInfo;
use defmt_rtt as _;
use esp_hal::clock::CpuClock;
use esp_hal::interrupt::{InterruptHandler, InterruptStatus};
use esp_hal::peripherals::Interrupt;
use esp_hal::time::Duration;
use esp_hal::timer::PeriodicTimer;
use esp_hal::timer::systimer::SystemTimer;
use esp_hal::uart::{self, UartTx};
use esp_hal::{Blocking, Config};
use sdp3_board_support::cycles::extended;
use sdp3_board_support::interrupt_station;
use sdp3_board_support::line::Serial;
use sdp3_board_support::linked::paint_stack;

esp_bootloader_esp_idf::esp_app_desc!();

/// Bits a second of the serial line.
const BAUD: u32 = 921_600;
/// A slot in microseconds.
const SLOT_US: u64 = 250;

/// UART0 on GPIO21: 8 bits, no parity, one stop bit.
pub struct Uart(UartTx<'static, Blocking>);

impl Serial for Uart {
    fn send(&mut self, byte: u8) {
        while !matches!(self.0.write(&[byte]), Ok(1)) {}
    }
}

/// Alarm 0 of the system timer, which counts 16 MHz.
pub struct SlotTimer(PeriodicTimer<'static, Blocking>);

impl SlotTimer {
    /// What begins a slot.
    pub fn set_handler(&mut self, interrupt: InterruptHandler) {
        self.0.set_interrupt_handler(interrupt);
    }
}

impl interrupt_station::SlotTimer for SlotTimer {
    fn start(&mut self) -> bool {
        self.0.listen();
        self.0.start(Duration::from_micros(SLOT_US)).is_ok()
    }

    fn acknowledge(&mut self) {
        self.0.clear_interrupt();
    }

    fn late(&self) -> bool {
        InterruptStatus::is_pending(Interrupt::SYSTIMER_TARGET0)
    }
}

/// What a program uses of the board.
pub struct Board {
    /// The serial line.
    pub uart: Uart,
    /// The slot timer, off.
    pub timer: SlotTimer,
}

/// Sets the processor's clock to 160 MHz, the serial line, and the cycle counter, and lets interrupts through. For one call.
pub fn board() -> Option<Board> {
    paint_stack();
    let device = esp_hal::init(Config::default().with_cpu_clock(CpuClock::_160MHz));
    let config = uart::Config::default().with_baudrate(BAUD);
    let uart = UartTx::new(device.UART0, config).ok()?.with_tx(device.GPIO21);
    let timer = PeriodicTimer::new(SystemTimer::new(device.SYSTIMER).alarm0);
    registers::enable_cycles();
    registers::enable_interrupts();
    Some(Board { uart: Uart(uart), timer: SlotTimer(timer) })
}

/// The recording that SDP3_RECORDING named at build time; else empty.
pub fn recording() -> &'static [u8] {
    include_bytes!(concat!(env!("OUT_DIR"), "/recording"))
}

/// The conformance suite that SDP3_SUITE named at build time; else empty.
pub fn suite() -> &'static [u8] {
    include_bytes!(concat!(env!("OUT_DIR"), "/suite"))
}

/// Cycles so far.
pub fn cycle_counter() -> impl FnMut() -> u64 {
    extended(registers::cycles)
}

#[panic_handler]
fn panic(info: &PanicInfo) -> ! {
    critical_section::with(|_| {
        defmt::error!("{}", defmt::Display2Format(info));
        loop {
            core::hint::spin_loop();
        }
    })
}
