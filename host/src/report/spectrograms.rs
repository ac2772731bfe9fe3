//! Spectrograms as images with axes.
//!
//! Intensities through a perceptual ramp from black over violet and orange to light yellow.

use super::plot::{escape, number};
use crate::results::Spectrogram;
use base64::Engine;

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

fn colour(intensity: u8) -> [u8; 3] {
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
    if rows == 0 || frames == 0 || s.grey.len() < rows * frames {
        return bytes;
    }
    let pixels: Vec<u8> = (0..rows)
        .rev()
        .flat_map(|row| {
            s.grey[row * frames..(row + 1) * frames].iter().flat_map(|&intensity| colour(intensity))
        })
        .collect();
    let mut encoder = png::Encoder::new(&mut bytes, s.frames, s.rows);
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_depth(png::BitDepth::Eight);
    let written = encoder.write_header().and_then(|mut writer| writer.write_image_data(&pixels));
    if written.is_ok() { bytes } else { Vec::new() }
}

/// The picture with its axes; empty for an empty spectrogram.
pub fn svg(s: &Spectrogram) -> String {
    let bytes = png(s);
    if bytes.is_empty() {
        return String::new();
    }
    let data = base64::engine::general_purpose::STANDARD.encode(bytes);
    let top = s.first_row_hz + s.row_hz * f64::from(s.rows);
    let seconds = s.frame_s * f64::from(s.frames);
    // 2 v / lambda: an axis of radial speeds on the right
    let speed =
        |hz: f64| number((hz * crate::scenario::SPEED_OF_LIGHT / (2.0 * s.carrier_hz) * 10.0).round() / 10.0);
    format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 320 250\" role=\"img\" font-size=\"12\" \
         font-family=\"system-ui,sans-serif\" fill=\"var(--ink,#222)\"><title>Spectrogram: {}</title>\
         <image href=\"data:image/png;base64,{data}\" x=\"48\" y=\"8\" width=\"232\" height=\"200\" \
         preserveAspectRatio=\"none\" style=\"image-rendering:pixelated\"/>\
         <text x=\"44\" y=\"18\" text-anchor=\"end\">{}</text><text x=\"44\" y=\"208\" text-anchor=\"end\">{}</text>\
         <text transform=\"translate(14 108) rotate(-90)\" text-anchor=\"middle\">Doppler (Hz)</text>\
         <text x=\"48\" y=\"224\">0</text><text x=\"280\" y=\"224\" text-anchor=\"end\">{}</text>\
         <text x=\"284\" y=\"18\">{}</text><text x=\"284\" y=\"208\">{}</text>\
         <text transform=\"translate(314 108) rotate(-90)\" text-anchor=\"middle\">radial speed (m/s)</text>\
         <text x=\"164\" y=\"240\" text-anchor=\"middle\">time (s)</text></svg>",
        escape(&s.title),
        number(top.round()),
        number(s.first_row_hz.round()),
        number((seconds * 100.0).round() / 100.0),
        speed(top),
        speed(s.first_row_hz),
    )
}

/// A figure element with the picture and its title.
pub fn figure(s: &Spectrogram) -> String {
    let picture = svg(s);
    if picture.is_empty() {
        return picture;
    }
    format!("<figure class=\"spectrogram\">{picture}<figcaption>{}</figcaption></figure>", escape(&s.title))
}
