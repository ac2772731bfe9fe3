//! Figures for a paper: every picture as SVG that stands alone, as PDF and as PNG of 600 dpi, at a journal's column width.
//!
//! What a browser resolves is resolved here: no CSS variable is left in a file. Text is set in DejaVu Sans, which is part of this
//! program and is embedded in SVG and PDF, so that figures depend on no machine's fonts.

mod font;
mod pdf;

use super::plot::Medium;
use super::{confusion, figures, spectrograms, timeline};
use crate::error::Failure;
use crate::results::{Figures, Run};
use crate::store::output::Output;
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use resvg::tiny_skia::{Color, Pixmap, Transform};
use resvg::usvg::{Options, Tree};
use std::path::Path;

/// Dots of a PNG to the inch.
const DPI: f32 = 600.0;
/// CSS pixels to the inch.
const CSS: f32 = 96.0;

/// Why a picture could not be rendered.
#[derive(Debug, thiserror::Error)]
pub enum PaperError {
    /// It is not SVG.
    #[error("figure {name}: {source}")]
    Svg {
        /// The picture.
        name: String,
        /// What the reader of SVG says.
        source: resvg::usvg::Error,
    },
    /// It is too large, or cannot be encoded.
    #[error("figure {name}: {reason}")]
    Draw {
        /// The picture.
        name: String,
        /// What is wrong with it.
        reason: String,
    },
}

/// Every figure of a run: file names and bytes.
///
/// # Errors
///
/// [`PaperError`] names the figure.
pub fn files(run: &Run, found: &Figures) -> Result<Vec<(String, Vec<u8>)>, PaperError> {
    let c = &found.calibration;
    let region = figures::region(&run.region, &run.operating_point, &found.cases, &found.prediction.points);
    let period_s = run.operating_point.period_s;
    let mut all = vec![
        ("region".to_owned(), region.svg(Medium::SINGLE)),
        (
            "learning-curve".to_owned(),
            figures::learning_curve(&found.prediction, &run.accuracy).svg(Medium::SINGLE),
        ),
        ("training-loss".to_owned(), figures::losses(found).svg(Medium::SINGLE)),
        ("intensities".to_owned(), figures::pmf(c).svg(Medium::SINGLE)),
        ("timeline".to_owned(), timeline::svg(&run.schedule.timeline, period_s)),
    ];
    if !c.curve.is_empty() {
        all.push(("kl-curve".to_owned(), figures::kl_curve(c).svg(Medium::SINGLE)));
    }
    for s in &found.spectrograms {
        // a title is any text, and a file's name is not
        let title = s.title.replace(|c: char| !c.is_alphanumeric() && c != '_', "-");
        all.push((format!("spectrogram-{title}"), spectrograms::svg(s, Medium::SINGLE)));
    }
    for sensing_slots in confusion::slots(found) {
        all.push((format!("confusion-{sensing_slots}"), confusion::svg(found, sensing_slots)));
    }
    let mut files = Vec::new();
    for (name, svg) in all {
        files.extend(forms(&name, &svg)?);
    }
    Ok(files)
}

/// A kind of file that a picture is written as.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Form {
    /// 600 dots to the inch.
    Png,
    /// One page, its font embedded.
    Pdf,
    /// Its font embedded.
    Svg,
}

impl Form {
    const ALL: [Form; 3] = [Form::Png, Form::Pdf, Form::Svg];

    /// How the names of such files end.
    fn ending(self) -> &'static str {
        match self {
            Form::Png => "png",
            Form::Pdf => "pdf",
            Form::Svg => "svg",
        }
    }

    /// The kind that a file's name ends with.
    pub fn of(file: &Path) -> Option<Form> {
        let ending = file.extension()?.to_str()?.to_ascii_lowercase();
        Self::ALL.into_iter().find(|form| form.ending() == ending)
    }
}

/// A picture as SVG, PDF and PNG: file names and bytes.
///
/// # Errors
///
/// [`PaperError`] names it.
pub fn forms(name: &str, svg: &str) -> Result<[(String, Vec<u8>); 3], PaperError> {
    let drawn = Drawn::new(name, svg)?;
    let [png, pdf, svg] = Form::ALL;
    let file = |form: Form| Ok((format!("{name}.{}", form.ending()), drawn.bytes(form)?));
    Ok([file(png)?, file(pdf)?, file(svg)?])
}

