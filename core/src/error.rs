//! Why a radar module cannot be made.

use crate::dsn::ModelError;
use crate::scheduler::PlanError;

/// Why a radar module, a pipeline or a plan cannot be made.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum Error {
    /// A byte string is no model.
    Model(ModelError),
    /// Numbers are no plan.
    Plan(PlanError),
    /// A buffer is smaller than the models need.
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
    Exits,
    /// A period has fewer sensing slots than the first exit needs.
    SensingSlots {
        /// Slots the first exit needs.
        need: usize,
        /// Sensing slots of a period.
        have: u32,
    },
    /// A recognition at one step a slot is not over when the next one is due.
    Deadline {
        /// Slots a recognition and the slots taken meanwhile need.
        need: u32,
        /// Slots there are.
        have: u32,
    },
}

impl core::fmt::Display for Error {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match *self {
            Error::Model(error) => write!(f, "model: {error}"),
            Error::Plan(error) => write!(f, "plan: {error}"),
            Error::Memory { buffer, need, have } => {
                write!(f, "buffer {buffer} has {have} elements; the model needs {need}")
            }
            Error::Exits => {
                write!(f, "early exits are not ascending, do not agree, or have a weight out of range")
            }
            Error::SensingSlots { need, have } => {
                write!(f, "a period has {have} sensing slots; the first exit needs {need}")
            }
            Error::Deadline { need, have } => {
                write!(
                    f,
                    "a recognition needs {need} slots at one step a slot; the next one is due after {have}"
                )
            }
        }
    }
}

impl core::error::Error for Error {}

impl From<ModelError> for Error {
    fn from(error: ModelError) -> Self {
        Error::Model(error)
    }
}

impl From<PlanError> for Error {
    fn from(error: PlanError) -> Self {
        Error::Plan(error)
    }
}
