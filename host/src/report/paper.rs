//! Figures for a paper: every picture as SVG that stands alone, and as PNG.
//!
//! What a browser resolves is resolved here: no CSS variable is left in a file. PNGs are rendered in DejaVu Sans, which is part of
//! this program, so their bytes depend on no machine's fonts.

use super::plot::on_white;
use super::{confusion, figures, spectrograms, timeline};
use crate::results::{Figures, Run};
use resvg::tiny_skia::{Pixmap, Transform};
use resvg::usvg::{Options, Tree};

/// Pixels of a PNG for each unit of its SVG: 1920 for 640, which is 300 dpi over a column and a half.
const SCALE: f32 = 3.0;

/// Why a picture could not be rendered.
#[derive(Debug, thiserror::Error)]
pub enum PaperError {
    /// It is not SVG.
    #[error("figure {name}: {source}")]
    Svg {
        /// Its name.
        name: String,
        /// What is wrong.
        source: resvg::usvg::Error,
    },
    /// It is too large, or cannot be encoded.
    #[error("figure {name}: {reason}")]
    Png {
        /// Its name.
        name: String,
        /// What is wrong.
        reason: String,
    },
}

/// Every figure of a run as SVG, by name.
fn svgs(run: &Run, found: &Figures) -> Vec<(String, String)> {
    let c = &found.calibration;
    let mut all = vec![
        ("region".to_owned(), figures::region(run, found).standalone()),
        ("learning-curve".to_owned(), figures::learning_curve(run, found).standalone()),
        ("training-loss".to_owned(), figures::losses(found).standalone()),
        ("grey-levels".to_owned(), figures::pmf(c).standalone()),
        ("timeline".to_owned(), on_white(timeline::svg(&run.schedule.timeline))),
    ];
    if !c.curve.is_empty() {
        all.push(("kl-curve".to_owned(), figures::kl_curve(c).standalone()));
    }
    for s in &found.spectrograms {
        all.push((format!("spectrogram-{}", s.title.replace(' ', "-")), on_white(spectrograms::svg(s))));
    }
    for sensing_slots in confusion::slots(found) {
        let svg = on_white(confusion::svg(found, sensing_slots));
        all.push((format!("confusion-{sensing_slots}"), svg));
    }
    all
}

/// Every figure of a run as SVG and PNG: file names and bytes.
///
/// # Errors
///
/// [`PaperError`] names the figure.
pub fn files(run: &Run, found: &Figures) -> Result<Vec<(String, Vec<u8>)>, PaperError> {
    let mut options = Options { font_family: "DejaVu Sans".into(), ..Options::default() };
    let fonts = options.fontdb_mut();
    fonts.load_font_data(dejavu::sans::regular().to_vec());
    fonts.load_font_data(dejavu::sans::bold().to_vec());
    fonts.set_sans_serif_family("DejaVu Sans");
    let mut files = Vec::new();
    for (name, svg) in svgs(run, found) {
        files.push((format!("{name}.png"), png(&name, &svg, &options)?));
        files.push((format!("{name}.svg"), svg.into_bytes()));
    }
    Ok(files)
}

fn png(name: &str, svg: &str, options: &Options) -> Result<Vec<u8>, PaperError> {
    let tree =
        Tree::from_str(svg, options).map_err(|source| PaperError::Svg { name: name.into(), source })?;
    let failed = |reason: String| PaperError::Png { name: name.into(), reason };
    let side = |length: f32| (length * SCALE).ceil() as u32;
    let size = tree.size();
    let mut pixels = Pixmap::new(side(size.width()), side(size.height()))
        .ok_or_else(|| failed("it has no area, or too much".into()))?;
    resvg::render(&tree, Transform::from_scale(SCALE, SCALE), &mut pixels.as_mut());
    pixels.encode_png().map_err(|error| failed(error.to_string()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_stand_alone_and_text_is_drawn() {
        let text = |fill: &str, words: &str| {
            on_white(format!(
                "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 40 20\"><title>t</title><text x=\"2\" y=\"15\" \
                 font-size=\"12\" fill=\"{fill}\">{words}</text></svg>"
            ))
        };
        let svg = text("var(--ink,#222)", "A");
        assert!(svg.contains("fill=\"#222\"") && !svg.contains("var("), "{svg}");
        let mut options = Options::default();
        options.fontdb_mut().load_font_data(dejavu::sans::regular().to_vec());
        options.font_family = "DejaVu Sans".into();
        let drawn = |svg: &str| Pixmap::decode_png(&png("t", svg, &options).unwrap()).unwrap();
        let dark = |pixels: &Pixmap| pixels.pixels().iter().filter(|p| p.red() < 100).count();
        let letter = drawn(&svg);
        assert_eq!((letter.width(), letter.height()), (120, 60));
        assert!(dark(&letter) > 100, "{}", dark(&letter));
        assert_eq!(dark(&drawn(&text("#222", ""))), 0);
        assert!(png("t", "<svg", &options).unwrap_err().to_string().contains("figure t"));
    }
}
