//! Steps 2 and 3 of clause 7.5, and the table of step 4: the state of a link, its path loss, and what Table 7.5-6 gives for an indoor
//! office. The table's zenith spread of departure is in Table 7.5-10.

use crate::numerics::random::Random;
use crate::simulator::body::{Vec3, sub};
use crate::simulator::channel::target::NEAREST_M;
use crate::simulator::channel::{free_space, wavelength};

/// Large-scale parameters, in the order of the fields: DS, ASD, ASA, SF, K, ZSD, ZSA.
pub const LSPS: usize = 7;
/// Delay spread within a cluster in s where the table gives none.
pub const CLUSTER_DELAY_SPREAD_S: f64 = 3.91e-9;
/// Mean and deviation of the logarithm (base 10) of the excess delay without line of sight in s, and its correlation distance in m
/// (Table 7.6.9-1).
pub const EXCESS_DELAY: (f64, f64) = (-8.6, 0.1);
pub const EXCESS_CORRELATION_M: f64 = 10.0;
/// Correlation distance of cluster variables indoors in m (Table 7.6.3.1-2).
pub const CLUSTER_CORRELATION_M: f64 = 10.0;

/// What Table 7.5-6 gives for one condition at one carrier. Angles in degrees, logarithms to base 10.
#[derive(Debug, Clone, PartialEq)]
pub struct Parameters {
    /// Mean and deviation of lg(DS/s), lg(ASD), lg(ASA), SF (dB), K (dB), lg(ZSD), lg(ZSA).
    pub lsp: [(f64, f64); LSPS],
    pub r_tau: f64,
    pub clusters: usize,
    /// Spread of a cluster's azimuths and zeniths of arrival.
    pub c_asa: f64,
    pub c_zsa: f64,
    /// Spread of a cluster's azimuths and zeniths of departure; the zeniths' is 3/8 of the median of ZSD (eq. 7.5-20).
    pub c_asd: f64,
    pub c_zsd: f64,
    /// Mean and deviation of the cross-polarisation power ratio in dB.
    pub xpr_db: (f64, f64),
    /// Per-cluster shadowing in dB.
    pub zeta_db: f64,
    /// Scaling of azimuths and zeniths for this number of clusters.
    pub c_phi: f64,
    pub c_theta: f64,
    /// Correlation distance of each parameter in m.
    pub correlation_m: [f64; LSPS],
    /// Correlation of the parameters.
    pub cross: [[f64; LSPS]; LSPS],
    pub los: bool,
}

/// A symmetric matrix from its entries above the diagonal.
fn symmetric(entries: &[(usize, usize, f64)]) -> [[f64; LSPS]; LSPS] {
    let mut matrix = [[0.0; LSPS]; LSPS];
    (0..LSPS).for_each(|i| matrix[i][i] = 1.0);
    for &(i, j, value) in entries {
        matrix[i][j] = value;
        matrix[j][i] = value;
    }
    matrix
}

