//! Accuracy points: CSV `[spacing_slots,]sensing_slots,accuracy[,tested][,std]` with a header line, JSON of the same fields, or this
//! tool's own results (`run.json`, a study's `learning-curve.json`, a sweep's `merged.json`, what `sdp3 predict --json` printed).

use super::table;
use crate::error::Invalid;
use crate::results::{CurvePoint, Group, Spread};
use crate::store::limited;

use serde_json::Value;
use std::collections::BTreeMap;
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

const SPACING: &str = "an integer from 0 to 1000";
const SLOTS: &str = "a number of slots above 1";
const ACCURACY: &str = "0 to 1";
const TESTED: &str = "a number of recordings, at least 2";
const STD: &str = "a standard deviation above 0, at most 0.5";
const LEAST_TESTED: f64 = 2.0;

/// Points by N_m, `None` where the file states none.
pub type BySpacing = BTreeMap<Option<u32>, Vec<CurvePoint>>;

/// A point and its N_m, if stated.
type Stated = (Option<u32>, CurvePoint);

/// Reads points; a file that begins with `{` or `[` is JSON.
///
/// # Errors
///
/// [`PointsError`] names file, line or point, field, value and legal range.
pub fn read(file: &Path) -> Result<BySpacing, PointsError> {
    let text = limited::read_text(file, limited::TEXT)
        .map_err(|source| PointsError::Read { file: file.to_owned(), source })?;
    let refuse = |place: String, field: &'static str, value: &str, legal: &'static str| {
        Invalid::new(field, value, legal).at(place).at(file.display()).into()
    };
    let stated = match text.trim_start().starts_with(['{', '[']) {
        true => json(&text, &refuse)?,
        false => csv(&text, &refuse)?,
    };
    let mut points = BySpacing::new();
    stated.into_iter().for_each(|(spacing, point)| points.entry(spacing).or_default().push(point));
    Ok(points)
}

/// Reads points of one N_m.
///
/// # Errors
///
/// As [`read`]; points of several N_m.
pub fn read_one_spacing(file: &Path) -> Result<Vec<CurvePoint>, PointsError> {
    let mut points = read(file)?;
    if points.len() > 1 {
        let stated = |spacing: Option<u32>| spacing.map_or("none".to_owned(), |n| n.to_string());
        let all: Vec<String> = points.keys().map(|&spacing| stated(spacing)).collect();
        let legal = "one N_m: a learning curve goes through the points of one";
        return Err(Invalid::new("spacing_slots", all.join(", "), legal).at(file.display()).into());
    }
    Ok(points.pop_first().map(|(_, points)| points).unwrap_or_default())
}

fn legal_spacing(spacing: f64) -> bool {
    spacing.fract() == 0.0 && (0.0..=1000.0).contains(&spacing)
}

type Refuse<'a> = dyn Fn(String, &'static str, &str, &'static str) -> PointsError + 'a;

fn csv(text: &str, refuse: &Refuse) -> Result<Vec<Stated>, PointsError> {
    let mut lines = text.lines().enumerate().filter(|(_, line)| !line.trim().is_empty());
    let header = lines.next().map_or("", |(_, line)| line.trim());
    let names = table::cells(header);
    let own = names.join(",");
    let rest = own.strip_prefix("spacing_slots,").unwrap_or(&own).strip_prefix("sensing_slots,accuracy");
    if !rest.is_some_and(|rest| ["", ",tested", ",std", ",tested,std"].contains(&rest)) {
        let legal = "sensing_slots,accuracy, before them spacing_slots or nothing, then none, one or both of tested,std";
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
            let spacing = optional("spacing_slots", SPACING, legal_spacing)?;
            let tested = optional("tested", TESTED, |n| n >= LEAST_TESTED)?;
            let std = optional("std", STD, legal_std)?;
            let first = usize::from(spacing.is_some());
            let slots = number(first).filter(|&n| n > 1.0);
            let accuracy = number(first + 1).filter(|a| (0.0..=1.0).contains(a));
            let point = CurvePoint {
                sensing_slots: slots.ok_or_else(|| refuse(first, "sensing_slots", SLOTS))?,
                accuracy: accuracy.ok_or_else(|| refuse(first + 1, "accuracy", ACCURACY))?,
                tested,
                std,
            };
            Ok((spacing.map(|n| n as u32), point))
        })
        .collect()
}

fn legal_std(std: f64) -> bool {
    std > 0.0 && std <= 0.5
}

fn json(text: &str, refuse: &Refuse) -> Result<Vec<Stated>, PointsError> {
    let legal = "a list of {[spacing_slots, ]sensing_slots, accuracy[, tested][, std]}, or results of `sdp3 run`, `predict`, `study` or `merge`";
    let whole: Value = serde_json::from_str(text)
        .map_err(|error| refuse("the whole".into(), "JSON", &format!("({error})"), legal))?;
    if let Some(groups) = whole.get("groups") {
        let groups: Vec<Group> = serde_json::from_value(groups.clone())
            .map_err(|error| refuse("groups".into(), "JSON", &format!("({error})"), legal))?;
        return merged(&groups, refuse);
    }
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
            // of a study's seeds
            let spread =
                entry.get("int8").and_then(|int8| serde_json::from_value::<Spread>(int8.clone()).ok());
            let std = entry.get("std").filter(|value| !value.is_null());
            if std.is_some() && !number(std).is_some_and(legal_std) {
                return Err(refuse("std", std, STD));
            }
            let spacing = entry.get("spacing_slots").filter(|value| !value.is_null());
            if spacing.is_some() && !number(spacing).is_some_and(legal_spacing) {
                return Err(refuse("spacing_slots", spacing, SPACING));
            }
            let legal_accuracy = number(accuracy).filter(|a| (0.0..=1.0).contains(a));
            let point = CurvePoint {
                sensing_slots: number(slots)
                    .filter(|&n| n > 1.0)
                    .ok_or_else(|| refuse("sensing_slots", slots, SLOTS))?,
                accuracy: legal_accuracy.ok_or_else(|| refuse("accuracy", accuracy, ACCURACY))?,
                tested: number(tested).map(|n| n * spread.map_or(1.0, |s| f64::from(s.seeds))),
                std: number(std).or(spread.and_then(|s| s.standard_error())),
            };
            Ok((number(spacing).map(|n| n as u32), point))
        })
        .collect()
}

