//! Tests of `signal::stft`.

use sdp3_core::dims::Complex;
use sdp3_core::signal::stft::*;

#[test]
fn frame_counts_are_the_papers() {
    assert_eq!(frames(200, 128, 8), 10);
    assert_eq!(frames(1000, 128, 8), 110);
    assert_eq!(frames(127, 128, 8), 0);
}

#[test]
fn a_tone_lands_in_its_bin() {
    let stft = FloatStft::new(128, 10.0, 8);
    let tone: [Complex<i32>; 160] = core::array::from_fn(|n| {
        let phase = 2.0 * core::f64::consts::PI * 20.0 * n as f64 / 256.0;
        Complex::new((4e6 * libm::cos(phase)) as i32, (4e6 * libm::sin(phase)) as i32)
    });
    let mut spectrum = ZERO_SPECTRUM;
    for k in 0..stft.frames(tone.len()) {
        stft.frame(&tone, k, 1, &mut spectrum);
        let loudest = (0..256).max_by(|&a, &b| spectrum[a].norm_sqr().total_cmp(&spectrum[b].norm_sqr()));
        assert_eq!(loudest, Some(20));
    }
}

#[test]
fn the_window_is_symmetric_and_peaks_in_the_middle() {
    let stft = FloatStft::new(128, 10.0, 8);
    let window = stft.window();
    assert_eq!(window.len(), 128);
    for n in 0..64 {
        assert_eq!(window[n], window[127 - n]);
    }
    // scipy.signal.windows.kaiser(128, 10, sym=True)
    assert!((window[0] - 3.551_494e-4).abs() < 1e-8, "{}", window[0]);
    assert!((window[63] - 0.999_706).abs() < 1e-5, "{}", window[63]);
}

#[test]
fn arguments_out_of_range_are_taken_to_the_nearest_legal_value() {
    for (stated, taken) in
        [(200.0, 40.0), (f32::INFINITY, 40.0), (f32::MAX, 40.0), (-1.0, 0.0), (f32::NAN, 0.0)]
    {
        let (stated_f32, taken_f32) = (FloatStft::new(128, stated, 8), FloatStft::new(128, taken, 8));
        assert_eq!(stated_f32.window(), taken_f32.window(), "{stated}");
        assert!(stated_f32.window().iter().all(|w| (0.0..=1.0).contains(w)), "{stated}");
        let (stated_fixed, taken_fixed) = (FixedStft::new(128, stated, 8), FixedStft::new(128, taken, 8));
        assert_eq!(stated_fixed.window(), taken_fixed.window(), "{stated}");
    }
    for (length, hop, taken) in
        [(128, 300, (128, 128)), (128, 0, (128, 1)), (0, 9, (2, 2)), (999, 999, (256, 256))]
    {
        for slots in [0, 127, 128, 255, 256, 300, 1000] {
            let wanted = frames(slots, taken.0, taken.1);
            assert_eq!(FloatStft::new(length, 10.0, hop).frames(slots), wanted, "{length} {hop} {slots}");
            assert_eq!(FixedStft::new(length, 10.0, hop).frames(slots), wanted, "{length} {hop} {slots}");
        }
    }
}
