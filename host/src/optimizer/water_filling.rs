//! Water-filling: the power of each sub-carrier that maximises the rate.
//!
//! Appendix A of the paper: sum over active m of (1/gamma_0 - 1/gamma_m) = 1 with gamma_m the signal-to-noise ratio at
//! full power; rate = sum of log2(gamma_m / gamma_0). Exact, O(M log M): sorted once, the active set is a prefix.

/// Shares of the power (summing to 1) and the rate in bit per symbol.
#[derive(Debug, Clone, PartialEq)]
pub struct Allocation {
    /// Share of each sub-carrier, in the order given.
    pub shares: Vec<f64>,
    /// Sum of log2(1 + share gamma).
    pub rate_bit: f64,
}

/// `gamma`: signal-to-noise ratio of each sub-carrier if it had all the power. Zero and negative ones get nothing.
pub fn allocate(gamma: &[f64]) -> Allocation {
    let mut order: Vec<usize> = (0..gamma.len()).filter(|&m| gamma[m] > 0.0).collect();
    order.sort_by(|&a, &b| gamma[b].total_cmp(&gamma[a]));
    let mut level = 0.0;
    let mut inverse_sum = 0.0;
    for (count, &m) in order.iter().enumerate() {
        let with = (1.0 + inverse_sum + 1.0 / gamma[m]) / (count + 1) as f64;
        if with <= 1.0 / gamma[m] {
            break;
        }
        inverse_sum += 1.0 / gamma[m];
        level = with;
    }
    let shares: Vec<f64> =
        gamma.iter().map(|&g| if g > 0.0 { (level - 1.0 / g).max(0.0) } else { 0.0 }).collect();
    let rate_bit = shares.iter().zip(gamma).map(|(s, g)| libm::log2(1.0 + s * g.max(0.0))).sum();
    Allocation { shares, rate_bit }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numerics::random::Random;

    #[test]
    fn optimality_conditions_hold_on_random_instances() {
        let mut random = Random::new(8, 0, 0, 0);
        for _ in 0..500 {
            let m = 1 + (random.bits() % 40) as usize;
            let gamma: Vec<f64> = (0..m).map(|_| libm::exp(6.0 * random.gaussian())).collect();
            let found = allocate(&gamma);
            assert!((found.shares.iter().sum::<f64>() - 1.0).abs() < 1e-9);
            // active carriers share one level; inactive ones lie above it
            let level = found.shares.iter().zip(&gamma).filter(|(s, _)| **s > 0.0).map(|(s, g)| s + 1.0 / g);
            let level = level.fold(0.0, f64::max);
            for (s, g) in found.shares.iter().zip(&gamma) {
                let own = s + 1.0 / g;
                assert!(if *s > 0.0 {
                    (own / level - 1.0).abs() < 1e-9
                } else {
                    own >= level * (1.0 - 1e-12)
                });
            }
        }
    }
}
