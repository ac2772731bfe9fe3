//! Products of int8 values with four rows of weights: the inner loop of every convolution that the Winograd kernels are not made for.

/// Adds `sum (x - zero) w` of values with each of four rows of weights (i8) to its sum; all are as long as the shortest. Wraps.
#[inline(always)]
pub fn portable(values: &[i8], rows: [&[u8]; 4], zero: i8, sums: &mut [i32; 4]) {
    let [a, b, c, d] = rows;
    let [mut s0, mut s1, mut s2, mut s3] = *sums;
    for ((((&x, &a), &b), &c), &d) in values.iter().zip(a).zip(b).zip(c).zip(d) {
        let x = i32::from(x) - i32::from(zero);
        s0 = s0.wrapping_add(x * i32::from(a as i8));
        s1 = s1.wrapping_add(x * i32::from(b as i8));
        s2 = s2.wrapping_add(x * i32::from(c as i8));
        s3 = s3.wrapping_add(x * i32::from(d as i8));
    }
    *sums = [s0, s1, s2, s3];
}
