//! File formats: what other programs write and read.

pub mod model_file;
pub(crate) mod numpy;
pub mod points;
pub mod slots;
pub(crate) mod table;
pub mod tflite;
