//! Dechirp, range gate, Gram matrix, weights, projection, STFT and intensities by their definitions.
//!
//! Paper, eqs. (X), (Y) and (z); integer scalings as stated in the core's documentation.

use super::network::Radar;
use rustfft::num_complex::Complex;
use std::f64::consts::PI;

/// Complex i64.
pub type Int = (i64, i64);
/// Complex f64.
pub type Float = Complex<f64>;

/// Round of x / 2^shift, halves up.
fn shifted(x: i64, shift: u32) -> i64 {
    (x + (1 << shift) / 2).div_euclid(1 << shift)
}

/// Least k with n <= 2^k.
fn bits(n: usize) -> u32 {
    (0..).find(|&k| n <= 1 << k).expect("some power")
}

/// Q1.15 of a real number.
fn q15(x: f64) -> i64 {
    libm::round(32767.0 * x) as i64
}

/// Sample n of the chirp of L samples, t = (n + 1) / f_s.
fn chirp(n: usize, samples: usize) -> Int {
    // reduce the phase before the cosine: pi n^2 / L modulo 2 pi
    let phase = PI * (((n + 1) * (n + 1)) % (2 * samples)) as f64 / samples as f64;
    (q15(libm::cos(phase)), q15(libm::sin(phase)))
}

/// Sample n of what a range sample's bins of the DFT, Hann-windowed and with their phases from the sweep's middle, are a product with.
fn gate(n: usize, range: usize, radar: &Radar) -> Int {
    let u = (n as f64 + 0.5) / radar.samples as f64 - 0.5;
    let hann = 0.5 + 0.5 * libm::cos(2.0 * PI * u);
    let mut sum = Float::new(0.0, 0.0);
    for bin in radar.first_bin + range * radar.bins..radar.first_bin + (range + 1) * radar.bins {
        sum += Float::from_polar(1.0, 2.0 * PI * bin as f64 * u);
    }
    let mean = sum * hann / radar.bins as f64;
    (q15(mean.re), q15(mean.im))
}

/// Range samples of a slot, eight with zeros behind those that are kept.
///
/// Block sums of the samples times the conjugate chirp, of the samples as they are, or all samples times the conjugate gate; the
/// sum is divided by a power of two, halves up.
pub fn beat(slot: &[i16], radar: &Radar) -> Vec<Int> {
    let samples: Vec<Int> = match radar.real {
        true => slot.iter().map(|&x| (i64::from(x), 0)).collect(),
        false => slot.chunks(2).map(|z| (i64::from(z[0]), i64::from(z[1]))).collect(),
    };
    let block = radar.samples / radar.kept;
    let shift = match (radar.bins, radar.analog) {
        (0, false) => 5 + bits(block),
        (0, true) => bits(block).saturating_sub(9),
        _ => 5 + bits(radar.samples),
    };
    let mut kept = vec![(0, 0); 8];
    for (range, kept) in kept.iter_mut().take(radar.kept).enumerate() {
        let mut sum = (0, 0);
        for (n, &(i, q)) in samples.iter().enumerate() {
            let (c, s) = match (radar.bins, radar.analog) {
                (0, _) if n / block != range => (0, 0),
                (0, false) => chirp(n, radar.samples),
                (0, true) => (1, 0),
                _ => gate(n, range, radar),
            };
            sum.0 += i * c + q * s;
            sum.1 += q * c - i * s;
        }
        // a sensor delivers sent times conjugate received
        let im = if radar.analog { -sum.1 } else { sum.1 };
        *kept = (shifted(sum.0, shift), shifted(im, shift));
    }
    kept
}

/// Slot n times exp(-2 pi j n / 4).
pub fn turned(beats: &[Vec<Int>]) -> Vec<Vec<Int>> {
    let once = |&(re, im): &Int| (im, -re);
    let times = |beat: &Vec<Int>, n: usize| (0..n).fold(beat.clone(), |b, _| b.iter().map(once).collect());
    beats.iter().enumerate().map(|(n, beat)| times(beat, n % 4)).collect()
}

/// Upper triangle of the sum over slots of b b^H, row by row.
pub fn gram(beats: &[Vec<Int>]) -> Vec<Int> {
    let mut upper = Vec::new();
    for i in 0..8 {
        for j in i..8 {
            let mut sum = (0_i128, 0_i128);
            for beat in beats {
                let ((ar, ai), (br, bi)) = (beat[i], beat[j]);
                sum.0 += i128::from(ar * br + ai * bi);
                sum.1 += i128::from(ai * br - ar * bi);
            }
            upper.push((i64::try_from(sum.0).expect("fits"), i64::try_from(sum.1).expect("fits")));
        }
    }
    upper
}

