//! sdp3: how many slots must be spent on radar to recognise how a person moves, and what does that cost in throughput?
//!
//! | feature | default | effect |
//! |---|---|---|
//! | `train` | yes | training (burn): `sdp3 run`, `train`, `quantize`, `study`; without it the build takes seconds |
//! | `wgpu` | no | `sdp3 train --backend wgpu`: Vulkan, Metal, DirectX 12, WebGPU |
//! | `cuda` | no | `sdp3 train --backend cuda`; the build downloads an LLVM bundle |
//! | `svm` | no | the support vector machine of `sdp3 study baselines` |
//! | `hdf5` | no | measured signals in HDF5 files |
//!
//! Rust 1.95 or newer. The radar module itself is the crate `sdp3-core`.

// what only the commands that train call
#![cfg_attr(not(feature = "train"), allow(dead_code))]

mod cli;
pub mod conformance;
pub mod dataset;
pub mod error;
pub mod experiments;
pub mod formats;
pub mod network;
pub mod numerics;
pub mod optimizer;
mod pipeline;
pub mod predictor;
mod progress;
pub mod recordings;
pub mod report;
pub mod reproduce;
pub mod results;
pub mod scenario;
mod scheduling;
pub mod schemas;
pub mod simulator;
pub mod store;
pub mod text;

pub use cli::main;

/// Name and version, as files say what made them.
pub const PROGRAM: &str = concat!("sdp3 ", env!("CARGO_PKG_VERSION"));

/// Version, and commit and date where the build knew them.
pub const VERSION: &str = env!("SDP3_VERSION");

/// The commit it was built of, where the build knew it (`host/build.rs`).
pub const COMMIT: Option<&str> = option_env!("SDP3_COMMIT");

/// That commit's date, `YYYY-MM-DD`.
pub const COMMIT_DATE: Option<&str> = option_env!("SDP3_DATE");
