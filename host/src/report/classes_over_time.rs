//! Class and confidence of recordings over time, each below its recording's spectrogram.

use super::plot::{Axis, COLOURS, Medium, SOFT, escape, number};
use super::spectrograms::{colour_bar, data, png, radial_speed};
use crate::results::{Classified, ClassifiedRecording, ClassifiedWindow, Spectrogram};
use std::fmt::Write;

/// Most recordings of a picture, and most windows.
pub const MOST_RECORDINGS: usize = 8;
pub const MOST_WINDOWS: usize = 20_000;

const MEDIUM: Medium = Medium::DOUBLE;
/// Heights of a recording's parts: its name, its spectrogram, a class, the confidence, the time axis; and the gap between two parts.
const NAME: f64 = 22.0;
const SPECTROGRAM: f64 = 120.0;
const CLASS: f64 = 13.0;
const CONFIDENCE: f64 = 60.0;
const TIME: f64 = 46.0;
const GAP: f64 = 10.0;
/// Margin for the axis of radial speeds and the colour bar.
const RIGHT: f64 = 100.0;

/// A recording's spectrogram on its time axis.
#[derive(Debug, Clone)]
pub struct OverTime {
    pub spectrogram: Spectrogram,
    /// Time of its left edge in s.
    pub first_s: f64,
    /// Slots a second.
    pub slot_rate_hz: f64,
}

/// Where a recording is drawn.
struct Panel<'a> {
    /// The model's classes, so many, and `unknown` if there is any.
    classes: &'a [String],
    known: usize,
    /// Time axis in s, and where it is.
    time: Axis,
    left: f64,
    right: f64,
    svg: String,
}

/// A picture of recordings that were classified, with their spectrograms.
pub fn picture(found: &Classified, spectrograms: &[OverTime]) -> String {
    let mut classes = found.classes.clone();
    let windows = || found.recordings.iter().flat_map(|recording| &recording.windows);
    let more = windows().map(|window| &window.class).find(|class| !classes.contains(class)).cloned();
    classes.extend(more);
    let longest = classes.iter().map(|class| MEDIUM.width_of(class)).fold(36.0, f64::max);
    let (mut body, mut y) = (String::new(), 0.0);
    for (recording, over_time) in found.recordings.iter().zip(spectrograms) {
        let seconds = f64::from(recording.slots) / over_time.slot_rate_hz;
        let mut panel = Panel {
            classes: &classes,
            known: found.classes.len(),
            time: Axis::new(0.0, seconds, "time (s)"),
            left: 28.0 + longest,
            right: MEDIUM.width - RIGHT,
            svg: String::new(),
        };
        y = panel.draw(recording, over_time, y);
        body += &panel.svg;
    }
    format!(
        "<svg {}><title>Class and confidence over time, model {}</title>\
         <style>.grid{{stroke:var(--grid,#ddd);fill:none}}.frame{{stroke:var(--ink,#222);fill:none}}</style>{body}</svg>",
        MEDIUM.root(y),
        escape(&found.model)
    )
}

