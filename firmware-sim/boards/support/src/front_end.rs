//! Where the samples of a slot come from: a radar sensor, or a recording.

use crate::recording::Recording;
use core::convert::Infallible;

/// A source of samples, one sweep a slot.
///
/// The future of a call may be dropped before it is ready: the next slot has begun. An implementation goes on from there.
#[allow(async_fn_in_trait)] // boards have one executor each: no future is sent
pub trait FrontEnd {
    /// What went wrong.
    type Error: defmt::Format;

    /// Sets the sensor up; its sweeps begin. Not limited in time.
    async fn start(&mut self) -> Result<(), Self::Error>;

    /// Fills the buffer with the values of one sweep, as the model's radar configuration describes them.
    async fn read(&mut self, buffer: &mut [i16]) -> Result<(), Self::Error>;

    /// A slot that does not sense: a sensor that sweeps all the time drops one.
    async fn skip(&mut self) -> Result<(), Self::Error> {
        Ok(())
    }
}

impl FrontEnd for Recording {
    type Error = Infallible;

    async fn start(&mut self) -> Result<(), Infallible> {
        Ok(())
    }

    async fn read(&mut self, buffer: &mut [i16]) -> Result<(), Infallible> {
        self.play(buffer);
        Ok(())
    }
}
