//! The plotting kit: scales, ticks, axes, series, legend, as SVG text.
//!
//! Colours are CSS variables with fallbacks, so that one picture serves light and dark pages and stands alone. Series differ in
//! lightness, dash and marker, so that print without colours keeps them apart.

mod frame;
mod style;

pub use style::{COLOURS, INK, SOFT, STYLES, Style, escape, grouped, number, style};

use frame::{BAND, Frame, bar, ring, tint};
use std::fmt::Write;

/// One axis: the interval shown and its name.
#[derive(Debug, Clone)]
pub struct Axis {
    pub low: f64,
    pub high: f64,
    pub name: String,
    /// Logarithmic (base 10).
    pub log: bool,
    pub whole: bool,
}

impl Axis {
    /// A linear axis between two values.
    pub fn new(low: f64, high: f64, name: &str) -> Self {
        Axis { low, high, name: name.into(), log: false, whole: false }
    }

    /// A linear axis around values, with a margin.
    pub fn around(values: impl IntoIterator<Item = f64>, name: &str) -> Self {
        let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
        for value in values.into_iter().filter(|v| v.is_finite()) {
            (low, high) = (low.min(value), high.max(value));
        }
        if low > high {
            (low, high) = (0.0, 1.0);
        }
        // ticks differ within the four digits that are shown
        let margin = ((high - low) * 0.05).max(1e-3 * high.abs().max(low.abs())).max(1e-9);
        Axis { low: low - margin, high: high + margin, name: name.into(), log: false, whole: false }
    }

    fn share(&self, value: f64) -> f64 {
        let map = |x: f64| if self.log { x.max(1e-300).log10() } else { x };
        (map(value) - map(self.low)) / (map(self.high) - map(self.low)).max(1e-300)
    }

    /// Round values inside the axis, about so many.
    pub fn ticks(&self, most: usize) -> Vec<f64> {
        if self.log {
            let (low, high) = (self.low.log10().ceil() as i32, self.high.log10().floor() as i32);
            return (low..=high).map(|e| 10_f64.powi(e)).collect();
        }
        let raw = (self.high - self.low) / most.clamp(2, 6) as f64;
        let raw = if self.whole { raw.max(1.0) } else { raw };
        let power = 10_f64.powf(raw.log10().floor());
        let step = [1.0, 2.0, 2.5, 5.0, 10.0]
            .map(|m| m * power)
            .into_iter()
            .find(|s| *s >= raw && !(self.whole && s.fract() > 0.0))
            .unwrap_or(raw);
        let first = (self.low / step).ceil() as i64;
        (first..).map(|k| k as f64 * step).take_while(|x| *x <= self.high + step * 1e-9).take(20).collect()
    }
}

/// Names with samples of their series, in SVG around y = 8, as a list that wraps.
pub fn legend(entries: &[(String, String)]) -> String {
    let item = |(name, sample): &(String, String)| {
        format!(
            "<li><svg viewBox=\"0 0 {SAMPLE} 16\" aria-hidden=\"true\">{sample}</svg>{}</li>",
            escape(name)
        )
    };
    format!("<ul class=\"legend\">{}</ul>", entries.iter().map(item).collect::<String>())
}

/// A filled sample for [`legend`].
pub fn swatch(colour: &str) -> String {
    format!("<rect y=\"3\" width=\"{SAMPLE}\" height=\"10\" fill=\"{colour}\"/>")
}

/// What a picture is drawn for: size, text and margins in units of its view box.
#[derive(Debug, Clone, Copy)]
pub struct Medium {
    pub width: f64,
    /// Height without the legend.
    pub height: f64,
    /// Size of its text.
    pub font: f64,
    pub left: f64,
    pub bottom: f64,
    /// Width in mm on paper; 0 on a page, which scales it.
    pub mm: f64,
}

/// Units of a view box for each millimetre of paper.
pub const UNITS_PER_MM: f64 = 4.0;
/// Size of text on paper: 7.4 pt.
pub const PAPER_FONT: f64 = 10.5;

impl Medium {
    pub const PAGE: Medium =
        Medium { width: 640.0, height: 380.0, font: 12.0, left: 92.0, bottom: 52.0, mm: 0.0 };
    /// A single column of a journal.
    pub const SINGLE: Medium = Medium::paper(88.0, 236.0);
    /// Two columns of a journal.
    pub const DOUBLE: Medium = Medium::paper(180.0, 300.0);

    /// Paper of a width in mm and a height in units.
    pub const fn paper(mm: f64, height: f64) -> Self {
        Medium { width: mm * UNITS_PER_MM, height, font: PAPER_FONT, left: 56.0, bottom: 42.0, mm }
    }

