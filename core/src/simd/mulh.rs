//! Upper words of products: one instruction on most processors, if the compiler sees it.

/// Upper word of the product.
#[inline(always)]
pub fn mulh(a: i32, b: i32) -> i32 {
    #[cfg(all(target_arch = "arm", arm_dsp))]
    return super::arm::upper_words::mulh(a, b);
    #[cfg(not(all(target_arch = "arm", arm_dsp)))]
    plain(a, b)
}

/// A number and the upper word of a product, wrapping.
#[inline(always)]
pub fn mla_h(sum: i32, a: i32, b: i32) -> i32 {
    #[cfg(all(target_arch = "arm", arm_dsp))]
    return super::arm::upper_words::mla_h(sum, a, b);
    #[cfg(not(all(target_arch = "arm", arm_dsp)))]
    sum.wrapping_add(plain(a, b))
}

/// [`mulh`] in plain Rust.
#[inline(always)]
pub fn plain(a: i32, b: i32) -> i32 {
    ((i64::from(a) * i64::from(b)) >> 32) as i32
}
