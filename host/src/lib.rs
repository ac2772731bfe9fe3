//! sdp3
pub mod conformance;
pub mod formats;
pub mod optimizer;
pub mod predictor;
pub mod report;
pub mod results;
pub mod scenario;
pub mod simulator;
