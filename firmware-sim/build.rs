//! Hands the machine's memory map to the linker and its clock to the runtime. A host build needs neither.
//!
//! `build` sets the variables from the table `machines`.

fn main() {
    println!("cargo:rerun-if-changed=memory");
    println!("cargo:rerun-if-env-changed=SDP3_MEMORY");
    println!("cargo:rerun-if-env-changed=SDP3_TICK_PS");
    let Ok(memory) = std::env::var("SDP3_MEMORY") else { return };
    let folder = std::env::var("CARGO_MANIFEST_DIR").unwrap_or_default();
    println!("cargo:rustc-link-arg-bins=-L{folder}/memory");
    println!("cargo:rustc-link-arg-bins=-T{memory}.ld");
    println!("cargo:rustc-link-arg-bins=-Tdefmt.x");
    println!("cargo:rustc-link-arg-bins=--gc-sections");
    println!("cargo:rustc-env=SDP3_TICK_PS={}", std::env::var("SDP3_TICK_PS").unwrap_or_default());
}
