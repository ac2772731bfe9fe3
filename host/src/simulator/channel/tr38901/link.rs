//! A link that the procedure made: a direct ray and the rays of clusters.

use super::polarisation::{Matrix, transposed};

/// A ray of a cluster.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ray {
    /// Delay behind the first path in s.
    pub delay_s: f64,
    /// Share of the power.
    pub power: f64,
    /// Azimuth and elevation in rad, away from the direct path.
    pub arrival: [f64; 2],
    pub departure: [f64; 2],
    pub matrix: Matrix,
}

/// A link between isotropic antennas, without path loss.
#[derive(Debug, Clone, PartialEq)]
pub struct Link {
    /// Share of the direct ray in the power; 0 without line of sight.
    pub direct: f64,
    pub rays: Vec<Ray>,
    /// Shadow fading in dB; positive is more power.
    pub shadow_db: f64,
    /// How much later than the direct path's length says all rays arrive without line of sight, in s (7.6.9).
    pub excess_s: f64,
}

impl Link {
    /// The same link in the other direction.
    pub fn reversed(&self) -> Self {
        let back = |ray: &Ray| Ray {
            arrival: ray.departure,
            departure: ray.arrival,
            matrix: transposed(&ray.matrix),
            ..*ray
        };
        Link { rays: self.rays.iter().map(back).collect(), ..self.clone() }
    }
}
