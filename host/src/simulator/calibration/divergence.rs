//! Kullback-Leibler divergence of intensity distributions, and its minimum over rho.
//!
//! Eq. (fitting) of the paper: D(measured || simulated) over F = 64 levels. One count is added to every simulated level; the black
//! level, which holds all that is weaker than the range, is counted or left out, and both are reported.

use super::intensity::LEVELS;
use crate::results::KlPoint;

/// Counts of each level.
pub type Counts = [u64; LEVELS];

/// First pass of the search, as 1 - rho: logarithmic, then no innovation at all.
const GRID: [f64; 20] = [
    0.08, 0.056, 0.04, 0.028, 0.02, 0.014, 0.01, 0.007, 0.005, 0.0035, 0.0025, 0.0018, 0.0012, 0.0008,
    0.0004, 0.0002, 1e-4, 5e-5, 2e-5, 0.0,
];
/// Steps of the golden section: the bracket shrinks to 2 per cent of 1 - rho.
const GOLDEN_STEPS: usize = 9;

/// Evaluations of a whole search, at most.
pub const EVALUATIONS: u64 = (GRID.len() + GOLDEN_STEPS + 2) as u64;

/// Share of each level.
pub fn shares(counts: &Counts) -> Vec<f64> {
    let total: u64 = counts.iter().sum();
    counts.iter().map(|&n| n as f64 / total.max(1) as f64).collect()
}

/// D(measured || simulated) in nats over the levels from `skip` on.
pub fn divergence(measured: &Counts, simulated: &Counts, skip: usize) -> f64 {
    let total: u64 = measured[skip..].iter().sum();
    let simulated_total: u64 = simulated[skip..].iter().map(|n| n + 1).sum();
    let (m, s) = (total.max(1) as f64, simulated_total as f64);
    let levels = measured[skip..].iter().zip(&simulated[skip..]).filter(|(p, _)| **p > 0);
    levels
        .map(|(&p, &q)| {
            let (p, q) = (p as f64 / m, (q + 1) as f64 / s);
            p * libm::log(p / q)
        })
        .sum()
}

/// The curve over rho, ascending, the counts simulated at each of its points, and the place of its minimum.
pub fn search(
    measured: &Counts,
    mut simulate: impl FnMut(f64) -> Counts,
) -> (Vec<KlPoint>, Vec<Counts>, usize) {
    let mut found: Vec<(KlPoint, Counts)> = Vec::new();
    let mut evaluate = |away: f64, found: &mut Vec<(KlPoint, Counts)>| -> f64 {
        // to the fifth digit, near 1 to the seventh, so that tables and pages show what was used
        let digits = if away < 1e-3 { 1e7 } else { 1e5 };
        let rho = (digits * (1.0 - away)).round() / digits;
        if let Some((point, _)) = found.iter().find(|(point, _)| point.rho == rho) {
            return point.kl;
        }
        let simulated = simulate(rho);
        let kl = divergence(measured, &simulated, 0);
        let kl_without_floor = divergence(measured, &simulated, 1);
        found.push((KlPoint { rho, kl, kl_without_floor }, simulated));
        kl
    };
    let grid: Vec<f64> = GRID.iter().map(|&away| evaluate(away, &mut found)).collect();
    let best = (0..grid.len()).min_by(|&a, &b| grid[a].total_cmp(&grid[b])).unwrap_or(0);
    // golden section over ln(1 - rho) between the neighbours of the grid's minimum
    let log = |k: usize| libm::log(GRID[k].max(0.4 * GRID[GRID.len() - 2]));
    let (mut low, mut high) = (log((best + 1).min(GRID.len() - 1)), log(best.saturating_sub(1)));
    let share = 0.5 * (5.0_f64.sqrt() - 1.0);
    let (mut a, mut b) = (high - share * (high - low), low + share * (high - low));
    let mut at = |x: f64, found: &mut Vec<_>| evaluate(libm::exp(x), found);
    let (mut fa, mut fb) = (at(a, &mut found), at(b, &mut found));
    for _ in 0..GOLDEN_STEPS {
        if fa <= fb {
            (high, b, fb) = (b, a, fa);
            a = high - share * (high - low);
            fa = at(a, &mut found);
        } else {
            (low, a, fa) = (a, b, fb);
            b = low + share * (high - low);
            fb = at(b, &mut found);
        }
    }
    found.sort_by(|x, y| x.0.rho.total_cmp(&y.0.rho));
    let best = (0..found.len()).min_by(|&x, &y| found[x].0.kl.total_cmp(&found[y].0.kl)).unwrap_or(0);
    let (curve, counts) = found.into_iter().unzip();
    (curve, counts, best)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn divergence_is_zero_for_equals_and_finite_for_what_is_never_simulated() {
        let even = [1_000_000; LEVELS];
        assert!(divergence(&even, &even, 0).abs() < 1e-12);
        let mut other = even;
        (other[3], other[4]) = (2_000_000, 0);
        // level 4: (1/64) ln(1e6), level 3: -(1/64) ln 2, to the accuracy of the one count
        let exact = (libm::log(1e6) - libm::log(2.0)) / 64.0;
        assert!((divergence(&even, &other, 0) - exact).abs() < 1e-5);
        assert!(divergence(&even, &other, 5).abs() < 1e-12);
    }

    #[test]
    fn the_search_finds_the_minimum_of_a_smooth_curve() {
        // geometric distributions over the levels, their rate a function of rho
        let counts = |rho: f64| -> Counts {
            let q = 0.5 + 0.03 * libm::log(1.0 - rho + 1e-6);
            std::array::from_fn(|k| (1e6 * libm::pow(0.95 - 0.3 * q.abs(), k as f64)) as u64)
        };
        for rho in [0.96, 0.9876, 0.9931, 0.9973, 0.9985, 0.9997, 0.99992, 0.99997] {
            let (curve, _, best) = search(&counts(rho), counts);
            assert!((curve[best].rho - rho).abs() < 0.03 * (1.0 - rho), "{rho}: {}", curve[best].rho);
            assert!(curve.windows(2).all(|pair| pair[0].rho < pair[1].rho));
        }
    }
}
