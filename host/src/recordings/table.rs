//! CSV: one row a time, of one value (real) or two (I and Q), with or without a column of times before them.
//!
//! Lines that begin with `#` are passed over. A first row without numbers names the columns; a column of times is named `t`, `time` or
//! `time_s` and is in seconds. It says the rate, and its steps may differ from the mean by a hundredth.

use super::array::{Array, Numbers};
use super::{Contents, MeasuredError, Source};
use crate::store::limited;
use std::io::BufReader;

pub(super) const FORMAT: &str = "CSV";
/// Share by which a step of time may differ from the mean.
const JITTER: f64 = 0.01;

pub(super) fn read(source: Source) -> Result<Contents, MeasuredError> {
    let broken = |error: csv::Error| source.unreadable(FORMAT, error);
    let file = limited::open(source.0, limited::WHOLE).map_err(|error| source.unreadable(FORMAT, error))?;
    // a number and its comma take two bytes at least
    let size = file.metadata().map_or(0, |about| about.len());
    source.fits("size (bytes)", size, size / 2)?;
    let mut reader = csv::ReaderBuilder::new()
        .has_headers(false)
        .comment(Some(b'#'))
        .trim(csv::Trim::All)
        .from_reader(BufReader::new(file));
    let (mut columns, mut timed) = (0, false);
    let (mut times, mut values) = (Vec::new(), Vec::new());
    for (n, record) in reader.records().enumerate() {
        let record = record.map_err(broken)?;
        if n == 0 {
            timed = matches!(record[0].to_ascii_lowercase().as_str(), "t" | "time" | "time_s");
            columns = record.len() - usize::from(timed);
            if !(1..=2).contains(&columns) {
                let legal = "1 (real) or 2 (I and Q), beside one named t, time or time_s";
                return Err(source.value("columns", columns, legal));
            }
            if record.iter().all(|cell| cell.parse::<f64>().is_err()) {
                continue;
            }
        }
        let line = record.position().map_or(0, csv::Position::line);
        for (column, cell) in record.iter().enumerate() {
            let number: f64 = cell.parse().map_err(|_| {
                let field = format!("line {line}, column {}", column + 1);
                source.value(field, format!("{cell:?}"), "a number")
            })?;
            if timed && column == 0 { times.push(number) } else { values.push(number) }
        }
    }
    let rows = values.len() / columns.max(1);
    let shape = if columns == 1 { vec![rows] } else { vec![rows, columns] };
    let mut contents = Array { shape, numbers: Numbers::Real(values) }.contents(source, FORMAT)?;
    if timed {
        contents.rate_hz = Some(rate(source, &times)?);
    }
    Ok(contents)
}

/// Rate of evenly spaced times.
fn rate(source: Source, times: &[f64]) -> Result<f64, MeasuredError> {
    let (Some(first), Some(last)) = (times.first(), times.last()) else {
        return Err(source.value("times", 0, "at least 2"));
    };
    let step = (last - first) / (times.len() - 1).max(1) as f64;
    for (n, pair) in times.windows(2).enumerate() {
        let found = pair[1] - pair[0];
        if !(step > 0.0 && (found - step).abs() <= JITTER * step) {
            let legal = format!("{step}, the mean, within a hundredth: resample it evenly");
            return Err(source.value(format!("step {n} of time (s)"), found, legal));
        }
    }
    Ok(1.0 / step)
}
