//! Takes the station's model, and the sensor's registers, from where the environment says. Both paths are absolute.

use std::path::PathBuf;

const MODEL: &str = "SDP3_MODEL must be the path of a model for a BGT60TR13C. The command that makes one:
    sdp3 run --scenario bgt60";
const REGISTERS: &str = "SDP3_BGT60_REGISTERS must be the path of the C header with `register_list` that the vendor's tool exports";

/// A file that a variable names, if it is set.
fn file(variable: &str, what: &str) -> Option<Vec<u8>> {
    println!("cargo:rerun-if-env-changed={variable}");
    let path = PathBuf::from(std::env::var_os(variable)?);
    println!("cargo:rerun-if-changed={}", path.display());
    match std::fs::read(&path) {
        Ok(bytes) => Some(bytes),
        Err(error) => panic!("{}: {error}\n{what}", path.display()),
    }
}

/// The list in braces: hexadecimal numbers, as a Rust slice.
fn list(header: &str) -> Option<String> {
    let (_, rest) = header.split_once("register_list")?;
    let (_, rest) = rest.split_once('{')?;
    let (list, _) = rest.split_once('}')?;
    let words: Option<Vec<u32>> = list
        .split(',')
        .map(str::trim)
        .filter(|word| !word.is_empty())
        .map(|word| u32::from_str_radix(word.strip_prefix("0x")?.trim_end_matches(['U', 'L']), 16).ok())
        .collect();
    words.map(|words| format!("&{words:?}"))
}

/// What a header defines as a name that ends so, without parentheses.
fn defined<'h>(header: &'h str, name: &str) -> Option<&'h str> {
    let mut words = header.lines().find(|line| line.contains(name))?.split_whitespace();
    (words.next() == Some("#define") && words.next()?.ends_with(name))
        .then(|| words.next().unwrap_or_default().trim_matches(['(', ')']))
}

fn main() {
    println!("cargo:rustc-check-cfg=cfg(sdp3_model)");
    let out = PathBuf::from(std::env::var_os("OUT_DIR").expect("cargo sets it"));
    let sensor = std::env::var_os("CARGO_FEATURE_BGT60").is_some();
    match file("SDP3_MODEL", MODEL) {
        Some(model) => {
            std::fs::write(out.join("model.sdp3"), model).expect("OUT_DIR");
            println!("cargo:rustc-cfg=sdp3_model");
        }
        None => assert!(!sensor, "{MODEL}"),
    }
    if !sensor {
        return;
    }
    let header = file("SDP3_BGT60_REGISTERS", REGISTERS).expect(REGISTERS);
    let header = String::from_utf8(header).expect(REGISTERS);
    for (name, wanted) in [("NUM_SAMPLES_PER_CHIRP", "128"), ("NUM_RX_ANTENNAS", "1")] {
        let value = defined(&header, name).unwrap_or(wanted);
        assert!(value == wanted, "SDP3_BGT60_REGISTERS: {name} is {value}, not {wanted}");
    }
    std::fs::write(out.join("registers.rs"), list(&header).expect(REGISTERS)).expect("OUT_DIR");
}
