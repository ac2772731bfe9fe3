//! The slots of a period: how they are shared along it, and its first ones one by one.

use super::plot::{COLOURS, legend};
use std::fmt::Write;

/// Slots shown one by one.
const FIRST: u32 = 80;

/// Columns of the whole period.
const COLUMNS: u32 = 100;

/// Width and height of a strip.
const STRIP: (f64, f64) = (600.0, 34.0);

/// Entries of the legend that stand side by side.
const ABREAST: usize = 5;

/// Colour of a use: -2 idle, -1 sensing, else the user's index.
fn colour(code: i32) -> &'static str {
    match usize::try_from(code) {
        Ok(k) => COLOURS.get(k).copied().unwrap_or("#f0e442"),
        Err(_) if code == -1 => "var(--ink,#222)",
        Err(_) => "#e6e6e6",
    }
}

/// A period, run-length coded as in [`crate::results::Schedule::timeline`], its legend below it.
pub fn svg(runs: &[(i32, u32)]) -> String {
    let entries = entries(runs);
    let mut names = String::new();
    for (index, (name, colour)) in entries.iter().enumerate() {
        let (x, y) = (20 + index % ABREAST * 122, 182 + index / ABREAST * 18);
        let _ = write!(
            names,
            "<rect x=\"{x}\" y=\"{y}\" width=\"12\" height=\"12\" fill=\"{colour}\"/><text x=\"{}\" y=\"{}\">{name}</text>",
            x + 18,
            y + 11
        );
    }
    drawn(runs, 182 + 18 * entries.len().div_ceil(ABREAST), &names)
}

/// The same for a page: its legend is text that wraps, its strips are marked for scripts.
pub fn html(runs: &[(i32, u32)]) -> String {
    drawn(runs, 170, "") + &legend(&entries(runs))
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

fn drawn(runs: &[(i32, u32)], height: usize, legend: &str) -> String {
    let slots: Vec<i32> = runs.iter().flat_map(|&(code, n)| std::iter::repeat_n(code, n as usize)).collect();
    let codes = codes(runs);
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 640 {height}\" role=\"img\" font-size=\"12\" \
         font-family=\"system-ui,sans-serif\" fill=\"var(--ink,#222)\"><title>Slots of one period</title>"
    );
    let first = &slots[..slots.len().min(FIRST as usize)];
    let text = format!("the period: who has how many of {} slots", slots.len());
    for (name, y, slots, columns, text) in [
        ("whole", 26.0, &slots[..], COLUMNS, text.as_str()),
        ("first", 112.0, first, FIRST, "its first slots, one by one"),
    ] {
        let _ = write!(svg, "<g data-strip=\"{name}\" data-box=\"20 {y} {} {}\"><g>", STRIP.0, STRIP.1);
        strip(&mut svg, y, slots, columns, &codes);
        svg.push_str("</g>");
        axis(&mut svg, y, slots.len(), text);
        svg.push_str("</g>");
    }
    svg + legend + "</svg>"
}

/// Slots in at most so many columns, each divided among the uses in it.
fn strip(svg: &mut String, y: f64, slots: &[i32], columns: u32, codes: &[i32]) {
    let columns = (columns as usize).min(slots.len());
    let width = STRIP.0 / columns.max(1) as f64;
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
                    20.0 + column as f64 * width,
                    share * STRIP.1,
                    colour(code)
                );
            }
            top += share * STRIP.1;
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
    fn both_strips_are_full() {
        let drawn = svg(&[(-1, 1), (0, 3), (-2, 440), (7, 56)]);
        let area: f64 = drawn
            .split("<rect x=")
            .filter_map(|rect| {
                let number = |name: &str| rect.split(name).nth(1)?.split('"').next()?.parse::<f64>().ok();
                Some(number("width=\"")? * number("height=\"")?)
            })
            .filter(|area| *area != 144.0)
            .sum();
        assert!((area / (2.0 * STRIP.0 * STRIP.1) - 1.0).abs() < 1e-3, "{area}");
        for name in ["idle", "sensing", "user 1", "user 8", "500 slots"] {
            assert!(drawn.contains(name), "{name}");
        }
        assert!(svg(&[]).ends_with("</svg>"));
    }
}
