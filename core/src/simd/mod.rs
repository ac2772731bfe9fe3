//! What the hot loops do with a processor's own instructions: dual multiply-accumulates, upper words of products, and orders of
//! products that its registers hold.
//!
//! Each has a portable reference implementation of the same bits, which processors without the instructions run.

#[cfg(all(target_arch = "arm", arm_dsp))]
#[allow(unsafe_code)]
mod arm;
pub mod conj_mac;
#[cfg(feature = "graph")]
pub mod depthwise_products;
pub mod dual_mac;
pub mod mulh;
pub mod patch_pairs;
#[cfg(feature = "graph")]
pub mod patch_products;
#[cfg(all(target_arch = "riscv32", target_feature = "m"))]
#[allow(unsafe_code)]
mod riscv;

/// The fastest [`dual_mac::DualMac`] of the target.
#[cfg(all(target_arch = "arm", arm_dsp))]
pub use arm::NativeDualMac;
/// The fastest [`depthwise_products::portable`] of the target.
#[cfg(all(feature = "graph", target_arch = "arm", arm_dsp))]
pub use arm::depthwise_products as native_depthwise_products;
/// The fastest [`patch_pairs::portable`] of the target.
#[cfg(all(target_arch = "arm", arm_dsp))]
pub use arm::largest_of_pairs as native_largest_of_pairs;
/// The fastest [`conj_mac::portable`] and [`conj_mac::eight_blocks`] of the target.
#[cfg(all(target_arch = "arm", arm_dsp))]
pub use arm::{conj_mac as native_conj_mac, eight_blocks as native_eight_blocks};
/// The fastest [`patch_products::portable`] and [`patch_products::widen`] of the target.
#[cfg(all(feature = "graph", target_arch = "arm", arm_dsp))]
pub use arm::{patch_products as native_patch_products, widen as native_widen};
/// The fastest [`conj_mac::eight_blocks`] of the target.
#[cfg(not(any(all(target_arch = "riscv32", target_feature = "m"), all(target_arch = "arm", arm_dsp))))]
pub use conj_mac::eight_blocks as native_eight_blocks;
/// The fastest [`conj_mac::portable`] of the target.
#[cfg(not(all(target_arch = "arm", arm_dsp)))]
pub use conj_mac::portable as native_conj_mac;
/// The fastest [`depthwise_products::portable`] of the target.
#[cfg(all(feature = "graph", not(all(target_arch = "arm", arm_dsp))))]
pub use depthwise_products::portable as native_depthwise_products;
/// The fastest [`patch_pairs::portable`] of the target.
#[cfg(not(all(target_arch = "arm", arm_dsp)))]
pub use patch_pairs::portable as native_largest_of_pairs;
/// The fastest [`patch_products::portable`] and [`patch_products::widen`] of the target.
#[cfg(all(feature = "graph", not(all(target_arch = "arm", arm_dsp))))]
pub use patch_products::{portable as native_patch_products, widen as native_widen};
/// The fastest [`dual_mac::DualMac`] of the target.
#[cfg(not(any(all(target_arch = "riscv32", target_feature = "m"), all(target_arch = "arm", arm_dsp))))]
pub type NativeDualMac = dual_mac::Plain;
/// The fastest [`dual_mac::DualMac`] of the target, and [`conj_mac::eight_blocks`] for the paper's chirp alone.
#[cfg(all(target_arch = "riscv32", target_feature = "m"))]
pub use riscv::{NativeDualMac, eight_blocks as native_eight_blocks};
