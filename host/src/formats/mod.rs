//! File formats: what the outside world writes and reads.

pub mod dataset;
pub mod measured;
pub mod model_file;
pub mod numpy;
pub mod points;
pub mod slots;
pub mod tflite;
