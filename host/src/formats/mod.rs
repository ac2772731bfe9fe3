//! File formats: what other programs write and read.

pub mod graph_file;
pub mod model_file;
pub(crate) mod numpy;
pub mod points;
pub mod slots;
pub mod table;
pub mod tflite;
