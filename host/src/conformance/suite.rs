//! The inputs of the conformance suite, and the file in which firmware reads them.
//!
//! Little-endian: `SDPS`, u32 version 3, u32 cases; per case u32 model length, u32 slots, u32 transform (0 floats, 1
//! integers), u32 values of a slot, the model and then the slots (i16; I and Q in turn of a complex converter), each padded to
//! four bytes; then u32 period, spacing, sensing, K and K shares.

use crate::formats::model_file::RADAR_AT;
use crate::formats::slots::Slots;
use rand_core::{Rng, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;
use sdp3_core::config::{Dechirp, RadarConfig, SampleFormat};

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
    pub slots: Slots,
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
        word(&mut bytes, 3);
        word(&mut bytes, self.cases.len() as u32);
        for case in &self.cases {
            word(&mut bytes, case.model.len() as u32);
            word(&mut bytes, case.slots.len() as u32);
            word(&mut bytes, u32::from(case.transform == Transform::Fixed));
            word(&mut bytes, case.slots.per_slot as u32);
            for part in [&case.model, &case.slots.to_le_bytes()] {
                bytes.extend(part);
                bytes.resize(bytes.len().next_multiple_of(4), 0);
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

/// Inputs no room produces, for the radar of a model file and by both transforms: silence, full scale, saturation, noise and a
/// single moving echo.
pub fn stimuli(model: &[u8], slots: usize, seed: u64) -> Vec<Case> {
    let radar = radar_of(model);
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(seed);
    let make = |name: &str, sample: &mut dyn FnMut(usize, usize) -> [i16; 2]| {
        let mut made = Slots::with_capacity(radar.values_per_slot(), slots);
        for slot in 0..slots {
            for n in 0..usize::from(radar.samples) {
                let [i, q] = sample(slot, n);
                made.values.push(i);
                made.values.extend((radar.format == SampleFormat::Complex).then_some(q));
            }
        }
        let (name, model) = (name.to_owned(), model.to_vec());
        Case { name, model, transform: Transform::Float, slots: made }
    };
    let l = f64::from(radar.samples);
    let echo = |slot: usize, n: usize, amplitude: f64| {
        // from a target that moves by a wavelength in 50 slots
        let moved = slot as f64 / 50.0;
        let t = (n + 1) as f64;
        let turn = match (radar.dechirp, radar.gate) {
            // a chirp returned with a delay of two samples in a thousand
            (Dechirp::Digital, _) => t * t / (2.0 * l) - 2.0 / l * t + moved,
            // a beat in the third range sample, or of two turns a sweep
            (Dechirp::Analog, Some(gate)) => {
                (f64::from(gate.first_bin) + 2.5 * f64::from(gate.bins_per_sample)) / l * t - moved
            }
            (Dechirp::Analog, None) => 2.0 / l * t - moved,
        };
        let phase = std::f64::consts::TAU * (turn % 1.0);
        let round = |x: f64| libm::round(amplitude * x).clamp(-32768.0, 32767.0) as i16;
        [round(libm::cos(phase)), round(libm::sin(phase))]
    };
    let cases = [
        make("silence", &mut |_, _| [0; 2]),
        make("full-scale-alternating", &mut |slot, n| {
            let value = if (slot + n).is_multiple_of(2) { i16::MAX } else { i16::MIN };
            [value, !value]
        }),
        make("saturating-echo", &mut |slot, n| echo(slot, n, 60_000.0)),
        make("noise", &mut |_, _| {
            let word = rng.next_u64();
            [word as i16, (word >> 16) as i16]
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

/// The radar a model file is for; the paper's if its header says nothing that can be.
fn radar_of(model: &[u8]) -> RadarConfig {
    let bytes = model.get(RADAR_AT..).and_then(<[u8]>::first_chunk);
    bytes.and_then(|bytes| RadarConfig::from_bytes(*bytes)).unwrap_or(RadarConfig::PAPER)
}
