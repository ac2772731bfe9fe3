//! Steps 4 to 11 of clause 7.5 for one link: from what it draws to its rays.
//!
//! What the standard holds fixed in a drop is drawn where the link begins ([`Procedure`]): signs of angles, coupling, polarisation, and
//! which clusters are the first, the strongest and the removed ones. The rest may change with the receiver's place ([`super::variables`]).
//!
//! Spreads are stretched to what a drop drew, as QuaDRiGa does: the steps alone leave them some per cent off.

use super::angles::{coupling, offset, scaling, stretch};
use super::clusters::{delay_scaling, delays, large_scale, powers, strong_enough, two_strongest};
use super::link::{Link, Ray};
use super::parameters::{CLUSTER_DELAY_SPREAD_S, EXCESS_DELAY, LSPS, Parameters};
use super::polarisation::{self, Matrix};
use super::variables::{ANGLES, Variables};
use super::{RAYS, angles};
use crate::numerics::random::Random;
use crate::scenario::SPEED_OF_LIGHT;
use std::f64::consts::PI;

/// All rays of a cluster.
pub const EVERY_RAY: [usize; RAYS] = [0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16, 17, 18, 19];
/// Step 11: rays of the three sub-clusters of a strong cluster (Table 7.5-5), counted from 0.
pub const SUB_CLUSTERS: [&[usize]; 3] =
    [&[0, 1, 2, 3, 4, 5, 6, 7, 18, 19], &[8, 9, 10, 11, 16, 17], &[12, 13, 14, 15]];
/// Their delays in units of the cluster's delay spread (eq. 7.5-26).
const SUB_DELAYS: [f64; 3] = [0.0, 1.28, 2.56];

/// What a drop keeps of a cluster.
#[derive(Debug, Clone)]
struct Constants {
    number: usize,
    signs: [f64; ANGLES],
    /// Which ray's offset each ray has, by angle.
    coupled: [[usize; RAYS]; ANGLES],
    /// Delays of the rays behind the cluster's in s.
    behind_s: [f64; RAYS],
    matrices: [Matrix; RAYS],
}

/// The procedure of one drop.
#[derive(Debug, Clone)]
pub struct Procedure {
    pub parameters: Parameters,
    factor: [[f64; LSPS]; LSPS],
    /// Number of the first cluster.
    first: usize,
    clusters: Vec<Constants>,
    longest_excess_s: f64,
}

impl Procedure {
    /// A drop that begins with `at`, in a room with sides up to `room_m`.
    pub fn new(parameters: Parameters, at: &Variables, room_m: f64, random: &mut Random) -> Self {
        let factor = parameters.factor();
        let large = large_scale(&parameters, &factor, &at.large);
        let delays = delays(&parameters, large.delay_spread_s, at.clusters.iter().map(|c| c.delay));
        let powers = powers(&parameters, large.delay_spread_s, &delays, at.clusters.iter().map(|c| c.shadow));
        let strongest = two_strongest(&powers);
        let mut stay = strong_enough(&powers);
        let first = (0..delays.len()).min_by(|&a, &b| delays[a].total_cmp(&delays[b])).unwrap_or(0);
        // the first cluster holds the direct ray
        stay[first] |= parameters.los;
        let numbers = (0..stay.len()).filter(|&n| stay[n]);
        let clusters =
            numbers.map(|number| Constants::draw(number, strongest.contains(&number), &parameters, random));
        let clusters = clusters.collect();
        Procedure { factor, first, clusters, longest_excess_s: 2.0 * room_m / SPEED_OF_LIGHT, parameters }
    }

    /// The link of what was drawn at one place, with the spreads it drew.
    pub fn link(&self, at: &Variables) -> Link {
        let p = &self.parameters;
        let large = large_scale(p, &self.factor, &at.large);
        let mut parts = self.parts(at);
        let direct = large.direct(p);
        let degrees = [large.asa_deg, large.zsa_deg, large.asd_deg, large.zsd_deg].map(|d| d * PI / 180.0);
        let wanted = [large.delay_spread_s, degrees[0], degrees[1], degrees[2], degrees[3]];
        for (quantity, wanted) in wanted.iter().enumerate() {
            let factor = stretch(direct, of(&parts, quantity), *wanted);
            parts.iter_mut().for_each(|part| part.quantities[quantity].0 *= factor);
        }
        let rays = parts.iter().map(|part| {
            let [delay_s, aoa, zoa, aod, zod] = part.quantities.map(|(value, fixed)| value + fixed);
            Ray {
                delay_s,
                power: part.power,
                arrival: [aoa, zoa],
                departure: [aod, zod],
                matrix: *part.matrix,
            }
        });
        Link {
            direct,
            rays: rays.collect(),
            shadow_db: large.shadow_db,
            excess_s: if p.los { 0.0 } else { self.excess_delay(at) },
        }
    }

