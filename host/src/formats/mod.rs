//! formats
pub mod model_file;
