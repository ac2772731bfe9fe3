//! The tables of the page: conformance, instructions, learning curves.

use super::plot::{grouped, number};
use crate::formats::table;
use crate::predictor::{Model, paper};
use crate::results::{ChannelTable, Figures, Interval, Parameters, Prediction, RoomFit, SweepRow, Verify};
use maud::{Markup, html};
use std::collections::BTreeSet;
use std::fmt::Write;

/// Every stage of every target.
pub fn conformance(verify: &Verify) -> Markup {
    let largest = |error: Option<f64>| error.map_or_else(String::new, |e| format!("; largest {}", number(e)));
    html! {
        div.scroll {
            table #targets {
                tr {
                    th { "target, stage" }
                    th { "compared" }
                    th { "mismatches" }
                    th { "instructions a recognition" }
                    th { "rule" }
                }
                @for target in &verify.targets {
                    tr.head {
                        th scope="row" { (target.name) }
                        td { (grouped(target.compared)) }
                        td { (target.mismatches) }
                        td { (target.instructions.map_or_else(|| "–".into(), grouped)) }
                        td { (target.detail.as_deref().unwrap_or("")) }
                    }
                    @for s in &target.stages {
                        tr {
                            td { (s.stage) }
                            td { (grouped(s.compared)) }
                            td { (s.mismatches) }
                            td {}
                            td { (s.rule) (largest(s.largest_error)) }
                        }
                    }
                }
            }
        }
    }
}

/// The seven models and their figures of merit.
pub fn models(figures: &Figures) -> Markup {
    let optional = |x: Option<f64>| x.map_or_else(|| "–".into(), number);
    let parameters = |p: &Parameters| {
        let named = [Some(p.alpha), Some(p.beta), p.gamma, p.epsilon].into_iter().zip(["α", "β", "γ", "ε"]);
        let words = named.filter_map(|(value, name)| value.map(|v| format!("{name} = {}", number(v))));
        words.collect::<Vec<_>>().join(", ")
    };
    html! {
        div.scroll {
            table #models {
                tr {
                    th { "model" }
                    th { "squared error" }
                    th { "rmse" }
                    th { "AICc" }
                    th { "leave-one-out" }
                    th { "parameters" }
                }
                @for m in &figures.prediction.models {
                    tr data-model=(m.name) {
                        th scope="row" { (m.name) }
                        td { (number(m.sse)) }
                        td { (number(m.rmse)) }
                        td { (optional(m.aicc)) }
                        td { (optional(m.loo)) }
                        td { (parameters(&m.parameters)) }
                    }
                }
            }
        }
    }
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
    } else {
        text += "\nno band: points without tested or std, as few as the curve's parameters, do not say how sure they are";
    }
    text
}

/// Instructions of a recognition, as the run's own proof counted them: a row for each N_s, a column for each machine.
pub fn instructions(verify: &Verify) -> Markup {
    let counted: Vec<_> = verify.targets.iter().filter(|t| !t.recognitions.is_empty()).collect();
    let all = || counted.iter().flat_map(|t| &t.recognitions);
    let most = all().map(|c| c.instructions).max().unwrap_or(1);
    let slots: BTreeSet<u32> = all().map(|c| c.sensing_slots).collect();
    if slots.is_empty() {
        return html! { p { "No firmware was compared in this run." } };
    }
    let share = |instructions: u64| format!("--share:{:.4}", instructions as f64 / most as f64);
    html! {
        div.scroll {
            table #instructions {
                caption { "Instructions of one recognition, first sample to class" }
                tr {
                    th scope="col" { "N_s" }
                    @for target in &counted { th scope="col" { (target.name) } }
                }
                @for n in slots {
                    tr {
                        th scope="row" { (n) }
                        @for target in &counted {
                            @match target.recognitions.iter().find(|c| c.sensing_slots == n) {
                                Some(c) => { td.bar style=(share(c.instructions)) { (grouped(c.instructions)) } }
                                None => { td { "–" } }
                            }
                        }
                    }
                }
            }
        }
    }
}

/// A value with its interval.
fn within(value: f64, interval: Option<Interval>, digits: usize) -> String {
    let ends = interval.map(|i| format!(" [{:.digits$}, {:.digits$}]", i.low, i.high)).unwrap_or_default();
    format!("{value:.digits$}{ends}")
}

