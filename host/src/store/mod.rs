//! Files on disk: written whole or not at all, read up to a limit, resumed only by the command that began them.
//!
//! A folder says what it is for ([`resume`]). A result that is kept says what it belongs to and whether it is whole ([`record`]).

pub(crate) mod difference;
pub(crate) mod digest;
pub(crate) mod file_record;
pub(crate) mod limited;
pub mod output;
pub(crate) mod partial;
pub(crate) mod record;
pub(crate) mod resume;
