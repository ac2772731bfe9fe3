//! The gallery: spectrograms of every class at every carrier under every channel model, on one page.

use super::plot::escape;
use super::{STYLE, spectrograms};
use crate::results::GallerySpectrogram;
use std::fmt::Write;

/// What to look for under a model.
fn caption(model: &str) -> &'static str {
    match model {
        "dahc" => {
            "Limbs around the torso's line in the rhythm of the gait, over the noise of the room's random response."
        }
        "primitive" => "The same without uncertainty: a clean body on black.",
        "ray-tracing" => {
            "The body and its images in the walls: ghosts at other radial speeds, no uncertainty."
        }
        "statistical" => "Rays that fade: a bell around zero; it does not know the person's speed.",
        "80211ay" => "Static clusters: what clutter removal leaves is noise.",
        "80211ax" => "Slow fading of the taps and a bell around zero; it does not know the person's speed.",
        "38901" => {
            "One moving scatterer, seen directly and by way of clusters: the torso's line without limbs."
        }
        "quadriga" => "Scatterers at rest within a segment: a line at zero and steps between segments.",
        "metis" => "A traced map with resting objects: people move as shadows on its ways alone.",
        _ => "",
    }
}

pub fn page(exhibits: &[GallerySpectrogram]) -> String {
    let mut page = format!(
        "<!doctype html><html lang=\"en\"><head><meta charset=\"utf-8\"><meta name=\"viewport\" \
         content=\"width=device-width,initial-scale=1\"><title>sdp3: gallery</title><style>{STYLE}</style></head><body>\
         <header><h1>Gallery</h1><p>One or two seconds of each class, clutter removed, through the radar module's own front end: \
         every channel model at 3.5, 24 and 60 GHz. Doppler on the left, radial speed on the right; towards the radar is up \
         (positive).</p></header><main>"
    );
    let mut shown = "";
    for exhibit in exhibits {
        if exhibit.model != shown {
            if !shown.is_empty() {
                page.push_str("</div></section>");
            }
            shown = &exhibit.model;
            let name = escape(shown);
            let _ = write!(
                page,
                "<section id=\"{name}\"><h2>{name}</h2><p>{}</p><div class=\"gallery\">",
                caption(shown)
            );
        }
        page.push_str(&spectrograms::figure(&exhibit.spectrogram));
    }
    page.push_str("</div></section></main></body></html>\n");
    page
}
