//! Confusion matrices, float beside int8: a table for the page, a picture for a paper.

use super::plot::{COLOURS, Medium, escape};
use crate::results::{Confusion, Figures};
use maud::{Markup, html};
use std::fmt::Write;

/// The arithmetics in the order they stand.
const ARITHMETICS: [&str; 2] = ["float", "int8"];

/// Edge of a cell, and distance of two matrices.
const CELL: f64 = 34.0;
const GAP: f64 = 24.0;

/// Every N_s that has a matrix, ascending.
pub fn slots(figures: &Figures) -> Vec<u32> {
    let mut all: Vec<u32> = figures.confusion.iter().map(|c| c.sensing_slots).collect();
    all.sort_unstable();
    all.dedup();
    all
}

/// The matrices of one N_s.
fn of(figures: &Figures, sensing_slots: u32) -> impl Iterator<Item = &Confusion> {
    let named = move |arithmetic: &str| {
        let own = |c: &&Confusion| c.sensing_slots == sensing_slots && c.arithmetic == arithmetic;
        figures.confusion.iter().find(own)
    };
    ARITHMETICS.into_iter().filter_map(named)
}

/// Tables of the largest N_s.
pub fn tables(figures: &Figures) -> Markup {
    let largest = slots(figures).pop().unwrap_or(0);
    html! { div.row #confusion { @for c in of(figures, largest) { (table(c, &figures.classes)) } } }
}

fn share(row: &[u32], n: u32) -> f64 {
    f64::from(n) / f64::from(row.iter().sum::<u32>().max(1))
}

fn table(c: &Confusion, classes: &[String]) -> Markup {
    let fill = |row: &[u32], n: u32| format!("--share:{:.2}", share(row, n));
    html! {
        figure {
            table.confusion {
                caption { (c.arithmetic) ", N_s = " (c.sensing_slots) ": truth down, answer across" }
                tr {
                    th scope="col" { "truth \\ answer" }
                    @for name in classes { th scope="col" { (name) } }
                }
                @for (truth, row) in c.counts.iter().enumerate() {
                    tr {
                        th scope="row" { (classes.get(truth).map_or("", String::as_str)) }
                        @for (answer, &n) in row.iter().enumerate() {
                            td class=(if truth == answer { "right" } else { "wrong" }) style=(fill(row, n)) { (n) }
                        }
                    }
                }
            }
        }
    }
}

/// The picture of one N_s: rows are the truth, columns the answer.
pub fn svg(figures: &Figures, sensing_slots: u32) -> String {
    let side = CELL * figures.classes.len() as f64;
    let longest = figures.classes.iter().map(String::as_str).max_by_key(|name| name.chars().count());
    let names = Medium::DOUBLE.width_of(longest.unwrap_or_default());
    let needed = names + 34.0 + 2.0 * side + GAP + 10.0;
    let medium = if needed > Medium::SINGLE.width { Medium::DOUBLE } else { Medium::SINGLE };
    let (edge, top) = ((medium.width - needed) / 2.0, 26.0);
    let left = edge + names + 34.0;
    // names of columns stand upright
    let height = top + side + names + 30.0;
    let name = |k: usize| figures.classes.get(k).map_or("", String::as_str);
    let mut svg = format!("<svg {}><title>Confusion, N_s = {sensing_slots}</title>", medium.root(height));
    let _ = write!(
        svg,
        "<text class=\"axis-y\" transform=\"translate({:.1} {:.1}) rotate(-90)\" text-anchor=\"middle\">true class</text>",
        edge + 14.0,
        top + side / 2.0
    );
    for (k, c) in of(figures, sensing_slots).enumerate() {
        let left = left + k as f64 * (side + GAP);
        let middle = left + side / 2.0;
        let _ = write!(
            svg,
            "<text x=\"{middle:.1}\" y=\"15\" text-anchor=\"middle\">{}, N_s = {sensing_slots} (recordings)</text>\
             <text class=\"axis-x\" x=\"{middle:.1}\" y=\"{:.1}\" text-anchor=\"middle\">recognised class</text>",
            escape(&c.arithmetic),
            height - 8.0
        );
        for (truth, row) in c.counts.iter().enumerate() {
            let y = top + CELL * truth as f64;
            let column = left + CELL * (truth as f64 + 0.5) + 4.0;
            let _ = write!(
                svg,
                "<text transform=\"translate({column:.1} {:.1}) rotate(-90)\" text-anchor=\"end\">{}</text>",
                top + side + 6.0,
                escape(name(truth))
            );
            if k == 0 {
                let (x, y, name) = (left - 8.0, y + CELL / 2.0 + 4.0, escape(name(truth)));
                let _ = write!(svg, "<text x=\"{x:.1}\" y=\"{y:.1}\" text-anchor=\"end\">{name}</text>");
            }
            for (answer, &n) in row.iter().enumerate() {
                let x = left + CELL * answer as f64;
                let _ = write!(
                    svg,
                    "<rect x=\"{x:.1}\" y=\"{y:.1}\" width=\"{CELL}\" height=\"{CELL}\" fill=\"{}\" fill-opacity=\"{:.2}\" \
                     stroke=\"#888\"/><text x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"middle\">{n}</text>",
                    COLOURS[0],
                    0.6 * share(row, n),
                    x + CELL / 2.0,
                    y + CELL / 2.0 + 4.0
                );
            }
        }
    }
    svg + "</svg>"
}
