//! IEEE 802.11 TGn channel model B, the indoor model of 802.11ax for a room of this size: tap powers and delays.
//!
//! 11-03/940r4: two clusters, nine taps at 0..80 ns, rms delay spread 15 ns, break point 5 m, K = 0 dB on the first tap.

/// Spacing of the taps in s.
pub const TAP_S: f64 = 10e-9;
/// Taps.
pub const TAPS: usize = 9;

const FIRST_DB: [f64; 5] = [0.0, -5.4, -10.8, -16.2, -21.7];
const SECOND_DB: [f64; 7] = [-3.2, -6.3, -9.4, -12.5, -15.6, -18.7, -21.8];

/// Mean power of each tap, summing to 1.
pub fn tap_powers() -> [f64; TAPS] {
    let mut powers = [0.0; TAPS];
    let linear = |db: f64| libm::pow(10.0, db / 10.0);
    FIRST_DB.iter().enumerate().for_each(|(tap, &db)| powers[tap] += linear(db));
    SECOND_DB.iter().enumerate().for_each(|(tap, &db)| powers[tap + 2] += linear(db));
    let total: f64 = powers.iter().sum();
    powers.map(|p| p / total)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rms_delay_spread_is_fifteen_nanoseconds() {
        let powers = tap_powers();
        let moment =
            |n: i32| -> f64 { powers.iter().enumerate().map(|(k, p)| p * (10.0 * k as f64).powi(n)).sum() };
        let spread = (moment(2) - moment(1) * moment(1)).sqrt();
        assert!((spread - 15.0).abs() < 1.0, "{spread}");
    }
}
