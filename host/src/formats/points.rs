//! Accuracy points: CSV `sensing_slots,accuracy[,tested][,std]` with a header line, JSON of the same fields, or this tool's own results
//! (`run.json`, a study's `learning-curve.json`, what `sdp3 predict --json` printed).

use super::table;
use crate::error::Invalid;
use crate::results::CurvePoint;
use crate::store::limited;

use serde_json::Value;
use std::path::{Path, PathBuf};

/// Why a file of points cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum PointsError {
    /// It cannot be read.
    #[error("{file}: {source}")]
    Read {
        /// The file.
        file: PathBuf,
        /// What the system says.
        source: std::io::Error,
    },
    /// A field that may not be what it is.
    #[error(transparent)]
    Invalid(#[from] Invalid),
}

const SLOTS: &str = "a number of slots above 1";
const ACCURACY: &str = "0 to 1";
const TESTED: &str = "a number of recordings, at least 2";
const STD: &str = "a standard deviation above 0, at most 0.5";
const LEAST_TESTED: f64 = 2.0;

/// Reads points; a file that begins with `{` or `[` is JSON.
///
/// # Errors
///
/// [`PointsError`] names file, line or point, field, value and legal range.
pub fn read(file: &Path) -> Result<Vec<CurvePoint>, PointsError> {
    let text = limited::read_text(file, limited::TEXT)
        .map_err(|source| PointsError::Read { file: file.to_owned(), source })?;
    let refuse = |place: String, field: &'static str, value: &str, legal: &'static str| {
        Invalid::new(field, value, legal).at(place).at(file.display()).into()
    };
    if text.trim_start().starts_with(['{', '[']) { json(&text, &refuse) } else { csv(&text, &refuse) }
}

type Refuse<'a> = dyn Fn(String, &'static str, &str, &'static str) -> PointsError + 'a;

fn csv(text: &str, refuse: &Refuse) -> Result<Vec<CurvePoint>, PointsError> {
    let mut lines = text.lines().enumerate().filter(|(_, line)| !line.trim().is_empty());
    let header = lines.next().map_or("", |(_, line)| line.trim());
    let names = table::cells(header);
    let legal = ["", ",tested", ",std", ",tested,std"].map(|rest| format!("sensing_slots,accuracy{rest}"));
    if !legal.contains(&names.join(",")) {
        let legal = "sensing_slots,accuracy, then none, one or both of tested,std";
        return Err(refuse("line 1".into(), "header", &format!("{header:?}"), legal));
    }
    lines
        .map(|(index, line)| {
            let place = || format!("line {}", index + 1);
            let cells = table::cells(line);
            let cell = |k: usize| cells.get(k).map_or("", String::as_str);
            let number = |k: usize| cell(k).parse::<f64>().ok().filter(|x| x.is_finite());
            let refuse = |k: usize, field, legal| refuse(place(), field, &format!("{:?}", cell(k)), legal);
            if cells.len() != names.len() {
                let legal = "as many cells as the header has";
                return Err(refuse(names.len(), "cell", legal));
            }
            let column = |name: &str| names.iter().position(|own| *own == name);
            let optional = |name, legal, within: fn(f64) -> bool| match column(name) {
                None => Ok(None),
                Some(k) => number(k).filter(|&x| within(x)).map(Some).ok_or_else(|| refuse(k, name, legal)),
            };
            let tested = optional("tested", TESTED, |n| n >= LEAST_TESTED)?;
            let std = optional("std", STD, legal_std)?;
            let slots = number(0).filter(|&n| n > 1.0);
            let accuracy = number(1).filter(|a| (0.0..=1.0).contains(a));
            Ok(CurvePoint {
                sensing_slots: slots.ok_or_else(|| refuse(0, "sensing_slots", SLOTS))?,
                accuracy: accuracy.ok_or_else(|| refuse(1, "accuracy", ACCURACY))?,
                tested,
                std,
            })
        })
        .collect()
}

fn legal_std(std: f64) -> bool {
    std > 0.0 && std <= 0.5
}