    /// 7.6.9: the excess delay in s, at most 2 L / c with L the room's longest side.
    fn excess_delay(&self, at: &Variables) -> f64 {
        let (mean, deviation) = EXCESS_DELAY;
        libm::pow(10.0, mean + deviation * at.excess).min(self.longest_excess_s)
    }

    /// The rays by steps 4 to 8 alone.
    fn parts(&self, at: &Variables) -> Vec<Parts<'_>> {
        let p = &self.parameters;
        let large = large_scale(p, &self.factor, &at.large);
        let delays = delays(p, large.delay_spread_s, at.clusters.iter().map(|c| c.delay));
        let powers = powers(p, large.delay_spread_s, &delays, at.clusters.iter().map(|c| c.shadow));
        let direct = large.direct(p);
        let scaling_delays = if p.los { delay_scaling(large.k_db) } else { 1.0 };
        // eq. 7.5-8: with the direct ray, for angles alone
        let seen = |n: usize| powers[n] * (1.0 - direct) + if n == self.first { direct } else { 0.0 };
        let most = (0..powers.len()).map(seen).fold(0.0, f64::max);
        let (c_phi, c_theta) = scaling(p, large.k_db);
        let cluster_angles = |number: usize, signs: &[f64; ANGLES]| -> [f64; ANGLES] {
            let ratio = -libm::log(seen(number) / most);
            let bare = [
                (angles::azimuth(ratio, large.asa_deg, c_phi), large.asa_deg),
                (angles::zenith(ratio, large.zsa_deg, c_theta), large.zsa_deg),
                (angles::azimuth(ratio, large.asd_deg, c_phi), large.asd_deg),
                (angles::zenith(ratio, large.zsd_deg, c_theta), large.zsd_deg),
            ];
            let drawn = &at.clusters[number].angles;
            std::array::from_fn(|k| signs[k] * bare[k].0 + bare[k].1 / 7.0 * drawn[k])
        };
        let first = self.clusters.iter().find(|c| c.number == self.first);
        let aligned = match first {
            Some(first) if p.los => cluster_angles(self.first, &first.signs),
            _ => [0.0; ANGLES],
        };
        let widths = [p.c_asa, p.c_zsa, p.c_asd, p.c_zsd];
        let mut parts = Vec::with_capacity(self.clusters.len() * RAYS);
        for c in &self.clusters {
            let angles = cluster_angles(c.number, &c.signs);
            for ray in 0..RAYS {
                let angle = |k: usize| {
                    let degree = PI / 180.0;
                    ((angles[k] - aligned[k]) * degree, widths[k] * offset(c.coupled[k][ray]) * degree)
                };
                parts.push(Parts {
                    power: powers[c.number] * (1.0 - direct) / RAYS as f64,
                    quantities: [
                        (delays[c.number] / scaling_delays, c.behind_s[ray]),
                        angle(0),
                        angle(1),
                        angle(2),
                        angle(3),
                    ],
                    matrix: &c.matrices[ray],
                });
            }
        }
        parts
    }
}

/// A ray before stretching: its delay and its angles, each as the cluster's, which is stretched, and what the ray adds to it.
struct Parts<'a> {
    power: f64,
    quantities: [(f64, f64); ANGLES + 1],
    matrix: &'a Matrix,
}

fn of<'a>(parts: &'a [Parts], quantity: usize) -> impl Iterator<Item = angles::Part> + 'a {
    parts.iter().map(move |part| {
        let (value, fixed) = part.quantities[quantity];
        (part.power, value, fixed)
    })
}

