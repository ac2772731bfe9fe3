//! Pictures of a sweep: accuracy and throughput over every axis of the plan that varies.

use super::plot::{Axis, Medium, Plot, style};
use crate::results::{Group, GroupPoint, Merged};
use std::collections::BTreeMap;

/// One N_s of a group.
type Row<'a> = (&'a Group, &'a GroupPoint);

/// An axis of the plan.
struct Over {
    /// Its name in files.
    file: &'static str,
    /// Its name at the axis.
    name: &'static str,
    /// Its name in a legend.
    symbol: &'static str,
    of: fn(&Row) -> f64,
}

const AXES: [Over; 3] = [
    Over {
        file: "sensing-slots",
        name: "sensing slots N_s",
        symbol: "N_s",
        of: |(_, point)| f64::from(point.sensing_slots),
    },
    Over { file: "rho", name: "channel correlation rho", symbol: "rho", of: |(group, _)| group.rho },
    Over { file: "carrier", name: "carrier (GHz)", symbol: "GHz", of: |(group, _)| group.carrier_hz / 1e9 },
];

/// A point of a curve: where, how much, and its standard deviation.
type Point = (f64, f64, f64);

/// Every picture with its name.
pub fn pictures(merged: &Merged) -> Vec<(String, String)> {
    let rows: Vec<Row> = merged.groups.iter().flat_map(|g| g.points.iter().map(move |p| (g, p))).collect();
    let varies = |axis: &Over| rows.iter().any(|row| (axis.of)(row) != (axis.of)(&rows[0]));
    let mut pictures = Vec::new();
    for over in AXES.iter().filter(|axis| varies(axis)) {
        // a curve for every combination of the other axes
        let others: Vec<&Over> = AXES.iter().filter(|axis| axis.file != over.file && varies(axis)).collect();
        let (mut accuracy, mut throughput) = (BTreeMap::new(), BTreeMap::new());
        for row @ (group, point) in &rows {
            let mut words: Vec<String> =
                others.iter().map(|axis| format!("{} {}", axis.symbol, (axis.of)(row))).collect();
            if merged.groups.iter().any(|other| other.scenario != group.scenario) {
                words.insert(0, group.scenario.clone());
            }
            let x = (over.of)(row);
            let curve = |curves: &mut BTreeMap<String, Vec<Point>>, name: String, y: f64, deviation: f64| {
                curves.entry(name).or_default().push((x, y, deviation));
            };
            curve(&mut accuracy, words.join(", "), point.int8.mean, point.int8.deviation);
            for of_case in &point.throughput {
                let mut words = words.clone();
                words.push(format!("case {}", of_case.case));
                curve(&mut throughput, words.join(", "), of_case.throughput_bit_s / 1e6, 0.0);
            }
        }
        for (what, unit, curves) in [
            ("accuracy", "accuracy (int8, share)", accuracy),
            ("throughput", "throughput (Mbit/s)", throughput),
        ] {
            let svg = picture(&format!("{unit} over {}", over.name), over.name, unit, curves);
            pictures.push((format!("{what}-over-{}", over.file), svg));
        }
    }
    pictures
}

fn picture(title: &str, x: &str, y: &str, curves: BTreeMap<String, Vec<Point>>) -> String {
    let points = || curves.values().flatten();
    let ends = points().flat_map(|(_, y, deviation)| [y - deviation, y + deviation]);
    let axes = (Axis::around(points().map(|p| p.0), x), Axis::around(ends, y));
    let mut plot = Plot::new(title, axes.0, axes.1);
    for (index, (name, mut points)) in curves.into_iter().enumerate() {
        points.sort_by(|a, b| a.0.total_cmp(&b.0));
        let series = plot.series(&name, style(index));
        let line: Vec<(f64, f64)> = points.iter().map(|p| (p.0, p.1)).collect();
        plot.line(series, &line, 1.6);
        for (at, value, deviation) in points {
            if deviation > 0.0 {
                plot.error_bar(series, at, value - deviation, value + deviation);
            }
            plot.dot(series, (at, value), 3.0, &format!("{name} {at}: {value:.4}"));
        }
    }
    plot.svg(Medium::SINGLE)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::results::{PointThroughput, Spread};

    #[test]
    fn every_axis_that_varies_has_its_pictures() {
        let point = |sensing_slots: u32| GroupPoint {
            sensing_slots,
            float: Spread::of(&[0.9]),
            int8: Spread::of(&[0.8, 0.9]),
            seeds: 2,
            tested: 100,
            throughput: (1..=2)
                .map(|case| PointThroughput { case, throughput_bit: 3e6, throughput_bit_s: 3e6 })
                .collect(),
        };
        let group = |rho: f64| Group {
            scenario: "room & hall".into(),
            carrier_hz: 3.5e9,
            rho,
            spacing_slots: 3,
            points: vec![point(200), point(300)],
            curve: None,
            cases: Vec::new(),
            channels: String::new(),
        };
        let mut merged = Merged {
            name: "s".into(),
            program: "sdp3".into(),
            plan: String::new(),
            chance: 0.2,
            cells: Vec::new(),
            missing: Vec::new(),
            groups: vec![group(0.99), group(1.0)],
        };
        let found = pictures(&merged);
        let names: Vec<&str> = found.iter().map(|(name, _)| name.as_str()).collect();
        let all = [
            "accuracy-over-sensing-slots",
            "throughput-over-sensing-slots",
            "accuracy-over-rho",
            "throughput-over-rho",
        ];
        assert_eq!(names, all);
        assert!(found[0].1.contains("rho 0.99") && found[1].1.contains("rho 1, case 2"), "{}", found[1].1);
        assert_eq!(found[0].1.matches("class=\"entry\"").count(), 2);
        assert_eq!(found[3].1.matches("class=\"entry\"").count(), 4);
        merged.groups.truncate(1);
        assert_eq!(pictures(&merged).len(), 2);
    }
}