fn json(text: &str, refuse: &Refuse) -> Result<Vec<CurvePoint>, PointsError> {
    let legal = "a list of {sensing_slots, accuracy[, tested][, std]}, or results of `sdp3 run`, `predict` or `study`";
    let whole: Value = serde_json::from_str(text)
        .map_err(|error| refuse("the whole".into(), "JSON", &format!("({error})"), legal))?;
    let places = [Some(&whole), whole.get("points"), whole.get("accuracy"), whole.get("rows")];
    let list = places.into_iter().flatten().find_map(Value::as_array);
    let list = list.ok_or_else(|| refuse("the whole".into(), "points", "missing", legal))?;
    list.iter()
        .enumerate()
        .map(|(index, entry)| {
            let place = || format!("point {}", index + 1);
            // this tool's own results count the answers of the int8 core, a study their mean
            let accuracy = [entry.get("accuracy"), entry.get("int8").map(|a| a.get("mean").unwrap_or(a))];
            let accuracy = accuracy.into_iter().flatten().next();
            let slots = entry.get("sensing_slots");
            let tested = entry.get("tested").filter(|value| !value.is_null());
            let number = |value: Option<&Value>| value.and_then(Value::as_f64);
            let shown = |value: Option<&Value>| value.map_or("missing".into(), Value::to_string);
            let refuse = |field, value, legal| refuse(place(), field, &shown(value), legal);
            if tested.is_some() && number(tested).is_none_or(|n| n < LEAST_TESTED) {
                return Err(refuse("tested", tested, TESTED));
            }
            let std = entry.get("std").filter(|value| !value.is_null());
            if std.is_some() && !number(std).is_some_and(legal_std) {
                return Err(refuse("std", std, STD));
            }
            let legal_accuracy = number(accuracy).filter(|a| (0.0..=1.0).contains(a));
            Ok(CurvePoint {
                sensing_slots: number(slots)
                    .filter(|&n| n > 1.0)
                    .ok_or_else(|| refuse("sensing_slots", slots, SLOTS))?,
                accuracy: legal_accuracy.ok_or_else(|| refuse("accuracy", accuracy, ACCURACY))?,
                tested: number(tested),
                std: number(std),
            })
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(text: &str) -> Result<Vec<CurvePoint>, PointsError> {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("points");
        std::fs::write(&file, text).unwrap();
        read(&file)
    }

    #[test]
    fn every_form_gives_the_same_points() {
        let csv = of("sensing_slots,accuracy,tested\n200,0.5,60\n300,0.7,60\n").unwrap();
        let forms = [
            r#"[{"sensing_slots":200,"accuracy":0.5,"tested":60},{"sensing_slots":300,"accuracy":0.7,"tested":60}]"#,
            r#"{"best":"pow3","points":[{"sensing_slots":200.0,"accuracy":0.5,"tested":60},
                {"sensing_slots":300.0,"accuracy":0.7,"tested":60}]}"#,
            r#"{"accuracy":[{"sensing_slots":200,"float":0.6,"int8":0.5,"tested":60},
                {"sensing_slots":300,"float":0.7,"int8":0.7,"tested":60}]}"#,
            r#"{"rows":[{"sensing_slots":200,"int8":{"mean":0.5,"deviation":0.1},"tested":60},
                {"sensing_slots":300,"int8":{"mean":0.7,"deviation":0.1},"tested":60}]}"#,
            "\"sensing_slots\",\"accuracy\",tested\n\n\"200\", 0.5 ,60\n300,\"0.7\",\"60\"\n",
        ];
        for form in forms {
            assert_eq!(of(form).unwrap(), csv, "{form}");
        }
    }

    #[test]
    fn refusals_name_place_field_value_and_range() {
        for (text, words) in [
            ("[{\"sensing_slots\":200,\"accuracy\":1.5}]", ["point 1", "accuracy is 1.5", "0 to 1"]),
            ("[{\"sensing_slots\":null,\"accuracy\":0.5}]", ["point 1", "sensing_slots is null", "above 1"]),
            ("[{\"sensing_slots\":200,\"accuracy\":NaN}]", ["the whole", "JSON", "line 1 column 34"]),
            ("{\"a\": 3}", ["the whole", "points is missing", "sensing_slots, accuracy"]),
            ("sensing_slots,accuracy\n200,NaN\n", ["line 2", "accuracy is \"NaN\"", "0 to 1"]),
            ("", ["line 1", "header is \"\"", "sensing_slots,accuracy"]),
        ] {
            let error = of(text).unwrap_err().to_string();
            assert!(words.iter().all(|word| error.contains(word)), "{error}");
        }
    }
}
