//! A radar module in two contexts: what must happen at a slot boundary, and everything else.
//!
//! [`SlotContext`] belongs to the slot interrupt: which use has this slot, samples are ready, a slot is lost. Every call is short
//! and bounded and never waits. [`ProcessingContext`] belongs to a task or the idle loop and is polled: each call does one bounded
//! step of dechirp, clutter removal, spectrogram, network, planning or model check. The two share queues with one producer and one
//! consumer each, without locks, and one word by which processing ends a period's sensing early.
//!
//! ```text
//!  slot interrupt                                                    task
//!  SlotContext   -- filled slot buffers, faults, period reports -->   ProcessingContext
//!                <-- free slot buffers, plans, end of sensing ------
//! ```
//!
//! A recognition may go on while the next period senses. [`RadarModule::new`] refuses what cannot be in time even if a step took
//! a whole slot.

mod memory;
mod processing_context;
mod slot_context;

pub use memory::{RadarMemory, SlotBuffer};
pub use processing_context::{Event, ProcessingContext, Progress};
pub use slot_context::{SlotAction, SlotContext};

use crate::dims::BEATS;
use crate::dsn::{Model, Shape};
use crate::early_exit::EarlyExit;
use crate::error::Error;
use crate::scheduler::{PeriodCounts, Planner, SensingLayout, USERS};
use crate::signal::front_end::slow_time_steps;
use crate::signal::stft::{NativeStft, Stft};
use crate::supervision::Fault;
use crate::supervision::retained::Retained;
use memory::{Made, ProcessingEnds, SlotEnds};
use processing_context::CHECK_BYTES;

/// Slot buffers of a module: one that is being filled, and the others waiting.
pub const SLOT_BUFFERS: usize = 3;

/// What a module does.
#[derive(Debug, Clone, Copy)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Settings {
    /// N, N_m and N_s.
    pub layout: SensingLayout,
    /// Bits that a slot carries to each downlink user, 0 for an absent one.
    pub rates: [u32; USERS],
    /// Confidence that ends a period's sensing early; above 1 for never before the last exit.
    pub threshold: f32,
}

/// Samples of a sensing slot on their way to processing.
#[derive(Debug)]
struct Filled<const VALUES: usize> {
    period: u32,
    /// Number of the sensing slot in its period, from 0.
    index: u32,
    /// Sensing slots of the period behind it.
    left: u32,
    buffer: &'static mut SlotBuffer<VALUES>,
}

/// What the slot context reports.
#[derive(Debug)]
enum Report {
    Fault(Fault),
    /// A period begins.
    Period {
        period: u32,
        replanned: bool,
        counts: PeriodCounts,
    },
    /// A period's sensing has ended early.
    Released {
        period: u32,
        rest: u32,
        /// Slots each user has had.
        served: [u32; USERS],
    },
    /// Nothing, or only the running plan, is known: a plan is needed.
    PlanNeeded,
}

/// Totals of each user at the end of a period.
#[derive(Debug)]
struct Totals {
    period: u32,
    totals: [u32; USERS],
}

impl Shape {
    /// Values of a slot buffer.
    pub const fn slot_values(&self) -> usize {
        self.radar.values_per_slot()
    }
}

/// A radar module, to be split into its two contexts.
pub struct RadarModule<const VALUES: usize, T: Stft + 'static = NativeStft> {
    slots: SlotContext<VALUES>,
    processing: ProcessingContext<VALUES, T>,
}

