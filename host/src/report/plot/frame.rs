//! A plot on its medium: shapes, grid and axes as SVG text.

use super::style::{Style, escape, number};
use super::{Medium, Plot, RIGHT, Shape, TOP};
use std::fmt::Write;
use std::ptr;

/// Opacity of a band.
pub(super) const BAND: f64 = 0.2;

pub(super) fn ring((x, y): (f64, f64), r: f64, colour: &str) -> String {
    format!(
        "<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"{r}\" fill=\"none\" stroke=\"{colour}\" stroke-width=\"1.6\"/>"
    )
}

pub(super) fn bar(x: f64, top: f64, bottom: f64, colour: &str) -> String {
    format!(
        "<path d=\"M{x:.1} {top:.1}V{bottom:.1}M{:.1} {top:.1}h6M{:.1} {bottom:.1}h6\" stroke=\"{colour}\" fill=\"none\"/>",
        x - 3.0,
        x - 3.0
    )
}

pub(super) fn tint((x, y): (f64, f64), (width, height): (f64, f64), colour: &str, opacity: f64) -> String {
    format!(
        "<rect x=\"{x:.1}\" y=\"{y:.1}\" width=\"{:.1}\" height=\"{height:.1}\" fill=\"{colour}\" fill-opacity=\"{opacity}\"/>",
        width.max(0.0)
    )
}

/// A plot on its medium.
pub(super) struct Frame<'a> {
    pub plot: &'a Plot,
    pub medium: Medium,
}

