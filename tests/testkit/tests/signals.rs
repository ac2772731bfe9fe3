//! The beat of a wide-band sensor against its discrete Fourier transform.

use core::f64::consts::TAU;
use sdp3_testkit::signals::{Echo, beat_echo, beat_echo_real};

/// Bin `bin` of the transform of interleaved complex samples: magnitude per sample and phase in cycles.
fn transform(samples: &[i16], bin: f64) -> (f64, f64) {
    let count = samples.len() as f64 / 2.0;
    let (mut re, mut im) = (0.0, 0.0);
    for (n, pair) in samples.chunks_exact(2).enumerate() {
        let (sine, cosine) = (TAU * bin * (n + 1) as f64 / count).sin_cos();
        let (i, q) = (f64::from(pair[0]), f64::from(pair[1]));
        (re, im) = (re + i * cosine + q * sine, im + q * cosine - i * sine);
    }
    (re.hypot(im) / count, im.atan2(re) / TAU)
}

#[test]
fn an_echo_is_in_the_bin_of_its_delay_and_its_phase_falls_as_it_approaches() {
    for (count, delay) in [(128, 13.0), (256, 70.0), (64, 2.0)] {
        let near = Echo { amplitude: 9000.0, delay, doppler: 0.125, ..Echo::default() };
        let far = Echo { amplitude: 500.0, delay: delay + 9.0, ..Echo::default() };
        for slot in [0, 1, 3] {
            let mut samples = vec![0; 2 * count];
            beat_echo(&[near, far], slot, &mut samples);
            let (magnitude, phase) = transform(&samples, delay);
            assert!((magnitude - 9000.0).abs() < 1.0, "{magnitude} in bin {delay}");
            assert!((phase + 0.125 * f64::from(slot)).abs() < 1e-4, "{phase} in slot {slot}");
            assert!((transform(&samples, delay + 9.0).0 - 500.0).abs() < 1.0);
            assert!(transform(&samples, -delay).0 < 1.0, "no image");

            let mut real = vec![0; count];
            beat_echo_real(&[near, far], slot, &mut real);
            assert!(real.iter().eq(samples.iter().step_by(2)));
        }
    }
}

#[test]
fn a_delay_moves_with_its_step_and_samples_are_clipped() {
    let moving = Echo { amplitude: 5000.0, delay: 20.0, delay_step: -2.5, ..Echo::default() };
    let mut samples = [0; 256];
    beat_echo(&[moving], 4, &mut samples);
    assert!((transform(&samples, 10.0).0 - 5000.0).abs() < 1.0);
    beat_echo(&[Echo { amplitude: 1e5, ..Echo::default() }], 0, &mut samples);
    assert!(samples.chunks_exact(2).all(|pair| pair == [i16::MAX, 0]));
}
