//! Hands the machine's memory map to the linker. A host build needs none.

fn main() {
    let target = std::env::var("TARGET").unwrap_or_default();
    let script = match target.as_str() {
        "thumbv7em-none-eabihf" => "cortex-m4f.ld",
        "riscv32imac-unknown-none-elf" => "riscv32imac.ld",
        _ => return,
    };
    let folder = std::env::var("CARGO_MANIFEST_DIR").unwrap_or_default();
    println!("cargo:rerun-if-changed={script}");
    println!("cargo:rustc-link-arg-bins=-T{folder}/{script}");
    println!("cargo:rustc-link-arg-bins=-Tdefmt.x");
    println!("cargo:rustc-link-arg-bins=--gc-sections");
}
