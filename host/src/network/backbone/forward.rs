//! The backbone's forward pass: two sweeps over the batch for every block, one for each half, with the batch's statistics
//! of the next half gathered on the way.

use super::elementwise::{Affine, Sums, add, affine_relu, moments};
use super::kernels::forward_kernels;
use super::layout::{Geometry, Padded};
use super::stem::Stem;
use super::winograd::Winograd;
use super::{BlockKind, Buffer, PreActConv, Shape, Statistics, Workspace, rows_with_channels, total};
use pulp::Arch;
use rayon::prelude::*;

/// What a forward pass leaves: the features, and what the backward pass needs.
#[derive(Debug)]
pub struct Forward {
    /// Mean of every channel, `[batch][C]`.
    pub features: Vec<f32>,
    /// With whole vectors of channels, and how many the parameters have.
    pub(super) shape: Shape,
    pub(super) channels: usize,
    pub(super) workspace: Workspace,
    /// Input of every block and output of the last, `[batch][pixel][C]`.
    pub(super) x: Vec<Buffer>,
    /// Output of every block's first convolution.
    pub(super) t: Vec<Buffer>,
    /// Statistics of `x` and of `t` in every block.
    pub(super) norms: Vec<[Vec<Statistics>; 2]>,
}

impl Forward {
    /// Mean, variance, mean, variance of every block's normalisations, each `[C]`; variances are mean squares.
    pub fn statistics(&self) -> Vec<f32> {
        let flat = |norms: &Vec<Statistics>| {
            let (means, variances): (Vec<f32>, Vec<f32>) =
                norms.iter().map(|s| (s.mean as f32, s.variance as f32)).unzip();
            [means, variances].concat()
        };
        let wide: Vec<f32> = self.norms.iter().flatten().flat_map(flat).collect();
        rows_with_channels(&wide, self.shape.channels, self.channels)
    }
}

/// Normalised and rectified images, and their convolution.
pub(super) struct HalfPass {
    pub arch: Arch,
    pub geometry: Geometry,
    pub active: Padded,
    pub winograd: Winograd,
}

impl HalfPass {
    pub fn new(geometry: Geometry, arch: Arch) -> HalfPass {
        HalfPass { arch, geometry, active: Padded::new(geometry), winograd: Winograd::new(geometry, arch) }
    }

    /// Fills `active` with `relu(norm(x))`.
    pub fn activate(&mut self, x: &[f32], affine: &Affine) {
        affine_relu(self.arch, &self.geometry, x, affine, &mut self.active);
    }

    fn convolve(&mut self, kernels: &[f32], y: &mut [f32]) {
        self.winograd.convolve(&self.active, kernels, y);
    }
}

pub(super) fn affine(half: &PreActConv, norms: &[Statistics]) -> Affine {
    let pairs = norms.iter().zip(half.gamma.iter().zip(half.beta)).map(|(s, (&g, &b))| s.affine(g, b));
    let (factors, offsets) = pairs.unzip();
    Affine { factors, offsets }
}

/// Features of `images`, `[batch][rows][frames]`, under `parameters` in the order of [`Shape::parameters`].
pub fn forward(shape: Shape, images: &[f32], parameters: &[f32], workspace: &Workspace) -> Forward {
    let channels = shape.channels;
    let shape = shape.widened();
    let parameters = &shape.parameters_of(channels, parameters)[..];
    let arch = shape.arch();
    let geometry = shape.geometry();
    let (c, image, chunk) = (shape.channels, geometry.image(), shape.chunk());
    let area = geometry.pixels() as f64;
    let ([stem, stem_bias], blocks) = shape.split(parameters);
    let buffer = || workspace.take(shape.batch * image);

    let mut x = vec![buffer()];
    let stem = shape.stem_weights(stem);
    let source = images.par_chunks(chunk * shape.rows * shape.frames);
    let sums: Vec<Vec<Sums>> = source
        .zip(x[0].par_chunks_mut(chunk * image))
        .map_init(
            || Stem::new(&shape, arch),
            |pass, (source, x)| {
                let mut sums = vec![Sums::default(); c];
                let images = source.chunks_exact(shape.rows * shape.frames);
                for (source, x) in images.zip(x.chunks_exact_mut(image)) {
                    pass.forward(source, &stem, stem_bias, x);
                    moments(arch, &geometry, x, &mut sums);
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
        let (kernels, scale) = (forward_kernels(first.conv, c), affine(first, &before));
        let sums: Vec<Vec<Sums>> = input
            .par_chunks(chunk * image)
            .zip(middle.par_chunks_mut(chunk * image))
            .map_init(
                || HalfPass::new(geometry, arch),
                |pass, (x, t)| {
                    let mut sums = vec![Sums::default(); c];
                    for (x, t) in x.chunks_exact(image).zip(t.chunks_exact_mut(image)) {
                        pass.activate(x, &scale);
                        pass.convolve(&kernels, t);
                        moments(arch, &geometry, t, &mut sums);
                    }
                    sums
                },
            )
            .collect();
        let between = shape.statistics_of(&total(sums), count);

        let (kernels, scale) = (forward_kernels(second.conv, c), affine(second, &between));
        let inputs = input.par_chunks(chunk * image).zip(middle.par_chunks(chunk * image));
        let outputs = output.par_chunks_mut(chunk * image).zip(features.par_chunks_mut(chunk * c));
        let sums: Vec<Vec<Sums>> = inputs
            .zip(outputs)
            .map_init(
                || HalfPass::new(geometry, arch),
                |pass, ((x, t), (y, features))| {
                    let mut sums = vec![Sums::default(); c];
                    let inputs = x.chunks_exact(image).zip(t.chunks_exact(image));
                    let outputs = y.chunks_exact_mut(image).zip(features.chunks_exact_mut(c));
                    for ((x, t), (y, features)) in inputs.zip(outputs) {
                        pass.activate(t, &scale);
                        pass.convolve(&kernels, y);
                        let skip = (shape.block_kind == BlockKind::Residual).then_some(x);
                        let mut moments = vec![Sums::default(); c];
                        add(arch, &geometry, skip, block.bias, y, &mut moments);
                        for ((feature, sums), moments) in features.iter_mut().zip(&mut sums).zip(moments) {
                            *feature = (moments.0 / area) as f32;
                            *sums += moments;
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
    let features = rows_with_channels(&features, c, channels);
    Forward { features, shape, channels, workspace: workspace.clone(), x, t, norms }
}
