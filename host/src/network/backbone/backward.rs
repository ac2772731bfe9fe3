//! The backbone's backward pass: two sweeps over the batch for every block, from the last to the first, then the input
//! convolution. Activations are computed again from what the forward pass kept.

use super::elementwise::{NormGradient, Sums, gate, moments};
use super::forward::{Forward, HalfPass, affine};
use super::planes::{Geometry, Padded, backward_weights};
use super::products::{Convolve, Correlate, LANES};
use super::stem::Stem;
use super::{BlockKind, PreActConv, Shape, Statistics, total};
use pulp::Arch;
use rayon::prelude::*;

/// What a thread needs for the gradient of a half.
struct Gradient {
    half: HalfPass,
    /// Gradient of the convolution's output.
    g: Padded,
    shifts: Vec<usize>,
}

/// What a chunk of images adds to a half's gradient.
struct Part {
    /// Weights `[i][9][o]`.
    weights: Vec<f32>,
    /// Sums of the gradient before the ReLU, and of it times the centred input.
    norm: Vec<Sums>,
    /// Sum of the gradient of the convolution's output.
    bias: Vec<Sums>,
}

impl Gradient {
    fn new(geometry: Geometry, arch: Arch) -> Gradient {
        Gradient { half: HalfPass::new(geometry, arch), g: Padded::new(&geometry), shifts: geometry.shifts() }
    }

    /// One image: from `g`, the gradient of the convolution's output, to `y`, that of the normalisation's output.
    fn image(
        &mut self,
        x: &[f32],
        affine: &[(f32, f32)],
        norms: &[Statistics],
        weights: &[f32],
        y: &mut [f32],
        (lanes, sums): (&mut [f32], &mut [Sums]),
    ) {
        let Geometry { channels: outputs, .. } = self.half.geometry;
        let (pixels, plane, arch) =
            (self.half.geometry.pixels(), self.half.geometry.padded(), self.half.arch);
        let shifts = &self.shifts;
        self.half.activate(x, affine);
        let (active, g) = (self.half.active.data(), self.g.pixels());
        Correlate { x: active, shifts, g, plane, outputs, pixels, sums: lanes }.run(arch);
        let none = vec![0.0; outputs];
        Convolve { x: self.g.data(), shifts, weights, bias: &none, pixels, y: &mut *y }.run(arch);
        for (c, (y, x)) in y.chunks_exact_mut(pixels).zip(x.chunks_exact(pixels)).enumerate() {
            sums[c] += gate(arch, y, self.half.active.plane(c), x, norms[c].mean as f32);
        }
    }
}

fn reduced(lanes: &[f32]) -> Vec<f32> {
    lanes.chunks_exact(LANES).map(|lanes| lanes.iter().map(|&l| f64::from(l)).sum::<f64>() as f32).collect()
}

/// Weights `[o][i][9]` from the chunks' `[i][9][o]`.
fn weights<'a>(parts: impl Iterator<Item = &'a [f32]>, inputs: usize, outputs: usize) -> Vec<f32> {
    let mut sums = vec![0.0f64; 9 * inputs * outputs];
    for part in parts {
        sums.iter_mut().zip(part).for_each(|(s, &p)| *s += f64::from(p));
    }
    let at = |o: usize, k: usize| sums[k * outputs + o] as f32;
    (0..outputs).flat_map(|o| (0..9 * inputs).map(move |k| at(o, k))).collect()
}

/// Gradients of gamma and beta, and the coefficients of the input's, from the sums over `count` values.
fn norm(
    block_kind: BlockKind,
    half: &PreActConv,
    norms: &[Statistics],
    sums: &[Sums],
    count: f64,
) -> (Vec<f32>, Vec<f32>, Vec<NormGradient>) {
    let one = |((s, sums), &gamma): ((&Statistics, &Sums), &f32)| {
        let scale = s.scale();
        let outer = f64::from(gamma) * scale;
        // what comes back through the batch's statistics
        let (slope, constant) = match block_kind {
            BlockKind::Residual => (-outer * scale * scale * sums.1 / count, -outer * sums.0 / count),
            BlockKind::Plain => (0.0, 0.0),
        };
        let input = NormGradient {
            outer: outer as f32,
            slope: slope as f32,
            constant: constant as f32,
            mean: s.mean as f32,
        };
        ((sums.1 * scale) as f32, (sums.0 as f32, input))
    };
    let (gamma, (beta, input)): (Vec<f32>, (Vec<f32>, Vec<NormGradient>)) =
        norms.iter().zip(sums).zip(half.gamma).map(one).unzip();
    (gamma, beta, input)
}

