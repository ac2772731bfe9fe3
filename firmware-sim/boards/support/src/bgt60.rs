//! Infineon BGT60TR13C, 60 GHz, over SPI: one antenna, one sweep of 128 samples of 12 bits a slot.
//!
//! The sensor sweeps all the time, once in 250 us of its own clock, into a FIFO of 8192 words. Each slot takes one sweep out, of a
//! sensing slot or not. The two clocks drift apart: one sweep in some seconds is missing, or waits too long and is dropped.
//! The registers must ask for that: frames without end of one chirp of 128 samples of one receiver, 250 us from chirp to chirp.

use crate::front_end::FrontEnd;
use embedded_hal::digital::OutputPin;
use embedded_hal_async::delay::DelayNs;
use embedded_hal_async::spi::SpiBus;

/// Samples of a sweep.
pub const SAMPLES: usize = 128;
/// Words of 24 bits in the FIFO that a sweep takes, two samples each.
const WORDS: usize = SAMPLES / 2;
/// Sweeps in the FIFO from which on one is dropped. One less than this is what jitter around a slot's edge can bring.
const BACKLOG: usize = 3;
/// Bytes of a command and its answer.
const COMMAND: usize = 4;
/// Fastest clock of the SPI in Hz at which a sweep is read in less than a third of a slot.
pub const SPI_HZ: u32 = 25_000_000;

/// What all transfers are read from and written to: memory that the DMA reaches.
///
/// It fills whole cache lines.
#[repr(C, align(32))]
pub struct DmaBuffer([u8; 224]);

impl DmaBuffer {
    /// Zeros.
    #[allow(clippy::new_without_default)] // for a static
    pub const fn new() -> Self {
        const { assert!(COMMAND + 3 * WORDS <= 224) };
        DmaBuffer([0; 224])
    }
}

/// Registers. The vendor's register map has their fields.
mod register {
    pub const MAIN: u8 = 0x00;
    pub const CHIP_ID: u8 = 0x02;
    pub const SFCTL: u8 = 0x06;
    pub const FSTAT: u8 = 0x5F;
    pub const FIFO: u8 = 0x60;
}

/// MAIN: begins a frame.
const FRAME_START: u32 = 1;
/// MAIN: sets all registers to their values after power-on.
const RESET_CHIP: u32 = 1 << 1;
/// MAIN: stops the frames.
const RESET_FRAMES: u32 = 1 << 2;
/// MAIN: empties the FIFO.
const RESET_FIFO: u32 = 1 << 3;
/// CHIP_ID of a BGT60TR13C.
const CHIP: u32 = 0x00_0303;
/// SFCTL: low-power FIFO, MISO on the falling edge.
const STANDARD_SPI: u32 = 0x10_2000;
/// FSTAT: words in the FIFO.
const FILLED: u32 = 0x3FFF;
/// FSTAT: the FIFO ran over or empty, or a transfer had a wrong number of clocks.
const FIFO_ERRORS: u32 = 0x8E_0000;
/// Answer's first byte: the FIFO ran over or empty, a wrong burst, a wrong number of clocks.
const STATUS_ERRORS: u8 = 0x0D;

/// What can go wrong.
#[derive(Debug, Clone, Copy, PartialEq, Eq, defmt::Format)]
pub enum Error {
    /// The SPI or a pin.
    Bus,
    /// The chip's number is another: a wrong chip, or a wire is loose.
    Chip(u32),
    /// The chip does not come back from its reset.
    Reset,
    /// The FIFO ran over or empty, or a transfer was cut; FSTAT, or the status byte of a burst.
    Fifo(u32),
    /// No whole sweep is in the FIFO yet.
    NotReady,
    /// The buffer is not of 128 values.
    Buffer(usize),
}

/// A BGT60TR13C.
pub struct Bgt60<S, C, R, D> {
    spi: S,
    select: C,
    reset: R,
    delay: D,
    registers: &'static [u32],
    dma: &'static mut DmaBuffer,
    /// The FIFO begins with a whole sweep. Not while a burst runs, nor after one that was cut.
    whole: bool,
}

impl<S: SpiBus, C: OutputPin, R: OutputPin, D: DelayNs> Bgt60<S, C, R, D> {
    /// SPI in mode 0, most significant bit first, and the pins CS and RST.
    ///
    /// `registers` is the list that the vendor's tool exports: the address in the upper seven bits, a write bit, 24 bits of data.
    pub fn new(
        spi: S,
        select: C,
        reset: R,
        delay: D,
        registers: &'static [u32],
        dma: &'static mut DmaBuffer,
    ) -> Self {
        Bgt60 { spi, select, reset, delay, registers, dma, whole: false }
    }

    /// Sends and receives the first `bytes` of the buffer.
    async fn transfer(&mut self, bytes: usize) -> Result<(), Error> {
        // a transfer that was dropped has left the chip selected
        self.select.set_high().map_err(|_| Error::Bus)?;
        let data = self.dma.0.get_mut(..bytes).ok_or(Error::Bus)?;
        self.select.set_low().map_err(|_| Error::Bus)?;
        let sent = self.spi.transfer_in_place(data).await;
        self.select.set_high().map_err(|_| Error::Bus)?;
        sent.map_err(|_| Error::Bus)
    }

