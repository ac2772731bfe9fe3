//! How images lie in memory while a network trains: `[row][column][channel]`, so that a vector holds channels of one pixel
//! and no sum crosses its lanes.

use std::ops::{Deref, DerefMut};

/// Pixels of a tile's side: what one Winograd transform gives.
pub const TILE: usize = 4;

/// Channels are padded with zeros to a multiple of this many.
pub const CHANNELS: usize = 8;

/// Size of the images inside the blocks, and of everything made from it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Geometry {
    /// A multiple of [`CHANNELS`].
    pub channels: usize,
    pub height: usize,
    pub width: usize,
}

impl Geometry {
    pub fn pixels(&self) -> usize {
        self.height * self.width
    }

    /// Values of a row.
    pub fn row(&self) -> usize {
        self.width * self.channels
    }

    /// Values of a row of a [`Padded`] image.
    pub fn padded_row(&self) -> usize {
        (self.width.next_multiple_of(TILE) + 2) * self.channels
    }

    /// Values of an image.
    pub fn image(&self) -> usize {
        self.height * self.row()
    }

    /// Rows and columns of tiles; the last of each may reach beyond the image.
    pub fn tiles(&self) -> [usize; 2] {
        [self.height, self.width].map(|size| size.div_ceil(TILE))
    }
}

/// Values that begin on a cache line.
#[derive(Debug, Default)]
pub struct Aligned {
    values: Vec<f32>,
    start: usize,
    length: usize,
}

impl Aligned {
    pub fn new(length: usize) -> Aligned {
        let values = vec![0.0; length + 15];
        let start = values.as_ptr().align_offset(64).min(15);
        Aligned { values, start, length }
    }
}

impl Deref for Aligned {
    type Target = [f32];

    fn deref(&self) -> &[f32] {
        &self.values[self.start..][..self.length]
    }
}

impl DerefMut for Aligned {
    fn deref_mut(&mut self) -> &mut [f32] {
        &mut self.values[self.start..][..self.length]
    }
}

/// An image of whole tiles with one pixel of zeros all round; the border stays zero.
#[derive(Debug)]
pub struct Padded(Aligned);

impl Padded {
    pub fn new(geometry: Geometry) -> Padded {
        let rows = geometry.height.next_multiple_of(TILE) + 2;
        Padded(Aligned::new(rows * geometry.padded_row()))
    }

    /// Everything, from the first zero on, rows [`Geometry::padded_row`] apart.
    pub fn values(&self) -> &[f32] {
        &self.0
    }

    pub fn values_mut(&mut self) -> &mut [f32] {
        &mut self.0
    }
}
