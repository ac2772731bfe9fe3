//! Pictures and pages of what the floors found. Reads results, computes none.
//!
//! [`page`] is one self-contained HTML file: no script, no font, no address outside it.

pub mod anytime;
#[cfg(feature = "train")]
pub mod fidelity;
pub mod figures;
pub mod gallery;
pub mod plot;
pub mod spectrograms;
#[cfg(feature = "train")]
pub mod studies;
pub mod tables;
pub mod timeline;

use crate::results::{Figures, Run};
use plot::{escape, grouped, number};
use std::fmt::Write;

const STYLE: &str = include_str!("style.css");

fn section(page: &mut String, id: &str, title: &str, caption: &str, body: &str) {
    let _ = write!(page, "<section id=\"{id}\"><h2>{title}</h2><p>{caption}</p>{body}</section>");
}

/// The report page of a run.
pub fn page(run: &Run, figures: &Figures, scenario_toml: &str) -> String {
    let name = escape(&run.scenario);
    let p = &run.operating_point;
    let mut page = format!(
        "<!doctype html><html lang=\"en\"><head><meta charset=\"utf-8\"><meta name=\"viewport\" \
         content=\"width=device-width,initial-scale=1\"><title>sdp3: {name}</title><style>{STYLE}</style></head><body>\
         <header><h1>{name}</h1><p>How many slots must be spent on radar to recognise how a person moves, and what does \
         that cost in throughput?</p></header><main><ul class=\"headline\">"
    );
    for (value, text) in [
        (number(run.rho), "memory of the room, ρ"),
        (p.sensing_slots.to_string(), "sensing slots at the operating point"),
        (format!("{:.1} %", 100.0 * p.accuracy), "predicted accuracy there"),
        (format!("{:.2} Mbit", p.throughput_bit / 1e6), "per period to the worst receiver"),
        (grouped(run.verify.compared), "values and digests compared"),
        (run.verify.mismatches.to_string(), "mismatches"),
    ] {
        let _ = write!(page, "<li><b>{value}</b> {text}</li>");
    }
    page.push_str("</ul><nav>");
    for (id, text) in [
        ("spectrograms", "Spectrograms"),
        ("calibration", "Calibration"),
        ("learning", "Learning"),
        ("region", "Region"),
        ("schedule", "Schedule"),
        ("conformance", "Conformance"),
        ("configuration", "Configuration"),
    ] {
        let _ = write!(page, "<a href=\"#{id}\">{text}</a> ");
    }
    page.push_str("</nav>");

    let pictures: String = figures.spectrograms.iter().map(spectrograms::figure).collect();
    section(
        &mut page,
        "spectrograms",
        "Spectrograms",
        "One simulated recording of each class as the network sees it: the torso's line near the walking speed's Doppler, \
         limbs around it in the rhythm of the gait (paper, figure of the experimental spectrograms).",
        &format!("<div class=\"row\">{pictures}</div>"),
    );

    let c = &figures.calibration;
    let both: String = [&c.measured, &c.simulated].into_iter().flatten().map(spectrograms::figure).collect();
    let curve = if c.curve.is_empty() { String::new() } else { figures::kl_curve(c) };
    section(
        &mut page,
        "calibration",
        "Calibration",
        &format!(
            "ρ = {}. {}. The curve shows {}: the paper's eq. (fitting) and its KL figure.",
            number(c.rho),
            escape(&c.source),
            escape(&c.curve_of)
        ),
        &format!(
            "<div class=\"row\"><figure>{curve}<figcaption>KL divergence over ρ</figcaption></figure><figure>{}\
             <figcaption>Share of each grey level</figcaption></figure></div><div class=\"row\">{both}</div>",
            figures::pmf(c)
        ),
    );

    let matrices: String =
        figures.confusion.iter().rev().take(2).map(|m| tables::confusion(m, &figures.classes)).collect();
    section(
        &mut page,
        "learning",
        "Learning",
        &format!(
            "Accuracy on recordings never seen, from raw I/Q through the radar module's own code, and the learning curves \
             fitted to it (paper, Tables II and III); the best is {} with rmse {}. Bars: one standard deviation of the count.",
            escape(&run.curve.model),
            number(run.curve.rmse)
        ),
        &format!(
            "<div class=\"row\"><figure>{}<figcaption>Accuracy over N_s</figcaption></figure><figure>{}\
             <figcaption>Training loss</figcaption></figure></div>{}<div class=\"row\">{matrices}</div>",
            figures::learning_curve(run, figures),
            figures::losses(figures),
            tables::models(figures)
        ),
    );
    section(
        &mut page,
        "region",
        "Accuracy-throughput region",
        &format!(
            "Largest worst throughput for every accuracy (paper, Theorem 1), both receiver placements. The ring is the \
             operating point: {}.",
            escape(&p.rule)
        ),
        &format!("<figure>{}</figure>", figures::region(run, figures)),
    );
    let recognised = run.schedule.recognised.as_ref().map_or_else(String::new, |r| {
        format!(
            " The core recognised {} as {} ({:.0} %).",
            escape(&r.truth),
            escape(&r.class),
            100.0 * r.confidence
        )
    });
    section(
        &mut page,
        "schedule",
        "One period",
        &format!(
            "The core's scheduler plays the operating point: {} sensing slots, {:?} slots to the receivers, longest waits \
             {:?} slots.{recognised}",
            run.schedule.sensing_slots, run.schedule.communication_slots, run.schedule.longest_wait_slots
        ),
        &format!("<figure>{}</figure>", timeline::timeline(&run.schedule.timeline)),
    );
    section(
        &mut page,
        "conformance",
        "Conformance",
        "The core against an independently written reference, and firmware under QEMU against the core. Integer stages are \
         compared bit for bit, float stages with the bound shown.",
        &tables::conformance(&run.verify),
    );
    section(
        &mut page,
        "configuration",
        "Configuration",
        &format!("Seed {}. Every default is written out.", run.seed),
        &format!("<details><summary>scenario.toml</summary><pre>{}</pre></details>", escape(scenario_toml)),
    );
    page.push_str("</main></body></html>\n");
    page
}

/// Every vector figure as a file of its own.
pub fn svgs(run: &Run, figures: &Figures) -> Vec<(String, String)> {
    let mut files = vec![
        ("region.svg".into(), plot::on_white(figures::region(run, figures))),
        ("learning-curve.svg".into(), plot::on_white(figures::learning_curve(run, figures))),
        ("training-loss.svg".into(), plot::on_white(figures::losses(figures))),
        ("grey-levels.svg".into(), plot::on_white(figures::pmf(&figures.calibration))),
        ("timeline.svg".into(), plot::on_white(timeline::timeline(&run.schedule.timeline))),
    ];
    if !figures.calibration.curve.is_empty() {
        files.push(("kl-curve.svg".into(), plot::on_white(figures::kl_curve(&figures.calibration))));
    }
    files
}
