//! Steps 9 and 10 of clause 7.5: cross-polarisation power ratios and initial phases, as the matrix of a ray.

use crate::numerics::random::Random;
use crate::scenario::Polarisation;
use crate::simulator::channel::{Complex64, phasor};
use std::f64::consts::TAU;

/// What a ray makes of a wave: rows are the receiver's vertical and horizontal field, columns the transmitter's.
pub type Matrix = [[Complex64; 2]; 2];

/// The direct ray's.
pub const DIRECT: Matrix = [
    [Complex64::new(1.0, 0.0), Complex64::new(0.0, 0.0)],
    [Complex64::new(0.0, 0.0), Complex64::new(-1.0, 0.0)],
];

/// A ray's: four random phases, and cross terms weaker by a ratio drawn with this mean and deviation in dB.
pub fn draw((mean, deviation): (f64, f64), random: &mut Random) -> Matrix {
    let cross = libm::pow(10.0, -(mean + deviation * random.gaussian()) / 20.0);
    let mut phase = || phasor(TAU * random.uniform());
    [[phase(), phase() * cross], [phase() * cross, phase()]]
}

/// `b` first, then `a`.
pub fn product(a: &Matrix, b: &Matrix) -> Matrix {
    std::array::from_fn(|i| std::array::from_fn(|j| a[i][0] * b[0][j] + a[i][1] * b[1][j]))
}

/// The matrix of the way back.
pub fn transposed(m: &Matrix) -> Matrix {
    [[m[0][0], m[1][0]], [m[0][1], m[1][1]]]
}

/// What antennas of this polarisation receive.
pub fn received(m: &Matrix, polarisation: Polarisation) -> Complex64 {
    match polarisation {
        Polarisation::Vertical => m[0][0],
        Polarisation::Horizontal => m[1][1],
        Polarisation::Crossed => m[1][0],
    }
}

#[cfg(test)]
mod tests {
    use super::super::parameters::Parameters;
    use super::*;

    #[test]
    fn step_9_cross_polarisation_ratios_are_the_tables() {
        for los in [true, false] {
            let table = Parameters::indoor_office(3.5e9, los).xpr_db;
            let mut random = Random::new(9, 1, u64::from(los), 0);
            let ratios: Vec<f64> = (0..10_000)
                .map(|_| {
                    let m = draw(table, &mut random);
                    assert!((m[0][1].norm() - m[1][0].norm()).abs() < 1e-12);
                    -20.0 * libm::log10(m[0][1].norm())
                })
                .collect();
            let n = ratios.len() as f64;
            let mean = ratios.iter().sum::<f64>() / n;
            let deviation = (ratios.iter().map(|r| (r - mean) * (r - mean)).sum::<f64>() / n).sqrt();
            println!(
                "number: 38.901 step 9, line of sight {los}: cross-polarisation {mean:.2} +- {deviation:.2} dB (table: {} +- {} dB)",
                table.0, table.1
            );
            assert!((mean / table.0 - 1.0).abs() < 0.03 && (deviation / table.1 - 1.0).abs() < 0.03);
        }
    }

    #[test]
    fn step_10_phases_of_four_combinations_are_uniform_and_independent() {
        let mut random = Random::new(10, 1, 0, 0);
        let (n, mut square, mut pairs) = (10_000, [0.0; 4], Complex64::default());
        for _ in 0..n {
            let m = draw((11.0, 4.0), &mut random);
            let phases = [m[0][0], m[0][1], m[1][0], m[1][1]].map(Complex64::arg);
            square.iter_mut().zip(phases).for_each(|(sum, phase)| *sum += phase * phase / f64::from(n));
            pairs += phasor(phases[0] - phases[3]) / f64::from(n);
        }
        let exact = std::f64::consts::PI / 3.0_f64.sqrt();
        let found = square.map(f64::sqrt);
        println!(
            "number: 38.901 step 10, rms phases {:.3} {:.3} {:.3} {:.3} rad (uniform: {exact:.3}), coherence of two {:.3} (0)",
            found[0],
            found[1],
            found[2],
            found[3],
            pairs.norm()
        );
        assert!(found.iter().all(|f| (f / exact - 1.0).abs() < 0.03) && pairs.norm() < 0.03);
    }
}
