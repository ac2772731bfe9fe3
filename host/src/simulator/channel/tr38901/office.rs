//! The clusters of QuaDRiGa: steps 4 to 7 of clause 7.5 at arrival, as random fields of the receiver's position (7.6.3).
//!
//! Each drop's delays and azimuths are stretched to the spread it drew, as QuaDRiGa does. `38901` itself has the whole procedure
//! ([`super::procedure`]).

use super::angles::{OFFSETS, azimuth, offset, scaling, zenith};
use super::clusters::{delays, large_scale, powers};
use super::parameters::{CLUSTER_CORRELATION_M, LSPS, Parameters};
use super::{Field, RAYS};
use crate::numerics::random::Random;
use crate::simulator::body::Vec3;
use std::f64::consts::{PI, TAU};

/// Random fields of one cluster.
#[derive(Debug, Clone)]
struct ClusterFields {
    delay: Field,
    shadow: Field,
    /// Sign and deviation of azimuth and zenith.
    azimuth: [Field; 2],
    zenith: [Field; 2],
    /// Initial phases of the rays.
    phases: [f64; RAYS],
}

/// One cluster at one place.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cluster {
    /// Delay behind the first path in s.
    pub delay_s: f64,
    /// Share of the power; a drop's shares and its direct share sum to 1.
    pub power: f64,
    /// Azimuth of arrival in rad, away from the direct path.
    pub azimuth: f64,
    /// Elevation of arrival in rad, away from the direct path.
    pub elevation: f64,
}

/// The channel at one place.
#[derive(Debug, Clone, PartialEq)]
pub struct Drop {
    pub clusters: Vec<Cluster>,
    /// Share of the direct path.
    pub direct: f64,
    /// Shadow fading in dB.
    pub shadow_db: f64,
}

/// The fields of one recording.
#[derive(Debug, Clone)]
pub struct Office {
    pub parameters: Parameters,
    factor: [[f64; LSPS]; LSPS],
    lsp: Vec<Field>,
    clusters: Vec<ClusterFields>,
}

impl Office {
    pub fn new(parameters: Parameters, random: &mut Random) -> Self {
        let lsp = parameters.correlation_m.iter().map(|&d| Field::new(d, random)).collect();
        let clusters = (0..parameters.clusters)
            .map(|_| {
                let mut field = || Field::new(CLUSTER_CORRELATION_M, random);
                let (delay, shadow) = (field(), field());
                let (azimuth, zenith) = ([field(), field()], [field(), field()]);
                let phases = std::array::from_fn(|_| TAU * random.uniform());
                ClusterFields { delay, shadow, azimuth, zenith, phases }
            })
            .collect();
        Office { factor: parameters.factor(), parameters, lsp, clusters }
    }

    /// Phase in rad of a ray of a cluster.
    pub fn phase(&self, cluster: usize, ray: usize) -> f64 {
        self.clusters[cluster].phases[ray]
    }

    /// The channel of a receiver at `place`.
    pub fn at(&self, place: Vec3) -> Drop {
        let p = &self.parameters;
        let white = std::array::from_fn(|i| self.lsp[i].at(place));
        let large = large_scale(p, &self.factor, &white);
        let delays = delays(p, large.delay_spread_s, self.clusters.iter().map(|c| c.delay.uniform_at(place)));
        let shadows = self.clusters.iter().map(|c| c.shadow.at(place));
        let powers = powers(p, large.delay_spread_s, &delays, shadows);
        let direct = large.direct(p);
        let strongest = powers.iter().copied().fold(0.0, f64::max);
        let (c_phi, c_theta) = scaling(p, large.k_db);
        let mut clusters: Vec<Cluster> = (0..powers.len())
            .map(|n| {
                let c = &self.clusters[n];
                let ratio = -libm::log(powers[n] / strongest);
                let sign = |field: &Field| if field.at(place) < 0.0 { -1.0 } else { 1.0 };
                let azimuth = sign(&c.azimuth[0]) * azimuth(ratio, large.asa_deg, c_phi)
                    + large.asa_deg / 7.0 * c.azimuth[1].at(place);
                let zenith = sign(&c.zenith[0]) * zenith(ratio, large.zsa_deg, c_theta)
                    + large.zsa_deg / 7.0 * c.zenith[1].at(place);
                Cluster {
                    delay_s: delays[n],
                    power: powers[n] * (1.0 - direct),
                    azimuth: azimuth * PI / 180.0,
                    elevation: zenith * PI / 180.0,
                }
            })
            .collect();
        stretch_delays(&mut clusters, direct, large.delay_spread_s);
        stretch_azimuths(&mut clusters, direct, p.c_asa * PI / 180.0, large.asa_deg * PI / 180.0);
        Drop { clusters, direct, shadow_db: large.shadow_db }
    }

