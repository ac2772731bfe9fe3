//! The application core of an nRF5340 on its development kit, with its radar module: clocks, serial line, sensor, slot timer,
//! executor of the slots.
#![no_std]

pub mod executor;
#[cfg(feature = "bgt60")]
mod sensor;
mod slot_timer;

pub use slot_timer::SlotTimer;

use cortex_m::peripheral::DWT;
use defmt_rtt as _;
use embassy_nrf::bind_interrupts;
use embassy_nrf::config::{Config, HfclkSource, LfclkSource};
use embassy_nrf::pac::clock::vals::Hclk;
use embassy_nrf::pac::{CACHE_S, CLOCK_S};
use embassy_nrf::peripherals::SERIAL0;
use embassy_nrf::uarte::{self, Baudrate, UarteTx};
use panic_probe as _;
use sdp3_board_support::cycles::extended;
use sdp3_board_support::line::Serial;

bind_interrupts!(struct Interrupts {
    SERIAL0 => uarte::InterruptHandler<SERIAL0>;
});

/// UARTE0 on P0.20, the first serial line of the kit's debugger: 921 600 bits a second, 8 bits, no parity, one stop bit.
pub struct Uart(UarteTx<'static>);

impl Serial for Uart {
    fn send(&mut self, byte: u8) {
        let _ = self.0.blocking_write(&[byte]); // a byte of the stack is in RAM
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
    /// Where slots begin: runs.
    pub slots: SlotTimer,
}

/// 128 MHz from the crystal.
fn clocks() -> Config {
    let mut config = Config::default();
    config.hfclk_source = HfclkSource::ExternalXtal;
    config.lfclk_source = LfclkSource::ExternalXtal;
    config
}

/// Sets clocks and serial line, once.
pub fn board() -> Option<Board> {
    let mut core = cortex_m::Peripherals::take()?;
    core.DCB.enable_trace();
    core.DWT.enable_cycle_counter();
    let device = embassy_nrf::init(clocks());
    CLOCK_S.hfclkctrl().write(|w| w.set_hclk(Hclk::Div1)); // 64 MHz after a reset
    CACHE_S.enable().write(|w| w.set_enable(true)); // of flash; off after a reset
    let mut config = uarte::Config::default();
    config.baudrate = Baudrate::Baud921600;
    let uart = Uart(UarteTx::new(device.SERIAL0, Interrupts, device.P0_20, config));
    #[cfg(feature = "bgt60")]
    let radar = {
        let spi = sensor::spi(device.SPIM4, device.P0_08, device.P0_09, device.P0_10);
        sensor::radar(spi, device.P0_11.into(), device.P0_12.into())
    };
    #[cfg(not(feature = "bgt60"))]
    let radar = sdp3_board_support::async_station::recording();
    Some(Board { uart, radar, slots: SlotTimer::new(device.TIMER1) })
}

/// Cycles so far.
pub fn cycle_counter() -> impl FnMut() -> u64 {
    extended(DWT::cycle_count)
}
