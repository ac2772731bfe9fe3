//! Sets a `cfg` for each processor extension of the compiler's target that stable Rust does not state.
//!
//! `arm_dsp`: the DSP extension: thumbv7em, `-C target-feature=+dsp`, or `-C target-cpu` of a core that has it. `arm_mve`:
//! `-C target-cpu` of a core with Helium. Then `SDP3_ARM_CPU` is that core, for the assembler.

fn main() {
    println!("cargo:rustc-check-cfg=cfg(arm_dsp, arm_mve)");
    println!("cargo:rerun-if-env-changed=CARGO_ENCODED_RUSTFLAGS");
    let read = |name| std::env::var(name).unwrap_or_default();
    let (target, flags) = (read("TARGET"), read("CARGO_ENCODED_RUSTFLAGS"));
    if !target.starts_with("thumb") {
        return;
    }
    let values = |option| flags.split('\x1f').filter_map(move |flag| Some(flag.split_once(option)?.1));
    let v7em = target.starts_with("thumbv7em");
    let named = values("target-cpu=").next_back();
    // the last word on a feature wins, also over what a core's name says
    let stated = |name| {
        let words = values("target-feature=").flat_map(|list| list.split(','));
        words.filter_map(|word| Some(word.strip_suffix(name)? == "+")).next_back()
    };
    let feature = stated("dsp");
    let named_helium = matches!(named, Some("cortex-m52" | "cortex-m55" | "cortex-m85"));
    let helium = named_helium && stated("mve").unwrap_or(true);
    let dsp = feature.unwrap_or(v7em || named_helium || matches!(named, Some("cortex-m33" | "cortex-m35p")));
    if dsp {
        println!("cargo:rustc-cfg=arm_dsp");
        let core = named.unwrap_or(if v7em { "cortex-m4" } else { "cortex-m33" });
        println!("cargo:rustc-env=SDP3_ARM_CPU={core}");
    } else if target.starts_with("thumbv8m.main") && named.is_none() && feature.is_none() {
        println!(
            "cargo:warning=without -C target-cpu=cortex-m33 or -C target-feature=+dsp the DSP instructions go unused"
        );
    }
    if dsp && helium {
        println!("cargo:rustc-cfg=arm_mve");
    }
}
