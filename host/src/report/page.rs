//! The report page of a run, section by section.

use super::plot::{Plot, grouped, number};
use super::{Live, STYLE, confusion, explorer, figures as pictures, spectrograms, tables, timeline};
use crate::results::{Figures, Run};
use maud::{DOCTYPE, Markup, PreEscaped, html};

const PAPER: &str =
    "Li et al., \"Integrated Sensing and Communication from Learning Perspective: An SDP3 Approach\".";

/// A section: its address in the page, its entry in the navigation, its title.
const SECTIONS: [(&str, &str, &str); 8] = [
    ("recording", "Your recording", "Your recording"),
    ("region", "Region", "Accuracy-throughput region"),
    ("spectrograms", "Spectrograms", "Spectrograms"),
    ("calibration", "Calibration", "Calibration"),
    ("learning", "Learning", "Learning"),
    ("schedule", "Schedule", "One period"),
    ("conformance", "Conformance", "Conformance"),
    ("configuration", "Configuration", "Configuration"),
];

fn section(id: &str, caption: &str, body: Markup) -> Markup {
    let title = SECTIONS.iter().find(|s| s.0 == id).map_or("", |s| s.2);
    html! { section id=(id) { h2 { (title) } p { (caption) } (body) } }
}

/// A plot with a caption, named for the explorer.
fn figure(name: &str, plot: &Plot, caption: &str) -> Markup {
    html! { figure data-figure=(name) { (PreEscaped(plot.html())) figcaption { (caption) } } }
}

/// The report page of a run; with a program it also computes.
pub fn page(run: &Run, figures: &Figures, scenario_toml: &str, live: Option<&Live>) -> String {
    let page = html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                (explorer::policy(live.is_some()))
                meta name="viewport" content="width=device-width,initial-scale=1";
                meta name="color-scheme" content="light dark";
                title { "sdp3: " (run.scenario) }
                style { (PreEscaped(explorer::colours())) (PreEscaped(STYLE)) }
            }
            body {
                a.skip href="#region" { "Skip to the figures" }
                header {
                    h1 { (run.scenario) }
                    p {
                        "How many slots must be spent on radar to recognise how a person moves, and what does that cost in \
                         throughput?"
                    }
                    p.answer { (answer(run)) }
                    p { "sdp3 " (crate::VERSION) ", seed " (run.seed) ". Reproduces " (PAPER) }
                }
                main {
                    (headline(run))
                    nav aria-label="Sections" {
                        @for (id, text, _) in &SECTIONS[usize::from(live.is_none())..] { a href={ "#" (id) } { (text) } " " }
                    }
                    @if live.is_some() { (recording()) }
                    (region(run, figures))
                    (gallery(figures))
                    (calibration(figures))
                    (learning(run, figures))
                    (schedule(run))
                    (section(
                        "conformance",
                        "The core against an independently written reference, and firmware under QEMU against the core. Integer \
                         stages are compared bit for bit, float stages with the bound shown.",
                        html! { (tables::conformance(&run.verify)) (tables::instructions(&run.verify)) },
                    ))
                    (section(
                        "configuration",
                        &format!("Seed {}. Every default is written out.", run.seed),
                        html! { details { summary { "scenario.toml" } pre { (scenario_toml) } } },
                    ))
                }
                (explorer::embedded(run, figures, live))
            }
        }
    };
    page.into_string() + "\n"
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
        p.channels
    )
}

fn headline(run: &Run) -> Markup {
    let p = &run.operating_point;
    let figures = [
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
    ];
    html! { ul.headline { @for (value, text) in figures { li { b { (value) } " " (text) } } } }
}

fn recording() -> Markup {
    section(
        "recording",
        "What the models of this run make of a recording of raw slots of the same radar: WAV, CSV, NPY, NPZ, MATLAB, SigMF (both of its \
         files), or a module's capture. The program of sdp3 runs in this page, and nothing leaves it.",
        html! { noscript { p { "This needs JavaScript." } } },
    )
}