/// How far weights are from those of a nearby matrix: one error for each eigenvector, and one for the projection.
///
/// r = 1 - w is the projection of 1 on the dropped eigenvectors. In the eigenbasis it has the parts o_i = v_i^H 1 of the
/// dropped and none of the kept. A perturbation E of the matrix (trace 1) moves part i by |E| / d_i at most, d_i being the
/// distance to the nearest eigenvalue of the other kind; so the part's deviation times d_i, over |1| = sqrt 8, is a
/// backward error: its bound holds for every gap. Where d_i vanishes the eigenvectors are any of their span, but r is a
/// projection all the same: r^H (1 - r) = 0 is the last error.
pub fn backward_error(upper: &[Int], first: usize, last: usize, w: &[Float]) -> Vec<f64> {
    let one = Float::new(1.0, 0.0);
    let r: Vec<Float> = w.iter().map(|w| one - w).collect();
    let Some(pairs) = eigenpairs(upper) else { return r.iter().map(|r| r.norm()).collect() };
    let dropped = |index: usize| index + 1 < first || index + 1 > last;
    let mut errors = Vec::new();
    for (index, (value, v)) in pairs.iter().enumerate() {
        let part: Float = v.iter().zip(&r).map(|(v, r)| v.conj() * r).sum();
        let wanted: Float =
            if dropped(index) { v.iter().map(|v| v.conj()).sum() } else { Float::new(0.0, 0.0) };
        let others = pairs.iter().enumerate().filter(|(other, _)| dropped(*other) != dropped(index));
        // with no other kind nothing can turn: the whole deviation is an error
        let distance = others.map(|(_, (other, _))| (value - other).abs()).fold(1.0, f64::min);
        errors.push((part - wanted).norm() * distance / 8_f64.sqrt());
    }
    let projection: Float = r.iter().map(|r| r.conj() * (one - r)).sum();
    errors.push(projection.norm() / 8.0);
    errors
}

/// The first component kept, from 1: `stated`, or if that is 0 the first with a slow-time signal `v^H b[n]` that is static to at most 2047/2048
/// of its energy, `last` at most. Two where one share is within rounding of that: the core knows an eigenvalue to 2e-7 of their sum.
pub fn first_kept(beats: &[Vec<Int>], upper: &[Int], stated: usize, last: usize) -> Vec<usize> {
    if stated > 0 {
        return vec![stated];
    }
    let Some(pairs) = eigenpairs(upper) else { return vec![1] };
    for (index, (value, v)) in pairs.iter().enumerate().take(last - 1) {
        let signal = beats.iter().map(|beat| -> Float {
            let float = |b: &Int| Float::new(b.0 as f64, b.1 as f64);
            v.iter().zip(beat).map(|(v, b)| v.conj() * float(b)).sum()
        });
        let (sum, energy) =
            signal.fold((Float::new(0.0, 0.0), 0.0), |(sum, energy), y| (sum + y, energy + y.norm_sqr()));
        let share = sum.norm_sqr() / (energy * beats.len() as f64).max(f64::MIN_POSITIVE) - 2047.0 / 2048.0;
        if share.abs() < 3e-5 + 2e-7 / value.max(1e-12) {
            return vec![index + 1, index + 2];
        }
        if share < 0.0 {
            return vec![index + 1];
        }
    }
    vec![last]
}

/// Eigenvalues, largest first, and eigenvectors of the matrix over its trace; `None` if it is zero.
fn eigenpairs(upper: &[Int]) -> Option<Vec<(f64, Vec<Float>)>> {
    let mut a = [[Float::new(0.0, 0.0); 8]; 8];
    let mut entries = upper.iter();
    for i in 0..8 {
        for j in i..8 {
            let &(re, im) = entries.next().expect("36 entries");
            a[i][j] = Float::new(re as f64, im as f64);
            a[j][i] = a[i][j].conj();
        }
    }
    let trace: f64 = (0..8).map(|i| a[i][i].re).sum();
    if trace <= 0.0 {
        return None;
    }
    a.iter_mut().flatten().for_each(|value| *value /= trace);
    let mut pairs = eigen(a);
    pairs.sort_by(|x, y| y.0.total_cmp(&x.0));
    Some(pairs)
}