impl<const VALUES: usize, T: Stft> RadarModule<VALUES, T> {
    /// Joins models, fewest sensing slots first, memory and what survived a reset in `retained`. Cost: one inference by each exit, which
    /// counts its steps. No slot is played meanwhile: after a reset that is usually an [`Outage`](Fault::Outage), and a period begins.
    ///
    /// # Errors
    ///
    /// [`Error`] names what does not fit: models, memory, plan, or time. The memory stays taken.
    pub fn new<
        const REFERENCE: usize,
        const SLOTS: usize,
        const WORKSPACE: usize,
        const I16X8S: usize,
        const WORDS: usize,
    >(
        exits: &[EarlyExit<'static>],
        settings: Settings,
        memory: &'static mut RadarMemory<VALUES, REFERENCE, SLOTS, WORKSPACE, I16X8S, WORDS, T>,
        retained: &'static Retained,
    ) -> Result<Self, Error> {
        let (pipeline, links) = memory.split();
        Self::join(pipeline.make(exits, settings.threshold)?, links, settings, retained)
    }

    /// Contexts for a pipeline.
    #[inline(never)] // they do not lie under the pipeline's making
    fn join(
        pipeline: &'static mut Made<T>,
        links: (SlotEnds<VALUES>, ProcessingEnds<VALUES>),
        settings: Settings,
        retained: &'static Retained,
    ) -> Result<Self, Error> {
        let values = pipeline.config().values_per_slot();
        if values != VALUES {
            return Err(Error::Memory { buffer: "slot buffer", need: values, have: VALUES });
        }
        let (need, have) = (pipeline.first_exit_slots(), settings.layout.slots());
        if (have as usize) < need {
            return Err(Error::SensingSlots { need, have });
        }
        pipeline.count_steps();
        in_time(pipeline, settings.layout)?;
        let planner = Planner::new(settings.layout, settings.rates);
        let (slot_ends, processing_ends) = links;
        let slots = SlotContext::new(slot_ends, retained, &planner.first_plan());
        Ok(RadarModule { slots, processing: ProcessingContext::new(pipeline, planner, processing_ends) })
    }

    /// [`RadarModule::new`] with the file of one model, which is asked when all its sensing slots have been taken.
    ///
    /// # Errors
    ///
    /// As [`RadarModule::new`], and [`Error::Model`].
    pub fn single<
        const REFERENCE: usize,
        const SLOTS: usize,
        const WORKSPACE: usize,
        const I16X8S: usize,
        const WORDS: usize,
    >(
        model: &'static [u8],
        settings: Settings,
        memory: &'static mut RadarMemory<VALUES, REFERENCE, SLOTS, WORKSPACE, I16X8S, WORDS, T>,
        retained: &'static Retained,
    ) -> Result<Self, Error> {
        Self::new(&[EarlyExit::single(Model::parse(model)?)], settings, memory, retained)
    }

    /// The two contexts.
    pub fn split(self) -> (SlotContext<VALUES>, ProcessingContext<VALUES, T>) {
        (self.slots, self.processing)
    }
}

/// Whether every recognition is over before the next one is due, at one step of processing a slot.
///
/// Between two exits with n sensing slots, and behind the last until the period's end and the next recording's first exit, there
/// are n (N_m + 1) slots; in each a step of processing can be done, less one for each sensing slot's own.
fn in_time<T: Stft>(pipeline: &Made<T>, layout: SensingLayout) -> Result<(), Error> {
    let slots = |exit: &EarlyExit<'_>| exit.model.sensing_slots();
    let (step, total) = (layout.spacing() as usize + 1, layout.slots() as usize);
    let (first, most) = (pipeline.first_exit_slots(), pipeline.exits().last().map_or(0, slots));
    let fits = |need: usize, have: usize| {
        if need > have { Err(Error::Deadline { need: need as u32, have: have as u32 }) } else { Ok(()) }
    };
    // exits that a period reaches
    let exits = pipeline.exits().iter().zip(&pipeline.steps);
    let mut reached = exits.take_while(|(exit, _)| slots(exit) <= total).peekable();
    while let Some((exit, &steps)) = reached.next() {
        let taken = slots(exit);
        let rest = (layout.period() as usize).saturating_sub(taken * step);
        let (between, sensing) = match reached.peek() {
            Some((next, _)) => ((slots(next) - taken) * step, slots(next) - taken),
            // what is left of the period, and the next one up to its first exit
            None => {
                // of which the first wait in memory of the slow time until that is made
                let (waiting, kept) = (first.min(most / BEATS), exit.model.preprocessing().kept);
                fits(slow_time_steps(kept, taken) + total - taken + waiting, rest + waiting * step)?;
                (rest + first * step, total - taken + first)
            }
        };
        let check = exit.model.bytes().len().div_ceil(CHECK_BYTES) + 1;
        fits(steps as usize + check + sensing, between)?;
    }
    Ok(())
}
