//! The plotting kit: scales, ticks, axes, lines, legend, as SVG text.
//!
//! Colours are CSS variables with fallbacks, so that one picture serves light and dark pages and stands alone.

use std::fmt::Write;

/// Colour-blind-safe series colours (Okabe and Ito).
pub const COLOURS: [&str; 7] = ["#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#7f7f7f"];

/// Text made safe for HTML and SVG.
pub fn escape(text: &str) -> String {
    text.replace('&', "&amp;")
        .replace('<', "&lt;")
        .replace('>', "&gt;")
        .replace('"', "&quot;")
        .replace('\'', "&#39;")
}

/// A picture that stands alone: on white, every CSS variable replaced by its fallback.
pub fn on_white(svg: String) -> String {
    let svg = svg.replacen("</title>", "</title><rect width=\"100%\" height=\"100%\" fill=\"#fff\"/>", 1);
    let mut parts = svg.split("var(--");
    let mut plain = parts.next().unwrap_or_default().to_owned();
    for part in parts {
        let (variable, rest) = part.split_once(')').unwrap_or((part, ""));
        plain += variable.split_once(',').map_or("none", |(_, fallback)| fallback);
        plain += rest;
    }
    plain
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

/// Names with their colours as a list that wraps.
pub fn legend(entries: &[(String, String)]) -> String {
    let items: String = entries
        .iter()
        .map(|(name, colour)| format!("<li><i style=\"background:{colour}\"></i>{}</li>", escape(name)))
        .collect();
    format!("<ul class=\"legend\">{items}</ul>")
}

/// One axis: the interval shown and its name.
#[derive(Debug, Clone)]
pub struct Axis {
    /// Lowest value.
    pub low: f64,
    /// Highest value.
    pub high: f64,
    /// Name with unit.
    pub name: String,
    /// Logarithmic (base 10).
    pub log: bool,
}

impl Axis {
    /// A linear axis around values, with a margin.
    pub fn around(values: impl IntoIterator<Item = f64>, name: &str) -> Self {
        let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
        for value in values.into_iter().filter(|v| v.is_finite()) {
            (low, high) = (low.min(value), high.max(value));
        }
        if low > high {
            (low, high) = (0.0, 1.0);
        }
        let margin = ((high - low) * 0.05).max(1e-9);
        Axis { low: low - margin, high: high + margin, name: name.into(), log: false }
    }

    fn share(&self, value: f64) -> f64 {
        let map = |x: f64| if self.log { x.max(1e-300).log10() } else { x };
        (map(value) - map(self.low)) / (map(self.high) - map(self.low)).max(1e-300)
    }

    /// Round values inside the axis.
    fn ticks(&self) -> Vec<f64> {
        if self.log {
            let (low, high) = (self.low.log10().ceil() as i32, self.high.log10().floor() as i32);
            return (low..=high).map(|e| 10_f64.powi(e)).collect();
        }
        let raw = (self.high - self.low) / 6.0;
        let power = 10_f64.powf(raw.log10().floor());
        let step =
            [1.0, 2.0, 2.5, 5.0, 10.0].map(|m| m * power).into_iter().find(|s| *s >= raw).unwrap_or(raw);
        let first = (self.low / step).ceil() as i64;
        (first..).map(|k| k as f64 * step).take_while(|x| *x <= self.high + step * 1e-9).take(20).collect()
    }
}

/// A plot being drawn.
#[derive(Debug)]
pub struct Plot {
    x: Axis,
    y: Axis,
    width: f64,
    height: f64,
    body: String,
    legend: Vec<(String, String)>,
    title: String,
}

const LEFT: f64 = 92.0;
const RIGHT: f64 = 16.0;
const TOP: f64 = 16.0;
const BOTTOM: f64 = 52.0;
/// Left edge of the legend, and the width of a letter.
const LEGEND: f64 = 40.0;
const LETTER: f64 = 6.8;

impl Plot {
    /// An empty plot; `title` is what a screen reader says.
    pub fn new(title: &str, x: Axis, y: Axis) -> Self {
        Plot {
            x,
            y,
            width: 640.0,
            height: 380.0,
            body: String::new(),
            legend: Vec::new(),
            title: title.into(),
        }
    }

    /// Pixel position of a point.
    pub fn at(&self, x: f64, y: f64) -> (f64, f64) {
        let (w, h) = (self.width - LEFT - RIGHT, self.height - TOP - BOTTOM);
        (LEFT + w * self.x.share(x), TOP + h * (1.0 - self.y.share(y)))
    }

    /// Adds SVG as it is.
    pub fn raw(&mut self, svg: &str) {
        self.body.push_str(svg);
    }

    /// A line through points; empty `name` stays out of the legend.
    pub fn line(&mut self, points: &[(f64, f64)], colour: &str, width: f64, name: &str) {
        let mut path = String::new();
        for (x, y) in points.iter().filter(|(x, y)| x.is_finite() && y.is_finite()) {
            let (px, py) = self.at(*x, *y);
            let _ = write!(path, "{px:.1},{py:.1} ");
        }
        let _ = write!(
            self.body,
            "<polyline points=\"{}\" fill=\"none\" stroke=\"{colour}\" stroke-width=\"{width}\" \
             stroke-linejoin=\"round\"/>",
            path.trim_end()
        );
        if !name.is_empty() {
            self.legend.push((name.into(), colour.into()));
        }
    }

    /// A dot with what it says when pointed at.
    pub fn dot(&mut self, x: f64, y: f64, radius: f64, colour: &str, says: &str) {
        let (px, py) = self.at(x, y);
        let _ = write!(
            self.body,
            "<circle cx=\"{px:.1}\" cy=\"{py:.1}\" r=\"{radius}\" fill=\"{colour}\"><title>{}</title></circle>",
            escape(says)
        );
    }

    /// A vertical bar between two values.
    pub fn error_bar(&mut self, x: f64, low: f64, high: f64, colour: &str) {
        let ((px, a), (_, b)) = (self.at(x, low), self.at(x, high));
        let _ = write!(
            self.body,
            "<path d=\"M{px:.1} {a:.1}V{b:.1}M{:.1} {a:.1}h8M{:.1} {b:.1}h8\" stroke=\"{colour}\" fill=\"none\"/>",
            px - 4.0,
            px - 4.0
        );
    }

    /// A band between two curves of equal length.
    pub fn band(&mut self, low: &[(f64, f64)], high: &[(f64, f64)], colour: &str) {
        let mut path = String::new();
        for (x, y) in low.iter().chain(high.iter().rev()).filter(|(x, y)| x.is_finite() && y.is_finite()) {
            // no further than the axes reach
            let (px, py) = self.at(x.clamp(self.x.low, self.x.high), y.clamp(self.y.low, self.y.high));
            let _ = write!(path, "{px:.1},{py:.1} ");
        }
        let path = path.trim_end();
        let _ = write!(self.body, "<polygon points=\"{path}\" fill=\"{colour}\" fill-opacity=\"0.13\"/>");
    }

    /// A tinted strip from one x to another, over the whole height, with what it says when pointed at.
    pub fn strip(&mut self, (from, to): (f64, f64), colour: &str, says: &str) {
        let ((left, top), (right, bottom)) = (self.at(from, self.y.high), self.at(to, self.y.low));
        let _ = write!(
            self.body,
            "<rect x=\"{left:.1}\" y=\"{top:.1}\" width=\"{:.1}\" height=\"{:.1}\" fill=\"{colour}\" fill-opacity=\"0.14\">\
             <title>{}</title></rect>",
            (right - left).max(0.0),
            bottom - top,
            escape(says)
        );
    }

    /// A dashed vertical line with a label.
    pub fn mark(&mut self, x: f64, label: &str) {
        let (px, _) = self.at(x, self.y.low);
        let bottom = self.height - BOTTOM;
        let near_right = px > self.width - 150.0;
        let (anchor, shift) = if near_right { ("end", -5.0) } else { ("start", 5.0) };
        let _ = write!(
            self.body,
            "<path d=\"M{px:.1} {TOP}V{bottom}\" stroke=\"var(--soft,#888)\" stroke-dasharray=\"4 4\"/>\
             <text x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"{anchor}\" class=\"small\">{}</text>",
            px + shift,
            TOP + 12.0,
            escape(label)
        );
    }

    /// An entry of the legend without a line.
    pub fn entry(&mut self, name: &str, colour: &str) {
        self.legend.push((name.into(), colour.into()));
    }

    /// The finished picture on white.
    pub fn standalone(self) -> String {
        on_white(self.svg())
    }

    /// The finished picture, its legend below it.
    pub fn svg(self) -> String {
        // as many entries to a row as the longest leaves room for
        let longest = self.legend.iter().map(|(name, _)| name.chars().count()).max().unwrap_or(0);
        let entry = 34.0 + LETTER * longest as f64;
        let abreast = ((self.width - LEGEND) / entry).clamp(1.0, 4.0) as usize;
        let rows = self.legend.len().div_ceil(abreast);
        let mut legend = String::new();
        for (index, (name, colour)) in self.legend.iter().enumerate() {
            let x = LEGEND + (index % abreast) as f64 * entry;
            let y = self.height + 8.0 + (index / abreast) as f64 * 20.0;
            let _ = write!(
                legend,
                "<rect x=\"{x}\" y=\"{}\" width=\"16\" height=\"4\" fill=\"{colour}\"/><text x=\"{}\" y=\"{}\">{}</text>",
                y - 6.0,
                x + 22.0,
                y,
                escape(name)
            );
        }
        self.drawn(self.height + rows as f64 * 20.0, &legend)
    }

    /// The finished picture for a page: its legend is text that wraps, its scale is an attribute for scripts.
    pub fn html(self) -> String {
        self.drawn(self.height, "") + &legend(&self.legend)
    }

    fn drawn(&self, height: f64, legend: &str) -> String {
        let mut grid = String::new();
        let (right, bottom) = (self.width - RIGHT, self.height - BOTTOM);
        for tick in self.x.ticks() {
            let (px, _) = self.at(tick, self.y.low);
            let _ = write!(
                grid,
                "<path d=\"M{px:.1} {TOP}V{bottom}\" class=\"grid\"/><text x=\"{px:.1}\" y=\"{}\" \
                 text-anchor=\"middle\">{}</text>",
                bottom + 16.0,
                number(tick)
            );
        }
        for tick in self.y.ticks() {
            let (_, py) = self.at(self.x.low, tick);
            let _ = write!(
                grid,
                "<path d=\"M{LEFT} {py:.1}H{right}\" class=\"grid\"/><text x=\"{}\" y=\"{:.1}\" \
                 text-anchor=\"end\">{}</text>",
                LEFT - 7.0,
                py + 4.0,
                number(tick)
            );
        }
        let _ = write!(
            grid,
            "<text x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"middle\">{}</text>\
             <text transform=\"translate(20 {:.1}) rotate(-90)\" text-anchor=\"middle\">{}</text>",
            (LEFT + right) / 2.0,
            self.height - 8.0,
            escape(&self.x.name),
            (TOP + bottom) / 2.0,
            escape(&self.y.name)
        );
        format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {} {height}\" role=\"img\" font-size=\"12\" \
             data-x=\"{} {} {LEFT} {right}\" data-y=\"{} {} {bottom} {TOP}\" data-log=\"{}\" font-family=\"system-ui,sans-serif\" fill=\"var(--ink,#222)\"><title>{}</title><style>.grid{{stroke:\
             var(--grid,#ddd);fill:none}}.small{{font-size:11px}}</style>{grid}{}{legend}</svg>",
            self.width,
            self.x.low,
            self.x.high,
            self.y.low,
            self.y.high,
            self.y.log,
            escape(&self.title),
            self.body
        )
    }
}