    /// Sends a command; the 24 bits of the answer.
    async fn command(&mut self, command: u32) -> Result<u32, Error> {
        if let Some(first) = self.dma.0.first_chunk_mut() {
            *first = command.to_be_bytes();
        }
        self.transfer(COMMAND).await?;
        Ok(self.dma.0.first_chunk().map_or(0, |first| u32::from_be_bytes(*first)) & 0xFF_FFFF)
    }

    async fn get(&mut self, register: u8) -> Result<u32, Error> {
        self.command(u32::from(register) << 25).await
    }

    async fn set(&mut self, register: u8, value: u32) -> Result<(), Error> {
        self.command(u32::from(register) << 25 | 1 << 24 | value & 0xFF_FFFF).await?;
        Ok(())
    }

    /// Sets bits of MAIN that the chip clears by itself.
    async fn trigger(&mut self, bits: u32) -> Result<(), Error> {
        let main = self.get(register::MAIN).await?;
        self.set(register::MAIN, main | bits).await
    }

    /// Resets the chip, and waits until it is ready.
    async fn reset(&mut self) -> Result<(), Error> {
        self.select.set_high().map_err(|_| Error::Bus)?;
        for high in [true, false, true] {
            let set = if high { self.reset.set_high() } else { self.reset.set_low() };
            set.map_err(|_| Error::Bus)?;
            self.delay.delay_us(1).await; // at least 100 ns
        }
        self.set(register::SFCTL, STANDARD_SPI).await?;
        let chip = self.get(register::CHIP_ID).await?;
        if chip != CHIP {
            return Err(Error::Chip(chip));
        }
        self.trigger(RESET_CHIP).await?;
        for _ in 0..10 {
            self.delay.delay_ms(10).await;
            if self.get(register::MAIN).await? & RESET_CHIP == 0 {
                return self.set(register::SFCTL, STANDARD_SPI).await;
            }
        }
        Err(Error::Reset)
    }

    /// Empties the FIFO and begins the sweeps again. The first is ready after some slots.
    async fn restart(&mut self) -> Result<(), Error> {
        self.trigger(RESET_FRAMES).await?;
        self.trigger(RESET_FIFO).await?;
        self.trigger(FRAME_START).await?;
        self.whole = true;
        Ok(())
    }

    /// Reads a sweep out of the FIFO into the DMA's buffer.
    async fn burst(&mut self) -> Result<(), Error> {
        self.whole = false;
        let command = 0xFF << 24 | u32::from(register::FIFO) << 17; // as many words as there are clocks
        if let Some(first) = self.dma.0.first_chunk_mut() {
            *first = command.to_be_bytes();
        }
        self.transfer(COMMAND + 3 * WORDS).await?;
        let status = self.dma.0.first().copied().unwrap_or_default();
        if status & STATUS_ERRORS != 0 {
            return Err(Error::Fifo(u32::from(status)));
        }
        self.whole = true;
        Ok(())
    }

    /// Takes the next sweep out of the FIFO.
    async fn sweep(&mut self) -> Result<(), Error> {
        if !self.whole {
            self.restart().await?;
            return Err(Error::NotReady);
        }
        let state = self.get(register::FSTAT).await?;
        if state & FIFO_ERRORS != 0 {
            self.whole = false;
            return Err(Error::Fifo(state));
        }
        let words = (state & FILLED) as usize;
        if words < WORDS {
            return Err(Error::NotReady);
        }
        if words >= BACKLOG * WORDS {
            self.burst().await?;
        }
        self.burst().await
    }
}

/// Samples of a FIFO's words: two a word of 24 bits, the first in the upper half; 0 to 4095 becomes -2048 to 2047.
fn unpack(words: &[u8], samples: &mut [i16]) {
    for (pair, word) in samples.as_chunks_mut().0.iter_mut().zip(words.as_chunks().0) {
        let [a, b, c] = word.map(i16::from);
        *pair = [(a << 4 | b >> 4) - 2048, ((b & 15) << 8 | c) - 2048];
    }
}

impl<S: SpiBus, C: OutputPin, R: OutputPin, D: DelayNs> FrontEnd for Bgt60<S, C, R, D> {
    type Error = Error;

    async fn start(&mut self) -> Result<(), Error> {
        self.whole = false;
        self.reset().await?;
        for word in self.registers {
            self.set((word >> 25) as u8, *word).await?;
        }
        self.restart().await
    }

    async fn read(&mut self, buffer: &mut [i16]) -> Result<(), Error> {
        if buffer.len() != SAMPLES {
            return Err(Error::Buffer(buffer.len()));
        }
        self.sweep().await?;
        unpack(self.dma.0.get(COMMAND..).unwrap_or_default(), buffer);
        Ok(())
    }

    async fn skip(&mut self) -> Result<(), Error> {
        self.sweep().await
    }
}
