//! The input convolution with its pooling, as the maximum of four convolutions, and its gradient.
//!
//! Pixel (r, c) of the pooled image is the maximum of the convolution at (2r, 2c), (2r, 2c+1), (2r+1, 2c), (2r+1, 2c+1):
//! its four phases. All taps of all phases are planes of every (2 stride)-th pixel of the image, gathered once.

use super::Shape;
use super::elementwise::{Sums, moments};
use super::planes::Geometry;
use super::products::{Convolve, Correlate};
use crate::network::float_network::same_padding;
use pulp::Arch;

/// What a thread needs for an image.
#[derive(Debug)]
pub struct Stem {
    arch: Arch,
    geometry: Geometry,
    stride: usize,
    pads: [usize; 2],
    size: [usize; 2],
    image: Vec<f32>,
    planes: Vec<f32>,
    phases: [Vec<f32>; 4],
}

impl Stem {
    /// For images of a shape.
    pub fn new(shape: &Shape, arch: Arch) -> Stem {
        let (geometry, stride) = (shape.geometry(), shape.stem_stride);
        let pads = [shape.rows, shape.frames].map(|size| same_padding(size, stride).1);
        let size = [shape.rows, shape.frames];
        let room = size.map(|size| size + 2 * stride + 4);
        Stem {
            arch,
            geometry,
            stride,
            pads,
            size,
            image: vec![0.0; room[0] * room[1]],
            planes: vec![0.0; (stride + 3).pow(2) * geometry.pixels()],
            phases: std::array::from_fn(|_| vec![0.0; geometry.image()]),
        }
    }

    /// Where the nine taps of a phase begin.
    fn shifts(&self, phase: usize) -> [usize; 9] {
        let (side, pixels) = (self.stride + 3, self.geometry.pixels());
        let [y, x] = [phase / 2, phase % 2].map(|p| p * self.stride);
        std::array::from_fn(|tap| ((y + tap / 3) * side + x + tap % 3) * pixels)
    }

    fn gather(&mut self, image: &[f32]) {
        let room = self.size[1] + 2 * self.stride + 4;
        for (r, row) in image.chunks_exact(self.size[1]).enumerate() {
            self.image[(r + self.pads[0]) * room + self.pads[1]..][..self.size[1]].copy_from_slice(row);
        }
        let (side, pixels, row) = (self.stride + 3, self.geometry.pixels(), self.geometry.row());
        for (d, plane) in self.planes.chunks_exact_mut(pixels).enumerate() {
            for r in 0..self.geometry.height {
                let from = &self.image[(2 * self.stride * r + d / side) * room + d % side..];
                let to = &mut plane[r * row..][..self.geometry.width];
                to.iter_mut().zip(from.iter().step_by(2 * self.stride)).for_each(|(to, from)| *to = *from);
            }
        }
    }

    /// Pooled image `x` and the phase of each maximum, the first of equals; adds the moments of `x`.
    ///
    /// `weights` are `[9][C]`.
    pub fn forward(
        &mut self,
        image: &[f32],
        weights: &[f32],
        bias: &[f32],
        x: &mut [f32],
        argmax: &mut [u8],
        sums: &mut [Sums],
    ) {
        self.gather(image);
        let (pixels, arch) = (self.geometry.pixels(), self.arch);
        for phase in 0..4 {
            let shifts = self.shifts(phase);
            let (planes, y) = (&self.planes, &mut self.phases[phase]);
            Convolve { x: planes, shifts: &shifts, weights, bias, pixels, y }.run(arch);
        }
        let [a, b, c, d] = &self.phases;
        arch.dispatch(
            #[inline(always)]
            || {
                let phases = a.iter().zip(b).zip(c.iter().zip(d));
                for ((x, argmax_index), ((&a, &b), (&c, &d))) in x.iter_mut().zip(argmax).zip(phases) {
                    let (top, first) = if b > a { (b, 1) } else { (a, 0) };
                    let (low, second) = if d > c { (d, 3) } else { (c, 2) };
                    (*x, *argmax_index) = if low > top { (low, second) } else { (top, first) };
                }
            },
        );
        for (plane, sums) in x.chunks_exact_mut(pixels).zip(sums) {
            self.geometry.clear(plane);
            *sums += moments(arch, plane);
        }
    }

    /// Adds the gradients of weights, `[9][C][lane]`, and biases for the gradient `g` of the pooled image.
    pub fn backward(
        &mut self,
        image: &[f32],
        g: &[f32],
        argmax: &[u8],
        lanes: &mut [f32],
        bias: &mut [Sums],
    ) {
        self.gather(image);
        let (pixels, arch) = (self.geometry.pixels(), self.arch);
        for phase in 0..4 {
            let shifts = self.shifts(phase);
            let chosen = &mut self.phases[phase];
            arch.dispatch(
                #[inline(always)]
                || {
                    for ((y, &g), &argmax_index) in chosen.iter_mut().zip(g).zip(argmax) {
                        *y = if argmax_index == phase as u8 { g } else { 0.0 };
                    }
                },
            );
            let outputs = self.geometry.channels;
            let (x, g) = (&self.planes, &self.phases[phase]);
            Correlate { x, shifts: &shifts, g, plane: pixels, outputs, pixels, sums: lanes }.run(arch);
        }
        for (plane, sums) in g.chunks_exact(pixels).zip(bias) {
            *sums += moments(arch, plane);
        }
    }
}
