//! A sweep's beat at the samples from its values at a few nodes, by polynomials.

use super::{SAMPLE_RATE, SAMPLES};
use crate::numerics::differentiation;
use crate::numerics::vectors::vectorised;
use crate::simulator::channel::{Complex64, NODES, SWEEP_RATE, SWEEP_S, Sweep, node_time};
use std::f64::consts::PI;
use std::sync::LazyLock;

/// Half of the nodes, and samples of the sweep's first half. Sample n = 1 to 1000 is taken at n / f_s; 1000 - n is its mirror image.
const HALF: usize = NODES / 2;
const FIRST: usize = SAMPLES / 2;
/// Samples of a block: their sums stay in registers. The last block goes beyond the middle.
const BLOCK: usize = 24;
const BLOCKS: usize = FIRST.div_ceil(BLOCK);

/// Sums and differences of the polynomials of two mirrored nodes at a block's samples, halved, `[node][fast_time]`, where a vector lies
/// within a line of the cache.
#[repr(align(64))]
struct Rows {
    even: [[f64; BLOCK]; HALF],
    odd: [[f64; BLOCK]; HALF],
}

/// Chebyshev polynomials T_1 to T_15 at cos x.
fn chebyshev(x: f64) -> [f64; NODES - 1] {
    std::array::from_fn(|d| libm::cos((d + 1) as f64 * x))
}

/// Their values at the nodes, `[node][degree - 1]`.
static AT_NODES: LazyLock<[[f64; NODES - 1]; NODES]> =
    LazyLock::new(|| std::array::from_fn(|k| chebyshev(PI * (k as f64 + 0.5) / NODES as f64)));

/// Values of the nodes' Lagrange polynomials at sample n.
fn polynomials(n: usize) -> [f64; NODES] {
    let x = 1.0 - 2.0 * (n as f64 / SAMPLE_RATE) / SWEEP_S;
    let at_sample = chebyshev(libm::acos(x.clamp(-1.0, 1.0)));
    AT_NODES.each_ref().map(|at_node| {
        // discrete cosine synthesis: sum over degrees of T_d(x) T_d(x_k)
        let sum: f64 = at_sample.iter().zip(at_node).map(|(a, b)| a * b).sum();
        (1.0 + 2.0 * sum) / NODES as f64
    })
}

/// The polynomials at the first half's samples, block by block.
static INTERPOLATION: LazyLock<[Rows; BLOCKS]> = LazyLock::new(|| {
    let mut blocks = [(); BLOCKS].map(|()| Rows { even: [[0.0; BLOCK]; HALF], odd: [[0.0; BLOCK]; HALF] });
    for (b, rows) in blocks.iter_mut().enumerate() {
        for n in 0..BLOCK {
            let at_sample = polynomials(b * BLOCK + n + 1);
            for k in 0..HALF {
                let mirrored = at_sample[NODES - 1 - k];
                rows.even[k][n] = 0.5 * (at_sample[k] + mirrored);
                rows.odd[k][n] = 0.5 * (at_sample[k] - mirrored);
            }
        }
    }
    blocks
});

/// The polynomials at the last sample, which has no mirror image.
static LAST: LazyLock<[f64; NODES]> = LazyLock::new(|| polynomials(SAMPLES));

/// Sums over the nodes in their order.
#[inline(always)]
fn sums(rows: &[[f64; BLOCK]; HALF], nodes: &[f64; HALF]) -> [f64; BLOCK] {
    let mut sums = [0.0; BLOCK];
    for (row, z) in rows.iter().zip(nodes) {
        for n in 0..BLOCK {
            sums[n] += row[n] * z;
        }
    }
    sums
}

/// A real function at the [`SAMPLES`] samples from its values at the nodes, which are symmetric about the sweep's middle: its even part plus
/// its odd part at sample n is its value there, the even less the odd part its value at sample 1000 - n.
#[inline(always)]
fn real(nodes: &[f64; NODES], samples: &mut [f64]) {
    let even: [f64; HALF] = std::array::from_fn(|k| nodes[k] + nodes[NODES - 1 - k]);
    let odd: [f64; HALF] = std::array::from_fn(|k| nodes[k] - nodes[NODES - 1 - k]);
    for (b, Rows { even: even_rows, odd: odd_rows }) in INTERPOLATION.iter().enumerate() {
        let (even, odd) = (sums(even_rows, &even), sums(odd_rows, &odd));
        let (mut first, mut mirrored) = ([0.0; BLOCK], [0.0; BLOCK]);
        for n in 0..BLOCK {
            first[n] = even[n] + odd[n];
        }
        for n in 0..BLOCK {
            mirrored[BLOCK - 1 - n] = even[n] - odd[n];
        }
        // sample n has index n - 1
        let mirror = SAMPLES - 1 - (b + 1) * BLOCK;
        samples[b * BLOCK..(b + 1) * BLOCK].copy_from_slice(&first);
        samples[mirror..mirror + BLOCK].copy_from_slice(&mirrored);
    }
    samples[SAMPLES - 1] = LAST.iter().zip(nodes).map(|(weight, z)| weight * z).sum();
}

/// Real and imaginary part at the [`SAMPLES`] samples. Cost: [`NODES`] / 2 complex multiply-adds a sample.
pub fn interpolate(nodes: &Sweep, re: &mut [f64], im: &mut [f64]) {
    let parts = [nodes.map(|z| z.re), nodes.map(|z| z.im)];
    vectorised(
        #[inline(always)]
        || {
            real(&parts[0], re);
            real(&parts[1], im);
        },
    );
}

/// Derivative of a sweep's beat at the nodes in 1/s, `[node][node]`.
static SLOPE: LazyLock<Vec<Vec<f64>>> = LazyLock::new(|| {
    let times: Vec<f64> = (0..NODES).map(node_time).collect();
    differentiation::matrix(&times)
});

/// What a phase phi' tau of every path adds to the beat at the nodes, per phi': j sum a tau exp(-2 pi j S tau t) is minus the
/// derivative of the beat over 2 pi S.
pub fn time_shift(sweep: &Sweep) -> Sweep {
    std::array::from_fn(|k| {
        let slope: Complex64 = SLOPE[k].iter().zip(sweep).map(|(w, z)| z * w).sum();
        slope / (-2.0 * PI * SWEEP_RATE)
    })
}
