//! An RP2350's Hazard3 (RISC-V) on a Raspberry Pi Pico 2, with its radar module: clocks, serial line, slot timer.
#![no_std]

mod slot_timer;
mod start;

pub use slot_timer::SlotTimer;

use defmt_rtt as _;
use rp235x_hal::clocks::{Clock, init_clocks_and_plls};
use rp235x_hal::fugit::RateExtU32;
use rp235x_hal::gpio::bank0::{Gpio0, Gpio1};
use rp235x_hal::gpio::{FunctionUart, Pin, Pins, PullDown};
use rp235x_hal::pac::{Peripherals, UART0};
use rp235x_hal::uart::{DataBits, Enabled, StopBits, UartConfig, UartPeripheral};
use rp235x_hal::{Sio, Timer, Watchdog};
use sdp3_board_support::line::Serial;
use sdp3_board_support::linked::paint_stack;

/// Frequency of the crystal in Hz.
const CRYSTAL_HZ: u32 = 12_000_000;
/// Bits a second of the serial line.
const BAUD: u32 = 921_600;

type Wire<P> = Pin<P, FunctionUart, PullDown>;

/// UART0 on GPIO0: 8 bits, no parity, one stop bit.
pub struct Uart(UartPeripheral<Enabled, UART0, (Wire<Gpio0>, Wire<Gpio1>)>);

impl Serial for Uart {
    fn send(&mut self, byte: u8) {
        self.0.write_full_blocking(&[byte]);
    }
}

/// What a program uses of the board.
pub struct Board {
    /// The serial line.
    pub uart: Uart,
    /// The slot timer, off.
    pub timer: SlotTimer,
}

/// Sets clocks (150 MHz), serial line and cycle counter, and lets interrupts through, once. Paints the stack.
pub fn board() -> Option<Board> {
    paint_stack();
    let device = Peripherals::take()?;
    let mut resets = device.RESETS;
    let mut watchdog = Watchdog::new(device.WATCHDOG);
    let clocks = init_clocks_and_plls(
        CRYSTAL_HZ,
        device.XOSC,
        device.CLOCKS,
        device.PLL_SYS,
        device.PLL_USB,
        &mut resets,
        &mut watchdog,
    )
    .ok()?;
    let sio = Sio::new(device.SIO);
    let pins = Pins::new(device.IO_BANK0, device.PADS_BANK0, sio.gpio_bank0, &mut resets);
    let config = UartConfig::new(BAUD.Hz(), DataBits::Eight, None, StopBits::One);
    let wires = (pins.gpio0.into_function(), pins.gpio1.into_function());
    let uart = UartPeripheral::new(device.UART0, wires, &mut resets);
    let uart = Uart(uart.enable(config, clocks.peripheral_clock.freq()).ok()?);
    let timer = SlotTimer::new(Timer::new_timer0(device.TIMER0, &mut resets, &clocks))?;
    start::enable_counters();
    start::enable_interrupts();
    Some(Board { uart, timer })
}

/// Cycles so far.
pub fn cycle_counter() -> impl FnMut() -> u64 {
    || riscv::register::mcycle::read64()
}
