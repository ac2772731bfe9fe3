//! The core against the reference, value for value.
//!
//! Each stage's reference takes the core's previous output, so that each stage is judged alone. Integer stages must
//! agree bit for bit. Float stages are held to these bounds:
//! - weights: a backward error of 64 eps, eps = 2^-23, whatever the gaps between eigenvalues: see
//!   [`signal::backward_error`]. The f32 Jacobi sweeps perturb the matrix (trace 1) by a few dozen eps at most.
//! - frames: `2^-18` of the sum of the windowed magnitudes: the f32 window is off by at most 2e-6 of its value, the
//!   radix-2 transform adds eight roundings.
//! - frames in integers: 57 LSB beyond that, 40 in each part: see [`sdp3_core::signal::stft::FixedStft`].
//! - confidence: 0.6 %, twice the error of the core's fast exponential.

use super::reference::{network, schedule, signal};
use super::suite::{Case, Suite, Transform};
use crate::network::memory::OwnedMemory;
use crate::results::{StageVerdict, TargetVerdict};
use rayon::prelude::*;
use sdp3_core::dims::{Beat, Complex, FFT_LEN};
use sdp3_core::dsn::Model;
use sdp3_core::probe::Probe;
use sdp3_core::scheduler::{Plan, Sequencer, SlotUse};
use sdp3_core::signal::clutter::Gram;
use sdp3_core::signal::stft::{FixedStft, FloatStft, Stft};

/// Bound of the weights' backward error: see the module.
const WEIGHT_BOUND: f64 = 64.0 / 8_388_608.0;
/// Bound of a bin's error relative to the sum of the windowed magnitudes.
const FRAME_BOUND: f64 = 1.0 / 262_144.0;
/// What a bin in integers may be off beyond that, in LSB.
const FIXED_BOUND: f64 = 57.0;
/// Bound of the confidence's relative error.
const CONFIDENCE_BOUND: f64 = 6e-3;

/// Why a case cannot be run at all.
#[derive(Debug, thiserror::Error)]
#[error("case {case}: {reason}")]
pub struct CaseError {
    /// The case.
    pub case: String,
    /// What the core said.
    pub reason: String,
}

/// Runs the core on a case under a probe.
///
/// # Errors
///
/// [`CaseError`] if the model is refused or the number of slots is not the model's.
pub fn run_core(case: &Case, probe: &mut impl Probe) -> Result<(), CaseError> {
    match case.transform {
        Transform::Float => run_by::<FloatStft>(case, probe),
        Transform::Fixed => run_by::<FixedStft>(case, probe),
    }
}

fn run_by<T: Stft>(case: &Case, probe: &mut impl Probe) -> Result<(), CaseError> {
    let fail = |reason: String| CaseError { case: case.name.clone(), reason };
    let model = Model::parse(&case.model).map_err(|e| fail(e.to_string()))?;
    let mut memory = OwnedMemory::for_model(&model);
    let mut pipeline = memory.pipeline::<T>(model).map_err(|e| fail(e.to_string()))?;
    for slot in &case.slots {
        pipeline.push(slot, probe).map_err(|e| fail(e.to_string()))?;
    }
    let missing = fail(format!("{} of {} sensing slots", pipeline.taken(), model.sensing_slots()));
    pipeline.classify(probe).map(|_| ()).ok_or(missing)
}

/// Keeps every stage's values.
#[derive(Default)]
struct Recorder {
    beats: Vec<Vec<signal::Int>>,
    gram: Vec<signal::Int>,
    projection: Vec<signal::Int>,
    slow_time: Vec<signal::Int>,
    frames: Vec<Vec<(f32, f32)>>,
    fixed_frames: Vec<Vec<signal::Int>>,
    image: Vec<i8>,
    layers: Vec<Vec<i64>>,
    logits: Vec<i64>,
    class: Option<usize>,
    confidence: f64,
}

fn ints(values: &[Complex<i32>]) -> Vec<signal::Int> {
    values.iter().map(|z| (i64::from(z.re), i64::from(z.im))).collect()
}

impl Probe for Recorder {
    fn beat(&mut self, beat: &Beat) {
        self.beats.push(ints(beat));
    }
    fn gram(&mut self, gram: &Gram) {
        self.gram = gram.upper().iter().map(|z| (z.re, z.im)).collect();
    }
    fn projection(&mut self, projection: &Beat) {
        self.projection = ints(projection);
    }
    fn slow_time(&mut self, slow_time: &[Complex<i32>]) {
        self.slow_time = ints(slow_time);
    }
    fn frame(&mut self, _k: usize, spectrum: &[Complex<f32>; FFT_LEN]) {
        self.frames.push(spectrum.iter().map(|z| (z.re, z.im)).collect());
    }
    fn fixed_frame(&mut self, _k: usize, spectrum: &[Complex<i32>; FFT_LEN]) {
        self.fixed_frames.push(ints(spectrum));
    }
    fn image(&mut self, image: &[i8]) {
        self.image = image.to_vec();
    }
    fn layer(&mut self, _index: usize, activations: &[i8]) {
        self.layers.push(activations.iter().map(|&a| i64::from(a)).collect());
    }
    fn logits(&mut self, logits: &[i8]) {
        self.logits = logits.iter().map(|&a| i64::from(a)).collect();
    }
    fn class(&mut self, class: u8) {
        self.class = Some(usize::from(class));
    }
    fn confidence(&mut self, confidence: f32) {
        self.confidence = f64::from(confidence);
    }
}

