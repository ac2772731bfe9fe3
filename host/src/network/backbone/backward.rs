//! The backbone's backward pass: two sweeps over the batch for every block, from the last to the first, then the input
//! convolution. Activations are computed again from what the forward pass kept.

use super::elementwise::{Affine, NormGradient, Sums, gate};
use super::forward::{Forward, HalfPass, affine};
use super::kernels::{backward_kernels, kernel_gradients, transformed};
use super::layout::{Geometry, Padded};
use super::stem::Stem;
use super::{BlockKind, Buffer, PreActConv, Shape, Statistics, rows_with_channels, total};
use pulp::Arch;
use rayon::prelude::*;

/// What a thread needs for the gradient of a half.
struct Gradient {
    half: HalfPass,
    /// Gradient of the convolution's output.
    g: Padded,
}

/// What a chunk of images adds to a half's gradient.
struct Part {
    /// Transformed kernels.
    kernels: Buffer,
    /// Sums of the gradient before the ReLU, and of it times the centred input.
    norm: Vec<Sums>,
    /// Sum of the gradient of the convolution's output.
    bias: Vec<Sums>,
}

impl Gradient {
    fn new(geometry: Geometry, arch: Arch) -> Gradient {
        Gradient { half: HalfPass::new(geometry, arch), g: Padded::new(geometry) }
    }

    /// One image: from `g`, the gradient of the convolution's output, to `y`, that of the normalisation's output.
    fn image(
        &mut self,
        x: &[f32],
        (affine, means): (&Affine, &[f32]),
        kernels: &[f32],
        y: &mut [f32],
        part: &mut Part,
    ) {
        self.half.activate(x, affine);
        let HalfPass { arch, geometry, active, winograd } = &mut self.half;
        winograd.gradients(active, &self.g, kernels, &mut part.kernels, y);
        gate(*arch, geometry, y, active, (x, means), &mut part.norm);
    }
}

fn means(norms: &[Statistics]) -> Vec<f32> {
    norms.iter().map(|s| s.mean as f32).collect()
}

/// Gradients of gamma and beta, and the coefficients of the input's, from the sums over `count` values.
fn norm(
    block_kind: BlockKind,
    half: &PreActConv,
    norms: &[Statistics],
    sums: &[Sums],
    count: f64,
) -> (Vec<f32>, Vec<f32>, NormGradient) {
    let mut input = NormGradient { mean: means(norms), ..NormGradient::default() };
    let mut gradients = (Vec::new(), Vec::new());
    for ((s, sums), &gamma) in norms.iter().zip(sums).zip(half.gamma) {
        let scale = s.scale();
        let outer = f64::from(gamma) * scale;
        // what comes back through the batch's statistics
        let (slope, constant) = match block_kind {
            BlockKind::Residual => (-outer * scale * scale * sums.1 / count, -outer * sums.0 / count),
            BlockKind::Plain => (0.0, 0.0),
        };
        input.outer.push(outer as f32);
        input.slope.push(slope as f32);
        input.constant.push(constant as f32);
        gradients.0.push((sums.1 * scale) as f32);
        gradients.1.push(sums.0 as f32);
    }
    (gradients.0, gradients.1, input)
}

