//! Names the linker scripts, has the compiler's arithmetic linked in place of the ROM's, and hands over what is linked as data: the
//! recording that SDP3_RECORDING names, the suite that SDP3_SUITE names, or else nothing.

use std::path::PathBuf;

fn main() {
    for argument in ["-Tlinkall.x", "-Tdefmt.x", "-Tarithmetic.x"] {
        println!("cargo:rustc-link-arg-bins={argument}");
    }
    let out = PathBuf::from(std::env::var_os("OUT_DIR").expect("cargo sets it"));
    // esp-rom-sys takes the arithmetic of floats and wide integers from the ROM, by a linker script of this name: the linker finds
    // the empty one first
    std::fs::create_dir_all(out.join("rom")).expect("OUT_DIR");
    std::fs::write(out.join("rom/esp32c3.rom.libgcc.ld"), "/* nothing */\n").expect("OUT_DIR");
    let check =
        "ASSERT(!DEFINED(__addsf3) || __addsf3 >= ORIGIN(IROM), \"arithmetic of the ROM is linked\");\n";
    std::fs::write(out.join("arithmetic.x"), check).expect("OUT_DIR");
    println!("cargo:rustc-link-search={}", out.display());
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
