//! Tests of `signal::clutter`. Oracle: nalgebra's Hermitian eigenvalue solver in f64.

use nalgebra::{SMatrix, SVector, SymmetricEigen};
use rand_core::{Rng, SeedableRng};
use sdp3_core::dims::{BEATS, Beat, Complex, ZERO_BEAT};
use sdp3_core::signal::clutter::*;

fn noise(seed: u64, slots: usize) -> Vec<Beat> {
    let mut rng = rand_xoshiro::Xoshiro128PlusPlus::seed_from_u64(seed);
    let mut draw = || (rng.next_u32() as i32) >> 7;
    (0..slots).map(|_| core::array::from_fn(|_| Complex::new(draw(), draw()))).collect()
}

/// (I - U U^H) 1 over the dropped components in f64, and the smallest gap between a dropped and a kept eigenvalue, of their sum 1.
fn exact(gram: &Gram, kept: SvdRange) -> (SVector<Complex<f64>, BEATS>, f64) {
    let mut entries = gram.upper().iter();
    let mut matrix = SMatrix::<Complex<f64>, BEATS, BEATS>::zeros();
    for i in 0..BEATS {
        for j in i..BEATS {
            let entry = entries.next().expect("an entry");
            matrix[(i, j)] = Complex::new(entry.re as f64, entry.im as f64);
            matrix[(j, i)] = matrix[(i, j)].conj();
        }
    }
    let trace = matrix.trace().re;
    let eigen = SymmetricEigen::new(matrix);
    let mut order: Vec<usize> = (0..BEATS).collect();
    order.sort_by(|&a, &b| eigen.eigenvalues[b].total_cmp(&eigen.eigenvalues[a]));
    let is_kept = |rank: usize| (kept.first..=kept.last).contains(&(rank as u8 + 1));
    let mut w = SVector::<Complex<f64>, BEATS>::from_element(Complex::new(1.0, 0.0));
    let mut gap = f64::INFINITY;
    for (rank, &k) in order.iter().enumerate() {
        if !is_kept(rank) {
            let u = eigen.eigenvectors.column(k);
            w -= u * u.sum().conj();
        }
        if rank > 0 && is_kept(rank) != is_kept(rank - 1) {
            gap = gap.min((eigen.eigenvalues[order[rank - 1]] - eigen.eigenvalues[k]) / trace);
        }
    }
    (w, gap)
}

#[test]
fn the_projection_is_that_of_an_eigenvalue_solver_in_f64() {
    let mut compared = 0;
    for seed in 0..200 {
        let beats = noise(seed, 1 + seed as usize % 20);
        let mut gram = Gram::new();
        beats.iter().for_each(|beat| gram.add(beat));
        let kept = SvdRange { first: 2 + seed as u8 % 4, last: 8 - seed as u8 % 3 };
        let (w, gap) = exact(&gram, kept);
        // of fewer slots than range samples the weakest components are alike
        if gap < 1e-3 {
            continue;
        }
        compared += 1;
        let found = clutter_projection(&beats, kept).map(|q| {
            let scale = f64::from(1_u32 << PROJECTION_BITS);
            Complex::new(f64::from(q.re) / scale, f64::from(q.im) / scale)
        });
        let error = (SVector::from(found) - w).norm();
        assert!(error < 64.0 * f64::from(f32::EPSILON) / gap, "seed {seed}: {error}, gap {gap}");
    }
    assert!(compared > 100, "{compared}");
}

#[test]
fn a_constant_echo_is_removed_to_the_arithmetic() {
    // one static echo at full scale: rank one, so nothing may be left at d = 2
    let echo: Beat =
        core::array::from_fn(|i| Complex::new(20_000_000 - 900_000 * i as i32, 1_000_000 * i as i32));
    for first in [2, ADAPTIVE] {
        let w = clutter_projection(&[echo; 300], SvdRange { first, last: 8 });
        let part = |w| largest_part(&[echo], w) as f64;
        let ratio = part(&w) / part(&UNIT_PROJECTION);
        assert!(ratio < 1e-6, "left over: {ratio}");
    }
}

#[test]
fn full_scale_recordings_do_not_overflow() {
    // the loudest beats there are, as many as a Gram matrix takes: one static echo, removed like any other
    let loudest: Beat = [Complex::new(32_700_000, 32_700_000); BEATS];
    let mut gram = Gram::new();
    (0..GRAM_SLOTS).for_each(|_| gram.add(&loudest));
    assert!(gram.upper().iter().all(|entry| entry.re > 0));
    for first in [2, ADAPTIVE] {
        let w = clutter_projection(&vec![loudest; GRAM_SLOTS], SvdRange { first, last: 8 });
        assert_ne!(w, UNIT_PROJECTION);
        assert!(largest_part(&[loudest], &w) < 1 << 38); // of 2^56 before
    }
}

#[test]
fn keeping_everything_sums_the_beat() {
    let beats = noise(7, 40);
    for first in [1, ADAPTIVE] {
        assert_eq!(clutter_projection(&beats, SvdRange { first, last: 8 }), UNIT_PROJECTION);
    }
    // of nothing, and of silence, nothing is dropped
    for first in [2, ADAPTIVE] {
        assert_eq!(clutter_projection(&[], SvdRange { first, last: 8 }), UNIT_PROJECTION);
        assert_eq!(clutter_projection(&[ZERO_BEAT; 9], SvdRange { first, last: 8 }), UNIT_PROJECTION);
    }
}

