//! Colours, markers and dashes of series, and numbers as words.

use crate::text::shown;

/// Colours of series, safe for the colour-blind (Okabe and Ito); neighbours differ in lightness.
pub const COLOURS: [&str; 7] = ["#0072b2", "#e69f00", "#009e73", "#cc79a7", "#d55e00", "#56b4e9", "#7f7f7f"];

/// Text made safe for HTML and SVG; XML has no control characters, not even escaped.
pub fn escape(text: &str) -> String {
    shown(text)
        .replace('&', "&amp;")
        .replace('<', "&lt;")
        .replace('>', "&gt;")
        .replace('"', "&quot;")
        .replace('\'', "&#39;")
}

/// A short decimal number.
pub fn number(x: f64) -> String {
    if !x.is_finite() {
        return "–".into();
    }
    let magnitude = x.abs();
    let text = if magnitude >= 1e5 || (magnitude < 1e-3 && magnitude > 0.0) {
        format!("{x:.2e}")
    } else if magnitude >= 100.0 {
        format!("{x:.0}")
    } else {
        format!("{x:.4}")
    };
    if text.contains('.') && !text.contains('e') {
        text.trim_end_matches('0').trim_end_matches('.').to_owned()
    } else {
        text
    }
}

/// Digits in groups of three.
pub fn grouped(n: u64) -> String {
    let digits = n.to_string();
    let first = digits.len() % 3;
    let mut out = String::new();
    for (index, digit) in digits.chars().enumerate() {
        if index > 0 && index % 3 == first % 3 {
            out.push('\u{202f}');
        }
        out.push(digit);
    }
    out
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Marker {
    Circle,
    Square,
    /// A triangle, point up.
    Triangle,
    /// A square on its corner.
    Diamond,
    /// A triangle, point down.
    Down,
    Plus,
    /// A star of four points.
    Star,
}

/// How a series is drawn.
#[derive(Debug, Clone, Copy)]
pub struct Style {
    /// Colour of lines and markers.
    pub colour: &'static str,
    /// Dashes of its lines; empty for a solid one.
    pub dash: &'static str,
    /// Marker of its points.
    pub marker: Marker,
}

impl Style {
    pub(super) const fn new(colour: &'static str, dash: &'static str, marker: Marker) -> Self {
        Style { colour, dash, marker }
    }

    /// The same with solid lines.
    pub fn solid(self) -> Self {
        Style { dash: "", ..self }
    }

    /// The marker around a place, in SVG.
    pub(super) fn mark(self, (x, y): (f64, f64), r: f64, says: &str) -> String {
        let says = if says.is_empty() { String::new() } else { format!("<title>{}</title>", escape(says)) };
        let fill = self.colour;
        match self.marker {
            Marker::Circle => {
                format!("<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"{r}\" fill=\"{fill}\">{says}</circle>")
            }
            Marker::Square => {
                let (left, top, side) = (x - 0.9 * r, y - 0.9 * r, 1.8 * r);
                format!(
                    "<rect x=\"{left:.1}\" y=\"{top:.1}\" width=\"{side:.1}\" height=\"{side:.1}\" fill=\"{fill}\">{says}</rect>"
                )
            }
            Marker::Triangle => {
                let (a, b) = (1.2 * r, 0.8 * r);
                format!(
                    "<path d=\"M{x:.1} {:.1}l{a:.1} {:.1}h{:.1}z\" fill=\"{fill}\">{says}</path>",
                    y - a,
                    a + b,
                    -2.0 * a
                )
            }
            Marker::Down => {
                let (a, b) = (1.2 * r, 0.8 * r);
                polygon((x, y), &[(-a, -b), (a, -b), (0.0, a)], fill, &says)
            }
            Marker::Plus => {
                let (a, w) = (1.2 * r, 0.4 * r);
                polygon((x, y), &in_four_quarters(&[(-w, -a), (w, -a), (w, -w)]), fill, &says)
            }
            Marker::Star => {
                let (a, w) = (1.5 * r, 0.4 * r);
                polygon((x, y), &in_four_quarters(&[(0.0, -a), (w, -w)]), fill, &says)
            }
            Marker::Diamond => {
                let a = 1.3 * r;
                format!(
                    "<path d=\"M{x:.1} {:.1}l{a:.1} {a:.1}l{:.1} {a:.1}l{:.1} {:.1}z\" fill=\"{fill}\">{says}</path>",
                    y - a,
                    -a,
                    -a,
                    -a
                )
            }
        }
    }
}

/// Corners and what a quarter of a turn, half of one and three quarters make of them.
fn in_four_quarters(corners: &[(f64, f64)]) -> Vec<(f64, f64)> {
    let quarters = [(1.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (0.0, -1.0)];
    quarters
        .iter()
        .flat_map(|(c, s)| corners.iter().map(move |(x, y)| (x * c - y * s, x * s + y * c)))
        .collect()
}

/// A filled polygon, in SVG; corners from its centre.
fn polygon((x, y): (f64, f64), corners: &[(f64, f64)], fill: &str, says: &str) -> String {
    let corners: Vec<String> =
        corners.iter().map(|(dx, dy)| format!("{:.1} {:.1}", x + dx, y + dy)).collect();
    format!("<path d=\"M{}z\" fill=\"{fill}\">{says}</path>", corners.join("L"))
}

/// Styles in the order of series.
pub const STYLES: [Style; 7] = [
    Style::new(COLOURS[0], "", Marker::Circle),
    Style::new(COLOURS[1], "6 2", Marker::Square),
    Style::new(COLOURS[2], "2 2", Marker::Triangle),
    Style::new(COLOURS[3], "8 2 2 2", Marker::Diamond),
    Style::new(COLOURS[4], "10 3", Marker::Down),
    Style::new(COLOURS[5], "4 4", Marker::Plus),
    Style::new(COLOURS[6], "1 3", Marker::Star),
];

/// The style of a series among any number: after all colours dashes and markers are paired with others.
pub fn style(index: usize) -> Style {
    let Style { dash, marker, .. } = STYLES[(index + index / STYLES.len()) % STYLES.len()];
    Style { dash, marker, ..STYLES[index % STYLES.len()] }
}

/// Secondary lines: thin and grey.
pub const SOFT: Style = Style::new("var(--soft,#999)", "", Marker::Circle);

/// What is neither a case nor a method: text and rings.
pub const INK: Style = Style::new("var(--ink,#222)", "", Marker::Circle);
