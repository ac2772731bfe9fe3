//! Products of a row of weights with the windows of four pixels (im2col): the inner loop of every convolution that the Winograd kernels are
//! not made for.

/// Pixels at a time, so that a weight is loaded once for four products.
pub const PIXELS: usize = 4;

/// Four successive values of each window, less their zero point: the first and third of every pixel, then the second and fourth.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(C, align(4))]
pub struct Fours(pub [[[i16; 2]; PIXELS]; 2]);

impl Fours {
    /// Zeros.
    pub const ZERO: Self = Fours([[[0; 2]; PIXELS]; 2]);

    /// Writes value `at` of the four of window `pixel`, less `zero`.
    #[inline(always)]
    pub fn set(&mut self, pixel: usize, at: usize, value: i8, zero: i8) {
        self.0[at % 2][pixel % PIXELS][at / 2 % 2] = i16::from(value) - i16::from(zero);
    }
}

/// Writes fours of window `pixel`, less `zero`, as far as the shorter reaches.
#[inline(always)]
pub fn widen(values: &[[i8; 4]], zero: i8, fours: &mut [Fours], pixel: usize) {
    for (four, Fours([even, odd])) in values.iter().zip(fours) {
        let [a, b, c, d] = four.map(|value| i16::from(value) - i16::from(zero));
        (even[pixel % PIXELS], odd[pixel % PIXELS]) = ([a, c], [b, d]);
    }
}

/// Adds the products of each window with a row of weights (i8) to its sum, as far as the shorter reaches. Wraps.
#[inline(always)]
pub fn portable(patch: &[Fours], weights: &[[u8; 4]], sums: &mut [i32; PIXELS]) {
    for (Fours([even, odd]), weights) in patch.iter().zip(weights) {
        let [a, b, c, d] = weights.map(|weight| i32::from(weight as i8));
        for ((sum, even), odd) in sums.iter_mut().zip(even).zip(odd) {
            let [x, y, z, w] = [even[0], odd[0], even[1], odd[1]].map(i32::from);
            *sum = sum.wrapping_add(x * a + y * b + z * c + w * d);
        }
    }
}
