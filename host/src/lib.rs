//! sdp3: how many slots must be spent on radar to recognise how a person moves, and what does that cost in throughput?
pub mod conformance;
pub mod formats;
pub mod optimizer;
pub mod output;
pub mod pipeline;
pub mod predictor;
pub mod progress;
pub mod report;
pub mod results;
pub mod scenario;
pub mod simulator;
#[cfg(feature = "train")]
pub mod studies;
