//! Spectrograms as images with axes.
//!
//! Intensities in dB below the maximum through a perceptual ramp from black over violet and orange to light yellow.

use super::plot::{Medium, escape, number};
use crate::results::Spectrogram;
use base64::Engine;
use maud::{Markup, PreEscaped, html};
use std::fmt::Write;

/// Stops of the colour ramp, evenly spaced.
const RAMP: [[u8; 3]; 9] = [
    [0, 0, 4],
    [28, 16, 68],
    [79, 18, 123],
    [129, 37, 129],
    [181, 54, 122],
    [229, 80, 100],
    [251, 135, 97],
    [254, 194, 135],
    [252, 253, 191],
];

pub fn colour(intensity: u8) -> [u8; 3] {
    let position = f64::from(intensity) / 255.0 * 8.0;
    let stop = (position as usize).min(7);
    let share = position - stop as f64;
    std::array::from_fn(|c| {
        (f64::from(RAMP[stop][c]) * (1.0 - share) + f64::from(RAMP[stop + 1][c]) * share).round() as u8
    })
}

/// PNG bytes, highest frequency on top; empty for an empty spectrogram.
pub fn png(s: &Spectrogram) -> Vec<u8> {
    let (rows, frames) = (s.rows as usize, s.frames as usize);
    let mut bytes = Vec::new();
    if rows == 0 || frames == 0 || s.intensities.len() < rows * frames {
        return bytes;
    }
    let pixels: Vec<u8> = (0..rows)
        .rev()
        .flat_map(|row| {
            s.intensities[row * frames..(row + 1) * frames].iter().flat_map(|&intensity| colour(intensity))
        })
        .collect();
    let mut encoder = png::Encoder::new(&mut bytes, s.frames, s.rows);
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_depth(png::BitDepth::Eight);
    let written = encoder.write_header().and_then(|mut writer| writer.write_image_data(&pixels));
    if written.is_ok() { bytes } else { Vec::new() }
}

/// An image as a data address.
pub(super) fn data(png: &[u8]) -> String {
    format!("data:image/png;base64,{}", base64::engine::general_purpose::STANDARD.encode(png))
}

/// The colour ramp as an image, brightest on top.
fn ramp() -> Vec<u8> {
    let intensities = (0..=255).collect();
    let (rows, frames) = (256, 1);
    png(&Spectrogram {
        title: String::new(),
        rows,
        frames,
        first_row_hz: 0.0,
        row_hz: 1.0,
        frame_s: 1.0,
        carrier_hz: 1.0,
        range_db: 0.0,
        intensities,
    })
}

/// Where the image of a page's picture stands: x, y, width, height.
pub const IMAGE: (f64, f64, f64, f64) = (56.0, 8.0, 204.0, 196.0);

const PAGE: Medium = Medium { width: 352.0, height: 250.0, font: 11.0, left: 0.0, bottom: 0.0, mm: 0.0 };

/// An axis beside the image: its label, its ends, and the decimals of its ticks.
struct Side {
    label: &'static str,
    low: f64,
    high: f64,
    decimals: i32,
}

/// The picture with its axes and colour bar; empty for an empty spectrogram.
pub fn svg(s: &Spectrogram, medium: Medium) -> String {
    let high = s.first_row_hz + s.row_hz * f64::from(s.rows);
    let left = Side { label: "Doppler (Hz)", low: s.first_row_hz, high, decimals: 0 };
    // an axis of radial speeds on the right
    let (low, high) = (radial_speed(s, left.low), radial_speed(s, high));
    let right = Side { label: "radial speed (m/s)", low, high, decimals: 1 };
    drawn(s, &format!("Spectrogram: {}", s.title), &left, Some(&right), medium)
}

/// The radial speed of a Doppler shift, in m/s: f = 2 v / lambda.
pub(super) fn radial_speed(s: &Spectrogram, hz: f64) -> f64 {
    hz * crate::scenario::SPEED_OF_LIGHT / (2.0 * s.carrier_hz)
}

