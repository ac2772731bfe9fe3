//! Files on disk: written whole or not at all, read up to a limit, resumed only by the command that began them.

pub(crate) mod limited;
pub mod output;
pub(crate) mod resume;
