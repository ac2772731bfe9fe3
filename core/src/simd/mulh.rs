//! Upper words of products, and products of pairs: one instruction on most processors, if the compiler sees it.

/// Upper word of the product.
#[inline(always)]
pub fn mulh(a: i32, b: i32) -> i32 {
    #[cfg(all(target_arch = "arm", arm_dsp))]
    return super::arm::mulh(a, b);
    #[cfg(not(all(target_arch = "arm", arm_dsp)))]
    plain(a, b)
}

/// A number and the upper word of a product, wrapping.
#[inline(always)]
pub fn mla_h(sum: i32, a: i32, b: i32) -> i32 {
    #[cfg(all(target_arch = "arm", arm_dsp))]
    return super::arm::mla_h(sum, a, b);
    #[cfg(not(all(target_arch = "arm", arm_dsp)))]
    sum.wrapping_add(plain(a, b))
}

/// [`mulh`] in plain Rust.
#[inline(always)]
pub fn plain(a: i32, b: i32) -> i32 {
    ((i64::from(a) * i64::from(b)) >> 32) as i32
}

/// A number and the products of the halves of two words, i16 each, wrapping.
#[inline(always)]
pub fn add_dual(sum: i32, a: i32, b: i32) -> i32 {
    #[cfg(all(target_arch = "arm", arm_dsp))]
    return super::arm::add_dual(sum, a, b);
    #[cfg(not(all(target_arch = "arm", arm_dsp)))]
    plain_dual(sum, a, b)
}

/// [`add_dual`] in plain Rust.
#[inline(always)]
pub fn plain_dual(sum: i32, a: i32, b: i32) -> i32 {
    let low = i32::from(a as i16) * i32::from(b as i16);
    sum.wrapping_add(low).wrapping_add((a >> 16) * (b >> 16))
}
