//! Names the Arm extensions that the compiler's target promises, as `cfg`s: stable Rust does not.
//!
//! `arm_dsp`: thumbv7em, or `-C target-cpu` of a core that has it. `arm_mve`: `-C target-cpu` of a core with Helium.

fn main() {
    println!("cargo:rustc-check-cfg=cfg(arm_dsp, arm_mve)");
    println!("cargo:rerun-if-env-changed=CARGO_ENCODED_RUSTFLAGS");
    let read = |name| std::env::var(name).unwrap_or_default();
    let (target, flags) = (read("TARGET"), read("CARGO_ENCODED_RUSTFLAGS"));
    let core = |names: &[&str]| names.iter().any(|name| flags.contains(&format!("target-cpu=cortex-{name}")));
    let (helium, dsp) = (core(&["m52", "m55", "m85"]), core(&["m33", "m35p"]));
    if target.starts_with("thumb") && helium {
        println!("cargo:rustc-cfg=arm_mve");
    }
    if target.starts_with("thumbv7em") || target.starts_with("thumb") && (helium || dsp) {
        println!("cargo:rustc-cfg=arm_dsp");
    }
}
