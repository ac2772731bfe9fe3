//! The explorer: the script of the report page and the data it reads.
//!
//! Every file beside this one has one reason: `data` reads the JSON, `marks` makes elements, `cursor` lets pointer and keyboard
//! move along a plot, `wasi` runs a program, `workers` runs it beside the page, `retest` tests the
//! networks at another rho, and a file each for the panels. They are joined to one script in a scope of its own. The page's policy
//! allows this script by its hash and nothing else: no request, no other script.

use super::Live;
use super::plot::COLOURS;
use crate::results::{Figures, Run};
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use maud::{Markup, PreEscaped, html};
use serde::Serialize;
use sha2::{Digest, Sha256};

/// The script's files in the order of their use.
const FILES: [&str; 15] = [
    include_str!("data.js"),
    include_str!("marks.js"),
    include_str!("cursor.js"),
    include_str!("slots.js"),
    include_str!("region.js"),
    include_str!("gallery.js"),
    include_str!("calibration.js"),
    include_str!("learning.js"),
    include_str!("confusion.js"),
    include_str!("tables.js"),
    include_str!("wasi.js"),
    include_str!("workers.js"),
    include_str!("live.js"),
    include_str!("retest.js"),
    include_str!("links.js"),
];

fn script() -> String {
    format!("\"use strict\";(()=>{{\n{}}})();\n", FILES.concat())
}

/// The page's policy: this script, styles in the page, pictures in the page, and no address at all.
/// A page that computes may also compile the program in it, and run it in workers that the script makes.
pub fn policy(live: bool) -> Markup {
    let hash = STANDARD.encode(Sha256::digest(script()));
    let compiled = if live { " 'wasm-unsafe-eval'; worker-src blob:" } else { "" };
    let rules = format!(
        "default-src 'none'; img-src data:; style-src 'unsafe-inline'; script-src 'sha256-{hash}'{compiled}; base-uri 'none'; \
         form-action 'none'"
    );
    html! { meta http-equiv="Content-Security-Policy" content=(rules); }
}

/// Colours of the series as CSS variables.
pub fn colours() -> String {
    let each = COLOURS.iter().enumerate().map(|(k, colour)| format!("--series-{k}:{colour};"));
    format!(":root{{{}}}", each.collect::<String>())
}

/// The data and the script, at the page's end.
pub fn embedded(run: &Run, figures: &Figures, live: Option<&Live>) -> Markup {
    html! { (json("run", run)) (json("figures", figures)) @if let Some(live) = live { (json("live", live)) } script { (PreEscaped(script())) } }
}

/// A result as a data block; `<` is escaped as JSON does it, so that nothing in it ends the block.
fn json(name: &str, value: &impl Serialize) -> Markup {
    let text = serde_json::to_string(value).unwrap_or_default().replace('<', "\\u003c");
    html! { script type="application/json" id={ "data-" (name) } { (PreEscaped(text)) } }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_address_stands_in_the_script_and_no_data_ends_its_block() {
        let script = script().replace("http://www.w3.org/2000/svg", "");
        for address in ["://", "fetch(", "XMLHttpRequest", "import(", "WebSocket", "innerHTML", "eval("] {
            assert!(!script.contains(address), "{address}");
        }
        assert!(!script.contains("</script"));
        let block = json("x", &"</script><script>").into_string();
        assert_eq!(block.matches("<script").count() + block.matches("</script").count(), 2, "{block}");
    }
}