    /// Rays of a drop's cluster: azimuth and elevation offsets in rad; azimuths and elevations are paired crosswise.
    pub fn ray_angles(&self, cluster: &Cluster, ray: usize) -> [f64; 2] {
        let p = &self.parameters;
        [
            cluster.azimuth + offset(ray) * p.c_asa * PI / 180.0,
            cluster.elevation + offset((7 * ray + 3) % RAYS) * p.c_zsa * PI / 180.0,
        ]
    }
}

/// Root mean square of delays about their mean.
fn delay_spread(clusters: &[Cluster], direct: f64) -> f64 {
    let moment = |n: i32| -> f64 { clusters.iter().map(|c| c.power * c.delay_s.powi(n)).sum() };
    let total = moment(0) + direct;
    let mean = moment(1) / total;
    (moment(2) / total - mean * mean).max(0.0).sqrt()
}

fn stretch_delays(clusters: &mut [Cluster], direct: f64, wanted: f64) {
    let found = delay_spread(clusters, direct);
    if found > 0.0 {
        clusters.iter_mut().for_each(|c| c.delay_s *= wanted / found);
    }
}

/// Root mean square of the rays' azimuths of arrival about their power-weighted mean, in rad, before they wrap.
fn azimuth_spread(clusters: &[Cluster], direct: f64, c_asa: f64) -> f64 {
    let moment = |n: i32| -> f64 { clusters.iter().map(|c| c.power * c.azimuth.powi(n)).sum() };
    let total = moment(0) + direct;
    let mean = moment(1) / total;
    let within = OFFSETS.iter().map(|o| o * o).sum::<f64>() / OFFSETS.len() as f64 * c_asa * c_asa;
    (moment(2) / total - mean * mean + within * moment(0) / total).sqrt()
}

/// Stretches the azimuths so that their spread is `wanted`; where the offsets within clusters already exceed it the clusters
/// share one azimuth.
fn stretch_azimuths(clusters: &mut [Cluster], direct: f64, c_asa: f64, wanted: f64) {
    let between = azimuth_spread(clusters, direct, 0.0);
    let within = {
        let whole = azimuth_spread(clusters, direct, c_asa);
        whole * whole - between * between
    };
    let stretch = (wanted * wanted - within).max(0.0).sqrt() / between.max(f64::MIN_POSITIVE);
    clusters.iter_mut().for_each(|c| c.azimuth *= stretch);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn spreads_of_ten_thousand_drops_are_the_tables() {
        for los in [true, false] {
            let p = Parameters::indoor_office(3.5e9, los);
            let (mut delays, mut azimuths) = (Vec::new(), Vec::new());
            for index in 0..10_000 {
                let office = Office::new(p.clone(), &mut Random::new(6, 0, u64::from(los), index));
                let drop = office.at([1.0, 2.0, 1.0]);
                delays.push(delay_spread(&drop.clusters, drop.direct));
                azimuths.push(azimuth_spread(&drop.clusters, drop.direct, p.c_asa * PI / 180.0));
                let power: f64 = drop.clusters.iter().map(|c| c.power).sum::<f64>() + drop.direct;
                assert!((power - 1.0).abs() < 1e-12);
            }
            let median = |values: &mut Vec<f64>| {
                values.sort_by(f64::total_cmp);
                values[values.len() / 2]
            };
            let delay = median(&mut delays) / libm::pow(10.0, p.lsp[0].0);
            let azimuth = median(&mut azimuths) * 180.0 / PI / libm::pow(10.0, p.lsp[2].0);
            assert!((delay - 1.0).abs() < 0.03, "los {los}: delay {delay}");
            assert!((azimuth - 1.0).abs() < 0.03, "los {los}: azimuth {azimuth}");
        }
    }
}