/// One over the number of pixels times the features' gradient, at every pixel.
fn global_pool_backward(geometry: &Geometry, features: &[f32], g: &mut [f32]) {
    let area = (geometry.height * geometry.width) as f32;
    for (plane, &feature) in g.chunks_exact_mut(geometry.pixels()).zip(features) {
        geometry.fill(plane, feature / area);
    }
}

/// Gradient of the parameters, in the order of [`Shape::parameters`], from that of the features, `[batch][C]`.
pub fn backward(forward: &Forward, images: &[f32], parameters: &[f32], features: &[f32]) -> Vec<f32> {
    let arch = Arch::new();
    let shape: Shape = forward.shape;
    let geometry = shape.geometry();
    let (c, pixels, image, chunk) = (shape.channels, geometry.pixels(), geometry.image(), shape.chunk());
    let count = (shape.batch * geometry.height * geometry.width) as f64;
    let (_, blocks) = shape.split(parameters);
    // Gradient of the block's output, and of the normalisations' outputs.
    let mut outer = forward.workspace.take(shape.batch * image);
    let mut inner = forward.workspace.take(shape.batch * image);
    let mut gradient: Vec<Vec<f32>> = Vec::new();
    let mut behind: Option<Vec<NormGradient>> = None;
    let room = || (Gradient::new(geometry, arch), vec![0.0; 9 * c * c * LANES]);
    let sums = || vec![Sums::default(); c];

    for (b, block) in blocks.iter().enumerate().rev() {
        let [first, second] = &block.halves;
        let [before, between] = &forward.norms[b];
        let (mirrored, scale) = (backward_weights(second.conv, c, c), affine(second, between));
        let saved = forward.t[b]
            .values
            .par_chunks(chunk * image)
            .zip(forward.x[b + 1].values.par_chunks(chunk * image));
        let gradients =
            outer.values.par_chunks_mut(chunk * image).zip(inner.values.par_chunks_mut(chunk * image));
        let parts: Vec<Part> = saved
            .zip(gradients)
            .zip(features.par_chunks(chunk * c))
            .map_init(room, |(pass, lanes), (((t, x), (outer, inner)), features)| {
                lanes.fill(0.0);
                let (mut norm, mut bias) = (sums(), sums());
                let saved = t.chunks_exact(image).zip(x.chunks_exact(image));
                let gradients = outer.chunks_exact_mut(image).zip(inner.chunks_exact_mut(image));
                for (((t, x), (outer, inner)), features) in saved.zip(gradients).zip(features.chunks_exact(c))
                {
                    match &behind {
                        None => global_pool_backward(&geometry, features, outer),
                        Some(norms) => through_norm(arch, &shape, norms, inner, x, outer),
                    }
                    for (i, plane) in outer.chunks_exact(pixels).enumerate() {
                        pass.g.plane_mut(i).copy_from_slice(plane);
                        bias[i] += moments(arch, plane);
                    }
                    pass.image(t, &scale, between, &mirrored, inner, (lanes, &mut norm));
                }
                Part { weights: reduced(lanes), norm, bias }
            })
            .collect();
        let conv2 = weights(parts.iter().map(|p| &p.weights[..]), c, c);
        let bias2 = total(parts.iter().map(|p| p.bias.clone())).iter().map(|s| s.0 as f32).collect();
        let sums2 = total(parts.into_iter().map(|p| p.norm));
        let (gamma2, beta2, middle) = norm(shape.block_kind, second, between, &sums2, count);

        let (mirrored, scale) = (backward_weights(first.conv, c, c), affine(first, before));
        let saved =
            forward.x[b].values.par_chunks(chunk * image).zip(forward.t[b].values.par_chunks(chunk * image));
        let parts: Vec<Part> = saved
            .zip(inner.values.par_chunks_mut(chunk * image))
            .map_init(room, |(pass, lanes), ((x, t), inner)| {
                lanes.fill(0.0);
                let mut norm = sums();
                let saved = x.chunks_exact(image).zip(t.chunks_exact(image));
                for ((x, t), inner) in saved.zip(inner.chunks_exact_mut(image)) {
                    let planes = inner.chunks_exact(pixels).zip(t.chunks_exact(pixels)).zip(&middle);
                    for (i, ((g, t), middle)) in planes.enumerate() {
                        let target = pass.g.plane_mut(i);
                        middle.set(arch, g, t, target);
                        geometry.clear(target);
                    }
                    pass.image(x, &scale, before, &mirrored, inner, (lanes, &mut norm));
                }
                Part { weights: reduced(lanes), norm, bias: Vec::new() }
            })
            .collect();
        let conv1 = weights(parts.iter().map(|p| &p.weights[..]), c, c);
        let sums1 = total(parts.into_iter().map(|p| p.norm));
        let (gamma1, beta1, input) = norm(shape.block_kind, first, before, &sums1, count);
        gradient.push([gamma1, beta1, conv1, gamma2, beta2, conv2, bias2].concat());
        behind = Some(input);
    }

    let gradients =
        outer.values.par_chunks_mut(chunk * image).zip(inner.values.par_chunks_mut(chunk * image));
    let saved = forward.x[0].values.par_chunks(chunk * image).zip(forward.argmax.par_chunks(chunk * image));
    let parts: Vec<(Vec<f32>, Vec<Sums>)> = images
        .par_chunks(chunk * shape.rows * shape.frames)
        .zip(saved.zip(gradients).zip(features.par_chunks(chunk * c)))
        .map_init(
            || (Stem::new(&shape, arch), vec![0.0; 9 * c * LANES]),
            |(stem, lanes), (images, (((x, argmax), (outer, inner)), features))| {
                lanes.fill(0.0);
                let mut bias = sums();
                let saved = x.chunks_exact(image).zip(argmax.chunks_exact(image));
                let gradients = outer.chunks_exact_mut(image).zip(inner.chunks_exact(image));
                let all = saved.zip(gradients).zip(features.chunks_exact(c));
                for (source, (((x, argmax), (outer, inner)), features)) in
                    images.chunks_exact(shape.rows * shape.frames).zip(all)
                {
                    match &behind {
                        None => global_pool_backward(&geometry, features, outer),
                        Some(norms) => through_norm(arch, &shape, norms, inner, x, outer),
                    }
                    stem.backward(source, outer, argmax, lanes, &mut bias);
                }
                (reduced(lanes), bias)
            },
        )
        .collect();
    let stem = weights(parts.iter().map(|p| &p.0[..]), 1, c);
    let bias = total(parts.into_iter().map(|p| p.1)).iter().map(|s| s.0 as f32).collect();
    gradient.push([stem, bias].concat());
    gradient.reverse();
    gradient.concat()
}

/// Adds the gradient through the normalisation of the block behind to that through its skip, if it has one.
fn through_norm(arch: Arch, shape: &Shape, norms: &[NormGradient], g: &[f32], x: &[f32], outer: &mut [f32]) {
    let geometry = shape.geometry();
    let pixels = geometry.pixels();
    let planes = outer.chunks_exact_mut(pixels).zip(g.chunks_exact(pixels)).zip(x.chunks_exact(pixels));
    for (((outer, g), x), norm) in planes.zip(norms) {
        match shape.block_kind {
            BlockKind::Residual => norm.add(arch, g, x, outer),
            BlockKind::Plain => norm.set(arch, g, x, outer),
        }
        geometry.clear(outer);
    }
}