fn region(run: &Run, figures: &Figures) -> Markup {
    let points = &figures.prediction.points;
    let region = pictures::region(&run.region, &run.operating_point, &figures.cases, points);
    section(
        "region",
        &format!(
            "Largest worst throughput for every accuracy (paper, Theorem 1), both user placements. The ring is the \
             operating point: {}. Where nothing was measured boundaries are dotted, and zones are left out.",
            run.operating_point.rule
        ),
        figure("region", &region, "Accuracy against throughput"),
    )
}

fn gallery(figures: &Figures) -> Markup {
    let stops = figures.early_exits.as_ref().map_or_else(String::new, |a| {
        let each: Vec<String> =
            a.recordings.iter().map(|r| format!("{} after {}", r.truth, r.stops_after)).collect();
        format!(
            " Early exits, as accurate as the operating point on {} other recordings, stop {}; sensing slots needed: {}.",
            a.calibrated_on,
            if a.threshold > 1.0 { "never early".into() } else { format!("at a confidence of {}", number(a.threshold)) },
            each.join(", ")
        )
    });
    section(
        "spectrograms",
        &format!(
            "One simulated recording of each class as the network sees it: the torso's line near the walking speed's Doppler, \
             limbs around it in the rhythm of the gait (paper, figure of the experimental spectrograms).{stops}"
        ),
        html! { div.row { @for shown in &figures.spectrograms { (spectrograms::figure(shown)) } } },
    )
}

fn calibration(figures: &Figures) -> Markup {
    let c = &figures.calibration;
    section(
        "calibration",
        &format!(
            "ρ = {}. {}. The curve shows {}: the paper's eq. (fitting) and its KL figure.",
            number(c.rho),
            c.source,
            c.curve_of
        ),
        html! {
            div.row {
                @if !c.curve.is_empty() {
                    (figure("kl-curve", &pictures::kl_curve(c), "KL divergence over 1 − ρ"))
                }
                (figure("intensities", &pictures::pmf(c), "Share of each intensity"))
            }
            @if let Some(room) = &c.room { (tables::room_on_page(room)) }
            div.row { @for shown in [&c.measured, &c.simulated].into_iter().flatten() { (spectrograms::figure(shown)) } }
        },
    )
}

fn learning(run: &Run, figures: &Figures) -> Markup {
    let curve = pictures::learning_curve(&figures.prediction, &run.accuracy);
    section(
        "learning",
        &format!(
            "Accuracy on recordings never seen, from raw I/Q through the radar module's own code, and the learning curves \
             fitted to it (paper, Tables II and III); the best is {} with rmse {}. Bars: one standard deviation (1 σ) of the \
             count. Band: 95 % of the curves that other test recordings would give.",
            run.curve.model,
            number(run.curve.rmse)
        ),
        html! {
            div.row {
                (figure("learning-curve", &curve, "Accuracy over N_s"))
                (figure("training-loss", &pictures::losses(figures), "Training loss"))
            }
            (tables::models(figures))
            (confusion::tables(figures))
        },
    )
}

fn schedule(run: &Run) -> Markup {
    let s = &run.schedule;
    let recognised = s.recognised.as_ref().map_or_else(String::new, |r| {
        format!(
            " In this period the core recognised one recording of {} as {} with a confidence of {:.0} %: one recording, no accuracy.",
            r.truth,
            r.class,
            100.0 * r.confidence
        )
    });
    section(
        "schedule",
        &format!(
            "The core's scheduler plays the operating point: {} sensing slots, {:?} slots to the users, longest waits \
             {:?} slots.{recognised}",
            s.sensing_slots, s.communication_slots, s.longest_wait_slots
        ),
        html! { figure data-figure="timeline" { (PreEscaped(timeline::html(&s.timeline))) } },
    )
}
