//! The slots of a period as a strip, and its first ones enlarged.

use super::plot::COLOURS;
use std::fmt::Write;

/// Slots of the enlarged strip.
const FIRST: u32 = 80;

/// Entries of the legend that stand side by side.
const ABREAST: usize = 5;

/// Colour of a use: -2 idle, -1 sensing, else the receiver's index.
fn colour(code: i32) -> &'static str {
    match usize::try_from(code) {
        Ok(k) => COLOURS.get(k).copied().unwrap_or("#f0e442"),
        Err(_) if code == -1 => "var(--ink,#222)",
        Err(_) => "#e6e6e6",
    }
}

/// A period of `period_slots` slots, run-length coded as in [`crate::results::Schedule::timeline`].
pub fn timeline(period_slots: u32, runs: &[(i32, u32)]) -> String {
    let mut codes: Vec<i32> = runs.iter().map(|&(code, _)| code).collect();
    codes.sort_unstable();
    codes.dedup();
    let height = 188 + 18 * codes.len().div_ceil(ABREAST);
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 640 {height}\" role=\"img\" font-size=\"12\" \
         font-family=\"system-ui,sans-serif\" fill=\"var(--ink,#222)\"><title>Slots of one period</title>"
    );
    strip(&mut svg, 20.0, period_slots, "whole period", runs);
    strip(&mut svg, 106.0, FIRST.min(period_slots), "first slots", runs);
    for (index, code) in codes.into_iter().enumerate() {
        let name = match code {
            -2 => "nobody".to_owned(),
            -1 => "sensing".to_owned(),
            k => format!("receiver {}", k + 1),
        };
        let (x, y) = (20 + index % ABREAST * 122, 180 + index / ABREAST * 18);
        let _ = write!(
            svg,
            "<rect x=\"{x}\" y=\"{y}\" width=\"12\" height=\"12\" fill=\"{}\"/><text x=\"{}\" y=\"{}\">{name}</text>",
            colour(code),
            x + 18,
            y + 11
        );
    }
    svg + "</svg>"
}

/// The slots up to `first`, with an axis below.
fn strip(svg: &mut String, y: f64, first: u32, text: &str, runs: &[(i32, u32)]) {
    let width = 600.0 / f64::from(first.max(1));
    let _ = write!(svg, "<text x=\"20\" y=\"{}\">{text}: slots 1 to {first}</text>", y - 6.0);
    let mut at = 0;
    for &(code, slots) in runs {
        if at >= first {
            break;
        }
        let shown = slots.min(first - at);
        let _ = write!(
            svg,
            "<rect x=\"{:.2}\" y=\"{y}\" width=\"{:.2}\" height=\"34\" fill=\"{}\"/>",
            20.0 + f64::from(at) * width,
            f64::from(shown) * width,
            colour(code)
        );
        at += shown;
    }
    for tick in 0..=4 {
        let slot = u64::from(first) * tick / 4;
        let x = 20.0 + slot as f64 * width;
        let _ = write!(
            svg,
            "<path d=\"M{x:.2} {}v5\" stroke=\"var(--ink,#222)\"/><text x=\"{x:.2}\" y=\"{}\" text-anchor=\"middle\" \
             font-size=\"11\">{slot}</text>",
            y + 34.0,
            y + 50.0
        );
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_slot_is_drawn_once_in_each_strip() {
        let svg = timeline(100, &[(-1, 1), (0, 3), (-2, 40), (7, 56)]);
        let widths: f64 = svg
            .split("height=\"34\"")
            .filter_map(|part| part.rsplit("width=\"").next()?.strip_suffix("\" ")?.parse::<f64>().ok())
            .sum();
        assert!((widths - 1200.0).abs() < 0.1, "{widths}");
        for name in ["nobody", "sensing", "receiver 1", "receiver 8"] {
            assert!(svg.contains(name), "{name}");
        }
    }
}