    /// Attributes of a picture's root: size, text.
    pub fn root(&self, height: f64) -> String {
        let size = match self.mm > 0.0 {
            true => format!("width=\"{}mm\" height=\"{:.2}mm\" ", self.mm, height / UNITS_PER_MM),
            false => String::new(),
        };
        format!(
            "xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {} {height}\" {size}role=\"img\" font-size=\"{}\" \
             font-family=\"{FONTS}\" fill=\"var(--ink,#222)\"",
            self.width, self.font
        )
    }

    /// Estimated width of a text.
    pub fn width_of(&self, text: &str) -> f64 {
        0.58 * self.font * text.chars().count() as f64
    }
}

/// The font of figures: on paper the one embedded in them.
pub const FONTS: &str = "'DejaVu Sans',system-ui,sans-serif";

/// What a series shows, in values of the axes.
#[derive(Debug)]
enum Shape {
    Line { points: Vec<(f64, f64)>, width: f64, dash: &'static str },
    Dot { at: (f64, f64), radius: f64, says: String },
    Ring { at: (f64, f64), label: String },
    Bar { x: f64, low: f64, high: f64 },
    Band { edge: Vec<(f64, f64)> },
    Strip { from: f64, to: f64, opacity: f64, says: String },
    Mark { x: f64, label: String },
}

/// A name in the legend and the style of what belongs to it.
#[derive(Debug)]
struct Series {
    name: String,
    style: Style,
}

/// A series of a plot.
#[derive(Debug, Clone, Copy)]
pub struct Id(usize);

/// A plot: what is drawn is kept in values of its axes, so that it can be drawn for a page or for paper.
#[derive(Debug)]
pub struct Plot {
    x: Axis,
    y: Axis,
    title: String,
    series: Vec<Series>,
    shapes: Vec<(usize, Shape)>,
}

const RIGHT: f64 = 16.0;
const TOP: f64 = 16.0;
/// Width of a legend's sample of a series.
const SAMPLE: f64 = 26.0;

impl Plot {
    /// An empty plot; `title` is what a screen reader says.
    pub fn new(title: &str, x: Axis, y: Axis) -> Self {
        Plot { x, y, title: title.into(), series: Vec::new(), shapes: Vec::new() }
    }

    /// A series with its name in the legend.
    pub fn series(&mut self, name: &str, style: Style) -> Id {
        self.series.push(Series { name: name.into(), style });
        Id(self.series.len() - 1)
    }

    /// A line through points, with the dashes of its series.
    pub fn line(&mut self, Id(series): Id, points: &[(f64, f64)], width: f64) {
        let dash = self.series[series].style.dash;
        self.shapes.push((series, Shape::Line { points: points.to_vec(), width, dash }));
    }

    /// A dotted line: values that nothing was measured for.
    pub fn dotted(&mut self, Id(series): Id, points: &[(f64, f64)], width: f64) {
        self.shapes.push((series, Shape::Line { points: points.to_vec(), width, dash: "1.5 3" }));
    }

    /// A marker with what it says when pointed at.
    pub fn dot(&mut self, Id(series): Id, at: (f64, f64), radius: f64, says: &str) {
        self.shapes.push((series, Shape::Dot { at, radius, says: says.into() }));
    }

    /// A ring with a label beside it.
    pub fn ring(&mut self, Id(series): Id, at: (f64, f64), label: &str) {
        self.shapes.push((series, Shape::Ring { at, label: label.into() }));
    }

    /// A vertical bar between two values.
    pub fn error_bar(&mut self, Id(series): Id, x: f64, low: f64, high: f64) {
        self.shapes.push((series, Shape::Bar { x, low, high }));
    }

    /// A band between two curves of equal length.
    pub fn band(&mut self, Id(series): Id, low: &[(f64, f64)], high: &[(f64, f64)]) {
        let edge = low.iter().chain(high.iter().rev()).copied().collect();
        self.shapes.push((series, Shape::Band { edge }));
    }

    /// A tinted strip from one x to another, over the whole height, with what it says when pointed at.
    pub fn strip(&mut self, Id(series): Id, (from, to): (f64, f64), opacity: f64, says: &str) {
        self.shapes.push((series, Shape::Strip { from, to, opacity, says: says.into() }));
    }

    /// A dashed vertical line with a label.
    pub fn mark(&mut self, Id(series): Id, x: f64, label: &str) {
        self.shapes.push((series, Shape::Mark { x, label: label.into() }));
    }

    /// The finished picture, its legend below it.
    pub fn svg(&self, medium: Medium) -> String {
        let (legend, rows) = self.legend(medium);
        self.drawn(medium, medium.height + rows as f64 * (medium.font + 5.0) + 4.0, &legend)
    }