/// Eigenpairs of a Hermitian matrix through the real symmetric 16 x 16 matrix [[Re, -Im], [Im, Re]]: classical
/// Jacobi on the largest element, then one vector of each doubled pair by Gram-Schmidt.
fn eigen(a: [[Float; 8]; 8]) -> Vec<(f64, Vec<Float>)> {
    let mut m = vec![vec![0.0; 16]; 16];
    for i in 0..8 {
        for j in 0..8 {
            m[i][j] = a[i][j].re;
            m[i + 8][j + 8] = a[i][j].re;
            m[i][j + 8] = -a[i][j].im;
            m[i + 8][j] = a[i][j].im;
        }
    }
    let mut v: Vec<Vec<f64>> = (0..16).map(|i| (0..16).map(|j| f64::from(i == j)).collect()).collect();
    for _ in 0..20_000 {
        let (mut p, mut q, mut largest) = (0, 1, 0.0);
        for (i, row) in m.iter().enumerate() {
            for (j, value) in row.iter().enumerate().skip(i + 1) {
                if value.abs() > largest {
                    (p, q, largest) = (i, j, value.abs());
                }
            }
        }
        if largest < 1e-17 {
            break;
        }
        let theta = 0.5 * libm::atan2(2.0 * m[p][q], m[q][q] - m[p][p]);
        let (s, c) = (libm::sin(theta), libm::cos(theta));
        for matrix in [&mut m, &mut v] {
            for row in matrix.iter_mut() {
                (row[p], row[q]) = (c * row[p] - s * row[q], s * row[p] + c * row[q]);
            }
        }
        for j in 0..16 {
            (m[p][j], m[q][j]) = (c * m[p][j] - s * m[q][j], s * m[p][j] + c * m[q][j]);
        }
    }
    let mut order: Vec<usize> = (0..16).collect();
    order.sort_by(|&x, &y| m[y][y].total_cmp(&m[x][x]));
    let mut pairs: Vec<(f64, Vec<Float>)> = Vec::new();
    for column in order {
        let mut u: Vec<Float> = (0..8).map(|i| Float::new(v[i][column], v[i + 8][column])).collect();
        for (_, other) in &pairs {
            let inner: Float = other.iter().zip(&u).map(|(o, u)| o.conj() * u).sum();
            u.iter_mut().zip(other).for_each(|(u, o)| *u -= o * inner);
        }
        let norm = u.iter().map(|u| u.norm_sqr()).sum::<f64>().sqrt();
        if norm > 0.3 && pairs.len() < 8 {
            u.iter_mut().for_each(|u| *u /= norm);
            pairs.push((m[column][column], u));
        }
    }
    assert_eq!(pairs.len(), 8, "a Hermitian 8 x 8 matrix has eight eigenvectors");
    pairs
}

/// Slow time from given Q3.28 weights: exact inner products, scaled to 23 bits by one shift, halves up.
pub fn slow_time(beats: &[Vec<Int>], weights: &[Int]) -> Vec<Int> {
    let exact: Vec<(i128, i128)> = beats
        .iter()
        .map(|beat| {
            beat.iter().zip(weights).fold((0, 0), |sum, (&(br, bi), &(wr, wi))| {
                let (br, bi, wr, wi) = (i128::from(br), i128::from(bi), i128::from(wr), i128::from(wi));
                (sum.0 + wr * br + wi * bi, sum.1 + wr * bi - wi * br)
            })
        })
        .collect();
    let largest = exact.iter().map(|y| y.0.abs().max(y.1.abs())).max().unwrap_or(0);
    let mut scale = 1_i128;
    while largest >= (1 << 23) * scale {
        scale *= 2;
    }
    let round = |x: i128| (x + scale / 2).div_euclid(scale) as i64;
    exact.into_iter().map(|(re, im)| (round(re), round(im))).collect()
}

/// Kaiser window of eq. (z).
pub fn kaiser(length: usize, beta: f64) -> Vec<f64> {
    let centre = (length as f64 - 1.0) / 2.0;
    (0..length)
        .map(|n| {
            let x = (n as f64 - centre) / centre;
            bessel_i0(beta * (1.0 - x * x).max(0.0).sqrt()) / bessel_i0(beta)
        })
        .collect()
}

fn bessel_i0(x: f64) -> f64 {
    let (mut term, mut sum, mut k) = (1.0, 1.0, 1.0);
    while term > sum * 1e-18 {
        term *= x * x / (4.0 * k * k);
        sum += term;
        k += 1.0;
    }
    sum
}

