//! Any text stays a text: no name, folder, option or message becomes an option of sbatch, a command of the shell, a field of a manifest, an
//! element of a page or picture, a cell or formula of a table, or a command to the terminal.
//!
//! The first byte says where the text goes; the others are its characters, those from 128 on a fragment of [`SYNTAX`] each. A
//! third-party parser reads what the host writes, and must find the same structure as with [`MARK`] in the text's place.
#![no_main]

use libfuzzer_sys::fuzz_target;
use sdp3::experiments::sweep::plan::Sweep;
use sdp3::experiments::sweep::{kubernetes, slurm};
use sdp3::formats::table;
use sdp3::report;
use sdp3::results::{Figures, Merged, Run};
use sdp3::scenario::Scenario;
use sdp3::store::output::Output;
use sdp3::text::{printable_json, shown};
use sdp3_fuzz::files::{Folder, place};
use sdp3_fuzz::parsed::{self, Parts, same_but_for};
use std::path::Path;
use std::sync::LazyLock;

/// The placeholder: a text without any syntax.
const MARK: &str = "MARK";

/// Fragments of the syntax of shells, sbatch, YAML, TOML, HTML, SVG, CSV and terminals, and invisible characters.
const SYNTAX: [&str; 64] = [
    "\n#SBATCH ",
    "--wrap=reboot",
    "hetjob",
    "packjob",
    "%a",
    "%%",
    "'",
    "\"",
    "\\",
    "`reboot`",
    "$(reboot)",
    "${HOME}",
    "; reboot",
    " && ",
    " | ",
    "<<EOF\n",
    "\r\n",
    "\r",
    "\u{85}",
    "\u{2028}",
    "\u{2029}",
    "\n---\n",
    "\n...\n",
    "\nkind: Pod",
    ": ",
    " #",
    "- ",
    "{",
    "}",
    "[",
    "]",
    "&a ",
    "*a",
    "!!str ",
    "\"\"\"",
    "'''",
    "</script>",
    "<script>",
    "</title>",
    "</style>",
    "</svg>",
    "<svg onload=reboot>",
    "<!--",
    "-->",
    "<![CDATA[",
    "]]>",
    "&lt;",
    "&#60;",
    "href=\"javascript:reboot\"",
    "var(--ink,#222)",
    "\u{fffe}",
    "\0",
    ",",
    "=1+1",
    "@SUM(A1)",
    "\u{ff1d}1",
    "-",
    "+",
    "\u{1b}[2J",
    "\u{9b}2J",
    "\u{1b}]0;a\u{7}",
    "\u{202e}",
    "\u{200b}",
    "\u{e0041}",
];

/// The text of some bytes.
fn text_of(bytes: &[u8]) -> String {
    let mut text = String::new();
    for byte in bytes {
        match byte {
            0..128 => text.push(char::from(*byte)),
            _ => text += SYNTAX[usize::from(byte % 64)],
        }
    }
    text
}

/// A folder of one name, which may be any text; nothing for what is no name.
fn folder(text: &str) -> Option<Output> {
    let name = text.replace(['/', '\0'], "_");
    if matches!(name.as_str(), "" | "." | "..") || name.len() > 200 {
        return None;
    }
    Output::create(&place(".out").join(name)).ok()
}

/// A plan of one cell with the name of its scenario, if that is legal.
fn plan(name: &str) -> Option<Sweep> {
    let name = serde_json::Value::from(name);
    let text = format!("name = \"fuzz\"\nseeds = [1]\nsensing_slots = [200]\n[[scenario]]\nname = {name}\n");
    let folder = Folder::new(&[("named.toml", text.as_bytes())]);
    Sweep::load(&folder.path().join("named.toml"), None, None).ok()
}

fn read(file: &Path) -> String {
    std::fs::read_to_string(file).expect("a file that was written")
}

/// The scripts for a folder and an option of sbatch, as the shell and as sbatch read them.
fn scripts(name: &str, option: &str) -> Option<[Parts; 4]> {
    let output = folder(name)?;
    slurm::write(&NAMED, 1, &[option.to_owned()], &output).ok()?;
    let [sweep, merge] = ["sweep.sbatch", "merge.sbatch"].map(|file| read(&output.folder().join(file)));
    let shell = |script: &str| parsed::shell(script).unwrap_or_else(|error| panic!("{error}: {script}"));
    Some([shell(&sweep), shell(&merge), parsed::sbatch(&sweep), parsed::sbatch(&merge)])
}

/// A plan with a usual name.
static NAMED: LazyLock<Sweep> = LazyLock::new(|| plan("scenario").expect("a legal name"));

