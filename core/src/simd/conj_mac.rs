//! Conjugate multiply-accumulate, the product of dechirping: samples times a conjugate reference, summed in blocks, exactly.
//!
//! [`portable`] is the reference of Arm's dual multiply-accumulates; [`super::native_conj_mac`] is the faster of the two.

/// Complex samples: in-phase and quadrature.
pub(crate) type ComplexI16 = [i16; 2];

/// `sum conj(reference) samples` of every block of `block` samples, `[real, imaginary]`, in portable Rust.
///
/// |samples| |reference| below 2^31, blocks of at most 2^15 samples. Cost: four multiply-accumulates a sample.
#[inline]
pub fn portable(samples: &[ComplexI16], reference: &[ComplexI16], block: usize, sums: &mut [[i64; 2]]) {
    let blocks = samples.chunks_exact(block.max(1)).zip(reference.chunks_exact(block.max(1)));
    for (sum, (samples, reference)) in sums.iter_mut().zip(blocks) {
        *sum = match (<&[ComplexI16; 125]>::try_from(samples), <&[ComplexI16; 125]>::try_from(reference)) {
            (Ok(samples), Ok(reference)) => paper_block(samples, reference),
            _ => block_sum(samples, reference),
        };
    }
}

/// A block of the paper's configuration: a loop of known length is unrolled by the compiler.
#[inline(never)]
fn paper_block(samples: &[ComplexI16; 125], reference: &[ComplexI16; 125]) -> [i64; 2] {
    block_sum(samples, reference)
}

/// The sum of one block.
#[inline(always)]
fn block_sum(samples: &[ComplexI16], reference: &[ComplexI16]) -> [i64; 2] {
    let (mut real, mut imaginary) = (Sum::default(), Sum::default());
    let mut add = |x: &ComplexI16, s: &ComplexI16| {
        let (i, q) = (i32::from(x[0]), i32::from(x[1]));
        let (c, s) = (i32::from(s[0]), i32::from(s[1]));
        real.add((i * c).wrapping_add(q * s));
        imaginary.add((q * c).wrapping_sub(i * s));
    };
    // as many registers as RISC-V has hold five products
    const UNROLLED: usize = if cfg!(target_arch = "riscv32") { 5 } else { 1 };
    let (samples, rest) = samples.as_chunks::<UNROLLED>();
    let (references, last) = reference.as_chunks::<UNROLLED>();
    for (samples, reference) in samples.iter().zip(references) {
        for k in 0..UNROLLED {
            add(&samples[k], &reference[k]);
        }
    }
    rest.iter().zip(last).for_each(|(x, s)| add(x, s));
    [real.value(), imaginary.value()]
}

/// [`portable`] of eight blocks of 125 samples, of which the reference alternates in sign with itself 500 samples before, as that of
/// [`CHIRP`](crate::signal::dechirp::CHIRP) does: `s[n + 500] = (-1)^n s[n]`, n from 1. A reference sample is loaded once for two products.
pub fn alternating(samples: &[ComplexI16; 1000], reference: &[ComplexI16; 1000], sums: &mut [[i64; 2]; 8]) {
    let ((samples, _), (reference, _)) = (samples.as_chunks::<125>(), reference.as_chunks::<125>());
    let ([first @ .., _, _, _, _], [_, _, _, _, second @ ..]) = (samples, samples) else { return };
    let (sums, later) = sums.split_at_mut(4);
    for (k, (sum, later)) in sums.iter_mut().zip(later).enumerate() {
        let (Some(first), Some(second), Some(reference)) = (first.get(k), second.get(k), reference.get(k))
        else {
            continue;
        };
        let [sum_of_first, [re, im]] = two_blocks(first, second, reference);
        // a block of an odd number of samples: the next begins with the other sign
        (*sum, *later) = (sum_of_first, if k % 2 == 0 { [re, im] } else { [-re, -im] });
    }
}

/// The sums of a block and of one 500 samples later, whose reference's first sample has the other sign.
#[inline(never)]
fn two_blocks(
    first: &[ComplexI16; 125],
    second: &[ComplexI16; 125],
    reference: &[ComplexI16; 125],
) -> [[i64; 2]; 2] {
    let mut sums = [const { [const { Sum { low: 0, high: 0 } }; 2] }; 2];
    let parts = |x: &ComplexI16, s: &ComplexI16| {
        let [i, q, c, s] = [x[0], x[1], s[0], s[1]].map(i32::from);
        [(i * c).wrapping_add(q * s), (q * c).wrapping_sub(i * s)]
    };
    let mut add = |x: &ComplexI16, y: &ComplexI16, s: &ComplexI16, even: bool| {
        let [[re, im], [later_re, later_im]] = &mut sums;
        let [a, b] = parts(x, s);
        re.add(a);
        im.add(b);
        let [a, b] = parts(y, s);
        if even {
            later_re.add(a);
            later_im.add(b);
        } else {
            later_re.subtract(a);
            later_im.subtract(b);
        }
    };
    let ((pairs, last), (later, last_later)) = (first.as_chunks::<2>(), second.as_chunks::<2>());
    let (references, last_reference) = reference.as_chunks::<2>();
    for (([x0, x1], [y0, y1]), [s0, s1]) in pairs.iter().zip(later).zip(references) {
        add(x0, y0, s0, false);
        add(x1, y1, s1, true);
    }
    if let ([x], [y], [s]) = (last, last_later, last_reference) {
        add(x, y, s, false);
    }
    sums.map(|parts| parts.map(|sum| sum.short_value()))
}

/// A sum of up to 2^15 words of 32 bits, without carries: modulo 2^32, and in units of 2^16 rounded down.
///
/// What the second lacks of the exact sum is below 2^15 2^16, so the first completes it.
#[derive(Default)]
pub(crate) struct Sum {
    low: i32,
    high: i32,
}

impl Sum {
    #[inline(always)]
    pub(crate) fn add(&mut self, value: i32) {
        self.low = self.low.wrapping_add(value);
        self.high = self.high.wrapping_add(value >> 16);
    }

    /// Takes a word away: then only [`Sum::short_value`] is right.
    #[inline(always)]
    fn subtract(&mut self, value: i32) {
        self.low = self.low.wrapping_sub(value);
        self.high = self.high.wrapping_sub(value >> 16);
    }

    /// The sum of fewer than 2^15 words, some taken away: what is lacking is below 2^15 2^16 with either sign.
    fn short_value(&self) -> i64 {
        (i64::from(self.high) << 16) + i64::from(self.low.wrapping_sub(self.high << 16))
    }

    pub(crate) fn value(&self) -> i64 {
        let rest = self.low.wrapping_sub(self.high << 16) as u32;
        (i64::from(self.high) << 16) + i64::from(rest)
    }
}
