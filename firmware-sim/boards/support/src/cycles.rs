//! Counters of cycles.

/// Cycles so far, over the overflows of a counter of 32 bits that is read at least once in each.
pub fn extended(mut count: impl FnMut() -> u32) -> impl FnMut() -> u64 {
    let (mut last, mut high) = (0, 0_u64);
    move || {
        let now = count();
        high += u64::from(now < last) << 32;
        last = now;
        high | u64::from(now)
    }
}