/// One frame's 256 bins, and the sum of the windowed magnitudes its error is measured against.
pub fn frame(slow_time: &[Int], window: &[f64], start: usize) -> (Vec<Float>, f64) {
    let mut x = vec![Float::new(0.0, 0.0); 256];
    for ((x, y), w) in x.iter_mut().zip(&slow_time[start..]).zip(window) {
        *x = Float::new(y.0 as f64 * w, y.1 as f64 * w);
    }
    let total = x.iter().map(|x| x.norm_sqr().sqrt()).sum();
    rustfft::FftPlanner::new().plan_fft_forward(256).process(&mut x);
    (x, total)
}

/// `floor(64 log2 p)` of a normal positive f32, or `None`.
///
/// f64 holds p exactly and its logarithm to 1e-15; the distance of 64 log2 p from an integer is above 1e-7 unless p
/// is a power of two, where the logarithm is exact.
pub fn level(p: f32) -> Option<i64> {
    if !p.is_normal() || p < 0.0 {
        return None;
    }
    Some((libm::log2(f64::from(p)) * 64.0).floor() as i64)
}

/// `floor(64 log2 p)` of the leading 32 bits of a positive p, or `None`: f64 holds them exactly.
pub fn fixed_level(p: u64) -> Option<i64> {
    let below = p.checked_ilog2()?.saturating_sub(31);
    Some((libm::log2((p >> below << below) as f64) * 64.0).floor() as i64)
}

/// Bin `t` of an image's row.
fn bin(row: usize, t: usize, bins_per_row: usize) -> usize {
    ((row as i64 - 32) * bins_per_row as i64 + t as i64).rem_euclid(256) as usize
}

/// The levels of the frames' f32 spectra, `[64][frames]`.
pub fn levels(spectra: &[Vec<(f32, f32)>], bins_per_row: usize) -> Vec<Option<i64>> {
    let mut levels = vec![None; 64 * spectra.len()];
    for (k, spectrum) in spectra.iter().enumerate() {
        for row in 0..64 {
            let mut power: Option<f32> = None;
            for t in 0..bins_per_row {
                let (re, im) = spectrum[bin(row, t, bins_per_row)];
                let term = re * re + im * im;
                power = Some(power.map_or(term, |power| power + term));
            }
            levels[row * spectra.len() + k] = power.and_then(level);
        }
    }
    levels
}

/// The levels of spectra in integers, `[64][frames]`.
pub fn fixed_levels(spectra: &[Vec<Int>], bins_per_row: usize) -> Vec<Option<i64>> {
    let mut levels = vec![None; 64 * spectra.len()];
    for (k, spectrum) in spectra.iter().enumerate() {
        for row in 0..64 {
            let powers = (0..bins_per_row).map(|t| {
                let (re, im) = spectrum[bin(row, t, bins_per_row)];
                (re * re + im * im) as u64
            });
            levels[row * spectra.len() + k] = fixed_level(powers.sum());
        }
    }
    levels
}

