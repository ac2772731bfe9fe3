//! The gallery: spectrograms of every class at every carrier under every channel model, on one page.

use super::{STYLE, spectrograms};
use crate::results::GallerySpectrogram;
use maud::{DOCTYPE, PreEscaped, html};

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
    let page = html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                meta name="viewport" content="width=device-width,initial-scale=1";
                title { "sdp3: gallery" }
                style { (PreEscaped(STYLE)) }
            }
            body {
                header {
                    h1 { "Gallery" }
                    p {
                        "One or two seconds of each class, clutter removed, through the radar module's own front end: every \
                         channel model at 3.5, 24 and 60 GHz. Doppler on the left, radial speed on the right; towards the \
                         radar is up (positive)."
                    }
                }
                main {
                    @for of_model in exhibits.chunk_by(|a, b| a.model == b.model) {
                        @let model = &of_model[0].model;
                        section id=(model) {
                            h2 { (model) }
                            p { (caption(model)) }
                            div.gallery { @for exhibit in of_model { (spectrograms::figure(&exhibit.spectrogram)) } }
                        }
                    }
                }
            }
        }
    };
    page.into_string() + "\n"
}