/// The int8 means of a merged sweep, one group for each N_m.
fn merged(groups: &[Group], refuse: &Refuse) -> Result<Vec<Stated>, PointsError> {
    let mut stated = Vec::new();
    for (index, group) in groups.iter().enumerate() {
        let spacing = group.spacing_slots;
        if groups[..index].iter().any(|other| other.spacing_slots == spacing) {
            let legal =
                "another one than that of the groups before: one scenario, carrier and rho for each N_m";
            return Err(refuse(format!("group {}", index + 1), "spacing_slots", &spacing.to_string(), legal));
        }
        stated.extend(group.points.iter().map(|point| (Some(spacing), point.curve_point())));
    }
    Ok(stated)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn written(text: &str) -> tempfile::NamedTempFile {
        let file = tempfile::NamedTempFile::new().unwrap();
        std::fs::write(file.path(), text).unwrap();
        file
    }

    fn of(text: &str) -> Result<BySpacing, PointsError> {
        read(written(text).path())
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
    fn points_of_several_spacings_are_read_apart() {
        let text =
            "spacing_slots,sensing_slots,accuracy,std\n12,200,0.9,0.01\n3,200,0.8,0.02\n12,300,0.95,0.01\n";
        let csv = of(text).unwrap();
        let json = of(r#"[{"spacing_slots":12,"sensing_slots":200,"accuracy":0.9,"std":0.01},
            {"spacing_slots":3,"sensing_slots":200,"accuracy":0.8,"std":0.02},
            {"spacing_slots":12,"sensing_slots":300,"accuracy":0.95,"std":0.01}]"#);
        assert_eq!(csv, json.unwrap());
        assert_eq!(csv.keys().collect::<Vec<_>>(), [&Some(3), &Some(12)]);
        let slots = |spacing| csv[&Some(spacing)].iter().map(|p| p.sensing_slots).collect::<Vec<_>>();
        assert_eq!((slots(3), slots(12)), (vec![200.0], vec![200.0, 300.0]));
        let refused = read_one_spacing(written(text).path()).unwrap_err().to_string();
        assert!(refused.contains("spacing_slots is 3, 12, must be one N_m"), "{refused}");
        let one = "spacing_slots,sensing_slots,accuracy\n12,200,0.9\n12,300,0.95\n";
        assert_eq!(read_one_spacing(written(one).path()).unwrap().len(), 2);
    }

    #[test]
    fn of_several_seeds_a_point_has_the_standard_error_of_their_mean() {
        let int8 = r#""int8":{"mean":0.5,"deviation":0.02,"seeds":4}"#;
        let study = of(&format!(r#"{{"rows":[{{"sensing_slots":200,{int8},"tested":50}}]}}"#)).unwrap();
        let point = CurvePoint { sensing_slots: 200.0, accuracy: 0.5, tested: Some(200.0), std: Some(0.01) };
        assert_eq!(study, [(None, vec![point])].into());
        // a merged sweep counts the recordings of all seeds
        let group = |spacing: u32| {
            format!(
                r#"{{"scenario":"s","carrier_hz":3.5e9,"rho":0.997,"spacing_slots":{spacing},"cases":[],"points":[{{"sensing_slots":200,{int8},
                "float":{{"mean":0.5,"deviation":0.02,"seeds":4}},"seeds":4,"tested":200,"throughput":[]}}]}}"#
            )
        };
        let merged = of(&format!(r#"{{"groups":[{},{}]}}"#, group(3), group(12))).unwrap();
        assert_eq!(merged, [(Some(3), vec![point]), (Some(12), vec![point])].into());
        let refused = of(&format!(r#"{{"groups":[{},{}]}}"#, group(3), group(3))).unwrap_err().to_string();
        assert!(refused.contains("group 2: spacing_slots is 3, must be another one"), "{refused}");
    }

    #[test]
    fn refusals_name_place_field_value_and_range() {
        for (text, words) in [
            ("[{\"sensing_slots\":200,\"accuracy\":1.5}]", ["point 1", "accuracy is 1.5", "0 to 1"]),
            ("[{\"sensing_slots\":null,\"accuracy\":0.5}]", ["point 1", "sensing_slots is null", "above 1"]),
            ("[{\"sensing_slots\":200,\"accuracy\":NaN}]", ["the whole", "JSON", "line 1 column 34"]),
            ("{\"a\": 3}", ["the whole", "points is missing", "sensing_slots, accuracy"]),
            (
                "spacing_slots,sensing_slots,accuracy\n2.5,200,0.5\n",
                ["line 2", "spacing_slots is \"2.5\"", "0 to 1000"],
            ),
            (
                "[{\"spacing_slots\":-1,\"sensing_slots\":200,\"accuracy\":0.5}]",
                ["point 1", "spacing_slots is -1", "0 to 1000"],
            ),
            ("sensing_slots,accuracy\n200,NaN\n", ["line 2", "accuracy is \"NaN\"", "0 to 1"]),
            ("", ["line 1", "header is \"\"", "sensing_slots,accuracy"]),
        ] {
            let error = of(text).unwrap_err().to_string();
            assert!(words.iter().all(|word| error.contains(word)), "{error}");
        }
    }
}
