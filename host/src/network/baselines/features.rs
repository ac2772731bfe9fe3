//! Features of a spectrogram that do not depend on when a step begins: what every Doppler row shows over time.
//!
//! Mean, standard deviation, largest and smallest intensity of each row: where the torso's line lies, how far and how often
//! limbs leave it.

use crate::network::parameters::Images;

/// Features of a row.
const STATISTICS: usize = 4;

/// Features of every image, `[image][row][statistic]`.
pub fn features(images: &Images) -> Vec<Vec<f64>> {
    let row = |row: &[i8]| -> [f64; STATISTICS] {
        let levels = || row.iter().map(|&p| (f64::from(p) + 128.0) / 255.0);
        let n = row.len().max(1) as f64;
        let mean = levels().sum::<f64>() / n;
        let square = levels().map(|v| (v - mean) * (v - mean)).sum::<f64>() / n;
        [mean, square.sqrt(), levels().fold(0.0, f64::max), levels().fold(1.0, f64::min)]
    };
    (0..images.len()).map(|i| images.image(i).chunks_exact(images.frames).flat_map(row).collect()).collect()
}

/// Brings every feature to mean 0 and standard deviation 1 over the images it was made from.
#[derive(Debug, Clone, PartialEq)]
pub struct Scaling {
    means: Vec<f64>,
    deviations: Vec<f64>,
}

impl Scaling {
    /// From the features of training images; one that never changes is only centred.
    pub fn new(features: &[Vec<f64>]) -> Self {
        let n = features.len().max(1) as f64;
        let width = features.first().map_or(0, Vec::len);
        let means: Vec<f64> = (0..width).map(|k| features.iter().map(|f| f[k]).sum::<f64>() / n).collect();
        let deviation = |k: usize| {
            let square = features.iter().map(|f| (f[k] - means[k]) * (f[k] - means[k])).sum::<f64>() / n;
            if square > 0.0 { square.sqrt() } else { 1.0 }
        };
        let deviations = (0..width).map(deviation).collect();
        Scaling { means, deviations }
    }

    /// Scaled features, in their order.
    pub fn apply(&self, features: &[Vec<f64>]) -> Vec<f64> {
        let scaled = |f: &Vec<f64>| -> Vec<f64> {
            let at = |(k, v): (usize, &f64)| (v - self.means[k]) / self.deviations[k];
            f.iter().enumerate().map(at).collect()
        };
        features.iter().flat_map(scaled).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_are_described_whatever_the_moment_a_step_begins() {
        let image = |pixels: [i8; 8]| Images { rows: 2, frames: 4, pixels: pixels.to_vec(), labels: vec![0] };
        let a = features(&image([-128, -128, 127, 127, 0, 0, 0, 0]));
        let mid = 128.0 / 255.0;
        let expected = [0.5, 0.5, 1.0, 0.0, mid, 0.0, mid, mid];
        assert!(a[0].iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-12), "{a:?}");
        assert_eq!(a, features(&image([127, -128, -128, 127, 0, 0, 0, 0])));
    }

    #[test]
    fn scaled_features_have_no_mean_and_unit_deviation() {
        let features = vec![vec![1.0, 5.0], vec![3.0, 5.0]];
        assert_eq!(Scaling::new(&features).apply(&features), [-1.0, 0.0, 1.0, 0.0]);
    }
}