/// A picture as one kind of file.
///
/// # Errors
///
/// [`PaperError`] names it.
pub fn form(name: &str, svg: &str, form: Form) -> Result<Vec<u8>, PaperError> {
    Drawn::new(name, svg)?.bytes(form)
}

/// A picture that stands alone, and what its files are made of.
struct Drawn<'a> {
    name: &'a str,
    svg: String,
    tree: Tree,
    letters: font::Subset,
}

impl<'a> Drawn<'a> {
    fn new(name: &'a str, svg: &str) -> Result<Self, PaperError> {
        let whole = dejavu::sans::regular();
        let mut options = Options { font_family: font::FAMILY.into(), dpi: CSS, ..Options::default() };
        let fonts = options.fontdb_mut();
        fonts.load_font_data(whole.to_vec());
        fonts.set_sans_serif_family(font::FAMILY);
        let svg = on_white(svg);
        let tree =
            Tree::from_str(&svg, &options).map_err(|source| PaperError::Svg { name: name.into(), source })?;
        let letters = font::subset(whole, &text(&svg), &pdf::glyphs(&tree));
        Ok(Drawn { name, svg, tree, letters })
    }

    fn bytes(&self, form: Form) -> Result<Vec<u8>, PaperError> {
        Ok(match form {
            Form::Png => png(self.name, &self.tree)?,
            Form::Pdf => pdf::pdf(self.name, &self.tree, &self.letters)?,
            Form::Svg => with_font(&self.svg, &self.letters.bytes).into_bytes(),
        })
    }
}

/// Writes a picture in every form.
///
/// # Errors
///
/// [`PaperError`] names it; a folder that cannot be written.
pub fn draw(output: &Output, name: &str, svg: &str) -> Result<(), Failure> {
    for (file, bytes) in forms(name, svg)? {
        output.write(&file, &bytes)?;
    }
    Ok(())
}

/// A picture that stands alone: on white, every CSS variable replaced by its fallback.
pub fn on_white(svg: &str) -> String {
    let svg = svg.replacen("</title>", "</title><rect width=\"100%\" height=\"100%\" fill=\"#fff\"/>", 1);
    let mut parts = svg.split('<');
    let mut plain = parts.next().unwrap_or_default().to_owned();
    for part in parts {
        // a variable stands in a tag or in a style; between tags the same letters are text
        let (tag, text) = part.split_at(part.find('>').unwrap_or(part.len()));
        plain += "<";
        plain += &resolved(tag);
        plain += &if tag == "style" { resolved(text) } else { text.to_owned() };
    }
    plain
}

/// Every CSS variable replaced by its fallback.
fn resolved(markup: &str) -> String {
    let mut parts = markup.split("var(--");
    let mut plain = parts.next().unwrap_or_default().to_owned();
    for part in parts {
        let (variable, rest) = part.split_once(')').unwrap_or((part, ""));
        plain += variable.split_once(',').map_or("none", |(_, fallback)| fallback);
        plain += rest;
    }
    plain
}

/// All that stands between tags.
fn text(svg: &str) -> String {
    let between = svg.split('>').filter_map(|part| part.split('<').next());
    between
        .collect::<String>()
        .replace("&lt;", "<")
        .replace("&gt;", ">")
        .replace("&#39;", "'")
        .replace("&quot;", "\"")
        + "&"
}

/// The picture with its font.
fn with_font(svg: &str, font: &[u8]) -> String {
    let face = format!(
        "</title><style>@font-face{{font-family:'{}';src:url(data:font/ttf;base64,{})}}</style>",
        font::FAMILY,
        STANDARD.encode(font)
    );
    svg.replacen("</title>", &face, 1)
}