impl Parameters {
    /// Indoor office at a carrier in Hz; below 6 GHz the table's values at 6 GHz hold.
    pub fn indoor_office(carrier_hz: f64, los: bool) -> Self {
        let x = libm::log10(1.0 + (carrier_hz / 1e9).max(6.0));
        const DS: usize = 0;
        const ASD: usize = 1;
        const ASA: usize = 2;
        const SF: usize = 3;
        const K: usize = 4;
        const ZSD: usize = 5;
        const ZSA: usize = 6;
        if los {
            Parameters {
                lsp: [
                    (-7.692 - 0.01 * x, 0.18),
                    (1.60, 0.18),
                    (1.781 - 0.19 * x, 0.119 + 0.12 * x),
                    (0.0, 3.0),
                    (7.0, 4.0),
                    (2.228 - 1.43 * x, 0.30 + 0.13 * x),
                    (1.44 - 0.26 * x, 0.264 - 0.04 * x),
                ],
                r_tau: 3.6,
                clusters: 15,
                c_asa: 8.0,
                c_zsa: 9.0,
                c_asd: 5.0,
                c_zsd: 0.375 * libm::pow(10.0, 2.228 - 1.43 * x),
                xpr_db: (11.0, 4.0),
                zeta_db: 6.0,
                c_phi: 1.211,
                c_theta: 1.1088,
                correlation_m: [8.0, 7.0, 5.0, 10.0, 4.0, 4.0, 4.0],
                cross: symmetric(&[
                    (ASD, DS, 0.6),
                    (ASA, DS, 0.8),
                    (ASA, SF, -0.5),
                    (ASD, SF, -0.4),
                    (DS, SF, -0.8),
                    (ASD, ASA, 0.4),
                    (DS, K, -0.5),
                    (SF, K, 0.5),
                    (ZSD, SF, 0.2),
                    (ZSA, SF, 0.3),
                    (ZSA, K, 0.1),
                    (ZSD, DS, 0.1),
                    (ZSA, DS, 0.2),
                    (ZSD, ASD, 0.5),
                    (ZSA, ASA, 0.5),
                ]),
                los,
            }
        } else {
            Parameters {
                lsp: [
                    (-7.173 - 0.28 * x, 0.055 + 0.10 * x),
                    (1.62, 0.25),
                    (1.863 - 0.11 * x, 0.059 + 0.12 * x),
                    (0.0, 8.03),
                    (0.0, 0.0),
                    (1.08, 0.36),
                    (1.387 - 0.15 * x, 0.746 - 0.09 * x),
                ],
                r_tau: 3.0,
                clusters: 19,
                c_asa: 11.0,
                c_zsa: 9.0,
                c_asd: 5.0,
                c_zsd: 0.375 * libm::pow(10.0, 1.08),
                xpr_db: (10.0, 4.0),
                zeta_db: 3.0,
                c_phi: 1.273,
                c_theta: 1.184,
                correlation_m: [5.0, 3.0, 3.0, 6.0, 4.0, 4.0, 4.0],
                cross: symmetric(&[
                    (ASD, DS, 0.4),
                    (ASA, SF, -0.4),
                    (DS, SF, -0.5),
                    (ZSD, DS, -0.27),
                    (ZSA, DS, -0.06),
                    (ZSD, ASD, 0.35),
                    (ZSA, ASD, 0.23),
                    (ZSD, ASA, -0.08),
                    (ZSA, ASA, 0.43),
                    (ZSD, ZSA, 0.42),
                ]),
                los,
            }
        }
    }

    /// Lower triangle L with L L^T the cross correlation.
    pub fn factor(&self) -> [[f64; LSPS]; LSPS] {
        let mut l = [[0.0; LSPS]; LSPS];
        for i in 0..LSPS {
            for j in 0..=i {
                let below: f64 = (0..j).map(|k| l[i][k] * l[j][k]).sum();
                let rest = self.cross[i][j] - below;
                l[i][j] = if i == j { rest.max(0.0).sqrt() } else { rest / l[j][j].max(1e-12) };
            }
        }
        l
    }

    /// Path loss in dB at a distance in m and a carrier in Hz, without shadowing.
    pub fn path_loss_db(&self, distance_m: f64, carrier_hz: f64) -> f64 {
        let (d, f) = (libm::log10(distance_m.max(1.0)), libm::log10(carrier_hz / 1e9));
        let los = 32.4 + 17.3 * d + 20.0 * f;
        if self.los { los } else { los.max(17.3 + 38.3 * d + 24.9 * f) }
    }

    /// Path loss in dB, and that of free space nearer than the table's 1 m.
    pub fn loss_db(&self, distance_m: f64, carrier_hz: f64) -> f64 {
        if distance_m < 1.0 {
            -20.0 * libm::log10(free_space(distance_m.max(NEAREST_M), wavelength(carrier_hz)))
        } else {
            self.path_loss_db(distance_m, carrier_hz)
        }
    }
}

