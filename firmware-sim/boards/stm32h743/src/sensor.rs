//! A BGT60TR13C on the Arduino connector.

use crate::memory::dma_buffer;
use embassy_stm32::gpio::{AnyPin, Level, Output, Speed};
use embassy_stm32::mode::Async;
use embassy_stm32::peripherals::{DMA1_CH0, DMA1_CH1, PA5, PA6, PB5, SPI1};
use embassy_stm32::spi::{Config, Spi, mode::Master};
use embassy_stm32::time::Hertz;
use embassy_stm32::{Peri, bind_interrupts, dma};
use embassy_time::Delay;
use sdp3_board_support::async_station::REGISTERS;
use sdp3_board_support::bgt60::{Bgt60, SPI_HZ};

bind_interrupts!(struct Interrupts {
    DMA1_STREAM0 => dma::InterruptHandler<DMA1_CH0>;
    DMA1_STREAM1 => dma::InterruptHandler<DMA1_CH1>;
});

type Pin = Peri<'static, AnyPin>;

/// The sensor.
pub type Radar = Bgt60<Spi<'static, Async, Master>, Output<'static>, Output<'static>, Delay>;

/// SPI1 with its DMA channels: SCK, MOSI, MISO.
pub fn spi(
    spi: Peri<'static, SPI1>,
    clock: Peri<'static, PA5>,
    to_sensor: Peri<'static, PB5>,
    from_sensor: Peri<'static, PA6>,
    transmit: Peri<'static, DMA1_CH0>,
    receive: Peri<'static, DMA1_CH1>,
) -> Spi<'static, Async, Master> {
    let mut config = Config::default();
    config.frequency = Hertz(SPI_HZ);
    Spi::new(spi, clock, to_sensor, from_sensor, transmit, receive, Interrupts, config)
}

/// The sensor behind the SPI; its pins CS and RST.
pub fn radar(spi: Spi<'static, Async, Master>, select: Pin, reset: Pin) -> Option<Radar> {
    let select = Output::new(select, Level::High, Speed::High);
    let reset = Output::new(reset, Level::High, Speed::Low);
    Some(Bgt60::new(spi, select, reset, Delay, REGISTERS, dma_buffer()?))
}