fn png(name: &str, tree: &Tree) -> Result<Vec<u8>, PaperError> {
    let failed = |reason: String| PaperError::Draw { name: name.into(), reason };
    let scale = DPI / CSS;
    let side = |length: f32| (length * scale).ceil() as u32;
    let size = tree.size();
    let (width, height) = (side(size.width()), side(size.height()));
    let mut pixels =
        Pixmap::new(width, height).ok_or_else(|| failed("it has no area, or too much".into()))?;
    // the last row and column may be covered in part
    pixels.fill(Color::WHITE);
    resvg::render(tree, Transform::from_scale(scale, scale), &mut pixels.as_mut());
    let rgb: Vec<u8> = pixels.pixels().iter().flat_map(|p| [p.red(), p.green(), p.blue()]).collect();
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, width, height);
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_depth(png::BitDepth::Eight);
    let per_metre = (DPI / 0.0254).round() as u32;
    encoder.set_pixel_dims(Some(png::PixelDimensions {
        xppu: per_metre,
        yppu: per_metre,
        unit: png::Unit::Meter,
    }));
    let written = encoder.write_header().and_then(|mut writer| writer.write_image_data(&rgb));
    written.map_err(|error| failed(error.to_string()))?;
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeMap;

    fn drawn(fill: &str, words: &str) -> [(String, Vec<u8>); 3] {
        let svg = format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 40 20\" width=\"40mm\" height=\"20mm\" \
             font-family=\"'DejaVu Sans'\"><title>t</title><text x=\"2\" y=\"15\" font-size=\"12\" fill=\"{fill}\">{words}</text></svg>"
        );
        forms("t", &svg).unwrap()
    }

    #[test]
    fn files_stand_alone_and_text_is_drawn() {
        let [(_, png), (_, pdf), (_, svg)] = drawn("var(--ink,#222)", "Afié");
        let svg = String::from_utf8(svg).unwrap();
        assert!(
            svg.contains("fill=\"#222\"") && !svg.contains("var(") && svg.contains("@font-face"),
            "{svg}"
        );
        assert!(pdf.starts_with(b"%PDF") && pdf.windows(9).any(|w| w == b"FontFile2"));
        let pixels = Pixmap::decode_png(&png).unwrap();
        let dark = |pixels: &Pixmap| pixels.pixels().iter().filter(|p| p.red() < 100).count();
        assert_eq!((pixels.width(), pixels.height()), (945, 473));
        assert!(dark(&pixels) > 1000);
        let [(_, empty), ..] = drawn("#222", "");
        assert_eq!(dark(&Pixmap::decode_png(&empty).unwrap()), 0);
        assert!(forms("t", "<svg").unwrap_err().to_string().contains("figure t"));
    }

    #[test]
    fn text_like_a_variable_stays_text() {
        let svg = "<svg><title>t</title><style>a{fill:var(--a,#111)}</style><text fill=\"var(--b,#222)\">var(--c,d)</text></svg>";
        let drawn = on_white(svg);
        for part in ["a{fill:#111}</style>", "<text fill=\"#222\">var(--c,d)</text></svg>", "fill=\"#fff\"/>"]
        {
            assert!(drawn.contains(part), "{part} is not in: {drawn}");
        }
    }

    #[test]
    fn the_reduced_font_draws_the_same() {
        // é is made of parts
        let svg = "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 60 20\" width=\"60mm\" height=\"20mm\"><title>t</title>\
             <rect width=\"60\" height=\"20\" fill=\"#fff\"/><text x=\"2\" y=\"15\" font-size=\"12\" font-family=\"DejaVu Sans\">σé8−g</text></svg>";
        let letters = font::subset(dejavu::sans::regular(), "σé8−g", &BTreeMap::new());
        assert!(letters.bytes.len() < 6000, "{}", letters.bytes.len());
        let render = |bytes: Vec<u8>| {
            let mut options = Options::default();
            options.fontdb_mut().load_font_data(bytes);
            png("t", &Tree::from_str(svg, &options).unwrap()).unwrap()
        };
        let whole = render(dejavu::sans::regular().to_vec());
        assert!(whole != render(font::subset(dejavu::sans::regular(), "σé8−", &BTreeMap::new()).bytes));
        assert!(whole == render(letters.bytes));
    }
}
