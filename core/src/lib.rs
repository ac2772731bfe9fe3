//! The radar module of sdp3: from raw samples of a sensing slot to the class of a human motion, and the scheduler
//! that decides which slot senses. `no_std`, no allocation, the same bits on every processor.
//!
//! # The street
//!
//! Data walks down one street; each file takes what the previous one gives and none looks back.
//!
//! ```text
//! slot (1000 x i16 I/Q)
//!   dechirp      times the conjugate chirp, summed in eight blocks       -> beat [8] i32
//!   clutter      exact Gram matrix, leading eigenvectors, w; y = w^H b    -> slow time [N_s] i32
//!   stft         Kaiser window, 256-point FFT                             -> spectrum [256] f32 or i32
//!   spectrogram  exact integer logarithm, 50 dB of grey                   -> image [64, frames] i8
//!   dsn          int8 residual network                                    -> logits, class, confidence
//! ```
//!
//! [`front_end`] is the street up to the image, [`receiver`] the whole of it as one object: push a slot, ask for a
//! class; [`anytime`] asks on the way and stops when it is sure. [`schedule`] divides a period between sensing and the
//! receivers; [`station`] joins scheduler and receiver: one call per slot. [`guard`] stands between them and a world that
//! loses slots, skips numbers and flips bits. The ground they stand on: [`frame`] (sizes), [`fixed`] (the rounding rule of
//! int8), [`math`] (the only door to floats), `ranges` (that no sum outgrows its word, proved when it is compiled).
//! [`probe`] lets an observer see every stage's values, [`mod@values`] gives them as bytes, [`digest`] folds them to one
//! number per stage, and [`selftest`] runs the street on a seeded signal whose digest is known.
//!
//! # Which numbers are whose
//!
//! Dechirp, Gram matrix, projection, grey levels, the int8 network and the schedule are defined in integers. The
//! eigenvectors and the FFT are f32, written with `+ - * /` and `libm` only, in one fixed order: they too have the
//! same bits on every IEEE 754 processor with flush-to-zero off, with or without an FPU. On microcontrollers
//! the FFT is by default another one, in integers: [`stft::NativeStft`].
//!
//! # Rules of the house
//!
//! Unsafe code is denied but in one module of [`simd`] for each family of processors, the vector instructions of x86-64
//! and the DSP and Helium instructions of Arm; each has a portable twin and a test that runs both.
//! Everything from outside is checked once ([`dsn::Model::parse`], [`receiver::Receiver::new`],
//! [`schedule::Plan::new`]); after that no call can fail for reasons of data. Memory is the caller's
//! ([`receiver::Memory`]) and its size is a constant.
#![no_std]
#![deny(unsafe_code)]
#![deny(missing_docs)]

pub mod crc32;
pub mod digest;
pub mod dims;
pub mod dsn;
pub mod early_exit;
pub mod fixed;
pub mod math;
pub mod pipeline;
pub mod probe;
mod ranges;
pub mod scheduler;
pub mod selftest;
pub mod signal;
pub mod simd;
pub mod state;
pub mod station;
pub mod supervision;
pub mod values;

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