/// The colour bar of a spectrogram from a corner on, with its numbers on the right.
pub(super) fn colour_bar(s: &Spectrogram, (x, top): (f64, f64), height: f64) -> String {
    let (low, decibels) = (number(-s.range_db), number(-s.range_db / 2.0));
    format!(
        "<g class=\"colour-bar\"><image href=\"{}\" x=\"{x}\" y=\"{top}\" width=\"10\" height=\"{height}\" preserveAspectRatio=\"none\"/>\
         <text x=\"{}\" y=\"{}\" text-anchor=\"end\">dB</text><text x=\"{right}\" y=\"{}\">0</text>\
         <text x=\"{right}\" y=\"{}\">{decibels}</text><text x=\"{right}\" y=\"{}\">{low}</text></g>",
        data(&ramp()),
        x + 33.0,
        top - 12.0,
        top + 6.0,
        top + height / 2.0 + 4.0,
        top + height,
        right = x + 13.0,
    )
}

/// A range-time picture, rows from `low_m` to `high_m`.
pub fn range_time(s: &Spectrogram, low_m: f64, high_m: f64, medium: Medium) -> String {
    let left = Side { label: "range (m)", low: low_m, high: high_m, decimals: 2 };
    drawn(s, &format!("Range over time: {}", s.title), &left, None, medium)
}

fn drawn(s: &Spectrogram, title: &str, left: &Side, right: Option<&Side>, medium: Medium) -> String {
    let bytes = png(s);
    if bytes.is_empty() {
        return String::new();
    }
    let seconds = s.frame_s * f64::from(s.frames);
    let (x, y, width, height) = IMAGE;
    let mut svg = format!(
        "<svg {}><title>{}</title>\
         <image href=\"{}\" x=\"{x}\" y=\"{y}\" width=\"{width}\" height=\"{height}\" preserveAspectRatio=\"none\" \
         style=\"image-rendering:pixelated\"/>\
         <text class=\"axis-y\" transform=\"translate(12 106) rotate(-90)\" text-anchor=\"middle\">{}</text>\
         <text class=\"axis-x\" x=\"158\" y=\"238\" text-anchor=\"middle\">{}</text>",
        medium.root(250.0),
        escape(title),
        data(&bytes),
        left.label,
        // a frame of a spectrogram lies at its window's first slot
        if right.is_some() { "start of window (s)" } else { "time (s)" },
    );
    if let Some(Side { label, .. }) = right {
        let _ = write!(
            svg,
            "<text transform=\"translate(310 106) rotate(-90)\" text-anchor=\"middle\">{label}</text>"
        );
    }
    for k in 0..=4 {
        let share = f64::from(k) / 4.0;
        let at = y + (1.0 - share) * height;
        let value = |side: &Side| {
            // as many decimals as make the ticks differ
            let step = (side.high - side.low) / 4.0;
            let decimals = (0.75 - step.abs().max(1e-9).log10()).ceil() as i32;
            let digits = 10_f64.powi(side.decimals.max(decimals));
            number(((side.low + share * (side.high - side.low)) * digits).round() / digits)
        };
        let (time, across) = (number((share * seconds * 100.0).round() / 100.0), x + share * width);
        let anchor = ["start", "middle", "middle", "middle", "end"][k as usize];
        let _ = write!(
            svg,
            "<path d=\"M{:.1} {at:.1}h4M{:.1} {at:.1}h4M{across:.1} {:.1}v4\" stroke=\"var(--ink,#222)\"/>\
             <text x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"end\">{}</text>",
            x - 4.0,
            x + width,
            y + height,
            x - 6.0,
            at + 4.0,
            value(left),
        );
        if let Some(right) = right {
            let _ = write!(
                svg,
                "<text x=\"{:.1}\" y=\"{:.1}\">{}</text>",
                x + width + 6.0,
                at + 4.0,
                value(right)
            );
        }
        let _ = write!(
            svg,
            "<text x=\"{across:.1}\" y=\"{:.1}\" text-anchor=\"{anchor}\">{time}</text>",
            y + height + 16.0,
        );
    }
    svg + &colour_bar(s, (318.0, 34.0), 144.0) + "</svg>"
}

/// A figure element with the picture and its title; nothing for an empty spectrogram.
pub fn figure(s: &Spectrogram) -> Markup {
    let picture = svg(s, PAGE);
    html! {
        @if !picture.is_empty() {
            figure.spectrogram { (PreEscaped(picture)) figcaption { (s.title) } }
        }
    }
}
