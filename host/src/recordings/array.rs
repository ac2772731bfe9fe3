//! What an array of numbers may mean, by its shape.
//!
//! | numbers | shape | meaning |
//! |---|---|---|
//! | real | `[time]` | a CW sensor |
//! | real | `[time, 2]` | I and Q of one range cell |
//! | complex | `[time]` | one range cell |
//! | complex | `[time, cell]` | range cells; the one in which most moves is taken |
//! | complex | `[frame, sweep, cell]` | a pulsed radar; the sweeps of a frame are averaged |
//! | int16 | `[slot, samples, 2]` | raw FMCW slots, I and Q |
//! | int16 | `[slot, samples]` | raw FMCW slots of a real converter |

use super::{Contents, MeasuredError, Samples, Source};
use crate::formats::slots::Slots;
use crate::results::About;
use rustfft::num_complex::Complex64;
use std::ops::RangeInclusive;

/// Legal shapes, for errors.
const SHAPES: &str = "real [time] or [time, 2], complex [time], [time, cell] or [frame, sweep, cell], int16 [slot, samples, 2] or [slot, samples] with \
     64 to 2048 samples";

/// Samples that a sweep may have.
pub(super) const SAMPLES: RangeInclusive<usize> = 64..=2048;

/// Numbers of an array.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Numbers {
    Int16(Vec<i16>),
    Real(Vec<f64>),
    Complex(Vec<Complex64>),
}

/// Numbers in row-major order.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Array {
    pub shape: Vec<usize>,
    pub numbers: Numbers,
}

/// The shape as sizes, none empty, with no more numbers than can be read.
pub(super) fn checked_shape(source: Source, shape: &[u64]) -> Result<Vec<usize>, MeasuredError> {
    let all = shape.iter().fold(1_u64, |all, &n| all.saturating_mul(n));
    if all == 0 {
        return Err(source.value("shape", format!("{shape:?}"), "at least 1 number"));
    }
    source.fits("shape", format!("{shape:?}"), all)?;
    Ok(shape.iter().map(|&n| n as usize).collect())
}

impl Array {
    /// The array of a file of this format as samples.
    pub(super) fn contents(self, source: Source, format: &str) -> Result<Contents, MeasuredError> {
        let all: usize = self.shape.iter().product();
        let read = match &self.numbers {
            Numbers::Int16(values) => values.len(),
            Numbers::Real(values) => values.len(),
            Numbers::Complex(values) => values.len(),
        };
        if read != all {
            return Err(source.value("numbers", read, format!("{all}, as the shape says")));
        }
        let cells = matches!(self.numbers, Numbers::Complex(_));
        let shape = self.shape.clone();
        let samples = match (self.numbers, self.shape.as_slice()) {
            (Numbers::Int16(values), &[_, samples, 2]) if SAMPLES.contains(&samples) => {
                Samples::Slots(Slots { values, per_slot: 2 * samples })
            }
            (Numbers::Int16(values), &[_, samples]) if SAMPLES.contains(&samples) => {
                Samples::Slots(Slots { values, per_slot: samples })
            }
            (Numbers::Int16(values), shape @ (&[_] | &[_, 2])) => {
                real(values.into_iter().map(f64::from).collect(), shape)
            }
            (Numbers::Real(values), shape @ (&[_] | &[_, 2])) => real(values, shape),
            (Numbers::Complex(values), &[_]) => Samples::Complex(values),
            (Numbers::Complex(values), &[_, cells]) => Samples::Complex(max_variance_cell(&values, cells)),
            (Numbers::Complex(values), &[_, sweeps, cells]) => {
                Samples::Complex(max_variance_cell(&mean_sweep(&values, sweeps, cells), cells))
            }
            (_, shape) => return Err(source.value("shape", format!("{shape:?}"), SHAPES)),
        };
        let axes = match (&samples, shape.len()) {
            (Samples::Slots(_), 3) => "[slot, sample], int16, I and Q",
            (Samples::Slots(_), _) => "[slot, sample], int16",
            (Samples::Real(_), _) => "[time], real",
            (Samples::Complex(_), 2) if cells => {
                "[time, cell], complex; the cell of largest variance is taken"
            }
            (Samples::Complex(_), 3) => {
                "[frame, sweep, cell], complex; of the mean sweep the cell of largest variance is taken"
            }
            (Samples::Complex(_), _) => "[time], complex",
        };
        Ok(Contents { samples, rate_hz: None, carrier_hz: None, about: About::new(format, axes, shape) })
    }
}

fn real(values: Vec<f64>, shape: &[usize]) -> Samples {
    match shape {
        [_] => Samples::Real(values),
        _ => Samples::Complex(values.as_chunks::<2>().0.iter().map(|&[i, q]| Complex64::new(i, q)).collect()),
    }
}

/// Mean over the sweeps of each frame.
fn mean_sweep(values: &[Complex64], sweeps: usize, cells: usize) -> Vec<Complex64> {
    let frame = |frame: &[Complex64]| -> Vec<Complex64> {
        let cell = |c: usize| frame.iter().skip(c).step_by(cells).sum::<Complex64>() / sweeps as f64;
        (0..cells).map(cell).collect()
    };
    values.chunks_exact(sweeps * cells).flat_map(frame).collect()
}

/// The cell of largest variance.
fn max_variance_cell(values: &[Complex64], cells: usize) -> Vec<Complex64> {
    let cell = |c: usize| values.iter().skip(c).step_by(cells).copied();
    let variance = |c: usize| {
        let n = (values.len() / cells) as f64;
        let mean = cell(c).sum::<Complex64>() / n;
        cell(c).map(|z| (z - mean).norm_sqr()).sum::<f64>() / n
    };
    let best = (0..cells).max_by(|&a, &b| variance(a).total_cmp(&variance(b))).unwrap_or(0);
    cell(best).collect()
}
