//! The tables of the page: conformance, learning curves, confusion.

use super::plot::{escape, grouped, number};
use crate::predictor::learning_curve::{Model, paper};
use crate::results::{ChannelTable, Confusion, Figures, Prediction, Verify};
use std::fmt::Write;

/// Every stage of every target.
pub fn conformance(verify: &Verify) -> String {
    let mut rows = String::new();
    for target in &verify.targets {
        let instructions = target.instructions.map_or_else(|| "–".into(), grouped);
        let _ = write!(
            rows,
            "<tr class=\"head\"><th>{}</th><td>{}</td><td>{}</td><td>{instructions}</td><td>{}</td></tr>",
            escape(&target.name),
            grouped(target.compared),
            target.mismatches,
            escape(target.detail.as_deref().unwrap_or(""))
        );
        for s in &target.stages {
            let error = s.largest_error.map_or_else(String::new, |e| format!("; largest {}", number(e)));
            let _ = write!(
                rows,
                "<tr><td>{}</td><td>{}</td><td>{}</td><td></td><td>{}{error}</td></tr>",
                escape(&s.stage),
                grouped(s.compared),
                s.mismatches,
                escape(&s.rule)
            );
        }
    }
    format!(
        "<div class=\"scroll\"><table><tr><th>target, stage</th><th>compared</th><th>mismatches</th>\
         <th>instructions a recognition</th><th>rule</th></tr>{rows}</table></div>"
    )
}

/// The seven models and their figures of merit.
pub fn models(figures: &Figures) -> String {
    let mut rows = String::new();
    for m in &figures.prediction.models {
        let p = &m.parameters;
        let parameters: Vec<String> = [Some(p.alpha), Some(p.beta), p.gamma, p.epsilon]
            .into_iter()
            .zip(["α", "β", "γ", "ε"])
            .filter_map(|(value, name)| value.map(|v| format!("{name} = {}", number(v))))
            .collect();
        let optional = |x: Option<f64>| x.map_or_else(|| "–".into(), number);
        let _ = write!(
            rows,
            "<tr><th>{}</th><td>{}</td><td>{}</td><td>{}</td><td>{}</td><td>{}</td></tr>",
            escape(&m.name),
            number(m.sse),
            number(m.rmse),
            optional(m.aicc),
            optional(m.loo),
            parameters.join(", ")
        );
    }
    format!(
        "<div class=\"scroll\"><table><tr><th>model</th><th>squared error</th><th>rmse</th><th>AICc</th>\
         <th>leave-one-out</th><th>parameters</th></tr>{rows}</table></div>"
    )
}

/// The seven models in plain text, each with its place by every figure of merit; beside Table III if the points are the paper's.
pub fn prediction(prediction: &Prediction) -> String {
    let is_paper = prediction.points.len() == paper::POINTS.len()
        && prediction
            .points
            .iter()
            .zip(paper::POINTS)
            .all(|(p, (n, a))| p.sensing_slots == f64::from(n) && (p.accuracy - a).abs() < 1e-3);
    let places = |list: &[String], name: &str| {
        list.iter().position(|n| n == name).map_or_else(|| "-".to_owned(), |k| (k + 1).to_string())
    };
    let r = &prediction.ranking;
    let mut text = format!("{:<16}{:>18}{:>9}{:>16}{:>14}{:>6}", "model", "sse", "rmse", "aicc", "loo", "cp");
    if is_paper {
        text += &format!("{:>22}", "the paper's sse");
    }
    for m in &prediction.models {
        let merit = |x: Option<f64>, list: &[String]| match x {
            Some(x) => format!("{x:.4} ({})", places(list, &m.name)),
            None => "-".to_owned(),
        };
        let sse = format!("{:.4e} ({})", m.sse, places(&r.sse, &m.name));
        let _ = write!(
            text,
            "\n{:<16}{sse:>18}{:>9.4}{:>16}{:>14}{:>6}",
            m.name,
            m.rmse,
            merit(m.aicc, &r.aicc),
            merit(m.loo, &r.loo),
            places(&r.cp, &m.name)
        );
        if let Some(row) = Model::by_name(&m.name).filter(|_| is_paper).and_then(paper::printed) {
            let place = paper::TABLE_III.iter().position(|r| r.model == row.model).map_or(0, |k| k + 1);
            let _ = write!(text, "{:>22}", format!("{:.4e} ({place})", row.sse));
        }
    }
    let _ = write!(text, "\nbest: {}; in brackets the place by each figure of merit", prediction.best);
    if let Some(band) = &prediction.band {
        let least = prediction.points.iter().map(|p| p.sensing_slots).fold(f64::INFINITY, f64::min);
        let within = band.points.iter().filter(|p| p.sensing_slots >= least);
        let width = within.map(|p| p.high - p.low).fold(0.0, f64::max);
        let _ = write!(
            text,
            "\n{:.0} % band by {} draws from {}: at most {width:.3} wide from N_s = {least} on",
            100.0 * band.coverage,
            band.draws,
            band.source
        );
    }
    text
}

/// One confusion matrix.
pub fn confusion(c: &Confusion, classes: &[String]) -> String {
    let mut rows = String::new();
    for (truth, row) in c.counts.iter().enumerate() {
        let total: u32 = row.iter().sum();
        let name = classes.get(truth).map_or("", String::as_str);
        let _ = write!(rows, "<tr><th>{}</th>", escape(name));
        for (answer, &n) in row.iter().enumerate() {
            let share = f64::from(n) / f64::from(total.max(1));
            let class = if truth == answer { "right" } else { "wrong" };
            let _ = write!(rows, "<td class=\"{class}\" style=\"--share:{share:.2}\">{n}</td>");
        }
        rows.push_str("</tr>");
    }
    format!(
        "<figure><table class=\"confusion\"><caption>{}, N_s = {}</caption>{rows}</table></figure>",
        escape(&c.arithmetic),
        c.sensing_slots
    )
}

/// Table I in plain text: verdict, statistic and threshold of each property, and what the paper says.
pub fn channels(table: &ChannelTable) -> String {
    let mut text = format!("Table I from data, {} GHz, seed {}\n", table.carrier_hz / 1e9, table.seed);
    for model in &table.models {
        let _ = writeln!(text, "\n{}", model.name);
        for name in crate::simulator::channel::properties::PROPERTIES {
            let Some(p) = model.properties.get(name) else { continue };
            let word = |yes: bool| if yes { "yes" } else { "no" };
            let paper = match p.paper {
                Some(paper) if paper == p.verdict => String::new(),
                Some(paper) => format!("  paper: {}; {}", word(paper), p.reason),
                None => format!("  {}", p.reason),
            };
            let _ = writeln!(
                text,
                "  {name:<24} {:<4} {:>10.3e} {} {:<8}{paper}",
                word(p.verdict),
                p.statistic,
                p.relation,
                p.threshold
            );
        }
    }
    if let Some(model) = table.models.first() {
        text.push_str("\nThe statistics:\n");
        for name in crate::simulator::channel::properties::PROPERTIES {
            if let Some(p) = model.properties.get(name) {
                let _ = writeln!(text, "  {name:<24} {}", p.meaning);
            }
        }
    }
    text.trim_end().to_owned()
}
