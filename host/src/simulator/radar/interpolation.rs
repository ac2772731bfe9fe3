//! A sweep's beat at the samples from its values at a few nodes, by polynomials.

use super::{SAMPLE_RATE, SAMPLES};
use crate::numerics::differentiation;
use crate::numerics::vectors::vectorised;
use crate::simulator::channel::{Complex64, NODES, SWEEP_RATE, SWEEP_S, Sweep, node_time};
use std::f64::consts::PI;
use std::sync::LazyLock;

/// Samples worked on together: their sums stay in registers.
const BLOCK: usize = 40;

/// The polynomials at a block's samples, `[node][fast_time]`, where a vector lies within a line of the cache.
#[repr(align(64))]
struct Rows([[f64; BLOCK]; NODES]);

/// Values of the Lagrange polynomials of the nodes at the samples, block by block.
static INTERPOLATION: LazyLock<Vec<Rows>> = LazyLock::new(|| {
    let node = |k: usize| PI * (k as f64 + 0.5) / NODES as f64;
    let at = |k: usize, n: usize| {
        let x = 1.0 - 2.0 * (n as f64 / SAMPLE_RATE) / SWEEP_S;
        let x = libm::acos(x.clamp(-1.0, 1.0));
        // discrete cosine synthesis: sum over degrees of T_d(x) T_d(x_k)
        let sum: f64 = (1..NODES).map(|d| libm::cos(d as f64 * x) * libm::cos(d as f64 * node(k))).sum();
        (1.0 + 2.0 * sum) / NODES as f64
    };
    let block = |b: usize| Rows(std::array::from_fn(|k| std::array::from_fn(|n| at(k, b * BLOCK + n + 1))));
    (0..SAMPLES / BLOCK).map(block).collect()
});

/// Sums over the nodes in their order.
#[inline(always)]
fn sums(rows: &[[f64; BLOCK]; NODES], nodes: &[f64; NODES]) -> [f64; BLOCK] {
    let mut sums = [0.0; BLOCK];
    for (row, z) in rows.iter().zip(nodes) {
        for n in 0..BLOCK {
            sums[n] += row[n] * z;
        }
    }
    sums
}

/// Real and imaginary part at the samples. Cost: [`NODES`] complex multiply-adds a sample.
pub fn interpolate(nodes: &Sweep, re: &mut [f64], im: &mut [f64]) {
    let table = &*INTERPOLATION;
    let (real, imaginary) = (nodes.map(|z| z.re), nodes.map(|z| z.im));
    vectorised(
        #[inline(always)]
        || {
            let (re, _) = re.as_chunks_mut::<BLOCK>();
            let (im, _) = im.as_chunks_mut::<BLOCK>();
            for (Rows(rows), (re, im)) in table.iter().zip(re.iter_mut().zip(im)) {
                *re = sums(rows, &real);
                *im = sums(rows, &imaginary);
            }
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

const _: () = assert!(SAMPLES.is_multiple_of(BLOCK));
