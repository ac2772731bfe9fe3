//! The core's short-time Fourier transform in f32, sixteen frames at a time in vectors: the bits of [`FloatStft`].
//!
//! The butterflies are those of microfft's decimation in time, in its order of operations: every vector has one bin of sixteen frames.

use crate::numerics::vectors::vectorised;
use sdp3_core::dims::{Complex, FFT_LEN, ROWS};
use sdp3_core::probe::Probe;
use sdp3_core::signal::stft::{FixedSpectrum, FloatStft, Stft};
use std::cell::{Cell, RefCell};
use std::f64::consts::TAU;
use std::rc::Rc;
use std::sync::LazyLock;

type Spectrum = <FloatStft as Stft>::Spectrum;

/// Frames of a batch.
const FRAMES: usize = 16;

/// A bin's real or imaginary parts, `[frame]`.
type Bin = [f32; FRAMES];

/// Twiddle factors exp(-2 pi j k / 256), `[k]`, rounded as in microfft's table.
static TWIDDLES: LazyLock<[[f32; 2]; FFT_LEN / 2]> = LazyLock::new(|| {
    let sine = |k: usize| libm::sin(TAU * k as f64 / FFT_LEN as f64) as f32;
    let quarter = FFT_LEN / 4;
    std::array::from_fn(|k| {
        if k < quarter { [sine(quarter - k), -sine(k)] } else { [-sine(k - quarter), -sine(2 * quarter - k)] }
    })
});

/// Index of a sample before the butterflies: its own with the bits reversed.
const BIT_REVERSAL: [u8; FFT_LEN] = {
    let (mut indices, mut n) = ([0; FFT_LEN], 0);
    while n < FFT_LEN {
        indices[n] = (n as u8).reverse_bits();
        n += 1;
    }
    indices
};

/// Frames that follow one another.
#[repr(align(64))]
struct Batch {
    /// `[bin][frame]`.
    re: [Bin; FFT_LEN],
    im: [Bin; FFT_LEN],
    /// Number of the first of them, and how many have been read.
    first: usize,
    read: usize,
}

/// [`FloatStft`] for frames that are asked for one after the other, as a front end does.
pub struct VectorStft {
    window: Rc<Window>,
    /// Until it is dropped.
    batch: RefCell<Option<Box<Batch>>>,
}

/// The transform of these settings.
struct Window {
    settings: (u16, f32, u16),
    one: FloatStft,
    hop: usize,
}

thread_local! {
    /// The last transform's window, which is mostly the next one's, and memory: allocated once, for small allocations between large aligned
    /// ones scatter the heap.
    static WINDOW: RefCell<Option<Rc<Window>>> = const { RefCell::new(None) };
    static SPARE: Cell<Option<Box<Batch>>> = const { Cell::new(None) };
}

impl Drop for VectorStft {
    fn drop(&mut self) {
        SPARE.set(self.batch.take());
    }
}

impl Default for Batch {
    fn default() -> Self {
        Batch { re: [[0.0; FRAMES]; FFT_LEN], im: [[0.0; FRAMES]; FFT_LEN], first: 0, read: FRAMES }
    }
}

impl Batch {
    /// Transforms the frames from `first` on.
    fn make(&mut self, slow_time: &[Complex<i32>], first: usize, hop: usize, window: &[f32]) {
        (self.first, self.read) = (first, 0);
        let Batch { re, im, .. } = self;
        (*re, *im) = ([[0.0; FRAMES]; FFT_LEN], [[0.0; FRAMES]; FFT_LEN]);
        for frame in 0..FRAMES {
            let signal = slow_time.get((first + frame) * hop..).unwrap_or(&[]);
            for ((y, weight), index) in signal.iter().zip(window).zip(BIT_REVERSAL) {
                let index = usize::from(index);
                (re[index][frame], im[index][frame]) = (y.re as f32 * weight, y.im as f32 * weight);
            }
        }
        let twiddles = &*TWIDDLES;
        vectorised(
            #[inline(always)]
            || {
                for stage in 0..FFT_LEN.ilog2() {
                    let half = 1 << stage;
                    let blocks = re.chunks_exact_mut(2 * half).zip(im.chunks_exact_mut(2 * half));
                    for (re, im) in blocks {
                        let ((re, later_re), (im, later_im)) = (re.split_at_mut(half), im.split_at_mut(half));
                        let pairs = re.iter_mut().zip(im).zip(later_re.iter_mut().zip(later_im));
                        for (k, ((re, im), (later_re, later_im))) in pairs.enumerate() {
                            let rotated = twiddle_mul([*later_re, *later_im], k, half, twiddles);
                            let sums = [sum(re, &rotated[0]), sum(im, &rotated[1])];
                            [*later_re, *later_im] =
                                [difference(re, &rotated[0]), difference(im, &rotated[1])];
                            [*re, *im] = sums;
                        }
                    }
                }
            },
        );
    }
}

