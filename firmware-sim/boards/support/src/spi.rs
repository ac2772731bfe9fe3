//! An SPI of which a transfer may be dropped.

use core::future::Future;
use embedded_hal_async::spi::{ErrorType, SpiBus};

/// Calls `stop` when the future of a transfer is dropped before it is ready: for drivers that then leave the SPI running, or bytes in
/// its FIFO.
pub struct Stopped<S> {
    spi: S,
    stop: fn(),
}

impl<S: SpiBus> Stopped<S> {
    /// `stop` ends a transfer and empties what has been received.
    pub fn new(spi: S, stop: fn()) -> Self {
        Stopped { spi, stop }
    }
}

struct Running(fn());

impl Drop for Running {
    fn drop(&mut self) {
        (self.0)();
    }
}

async fn guard<T>(stop: fn(), transfer: impl Future<Output = T>) -> T {
    let running = Running(stop);
    let ended = transfer.await;
    core::mem::forget(running);
    ended
}

impl<S: SpiBus> ErrorType for Stopped<S> {
    type Error = S::Error;
}

impl<S: SpiBus> SpiBus for Stopped<S> {
    async fn read(&mut self, words: &mut [u8]) -> Result<(), S::Error> {
        guard(self.stop, self.spi.read(words)).await
    }
    async fn write(&mut self, words: &[u8]) -> Result<(), S::Error> {
        guard(self.stop, self.spi.write(words)).await
    }
    async fn transfer(&mut self, read: &mut [u8], write: &[u8]) -> Result<(), S::Error> {
        guard(self.stop, self.spi.transfer(read, write)).await
    }
    async fn transfer_in_place(&mut self, words: &mut [u8]) -> Result<(), S::Error> {
        guard(self.stop, self.spi.transfer_in_place(words)).await
    }
    async fn flush(&mut self) -> Result<(), S::Error> {
        self.spi.flush().await
    }
}
