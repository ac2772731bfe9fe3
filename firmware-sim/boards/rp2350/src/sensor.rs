//! A BGT60TR13C on SPI0.

use embassy_rp::gpio::{AnyPin, Level, Output};
use embassy_rp::peripherals::{DMA_CH0, DMA_CH1, PIN_16, PIN_18, PIN_19, SPI0};
use embassy_rp::spi::{Async, Config, Spi};
use embassy_rp::{Peri, bind_interrupts, dma, pac};
use embassy_time::Delay;
use sdp3_board_support::async_station::REGISTERS;
use sdp3_board_support::bgt60::{Bgt60, DmaBuffer, SPI_HZ};
use sdp3_board_support::spi::Stopped;
use static_cell::ConstStaticCell;

bind_interrupts!(struct Interrupts {
    DMA_IRQ_0 => dma::InterruptHandler<DMA_CH0>, dma::InterruptHandler<DMA_CH1>;
});

static BUFFER: ConstStaticCell<DmaBuffer> = ConstStaticCell::new(DmaBuffer::new());

type Bus = Stopped<Spi<'static, SPI0, Async>>;

/// The sensor.
pub type Radar = Bgt60<Bus, Output<'static>, Output<'static>, Delay>;

/// Empties the SPI's FIFOs: the DMA has stopped, the bytes it had sent come back.
fn stop() {
    let spi = pac::SPI0;
    while spi.sr().read().bsy() {}
    while spi.sr().read().rne() {
        spi.dr().read();
    }
}

/// SPI0 with its DMA channels: SCK, MOSI, MISO.
pub fn spi(
    spi: Peri<'static, SPI0>,
    clock: Peri<'static, PIN_18>,
    to_sensor: Peri<'static, PIN_19>,
    from_sensor: Peri<'static, PIN_16>,
    transmit: Peri<'static, DMA_CH0>,
    receive: Peri<'static, DMA_CH1>,
) -> Bus {
    let mut config = Config::default();
    config.frequency = SPI_HZ;
    Stopped::new(Spi::new(spi, clock, to_sensor, from_sensor, transmit, receive, Interrupts, config), stop)
}

/// The sensor behind the SPI; its pins CS and RST.
pub fn radar(spi: Bus, select: Peri<'static, AnyPin>, reset: Peri<'static, AnyPin>) -> Radar {
    let (select, reset) = (Output::new(select, Level::High), Output::new(reset, Level::High));
    Bgt60::new(spi, select, reset, Delay, REGISTERS, BUFFER.take())
}