fn largest(errors: &[f64]) -> f64 {
    errors.iter().copied().fold(0.0, f64::max)
}

/// Counts of one stage.
struct Tally {
    stage: &'static str,
    rule: String,
    compared: u64,
    mismatches: u64,
    largest_error: Option<f64>,
    first: Option<String>,
}

impl Tally {
    fn bits(stage: &'static str) -> Self {
        Tally { stage, rule: "bits".into(), compared: 0, mismatches: 0, largest_error: None, first: None }
    }

    fn exact<T: PartialEq + std::fmt::Debug>(&mut self, found: &[T], expected: &[T]) {
        self.compared += found.len().max(expected.len()) as u64;
        self.mismatches += found.len().abs_diff(expected.len()) as u64;
        for (index, (f, e)) in found.iter().zip(expected).enumerate() {
            if f != e {
                self.mismatches += 1;
                self.first.get_or_insert_with(|| format!("index {index}: expected {e:?}, found {f:?}"));
            }
        }
        if found.len() != expected.len() {
            self.first
                .get_or_insert_with(|| format!("{} values expected, {} found", expected.len(), found.len()));
        }
    }

    /// Compares an error already divided by its bound's scale with the bound.
    fn bounded(&mut self, index: usize, error: f64, bound: f64) {
        self.compared += 1;
        let largest = self.largest_error.get_or_insert(0.0);
        *largest = largest.max(error);
        if error > bound || error.is_nan() {
            self.mismatches += 1;
            self.first.get_or_insert_with(|| format!("index {index}: error {error:.3e}, bound {bound:.3e}"));
        }
    }
}

/// All stages of one case.
fn compare_case(case: &Case) -> Result<Vec<Tally>, CaseError> {
    let mut core = Recorder::default();
    run_core(case, &mut core)?;
    let header = network::header(&case.model);

    let mut beat = Tally::bits("beat");
    beat.exact(&[core.beats.len()], &[case.slots.len()]);
    for (slot, found) in case.slots.iter().zip(&core.beats) {
        beat.exact(found, &signal::beat(slot, &header.radar));
    }
    let beats = if header.radar.one_sided() { signal::turned(&core.beats) } else { core.beats.clone() };
    let mut gram = Tally::bits("gram");
    gram.exact(&core.gram, &signal::gram(&beats));

    let mut weights = Tally { rule: "backward error <= 2^-17".into(), ..Tally::bits("projection") };
    let scale = f64::from(1 << 28);
    let found: Vec<_> =
        core.projection.iter().map(|w| signal::Float::new(w.0 as f64 / scale, w.1 as f64 / scale)).collect();
    // a decision too near its threshold may be either
    let errors = signal::first_kept(&core.beats, &core.gram, header.first, header.last)
        .into_iter()
        .map(|first| signal::backward_error(&core.gram, first, header.last, &found))
        .min_by(|a, b| largest(a).total_cmp(&largest(b)))
        .unwrap_or_default();
    for (index, error) in errors.into_iter().enumerate() {
        weights.bounded(index, error, WEIGHT_BOUND);
    }

    let mut slow_time = Tally::bits("slow-time");
    slow_time.exact(&core.slow_time, &signal::slow_time(&beats, &core.projection));

    let frame = match case.transform {
        Transform::Float => compare_frames(&core, &header),
        Transform::Fixed => compare_fixed_frames(&core, &header),
    };
    let mut image = Tally::bits("image");
    let levels = match case.transform {
        Transform::Float => signal::levels(&core.frames, header.bins_per_row),
        Transform::Fixed => signal::fixed_levels(&core.fixed_frames, header.bins_per_row),
    };
    image.exact(&core.image, &signal::image(&levels, header.range));

    let reference = network::infer(&case.model, &core.image);
    let mut layer = Tally::bits("layer");
    layer.exact(&core.layers.concat(), &reference.layers.concat());
    let mut logits = Tally::bits("logits");
    logits.exact(&core.logits, &reference.logits);
    let mut class = Tally::bits("class");
    let first_of_largest = |logits: &[i64]| {
        let most = logits.iter().max()?;
        logits.iter().position(|logit| logit == most)
    };
    class.exact(&[core.class], &[first_of_largest(&reference.logits)]);
    let mut confidence = Tally { rule: "relative error <= 0.6 %".into(), ..Tally::bits("confidence") };
    confidence.bounded(0, (core.confidence / reference.confidence - 1.0).abs(), CONFIDENCE_BOUND);
    Ok(vec![beat, gram, weights, slow_time, frame, image, layer, logits, class, confidence])
}

