//! The inputs of the conformance suite, and the file in which firmware reads them.
//!
//! Little-endian: `SDPS`, u32 version 2, u32 cases; per case u32 model length, u32 slots, u32 transform (0 floats, 1
//! integers), the model padded to four bytes, the slots (interleaved i16 I/Q, 4000 bytes each); then u32 period, spacing,
//! sensing, K and K shares.

use rand_core::{Rng, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;
use sdp3_core::dims::{Iq, SLOT_SAMPLES, Slot};

/// The arithmetic of a spectrogram.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Transform {
    /// [`sdp3_core::signal::stft::FloatStft`].
    Float,
    /// [`sdp3_core::signal::stft::FixedStft`].
    Fixed,
}

/// One recording, the model that recognises it and the transform between them.
#[derive(Debug, Clone)]
pub struct Case {
    /// What the recording is.
    pub name: String,
    /// Model file.
    pub model: Vec<u8>,
    /// By which arithmetic.
    pub transform: Transform,
    /// Sensing slots.
    pub slots: Vec<Slot>,
}

/// A plan to be played for one period.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ScheduleCase {
    /// N.
    pub period: u32,
    /// N_m.
    pub spacing: u32,
    /// N_s.
    pub sensing: u32,
    /// N_c,k.
    pub shares: Vec<u32>,
}

/// Everything the targets are asked to compute.
#[derive(Debug, Clone)]
pub struct Suite {
    /// Recordings.
    pub cases: Vec<Case>,
    /// The plan.
    pub schedule: ScheduleCase,
}

impl Suite {
    /// The file firmware reads.
    pub fn to_bytes(&self) -> Vec<u8> {
        let mut bytes = b"SDPS".to_vec();
        let word = |bytes: &mut Vec<u8>, value: u32| bytes.extend(value.to_le_bytes());
        word(&mut bytes, 2);
        word(&mut bytes, self.cases.len() as u32);
        for case in &self.cases {
            word(&mut bytes, case.model.len() as u32);
            word(&mut bytes, case.slots.len() as u32);
            word(&mut bytes, u32::from(case.transform == Transform::Fixed));
            bytes.extend(&case.model);
            bytes.resize(bytes.len().next_multiple_of(4), 0);
            for sample in case.slots.iter().flatten() {
                bytes.extend(sample.to_le_bytes());
            }
        }
        let s = &self.schedule;
        for value in [s.period, s.spacing, s.sensing, s.shares.len() as u32] {
            word(&mut bytes, value);
        }
        s.shares.iter().for_each(|&share| word(&mut bytes, share));
        bytes
    }
}

/// Inputs no room produces, by both transforms: silence, full scale, saturation, noise and a single moving echo.
pub fn stimuli(model: &[u8], slots: usize, seed: u64) -> Vec<Case> {
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(seed);
    let make = |name: &str, sample: &mut dyn FnMut(usize, usize) -> Iq| Case {
        name: name.to_owned(),
        model: model.to_vec(),
        transform: Transform::Float,
        slots: (0..slots).map(|slot| std::array::from_fn(|n| sample(slot, n))).collect(),
    };
    let echo = |slot: usize, n: usize, amplitude: f64| {
        // a chirp returned with a delay of 20 ns from a target that moves by a wavelength in 50 slots
        let t = (n + 1) as f64;
        let turn = t * t / 2000.0 - 0.002 * t + slot as f64 / 50.0;
        let phase = std::f64::consts::TAU * (turn % 1.0);
        let round = |x: f64| libm::round(amplitude * x).clamp(-32768.0, 32767.0) as i16;
        Iq { i: round(libm::cos(phase)), q: round(libm::sin(phase)) }
    };
    let cases = [
        make("silence", &mut |_, _| Iq::default()),
        make("full-scale-alternating", &mut |slot, n| {
            let value = if (slot + n).is_multiple_of(2) { i16::MAX } else { i16::MIN };
            Iq { i: value, q: !value }
        }),
        make("saturating-echo", &mut |slot, n| echo(slot, n, 60_000.0)),
        make("noise", &mut |_, _| {
            let word = rng.next_u64();
            Iq { i: word as i16, q: (word >> 16) as i16 }
        }),
        make("moving-echo", &mut |slot, n| echo(slot, n, 3_000.0)),
    ];
    let fixed = cases.iter().map(|case| Case {
        name: format!("{}, in integers", case.name),
        transform: Transform::Fixed,
        ..case.clone()
    });
    cases.iter().cloned().chain(fixed).collect()
}

const _: () = assert!(SLOT_SAMPLES == 1000, "the suite file states 4000 bytes a slot");
