//! What a command may take: memory and time, held against estimates before work begins.
//!
//! An estimate is a sum of needs, each a formula over fields of the resolved scenario and of the command line
//! (`pipeline/budget.rs`). A command with a sum above a limit is refused by the field that needs most.

use crate::error::Invalid;
use std::str::FromStr;

/// Limits of a command.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Budget {
    /// Most memory.
    pub memory: Memory,
    /// Most time on the threads that there are.
    pub time: Time,
}

impl Default for Budget {
    /// Fixed, so that a command that is legal on one machine is legal on every machine: the memory of a small one, and a time that no
    /// study of this project comes near.
    fn default() -> Self {
        Budget { memory: Memory(4 << 30), time: Time(30.0 * 86400.0) }
    }
}

/// What one item of work needs.
#[derive(Debug, Clone, PartialEq)]
pub struct Need {
    /// The fields that it follows from.
    pub fields: &'static str,
    /// Their values.
    pub values: String,
    /// Bytes of memory, or seconds.
    pub amount: f64,
}

impl Need {
    /// So much for these `values` of `fields`.
    pub fn new(fields: &'static str, values: impl ToString, amount: f64) -> Self {
        Need { fields, values: values.to_string(), amount }
    }
}

impl Budget {
    /// Refuses needs of memory in bytes that are above the limit together.
    ///
    /// # Errors
    ///
    /// The largest of them.
    pub fn check_memory(&self, needs: &[Need]) -> Result<(), Invalid> {
        let legal = format!("at most {} (--max-memory)", self.memory);
        check(needs, self.memory.0 as f64, &legal, |bytes| format!("{} of memory", Memory(bytes as u64)))
    }

    /// The same for seconds.
    ///
    /// # Errors
    ///
    /// The largest of them.
    pub fn check_time(&self, needs: &[Need]) -> Result<(), Invalid> {
        let legal = format!("at most {} (--max-time)", self.time);
        check(needs, self.time.0, &legal, |seconds| Time(seconds).to_string())
    }
}

fn check(needs: &[Need], most: f64, legal: &str, words: impl Fn(f64) -> String) -> Result<(), Invalid> {
    let all: f64 = needs.iter().map(|need| need.amount).sum();
    let largest = needs.iter().max_by(|a, b| a.amount.total_cmp(&b.amount));
    let Some(Need { fields, values, .. }) = largest.filter(|_| all > most) else { return Ok(()) };
    Err(Invalid::new(fields, format!("{values}, about {} in all", words(all)), legal))
}

/// Bytes of memory, at least 1: `500M`, `1.5GiB`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Memory(pub u64);

const SIZES: [(&str, f64); 7] = [
    ("KiB", 1024.0),
    ("MiB", 1048576.0),
    ("GiB", 1073741824.0),
    ("K", 1e3),
    ("M", 1e6),
    ("G", 1e9),
    ("", 1.0),
];

impl FromStr for Memory {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let legal = "bytes, at least 1, with K, M, G, KiB, MiB or GiB behind them: 500M, 1.5GiB";
        let bytes = with_unit(text, &SIZES).filter(|bytes| (1.0..=u64::MAX as f64).contains(bytes));
        Ok(Memory(bytes.ok_or(legal)? as u64))
    }
}

impl std::fmt::Display for Memory {
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        let bytes = self.0 as f64;
        let (unit, size) = SIZES[..3].iter().rev().find(|(_, size)| bytes >= *size).unwrap_or(&SIZES[6]);
        write!(f, "{} {}", trimmed(bytes / size), if unit.is_empty() { "bytes" } else { unit })
    }
}

/// Seconds, above 0: `90`, `10m`, `12h`, `30d`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Time(pub f64);

const TIMES: [(&str, f64); 6] =
    [("s", 1.0), ("min", 60.0), ("h", 3600.0), ("d", 86400.0), ("m", 60.0), ("", 1.0)];

impl FromStr for Time {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let legal = "seconds above 0, or a number with s, m, h or d behind it: 90, 10m, 12h";
        Ok(Time(with_unit(text, &TIMES).filter(|seconds| *seconds > 0.0).ok_or(legal)?))
    }
}

impl std::fmt::Display for Time {
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        let (unit, size) = TIMES[..4].iter().rev().find(|(_, size)| self.0 >= *size).unwrap_or(&TIMES[0]);
        write!(f, "{} {unit}", trimmed(self.0 / size))
    }
}

/// A number in units, the first of them that its text ends with.
fn with_unit(text: &str, units: &[(&str, f64)]) -> Option<f64> {
    let (number, size) = units.iter().find_map(|(unit, size)| Some((text.strip_suffix(unit)?, size)))?;
    number.trim().parse::<f64>().ok().filter(|number| number.is_finite()).map(|number| number * size)
}

/// Three digits, and no zeros behind them.
fn trimmed(number: f64) -> f64 {
    let digits = 2 - number.max(1.0).log10().floor() as i32;
    let scale = libm::pow(10.0, f64::from(digits.max(0)));
    (number * scale).round() / scale
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_and_times_are_read_and_shown_in_their_units() {
        let memory = |text: &str| text.parse::<Memory>().map(|Memory(bytes)| bytes);
        assert_eq!(memory("1000"), Ok(1000));
        assert_eq!(
            [memory("2K"), memory("500M"), memory("3G")],
            [Ok(2000), Ok(500_000_000), Ok(3_000_000_000)]
        );
        assert_eq!([memory("2KiB"), memory("1.5MiB"), memory("1 GiB")], [Ok(2048), Ok(3 << 19), Ok(1 << 30)]);
        for text in ["", "0", "-1", "G", "1T", "NaN", "inf", "1e30G"] {
            assert!(memory(text).is_err(), "{text}");
        }
        assert_eq!(
            [1, 1 << 20, 3 << 30].map(|bytes| Memory(bytes).to_string()),
            ["1 bytes", "1 MiB", "3 GiB"]
        );
        let time = |text: &str| text.parse::<Time>().map(|Time(seconds)| seconds);
        assert_eq!(
            [time("90"), time("1.5m"), time("2h"), time("30d")],
            [Ok(90.0), Ok(90.0), Ok(7200.0), Ok(2592000.0)]
        );
        for text in ["", "0", "-1s", "m", "1y", "NaN"] {
            assert!(time(text).is_err(), "{text}");
        }
        assert_eq!([0.25, 90.0, 2592000.0].map(|s| Time(s).to_string()), ["0.25 s", "1.5 min", "30 d"]);
    }

    #[test]
    fn the_largest_need_of_a_sum_above_the_limit_is_named() {
        let budget = Budget { memory: Memory(1 << 30), time: Time(60.0) };
        let needs = [Need::new("a x b", "2 x 3", 4e8), Need::new("c", 7, 8e8)];
        assert_eq!(budget.check_memory(&needs[..1]), Ok(()));
        assert_eq!(
            budget.check_memory(&needs).unwrap_err().to_string(),
            "c is 7, about 1.12 GiB of memory in all, must be at most 1 GiB (--max-memory)"
        );
        assert_eq!(budget.check_time(&[Need::new("a", 1, 60.0)]), Ok(()));
        assert_eq!(
            budget.check_time(&[Need::new("a", 1, 61.0)]).unwrap_err().to_string(),
            "a is 1, about 1.02 min in all, must be at most 1 min (--max-time)"
        );
        // what cannot be counted is too much
        assert!(budget.check_time(&[Need::new("a", 1, f64::INFINITY)]).is_err());
    }
}
