//! The door through which the network's layers are computed: plain loops, or the vectors of one processor.
//!
//! Every implementation gives the same bits; a processor's own need not cover every layer.

use super::add::Add;
use super::batch_norm::BatchNormRelu;
use super::conv::Conv;
use super::pool::{average, max_rows};

/// What a layer is computed by. `at` is the layer's number as in [`crate::probe::Probe::layer`].
///
/// The provided methods are the plain loops; shapes are those of the layers.
pub trait Kernels {
    /// Input convolution and 2x2 maximum: `[height, width]` to `[pooled height, pooled width, channels]`; `rows` holds
    /// two rows of the convolution.
    fn stem(
        &mut self,
        stem: &Conv<'_>,
        image: &[i8],
        size: (usize, usize),
        rows: &mut [i8],
        pooled: &mut [i8],
    ) {
        let (height, width) = size;
        let (upper, lower) = rows.split_at_mut_checked(rows.len() / 2).unwrap_or_default();
        let channels = stem.channels();
        let row_length = (upper.len() / channels.max(1) / 2) * channels;
        for (y, pooled) in pooled.chunks_exact_mut(row_length.max(1)).enumerate() {
            stem.row(image, height, width, 2 * y, upper);
            stem.row(image, height, width, 2 * y + 1, lower);
            max_rows(upper, lower, channels, pooled);
        }
    }

    /// [`BatchNormRelu::forward`].
    fn affine(&mut self, _at: usize, layer: &BatchNormRelu<'_>, input: &[i8], output: &mut [i8]) {
        layer.forward(input, output);
    }

    /// [`Conv::forward`]; `_rows` are the stem's two rows, which nothing needs any more.
    fn conv(
        &mut self,
        _at: usize,
        layer: &Conv<'_>,
        input: &[i8],
        size: (usize, usize),
        _rows: &mut [i8],
        output: &mut [i8],
    ) {
        layer.forward(input, size.0, size.1, output);
    }

    /// [`Add::forward`].
    fn add(&mut self, _at: usize, layer: &Add, x: &mut [i8], branch: &[i8]) {
        layer.forward(x, branch);
    }

    /// [`average`].
    fn average(&mut self, input: &[i8], channels: usize, output: &mut [i8]) {
        average(input, channels, output);
    }
}

impl<K: Kernels> Kernels for &mut K {
    fn stem(
        &mut self,
        stem: &Conv<'_>,
        image: &[i8],
        size: (usize, usize),
        rows: &mut [i8],
        pooled: &mut [i8],
    ) {
        (**self).stem(stem, image, size, rows, pooled);
    }

    fn affine(&mut self, at: usize, layer: &BatchNormRelu<'_>, input: &[i8], output: &mut [i8]) {
        (**self).affine(at, layer, input, output);
    }

    fn conv(
        &mut self,
        at: usize,
        layer: &Conv<'_>,
        input: &[i8],
        size: (usize, usize),
        rows: &mut [i8],
        output: &mut [i8],
    ) {
        (**self).conv(at, layer, input, size, rows, output);
    }

    fn add(&mut self, at: usize, layer: &Add, x: &mut [i8], branch: &[i8]) {
        (**self).add(at, layer, x, branch);
    }

    fn average(&mut self, input: &[i8], channels: usize, output: &mut [i8]) {
        (**self).average(input, channels, output);
    }
}

/// The plain loops, on every processor.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Portable;

impl Kernels for Portable {}
