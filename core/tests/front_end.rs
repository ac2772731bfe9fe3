//! Slots to image: legal settings, how much it takes, when there is an image and what rows it has.

mod support;

use sdp3_core::config::{Dechirp, RadarConfig, SampleFormat};
use sdp3_core::dims::{BEATS, Beat, Complex, ROWS, ZERO_BEAT};
use sdp3_core::signal::clutter::{ADAPTIVE, GRAM_SLOTS, SvdRange};
use sdp3_core::signal::front_end::{FrontEnd, Preprocessing};
use sdp3_core::signal::stft::{FixedStft, FloatStft, Stft};
use support::{Memory, noise_slots};

/// An echo that rotates by `bin` 256ths of a turn a slot, the same in all range cells.
fn tone(n: usize, bin: i32) -> Beat {
    let angle = core::f64::consts::TAU * f64::from(bin) * n as f64 / 256.0;
    [Complex::new((1e6 * angle.cos()) as i32, (1e6 * angle.sin()) as i32); BEATS]
}

const EVERYTHING: SvdRange = SvdRange { first: 1, last: 8 };

#[test]
fn settings_have_their_ranges() {
    let legal = Preprocessing::default();
    let with = |change: &dyn Fn(&mut Preprocessing)| {
        let mut settings = legal;
        change(&mut settings);
        let made = FrontEnd::<FloatStft>::new(
            RadarConfig::PAPER,
            settings,
            Memory::of_front_end(200, 10).view().front_end,
        )
        .is_some();
        assert_eq!(made, settings.illegal(&RadarConfig::PAPER).is_none());
        made
    };
    assert!(with(&|_| ()));
    for (first, last, valid) in [
        (1, 1, true),
        (1, 8, true),
        (8, 8, true),
        (0, 8, true),
        (0, 0, false),
        (9, 9, false),
        (3, 2, false),
        (2, 9, false),
    ] {
        assert_eq!(with(&|s| s.kept = SvdRange { first, last }), valid, "{first} {last}");
    }
    for (window, hop, valid) in [
        (2, 1, true),
        (2, 2, true),
        (256, 256, true),
        (1, 1, false),
        (257, 8, false),
        (128, 0, false),
        (128, 129, false),
    ] {
        assert_eq!(with(&|s| (s.window, s.hop) = (window, hop)), valid, "{window} {hop}");
    }
    for (beta, valid) in [(0.0, true), (40.0, true), (-0.1, false), (40.1, false), (f32::NAN, false)] {
        assert_eq!(with(&|s| s.beta = beta), valid, "{beta}");
    }
    for (bins, valid) in [(1, true), (2, true), (4, true), (0, false), (3, false), (8, false)] {
        assert_eq!(with(&|s| s.bins_per_row = bins), valid, "{bins}");
    }
    for (range, valid) in [(1, true), (4095, true), (0, false), (4096, false)] {
        assert_eq!(with(&|s| s.range = range), valid, "{range}");
    }
}

#[test]
fn a_component_is_left_of_every_sensors_range_samples() {
    for (range_samples, first, valid) in
        [(1, 0, true), (1, 1, true), (1, 2, false), (1, 8, false), (4, 4, true), (4, 5, false)]
    {
        let config = RadarConfig { samples: 64, range_samples, ..RadarConfig::DOPPLER };
        let settings = Preprocessing { kept: SvdRange { first, last: 8 }, ..Preprocessing::default() };
        let mut memory = Memory::of_front_end(200, 10);
        let made = FrontEnd::<FloatStft>::new(config, settings, memory.view().front_end).is_some();
        assert_eq!(made, valid, "{first} of {range_samples}");
    }
}

#[test]
fn it_takes_what_the_least_buffer_holds() {
    let mut memory = Memory::of_front_end(200, 0);
    memory.workspace.pop();
    let settings = Preprocessing::default();
    assert!(FrontEnd::<FloatStft>::new(RadarConfig::PAPER, settings, memory.view().front_end).is_none());
    for (beats, wanted) in [(200, 200), (GRAM_SLOTS + 1, GRAM_SLOTS)] {
        let mut memory = Memory::of_front_end(beats, 0);
        let mut front_end =
            FrontEnd::<FloatStft>::new(RadarConfig::PAPER, settings, memory.view().front_end).expect("legal");
        assert_eq!(front_end.capacity(), wanted);
        for n in 0..wanted {
            assert_eq!(front_end.taken(), n);
            assert!(front_end.push_beat(tone(n, 3), &mut ()));
        }
        assert!(!front_end.push_beat(ZERO_BEAT, &mut ()));
        assert!(!front_end.push(&noise_slots(1, 1)[0], &mut ()));
        assert_eq!(front_end.taken(), wanted);
        front_end.reset();
        assert_eq!(front_end.taken(), 0);
    }
}

