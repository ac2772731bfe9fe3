//! The sets of seeds: those on which settings are chosen, and those of the final test (`docs/protocol.md`).

use crate::error::{Failure, Invalid};

/// The first seed of development: settings are chosen on these seeds, which no published test uses.
pub const DEVELOPMENT_SEED: u64 = 101;

/// First seed of the final tests, on which nothing is chosen.
pub const FINAL_SEED: u64 = 1001;

/// The set that seeds belong to.
///
/// # Errors
///
/// Seeds of several sets, or of none.
pub fn seed_set(seeds: &[u64]) -> Result<&'static str, Failure> {
    let (least, most) = (seeds.iter().min().copied().unwrap_or(0), seeds.iter().max().copied().unwrap_or(0));
    match (least, most) {
        (FINAL_SEED.., _) => Ok("final"),
        (DEVELOPMENT_SEED.., ..FINAL_SEED) => Ok("development"),
        _ => {
            let legal = format!(
                "seeds of one set: {DEVELOPMENT_SEED} to {} (development), or from {FINAL_SEED} on (final)",
                FINAL_SEED - 1
            );
            Err(Invalid::option("--seed", format!("{least} to {most}"), legal).into())
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn seeds_of_one_set_only() {
        assert_eq!(seed_set(&[101, 105]).unwrap(), "development");
        assert_eq!(seed_set(&[1001, 1005]).unwrap(), "final");
        for mixed in [[1, 5], [5, 101], [1000, 1001]] {
            let error = seed_set(&mixed).unwrap_err().to_string();
            assert!(error.contains("--seed") && error.contains("1001"), "{error}");
        }
    }
}
