//! `38901`: 3GPP TR 38.901 indoor office with spatial consistency and the sensing additions' human.
//!
//! Table 7.5-6 and the procedure of clause 7.5; large-scale parameters and cluster variables are random fields of the receiver's
//! position (7.6.3), so that neighbours see the same clusters. A person is one scatterer with the aspect-dependent cross section
//! of clause 7.9.2, model 2. Each drop's delays and azimuths are stretched to the spread it drew, as QuaDRiGa does: the
//! procedure alone leaves them some per cent off.

use super::field::Field;
use super::room::{free_space, mean_power};
use super::target::{Target, direct, scattered};
use super::{ChannelModel, Path, Scene, phasor, wavelength};
use crate::numerics::random::Random;
use crate::scenario::{SPEED_OF_LIGHT, Scenario};
use crate::simulator::body::{Vec3, dot, norm, sub};
use std::f64::consts::{PI, TAU};

/// Large-scale parameters, in the order of the fields: DS, ASD, ASA, SF, K, ZSD, ZSA.
const LSPS: usize = 7;
/// Rays of a cluster.
const RAYS: usize = 20;
/// Offsets of the rays in units of the cluster's spread (Table 7.5-3), each with both signs.
const OFFSETS: [f64; RAYS / 2] =
    [0.0447, 0.1413, 0.2492, 0.3715, 0.5129, 0.6797, 0.8844, 1.1481, 1.5195, 2.1551];
/// Correlation distance of cluster variables indoors in m (Table 7.6.3.1-2).
const CLUSTER_CORRELATION_M: f64 = 10.0;

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
    fn factor(&self) -> [[f64; LSPS]; LSPS] {
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
}

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
    /// Delay behind the first way in s.
    pub delay_s: f64,
    /// Share of the power; a drop's shares and its direct share sum to 1.
    pub power: f64,
    /// Azimuth of arrival in rad, away from the direct way.
    pub azimuth: f64,
    /// Elevation of arrival in rad, away from the direct way.
    pub elevation: f64,
}