#[test]
fn an_image_begins_with_one_window_and_ends_with_its_memory() {
    // two frames fit
    let mut memory = Memory::of_front_end(200, 2);
    let settings = Preprocessing { kept: EVERYTHING, ..Preprocessing::default() };
    let mut front_end =
        FrontEnd::<FloatStft>::new(RadarConfig::PAPER, settings, memory.view().front_end).expect("legal");
    for n in 0..160 {
        let frames = front_end.image(&mut ()).map(|image| image.len() / ROWS);
        let wanted = match n {
            0..128 => None,
            128..136 => Some(1),
            136..144 => Some(2),
            _ => None, // three do not
        };
        assert_eq!(frames, wanted, "after {n} slots");
        assert!(front_end.push_beat(tone(n, 3), &mut ()));
    }
    assert_eq!(settings.frames(136), 2);
}

/// The brightest row of every frame.
fn rows<T: Stft>(settings: Preprocessing, bin: i32) -> Vec<usize> {
    let mut memory = Memory::of_front_end(144, 3);
    let mut front_end =
        FrontEnd::<T>::new(RadarConfig::PAPER, settings, memory.view().front_end).expect("legal");
    (0..144).for_each(|n| assert!(front_end.push_beat(tone(n, bin), &mut ())));
    let image = front_end.image(&mut ()).expect("three frames");
    let bright = |frame: usize| (0..ROWS).max_by_key(|row| image[row * 3 + frame]);
    (0..3).filter_map(bright).collect()
}

#[test]
fn a_tone_lies_in_its_row() {
    for bins in [1, 2, 4_u8] {
        let settings = Preprocessing { kept: EVERYTHING, bins_per_row: bins, ..Preprocessing::default() };
        for row in [0, 5, 31, 32, 33, 63] {
            let bin = (row - 32) * i32::from(bins) + i32::from(bins) / 2;
            assert_eq!(rows::<FloatStft>(settings, bin), [row as usize; 3], "{bins} bins a row, bin {bin}");
            assert_eq!(rows::<FixedStft>(settings, bin), [row as usize; 3], "{bins} bins a row, bin {bin}");
        }
    }
}

#[test]
fn one_output_has_its_frequencies_from_zero_to_half_the_slot_rate() {
    let settings = Preprocessing { kept: EVERYTHING, bins_per_row: 2, ..Preprocessing::default() };
    for row in [1, 5, 31, 32, 40, 62] {
        let mut memory = Memory::of_front_end(144, 3);
        let mut front_end =
            FrontEnd::<FixedStft>::new(RadarConfig::DOPPLER, settings, memory.view().front_end)
                .expect("legal");
        for n in 0..144 {
            let angle = core::f64::consts::TAU * (2.0 * f64::from(row) + 0.5) * f64::from(n) / 256.0;
            assert!(front_end.push(&[(8000.0 * angle.cos()) as i16], &mut ()));
        }
        let image = front_end.image(&mut ()).expect("three frames");
        for frame in 0..3 {
            let bright = (0..ROWS).max_by_key(|row| image[row * 3 + frame]);
            assert_eq!(bright, Some(row as usize), "frame {frame}");
        }
    }
    assert!(RadarConfig::DOPPLER.one_sided());
    assert!(!RadarConfig::DOPPLER_IQ.one_sided() && !RadarConfig::BGT60.one_sided());
}

/// The brightest row of every frame of static blocks of thousands and a mover of 100 at 0.1 cycles a slot; 200 slots.
fn rows_of_clutter(format: SampleFormat, first: u8) -> Vec<usize> {
    let radar = RadarConfig { samples: 64, format, dechirp: Dechirp::Analog, ..RadarConfig::PAPER };
    let kept = SvdRange { first, last: 8 };
    let settings = Preprocessing { kept, bins_per_row: 2, ..Preprocessing::default() };
    let mut memory = Memory::of_front_end(200, 10);
    let mut front_end =
        FrontEnd::<FixedStft>::new(radar, settings, memory.view().front_end).expect("legal settings");
    for n in 0..200 {
        // the beat of a sweep is the conjugate of the range samples
        let (im, re) = (-core::f64::consts::TAU * 0.1 * f64::from(n)).sin_cos();
        let mut slot = vec![0; radar.values_per_slot()];
        for (k, sample) in slot.chunks_mut(radar.values_per_slot() / 64).enumerate() {
            let block = (k / 8) as i32;
            let mover = if block == 3 { 100.0 } else { 0.0 };
            let values = [5000 - 900 * block + (mover * re) as i32, 300 * block + (mover * im) as i32];
            sample.iter_mut().zip(values).for_each(|(to, value)| *to = value as i16);
        }
        assert!(front_end.push(&slot, &mut ()));
    }
    let image = front_end.image(&mut ()).expect("an image");
    let frames = image.len() / ROWS;
    (0..frames).filter_map(|frame| (0..ROWS).max_by_key(|row| image[row * frames + frame])).collect()
}

#[test]
fn what_is_static_is_dropped_of_one_output_too() {
    // 25.6 bins of 256 are nearest to bins 26 and 27, row 13 above 0 Hz: that is row 32 of complex samples and row 0 of real ones
    for first in [2, ADAPTIVE] {
        assert_eq!(rows_of_clutter(SampleFormat::Complex, first), [45; 10], "first {first}");
        assert_eq!(rows_of_clutter(SampleFormat::Real, first), [13; 10], "first {first}");
    }
    assert_eq!(rows_of_clutter(SampleFormat::Real, 1), [0; 10], "kept");
}
