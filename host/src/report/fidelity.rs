//! The picture of the fidelity study: intensity distributions, and accuracies as squares.

use super::plot::{Axis, COLOURS, Plot, escape};
use crate::experiments::fidelity::{DOMAINS, Fidelity, Levels};
use crate::simulator::randomised::Motion;
use std::fmt::Write;

/// Most measured recordings with drawn intensities.
const MOST: usize = 8;
const PANEL: f64 = 430.0;

/// Shares of the intensities of three domains.
fn levels(title: &str, found: &Levels, truth: &str) -> String {
    let most = found.pmf.iter().flatten().copied().fold(0.0, f64::max);
    let x = Axis { low: 0.0, high: 63.0, name: format!("intensity: {title}"), log: false };
    let y = Axis { low: 0.0, high: 1.05 * most.min(0.2), name: "share".into(), log: false };
    let top = y.high;
    let mut plot = Plot::new(title, x, y);
    let names = [
        format!("DAHC, KL {:.3}", found.dahc),
        format!("ray tracing, KL {:.3}", found.ray_tracing),
        truth.into(),
    ];
    for ((pmf, name), colour) in found.pmf.iter().zip(&names).zip([COLOURS[0], COLOURS[1], COLOURS[6]]) {
        let points: Vec<_> = pmf.iter().enumerate().map(|(k, p)| (k as f64, p.min(top))).collect();
        plot.line(&points, colour, 2.0, name);
    }
    plot.svg()
}

/// Shares 0 to 1 as squares with their numbers, `[row][column]`.
fn squares(title: &str, names: &[&str; 3], shares: &[[f64; 3]; 3], says: &[[String; 3]; 3]) -> String {
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 640 220\" role=\"img\" font-size=\"13\" \
         font-family=\"system-ui,sans-serif\" fill=\"var(--ink,#222)\"><title>{0}</title><text x=\"20\" y=\"20\">{0}</text>",
        escape(title)
    );
    for (r, row) in shares.iter().enumerate() {
        let y = 55.0 + 52.0 * r as f64;
        let _ = write!(svg, "<text x=\"130\" y=\"{}\" text-anchor=\"end\">{}</text>", y + 28.0, names[r]);
        for (c, share) in row.iter().enumerate() {
            let x = 140.0 + 160.0 * c as f64;
            if r == 0 {
                let _ = write!(
                    svg,
                    "<text x=\"{}\" y=\"46\" text-anchor=\"middle\">{}</text>",
                    x + 77.0,
                    names[c]
                );
            }
            let _ = write!(
                svg,
                "<rect x=\"{x}\" y=\"{y}\" width=\"155\" height=\"48\" fill=\"{}\" fill-opacity=\"{:.2}\" stroke=\"#888\"/>\
                 <text x=\"{}\" y=\"{}\" text-anchor=\"middle\">{}</text>",
                COLOURS[0],
                0.75 * share.clamp(0.0, 1.0),
                x + 77.0,
                y + 29.0,
                escape(&says[r][c])
            );
        }
    }
    svg + "</svg>"
}

/// The whole picture, panel below panel.
pub fn picture(found: &Fidelity) -> String {
    let mut panels = vec![(levels("the stand-in", &found.levels, "stand-in"), PANEL)];
    let means = found.int8.map(|row| row.map(|s| s.mean));
    let says = std::array::from_fn(|r| std::array::from_fn(|c| found.int8[r][c].to_string()));
    panels.push((
        squares("Accuracy (int8): trained on (row), tested on (column)", &DOMAINS, &means, &says),
        220.0,
    ));
    for m in found.measured.iter().take(MOST) {
        let title = format!("{} ({}), rho = {}", m.name, m.motion.name(), m.levels.rho);
        panels.push((levels(&title, &m.levels, "measured"), PANEL));
    }
    if let Some(s) = &found.sim_to_real {
        let shares = s.confusion.map(|row| {
            let all = row.iter().sum::<u32>().max(1);
            row.map(|n| f64::from(n) / f64::from(all))
        });
        let says = s.confusion.map(|row| row.map(|n| n.to_string()));
        let names = Motion::ALL.map(Motion::name);
        let title = format!("Measured windows, learned from simulated ones: {} right", s.float);
        panels.push((squares(&title, &names, &shares, &says), 220.0));
    }
    let height: f64 = panels.iter().map(|p| p.1).sum();
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 640 {height}\"><rect width=\"640\" height=\"{height}\" \
         fill=\"var(--paper,#fff)\"/>"
    );
    let mut y = 0.0;
    for (panel, tall) in panels {
        let placed = format!("<svg y=\"{y}\" width=\"640\" height=\"{tall}\" ");
        svg += &panel.replacen("<svg ", &placed, 1);
        y += tall;
    }
    svg + "</svg>"
}
