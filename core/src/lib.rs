//! The radar module of sdp3: from the samples of a sensing slot to the class of a human motion, and the schedule that says which
//! slot senses. `no_std`, no allocation, the same bits on every processor.
//!
//! # The signal chain
//!
//! A radio shares its slots between communication and sensing. In a sensing slot the radar sends one FMCW sweep. Its samples
//! become at most eight range samples; those of N_s slots form the beat matrix, of which the strongest singular components are
//! clutter. What is left is summed to one slow-time signal. Its spectrogram is an image that an int8 network classifies.
//!
//! ```text
//! samples of a slot, i16        for example [1000] I/Q at 10 MHz
//!    | signal::fast_time        times the conjugate chirp, summed in blocks; or the gate of a sensor that dechirps
//! range samples                 [range = 8]                  complex i32
//!    | signal::clutter          Gram matrix, leading eigenvectors, projection
//! slow time                     [slow_time = N_s]            complex i32
//!    | signal::stft             Kaiser window, 256-point FFT, every 8 slots
//! spectrum                      [doppler = 256]              complex f32 or i32
//!    | signal::spectrogram      64 log2 of the power, quantised over 50 dB
//! image                         [64, frames]                 i8
//!    | dsn                      residual network
//! logits, class, confidence     [classes]                    i8
//! ```
//!
//! # Two contexts
//!
//! [`radar`] is what firmware uses: [`radar::SlotContext`] in the slot interrupt, short and bounded; [`radar::ProcessingContext`]
//! in a task that is polled, one bounded step a call. Early exits, supervision and recovery after a reset are inside.
//! [`pipeline`] is the signal chain alone, [`scheduler`] the schedule alone. [`config`] describes the sensor.
//!
//! With the feature `graph` the module `graph` runs any other int8 network, also in the place of the paper's.
//!
//! # Numbers
//!
//! Range samples, Gram matrix, projection, log magnitudes, the network and the schedule are integers. The eigenvectors and one of the two
//! FFTs are f32, written with `+ - * /` and `libm` only, in one fixed order: they have the same bits on every IEEE 754 processor
//! with flush-to-zero off, with or without an FPU. On microcontrollers the FFT is the other one, in integers
//! ([`signal::stft::NativeStft`]). `ranges` proves at compile time that no sum outgrows its word.
//!
//! # Rules
//!
//! Everything from outside is checked once ([`dsn::Model::parse`], [`radar::RadarModule::new`], [`scheduler::SensingLayout::new`]);
//! after that nothing can fail for reasons of data. No call panics, allocates or loops without a bound. Memory is the caller's, in
//! one type of constant size. Unsafe code is denied but for the instructions of Arm and of RISC-V, in one module
//! of [`simd`] each, which have portable references with the same bits. [`probe`] shows every stage's values to an observer, [`digest`]
//! folds them to one number a stage.
#![no_std]
#![deny(unsafe_code)]
#![deny(missing_docs)]

pub mod areas;
pub mod config;
pub mod crc32;
pub mod digest;
pub mod dims;
pub mod dsn;
pub mod early_exit;
mod error;
pub mod fixed;
#[cfg(feature = "graph")]
pub mod graph;
pub mod math;
pub mod pipeline;
pub mod probe;
pub mod radar;
mod ranges;
pub mod scheduler;
pub mod selftest;
pub mod signal;
pub mod simd;
pub mod supervision;
pub mod values;

pub use dsn::Shape;
pub use error::Error;
pub use radar::{Event, ProcessingContext, Progress, RadarModule, Settings, SlotAction, SlotContext};
pub use scheduler::SensingLayout;
pub use supervision::retained::Retained;
