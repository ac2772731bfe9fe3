//! The report page of a run, section by section.

use super::plot::{Plot, escape, grouped, number};
use super::{STYLE, confusion, explorer, figures as pictures, spectrograms, tables, timeline};
use crate::results::{Figures, Run};
use std::fmt::Write;

const PAPER: &str =
    "Li et al., \"Integrated Sensing and Communication from Learning Perspective: An SDP3 Approach\".";

/// A section: its address in the page and its title.
const SECTIONS: [(&str, &str, &str); 7] = [
    ("region", "Region", "Accuracy-throughput region"),
    ("spectrograms", "Spectrograms", "Spectrograms"),
    ("calibration", "Calibration", "Calibration"),
    ("learning", "Learning", "Learning"),
    ("schedule", "Schedule", "One period"),
    ("conformance", "Conformance", "Conformance"),
    ("configuration", "Configuration", "Configuration"),
];

fn section(page: &mut String, id: &str, caption: &str, body: &str) {
    let title = SECTIONS.iter().find(|s| s.0 == id).map_or("", |s| s.2);
    let _ = write!(page, "<section id=\"{id}\"><h2>{title}</h2><p>{caption}</p>{body}</section>");
}

/// A plot with a caption, named for the explorer.
fn figure(name: &str, plot: Plot, caption: &str) -> String {
    format!("<figure data-figure=\"{name}\">{}<figcaption>{caption}</figcaption></figure>", plot.html())
}

/// The report page of a run.
pub fn page(run: &Run, figures: &Figures, scenario_toml: &str) -> String {
    let name = escape(&run.scenario);
    let mut page = format!(
        "<!doctype html><html lang=\"en\"><head><meta charset=\"utf-8\">{}<meta name=\"viewport\" \
         content=\"width=device-width,initial-scale=1\"><meta name=\"color-scheme\" content=\"light dark\"><title>sdp3: \
         {name}</title><style>{}{STYLE}</style></head><body><a class=\"skip\" href=\"#region\">Skip to the figures</a>\
         <header><h1>{name}</h1><p>How many slots must be spent on radar to recognise how a person moves, and what does \
         that cost in throughput?</p><p class=\"answer\">{}</p><p>sdp3 {}, seed {}. Reproduces {PAPER}</p></header><main>",
        explorer::policy(),
        explorer::colours(),
        answer(run),
        escape(crate::VERSION),
        run.seed
    );
    headline(&mut page, run);
    page.push_str("<nav aria-label=\"Sections\">");
    for (id, text, _) in SECTIONS {
        let _ = write!(page, "<a href=\"#{id}\">{text}</a> ");
    }
    page.push_str("</nav>");
    region(&mut page, run, figures);
    gallery(&mut page, figures);
    calibration(&mut page, figures);
    learning(&mut page, run, figures);
    schedule(&mut page, run);
    section(
        &mut page,
        "conformance",
        "The core against an independently written reference, and firmware under QEMU against the core. Integer stages are \
         compared bit for bit, float stages with the bound shown.",
        &(tables::conformance(&run.verify) + &tables::instructions(&run.verify)),
    );
    section(
        &mut page,
        "configuration",
        &format!("Seed {}. Every default is written out.", run.seed),
        &format!("<details><summary>scenario.toml</summary><pre>{}</pre></details>", escape(scenario_toml)),
    );
    page.push_str("</main>");
    page.push_str(&explorer::embedded(run, figures));
    page.push_str("</body></html>\n");
    page
}

/// The result in one sentence.
fn answer(run: &Run) -> String {
    let p = &run.operating_point;
    let own = run.region.iter().find(|r| (r.case, r.sensing_slots) == (p.case, p.sensing_slots));
    let band = own.and_then(|r| Some((r.accuracy_low?, r.accuracy_high?)));
    let band = band.map_or_else(String::new, |(low, high)| {
        format!(" (95 % band {:.1} % to {:.1} %)", 100.0 * low, 100.0 * high)
    });
    let beyond = match own.is_some_and(|r| r.extrapolated) {
        true => " No accuracy was measured at so few or so many slots: the curve is extrapolated there.",
        false => "",
    };
    format!(
        "With {} of the {} slots of a {} s period spent on sensing, the learning curve predicts that {:.1} %{band} of the recordings \
         are recognised, and the other slots leave at least {:.2} Mbit/s to every user.{beyond} {}",
        p.sensing_slots,
        p.period_slots,
        number(p.period_s),
        100.0 * p.accuracy,
        p.throughput_bit / p.period_s / 1e6,
        escape(&p.channels)
    )
}