/// The channel at one place.
#[derive(Debug, Clone, PartialEq)]
pub struct Drop {
    pub clusters: Vec<Cluster>,
    /// Share of the direct way.
    pub direct: f64,
    /// Shadow fading in dB.
    pub shadow_db: f64,
    /// The delay spread it drew in s.
    pub delay_spread_s: f64,
    /// The azimuth spread of arrival it drew in rad.
    pub azimuth_spread: f64,
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
        let white: Vec<f64> = self.lsp.iter().map(|field| field.at(place)).collect();
        let lsp: [f64; LSPS] = std::array::from_fn(|i| {
            let mixed: f64 = (0..=i).map(|k| self.factor[i][k] * white[k]).sum();
            p.lsp[i].0 + p.lsp[i].1 * mixed
        });
        let ten = |x: f64| libm::pow(10.0, x);
        let delay_spread = ten(lsp[0]);
        let asa = ten(lsp[2]).min(104.0);
        let zsa = ten(lsp[6]).min(52.0);
        let k_db = lsp[4];
        // 7.5 step 5: exponential delays
        let mut delays: Vec<f64> = self
            .clusters
            .iter()
            .map(|c| -p.r_tau * delay_spread * libm::log(c.delay.uniform_at(place)))
            .collect();
        let first = delays.iter().copied().fold(f64::INFINITY, f64::min);
        delays.iter_mut().for_each(|d| *d -= first);
        // step 6: powers decay with the delay and are shadowed
        let mut powers: Vec<f64> = delays
            .iter()
            .zip(&self.clusters)
            .map(|(d, c)| {
                let decay = libm::exp(-d * (p.r_tau - 1.0) / (p.r_tau * delay_spread));
                decay * ten(-p.zeta_db * c.shadow.at(place) / 10.0)
            })
            .collect();
        let total: f64 = powers.iter().sum();
        let k = ten(k_db / 10.0);
        let direct = if p.los { k / (k + 1.0) } else { 0.0 };
        powers.iter_mut().for_each(|power| *power /= total);
        // step 7: angles by the power angular spectrum
        let strongest = powers.iter().copied().fold(0.0, f64::max);
        let (c_phi, c_theta) = if p.los {
            let kd = k_db;
            (
                p.c_phi * (1.1035 - 0.028 * kd - 0.002 * kd * kd + 0.0001 * kd * kd * kd),
                p.c_theta * (1.3086 + 0.0339 * kd - 0.0077 * kd * kd + 0.0002 * kd * kd * kd),
            )
        } else {
            (p.c_phi, p.c_theta)
        };
        let mut clusters: Vec<Cluster> = (0..powers.len())
            .map(|n| {
                let c = &self.clusters[n];
                let ratio = -libm::log(powers[n] / strongest);
                let sign = |field: &Field| if field.at(place) < 0.0 { -1.0 } else { 1.0 };
                let azimuth = sign(&c.azimuth[0]) * 2.0 * (asa / 1.4) * ratio.sqrt() / c_phi
                    + asa / 7.0 * c.azimuth[1].at(place);
                let zenith = sign(&c.zenith[0]) * zsa * ratio / c_theta + zsa / 7.0 * c.zenith[1].at(place);
                Cluster {
                    delay_s: delays[n],
                    power: powers[n] * (1.0 - direct),
                    azimuth: azimuth * PI / 180.0,
                    elevation: zenith * PI / 180.0,
                }
            })
            .collect();
        let azimuth_spread = asa * PI / 180.0;
        stretch_delays(&mut clusters, direct, delay_spread);
        stretch_azimuths(&mut clusters, direct, p.c_asa * PI / 180.0, azimuth_spread);
        Drop { clusters, direct, shadow_db: lsp[3], delay_spread_s: delay_spread, azimuth_spread }
    }

    /// Rays of a drop's cluster: azimuth and elevation offsets in rad; azimuths and elevations are paired crosswise.
    pub fn ray_angles(&self, cluster: &Cluster, ray: usize) -> [f64; 2] {
        let offset = |ray: usize| OFFSETS[ray / 2] * if ray.is_multiple_of(2) { 1.0 } else { -1.0 };
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

/// Direction of a ray: offsets from the direct way's azimuth and elevation.
pub fn direction(towards: Vec3, [azimuth, elevation]: [f64; 2]) -> Vec3 {
    super::ieee80211ay::turned(towards, [azimuth, elevation])
}

/// Aspect-dependent cross section of a person in dBsm (clause 7.9.2, model 2): two lobes, front and back.
///
/// `azimuth` and `zenith` in rad of the bisector in the body's frame, `bistatic` the angle between both ways in rad.
pub fn human_dbsm(azimuth: f64, zenith: f64, bistatic: f64) -> f64 {
    const MOST: f64 = 2.14;
    const RANGE: f64 = 7.7;
    let (az, th, beta) = (azimuth * 180.0 / PI, zenith * 180.0 / PI, bistatic * 180.0 / PI);
    let vertical = (12.0 * ((th - 90.0) / 55.7) * ((th - 90.0) / 55.7)).min(RANGE);
    let lobe = |centre: f64| {
        let off = (az - centre) - 360.0 * ((az - centre) / 360.0).round();
        (12.0 * (off / 216.65) * (off / 216.65)).min(RANGE)
    };
    let horizontal = lobe(0.0).min(lobe(180.0));
    let bent = 0.5714 * libm::sin(0.1 * beta / 2.0 * PI / 180.0)
        - 5.0 * libm::log10(libm::cos(beta * PI / 360.0).max(1e-6));
    (MOST - (vertical + horizontal).min(RANGE) - bent).max(MOST - RANGE)
}

/// Root of a person's cross section in m at `t` seconds; `scatter` is its lognormal factor.
fn human_root(target: &Target, scene: &Scene, scatter: f64) -> f64 {
    let centre = target.centre(scene.time_s);
    let (a, b) = (sub(scene.from, centre), sub(scene.to, centre));
    let (a, b) = (super::ieee80211ay::unit(a), super::ieee80211ay::unit(b));
    let bisector = super::ieee80211ay::unit([a[0] + b[0], a[1] + b[1], a[2] + b[2]]);
    let heading = target.person.truth.heading_deg * PI / 180.0;
    let azimuth = libm::atan2(bisector[1], bisector[0]) - heading;
    let zenith = libm::acos(bisector[2].clamp(-1.0, 1.0));
    let beta = libm::acos(dot(a, b).clamp(-1.0, 1.0));
    let size = target.person.truth.height_m / 1.75;
    target.gain * size * (libm::pow(10.0, human_dbsm(azimuth, zenith, beta) / 10.0) * scatter).sqrt()
}

#[derive(Debug)]
pub struct IndoorOffice {
    office: Office,
    carrier_hz: f64,
    room_power: f64,
    /// The target's own fading (3.94 dB, mean 1) and its phase.
    scatter: f64,
    phase: f64,
    /// The drop of a place that has not moved.
    held: Option<(Vec3, Drop)>,
}

impl IndoorOffice {
    pub fn new(scenario: &Scenario, mut random: Random) -> Self {
        let parameters = Parameters::indoor_office(scenario.radar.carrier_hz, scenario.channel.line_of_sight);
        let office = Office::new(parameters, &mut random);
        let deviation = 3.94;
        let mean = -std::f64::consts::LN_10 / 20.0 * deviation * deviation;
        let db = (mean + deviation * random.gaussian()).min(mean + 3.0 * deviation);
        IndoorOffice {
            office,
            carrier_hz: scenario.radar.carrier_hz,
            room_power: mean_power(scenario),
            scatter: libm::pow(10.0, db / 10.0),
            phase: TAU * random.uniform(),
            held: None,
        }
    }

    /// Mean power ratio, shadowing included.
    fn gain(&self, scene: &Scene, shadow_db: f64) -> f64 {
        if scene.monostatic() {
            return self.room_power;
        }
        let distance = scene.distance_m();
        let loss = if distance < 1.0 {
            let free = free_space(distance.max(0.1), wavelength(self.carrier_hz));
            -20.0 * libm::log10(free)
        } else {
            self.office.parameters.path_loss_db(distance, self.carrier_hz)
        };
        libm::pow(10.0, (shadow_db - loss) / 10.0)
    }
}

impl ChannelModel for IndoorOffice {
    fn paths(&mut self, scene: &Scene, paths: &mut Vec<Path>) {
        let lambda = wavelength(self.carrier_hz);
        if self.held.as_ref().is_none_or(|(place, _)| *place != scene.to) {
            self.held = Some((scene.to, self.office.at(scene.to)));
        }
        let Some((_, drop)) = &self.held else { return };
        let gain = self.gain(scene, drop.shadow_db);
        // the radar has no direct way: its clusters have all the power, 2 m behind it
        let (spread, first) = match direct(scene, lambda) {
            Some(path) => {
                if drop.direct > 0.0 {
                    let unit = path.gain / path.gain.norm();
                    paths.push(Path { gain: unit * (gain * drop.direct).sqrt(), ..path });
                }
                (gain, path.delay_s)
            }
            None => (gain / (1.0 - drop.direct), 2.0 / SPEED_OF_LIGHT),
        };
        let towards = if scene.monostatic() {
            [1.0, 0.0, 0.0]
        } else {
            super::ieee80211ay::unit(sub(scene.from, scene.to))
        };
        for (n, cluster) in drop.clusters.iter().enumerate() {
            let amplitude = (spread * cluster.power / RAYS as f64).sqrt();
            for ray in 0..RAYS {
                let arrival = direction(towards, self.office.ray_angles(cluster, ray));
                // the phase turns as the receiver moves along the ray
                let turns = dot(arrival, scene.to) / lambda;
                let phase = self.office.phase(n, ray) + TAU * (turns - turns.floor());
                paths.push(Path {
                    gain: phasor(phase) * amplitude,
                    delay_s: first + cluster.delay_s,
                    departure: arrival,
                    arrival,
                });
            }
        }
        for person in scene.people {
            let root = human_root(person, scene, self.scatter);
            paths.push(scattered(scene, person.centre(scene.time_s), root, lambda, self.phase));
        }
    }
}

/// Length of a vector between two points in m.
pub fn between(a: Vec3, b: Vec3) -> f64 {
    norm(sub(a, b))
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

    #[test]
    fn a_human_is_widest_in_front_and_behind() {
        let front = human_dbsm(0.0, PI / 2.0, 0.0);
        assert!((front - 2.14).abs() < 1e-12);
        assert!((human_dbsm(PI, PI / 2.0, 0.0) - front).abs() < 1e-9);
        assert!(human_dbsm(PI / 2.0, PI / 2.0, 0.0) < front - 2.0);
        assert!((human_dbsm(0.0, 0.0, 0.0) - (2.14 - 7.7)).abs() < 1e-9);
    }
}
