//! Several pictures as one figure: panels side by side, each with its caption below it, as a journal sets them.

use super::plot::{Medium, PAPER_FONT, UNITS_PER_MM, escape};
use std::fmt::Write;

/// A panel of a figure with three columns, over the width of two of a journal.
pub const THIRD: Medium =
    Medium { width: 236.0, height: 176.0, font: PAPER_FONT, left: 50.0, bottom: 40.0, mm: 0.0 };
/// Space between panels, and height of a caption.
const GAP: f64 = 6.0;
const CAPTION: f64 = 20.0;

/// Width and height of a picture: its view box.
fn size(svg: &str) -> (f64, f64) {
    let numbers = svg.split_once("viewBox=\"").and_then(|(_, rest)| rest.split_once('"'));
    let mut numbers =
        numbers.map_or("", |(box_, _)| box_).split(' ').skip(2).map(|n| n.parse().unwrap_or(0.0));
    (numbers.next().unwrap_or(0.0), numbers.next().unwrap_or(0.0))
}

/// Panels `(caption, picture)` in rows of `columns`; captions are lettered.
pub fn grid(title: &str, columns: usize, panels: &[(String, String)]) -> String {
    let sizes: Vec<(f64, f64)> = panels.iter().map(|(_, svg)| size(svg)).collect();
    let width = sizes.iter().map(|size| size.0).fold(0.0, f64::max);
    let (mut top, mut body) = (0.0, String::new());
    for (row, panels) in panels.chunks(columns.max(1)).enumerate() {
        let sizes = &sizes[row * columns.max(1)..][..panels.len()];
        let height = sizes.iter().map(|size| size.1).fold(0.0, f64::max);
        for (column, ((caption, svg), (w, h))) in panels.iter().zip(sizes).enumerate() {
            let letter = char::from(b'a' + (row * columns.max(1) + column).min(25) as u8);
            let x = column as f64 * (width + GAP);
            // a picture that stands alone has a size in mm: here it has that of its view box
            let inner = svg.split_once("viewBox=").map_or(String::new(), |(_, rest)| {
                let (view, rest) = rest.split_once("\" ").unwrap_or((rest, ""));
                let rest =
                    rest.split_once("role=").map_or(rest.to_owned(), |(_, rest)| format!("role={rest}"));
                format!("<svg x=\"{x}\" y=\"{top}\" width=\"{w}\" height=\"{h}\" viewBox={view}\" {rest}")
            });
            let _ = write!(
                body,
                "{inner}<text x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"middle\">({letter}) {}</text>",
                x + width / 2.0,
                top + height + 0.6 * CAPTION,
                escape(caption)
            );
        }
        top += height + CAPTION + GAP;
    }
    let whole =
        width * columns.min(panels.len()).max(1) as f64 + GAP * (columns.min(panels.len()).max(1) - 1) as f64;
    let medium = Medium { width: whole, mm: whole / UNITS_PER_MM, ..THIRD };
    format!("<svg {}><title>{}</title>{body}</svg>", medium.root(top), escape(title))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::plot::{Axis, Plot, STYLES};

    #[test]
    fn panels_keep_their_place_and_render() {
        let mut plot = Plot::new("p", Axis::new(0.0, 1.0, "x (s)"), Axis::new(0.0, 1.0, "y (m)"));
        let series = plot.series("line", STYLES[0]);
        plot.line(series, &[(0.0, 0.0), (1.0, 1.0)], 1.0);
        let panels: Vec<_> = ["one", "two", "three"].map(|name| (name.to_owned(), plot.svg(THIRD))).into();
        let figure = grid("all", 2, &panels);
        assert_eq!(figure.matches("<svg ").count(), 4);
        for caption in ["(a) one", "(b) two", "(c) three"] {
            assert!(figure.contains(caption), "{caption}");
        }
        assert!(figure.contains("x=\"242\"") && figure.contains("width=\"119.5mm\""), "{figure:.300}");
        crate::report::paper::forms("panels", &figure).unwrap();
    }
}