fn headline(page: &mut String, run: &Run) {
    let p = &run.operating_point;
    page.push_str("<ul class=\"headline\">");
    for (value, text) in [
        (
            number(run.rho),
            "ρ, correlation of the room's channel from one sensing slot to the next (1: it never changes)",
        ),
        (
            p.sensing_slots.to_string(),
            "sensing slots a period at the operating point, the ring in the first figure",
        ),
        (format!("{:.1} %", 100.0 * p.accuracy), "of the recordings recognised there, by the learning curve"),
        (
            format!("{:.2} Mbit/s", p.throughput_bit / p.period_s / 1e6),
            "to the user with the least throughput there",
        ),
        (
            grouped(run.verify.compared),
            "values and digests of the radar module compared with reference and firmware",
        ),
        (run.verify.mismatches.to_string(), "of them differ"),
    ] {
        let _ = write!(page, "<li><b>{value}</b> {text}</li>");
    }
    page.push_str("</ul>");
}

fn region(page: &mut String, run: &Run, figures: &Figures) {
    let points = &figures.prediction.points;
    let region = pictures::region(&run.region, &run.operating_point, &figures.cases, points);
    section(
        page,
        "region",
        &format!(
            "Largest worst throughput for every accuracy (paper, Theorem 1), both user placements. The ring is the \
             operating point: {}. Where nothing was measured boundaries are dotted, and zones are left out.",
            escape(&run.operating_point.rule)
        ),
        &figure("region", region, "Accuracy against throughput"),
    );
}

fn gallery(page: &mut String, figures: &Figures) {
    let shown: String = figures.spectrograms.iter().map(spectrograms::figure).collect();
    let stops = figures.early_exits.as_ref().map_or_else(String::new, |a| {
        let each = a.recordings.iter().map(|r| format!("{} after {}", escape(&r.truth), r.stops_after));
        let each: Vec<String> = each.collect();
        format!(
            " Early exits, as accurate as the operating point on {} other recordings, stop {}; sensing slots needed: {}.",
            a.calibrated_on,
            if a.threshold > 1.0 { "never early".into() } else { format!("at a confidence of {}", number(a.threshold)) },
            each.join(", ")
        )
    });
    section(
        page,
        "spectrograms",
        &format!(
            "One simulated recording of each class as the network sees it: the torso's line near the walking speed's Doppler, \
             limbs around it in the rhythm of the gait (paper, figure of the experimental spectrograms).{stops}"
        ),
        &format!("<div class=\"row\">{shown}</div>"),
    );
}

fn calibration(page: &mut String, figures: &Figures) {
    let c = &figures.calibration;
    let both: String = [&c.measured, &c.simulated].into_iter().flatten().map(spectrograms::figure).collect();
    let curve = match c.curve.is_empty() {
        true => String::new(),
        false => figure("kl-curve", pictures::kl_curve(c), "KL divergence over 1 − ρ"),
    };
    section(
        page,
        "calibration",
        &format!(
            "ρ = {}. {}. The curve shows {}: the paper's eq. (fitting) and its KL figure.",
            number(c.rho),
            escape(&c.source),
            escape(&c.curve_of)
        ),
        &format!(
            "<div class=\"row\">{curve}{}</div>{}<div class=\"row\">{both}</div>",
            figure("intensities", pictures::pmf(c), "Share of each intensity"),
            c.room.as_ref().map(tables::room_on_page).unwrap_or_default()
        ),
    );
}

fn learning(page: &mut String, run: &Run, figures: &Figures) {
    section(
        page,
        "learning",
        &format!(
            "Accuracy on recordings never seen, from raw I/Q through the radar module's own code, and the learning curves \
             fitted to it (paper, Tables II and III); the best is {} with rmse {}. Bars: one standard deviation (1 σ) of the count. Band: 95 % of the curves that other test recordings would give.",
            escape(&run.curve.model),
            number(run.curve.rmse)
        ),
        &format!(
            "<div class=\"row\">{}{}</div>{}{}",
            figure(
                "learning-curve",
                pictures::learning_curve(&figures.prediction, &run.accuracy),
                "Accuracy over N_s"
            ),
            figure("training-loss", pictures::losses(figures), "Training loss"),
            tables::models(figures),
            confusion::tables(figures)
        ),
    );
}

fn schedule(page: &mut String, run: &Run) {
    let s = &run.schedule;
    let recognised = s.recognised.as_ref().map_or_else(String::new, |r| {
        format!(
            " In this period the core recognised one recording of {} as {} with a confidence of {:.0} %: one recording, no accuracy.",
            escape(&r.truth),
            escape(&r.class),
            100.0 * r.confidence
        )
    });
    section(
        page,
        "schedule",
        &format!(
            "The core's scheduler plays the operating point: {} sensing slots, {:?} slots to the users, longest waits \
             {:?} slots.{recognised}",
            s.sensing_slots, s.communication_slots, s.longest_wait_slots
        ),
        &format!("<figure data-figure=\"timeline\">{}</figure>", timeline::html(&s.timeline)),
    );
}