/// The image of levels.
pub fn image(levels: &[Option<i64>], range: i64) -> Vec<i8> {
    let largest = levels.iter().flatten().copied().max();
    levels
        .iter()
        .map(|level| match (*level, largest) {
            (Some(level), Some(largest)) if largest - level < range => {
                (255 - (largest - level) * 255 / range - 128) as i8
            }
            _ => -128,
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn range_samples_are_the_cores_for_every_kind_of_radar() {
        use crate::conformance::reference::network::Radar;
        use crate::formats::slots::Slots;
        use sdp3_core::config::{Dechirp, RadarConfig, RangeGate, SampleFormat};
        let (paper, iwr, bgt60) = (RadarConfig::PAPER, RadarConfig::IWR, RadarConfig::BGT60);
        let gate = |first_bin, bins_per_sample| Some(RangeGate { first_bin, bins_per_sample });
        let blocks = RadarConfig { dechirp: Dechirp::Analog, range_samples: 4, ..paper };
        let mut rng = crate::numerics::random::Random::new(3, 0, 0, 0);
        for config in [
            paper,
            iwr,
            bgt60,
            blocks,
            RadarConfig { samples: 64, ..paper },
            RadarConfig { samples: 2048, range_samples: 1, ..paper },
            RadarConfig { samples: 2048, range_samples: 1, ..blocks },
            RadarConfig { samples: 2048, gate: gate(100, 32), ..iwr },
            RadarConfig { samples: 300, range_samples: 3, gate: gate(0, 1), ..bgt60 },
            RadarConfig { samples: 300, range_samples: 3, gate: None, ..bgt60 },
            RadarConfig::DOPPLER,
            RadarConfig::DOPPLER_IQ,
        ] {
            let values = config.values_per_slot();
            let mut slots = Slots::with_capacity(values, 20);
            slots.values.extend((0..20 * values).map(|n| match n / values {
                0 => 0,
                1 => i16::MIN,
                2 => i16::MAX,
                _ => rng.bits() as i16,
            }));
            let radar = Radar {
                samples: config.samples.into(),
                kept: config.range_samples.into(),
                real: config.format == SampleFormat::Real,
                analog: config.dechirp == Dechirp::Analog,
                bins: config.gate.map_or(0, |gate| gate.bins_per_sample.into()),
                first_bin: config.gate.map_or(0, |gate| gate.first_bin.into()),
            };
            for (slot, found) in slots.iter().zip(slots.beats(config).unwrap()) {
                let found: Vec<Int> = found.iter().map(|z| (i64::from(z.re), i64::from(z.im))).collect();
                assert_eq!(found, beat(slot, &radar), "{config:?}");
            }
        }
    }

    #[test]
    fn eigenpairs_rebuild_their_matrix() {
        let mut state = 7_u64;
        let mut draw = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            (state >> 40) as f64 / 16_777_216.0 - 0.5
        };
        for _ in 0..20 {
            let mut a = [[Float::new(0.0, 0.0); 8]; 8];
            for i in 0..8 {
                for j in i..8 {
                    a[i][j] = Float::new(draw(), if i == j { 0.0 } else { draw() });
                    a[j][i] = a[i][j].conj();
                }
            }
            let pairs = eigen(a);
            for i in 0..8 {
                for j in 0..8 {
                    let rebuilt: Float = pairs.iter().map(|(value, u)| u[i] * u[j].conj() * *value).sum();
                    assert!((rebuilt - a[i][j]).norm_sqr() < 1e-24);
                }
            }
        }
    }

    #[test]
    fn the_backward_error_sees_wrong_weights_through_any_gap() {
        // diagonal matrices: the eigenvectors are the axes, the strongest is dropped, w = 1 but for a 0
        for gap in [1_i64 << 40, 1 << 20, 1] {
            let diagonal = |i: usize| if i == 0 { (1_i64 << 50) + gap } else { (1 << 50) >> (i - 1) };
            let upper: Vec<Int> =
                (0..8).flat_map(|i| (i..8).map(move |j| (if i == j { diagonal(i) } else { 0 }, 0))).collect();
            let weights = |zero: usize| -> Vec<Float> {
                (0..8).map(|i| Float::new(if i == zero { 0.0 } else { 1.0 }, 0.0)).collect()
            };
            let worst = |w: &[Float]| backward_error(&upper, 2, 8, w).into_iter().fold(0.0, f64::max);
            assert!(worst(&weights(0)) < 1e-12, "{gap}");
            // dropping the third instead of the first is wrong, the second only where the gap can be seen
            assert!(worst(&weights(2)) > 0.01, "{gap}");
            assert!((worst(&weights(1)) > 1e-6) == (gap > 1 << 30), "{gap}");
            // half of a component is no projection
            let mut half = weights(0);
            half[0].re = 0.5;
            assert!(worst(&half) > 0.01, "{gap}");
        }
    }

    #[test]
    fn levels_change_exactly_at_powers_of_the_64th_root_of_two() {
        for exponent in -126..128_i32 {
            for i in 0..64_i32 {
                let border = libm::exp2(f64::from(exponent) + f64::from(i) / 64.0);
                let mut p = border as f32;
                if f64::from(p) < border {
                    p = f32::from_bits(p.to_bits() + 1);
                }
                let below = f32::from_bits(p.to_bits() - 1);
                assert_eq!(level(p), Some(i64::from(64 * exponent + i)));
                if below.is_normal() {
                    assert_eq!(level(below), Some(i64::from(64 * exponent + i - 1)));
                }
            }
        }
    }

    #[test]
    fn kaiser_window_is_scipys() {
        // scipy.signal.windows.kaiser(128, 10, sym=True)[[0, 63]]
        let window = kaiser(128, 10.0);
        assert!((window[0] - 3.551_494_06e-4).abs() < 1e-9, "{}", window[0]);
        assert_eq!(window[63], window[64]);
    }
}