/// The fitted rho and power of the room's fluctuation in words.
fn fluctuation(room: &RoomFit) -> String {
    format!(
        "by the spectrum rho = {}, fluctuation {} dB below the room's mean, {} windows",
        within(room.rho, room.rho_interval, 4),
        within(room.k_factor_db, room.k_factor_interval, 1),
        room.windows
    )
}

/// Cells of a room's models: name, divergences of intensities and spectra, and how far behind the AR room each is.
fn room_rows(room: &RoomFit) -> impl Iterator<Item = [String; 5]> {
    let behind =
        |i: Option<Interval>| i.map_or_else(|| "-".into(), |i| format!("{:+.3} to {:+.3}", i.low, i.high));
    room.models.iter().map(move |m| {
        let [kl, spectral] = [m.kl, m.spectral].map(|x| format!("{x:.3}"));
        [m.model.clone(), kl, behind(m.kl_excess), spectral, behind(m.spectral_excess)]
    })
}

/// Heads of a room's models.
const ROOM: [&str; 5] = ["room", "KL of intensities", "above the AR room", "of spectra", "above the AR room"];

/// The room's models in plain text, after a line.
pub fn room(room: &RoomFit) -> String {
    let mut text = format!("\n{}\n", fluctuation(room));
    for [model, kl, kl_excess, spectral, spectral_excess] in
        std::iter::once(ROOM.map(String::from)).chain(room_rows(room))
    {
        let _ = writeln!(text, "  {model:<12} {kl:>17}  {kl_excess:<18} {spectral:>10}  {spectral_excess}");
    }
    text + &room.verdict
}

/// The room's models on a page.
pub fn room_on_page(room: &RoomFit) -> Markup {
    html! {
        p { (fluctuation(room)) ": " (room.verdict) ". Intervals: 95 %." }
        table {
            tr { @for head in ROOM { th { (head) } } }
            @for cells in room_rows(room) { tr { @for cell in cells { td { (cell) } } } }
        }
    }
}

/// Table I in plain text: verdict, statistic and threshold of each property, and what the paper says.
pub fn channels(table: &ChannelTable) -> String {
    let mut text = format!("Table I from data, {} GHz, seed {}\n", table.carrier_hz / 1e9, table.seed);
    for model in &table.models {
        let _ = writeln!(text, "\n{}", model.name);
        for name in crate::simulator::channel::properties::PROPERTIES {
            let Some(p) = model.properties.get(name) else { continue };
            let word = |yes: bool| if yes { "yes" } else { "no" };
            let (Some(verdict), Some(statistic)) = (p.verdict, p.statistic) else {
                let paper = p.paper.map_or(String::new(), |paper| format!("; paper: {}", word(paper)));
                let _ = writeln!(text, "  {name:<24} {}{paper}", p.reason);
                continue;
            };
            let paper = match p.paper {
                Some(paper) if paper == verdict => String::new(),
                Some(paper) => format!("  paper: {}; {}", word(paper), p.reason),
                None => format!("  {}", p.reason),
            };
            let _ = writeln!(
                text,
                "  {name:<24} {:<4} {:>10.3e} {} {:<8}{paper}",
                word(verdict),
                statistic,
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

/// Operating points over the axes of `optimize --sweep`, a line each, cells apart by `delimiter`.
pub fn sweep(rows: &[SweepRow], period_s: f64, delimiter: u8) -> String {
    let header = [
        "carrier_hz",
        "power_w",
        "users",
        "distance",
        "case",
        "sensing_slots",
        "accuracy",
        "throughput_bit",
        "throughput_mbit_s",
    ];
    let some = |x: Option<f64>| x.map_or_else(String::new, |x| x.to_string());
    let row = |r: &SweepRow| {
        vec![
            r.carrier_hz.to_string(),
            r.power_w.to_string(),
            r.users.to_string(),
            r.distance.to_string(),
            r.case.to_string(),
            some(r.sensing_slots.map(f64::from)),
            some(r.accuracy),
            some(r.throughput_bit),
            some(r.throughput_bit.map(|bit| bit / period_s / 1e6)),
        ]
    };
    table::delimited(delimiter, &header, rows.iter().map(row))
}
