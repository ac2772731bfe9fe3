//! A BGT60TR13C on SPIM4 with its own pins.

use embassy_nrf::gpio::{AnyPin, Level, Output, OutputDrive};
use embassy_nrf::pac::{P0_S, SPIM4_S, gpio::vals::Mcusel};
use embassy_nrf::peripherals::{P0_08, P0_09, P0_10, SPIM4};
use embassy_nrf::spim::{Config, Frequency, InterruptHandler, Spim};
use embassy_nrf::{Peri, bind_interrupts};
use embassy_time::Delay;
use sdp3_board_support::async_station::REGISTERS;
use sdp3_board_support::bgt60::{Bgt60, DmaBuffer};
use sdp3_board_support::spi::Stopped;
use static_cell::ConstStaticCell;

bind_interrupts!(struct Interrupts {
    SPIM4 => InterruptHandler<SPIM4>;
});

static BUFFER: ConstStaticCell<DmaBuffer> = ConstStaticCell::new(DmaBuffer::new());

type Spi = Stopped<Spim<'static>>;

/// The sensor.
pub type Radar = Bgt60<Spi, Output<'static>, Output<'static>, Delay>;

/// Ends a transfer.
fn stop() {
    SPIM4_S.events_stopped().write_value(0);
    SPIM4_S.tasks_stop().write_value(1);
    // a byte takes 64 cycles; a transfer that has ended may not answer
    for _ in 0..256 {
        if SPIM4_S.events_stopped().read() != 0 {
            break;
        }
    }
}

/// SPIM4 with 16 MHz: SCK, MOSI, MISO.
pub fn spi(
    spi: Peri<'static, SPIM4>,
    clock: Peri<'static, P0_08>,
    to_sensor: Peri<'static, P0_09>,
    from_sensor: Peri<'static, P0_10>,
) -> Spi {
    let mut config = Config::default();
    config.frequency = Frequency::M16;
    let spi = Spim::new(spi, Interrupts, clock, from_sensor, to_sensor, config);
    for pin in [8, 9, 10] {
        P0_S.pin_cnf(pin).modify(|w| w.set_mcusel(Mcusel::Peripheral));
    }
    Stopped::new(spi, stop)
}

/// The sensor behind the SPI; its pins CS and RST.
pub fn radar(spi: Spi, select: Peri<'static, AnyPin>, reset: Peri<'static, AnyPin>) -> Radar {
    let select = Output::new(select, Level::High, OutputDrive::HighDrive);
    let reset = Output::new(reset, Level::High, OutputDrive::Standard);
    Bgt60::new(spi, select, reset, Delay, REGISTERS, BUFFER.take())
}
