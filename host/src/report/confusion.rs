//! Confusion matrices, float beside int8: a table for the page, a picture for a paper.

use super::plot::{COLOURS, escape};
use crate::results::{Confusion, Figures};
use std::fmt::Write;

/// The arithmetics in the order they stand.
const ARITHMETICS: [&str; 2] = ["float", "int8"];

/// Edge of a cell, room of the class names, and of a matrix's heading.
const CELL: f64 = 44.0;
const NAMES: f64 = 110.0;
const HEAD: f64 = 60.0;

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
pub fn tables(figures: &Figures) -> String {
    let largest = slots(figures).pop().unwrap_or(0);
    let tables: String = of(figures, largest).map(|c| table(c, &figures.classes)).collect();
    format!("<div class=\"row\" id=\"confusion\">{tables}</div>")
}

fn share(row: &[u32], n: u32) -> f64 {
    f64::from(n) / f64::from(row.iter().sum::<u32>().max(1))
}

fn table(c: &Confusion, classes: &[String]) -> String {
    let mut rows = String::new();
    for (truth, row) in c.counts.iter().enumerate() {
        let name = classes.get(truth).map_or("", String::as_str);
        let _ = write!(rows, "<tr><th scope=\"row\">{}</th>", escape(name));
        for (answer, &n) in row.iter().enumerate() {
            let class = if truth == answer { "right" } else { "wrong" };
            let _ = write!(rows, "<td class=\"{class}\" style=\"--share:{:.2}\">{n}</td>", share(row, n));
        }
        rows.push_str("</tr>");
    }
    format!(
        "<figure><table class=\"confusion\"><caption>{}, N_s = {}: truth down, answer across</caption>{rows}</table></figure>",
        escape(&c.arithmetic),
        c.sensing_slots
    )
}

/// The picture of one N_s: rows are the truth, columns the answer.
pub fn svg(figures: &Figures, sensing_slots: u32) -> String {
    let classes = figures.classes.len();
    let side = CELL * classes as f64;
    let width = NAMES + 2.0 * side + 60.0;
    let height = HEAD + side + 30.0;
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width} {height}\" role=\"img\" font-size=\"12\" \
         font-family=\"system-ui,sans-serif\" fill=\"var(--ink,#222)\"><title>Confusion, N_s = {sensing_slots}</title>"
    );
    for (k, c) in of(figures, sensing_slots).enumerate() {
        let left = NAMES + k as f64 * (side + 30.0);
        let middle = left + side / 2.0;
        let _ = write!(
            svg,
            "<text x=\"{middle}\" y=\"20\" text-anchor=\"middle\" font-size=\"14\">{}, N_s = {sensing_slots}</text>\
             <text x=\"{middle}\" y=\"{}\" text-anchor=\"middle\">answer (in the order of the rows)</text>",
            escape(&c.arithmetic),
            height - 10.0
        );
        for (truth, row) in c.counts.iter().enumerate() {
            let y = HEAD - 20.0 + CELL * truth as f64;
            if k == 0 {
                let name = figures.classes.get(truth).map_or("", String::as_str);
                let _ = write!(
                    svg,
                    "<text x=\"{}\" y=\"{}\" text-anchor=\"end\">{}</text>",
                    left - 8.0,
                    y + CELL / 2.0 + 4.0,
                    escape(name)
                );
            }
            for (answer, &n) in row.iter().enumerate() {
                let x = left + CELL * answer as f64;
                let colour = if truth == answer { COLOURS[2] } else { COLOURS[1] };
                let _ = write!(
                    svg,
                    "<rect x=\"{x}\" y=\"{y}\" width=\"{CELL}\" height=\"{CELL}\" fill=\"{colour}\" fill-opacity=\"{:.2}\" \
                     stroke=\"#aaa\"/><text x=\"{}\" y=\"{}\" text-anchor=\"middle\">{n}</text>",
                    0.7 * share(row, n),
                    x + CELL / 2.0,
                    y + CELL / 2.0 + 4.0
                );
            }
        }
    }
    svg + "</svg>"
}
