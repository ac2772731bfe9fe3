//! Steps 4 to 6 of clause 7.5: large-scale parameters, delays and powers of clusters, and which clusters are too weak.

use super::parameters::{LSPS, Parameters};

/// A cluster this far below the strongest is removed, in dB.
const WEAKEST_DB: f64 = -25.0;

/// What a link drew of Table 7.5-6.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LargeScale {
    pub delay_spread_s: f64,
    /// Spreads of azimuth and zenith at departure and arrival in degrees.
    pub asd_deg: f64,
    pub asa_deg: f64,
    pub zsd_deg: f64,
    pub zsa_deg: f64,
    pub k_db: f64,
    /// Shadow fading in dB; positive is more power.
    pub shadow_db: f64,
}

fn ten(x: f64) -> f64 {
    libm::pow(10.0, x)
}

/// Step 4: correlated large-scale parameters from uncorrelated normal ones. Azimuth spreads are at most 104 degrees, zenith spreads 52.
pub fn large_scale(p: &Parameters, factor: &[[f64; LSPS]; LSPS], white: &[f64; LSPS]) -> LargeScale {
    let lsp: [f64; LSPS] = std::array::from_fn(|i| {
        let mixed: f64 = (0..=i).map(|k| factor[i][k] * white[k]).sum();
        p.lsp[i].0 + p.lsp[i].1 * mixed
    });
    LargeScale {
        delay_spread_s: ten(lsp[0]),
        asd_deg: ten(lsp[1]).min(104.0),
        asa_deg: ten(lsp[2]).min(104.0),
        zsd_deg: ten(lsp[5]).min(52.0),
        zsa_deg: ten(lsp[6]).min(52.0),
        k_db: lsp[4],
        shadow_db: lsp[3],
    }
}

impl LargeScale {
    /// Share of the direct ray in the power (eq. 7.5-7); 0 without line of sight.
    pub fn direct(&self, p: &Parameters) -> f64 {
        let k = ten(self.k_db / 10.0);
        if p.los { k / (k + 1.0) } else { 0.0 }
    }
}

/// Step 5: exponential delays of clusters behind the first in s (eqs. 7.5-1 and 2), in no order.
pub fn delays(p: &Parameters, delay_spread_s: f64, uniforms: impl Iterator<Item = f64>) -> Vec<f64> {
    let mut delays: Vec<f64> = uniforms.map(|u| -p.r_tau * delay_spread_s * libm::log(u)).collect();
    let first = delays.iter().copied().fold(f64::INFINITY, f64::min);
    delays.iter_mut().for_each(|d| *d -= first);
    delays
}

/// Step 5: C_tau, by which delays are divided in line of sight (eq. 7.5-3).
pub fn delay_scaling(k_db: f64) -> f64 {
    0.7705 - 0.0433 * k_db + 0.0002 * k_db * k_db + 0.000_017 * k_db * k_db * k_db
}

/// Step 6: shares of clusters in the power without the direct ray (eqs. 7.5-5 and 6): powers decay with the delay and are shadowed.
pub fn powers(
    p: &Parameters,
    delay_spread_s: f64,
    delays: &[f64],
    shadows: impl Iterator<Item = f64>,
) -> Vec<f64> {
    let mut powers: Vec<f64> = delays
        .iter()
        .zip(shadows)
        .map(|(d, shadow)| {
            let decay = libm::exp(-d * (p.r_tau - 1.0) / (p.r_tau * delay_spread_s));
            decay * ten(-p.zeta_db * shadow / 10.0)
        })
        .collect();
    let total: f64 = powers.iter().sum();
    powers.iter_mut().for_each(|power| *power /= total);
    powers
}

/// Step 6: which clusters stay.
pub fn strong_enough(powers: &[f64]) -> Vec<bool> {
    let least = powers.iter().copied().fold(0.0, f64::max) * ten(WEAKEST_DB / 10.0);
    powers.iter().map(|power| *power >= least).collect()
}

