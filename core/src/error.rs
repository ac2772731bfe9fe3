//! Why a radar module cannot be made, or a slot is not taken.

use crate::dsn::ModelError;
use crate::scheduler::PlanError;

/// Why a radar module, a pipeline or a plan cannot be made, or a pipeline does not take a slot.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum Error {
    /// A byte string is no model.
    #[error("model: {0}")]
    Model(#[from] ModelError),
    /// Numbers are no plan.
    #[error("plan: {0}")]
    Plan(#[from] PlanError),
    /// A buffer is smaller than the models need.
    #[error("buffer {buffer} has {have} elements; the model needs {need}")]
    Memory {
        /// Name of the buffer.
        buffer: &'static str,
        /// Elements it needs.
        need: usize,
        /// Elements it has.
        have: usize,
    },
    /// Early exits are not 1 to 12 with ascending numbers of slots, do not agree on sensor, preprocessing and classes, or an own
    /// weight rounds to nothing or is beyond its limit.
    #[error("early exits are not ascending, do not agree, or have a weight out of range")]
    Exits,
    /// A period has fewer sensing slots than the first exit needs.
    #[error("a period has {have} sensing slots; the first exit needs {need}")]
    SensingSlots {
        /// Slots the first exit needs.
        need: usize,
        /// Sensing slots of a period.
        have: u32,
    },
    /// A recognition at one step a slot is not over when the next one is due.
    #[error("a recognition needs {need} slots at one step a slot; the next one is due after {have}")]
    Deadline {
        /// Slots a recognition and the slots taken meanwhile need.
        need: u32,
        /// Slots there are.
        have: u32,
    },
    /// A recognition is not yet over: [`Pipeline::step`](crate::pipeline::Pipeline::step) first.
    #[error("a recognition is not yet over")]
    Busy,
    /// The recording is complete: [`Pipeline::reset`](crate::pipeline::Pipeline::reset) begins the next.
    #[error("the recording is complete")]
    Full,
    /// The slot has another number of values than the sensor's configuration says.
    #[error("the slot has another length than the sensor's")]
    Length,
}
