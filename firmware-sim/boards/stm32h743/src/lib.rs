//! An STM32H743ZI on a Nucleo-H743ZI2, with its radar module: clocks, caches, serial line, sensor, executor of the slots.
#![no_std]

pub mod executor;
pub mod memory;
#[cfg(feature = "bgt60")]
mod sensor;

use cortex_m::peripheral::DWT;
use defmt_rtt as _;
use embassy_stm32::Config;
use embassy_stm32::mode::Blocking;
use embassy_stm32::rcc::{
    AHBPrescaler, APBPrescaler, Hse, HseMode, Pll, PllDiv, PllMul, PllPreDiv, PllSource, Sysclk, VoltageScale,
};
use embassy_stm32::time::Hertz;
use embassy_stm32::usart::{self, UartTx};
use panic_probe as _;
use sdp3_board_support::cycles::extended;
use sdp3_board_support::line::Serial;

/// Bits a second of the serial line.
const BAUD: u32 = 921_600;

/// USART3 on PD8, the serial line of the board's debugger: 8 bits, no parity, one stop bit.
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

/// 400 MHz from the debugger's 8 MHz: the most at which every revision of the chip runs. 200 MHz for the buses and the SPI.
fn clocks() -> Config {
    let mut config = Config::default();
    let rcc = &mut config.rcc;
    rcc.hse = Some(Hse { freq: Hertz(8_000_000), mode: HseMode::Bypass });
    rcc.pll1 = Some(Pll {
        source: PllSource::HSE,
        prediv: PllPreDiv::DIV1,
        mul: PllMul::MUL100,
        fracn: None,
        divp: Some(PllDiv::DIV2),
        divq: Some(PllDiv::DIV4),
        divr: None,
    });
    rcc.sys = Sysclk::PLL1_P;
    rcc.ahb_pre = AHBPrescaler::DIV2;
    rcc.apb1_pre = APBPrescaler::DIV2;
    rcc.apb2_pre = APBPrescaler::DIV2;
    rcc.apb3_pre = APBPrescaler::DIV2;
    rcc.apb4_pre = APBPrescaler::DIV2;
    rcc.voltage_scale = VoltageScale::Scale1;
    config
}

/// Sets clocks, caches and serial line, once.
pub fn board() -> Option<Board> {
    let mut core = cortex_m::Peripherals::take()?;
    memory::enable_caches(&mut core.MPU, &mut core.SCB, &mut core.CPUID);
    core.DCB.enable_trace();
    DWT::unlock();
    core.DWT.enable_cycle_counter();
    let device = embassy_stm32::init(clocks());
    let mut config = usart::Config::default();
    config.baudrate = BAUD;
    let uart = Uart(UartTx::new_blocking(device.USART3, device.PD8, config).ok()?);
    #[cfg(feature = "bgt60")]
    let radar = {
        let (transmit, receive) = (device.DMA1_CH0, device.DMA1_CH1);
        let spi = sensor::spi(device.SPI1, device.PA5, device.PB5, device.PA6, transmit, receive);
        sensor::radar(spi, device.PD14.into(), device.PD15.into())?
    };
    #[cfg(not(feature = "bgt60"))]
    let radar = sdp3_board_support::async_station::recording();
    Some(Board { uart, radar })
}

/// Cycles so far.
pub fn cycle_counter() -> impl FnMut() -> u64 {
    extended(DWT::cycle_count)
}