impl Panel<'_> {
    /// Draws a recording from `top` on; its lower edge.
    fn draw(&mut self, recording: &ClassifiedRecording, over_time: &OverTime, top: f64) -> f64 {
        let width = self.right - self.left;
        let _ = write!(
            self.svg,
            "<g class=\"recording\"><text x=\"{:.1}\" y=\"{:.1}\">{}</text>",
            self.left,
            top + NAME - 6.0,
            escape(&shortened(&recording.file, width))
        );
        let at = top + NAME;
        self.spectrogram(over_time, at);
        let lanes = at + SPECTROGRAM + GAP;
        let bars = lanes + CLASS * self.classes.len() as f64 + GAP;
        let bottom = bars + CONFIDENCE;
        self.time_axis(at + SPECTROGRAM, (lanes, bars), bottom);
        self.lanes(lanes);
        self.side(&Axis::new(0.0, 1.0, "confidence"), (bars, bottom), true);
        let mut windows = recording.windows.iter().peekable();
        while let Some(window) = windows.next() {
            let next = windows.peek().map(|next| next.first_slot - window.first_slot);
            self.window(window, next, over_time.slot_rate_hz, lanes, bottom);
        }
        self.svg += "</g>";
        bottom + TIME
    }

    fn x(&self, seconds: f64) -> f64 {
        let share = ((seconds - self.time.low) / (self.time.high - self.time.low)).clamp(0.0, 1.0);
        self.left + share * (self.right - self.left)
    }

    /// The spectrogram with its axes of Doppler and radial speed, and its colour bar.
    fn spectrogram(&mut self, over_time: &OverTime, top: f64) {
        let OverTime { spectrogram: s, first_s, .. } = over_time;
        let bytes = png(s);
        let (low, high) = (s.first_row_hz, s.first_row_hz + s.row_hz * f64::from(s.rows));
        let bottom = top + SPECTROGRAM;
        let (from, to) = (self.x(*first_s), self.x(first_s + s.frame_s * f64::from(s.frames)));
        if !bytes.is_empty() {
            let _ = write!(
                self.svg,
                "<image href=\"{}\" x=\"{from:.1}\" y=\"{top:.1}\" width=\"{:.1}\" height=\"{SPECTROGRAM}\" preserveAspectRatio=\"none\" \
                 style=\"image-rendering:pixelated\"/>",
                data(&bytes),
                to - from
            );
        }
        self.side(&Axis::new(low, high, "Doppler (Hz)"), (top, bottom), true);
        let speed = |hz| radial_speed(s, hz);
        self.side(&Axis::new(speed(low), speed(high), "radial speed (m/s)"), (top, bottom), false);
        self.svg += &colour_bar(s, (MEDIUM.width - 38.0, top + 16.0), SPECTROGRAM - 16.0);
    }

    /// A vertical axis on the left or on the right, and the frame of its part.
    fn side(&mut self, axis: &Axis, (top, bottom): (f64, f64), left: bool) {
        let (x, tick, anchor, text, label) = match left {
            true => (self.left, -4.0, "end", -6.0, 12.0),
            false => (self.right, 4.0, "start", 6.0, self.right + 46.0),
        };
        for value in axis.ticks(4) {
            let y = bottom - (value - axis.low) / (axis.high - axis.low) * (bottom - top);
            let _ = write!(
                self.svg,
                "<path d=\"M{x:.1} {y:.1}h{tick}\" class=\"frame\"/><text x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"{anchor}\">{}</text>",
                x + text,
                y + 0.35 * MEDIUM.font,
                number(value)
            );
        }
        let _ = write!(
            self.svg,
            "<path d=\"M{:.1} {top:.1}H{:.1}V{bottom:.1}H{:.1}z\" class=\"frame\"/>\
             <text class=\"axis-y\" transform=\"translate({label:.1} {:.1}) rotate(-90)\" text-anchor=\"middle\">{}</text>",
            self.left,
            self.right,
            self.left,
            (top + bottom) / 2.0,
            escape(&axis.name)
        );
    }

    /// Ticks below the spectrogram, grid behind classes and confidence, numbers below them.
    fn time_axis(&mut self, image: f64, (lanes, bars): (f64, f64), bottom: f64) {
        for tick in self.time.ticks(6) {
            let x = self.x(tick);
            let _ = write!(
                self.svg,
                "<path d=\"M{x:.1} {lanes:.1}V{:.1}M{x:.1} {bars:.1}V{bottom:.1}\" class=\"grid\"/>\
                 <path d=\"M{x:.1} {image:.1}v4M{x:.1} {bottom:.1}v4\" class=\"frame\"/>\
                 <text x=\"{x:.1}\" y=\"{:.1}\" text-anchor=\"middle\">{}</text>",
                bars - GAP,
                bottom + MEDIUM.font + 5.0,
                number(tick)
            );
        }
        let _ = write!(
            self.svg,
            "<text class=\"axis-x\" x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"middle\">{}</text>",
            (self.left + self.right) / 2.0,
            bottom + 2.0 * MEDIUM.font + 9.0,
            self.time.name
        );
    }

    /// A line for each class with its name.
    fn lanes(&mut self, top: f64) {
        let height = CLASS * self.classes.len() as f64;
        for (k, class) in self.classes.iter().enumerate() {
            let y = top + CLASS * k as f64;
            let _ = write!(
                self.svg,
                "<path d=\"M{:.1} {y:.1}H{:.1}\" class=\"grid\"/><text class=\"class\" x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"end\">{}</text>",
                self.left,
                self.right,
                self.left - 6.0,
                y + CLASS / 2.0 + 0.35 * MEDIUM.font,
                escape(class)
            );
        }
        let _ = write!(
            self.svg,
            "<path d=\"M{:.1} {top:.1}H{:.1}v{height:.1}H{:.1}z\" class=\"frame\"/>\
             <text class=\"axis-y\" transform=\"translate(12 {:.1}) rotate(-90)\" text-anchor=\"middle\">class</text>",
            self.left,
            self.right,
            self.left,
            top + height / 2.0
        );
    }

    /// A window over the slots that it used, or up to the next window: in its class's line, and its confidence.
    fn window(
        &mut self,
        window: &ClassifiedWindow,
        next: Option<u32>,
        rate_hz: f64,
        lanes: f64,
        bottom: f64,
    ) {
        let ClassifiedWindow { first_slot, slots_used, class, confidence, .. } = window;
        let Some(k) = self.classes.iter().position(|name| name == class) else { return };
        let drawn = next.map_or(*slots_used, |next| next.min(*slots_used));
        let second = |slot: u32| f64::from(slot) / rate_hz;
        let (from, to) = (self.x(second(*first_slot)), self.x(second(first_slot + drawn)));
        // neighbours stay apart where there is room
        let width = if to - from > 4.0 { to - from - 0.6 } else { (to - from).max(0.3) };
        let colour = if k < self.known { COLOURS[k % (COLOURS.len() - 1)] } else { SOFT.colour };
        let height = confidence * CONFIDENCE;
        let _ = write!(
            self.svg,
            "<g class=\"window\" fill=\"{colour}\"><title>{} s: {}, confidence {confidence:.3}, {slots_used} slots</title>\
             <rect x=\"{from:.2}\" y=\"{:.1}\" width=\"{width:.2}\" height=\"{:.1}\"/>\
             <rect x=\"{from:.2}\" y=\"{:.2}\" width=\"{width:.2}\" height=\"{height:.2}\"/></g>",
            number(second(*first_slot)),
            escape(class),
            lanes + CLASS * k as f64 + 2.0,
            CLASS - 4.0,
            bottom - height
        );
    }
}

