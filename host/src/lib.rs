//! sdp3: how many slots must be spent on radar to recognise how a person moves, and what does that cost in throughput?
//!
//! | feature | default | effect |
//! |---|---|---|
//! | `cli` | yes | the command `sdp3`: its studies, pages and figures; without it, the library below them |
//! | `train` | yes | training (burn): `sdp3 run`, `train`, `quantize`, `study`, and the module `train`; without it the build takes seconds |
//! | `wgpu` | no | `sdp3 train --backend wgpu`: Vulkan, Metal, DirectX 12, WebGPU |
//! | `cuda` | no | `sdp3 train --backend cuda`; the build downloads an LLVM bundle |
//! | `svm` | no | the support vector machine of `sdp3 study baselines` |
//! | `hdf5` | yes | measured signals in HDF5 files, and in MATLAB files of version 7.3 |
//!
//! Rust 1.95 or newer. The radar module itself is the crate `sdp3-core`.

// what only the commands call, or those that train
#![cfg_attr(not(all(feature = "cli", feature = "train")), allow(dead_code))]

#[cfg(feature = "cli")]
mod cli;
#[cfg(feature = "cli")]
pub mod conformance;
pub mod dataset;
pub mod error;
#[cfg(feature = "cli")]
pub mod experiments;
pub mod formats;
pub mod network;
pub mod numerics;
pub mod optimizer;
#[cfg(any(feature = "cli", feature = "train"))]
mod pipeline;
pub mod predictor;
mod progress;
pub mod recordings;
#[cfg(feature = "cli")]
pub mod report;
#[cfg(feature = "cli")]
pub mod reproduce;
pub mod results;
pub mod scenario;
#[cfg(feature = "cli")]
mod scheduling;
#[cfg(feature = "cli")]
pub mod schemas;
pub mod simulator;
pub mod store;
pub mod text;
#[cfg(feature = "train")]
pub mod train;

#[cfg(feature = "cli")]
pub use cli::main;

/// Name and version, as files say what made them.
pub const PROGRAM: &str = concat!("sdp3 ", env!("CARGO_PKG_VERSION"));

/// Version, and commit and date where the build knew them.
pub const VERSION: &str = env!("SDP3_VERSION");

/// The commit it was built of, where the build knew it (`host/build.rs`).
pub const COMMIT: Option<&str> = option_env!("SDP3_COMMIT");

/// That commit's date, `YYYY-MM-DD`.
pub const COMMIT_DATE: Option<&str> = option_env!("SDP3_DATE");
