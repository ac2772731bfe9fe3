//! The random numbers of a link: drawn for it alone, or as random fields of the receiver's place (7.6.3), so that neighbours see the same
//! clusters.

use super::Field;
use super::parameters::{CLUSTER_CORRELATION_M, EXCESS_CORRELATION_M, LSPS, Parameters};
use crate::numerics::random::Random;
use crate::simulator::body::Vec3;

/// Angles of a ray, in this order: azimuth and zenith of arrival, azimuth and zenith of departure.
pub const ANGLES: usize = 4;

/// What a link draws at one place: normal numbers, and uniform ones of delays.
#[derive(Debug, Clone)]
pub struct Variables {
    pub large: [f64; LSPS],
    pub excess: f64,
    pub clusters: Vec<ClusterVariables>,
}

#[derive(Debug, Clone)]
pub struct ClusterVariables {
    pub delay: f64,
    pub shadow: f64,
    pub angles: [f64; ANGLES],
}

impl Variables {
    /// Those of a link that has no neighbour.
    pub fn draw(p: &Parameters, random: &mut Random) -> Self {
        Variables {
            large: std::array::from_fn(|_| random.gaussian()),
            excess: random.gaussian(),
            clusters: (0..p.clusters)
                .map(|_| ClusterVariables {
                    delay: (1.0 - random.uniform()).max(1e-9),
                    shadow: random.gaussian(),
                    angles: std::array::from_fn(|_| random.gaussian()),
                })
                .collect(),
        }
    }
}

/// The same as random fields of the receiver's place.
#[derive(Debug, Clone)]
pub struct Fields {
    large: Vec<Field>,
    excess: Field,
    clusters: Vec<[Field; ANGLES + 2]>,
}

impl Fields {
    pub fn new(p: &Parameters, random: &mut Random) -> Self {
        Fields {
            large: p.correlation_m.iter().map(|&d| Field::new(d, random)).collect(),
            excess: Field::new(EXCESS_CORRELATION_M, random),
            clusters: (0..p.clusters)
                .map(|_| std::array::from_fn(|_| Field::new(CLUSTER_CORRELATION_M, random)))
                .collect(),
        }
    }

    pub fn at(&self, place: Vec3) -> Variables {
        let cluster = |[delay, shadow, angles @ ..]: &[Field; ANGLES + 2]| ClusterVariables {
            delay: delay.uniform_at(place),
            shadow: shadow.at(place),
            angles: std::array::from_fn(|k| angles[k].at(place)),
        };
        Variables {
            large: std::array::from_fn(|k| self.large[k].at(place)),
            excess: self.excess.at(place),
            clusters: self.clusters.iter().map(cluster).collect(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn spatial_consistency_has_the_tables_correlation_distance() {
        let p = Parameters::indoor_office(3.5e9, true);
        let (mut sum, n) = (0.0, 2000);
        for index in 0..n {
            let fields = Fields::new(&p, &mut Random::new(763, 1, 0, index));
            let [here, there] = [[0.0; 3], [10.0, 0.0, 0.0]].map(|place| fields.at(place));
            let pairs = here.clusters.iter().zip(&there.clusters);
            sum +=
                pairs.map(|(a, b)| a.angles[0] * b.angles[0]).sum::<f64>() / (n as f64 * p.clusters as f64);
        }
        println!(
            "number: 38.901 clause 7.6.3, correlation of cluster variables 10 m apart {sum:.3} (Table 7.6.3.1-2: {:.3})",
            libm::exp(-1.0)
        );
        assert!((sum - libm::exp(-1.0)).abs() < 0.03, "{sum}");
    }
}