fn compare_frames(core: &Recorder, header: &network::Header) -> Tally {
    let mut frame = Tally { rule: "|error| <= 2^-18 sum |x|".into(), ..Tally::bits("frame") };
    let window = signal::kaiser(header.window, header.beta);
    frame.exact(&[core.frames.len()], &[header.frames]);
    for (k, found) in core.frames.iter().enumerate() {
        let (bins, total) = signal::frame(&core.slow_time, &window, k * header.hop);
        for (index, (found, expected)) in found.iter().zip(&bins).enumerate() {
            let (re, im) = (f64::from(found.0) - expected.re, f64::from(found.1) - expected.im);
            let error = (re * re + im * im).sqrt();
            frame.bounded(256 * k + index, if total > 0.0 { error / total } else { error }, FRAME_BOUND);
        }
    }
    frame
}

/// The bins that become rows; half of them for a window of more than half the transform.
fn compare_fixed_frames(core: &Recorder, header: &network::Header) -> Tally {
    let mut frame =
        Tally { rule: "|error| <= 2^-18 sum |x| + 57".into(), ..Tally::bits("frame in integers") };
    let window = signal::kaiser(header.window, header.beta);
    let scale = if header.window > 128 { 0.5 } else { 1.0 };
    frame.exact(&[core.fixed_frames.len()], &[header.frames]);
    for (k, found) in core.fixed_frames.iter().enumerate() {
        let (bins, total) = signal::frame(&core.slow_time, &window, k * header.hop);
        let kept = 32 * header.bins_per_row;
        for bin in (0..kept).chain(256 - kept..256) {
            let (found, expected) = (found[bin], bins[bin]);
            let (re, im) = (found.0 as f64 - scale * expected.re, found.1 as f64 - scale * expected.im);
            let bound = FRAME_BOUND * scale * total + FIXED_BOUND;
            frame.bounded(256 * k + bin, (re * re + im * im).sqrt() / bound, 1.0);
        }
    }
    frame
}

/// One period of the core's scheduler: 255 sensing, else the user; empty if the plan is refused.
pub fn play_schedule(suite: &Suite) -> Vec<u8> {
    let s = &suite.schedule;
    let Ok(plan) = Plan::new(s.period, s.spacing, s.sensing, &s.shares) else { return Vec::new() };
    let mut sequencer = Sequencer::new(&plan);
    (0..s.period)
        .map(|_| match sequencer.next_slot() {
            SlotUse::Communication(k) => k,
            _ => u8::MAX,
        })
        .collect()
}

/// Holds the core on this machine to the reference.
///
/// # Errors
///
/// [`CaseError`] if a case cannot be run.
pub fn verify_host(suite: &Suite) -> Result<TargetVerdict, CaseError> {
    let per_case: Vec<Vec<Tally>> = suite.cases.par_iter().map(compare_case).collect::<Result<_, _>>()?;
    let s = &suite.schedule;
    let expected: Vec<u8> = schedule::period(s.period, s.spacing, s.sensing, &s.shares)
        .into_iter()
        .map(|slot| slot.map_or(u8::MAX, |k| k as u8))
        .collect();
    let mut played = Tally::bits("schedule");
    played.exact(&play_schedule(suite), &expected);

    let mut detail = None;
    let mut stages: Vec<StageVerdict> = Vec::new();
    let named = suite.cases.iter().map(|case| case.name.as_str()).chain(["one period"]);
    for (name, tallies) in named.zip(per_case.into_iter().chain([vec![played]])) {
        for tally in tallies {
            if let Some(first) = &tally.first {
                detail.get_or_insert_with(|| format!("case {name}, stage {}, {first}", tally.stage));
            }
            match stages.iter_mut().find(|stage| stage.stage == tally.stage) {
                Some(stage) => {
                    stage.compared += tally.compared;
                    stage.mismatches += tally.mismatches;
                    stage.largest_error = stage
                        .largest_error
                        .zip(tally.largest_error)
                        .map(|(a, b)| a.max(b))
                        .or(stage.largest_error);
                }
                None => stages.push(StageVerdict {
                    stage: tally.stage.to_owned(),
                    compared: tally.compared,
                    mismatches: tally.mismatches,
                    rule: tally.rule,
                    largest_error: tally.largest_error,
                }),
            }
        }
    }
    Ok(TargetVerdict {
        name: "host-reference".into(),
        compared: stages.iter().map(|stage| stage.compared).sum(),
        mismatches: stages.iter().map(|stage| stage.mismatches).sum(),
        instructions: None,
        recognitions: Vec::new(),
        detail,
        stages,
    })
}
