//! Names what the compiler's target promises and stable Rust does not say, as `cfg`s.
//!
//! `arm_dsp`: thumbv7em, or `-C target-cpu` of a core that has the extension; `arm_mve`: of a core with Helium. Then
//! `SDP3_ARM_CPU` is that core, for the assembler.

fn main() {
    println!("cargo:rustc-check-cfg=cfg(arm_dsp, arm_mve)");
    println!("cargo:rerun-if-env-changed=CARGO_ENCODED_RUSTFLAGS");
    let read = |name| std::env::var(name).unwrap_or_default();
    let (target, flags) = (read("TARGET"), read("CARGO_ENCODED_RUSTFLAGS"));
    let named = flags.split('\x1f').filter_map(|flag| Some(flag.split_once("target-cpu=")?.1)).next_back();
    if target.starts_with("thumb") {
        let v7em = target.starts_with("thumbv7em");
        let core = named.unwrap_or(if v7em { "cortex-m4" } else { "" });
        let helium = ["cortex-m52", "cortex-m55", "cortex-m85"].contains(&core);
        if helium {
            println!("cargo:rustc-cfg=arm_mve");
        }
        if v7em || helium || ["cortex-m33", "cortex-m35p"].contains(&core) {
            println!("cargo:rustc-cfg=arm_dsp");
            println!("cargo:rustc-env=SDP3_ARM_CPU={core}");
        }
    }
}
