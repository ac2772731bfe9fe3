//! The identity skip: two int8 tensors of different scales added into a third scale.
//!
//! TFLite 8-bit specification, ADD: both inputs are brought to twice the larger scale with 20 guard bits.

use crate::fixed::{clamp_i8, requantize};

/// Guard bits of the sum.
const LEFT_SHIFT: u32 = 20;

/// Scales and zero points of an addition.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Add {
    /// Zero points of the left and the right input.
    pub in_zp: [i8; 2],
    /// Zero point of the output.
    pub out_zp: i8,
    /// Least output: the activation's lower end.
    pub act_min: i8,
    /// Largest output; not below `act_min`.
    pub act_max: i8,
    /// Multipliers of the inputs, 0 or Q0.31 in 2^30..2^31.
    pub multiplier: [i32; 2],
    /// Multiplier of the sum.
    pub out_multiplier: i32,
    /// Shifts of the inputs, -31 to 7.
    pub shift: [i8; 2],
    /// Shift of the sum.
    pub out_shift: i8,
}

impl Add {
    /// `x = x + branch`, in place, any shape. Cost: three requantisations a value.
    pub fn forward(&self, x: &mut [i8], branch: &[i8]) {
        for (x, &b) in x.iter_mut().zip(branch) {
            let (left, right) = (self.term(0, *x), self.term(1, b));
            let sum = requantize(left.wrapping_add(right), self.out_multiplier, self.out_shift);
            *x = clamp_i8(sum.wrapping_add(i32::from(self.out_zp)), self.act_min, self.act_max);
        }
    }

    /// One input in the common scale; `k` is 0 for the left one, 1 for the right one.
    pub(super) fn term(&self, k: usize, x: i8) -> i32 {
        let k = k & 1;
        let value = (i32::from(x) - i32::from(self.in_zp[k])) << LEFT_SHIFT;
        requantize(value, self.multiplier[k], self.shift[k])
    }
}
