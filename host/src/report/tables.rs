//! The tables of the page: conformance, learning curves, confusion.

use super::plot::{escape, grouped, number};
use crate::results::{ChannelTable, Confusion, Figures, Verify};
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