impl Constants {
    fn draw(number: usize, strong: bool, p: &Parameters, random: &mut Random) -> Self {
        let every: [&[usize]; 1] = [&EVERY_RAY];
        let groups: &[&[usize]] = if strong { &SUB_CLUSTERS } else { &every };
        let mut behind_s = [0.0; RAYS];
        for (group, delay) in groups.iter().zip(SUB_DELAYS) {
            group.iter().for_each(|&ray| behind_s[ray] = delay * CLUSTER_DELAY_SPREAD_S);
        }
        Constants {
            number,
            signs: std::array::from_fn(|_| if random.uniform() < 0.5 { -1.0 } else { 1.0 }),
            // arrivals in azimuth keep their numbers
            coupled: std::array::from_fn(|k| if k == 0 { EVERY_RAY } else { coupling(groups, random) }),
            behind_s,
            matrices: std::array::from_fn(|_| polarisation::draw(p.xpr_db, random)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::angles::spread;
    use super::*;

    /// Spread of a quantity of a link's rays: the delay, or an angle.
    fn spread_of(link: &Link, quantity: impl Fn(&Ray) -> f64) -> f64 {
        spread(link.direct, link.rays.iter().map(|ray| (ray.power, quantity(ray), 0.0)))
    }

    /// Ten thousand drops at 3.5 GHz: each with its variables. The large-scale ones come in pairs of opposite signs, so that their medians are
    /// the table's.
    fn drops(los: bool, stream: u64) -> impl Iterator<Item = (Procedure, Variables)> {
        let p = Parameters::indoor_office(3.5e9, los);
        (0..10_000).map(move |index| {
            let mut random = Random::new(stream, 1, u64::from(los), index / 2);
            let mut at = Variables::draw(&p, &mut random);
            if index % 2 == 1 {
                at.large = at.large.map(|x| -x);
                at.clusters = Variables::draw(&p, &mut random).clusters;
            }
            (Procedure::new(p.clone(), &at, 120.0, &mut random), at)
        })
    }

    fn median(mut values: Vec<f64>) -> f64 {
        values.sort_by(f64::total_cmp);
        values[values.len() / 2]
    }

    #[test]
    fn step_5_delay_spreads_of_ten_thousand_drops_are_the_tables() {
        for los in [true, false] {
            let (mut alone, mut found) = (Vec::new(), Vec::new());
            for (procedure, at) in drops(los, 5) {
                let link = procedure.link(&at);
                found.push(spread_of(&link, |ray| ray.delay_s));
                alone.push(spread(link.direct, of(&procedure.parts(&at), 0)));
            }
            let exact = libm::pow(10.0, Parameters::indoor_office(3.5e9, los).lsp[0].0);
            let (alone, found) = (median(alone) / exact, median(found) / exact);
            println!(
                "number: 38.901 step 5, line of sight {los}: median delay spread {found:.4} of Table 7.5-6's {:.1} ns (before stretching {alone:.3})",
                exact * 1e9
            );
            assert!((found - 1.0).abs() < 0.03, "{found}");
        }
    }

    #[test]
    fn step_7_angular_spreads_of_ten_thousand_drops_are_the_tables() {
        type Of = fn(&Ray) -> f64;
        let quantities: [(&str, Of, usize); 4] = [
            ("ASA", |ray| ray.arrival[0], 2),
            ("ZSA", |ray| ray.arrival[1], 6),
            ("ASD", |ray| ray.departure[0], 1),
            ("ZSD", |ray| ray.departure[1], 5),
        ];
        for los in [true, false] {
            let p = Parameters::indoor_office(3.5e9, los);
            let mut found: [Vec<f64>; 4] = Default::default();
            let mut alone: [Vec<f64>; 4] = Default::default();
            for (procedure, at) in drops(los, 7) {
                let (link, parts) = (procedure.link(&at), procedure.parts(&at));
                for (k, (_, quantity, _)) in quantities.iter().enumerate() {
                    found[k].push(spread_of(&link, quantity));
                    alone[k].push(spread(link.direct, of(&parts, k + 1)));
                }
            }
            for ((found, alone), (name, _, index)) in found.into_iter().zip(alone).zip(quantities) {
                let exact = libm::pow(10.0, p.lsp[index].0);
                let degrees = |values| median(values) * 180.0 / PI;
                let (found, alone) = (degrees(found), degrees(alone));
                println!(
                    "number: 38.901 step 7, line of sight {los}: median {name} {found:.2} degrees (table: {exact:.2}; before stretching {alone:.2})"
                );
                assert!((found / exact - 1.0).abs() < 0.03, "{name}: {found}");
            }
        }
    }

    #[test]
    fn step_7_the_first_cluster_lies_on_the_line_of_sight() {
        let (mut most, mut first_delay): (f64, f64) = (0.0, 0.0);
        for (procedure, at) in drops(true, 17).take(1000) {
            let link = procedure.link(&at);
            let number = procedure.clusters.iter().position(|c| c.number == procedure.first).unwrap();
            let rays = &link.rays[number * RAYS..(number + 1) * RAYS];
            for angle in [
                |r: &Ray| r.arrival[0],
                |r: &Ray| r.arrival[1],
                |r: &Ray| r.departure[0],
                |r: &Ray| r.departure[1],
            ] {
                most = most.max((rays.iter().map(angle).sum::<f64>() / RAYS as f64).abs());
            }
            first_delay = first_delay.max(rays[0].delay_s);
        }
        println!(
            "number: 38.901 step 7, the first cluster at most {most:.1e} rad off the line of sight and {:.1} ns behind it (eq. 7.5-12: 0)",
            first_delay * 1e9
        );
        assert!(most < 1e-9 && first_delay == 0.0, "{most} {first_delay}");
    }

    #[test]
    fn step_11_the_two_strongest_clusters_have_three_sub_clusters() {
        let mut shares = [0.0; 3];
        let mut clusters = 0;
        for (procedure, at) in drops(false, 11).take(500) {
            let link = procedure.link(&at);
            let split: Vec<usize> = (0..procedure.clusters.len())
                .filter(|&n| procedure.clusters[n].behind_s.iter().any(|d| *d > 0.0))
                .collect();
            assert_eq!(split.len(), 2);
            let power = |n: usize| link.rays[n * RAYS].power;
            let others = (0..procedure.clusters.len()).filter(|n| !split.contains(n));
            assert!(others.map(power).fold(0.0, f64::max) <= power(split[0]).min(power(split[1])));
            for n in split {
                let rays = &link.rays[n * RAYS..(n + 1) * RAYS];
                let total: f64 = rays.iter().map(|ray| ray.power).sum();
                let start = rays[0].delay_s;
                for ray in rays {
                    let group = ((ray.delay_s - start) / (1.28 * CLUSTER_DELAY_SPREAD_S)).round() as usize;
                    shares[group] += ray.power / total;
                }
                clusters += 1;
            }
        }
        let shares = shares.map(|share| share / f64::from(clusters));
        println!(
            "number: 38.901 step 11, sub-clusters at 0, {:.1} and {:.1} ns (5 and 10 ns) with {:.3} {:.3} {:.3} of the power (Table 7.5-5: 0.5 0.3 0.2)",
            1.28 * CLUSTER_DELAY_SPREAD_S * 1e9,
            2.56 * CLUSTER_DELAY_SPREAD_S * 1e9,
            shares[0],
            shares[1],
            shares[2]
        );
        for (found, exact) in shares.iter().zip([0.5, 0.3, 0.2]) {
            assert!((found - exact).abs() < 1e-9, "{shares:?}");
        }
    }

    #[test]
    fn absolute_time_of_arrival_has_the_tables_excess_delay() {
        let (procedure, at) = drops(false, 69).next().unwrap();
        let mut random = Random::new(69, 2, 0, 0);
        let excess: Vec<f64> = (0..10_000)
            .map(|_| procedure.link(&Variables { excess: random.gaussian(), ..at.clone() }).excess_s)
            .collect();
        let n = excess.len() as f64;
        let lg = |x: &f64| libm::log10(*x);
        let mean = excess.iter().map(lg).sum::<f64>() / n;
        let deviation = (excess.iter().map(|x| (lg(x) - mean) * (lg(x) - mean)).sum::<f64>() / n).sqrt();
        println!(
            "number: 38.901 clause 7.6.9, lg of the excess delay {mean:.3} +- {deviation:.4}, median {:.2} ns (Table 7.6.9-1: -8.6 +- 0.1, 2.51 ns)",
            median(excess) * 1e9
        );
        assert!((mean + 8.6).abs() < 0.03 * 0.1 && (deviation / 0.1 - 1.0).abs() < 0.03);
        let (mut small, at) = drops(false, 69).next().unwrap();
        small.longest_excess_s = 1e-9;
        assert_eq!(small.link(&at).excess_s, 1e-9);
        let (in_sight, at) = drops(true, 69).next().unwrap();
        assert_eq!(in_sight.link(&at).excess_s, 0.0);
    }

    #[test]
    fn power_is_kept_but_for_what_was_removed() {
        for (procedure, at) in drops(true, 3).take(1000) {
            let link = procedure.link(&at);
            let power = link.direct + link.rays.iter().map(|ray| ray.power).sum::<f64>();
            assert!((0.95..1.0 + 1e-12).contains(&power), "{power}");
            assert_eq!(link, link.reversed().reversed());
        }
    }
}