/// The end of a name that is wider than this, after an ellipsis.
fn shortened(name: &str, width: f64) -> String {
    let fits = |text: &str| MEDIUM.width_of(text) <= width;
    if fits(name) {
        return name.to_owned();
    }
    let ends = name.char_indices().map(|(at, _)| &name[at..]);
    ends.map(|end| format!("…{end}")).find(|text| fits(text)).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_long_name_keeps_its_end() {
        assert_eq!(shortened("walk.npy", 200.0), "walk.npy");
        let short = shortened(&format!("{}/walk.npy", "ä".repeat(300)), 200.0);
        assert!(short.starts_with("…ä") && short.ends_with("ä/walk.npy"), "{short}");
        assert!(MEDIUM.width_of(&short) <= 200.0, "{short}");
        assert_eq!(shortened("walk.npy", 0.0), "");
    }

    #[test]
    fn a_window_is_in_its_classs_line_as_wide_as_its_slots() {
        let window = |first_slot, class: &str| ClassifiedWindow {
            first_slot,
            start_s: f64::from(first_slot) / 1000.0,
            slots_used: 200,
            faulty_slots: None,
            class: class.into(),
            confidence: 0.5,
            logits: Vec::new(),
        };
        let recording = ClassifiedRecording {
            file: "a<b".into(),
            format: "NPY".into(),
            slots: 1000,
            supervision: None,
            windows: vec![window(0, "sit"), window(100, "fall"), window(500, "unknown")],
        };
        let found = Classified {
            model: "m".into(),
            sensing_slots: 400,
            classes: vec!["sit".into(), "fall".into()],
            early_exits: None,
            recordings: vec![recording],
        };
        let spectrogram = Spectrogram {
            title: String::new(),
            rows: 2,
            frames: 1,
            first_row_hz: -100.0,
            row_hz: 100.0,
            frame_s: 0.5,
            carrier_hz: 1e9,
            range_db: 50.0,
            intensities: vec![0, 255],
        };
        let over_time = OverTime { spectrogram, first_s: 0.25, slot_rate_hz: 1000.0 };
        let svg = picture(&found, &[over_time]);
        let marks: Vec<&str> = svg.split("<g class=\"window\"").skip(1).collect();
        let number = |text: &str, name: &str| -> f64 {
            text.split(&format!("{name}=\"")).nth(1).unwrap().split('"').next().unwrap().parse().unwrap()
        };
        // the margins are 28 and the shortest width of names, and 100
        let wide = MEDIUM.width - 100.0 - 28.0 - MEDIUM.width_of("unknown").max(36.0);
        let widths: Vec<f64> = marks.iter().map(|mark| number(mark, "width")).collect();
        for (width, share) in widths.iter().zip([0.1, 0.2, 0.2]) {
            assert!((width + 0.6 - share * wide).abs() < 0.02, "{widths:?}");
        }
        let tops: Vec<f64> = marks.iter().map(|mark| number(mark, " y")).collect();
        assert_eq!([tops[1] - tops[0], tops[2] - tops[1]], [CLASS; 2]);
        assert_eq!([COLOURS[0], COLOURS[1], SOFT.colour].map(|colour| svg.matches(colour).count()), [1; 3]);
        assert!(svg.contains("a&lt;b") && !svg.contains("a<b"));
    }
}