/// The manifests of a plan for an image and a claim.
fn manifests(sweep: &Sweep, text: &str) -> Option<[Parts; 2]> {
    let _ = std::fs::remove_dir_all(place(".out"));
    let output = folder("manifests")?;
    kubernetes::write(sweep, 1, (text, text), &output).ok()?;
    let manifest = |file: &str| {
        let text = read(&output.folder().join(file));
        assert_eq!(
            text.lines().count(),
            text.split(['\n', '\r', '\u{85}', '\u{2028}', '\u{2029}']).count() - 1
        );
        parsed::yaml(&text).unwrap_or_else(|error| panic!("{error}: {text}"))
    };
    Some(["sweep.yaml", "merge.yaml"].map(manifest))
}

/// Every string of a result that holds the mark, with a text there.
fn marked(value: &serde_json::Value, text: &str) -> serde_json::Value {
    use serde_json::Value;
    match value {
        Value::String(string) => Value::String(string.replace(MARK, text)),
        Value::Array(list) => list.iter().map(|one| marked(one, text)).collect(),
        Value::Object(map) => map.iter().map(|(key, one)| (key.clone(), marked(one, text))).collect(),
        other => other.clone(),
    }
}

/// A run, its figures and a merged sweep, with the placeholder in every name and sentence.
static RESULTS: LazyLock<[serde_json::Value; 3]> =
    LazyLock::new(|| serde_json::from_str(include_str!("../results.json")).expect("results"));

/// The page of that run; its two blocks of data apart.
fn page(text: &str) -> (Parts, Parts) {
    let [run, figures, _] = &*RESULTS;
    let run: Run = serde_json::from_value(marked(run, text)).expect("a run");
    let figures: Figures = serde_json::from_value(marked(figures, text)).expect("its figures");
    let parts = parsed::html(&report::page(&run, &figures, &format!("name = {text}"), None));
    parts.into_iter().partition(|part| !part.starts_with("text {\""))
}

/// The figures of that sweep, as files of their own.
fn pictures(text: &str) -> Parts {
    let merged: Merged = serde_json::from_value(marked(&RESULTS[2], text)).expect("a merged sweep");
    let standalone = |(_, svg): (String, String)| {
        let svg = report::paper::on_white(&svg);
        parsed::svg(&svg).unwrap_or_else(|error| panic!("{error}: {svg}"))
    };
    report::sweep::pictures(&merged).into_iter().flat_map(standalone).collect()
}

/// As browsers read text: one kind of line break.
fn normalised(text: &str) -> String {
    text.replace("\r\n", "\n").replace('\r', "\n")
}

fn must(result: Result<(), String>, text: &str) {
    if let Err(difference) = result {
        panic!("{text:?} is more than a text: {difference}");
    }
}

