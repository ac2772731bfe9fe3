//! The backbone's forward pass: two sweeps over the batch for every block, one for each half, with the batch's statistics
//! of the next half gathered on the way.

use super::elementwise::{Sums, add, affine_relu, moments};
use super::planes::{Geometry, Padded, forward_weights};
use super::products::Convolve;
use super::stem::Stem;
use super::{BlockKind, Buffer, PreActConv, Shape, Statistics, Workspace, total};
use pulp::Arch;
use rayon::prelude::*;

/// What a forward pass leaves: the features, and what the backward pass needs.
#[derive(Debug)]
pub struct Forward {
    /// Mean of every channel, `[batch][C]`.
    pub features: Vec<f32>,
    pub(super) shape: Shape,
    pub(super) workspace: Workspace,
    /// Input of every block and output of the last, `[batch][C][pixel]`.
    pub(super) x: Vec<Buffer>,
    /// Output of every block's first convolution.
    pub(super) t: Vec<Buffer>,
    /// Statistics of `x` and of `t` in every block.
    pub(super) norms: Vec<[Vec<Statistics>; 2]>,
    /// Phase of every maximum of the pooling.
    pub(super) argmax: Vec<u8>,
}

impl Forward {
    /// Mean, variance, mean, variance of every block's normalisations, each `[C]`; variances are mean squares.
    pub fn statistics(&self) -> Vec<f32> {
        let flat = |norms: &Vec<Statistics>| {
            let (means, variances): (Vec<f32>, Vec<f32>) =
                norms.iter().map(|s| (s.mean as f32, s.variance as f32)).unzip();
            [means, variances].concat()
        };
        self.norms.iter().flatten().flat_map(flat).collect()
    }
}

/// Normalised and rectified planes, and their convolution.
pub(super) struct HalfPass {
    pub arch: Arch,
    pub geometry: Geometry,
    pub active: Padded,
    shifts: Vec<usize>,
}

impl HalfPass {
    pub fn new(geometry: Geometry, arch: Arch) -> HalfPass {
        HalfPass { arch, geometry, active: Padded::new(&geometry), shifts: geometry.shifts() }
    }

    /// Fills `active` with `relu(norm(x))`.
    pub fn activate(&mut self, x: &[f32], affine: &[(f32, f32)]) {
        for (c, (x, &(factor, offset))) in x.chunks_exact(self.geometry.pixels()).zip(affine).enumerate() {
            let active = self.active.plane_mut(c);
            affine_relu(self.arch, x, factor, offset, active);
            self.geometry.clear(active);
        }
    }

    fn convolve(&self, weights: &[f32], bias: &[f32], y: &mut [f32]) {
        let (x, pixels) = (self.active.data(), self.geometry.pixels());
        Convolve { x, shifts: &self.shifts, weights, bias, pixels, y }.run(self.arch);
    }
}

pub(super) fn affine(half: &PreActConv, norms: &[Statistics]) -> Vec<(f32, f32)> {
    norms.iter().zip(half.gamma.iter().zip(half.beta)).map(|(s, (&g, &b))| s.affine(g, b)).collect()
}

/// Features of `images`, `[batch][rows][frames]`, under `parameters` in the order of [`Shape::parameters`].
pub fn forward(shape: Shape, images: &[f32], parameters: &[f32], workspace: &Workspace) -> Forward {
    let arch = Arch::new();
    let geometry = shape.geometry();
    let (c, pixels, image) = (shape.channels, geometry.pixels(), geometry.image());
    let area = (geometry.height * geometry.width) as f64;
    let chunk = shape.chunk();
    let ([stem, stem_bias], blocks) = shape.split(parameters);
    let buffer = || workspace.take(shape.batch * image);

    let mut x = vec![buffer()];
    let mut argmax = vec![0; shape.batch * image];
    let stem = forward_weights(stem, 1, c);
    let source = images.par_chunks(chunk * shape.rows * shape.frames);
    let sums: Vec<Vec<Sums>> = source
        .zip(x[0].values.par_chunks_mut(chunk * image).zip(argmax.par_chunks_mut(chunk * image)))
        .map_init(
            || Stem::new(&shape, arch),
            |pass, (source, (x, argmax))| {
                let mut sums = vec![Sums::default(); c];
                let targets = x.chunks_exact_mut(image).zip(argmax.chunks_exact_mut(image));
                for (source, (x, argmax)) in source.chunks_exact(shape.rows * shape.frames).zip(targets) {
                    pass.forward(source, &stem, stem_bias, x, argmax, &mut sums);
                }
                sums
            },
        )
        .collect();
    let count = shape.batch as f64 * area;
    let mut before = shape.statistics_of(&total(sums), count);

    let (mut t, mut norms) = (Vec::new(), Vec::new());
    let mut features = vec![0.0; shape.batch * c];
    for block in &blocks {
        let [first, second] = &block.halves;
        let (input, mut middle, mut output) = (&x[x.len() - 1], buffer(), buffer());
        let (weights, scale, none) =
            (forward_weights(first.conv, c, c), affine(first, &before), vec![0.0; c]);
        let sums: Vec<Vec<Sums>> = input
            .values
            .par_chunks(chunk * image)
            .zip(middle.values.par_chunks_mut(chunk * image))
            .map_init(
                || HalfPass::new(geometry, arch),
                |pass, (x, t)| {
                    let mut sums = vec![Sums::default(); c];
                    for (x, t) in x.chunks_exact(image).zip(t.chunks_exact_mut(image)) {
                        pass.activate(x, &scale);
                        pass.convolve(&weights, &none, t);
                        for (plane, sums) in t.chunks_exact_mut(pixels).zip(&mut sums) {
                            geometry.clear(plane);
                            *sums += moments(arch, plane);
                        }
                    }
                    sums
                },
            )
            .collect();
        let between = shape.statistics_of(&total(sums), count);

        let (weights, scale) = (forward_weights(second.conv, c, c), affine(second, &between));
        let inputs = input.values.par_chunks(chunk * image).zip(middle.values.par_chunks(chunk * image));
        let outputs = output.values.par_chunks_mut(chunk * image).zip(features.par_chunks_mut(chunk * c));
        let sums: Vec<Vec<Sums>> = inputs
            .zip(outputs)
            .map_init(
                || (HalfPass::new(geometry, arch), vec![0.0; image]),
                |(pass, convolved), ((x, t), (y, features))| {
                    let mut sums = vec![Sums::default(); c];
                    let inputs = x.chunks_exact(image).zip(t.chunks_exact(image));
                    let outputs = y.chunks_exact_mut(image).zip(features.chunks_exact_mut(c));
                    for ((x, t), (y, features)) in inputs.zip(outputs) {
                        pass.activate(t, &scale);
                        pass.convolve(&weights, block.bias, convolved);
                        match shape.block_kind {
                            BlockKind::Residual => add(arch, x, convolved, y),
                            BlockKind::Plain => y.copy_from_slice(convolved),
                        }
                        for (i, plane) in y.chunks_exact_mut(pixels).enumerate() {
                            geometry.clear(plane);
                            let moments = moments(arch, plane);
                            features[i] = (moments.0 / area) as f32;
                            sums[i] += moments;
                        }
                    }
                    sums
                },
            )
            .collect();
        norms.push([before, between]);
        before = shape.statistics_of(&total(sums), count);
        t.push(middle);
        x.push(output);
    }
    Forward { features, shape, workspace: workspace.clone(), x, t, norms, argmax }
}
