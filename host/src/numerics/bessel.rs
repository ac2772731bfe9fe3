//! The modified Bessel function of Kaiser windows.

/// Modified Bessel function of the first kind, order zero, by its power series.
pub fn bessel_i0(x: f64) -> f64 {
    let (mut term, mut sum, mut k) = (1.0, 1.0, 1.0);
    while term > 1e-17 * sum {
        term *= x * x / (4.0 * k * k);
        sum += term;
        k += 1.0;
    }
    sum
}

/// A Kaiser window of n values.
pub fn kaiser(n: usize, beta: f64) -> Vec<f64> {
    let centre = (n as f64 - 1.0) / 2.0;
    let value = |k: usize| {
        let x = (k as f64 - centre) / centre;
        bessel_i0(beta * (1.0 - x * x).max(0.0).sqrt()) / bessel_i0(beta)
    };
    (0..n).map(value).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Abramowitz and Stegun, table 9.8: I0(1) and, times exp(-10), I0(10).
    #[test]
    fn printed_values() {
        assert!((bessel_i0(1.0) - 1.266_065_878).abs() < 1e-9);
        assert!((bessel_i0(10.0) * libm::exp(-10.0) - 0.127_833_337_2).abs() < 1e-9);
        assert_eq!(bessel_i0(0.0), 1.0);
    }
}