/// The two strongest clusters.
pub fn two_strongest(powers: &[f64]) -> [usize; 2] {
    let mut order: Vec<usize> = (0..powers.len()).collect();
    order.sort_by(|a, b| powers[*b].total_cmp(&powers[*a]));
    [order[0], order[1]]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numerics::random::Random;

    #[test]
    fn step_4_large_scale_parameters_are_the_tables() {
        for los in [true, false] {
            let p = Parameters::indoor_office(3.5e9, los);
            let factor = p.factor();
            let mut random = Random::new(4, 0, u64::from(los), 0);
            let n = 10_000;
            // in pairs of opposite signs, so that no mean is off by chance
            let drops: Vec<LargeScale> = (0..n / 2)
                .flat_map(|_| {
                    let white: [f64; LSPS] = std::array::from_fn(|_| random.gaussian());
                    [white, white.map(|x| -x)].map(|white| large_scale(&p, &factor, &white))
                })
                .collect();
            let moments = |f: &dyn Fn(&LargeScale) -> f64| {
                let mean = drops.iter().map(f).sum::<f64>() / f64::from(n);
                let square = drops.iter().map(|d| (f(d) - mean) * (f(d) - mean)).sum::<f64>() / f64::from(n);
                (mean, square.sqrt())
            };
            let lg = |x: f64| libm::log10(x);
            type Of = fn(&LargeScale) -> f64;
            let quantities: [(&str, Of, usize); 3] = [
                ("lg DS", |d| libm::log10(d.delay_spread_s), 0),
                ("SF dB", |d| d.shadow_db, 3),
                ("K dB", |d| d.k_db, 4),
            ];
            for (name, of, index) in quantities {
                let (mean, deviation) = moments(&of);
                let exact = p.lsp[index];
                println!(
                    "number: 38.901 step 4, line of sight {los}: {name} {mean:.3} +- {deviation:.3} (table: {:.3} +- {:.3})",
                    exact.0, exact.1
                );
                assert!((mean - exact.0).abs() <= 0.03 * exact.0.abs().max(exact.1), "{name} {mean}");
                assert!((deviation - exact.1).abs() <= 0.03 * exact.1, "{name} {deviation}");
            }
            // medians and what lies a deviation below them do not know the largest spreads
            for (name, index, of) in [
                ("ASD", 1, (|d: &LargeScale| d.asd_deg) as Of),
                ("ASA", 2, |d| d.asa_deg),
                ("ZSD", 5, |d| d.zsd_deg),
                ("ZSA", 6, |d| d.zsa_deg),
            ] {
                let mut values: Vec<f64> = drops.iter().map(of).collect();
                values.sort_by(f64::total_cmp);
                let median = values[values.len() / 2];
                let deviation = lg(median / values[(0.158_655 * values.len() as f64) as usize]);
                let exact = (ten(p.lsp[index].0), p.lsp[index].1);
                println!(
                    "number: 38.901 step 4, line of sight {los}: median {name} {median:.2} degrees, deviation of lg {deviation:.3} (table: {:.2}, {:.3})",
                    exact.0, exact.1
                );
                assert!((median / exact.0 - 1.0).abs() < 0.03, "{name} {median}");
                assert!((deviation / exact.1 - 1.0).abs() < 0.03, "{name} {deviation}");
            }
            let product = drops
                .iter()
                .map(|d| (lg(d.delay_spread_s) - p.lsp[0].0) / p.lsp[0].1 * d.shadow_db / p.lsp[3].1);
            let found = product.sum::<f64>() / f64::from(n);
            println!(
                "number: 38.901 step 4, line of sight {los}: correlation of DS and SF {found:.3} (table: {})",
                p.cross[0][3]
            );
            assert!((found - p.cross[0][3]).abs() < 0.03, "{found}");
        }
    }

    #[test]
    fn step_6_clusters_25_decibels_below_the_strongest_are_removed() {
        for los in [true, false] {
            let p = Parameters::indoor_office(3.5e9, los);
            let mut random = Random::new(6, 1, u64::from(los), 0);
            let (mut stay, mut left, n) = (0, 0.0, 10_000);
            let mut decay = [0.0; 2];
            for _ in 0..n {
                let uniforms: Vec<f64> = (0..p.clusters).map(|_| 1.0 - random.uniform()).collect();
                let delays = delays(&p, 20e-9, uniforms.into_iter());
                let shadows: Vec<f64> = (0..p.clusters).map(|_| random.gaussian()).collect();
                let powers = powers(&p, 20e-9, &delays, shadows.iter().copied());
                let kept = strong_enough(&powers);
                let most = powers.iter().copied().fold(0.0, f64::max);
                for ((power, kept), (delay, shadow)) in
                    powers.iter().zip(&kept).zip(delays.iter().zip(&shadows))
                {
                    let below = 10.0 * libm::log10(power / most);
                    assert_eq!(*kept, below >= -25.0, "{below}");
                    stay += usize::from(*kept);
                    left += if *kept { *power } else { 0.0 };
                    // the law without shadowing: ln of the power against the delay
                    decay[0] += delay
                        * (libm::log(*power / powers[0])
                            + 0.1 * libm::log(10.0) * p.zeta_db * (shadow - shadows[0]));
                    decay[1] += delay * (delay - delays[0]);
                }
            }
            let found = decay[0] / decay[1] * 20e-9;
            let exact = -(p.r_tau - 1.0) / p.r_tau;
            println!(
                "number: 38.901 step 6, line of sight {los}: decay {found:.4} per delay spread (eq. 7.5-5: {exact:.4}); {:.2} of {} clusters stay with {:.4} of the power",
                stay as f64 / f64::from(n),
                p.clusters,
                left / f64::from(n)
            );
            assert!((found / exact - 1.0).abs() < 0.03);
            assert!(left / f64::from(n) > 0.99);
        }
    }
}
