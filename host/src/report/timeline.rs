//! The slots of a period: how they are shared along it, and its first ones one by one.

use super::plot::{COLOURS, Medium, legend, number, swatch};
use std::fmt::Write;

/// Slots shown one by one.
const FIRST: u32 = 80;

/// Columns of the whole period.
const COLUMNS: u32 = 100;

/// Width and height of a strip.
const STRIP: (f64, f64) = (600.0, 34.0);

/// Colour of a use: -2 idle, -1 sensing, else the user's index.
fn colour(code: i32) -> &'static str {
    match usize::try_from(code) {
        Ok(k) => COLOURS.get(k).copied().unwrap_or("#f0e442"),
        Err(_) if code == -1 => "var(--ink,#222)",
        Err(_) => "#e6e6e6",
    }
}

/// A period of a length in s, run-length coded as in [`crate::results::Schedule::timeline`]: its first slots, a row for each use,
/// and the shares of the uses along the whole period.
pub fn svg(runs: &[(i32, u32)], period_s: f64) -> String {
    let (medium, entries, codes) = (Medium::SINGLE, entries(runs), codes(runs));
    let all: usize = runs.iter().map(|&(_, n)| n as usize).sum();
    let slots: Vec<i32> = runs.iter().flat_map(|&(code, n)| std::iter::repeat_n(code, n as usize)).collect();
    let (left, width, row) = (62.0, medium.width - 62.0 - 14.0, 15.0);
    let rows = row * entries.len() as f64;
    let (first, second) = (10.0, rows + 58.0);
    let height = second + 64.0 + 60.0 + 16.0 * entries.len().div_ceil(3) as f64;
    let mut svg = format!("<svg {}><title>Slots of one period</title>", medium.root(height));
    let shown = slots.len().min(FIRST as usize);
    for (k, (name, colour)) in entries.iter().enumerate() {
        let y = first + row * k as f64;
        let _ =
            write!(svg, "<text x=\"{}\" y=\"{:.1}\" text-anchor=\"end\">{name}</text>", left - 6.0, y + 11.0);
        for slot in (0..shown).filter(|&slot| slots[slot] == codes[k]) {
            let each = width / shown as f64;
            let x = left + each * slot as f64;
            let _ = write!(
                svg,
                "<rect x=\"{x:.2}\" y=\"{:.1}\" width=\"{each:.2}\" height=\"{}\" fill=\"{colour}\"/>",
                y + 1.0,
                row - 2.0
            );
        }
    }
    let ticks = |svg: &mut String, y: f64, most: f64, name: &str| {
        for k in 0..=4 {
            let (share, x) = (f64::from(k) / 4.0, left + width * f64::from(k) / 4.0);
            let text = number((1000.0 * share * most).round() / 1000.0);
            let anchor = if k == 4 { "end" } else { "middle" };
            let _ = write!(
                svg,
                "<path d=\"M{x:.1} {y:.1}v4\" stroke=\"var(--ink,#222)\"/><text x=\"{x:.1}\" y=\"{:.1}\" text-anchor=\"{anchor}\">{text}</text>",
                y + 15.0
            );
        }
        let _ = write!(
            svg,
            "<path d=\"M{left} {y:.1}h{width}\" stroke=\"var(--ink,#222)\"/><text class=\"axis-x\" x=\"{:.1}\" y=\"{:.1}\" \
             text-anchor=\"middle\">{name}</text>",
            left + width / 2.0,
            y + 29.0
        );
    };
    ticks(&mut svg, first + rows, shown as f64, "slot number (first slots of the period)");
    strip(&mut svg, (left, second, width, 64.0), &slots, COLUMNS, &codes);
    for (share, y) in [("100", second + 10.0), ("0", second + 64.0)] {
        let _ = write!(svg, "<text x=\"{}\" y=\"{y:.1}\" text-anchor=\"end\">{share}</text>", left - 6.0);
    }
    ticks(&mut svg, second + 64.0, period_s, &format!("time in the period of {all} slots (s)"));
    let _ = write!(
        svg,
        "<text class=\"axis-y\" transform=\"translate(12 {:.1}) rotate(-90)\" text-anchor=\"middle\">slots (%)</text><g class=\"legend\">",
        second + 32.0
    );
    for (k, (name, colour)) in entries.iter().enumerate() {
        let (x, y) = (14.0 + 112.0 * (k % 3) as f64, second + 104.0 + 16.0 * (k / 3) as f64);
        let _ = write!(
            svg,
            "<g class=\"entry\" data-series=\"{k}\"><rect x=\"{x:.1}\" y=\"{y:.1}\" width=\"20\" height=\"10\" fill=\"{colour}\"/>\
             <text x=\"{:.1}\" y=\"{:.1}\">{name}</text></g>",
            x + 26.0,
            y + 9.0
        );
    }
    svg + "</g></svg>"
}

