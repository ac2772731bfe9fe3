//! What conformance firmware prints, read strictly: every line in its place, once, and nothing after `done`.
//!
//! `selftest <digest>`; per case `case <i> <stage> <values> <digest>` of every stage in order, then
//! `case <i> instructions <n>`; `schedule <slots> <digest>`; `stack <bytes>`; `done`.

use sdp3_core::values::Stage;

/// Name, number of values and digest of a stage.
pub type StageDigest = (String, u64, u64);

/// A whole output.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Transcript {
    /// Digest of the power-on self test.
    pub selftest: u64,
    /// The cases, in the suite's order.
    pub cases: Vec<CaseReport>,
    /// Slots and digest of the schedule.
    pub schedule: (u64, u64),
    /// Most stack used, in bytes.
    pub stack_bytes: u64,
}

/// What was printed of a case.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct CaseReport {
    /// Every stage.
    pub stages: Vec<StageDigest>,
    /// Instructions of one recognition.
    pub instructions: u64,
}

/// The line that is not what should stand there.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("line {line}: {expected} should be here, found {found:?}")]
pub struct Unexpected {
    line: usize,
    expected: String,
    found: String,
}

/// The lines that are left, blank ones left out.
struct Lines<'t> {
    lines: Vec<&'t str>,
    at: usize,
}

impl<'t> Lines<'t> {
    fn refused(&self, expected: impl Into<String>) -> Unexpected {
        let found = self.lines.get(self.at).copied().unwrap_or("the end").to_owned();
        Unexpected { line: self.at + 1, expected: expected.into(), found }
    }

    /// The words of the next line after `head`, all of them numbers, the last hexadecimal if `digest`.
    fn numbers<const N: usize>(&mut self, head: &str, digest: bool) -> Result<[u64; N], Unexpected> {
        let line = self.lines.get(self.at).copied().unwrap_or_default();
        let rest = line.strip_prefix(head).filter(|rest| N == 0 || rest.starts_with(' '));
        let words: Vec<&str> = rest.map(|rest| rest.split_ascii_whitespace().collect()).unwrap_or_default();
        let read = |(k, word): (usize, &&str)| match digest && k + 1 == N {
            true if word.len() == 16 => u64::from_str_radix(word, 16).ok(),
            true => None,
            false => word.parse().ok(),
        };
        let numbers: Option<Vec<u64>> = words.iter().enumerate().map(read).collect();
        match (rest, numbers.and_then(|numbers| numbers.try_into().ok())) {
            (Some(_), Some(numbers)) => {
                self.at += 1;
                Ok(numbers)
            }
            _ => Err(self.refused(format!("`{head}` and {N} numbers"))),
        }
    }

    fn case(&mut self, index: usize) -> Result<CaseReport, Unexpected> {
        let mut stages = Vec::new();
        for stage in Stage::ALL {
            let [count, digest] = self.numbers(&format!("case {index} {}", stage.name()), true)?;
            stages.push((stage.name().to_owned(), count, digest));
        }
        let [instructions] = self.numbers(&format!("case {index} instructions"), false)?;
        Ok(CaseReport { stages, instructions })
    }
}

/// Reads a whole output.
///
/// # Errors
///
/// [`Unexpected`] names the first line that is missing, doubled, out of order or not understood.
pub fn parse(text: &str) -> Result<Transcript, Unexpected> {
    let lines = text.lines().map(str::trim).filter(|line| !line.is_empty()).collect();
    let mut lines = Lines { lines, at: 0 };
    let [selftest] = lines.numbers("selftest", true)?;
    let mut cases = Vec::new();
    while lines.lines.get(lines.at).is_some_and(|line| line.starts_with("case ")) {
        cases.push(lines.case(cases.len())?);
    }
    let [slots, digest] = lines.numbers("schedule", true)?;
    let [stack_bytes] = lines.numbers("stack", false)?;
    let [] = lines.numbers("done", false)?;
    if lines.at < lines.lines.len() {
        return Err(lines.refused("nothing more"));
    }
    Ok(Transcript { selftest, cases, schedule: (slots, digest), stack_bytes })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn good() -> String {
        let mut text = "selftest 0ba80aa6e02f79c8\n".to_owned();
        for case in 0..2 {
            for (k, stage) in Stage::ALL.into_iter().enumerate() {
                text += &format!("case {case} {} {k} {:016x}\n", stage.name(), 255 + k);
            }
            text += &format!("case {case} instructions 123\n");
        }
        text + "schedule 40 71e32feb3f4cd392\n\nstack 26228\ndone\n"
    }

    #[test]
    fn a_whole_output_is_read() {
        let report = parse(&good()).unwrap();
        assert_eq!(report.cases.len(), 2);
        assert_eq!(report.cases[1].stages[0], ("beat".into(), 0, 255));
        assert_eq!((report.cases[0].instructions, report.stack_bytes), (123, 26228));
        assert_eq!(report.schedule, (40, 0x71e3_2feb_3f4c_d392));
    }

    #[test]
    fn any_line_missing_doubled_altered_or_out_of_order_is_refused() {
        let text = good();
        let lines: Vec<&str> = text.lines().filter(|line| !line.is_empty()).collect();
        let refused = |lines: &[&str]| assert!(parse(&lines.join("\n")).is_err(), "{lines:?}");
        for k in 0..lines.len() {
            let mut without = lines.clone();
            without.remove(k);
            refused(&without);
            let mut doubled = lines.clone();
            doubled.insert(k, lines[k]);
            refused(&doubled);
            let mut altered = lines.clone();
            let longer = format!("{} 1", lines[k]);
            altered[k] = &longer;
            refused(&altered);
            if k > 0 {
                let mut swapped = lines.clone();
                swapped.swap(k - 1, k);
                refused(&swapped);
            }
        }
        refused(&[&lines[..], &["panicked at core"]].concat());
        let error = parse(&text.replace("done", "down")).unwrap_err().to_string();
        assert_eq!(error, "line 26: `done` and 0 numbers should be here, found \"down\"");
    }
}