#[test]
fn components_are_cut_by_rank_from_both_ends() {
    // every slot in one range cell: eigenvectors are the cells, the later the stronger, the first two alike
    let mut beats = Vec::new();
    for (cell, times) in [1, 1, 2, 3, 4, 5, 6, 7].into_iter().enumerate() {
        let mut beat = ZERO_BEAT;
        beat[cell] = Complex::new(1000, -1000);
        beats.extend(std::iter::repeat_n(beat, times));
    }
    let ranks = [7, 8, 6, 5, 4, 3, 2, 1];
    for first in 1..=8 {
        for last in first..=8 {
            let kept = |rank: &u8| (first..=last).contains(rank);
            let wanted = ranks.map(|rank| Complex::new(i32::from(kept(&rank)) << PROJECTION_BITS, 0));
            assert_eq!(clutter_projection(&beats, SvdRange { first, last }), wanted, "{first}..={last}");
        }
    }
}

/// A wall in one range sample, and somebody who walks in another at an energy of `clutter_db` below it; faint noise.
fn scene(seed: u64, clutter_db: f64, hz: f64) -> Vec<Beat> {
    let (wall, body) = (4e6, 4e6 * 10_f64.powf(-clutter_db / 20.0));
    let mut beats = noise(seed, 300);
    for (n, beat) in beats.iter_mut().enumerate() {
        beat.iter_mut().for_each(|z| (z.re, z.im) = (z.re >> 20, z.im >> 20));
        let (s, c) = (std::f64::consts::TAU * hz * n as f64 * 1e-3).sin_cos();
        let body = body.min(2e7);
        let wall = if clutter_db < -14.0 { 2e7 / 10_f64.powf(-clutter_db / 20.0) } else { wall };
        beat[2].re += wall as i32;
        beat[5].re += (body * c) as i32;
        beat[5].im += (body * s) as i32;
    }
    beats
}

#[test]
fn what_is_static_is_dropped_and_who_moves_is_kept_however_strong() {
    for clutter_db in [-20.0, -10.0, -3.0, 3.0, 10.0, 20.0, 30.0, 40.0] {
        // whole turns, so that the walker has no mean
        for hz in [10.0 / 3.0, 50.0 / 3.0, 90.0] {
            let beats = scene(7, clutter_db, hz);
            let adaptive = clutter_projection(&beats, SvdRange { first: ADAPTIVE, last: 8 });
            let one = |b: usize| adaptive[b].re;
            // the walker is whole; the wall is gone where it leads, and stays where it does not hide anybody
            assert!(
                (one(5) - (1 << PROJECTION_BITS)).abs() < 1 << 20,
                "{clutter_db} dB, {hz} Hz: {adaptive:?}"
            );
            if clutter_db > 1.0 {
                let fixed = clutter_projection(&beats, SvdRange { first: 2, last: 8 });
                assert_eq!(adaptive, fixed, "{clutter_db} dB, {hz} Hz");
                assert!(one(2).abs() < 1 << 20);
            }
            if clutter_db < -1.0 {
                assert_eq!(adaptive, UNIT_PROJECTION, "{clutter_db} dB, {hz} Hz");
            }
        }
    }
}

#[test]
fn the_static_share_is_held_against_its_threshold() {
    // a component of one range sample, its phase jumps: m of 256 slots are turned round, so that its mean is 1 - m / 128
    for (turned, dropped) in [(0, true), (1, false), (2, false), (128, false)] {
        let mut beats = vec![ZERO_BEAT; 256];
        for (n, beat) in beats.iter_mut().enumerate() {
            beat[3].re = if n < turned { -1_000_000 } else { 1_000_000 };
        }
        let w = clutter_projection(&beats, SvdRange { first: ADAPTIVE, last: 8 });
        assert_eq!(w[3].re == 0, dropped, "{turned}: {w:?}");
        // an upper cut comes first
        let w = clutter_projection(&beats, SvdRange { first: ADAPTIVE, last: 1 });
        assert_eq!(w[3].re, 1 << PROJECTION_BITS);
    }
}

#[test]
fn slow_time_uses_its_bits() {
    let beats = noise(3, 64);
    let mut y = [Complex::new(0, 0); 64];
    project(&beats, &UNIT_PROJECTION, slow_time_shift(largest_part(&beats, &UNIT_PROJECTION)), &mut y);
    let largest = y.iter().map(|y| y.re.unsigned_abs().max(y.im.unsigned_abs())).max().unwrap();
    assert!((1 << 22..=1 << 23).contains(&largest), "{largest}");
    let mut silent = [Complex::new(1, 1); 4];
    assert_eq!(slow_time_shift(largest_part(&[ZERO_BEAT; 4], &UNIT_PROJECTION)), 0);
    project(&[ZERO_BEAT; 4], &UNIT_PROJECTION, 0, &mut silent);
    assert_eq!(silent, [Complex::new(0, 0); 4]);
}

#[test]
fn a_shift_of_any_length_is_a_division() {
    let beats = noise(3, 4);
    let shifted = |shift| {
        let mut y = [Complex::new(1, 1); 4];
        project(&beats, &UNIT_PROJECTION, shift, &mut y);
        y
    };
    let exact = |shift: u32| -> Vec<Complex<i32>> {
        let half_up = |sum: i64| ((i128::from(sum) * 2 + (1 << shift)) >> (shift + 1)) as i32;
        let sum = |beat: &Beat, part: fn(&Complex<i32>) -> i32| {
            half_up(beat.iter().map(|z| i64::from(part(z))).sum::<i64>() << PROJECTION_BITS)
        };
        beats.iter().map(|beat| Complex::new(sum(beat, |z| z.re), sum(beat, |z| z.im))).collect()
    };
    for shift in [30, 40, 57, 62, 63] {
        assert_eq!(shifted(shift), exact(shift)[..], "{shift}");
    }
    for shift in [63, 64, 70, u32::MAX] {
        assert_eq!(shifted(shift), [Complex::new(0, 0); 4], "{shift}");
    }
}