    /// The finished picture for a page: its legend is text that wraps, its scale is an attribute for scripts.
    pub fn html(&self) -> String {
        let medium = Medium::PAGE;
        let entry = |(k, s): (usize, &Series)| (s.name.clone(), self.sample(k, 0.0, 8.0, medium));
        let named = self.series.iter().enumerate().filter(|(_, series)| !series.name.is_empty());
        let entries: Vec<_> = named.map(entry).collect();
        self.drawn(medium, medium.height, "") + &legend(&entries)
    }

    /// Names and samples in rows as wide as the picture; how many rows.
    fn legend(&self, medium: Medium) -> (String, usize) {
        let first = 10.0;
        let (mut x, mut row, mut svg) = (first, 0, String::new());
        for (k, series) in self.series.iter().enumerate().filter(|(_, series)| !series.name.is_empty()) {
            let width = SAMPLE + 6.0 + medium.width_of(&series.name) + 10.0;
            if x > first && x + width > medium.width {
                (x, row) = (first, row + 1);
            }
            let y = medium.height + medium.font * 0.5 + row as f64 * (medium.font + 5.0);
            let _ = write!(
                svg,
                "<g class=\"entry\" data-series=\"{k}\">{}<text x=\"{:.1}\" y=\"{:.1}\">{}</text></g>",
                self.sample(k, x, y, medium),
                x + SAMPLE + 6.0,
                y + medium.font * 0.35,
                escape(&series.name)
            );
            x += width;
        }
        let rows = if svg.is_empty() { 0 } else { row + 1 };
        (format!("<g class=\"legend\">{svg}</g>"), rows)
    }

    /// A sample of everything a series draws, from x on around y.
    fn sample(&self, series: usize, x: f64, y: f64, medium: Medium) -> String {
        let style = self.series[series].style;
        let (colour, middle) = (style.colour, x + SAMPLE / 2.0);
        let (tall, mut svg, mut drawn) = (medium.font * 0.8, String::new(), Vec::new());
        for (_, shape) in self.shapes.iter().filter(|(own, _)| *own == series) {
            // one of a kind is enough
            let kind = std::mem::discriminant(shape);
            if drawn.contains(&kind) {
                continue;
            }
            drawn.push(kind);
            svg += &match shape {
                Shape::Line { width, dash, .. } => format!(
                    "<path d=\"M{x:.1} {y:.1}h{SAMPLE}\" stroke=\"{colour}\" stroke-width=\"{width}\" fill=\"none\" stroke-dasharray=\"{}\"/>",
                    if dash.is_empty() { "none" } else { dash }
                ),
                Shape::Dot { radius, .. } => style.mark((middle, y), radius.clamp(2.0, 4.0), ""),
                Shape::Ring { .. } => ring((middle, y), 4.5, colour),
                Shape::Bar { .. } => bar(middle, y - tall / 2.0, y + tall / 2.0, colour),
                Shape::Band { .. } => tint((x, y - tall / 2.0), (SAMPLE, tall), colour, BAND),
                Shape::Strip { opacity, .. } => tint((x, y - tall / 2.0), (SAMPLE, tall), colour, *opacity),
                Shape::Mark { .. } => {
                    format!(
                        "<path d=\"M{middle:.1} {:.1}v{tall}\" stroke=\"{colour}\" stroke-dasharray=\"3 2\"/>",
                        y - tall / 2.0
                    )
                }
            };
        }
        svg
    }

    fn drawn(&self, medium: Medium, height: f64, legend: &str) -> String {
        let frame = Frame { plot: self, medium };
        let (right, bottom) = (medium.width - RIGHT, medium.height - medium.bottom);
        let mut body = String::new();
        // tints lie under lines
        let tint = |(_, shape): &&(usize, Shape)| matches!(shape, Shape::Strip { .. } | Shape::Band { .. });
        let tints = self.shapes.iter().filter(tint);
        for (series, shape) in tints.chain(self.shapes.iter().filter(|shape| !tint(shape))) {
            let _ = write!(
                body,
                "<g data-series=\"{series}\">{}</g>",
                frame.shape(self.series[*series].style, shape)
            );
        }
        format!(
            "<svg {} data-x=\"{} {} {} {right}\" data-y=\"{} {} {bottom} {TOP}\" data-log-x=\"{}\" data-log=\"{}\"><title>{}</title>\
             <style>.grid{{stroke:var(--grid,#ddd);fill:none}}.line{{fill:none;stroke-linejoin:round}}</style>{}{body}{legend}</svg>",
            medium.root(height),
            self.x.low,
            self.x.high,
            medium.left,
            self.y.low,
            self.y.high,
            self.x.log,
            self.y.log,
            escape(&self.title),
            frame.axes(),
        )
    }
}