/// The same for a page: its legend is text that wraps, its strips are marked for scripts.
pub fn html(runs: &[(i32, u32)]) -> String {
    let entries: Vec<_> = entries(runs).into_iter().map(|(name, colour)| (name, swatch(&colour))).collect();
    drawn(runs, 186) + &legend(&entries)
}

/// The uses in a period, each once.
fn codes(runs: &[(i32, u32)]) -> Vec<i32> {
    let mut codes: Vec<i32> = runs.iter().map(|&(code, _)| code).collect();
    codes.sort_unstable();
    codes.dedup();
    codes
}

/// Their names and colours.
fn entries(runs: &[(i32, u32)]) -> Vec<(String, String)> {
    let name = |code| match code {
        -2 => "idle".to_owned(),
        -1 => "sensing".to_owned(),
        k => format!("user {}", k + 1),
    };
    codes(runs).into_iter().map(|code| (name(code), colour(code).to_owned())).collect()
}

fn drawn(runs: &[(i32, u32)], height: usize) -> String {
    let slots: Vec<i32> = runs.iter().flat_map(|&(code, n)| std::iter::repeat_n(code, n as usize)).collect();
    let codes = codes(runs);
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 640 {height}\" role=\"img\" font-size=\"12\" \
         font-family=\"system-ui,sans-serif\" fill=\"var(--ink,#222)\"><title>Slots of one period</title>"
    );
    let first = &slots[..slots.len().min(FIRST as usize)];
    let text = format!("share of each use over the slot number, 0 to {}", slots.len());
    for (name, y, slots, columns, text) in [
        ("whole", 26.0, &slots[..], COLUMNS, text.as_str()),
        ("first", 112.0, first, FIRST, "its first slots, one by one (slot number)"),
    ] {
        let _ = write!(svg, "<g data-strip=\"{name}\" data-box=\"20 {y} {} {}\"><g>", STRIP.0, STRIP.1);
        strip(&mut svg, (20.0, y, STRIP.0, STRIP.1), slots, columns, &codes);
        svg.push_str("</g>");
        axis(&mut svg, y, slots.len(), text);
        svg.push_str("</g>");
    }
    svg + "</svg>"
}

/// A box of slots in at most so many columns, each divided among the uses in it.
fn strip(
    svg: &mut String,
    (left, y, wide, tall): (f64, f64, f64, f64),
    slots: &[i32],
    columns: u32,
    codes: &[i32],
) {
    let columns = (columns as usize).min(slots.len());
    let width = wide / columns.max(1) as f64;
    for column in 0..columns {
        let edge = |column: usize| column * slots.len() / columns;
        let own = &slots[edge(column)..edge(column + 1)];
        let mut top = y;
        for &code in codes {
            let share = own.iter().filter(|&&slot| slot == code).count() as f64 / own.len().max(1) as f64;
            if share > 0.0 {
                let _ = write!(
                    svg,
                    "<rect x=\"{:.2}\" y=\"{top:.2}\" width=\"{width:.2}\" height=\"{:.2}\" fill=\"{}\"/>",
                    left + column as f64 * width,
                    share * tall,
                    colour(code)
                );
            }
            top += share * tall;
        }
    }
}

/// A strip's title and the numbers of its slots.
fn axis(svg: &mut String, y: f64, slots: usize, text: &str) {
    let _ = write!(svg, "<text x=\"20\" y=\"{}\">{text}</text>", y - 6.0);
    for tick in 0..=4 {
        let slot = slots * tick / 4;
        let x = 20.0 + slot as f64 / slots.max(1) as f64 * STRIP.0;
        let anchor = if tick == 4 { "end" } else { "middle" };
        let _ = write!(
            svg,
            "<path d=\"M{x:.2} {}v5\" stroke=\"var(--ink,#222)\"/><text x=\"{x:.2}\" y=\"{}\" text-anchor=\"{anchor}\" \
             font-size=\"11\">{slot}</text>",
            y + STRIP.1,
            y + STRIP.1 + 16.0
        );
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn strips_are_full_and_rows_complete() {
        let drawn = svg(&[(-1, 1), (0, 3), (-2, 440), (7, 56)], 0.5);
        let area: f64 = drawn
            .split("<rect x=")
            .filter_map(|rect| {
                let number = |name: &str| rect.split(name).nth(1)?.split('"').next()?.parse::<f64>().ok();
                Some(number("width=\"")? * number("height=\"")?)
            })
            .filter(|area| *area != 200.0)
            .sum();
        // one row of thirteen units for each slot shown, and the whole period
        let wide = Medium::SINGLE.width - 76.0;
        assert!((area / (wide * (13.0 + 64.0)) - 1.0).abs() < 2e-3, "{area}");
        for name in ["idle", "sensing", "user 1", "user 8", "500 slots"] {
            assert!(drawn.contains(name), "{name}");
        }
        assert!(svg(&[], 1.0).ends_with("</svg>"));
    }
}
