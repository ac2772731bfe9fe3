//! How images lie in memory while a network trains: flat planes in which a tap of a 3x3 kernel is a constant shift.
//!
//! A row of a plane is followed by one pixel that stays zero: it pads the row's end and the next row's beginning. Stored
//! tensors are `[image][channel][pixel]` with `height * (width + 1)` pixels, rounded up, zero between and behind the
//! rows. What is convolved lies in a [`Padded`] buffer, with a zero row above and below as well.

use super::products::BLOCK;

/// Size of the images inside the blocks, and of everything made from it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Geometry {
    pub channels: usize,
    pub height: usize,
    pub width: usize,
}

impl Geometry {
    /// Distance of two rows.
    pub fn row(&self) -> usize {
        self.width + 1
    }

    /// Pixels of a stored plane.
    pub fn pixels(&self) -> usize {
        (self.height * self.row()).next_multiple_of(BLOCK)
    }

    /// Pixels of a stored image.
    pub fn image(&self) -> usize {
        self.channels * self.pixels()
    }

    /// Distance of two planes in a [`Padded`] buffer.
    pub fn padded(&self) -> usize {
        (self.pixels() + 2 * self.row() + 2).next_multiple_of(16)
    }

    /// Where each input channel and tap of a 3x3 convolution begins in a [`Padded`] buffer.
    pub fn shifts(&self) -> Vec<usize> {
        let (plane, row) = (self.padded(), self.row());
        (0..9 * self.channels).map(|k| k / 9 * plane + k % 9 / 3 * row + k % 3).collect()
    }

    /// Zeroes what lies between and behind the rows of a plane.
    pub fn clear(&self, plane: &mut [f32]) {
        let row = self.row();
        for r in 1..=self.height {
            plane[r * row - 1] = 0.0;
        }
        plane[self.height * row..self.pixels()].fill(0.0);
    }

    /// A plane's value at every pixel, zero elsewhere.
    pub fn fill(&self, plane: &mut [f32], value: f32) {
        plane[..self.height * self.row()].fill(value);
        self.clear(plane);
    }
}

/// Planes with zeros all round.
#[derive(Debug)]
pub struct Padded {
    data: Vec<f32>,
    start: usize,
    plane: usize,
    row: usize,
    pixels: usize,
}

impl Padded {
    pub fn new(geometry: &Geometry) -> Padded {
        let (plane, row) = (geometry.padded(), geometry.row());
        let data = vec![0.0; geometry.channels * plane + 16];
        let start = data[row + 1..].as_ptr().align_offset(64).min(16);
        Padded { data, start, plane, row, pixels: geometry.pixels() }
    }

    /// What [`Geometry::shifts`] point into.
    pub fn data(&self) -> &[f32] {
        &self.data[self.start..]
    }

    /// The planes from their first pixel on, aligned to 64 bytes, [`Geometry::padded`] apart.
    pub fn pixels(&self) -> &[f32] {
        &self.data()[self.row + 1..]
    }

    /// The pixels of a plane.
    pub fn plane(&self, channel: usize) -> &[f32] {
        &self.pixels()[channel * self.plane..][..self.pixels]
    }

    /// The pixels of a plane; the caller keeps zero what [`Geometry::clear`] zeroes.
    pub fn plane_mut(&mut self, channel: usize) -> &mut [f32] {
        &mut self.data[self.start + self.row + 1 + channel * self.plane..][..self.pixels]
    }
}

/// Convolution weights `[o][i][9]` as `[i][9][o]`.
pub fn forward_weights(weights: &[f32], inputs: usize, outputs: usize) -> Vec<f32> {
    let at = |k: usize, o: usize| weights[(o * inputs + k / 9) * 9 + k % 9];
    (0..9 * inputs).flat_map(|k| (0..outputs).map(move |o| at(k, o))).collect()
}

/// Convolution weights `[o][i][9]` as `[o][9 mirrored][i]`: those of the input's gradient.
pub fn backward_weights(weights: &[f32], inputs: usize, outputs: usize) -> Vec<f32> {
    let at = |k: usize, i: usize| weights[(k / 9 * inputs + i) * 9 + 8 - k % 9];
    (0..9 * outputs).flat_map(|k| (0..inputs).map(move |i| at(k, i))).collect()
}