fuzz_target!(|data: &[u8]| {
    let Some((&kind, rest)) = data.split_first() else { return };
    let text = &text_of(rest);
    // a page takes ten times as long as a table
    let kind = if kind % 16 == 12 { 6 } else { kind % 8 };
    match kind {
        0 => {
            static PLAIN: LazyLock<[Parts; 4]> = LazyLock::new(|| scripts(MARK, "--x=y").expect("scripts"));
            let _ = std::fs::remove_dir_all(place(".out"));
            let plain = &*PLAIN;
            let Some(found) = scripts(text, "--x=y") else { return };
            // a path is a word of the shell as it is, and of sbatch with its signs of percent twice
            let name = text.replace(['/', '\0'], "_");
            let twice = name.replace('%', "%%");
            for (plain, found) in plain.iter().zip(&found) {
                must(same_but_for(MARK, &[&name, &twice], plain, found), text);
            }
        }
        1 => {
            static PLAIN: LazyLock<[Parts; 4]> =
                LazyLock::new(|| scripts("options", "--x=y").expect("scripts"));
            let plain = &*PLAIN;
            let Some(found) = scripts("options", text) else { return };
            // an option may be several words, of one line
            for (plain, found) in plain.iter().zip(&found) {
                let ends = |parts: &Parts| parts.iter().filter(|part| *part == "line").count();
                assert_eq!(ends(plain), ends(found), "{text:?} is more than one option");
                assert!(!found.iter().any(|part| part == "component"), "{text:?} begins another component");
                let before = plain.iter().zip(found).take_while(|(plain, found)| plain == found).count();
                let options = plain.iter().position(|part| part == "--x=y").unwrap_or(plain.len());
                assert_eq!(before.min(options), options, "{text:?} changes what stands before it");
            }
        }
        2 => {
            static PLAIN: LazyLock<[Parts; 2]> =
                LazyLock::new(|| manifests(&NAMED, MARK).expect("manifests"));
            let found = manifests(&NAMED, text).expect("any image and claim");
            for (plain, found) in PLAIN.iter().zip(&found) {
                must(same_but_for(MARK, &[text], plain, found), text);
            }
            let Some(sweep) = plan(text) else { return };
            let named = manifests(&sweep, MARK).expect("a legal name");
            assert_eq!(named[0].len(), PLAIN[0].len(), "{text:?} is more than a name");
            let toml = named[0].iter().find(|part| part.contains("[[scenario]]")).expect("the plan");
            let plan: serde_json::Value =
                basic_toml::from_str(toml.trim_start_matches("scalar ")).expect("TOML");
            assert_eq!(plain_name(&plan["scenario"][0]), text);
        }
        3 => {
            let scenario = Scenario { name: text.clone(), ..Scenario::default() };
            let toml = scenario.to_toml();
            let parsed: serde_json::Value =
                basic_toml::from_str(&toml).unwrap_or_else(|error| panic!("{error}: {toml}"));
            assert_eq!(plain_name(&parsed), text);
            static KEYS: LazyLock<serde_json::Value> =
                LazyLock::new(|| basic_toml::from_str(&Scenario::default().to_toml()).expect("TOML"));
            let unnamed = |value: &serde_json::Value| {
                let mut value = value.clone();
                value["name"] = "".into();
                value
            };
            assert_eq!(unnamed(&parsed), unnamed(&KEYS));
        }
        4 => {
            static PLAIN: LazyLock<(Parts, Parts)> = LazyLock::new(|| page(MARK));
            // HTML has no way to write it
            let text = &text.replace('\0', "");
            let (parts, data) = page(text);
            must(
                same_but_for(
                    MARK,
                    &[&normalised(text), &shown(&normalised(text)), &shown(text)],
                    &PLAIN.0,
                    &parts,
                ),
                text,
            );
            assert_eq!(data.len(), 2);
            for (block, value) in data.iter().zip(&*RESULTS) {
                let block = block.trim_start_matches("text ");
                let read: tinyjson::JsonValue =
                    block.parse().unwrap_or_else(|error| panic!("{error}: {block}"));
                let expected: tinyjson::JsonValue = marked(value, text).to_string().parse().expect("JSON");
                let lost: Vec<String> =
                    strings_of(&expected).difference(&strings_of(&read)).cloned().collect();
                assert!(lost.is_empty(), "{lost:?} are not in the data");
            }
        }
        5 => {
            static PLAIN: LazyLock<Parts> = LazyLock::new(|| pictures(MARK));
            must(
                same_but_for(MARK, &[&normalised(&shown(text)), &shown(text)], &PLAIN, &pictures(text)),
                text,
            );
        }
        6 => {
            let row = [text.clone(), "1".into(), text.clone()];
            let found = parsed::csv(&table::csv(&["a", text, "c"], [row.to_vec()]));
            let cells = ["a", text, "c", "row", text, "1", text, "row"];
            assert_eq!(found.len(), cells.len(), "{text:?} is more than a cell");
            for (cell, found) in cells.iter().zip(&found) {
                assert!(cell == found || found.strip_prefix('\'') == Some(cell), "{found:?} for {cell:?}");
                assert!(!parsed::is_formula(found), "{text:?} is a formula");
            }
        }
        _ => {
            let json = serde_json::Value::from(text.as_str()).to_string();
            let json = printable_json(&json);
            let read: tinyjson::JsonValue = json.parse().unwrap_or_else(|error| panic!("{error}: {json}"));
            assert_eq!(read.get::<String>(), Some(text));
            // what is not seen beyond U+FFFF stays in JSON
            let seen: String = json.chars().filter(|c| *c <= '\u{ffff}').collect();
            for shown in [&*shown(text), &seen] {
                if let Some(done) = parsed::terminal(shown) {
                    panic!("a terminal {done} for {text:?}");
                }
            }
        }
    }
});

fn plain_name(scenario: &serde_json::Value) -> &str {
    scenario["name"].as_str().expect("a name")
}

fn strings_of(value: &tinyjson::JsonValue) -> std::collections::BTreeSet<String> {
    use tinyjson::JsonValue;
    match value {
        JsonValue::String(text) => [text.clone()].into(),
        JsonValue::Array(list) => list.iter().flat_map(strings_of).collect(),
        JsonValue::Object(map) => map.values().flat_map(strings_of).collect(),
        _ => Default::default(),
    }
}
