//! Names the linker scripts, and hands over what is linked as data: the recording that SDP3_RECORDING names, the suite that
//! SDP3_SUITE names, or else nothing.

use std::path::PathBuf;

fn main() {
    for argument in ["-Tlinkall.x", "-Tdefmt.x"] {
        println!("cargo:rustc-link-arg-bins={argument}");
    }
    let out = PathBuf::from(std::env::var_os("OUT_DIR").expect("cargo sets it"));
    for (variable, name) in [("SDP3_RECORDING", "recording"), ("SDP3_SUITE", "suite")] {
        println!("cargo:rerun-if-env-changed={variable}");
        let bytes = match std::env::var_os(variable) {
            None => Vec::new(),
            Some(path) => {
                println!("cargo:rerun-if-changed={}", path.display());
                std::fs::read(&path).unwrap_or_else(|error| panic!("{variable}: {}: {error}", path.display()))
            }
        };
        std::fs::write(out.join(name), bytes).expect("OUT_DIR");
    }
}
