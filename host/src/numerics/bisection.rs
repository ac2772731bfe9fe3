//! Bisection to neighbouring numbers.

/// The two neighbouring numbers between `low` and `high` at which `below` changes: it holds at the first and not at the second.
///
/// It must hold at `low` and not at `high`. Cost: at most 64 evaluations for numbers of one sign and of magnitudes within 2^11.
pub fn bisect(mut low: f64, mut high: f64, below: impl Fn(f64) -> bool) -> (f64, f64) {
    loop {
        let middle = 0.5 * (low + high);
        if middle <= low || middle >= high {
            return (low, high);
        }
        if below(middle) { low = middle } else { high = middle }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_root_of_two_lies_between_neighbours() {
        let (low, high) = bisect(1.0, 2.0, |x| x * x < 2.0);
        assert_eq!(high.to_bits(), low.to_bits() + 1);
        assert!(low * low < 2.0 && high * high >= 2.0);
    }
}
