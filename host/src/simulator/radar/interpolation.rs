//! A sweep's beat at the samples from its values at a few nodes, by polynomials.

use super::{SAMPLE_RATE, SAMPLES};
use crate::simulator::channel::{NODES, SWEEP_S, Sweep};
use pulp::Arch;
use std::f64::consts::PI;
use std::sync::LazyLock;

/// Values of the Lagrange polynomials of the nodes at the samples, `[node][fast_time]`.
static INTERPOLATION: LazyLock<[Vec<f64>; NODES]> = LazyLock::new(|| {
    let node = |k: usize| PI * (k as f64 + 0.5) / NODES as f64;
    let at = |k: usize, n: usize| {
        let x = 1.0 - 2.0 * (n as f64 / SAMPLE_RATE) / SWEEP_S;
        let x = libm::acos(x.clamp(-1.0, 1.0));
        // discrete cosine synthesis: sum over degrees of T_d(x) T_d(x_k)
        let sum: f64 = (1..NODES).map(|d| libm::cos(d as f64 * x) * libm::cos(d as f64 * node(k))).sum();
        (1.0 + 2.0 * sum) / NODES as f64
    };
    std::array::from_fn(|k| (1..=SAMPLES).map(|n| at(k, n)).collect())
});

/// Samples worked on together: their sums stay in registers.
const BLOCK: usize = 20;

/// Real and imaginary part at the samples, each summed over the nodes in their order.
pub fn interpolate(nodes: &Sweep, re: &mut [f64], im: &mut [f64]) {
    let table = &*INTERPOLATION;
    Arch::new().dispatch(
        #[inline(always)]
        || {
            let (re, _) = re.as_chunks_mut::<BLOCK>();
            let (im, _) = im.as_chunks_mut::<BLOCK>();
            for (block, (re, im)) in re.iter_mut().zip(im).enumerate() {
                let (mut a, mut b) = ([0.0; BLOCK], [0.0; BLOCK]);
                for (z, row) in nodes.iter().zip(table) {
                    let weights = &row[block * BLOCK..][..BLOCK];
                    for n in 0..BLOCK {
                        a[n] += weights[n] * z.re;
                        b[n] += weights[n] * z.im;
                    }
                }
                (*re, *im) = (a, b);
            }
        },
    );
}

const _: () = assert!(SAMPLES.is_multiple_of(BLOCK));
