//! Powers of exp(-2 pi j / 256) in Q1.31, made by the compiler.

use crate::dims::{Complex, FFT_LEN};
use crate::math::sin_cos_turn;

/// exp(-2 pi j n / 256) in Q1.31; 1 is 1 - 2^-31.
const TWIDDLES: [Complex<i32>; FFT_LEN] = twiddles();

const fn twiddles() -> [Complex<i32>; FFT_LEN] {
    let mut table = [Complex::new(0, 0); FFT_LEN];
    let mut n = 0;
    while n < FFT_LEN {
        let (sine, cosine) = sin_cos_turn(n as u64, FFT_LEN as u64);
        table[n] = Complex::new(to_q31(cosine), to_q31(-sine));
        n += 1;
    }
    table
}

/// Rounds to Q1.31, halves away from zero; saturates.
pub const fn to_q31(x: f64) -> i32 {
    let scaled = x * 2_147_483_648.0;
    (if scaled < 0.0 { scaled - 0.5 } else { scaled + 0.5 }) as i32 // saturates
}

/// Twiddles W^n, W^2n and W^3n of a transform of length 4 `N`, for n in 0..`N`.
pub(super) type Twiddles<const N: usize> = [[Complex<i32>; 3]; N];

pub static TWIDDLES_64: Twiddles<16> = radix4_twiddles();
pub static TWIDDLES_16: Twiddles<4> = radix4_twiddles();
/// The same for the whole transform, for every bin.
pub static RADIX4_TWIDDLES: Twiddles<FFT_LEN> = twiddles_of(1);

const fn radix4_twiddles<const N: usize>() -> Twiddles<N> {
    twiddles_of(FFT_LEN / 4 / N)
}

/// Powers of W_256^`step`.
const fn twiddles_of<const N: usize>(step: usize) -> Twiddles<N> {
    let mut table = [[Complex::new(0, 0); 3]; N];
    let mut n = 0;
    while n < 3 * N {
        table[n / 3][n % 3] = TWIDDLES[n / 3 * (n % 3 + 1) * step % FFT_LEN];
        n += 1;
    }
    table
}
