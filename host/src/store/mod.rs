//! Files on disk: written whole or not at all, read up to a limit, resumed only by the command that began them.

pub mod limited;
pub mod output;
pub mod resume;
