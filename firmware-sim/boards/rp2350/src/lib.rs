//! An RP2350's Cortex-M33 on a Raspberry Pi Pico 2, with its radar module: clocks, serial line, sensor, executor of the slots.
#![no_std]

pub mod executor;
#[cfg(feature = "bgt60")]
mod sensor;

use cortex_m::peripheral::DWT;
use defmt_rtt as _;
use embassy_rp::config::Config;
use embassy_rp::uart::{self, Blocking, UartTx};
use panic_probe as _;
use sdp3_board_support::cycles::extended;
use sdp3_board_support::line::Serial;

/// Bits a second of the serial line.
const BAUD: u32 = 921_600;

/// UART0 on GPIO0: 8 bits, no parity, one stop bit.
pub struct Uart(UartTx<'static, Blocking>);

impl Serial for Uart {
    fn send(&mut self, byte: u8) {
        let _ = self.0.blocking_write(&[byte]); // sending has no errors
    }
}

/// Where the samples come from.
#[cfg(not(feature = "bgt60"))]
pub type Radar = sdp3_board_support::recording::Recording;
#[cfg(feature = "bgt60")]
pub use sensor::Radar;

/// What a program uses of the board.
pub struct Board {
    /// The serial line.
    pub uart: Uart,
    /// Where the samples come from.
    pub radar: Radar,
}

/// Sets clocks (150 MHz from the crystal of 12 MHz) and serial line, once.
pub fn board() -> Option<Board> {
    let mut core = cortex_m::Peripherals::take()?;
    core.DCB.enable_trace();
    core.DWT.enable_cycle_counter();
    let device = embassy_rp::init(Config::default());
    let mut config = uart::Config::default();
    config.baudrate = BAUD;
    let uart = Uart(UartTx::new_blocking(device.UART0, device.PIN_0, config));
    #[cfg(feature = "bgt60")]
    let radar = {
        let (transmit, receive) = (device.DMA_CH0, device.DMA_CH1);
        let spi = sensor::spi(device.SPI0, device.PIN_18, device.PIN_19, device.PIN_16, transmit, receive);
        sensor::radar(spi, device.PIN_17.into(), device.PIN_20.into())
    };
    #[cfg(not(feature = "bgt60"))]
    let radar = sdp3_board_support::async_station::recording();
    Some(Board { uart, radar })
}

/// Cycles so far.
pub fn cycle_counter() -> impl FnMut() -> u64 {
    extended(DWT::cycle_count)
}