/// Gradient of the parameters, in the order of [`Shape::parameters`], from that of the features, `[batch][C]`.
pub fn backward(forward: &Forward, images: &[f32], parameters: &[f32], features: &[f32]) -> Vec<f32> {
    let (shape, channels) = (forward.shape, forward.channels);
    let parameters = &shape.parameters_of(channels, parameters)[..];
    let features = &rows_with_channels(features, channels, shape.channels)[..];
    let (arch, geometry) = (shape.arch(), shape.geometry());
    let (c, image, chunk) = (shape.channels, geometry.image(), shape.chunk());
    let count = (shape.batch * geometry.pixels()) as f64;
    let ([stem, stem_bias], blocks) = shape.split(parameters);
    // Gradient of the block's output, and of the normalisations' outputs.
    let mut outer = forward.workspace.take(shape.batch * image);
    let mut inner = forward.workspace.take(shape.batch * image);
    let mut gradient: Vec<Vec<f32>> = Vec::new();
    let mut behind: Option<NormGradient> = None;
    let scratch = || Gradient::new(geometry, arch);
    let part = || {
        let mut kernels = forward.workspace.take(transformed(c));
        kernels.fill(0.0);
        Part { kernels, norm: vec![Sums::default(); c], bias: vec![Sums::default(); c] }
    };
    let kernels = |parts: &[Part]| kernel_gradients(parts.iter().map(|p| &p.kernels[..]), c);
    // The gradient of a block's output goes through the normalisation of the block behind, and through its skip if it has one;
    // behind the last block it is one over the number of pixels times the features'.
    let skips = shape.block_kind == BlockKind::Residual;
    let outer_of = |behind: &Option<NormGradient>,
                    (inner, x): (&[f32], &[f32]),
                    features: &[f32],
                    outer: &mut [f32],
                    g: &mut Padded,
                    bias: &mut [Sums]| {
        match behind {
            Some(norm) => norm.add(arch, &geometry, (inner, x), (skips, outer), g, bias),
            None => {
                let mean = NormGradient::constant(features.iter().map(|f| f / geometry.pixels() as f32));
                mean.add(arch, &geometry, (x, x), (false, outer), g, bias);
            }
        }
    };

    for (b, block) in blocks.iter().enumerate().rev() {
        let [first, second] = &block.halves;
        let [before, between] = &forward.norms[b];
        let (mirrored, scale) = (backward_kernels(second.conv, c), affine(second, between));
        let at_mean = means(between);
        let saved = forward.t[b].par_chunks(chunk * image).zip(forward.x[b + 1].par_chunks(chunk * image));
        let gradients = outer.par_chunks_mut(chunk * image).zip(inner.par_chunks_mut(chunk * image));
        let parts: Vec<Part> = saved
            .zip(gradients)
            .zip(features.par_chunks(chunk * c))
            .map_init(scratch, |pass, (((t, x), (outer, inner)), features)| {
                let mut part = part();
                let saved = t.chunks_exact(image).zip(x.chunks_exact(image));
                let gradients = outer.chunks_exact_mut(image).zip(inner.chunks_exact_mut(image));
                for (((t, x), (outer, inner)), features) in saved.zip(gradients).zip(features.chunks_exact(c))
                {
                    outer_of(&behind, (inner, x), features, outer, &mut pass.g, &mut part.bias);
                    pass.image(t, (&scale, &at_mean), &mirrored, inner, &mut part);
                }
                part
            })
            .collect();
        let conv2 = kernels(&parts);
        let bias2 = total(parts.iter().map(|p| p.bias.clone())).iter().map(|s| s.0 as f32).collect();
        let sums2 = total(parts.into_iter().map(|p| p.norm));
        let (gamma2, beta2, middle) = norm(shape.block_kind, second, between, &sums2, count);

        let (mirrored, scale) = (backward_kernels(first.conv, c), affine(first, before));
        let at_mean = means(before);
        let saved = forward.x[b].par_chunks(chunk * image).zip(forward.t[b].par_chunks(chunk * image));
        let parts: Vec<Part> = saved
            .zip(inner.par_chunks_mut(chunk * image))
            .map_init(scratch, |pass, ((x, t), inner)| {
                let mut part = part();
                let saved = x.chunks_exact(image).zip(t.chunks_exact(image));
                for ((x, t), inner) in saved.zip(inner.chunks_exact_mut(image)) {
                    middle.set(arch, &geometry, inner, t, &mut pass.g);
                    pass.image(x, (&scale, &at_mean), &mirrored, inner, &mut part);
                }
                part
            })
            .collect();
        let conv1 = kernels(&parts);
        let sums1 = total(parts.into_iter().map(|p| p.norm));
        let (gamma1, beta1, input) = norm(shape.block_kind, first, before, &sums1, count);
        gradient.push([gamma1, beta1, conv1, gamma2, beta2, conv2, bias2].concat());
        behind = Some(input);
    }

    let weights = shape.stem_weights(stem);
    let gradients = outer.par_chunks_mut(chunk * image).zip(inner.par_chunks(chunk * image));
    let parts: Vec<(Vec<f32>, Vec<Sums>)> = images
        .par_chunks(chunk * shape.rows * shape.frames)
        .zip(forward.x[0].par_chunks(chunk * image).zip(gradients).zip(features.par_chunks(chunk * c)))
        .map_init(
            || (Stem::new(&shape, arch), Padded::new(geometry)),
            |(stem, g), (images, ((x, (outer, inner)), features))| {
                let (mut part, mut bias) = (vec![0.0; 9 * c], vec![Sums::default(); c]);
                let gradients = outer.chunks_exact_mut(image).zip(inner.chunks_exact(image));
                let all = x.chunks_exact(image).zip(gradients).zip(features.chunks_exact(c));
                for (source, ((x, (outer, inner)), features)) in
                    images.chunks_exact(shape.rows * shape.frames).zip(all)
                {
                    outer_of(&behind, (inner, x), features, outer, g, &mut bias);
                    stem.backward(source, &weights, stem_bias, outer, &mut part);
                }
                (part, bias)
            },
        )
        .collect();
    let mut stem = vec![0.0f64; 9 * c];
    for (part, _) in &parts {
        stem.iter_mut().zip(part).for_each(|(sum, &part)| *sum += f64::from(part));
    }
    // `[C][9]`
    let stem: Vec<f32> = (0..9 * c).map(|at| stem[at % 9 * c + at / 9] as f32).collect();
    let bias = total(parts.into_iter().map(|p| p.1)).iter().map(|s| s.0 as f32).collect();
    gradient.push([stem, bias].concat());
    gradient.reverse();
    let narrow = Shape { channels, ..shape };
    narrow.parameters_of(c, &gradient.concat()).into_owned()
}
