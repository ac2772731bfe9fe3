//! The conference room by the image method: first and second order reflections off ceiling and walls.
//!
//! IEEE 802.11ad/ay (11-09/0334r8, 11-15/1150): 17 clusters, lognormal losses, rays before and after each
//! central one. Floor and table are left out.

use crate::scenario::SPEED_OF_LIGHT;
use crate::simulator::body::{Vec3, norm, sub};
use crate::simulator::random::Random;

/// A reflected path.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Reflection {
    /// Its whole length in m.
    pub length_m: f64,
    /// Reflections on the way.
    pub order: u8,
}

/// The 17 reflections between two points: ceiling, four walls, four wall-ceiling, eight double walls.
pub fn reflections(size: Vec3, from: Vec3, to: Vec3) -> Vec<Reflection> {
    let mirror = |p: Vec3, axis: usize, plane: f64| {
        let mut image = p;
        image[axis] = 2.0 * plane - p[axis];
        image
    };
    let walls = [(0, 0.0), (0, size[0]), (1, 0.0), (1, size[1])];
    let ceiling = (2, size[2]);
    let mut found = Vec::new();
    let mut push = |planes: &[(usize, f64)]| {
        let image = planes.iter().fold(from, |p, &(axis, plane)| mirror(p, axis, plane));
        found.push(Reflection { length_m: norm(sub(image, to)), order: planes.len() as u8 });
    };
    push(&[ceiling]);
    walls.iter().for_each(|&wall| push(&[wall]));
    walls.iter().for_each(|&wall| push(&[wall, ceiling]));
    for x in &walls[..2] {
        for y in &walls[2..] {
            push(&[*x, *y]);
        }
    }
    for pair in [[0, 1], [1, 0], [2, 3], [3, 2]] {
        push(&[walls[pair[0]], walls[pair[1]]]);
    }
    found
}

/// Mean reflection loss in dB of an order, before truncation, and its standard deviation.
const LOSS_DB: [(f64, f64); 2] = [(-10.0, 4.0), (-16.0, 5.0)];

/// A reflection loss in dB: normal, never above -2 dB.
pub fn draw_loss_db(order: u8, random: &mut Random) -> f64 {
    let (mean, deviation) = LOSS_DB[usize::from(order.clamp(1, 2)) - 1];
    loop {
        let loss = mean + deviation * random.gaussian();
        if loss <= -2.0 {
            return loss;
        }
    }
}

/// Free-space amplitude of a path times its mean reflection loss.
pub fn mean_amplitude(reflection: &Reflection, lambda: f64) -> f64 {
    let (mean, _) = LOSS_DB[usize::from(reflection.order.clamp(1, 2)) - 1];
    lambda / (4.0 * std::f64::consts::PI * reflection.length_m) * libm::pow(10.0, mean / 20.0)
}

/// One ray of a cluster.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ray {
    /// Amplitude; a cluster's rays have unit energy.
    pub amplitude: f64,
    /// Delay after (or before) the cluster's central ray in s.
    pub delay_s: f64,
    /// Whether it is the central, geometric ray.
    pub central: bool,
}

/// Rays of one cluster of the conference room: six before and eight after the central one, Poisson arrivals, Rayleigh
/// amplitudes, exponential decay.
pub fn draw_rays(random: &mut Random) -> Vec<Ray> {
    let mut rays = vec![Ray { amplitude: 1.0, delay_s: 0.0, central: true }];
    // (rays, K factor in dB, decay in ns, arrival in 1/ns, sign of the delay)
    for (count, k_db, decay, arrival, sign) in [(6, 10.0, 3.7, 0.37, -1.0), (8, 14.2, 4.5, 0.31, 1.0)] {
        let mut delay = 0.0;
        for _ in 0..count {
            delay -= libm::log(1.0 - random.uniform()) / arrival;
            let mean_power = libm::exp(-delay / decay) * libm::pow(10.0, -k_db / 10.0);
            let (x, y) = (random.gaussian(), random.gaussian());
            let amplitude = (mean_power * (x * x + y * y) / 2.0).sqrt();
            rays.push(Ray { amplitude, delay_s: sign * delay * 1e-9, central: false });
        }
    }
    let energy: f64 = rays.iter().map(|r| r.amplitude * r.amplitude).sum();
    rays.iter_mut().for_each(|r| r.amplitude /= energy.sqrt());
    rays
}

/// Delay of a path in s.
pub fn delay_s(reflection: &Reflection) -> f64 {
    reflection.length_m / SPEED_OF_LIGHT
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn path_lengths_of_the_papers_room() {
        let radar = [1.5, 1.0, 1.0];
        let lengths: Vec<f64> =
            reflections([3.0, 4.5, 3.0], radar, radar).iter().map(|r| r.length_m).collect();
        let golden =
            [4.0, 3.0, 3.0, 2.0, 7.0, 5.0, 5.0, 4.472, 8.062, 3.606, 7.616, 3.606, 7.616, 6.0, 6.0, 9.0, 9.0];
        assert_eq!(lengths.len(), 17);
        for (found, expected) in lengths.iter().zip(golden) {
            assert!((found - expected).abs() < 1e-3, "{found} {expected}");
        }
    }

    #[test]
    fn losses_have_their_means_and_rays_unit_energy() {
        let mut random = Random::new(9, 0, 0, 0);
        for (order, mean) in [(1, -10.2), (2, -16.0)] {
            let sum: f64 = (0..40_000).map(|_| draw_loss_db(order, &mut random)).sum();
            assert!((sum / 40_000.0 - mean).abs() < 0.1, "order {order}: {}", sum / 40_000.0);
        }
        for _ in 0..100 {
            let energy: f64 = draw_rays(&mut random).iter().map(|r| r.amplitude * r.amplitude).sum();
            assert!((energy - 1.0).abs() < 1e-12);
        }
    }
}