impl Frame<'_> {
    /// Position of a point in the view box.
    pub fn at(&self, (x, y): (f64, f64)) -> (f64, f64) {
        let m = self.medium;
        let (w, h) = (m.width - m.left - RIGHT, m.height - TOP - m.bottom);
        (m.left + w * self.plot.x.share(x), TOP + h * (1.0 - self.plot.y.share(y)))
    }

    pub fn path(&self, points: impl Iterator<Item = (f64, f64)>) -> String {
        let mut path = String::new();
        for point in points.filter(|(x, y)| x.is_finite() && y.is_finite()) {
            let (x, y) = self.at(point);
            let _ = write!(path, "{x:.1},{y:.1} ");
        }
        path.trim_end().to_owned()
    }

    pub fn shape(&self, style: Style, shape: &Shape) -> String {
        let (x_axis, y_axis, colour) = (&self.plot.x, &self.plot.y, style.colour);
        let top_bottom = |x: f64| (self.at((x, y_axis.high)), self.at((x, y_axis.low)));
        match shape {
            Shape::Line { points, width, dash } => {
                let dash =
                    if dash.is_empty() { String::new() } else { format!(" stroke-dasharray=\"{dash}\"") };
                format!(
                    "<polyline class=\"line\" points=\"{}\" stroke=\"{colour}\" stroke-width=\"{width}\"{dash}/>",
                    self.path(points.iter().copied())
                )
            }
            Shape::Dot { at, radius, says } => style.mark(self.at(*at), *radius, says),
            Shape::Ring { at, label } => {
                let (x, y) = self.at(*at);
                let left = x > self.medium.left + 12.0 + self.medium.width_of(label);
                let low = y + self.medium.font + 8.0 > self.medium.height - self.medium.bottom;
                let (anchor, shift) = if left { ("end", -9.0) } else { ("start", 9.0) };
                format!(
                    "{}<text x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"{anchor}\">{}</text>",
                    ring((x, y), 6.0, colour),
                    x + shift,
                    if low { y - 8.0 } else { y + self.medium.font + 4.0 },
                    escape(label)
                )
            }
            Shape::Bar { x, low, high } => {
                let ((px, bottom), (_, top)) = (self.at((*x, *low)), self.at((*x, *high)));
                bar(px, top, bottom, colour)
            }
            Shape::Band { edge } => {
                // no further than the axes reach
                let inside = |(x, y): &(f64, f64)| {
                    (x.clamp(x_axis.low, x_axis.high), y.clamp(y_axis.low, y_axis.high))
                };
                let path = self.path(edge.iter().map(inside));
                format!("<polygon points=\"{path}\" fill=\"{colour}\" fill-opacity=\"{BAND}\"/>")
            }
            Shape::Strip { from, to, opacity, says } => {
                let ((left, top), (right, bottom)) = (top_bottom(*from).0, top_bottom(*to).1);
                let rect = tint((left, top), (right - left, bottom - top), colour, *opacity);
                rect.replace("/>", &format!("><title>{}</title></rect>", escape(says)))
            }
            Shape::Mark { x, label } => {
                let ((px, top), (_, bottom)) = top_bottom(*x);
                let (from, to) = self.label_span(*x, label);
                let (anchor, at) = if from < px { ("end", to) } else { ("start", from) };
                let before =
                    self.plot.shapes.iter().map(|(_, one)| one).take_while(|one| !ptr::eq(*one, shape));
                let spans = before.filter_map(|one| match one {
                    Shape::Mark { x, label } => Some(self.label_span(*x, label)),
                    _ => None,
                });
                // below those that it would be printed over
                let row = spans.filter(|other| from < other.1 && other.0 < to).count() as f64;
                format!(
                    "<path d=\"M{px:.1} {top}V{bottom}\" stroke=\"{colour}\" stroke-dasharray=\"3 3\"/>\
                     <text x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"{anchor}\">{}</text>",
                    at,
                    top + self.medium.font * (1.0 + 1.2 * row),
                    escape(label)
                )
            }
        }
    }

    /// Where the label of a mark at x begins and ends: to its right where there is room.
    fn label_span(&self, x: f64, label: &str) -> (f64, f64) {
        let ((px, _), width) = (self.at((x, self.plot.y.low)), self.medium.width_of(label));
        match px + width + 8.0 > self.medium.width - RIGHT {
            true => (px - 4.0 - width, px - 4.0),
            false => (px + 4.0, px + 4.0 + width),
        }
    }

    /// Grid, numbers and names of both axes.
    pub fn axes(&self) -> String {
        let Frame { plot, medium: m } = self;
        let (right, bottom) = (m.width - RIGHT, m.height - m.bottom);
        let mut svg = String::new();
        let most = ((right - m.left) / (4.2 * m.font)) as usize;
        for tick in plot.x.ticks(most) {
            let (x, _) = self.at((tick, plot.y.low));
            // the first stays clear of the lowest number of the other axis
            let anchor = if x < m.left + 1.0 { "start" } else { "middle" };
            let _ = write!(
                svg,
                "<path d=\"M{x:.1} {TOP}V{bottom}\" class=\"grid\"/><text x=\"{x:.1}\" y=\"{:.1}\" text-anchor=\"{anchor}\">{}</text>",
                bottom + m.font + 3.0,
                number(tick)
            );
        }
        for tick in plot.y.ticks(6) {
            let (_, y) = self.at((plot.x.low, tick));
            let _ = write!(
                svg,
                "<path d=\"M{} {y:.1}H{right}\" class=\"grid\"/><text x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"end\">{}</text>",
                m.left,
                m.left - 6.0,
                y + 0.35 * m.font,
                number(tick)
            );
        }
        let _ = write!(
            svg,
            "<path d=\"M{0} {TOP}V{bottom}H{right}\" fill=\"none\" stroke=\"var(--ink,#222)\"/>\
             <text class=\"axis-x\" x=\"{1:.1}\" y=\"{2:.1}\" text-anchor=\"middle\">{3}</text>\
             <text class=\"axis-y\" transform=\"translate({4:.1} {5:.1}) rotate(-90)\" text-anchor=\"middle\">{6}</text>",
            m.left,
            (m.left + right) / 2.0,
            m.height - 9.0,
            escape(&plot.x.name),
            0.22 * m.left,
            (TOP + bottom) / 2.0,
            escape(&plot.y.name)
        );
        svg
    }
}
