//! Hands the machine's memory map to the linker, and its counter, virtual clock and slot to the runtime. A host build needs none.
//!
//! `build` sets the variables from the table `machines`. The cfgs are `board`, the memory map's name, `armv6m`, a processor
//! without a register for access to an FPU, and `armv8m`, one with a stack limit register.

fn main() {
    println!("cargo:rustc-check-cfg=cfg(armv6m)");
    println!("cargo:rustc-check-cfg=cfg(armv8m)");
    println!("cargo:rustc-check-cfg=cfg(vectors)");
    println!(
        "cargo:rustc-check-cfg=cfg(board, values(\"mps2\", \"an505\", \"an547\", \"riscv-virt\", \"rtl\", \"arm-virt\"))"
    );
    println!("cargo:rerun-if-changed=memory");
    for name in ["SDP3_MEMORY", "SDP3_TICK_PS", "SDP3_INSTRUCTION_PS", "SDP3_SLOT_INSTRUCTIONS"] {
        println!("cargo:rerun-if-env-changed={name}");
        println!("cargo:rustc-env={name}={}", read(name));
    }
    let memory = read("SDP3_MEMORY");
    if memory.is_empty() {
        return;
    }
    println!("cargo:rustc-cfg=board=\"{memory}\"");
    for (architecture, name) in [("thumbv6m", "armv6m"), ("thumbv8m.main", "armv8m")] {
        if read("TARGET").starts_with(architecture) {
            println!("cargo:rustc-cfg={name}");
        }
    }
    println!("cargo:rustc-link-arg-bins=-L{}/memory", read("CARGO_MANIFEST_DIR"));
    println!("cargo:rustc-link-arg-bins=-T{memory}.ld");
    println!("cargo:rustc-link-arg-bins=-Tdefmt.x");
    println!("cargo:rustc-link-arg-bins=--gc-sections");
    println!("cargo:rerun-if-env-changed=SDP3_CMSIS_NN");
    if !read("CARGO_FEATURE_CMSIS_NN").is_empty() {
        println!("cargo:rustc-link-arg-bin=graph-cmsis-nn={}", read("SDP3_CMSIS_NN"));
    }
}

fn read(name: &str) -> String {
    std::env::var(name).unwrap_or_default()
}