/// Step 2: probability of line of sight in an open office at a horizontal distance in m (Table 7.4.2-1).
pub fn line_of_sight_probability(distance_m: f64) -> f64 {
    match distance_m {
        d if d <= 5.0 => 1.0,
        d if d <= 49.0 => libm::exp(-(d - 5.0) / 70.8),
        d => 0.54 * libm::exp(-(d - 49.0) / 211.7),
    }
}

/// Step 2: draws the state of a link; never in sight where `possible` is false.
pub fn in_sight(possible: bool, from: Vec3, to: Vec3, random: &mut Random) -> bool {
    let [dx, dy, _] = sub(to, from);
    random.uniform() < line_of_sight_probability((dx * dx + dy * dy).sqrt()) && possible
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_table_at_the_papers_carriers() {
        let at = |carrier: f64, los: bool| {
            let p = Parameters::indoor_office(carrier, los);
            (libm::pow(10.0, p.lsp[0].0) * 1e9, libm::pow(10.0, p.lsp[2].0), libm::pow(10.0, p.lsp[6].0))
        };
        for (carrier, los, ds, asa, zsa) in [
            (3.5e9, true, 19.9, 41.7, 16.6),
            (3.5e9, false, 38.9, 58.9, 18.2),
            (60e9, true, 19.5, 27.7, 9.5),
            (60e9, false, 21.2, 46.4, 13.2),
        ] {
            let found = at(carrier, los);
            assert!((found.0 - ds).abs() < 0.06 && (found.1 - asa).abs() < 0.06, "{found:?}");
            assert!((found.2 - zsa).abs() < 0.06, "{found:?}");
        }
    }

    #[test]
    fn correlations_can_be_factored() {
        for los in [true, false] {
            let p = Parameters::indoor_office(3.5e9, los);
            let l = p.factor();
            for i in 0..LSPS {
                for j in 0..LSPS {
                    let product: f64 = (0..LSPS).map(|k| l[i][k] * l[j][k]).sum();
                    assert!((product - p.cross[i][j]).abs() < 1e-9, "{los} {i} {j}: {product}");
                }
            }
        }
    }

    #[test]
    fn step_2_links_are_in_sight_as_often_as_in_an_open_office() {
        let mut random = Random::new(1, 0, 0, 0);
        // by hand: exp(-25 / 70.8) at 30 m, 0.54 exp(-51 / 211.7) at 100 m
        for (distance, exact) in [(4.0, 1.0), (30.0, 0.7025), (100.0, 0.4244)] {
            let n = 10_000;
            let seen = (0..n).filter(|_| in_sight(true, [0.0; 3], [0.0, distance, 2.0], &mut random)).count();
            let found = seen as f64 / f64::from(n);
            println!(
                "number: 38.901 step 2, line of sight at {distance} m {found:.3} (Table 7.4.2-1: {exact})"
            );
            assert!((found / exact - 1.0).abs() < 0.03, "{distance} m: {found}");
            assert!(!in_sight(false, [0.0; 3], [0.0, distance, 2.0], &mut random));
        }
    }

    #[test]
    fn step_3_path_loss_is_the_tables() {
        // by hand at 10 m and 3.5 GHz: 32.4 + 17.3 + 20 lg 3.5, and 38.3 + 17.3 + 24.9 lg 3.5
        for (los, exact) in [(true, 60.58), (false, 69.15)] {
            let found = Parameters::indoor_office(3.5e9, los).loss_db(10.0, 3.5e9);
            println!(
                "number: 38.901 step 3, path loss at 10 m, line of sight {los}: {found:.2} dB (Table 7.4.1-1: {exact} dB)"
            );
            assert!((found - exact).abs() < 0.01, "{found}");
        }
        let near = Parameters::indoor_office(3.5e9, true);
        assert!((near.loss_db(1.0, 3.5e9) - near.loss_db(0.999, 3.5e9)).abs() < 0.1);
    }
}
