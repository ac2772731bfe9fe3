//! An STM32F405 with its radar module: clocks, serial line, slot timer.
#![no_std]

use cortex_m::peripheral::syst::SystClkSource;
use cortex_m::peripheral::{DCB, DWT, SCB, SYST};
use defmt_rtt as _;
use panic_probe as _;
use sdp3_board_support::cycles::extended;
use sdp3_board_support::interrupt_station::SlotTimer;
use sdp3_board_support::line::Serial;
use stm32f4xx_hal::pac;
use stm32f4xx_hal::pac::{Peripherals, USART1};
use stm32f4xx_hal::prelude::*;
use stm32f4xx_hal::rcc::{Config, Rcc};
use stm32f4xx_hal::serial::{self, config::StopBits};

/// Frequency of the crystal in MHz.
const CRYSTAL_MHZ: u32 = 8;
/// The processor's clock in MHz.
const CLOCK_MHZ: u32 = 168;
/// Bits a second of the serial line.
const BAUD: u32 = 921_600;
/// A slot in microseconds.
const SLOT_US: u32 = 250;

/// USART1 on PA9: 8 bits, no parity, one stop bit.
pub struct Uart(serial::Tx<USART1>);

impl Serial for Uart {
    fn send(&mut self, byte: u8) {
        while self.0.write(byte).is_err() {}
    }
}

/// What a program uses of the board.
pub struct Board {
    /// The serial line.
    pub uart: Uart,
    /// The slot timer, off.
    pub timer: SysTick,
}

/// 168 MHz from the crystal.
///
/// After a reset the internal oscillator says that it is ready. QEMU's machine has no clock control: nothing ever becomes ready, and
/// its processor runs with 168 MHz from the start.
fn clocks(rcc: pac::RCC) -> Rcc {
    if rcc.cr().read().hsirdy().bit_is_set() {
        rcc.freeze(Config::hse(CRYSTAL_MHZ.MHz()).sysclk(CLOCK_MHZ.MHz()))
    } else {
        rcc.constrain()
    }
}

/// Sets clocks, serial line and cycle counter, once.
pub fn board() -> Option<Board> {
    set_up(Peripherals::take()?, cortex_m::Peripherals::take()?)
}

/// Sets clocks, serial line and cycle counter.
pub fn set_up(device: Peripherals, mut core: cortex_m::Peripherals) -> Option<Board> {
    let mut rcc = clocks(device.RCC);
    let pins = device.GPIOA.split(&mut rcc);
    let config = serial::Config::default().baudrate(BAUD.bps()).stopbits(StopBits::STOP1);
    let uart = device.USART1.tx(pins.pa9, config, &mut rcc).ok()?;
    enable(&mut core.DCB, &mut core.DWT);
    Some(Board { uart: Uart(uart), timer: SysTick(core.SYST) })
}

fn enable(debug: &mut DCB, cycles: &mut DWT) {
    debug.enable_trace();
    cycles.enable_cycle_counter();
}

/// SysTick, which begins a slot each time it has counted down.
pub struct SysTick(SYST);

impl SlotTimer for SysTick {
    fn start(&mut self) -> bool {
        self.0.set_clock_source(SystClkSource::Core);
        self.0.set_reload(CLOCK_MHZ * SLOT_US - 1);
        self.0.clear_current();
        self.0.enable_interrupt();
        self.0.enable_counter();
        true
    }

    fn late(&self) -> bool {
        SCB::is_pendst_pending()
    }
}

/// Cycles so far.
pub fn cycle_counter() -> impl FnMut() -> u64 {
    extended(DWT::cycle_count)
}
