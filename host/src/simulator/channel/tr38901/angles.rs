//! Steps 7 and 8 of clause 7.5: azimuths and zeniths of clusters, offsets of their rays, and how rays at both ends are coupled.
//!
//! Angles are offsets from the direct path. In line of sight the first cluster lies on it (eqs. 7.5-12 and 17).

use super::RAYS;
use super::parameters::Parameters;
use crate::numerics::random::Random;

/// Offsets of the rays in units of the cluster's spread (Table 7.5-3), each with both signs.
pub const OFFSETS: [f64; RAYS / 2] =
    [0.0447, 0.1413, 0.2492, 0.3715, 0.5129, 0.6797, 0.8844, 1.1481, 1.5195, 2.1551];

/// Offset of a ray in units of the cluster's spread.
pub fn offset(ray: usize) -> f64 {
    OFFSETS[ray / 2] * if ray.is_multiple_of(2) { 1.0 } else { -1.0 }
}

/// C_phi and C_theta (eqs. 7.5-10 and 15).
pub fn scaling(p: &Parameters, kd: f64) -> (f64, f64) {
    if p.los {
        (
            p.c_phi * (1.1035 - 0.028 * kd - 0.002 * kd * kd + 0.0001 * kd * kd * kd),
            p.c_theta * (1.3086 + 0.0339 * kd - 0.0077 * kd * kd + 0.0002 * kd * kd * kd),
        )
    } else {
        (p.c_phi, p.c_theta)
    }
}

/// Azimuth of a cluster, exp(-`ratio`) of the strongest (eq. 7.5-9), in the unit of `spread`.
pub fn azimuth(ratio: f64, spread: f64, c_phi: f64) -> f64 {
    2.0 * (spread / 1.4) * ratio.sqrt() / c_phi
}

/// Zenith of a cluster (eq. 7.5-14).
pub fn zenith(ratio: f64, spread: f64, c_theta: f64) -> f64 {
    spread * ratio / c_theta
}

/// Step 8: a permutation of each of the groups of rays.
pub fn coupling(groups: &[&[usize]], random: &mut Random) -> [usize; RAYS] {
    let mut coupled = std::array::from_fn(|ray| ray);
    for group in groups {
        let mut others = group.to_vec();
        for k in (1..others.len()).rev() {
            others.swap(k, (random.bits() % (k as u64 + 1)) as usize);
        }
        group.iter().zip(others).for_each(|(&ray, other)| coupled[ray] = other);
    }
    coupled
}

/// A part of a link: its power, what can be stretched, and what cannot.
pub type Part = (f64, f64, f64);

/// Root mean square about the mean of parts' sums; `direct` is the power at 0.
#[cfg(test)]
pub fn spread(direct: f64, parts: impl Iterator<Item = Part>) -> f64 {
    let [[mean, square], ..] =
        moments(direct, parts.map(|(power, value, fixed)| (power, value + fixed, 0.0)));
    (square - mean * mean).max(0.0).sqrt()
}

/// Means of the first quantity and its square, of the second and the product, and of the second's square.
fn moments(direct: f64, parts: impl Iterator<Item = Part>) -> [[f64; 2]; 3] {
    let (mut total, mut sums) = (direct, [[0.0; 2]; 3]);
    for (power, value, fixed) in parts {
        total += power;
        let terms = [[value, value * value], [fixed, value * fixed], [fixed * fixed, 0.0]];
        sums.iter_mut().flatten().zip(terms.iter().flatten()).for_each(|(sum, term)| *sum += power * term);
    }
    sums.map(|pair| pair.map(|sum| sum / total))
}

/// The stretch that makes a spread the one that was drawn; where what cannot be stretched exceeds it, the stretch of the least spread.
pub fn stretch(direct: f64, parts: impl Iterator<Item = Part>, wanted: f64) -> f64 {
    let [[mean, square], [fixed, both], [fixed_square, _]] = moments(direct, parts);
    let (a, b) = (square - mean * mean, both - mean * fixed);
    let c = fixed_square - fixed * fixed - wanted * wanted;
    if a <= 0.0 {
        return 1.0;
    }
    ((-b + (b * b - a * c).max(0.0).sqrt()) / a).max(0.0)
}

#[cfg(test)]
mod tests {
    use super::super::procedure::{EVERY_RAY, SUB_CLUSTERS};
    use super::*;

    #[test]
    fn step_8_rays_are_coupled_at_random_within_sub_clusters() {
        let mut random = Random::new(8, 1, 0, 0);
        let (mut same, mut product, n) = (0, 0.0, 10_000);
        for _ in 0..n {
            let all = coupling(&[&EVERY_RAY], &mut random);
            same += (0..RAYS).filter(|&ray| all[ray] == ray).count();
            product += (0..RAYS).map(|ray| offset(ray) * offset(all[ray])).sum::<f64>() / RAYS as f64;
            let split = coupling(&SUB_CLUSTERS, &mut random);
            for group in SUB_CLUSTERS {
                assert!(group.iter().all(|&ray| group.contains(&split[ray])), "{split:?}");
            }
            let mut sorted = split;
            sorted.sort_unstable();
            assert_eq!(sorted, EVERY_RAY);
        }
        let (found, correlation) = (f64::from(same as u32) / f64::from(n), product / f64::from(n));
        println!(
            "number: 38.901 step 8, rays coupled with their own number {found:.3} a cluster (1), correlation of offsets at both ends {correlation:.4} (0)"
        );
        assert!((found - 1.0).abs() < 0.03 && correlation.abs() < 0.03);
    }

    #[test]
    fn step_7_offsets_of_rays_have_unit_spread() {
        let square = (0..RAYS).map(|ray| offset(ray) * offset(ray)).sum::<f64>() / RAYS as f64;
        println!("number: 38.901 step 7, rms of the rays' offsets {:.4} (Table 7.5-3: 1)", square.sqrt());
        assert!((square.sqrt() - 1.0).abs() < 0.03);
    }
}
