//! The slot interrupt as a task of an executor that runs in an interrupt of high priority.

use crate::front_end::FrontEnd;
use crate::run::Run;
use embassy_futures::select::{Either, select};
use embassy_time::{Duration, Instant, Timer};
use sdp3_core::radar::{SlotAction, SlotContext};

/// A slot in microseconds.
pub const SLOT_US: u64 = 250;

/// Where slots begin.
#[allow(async_fn_in_trait)] // boards have one executor each: no future is sent
pub trait SlotClock {
    /// Waits for the next slot; its number. Numbers of slots that have begun unseen are skipped.
    ///
    /// A future that is dropped before it is ready has no effect.
    async fn next(&mut self) -> u32;
}

/// Slots of so many microseconds of the time driver, which must count in microseconds.
pub struct TimeDriver<const US: u64> {
    next: Instant,
    number: u32,
}

impl<const US: u64> TimeDriver<US> {
    /// The first slot begins when it is asked for.
    #[allow(clippy::new_without_default)] // reads the clock
    pub fn new() -> Self {
        const { assert!(embassy_time::TICK_HZ == 1_000_000, "the time driver's ticks are no microseconds") };
        TimeDriver { next: Instant::now(), number: 0 }
    }
}

impl<const US: u64> SlotClock for TimeDriver<US> {
    async fn next(&mut self) -> u32 {
        let slot = Duration::from_micros(US);
        while self.next + slot <= Instant::now() {
            (self.next, self.number) = (self.next + slot, self.number.wrapping_add(1));
        }
        Timer::at(self.next).await;
        let number = self.number;
        (self.next, self.number) = (self.next + slot, number.wrapping_add(1));
        number
    }
}

/// Starts the front end, then does what each slot is for. A transfer ends with its slot at the latest.
pub async fn run<const VALUES: usize>(
    mut slots: SlotContext<VALUES>,
    mut clock: impl SlotClock,
    mut front_end: impl FrontEnd,
    counts: &Run,
) -> ! {
    while let Err(error) = front_end.start().await {
        defmt::error!("front end: {}", error);
        Timer::after(Duration::from_secs(1)).await;
    }
    let mut number = clock.next().await;
    loop {
        counts.begin();
        let next = match slots.begin(number) {
            SlotAction::Sense(buffer) => {
                let ended = select(front_end.read(&mut buffer.0), clock.next()).await;
                if let Either::First(Ok(())) = ended {
                    slots.samples_ready();
                }
                ended
            }
            // the radio is not part of this program
            SlotAction::Serve(_) | SlotAction::Idle => select(front_end.skip(), clock.next()).await,
        };
        let next = match next {
            Either::First(ended) => {
                if let Err(error) = ended {
                    defmt::warn!("slot {}: {}", number, error);
                }
                clock.next().await
            }
            Either::Second(next) => {
                defmt::warn!("slot {}: the front end was cut short", number);
                next
            }
        };
        if next != number.wrapping_add(1) {
            counts.late();
        }
        number = next;
    }
}