/// A bin of a block's second half times its twiddle factor; 1 and -j need no multiplication.
#[inline(always)]
fn twiddle_mul([re, im]: [Bin; 2], k: usize, half: usize, twiddles: &[[f32; 2]; FFT_LEN / 2]) -> [Bin; 2] {
    let [c, s] = twiddles[k * (FFT_LEN / 2 / half)];
    if k == 0 {
        [re, im]
    } else if 2 * k == half {
        [im, product(&re, -1.0)]
    } else {
        [difference(&product(&re, c), &product(&im, s)), sum(&product(&im, c), &product(&re, s))]
    }
}

#[inline(always)]
fn sum(a: &Bin, b: &Bin) -> Bin {
    std::array::from_fn(
        #[inline(always)]
        |n| a[n] + b[n],
    )
}

#[inline(always)]
fn difference(a: &Bin, b: &Bin) -> Bin {
    std::array::from_fn(
        #[inline(always)]
        |n| a[n] - b[n],
    )
}

#[inline(always)]
fn product(a: &Bin, b: f32) -> Bin {
    a.map(
        #[inline(always)]
        |a| a * b,
    )
}

impl Stft for VectorStft {
    type Spectrum = Spectrum;

    fn spectrum(memory: &mut FixedSpectrum) -> &mut Spectrum {
        FloatStft::spectrum(memory)
    }

    fn new(length: u16, beta: f32, hop: u16) -> Self {
        let settings = (length, beta, hop);
        let new = || {
            let one = FloatStft::new(length, beta, hop);
            let hop = usize::from(hop).clamp(1, one.window().len());
            Rc::new(Window { settings, one, hop })
        };
        let window = WINDOW.take().filter(|window| window.settings == settings).unwrap_or_else(new);
        WINDOW.set(Some(Rc::clone(&window)));
        let mut batch = SPARE.take().unwrap_or_default();
        (batch.first, batch.read) = (0, FRAMES);
        VectorStft { window, batch: RefCell::new(Some(batch)) }
    }

    fn frames(&self, slots: usize) -> usize {
        self.window.one.frames(slots)
    }

    /// The central 64 `per_row` bins. A frame that does not follow the last one begins a batch; slow time stays the same within a batch.
    fn frame(&self, slow_time: &[Complex<i32>], k: usize, per_row: u8, spectrum: &mut Spectrum) {
        let mut batch = self.batch.borrow_mut();
        let batch = batch.get_or_insert_default();
        if batch.read == FRAMES || batch.first + batch.read != k {
            batch.make(slow_time, k, self.window.hop, self.window.one.window());
        }
        let half = ROWS / 2 * usize::from(per_row);
        for bin in (0..half).chain(FFT_LEN - half..FFT_LEN) {
            spectrum[bin] = Complex::new(batch.re[bin][batch.read], batch.im[bin][batch.read]);
        }
        batch.read += 1;
    }

    fn level(spectrum: &Spectrum, first: usize, count: usize) -> i16 {
        FloatStft::level(spectrum, first, count)
    }

    fn probe(spectrum: &Spectrum, k: usize, probe: &mut impl Probe) {
        FloatStft::probe(spectrum, k, probe);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numerics::random::Random;
    use sdp3_core::signal::stft::ZERO_SPECTRUM;

    #[test]
    fn frames_have_the_bits_of_the_cores_transform() {
        let mut random = Random::new(1, 2, 3, 4);
        for (length, beta, hop, per_row) in
            [(128, 10.0, 8, 1), (96, 8.0, 5, 2), (256, 0.0, 256, 4), (2, 3.0, 1, 4)]
        {
            let slow_time: Vec<_> = (0..700)
                .map(|_| {
                    Complex::new(
                        (random.bits() >> 41) as i32 - (1 << 22),
                        (random.bits() >> 41) as i32 - (1 << 22),
                    )
                })
                .collect();
            let (one, many) = (FloatStft::new(length, beta, hop), VectorStft::new(length, beta, hop));
            assert_eq!(many.frames(slow_time.len()), one.frames(slow_time.len()));
            // in order, again from the beginning, with gaps, and beyond the end
            for k in (0..40).chain(0..3).chain([7, 9, 10, 5, 5]).chain(690..720) {
                let (mut expected, mut found) = (ZERO_SPECTRUM, ZERO_SPECTRUM);
                one.frame(&slow_time, k, per_row, &mut expected);
                many.frame(&slow_time, k, per_row, &mut found);
                let half = 32 * usize::from(per_row);
                for bin in (0..half).chain(FFT_LEN - half..FFT_LEN) {
                    let bits = |z: Complex<f32>| [z.re + 0.0, z.im + 0.0].map(f32::to_bits);
                    assert_eq!(bits(found[bin]), bits(expected[bin]), "frame {k}, bin {bin}");
                }
            }
        }
    }
}
