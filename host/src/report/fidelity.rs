//! The pictures of the fidelity study: intensity distributions, and accuracies as squares.

use super::plot::{Axis, COLOURS, Medium, Plot, STYLES, escape};
use crate::experiments::fidelity::{DOMAINS, Fidelity, IntensityDivergence};
use crate::experiments::sim_to_real::SimToReal;
use crate::simulator::randomised::Motion;
use std::fmt::Write;

/// Most measured recordings with drawn intensities.
const MOST: usize = 8;
/// Height of a panel of squares.
const SQUARES: f64 = 220.0;

/// Shares of the intensities of three domains.
fn intensities(title: &str, found: &IntensityDivergence, truth: &str) -> String {
    let most = found.pmf.iter().flatten().copied().fold(0.0, f64::max);
    let x = Axis::new(0.0, 63.0, &format!("intensity (level 0 to 63): {title}"));
    let y = Axis::new(0.0, 105.0 * most.min(0.2), "share of pixels (%)");
    let top = 1.05 * most.min(0.2);
    let mut plot = Plot::new(title, x, y);
    let names = [
        format!("DAHC, KL {:.3} nat", found.dahc),
        format!("ray tracing, KL {:.3} nat", found.ray_tracing),
        truth.into(),
    ];
    for ((pmf, name), style) in found.pmf.iter().zip(&names).zip(STYLES) {
        let points: Vec<_> = pmf.iter().enumerate().map(|(k, p)| (k as f64, 100.0 * p.min(top))).collect();
        let series = plot.series(name, style);
        plot.line(series, &points, 1.4);
    }
    plot.svg(Medium::DOUBLE)
}

/// Shares 0 to 1 as squares with their numbers, `[row][column]`.
fn squares(
    title: &str,
    axes: [&str; 2],
    names: &[&str; 3],
    shares: &[[f64; 3]; 3],
    says: &[[String; 3]; 3],
) -> String {
    let mut svg = format!(
        "<svg {1}><title>{0}</title><text x=\"20\" y=\"16\">{0}</text>\
         <text class=\"axis-x\" x=\"377\" y=\"32\" text-anchor=\"middle\">{2}</text>\
         <text class=\"axis-y\" transform=\"translate(20 130) rotate(-90)\" text-anchor=\"middle\">{3}</text>",
        escape(title),
        Medium::DOUBLE.root(SQUARES),
        axes[0],
        axes[1]
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

/// Every panel by name.
pub fn pictures(found: &Fidelity) -> Vec<(String, String)> {
    let mut panels = vec![(
        "fidelity-intensities".to_owned(),
        intensities("the surrogate", &found.intensities, "surrogate, simulated"),
    )];
    let means = found.int8.map(|row| row.map(|s| s.mean));
    let says = std::array::from_fn(|r| std::array::from_fn(|c| found.int8[r][c].to_string()));
    let axes = ["tested on", "trained on"];
    panels.push(("fidelity".to_owned(), squares("Accuracy (int8, share)", axes, &DOMAINS, &means, &says)));
    for (k, m) in found.measured.iter().take(MOST).enumerate() {
        let title = format!("{} ({}), rho = {}", m.name, m.motion.name(), m.intensities.rho);
        panels
            .push((format!("fidelity-measured-{}", k + 1), intensities(&title, &m.intensities, "measured")));
    }
    panels
}

/// Which motion the networks recognised in seconds of which.
pub fn confusion(found: &SimToReal) -> String {
    let shares = found.confusion.map(|row| {
        let all = row.iter().sum::<u32>().max(1);
        row.map(|n| f64::from(n) / f64::from(all))
    });
    let says = found.confusion.map(|row| row.map(|n| n.to_string()));
    let names = Motion::ALL.map(Motion::name);
    let axes = ["recognised motion", "true motion"];
    squares("Measured seconds, learned from simulated ones", axes, &names, &shares, &says)
}
