//! What every command prints, the report shows and the tests check: one set of types, one JSON schema.
//!
//! The modules fill these in; nothing here computes. Every file holding them is a function of the
//! scenario and the seed alone: no clock, no host name, no thread count.

mod files;
mod inspection;
mod learned;
mod optimizer;
mod reproduction;
mod retested;
mod spread;
mod sweep;

pub use files::*;
pub use inspection::*;
pub use learned::*;
pub use optimizer::*;
pub use reproduction::*;
pub use retested::*;
pub use spread::*;
pub use sweep::*;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// The main job's result: what `sdp3 run --json` prints and `run.json` holds.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Run {
    /// Name of the scenario.
    pub scenario: String,
    /// Seed everything random was drawn from.
    pub seed: u64,
    /// AR(1) coefficient rho that was used, eq. (vit).
    pub rho: f64,
    /// Recognition accuracy for each number of sensing slots.
    pub accuracy: Vec<Accuracy>,
    /// The best learning curve through those accuracies.
    pub curve: Curve,
    /// Bit-for-bit comparison of the core with its reference and its firmware.
    pub verify: Verify,
    /// Pareto boundary of both user placements.
    pub region: Vec<RegionPoint>,
    /// The point handed to the scheduler.
    pub operating_point: OperatingPoint,
    /// What the core's scheduler did with it in one period.
    pub schedule: Schedule,
    /// Path of the report page, relative to the output folder.
    pub report: String,
}

/// Accuracy of one trained network, float and through the int8 core, on recordings that were not trained on.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Accuracy {
    /// Sensing slots per recording, `N_s`.
    pub sensing_slots: u32,
    /// Share recognised by the float network, 0 to 1.
    pub float: f64,
    /// Share recognised by `sdp3-core` from raw I/Q, 0 to 1.
    pub int8: f64,
    /// Number of test recordings.
    pub tested: u32,
}

/// One fitted learning curve `A(N_s)`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Curve {
    /// `pow3 log_power exp4 vapor_pressure log_log_linear ilog2 pow4`.
    pub model: String,
    /// Fitted parameters, named as in the paper's Table II.
    pub parameters: Parameters,
    /// Root of the mean squared residual.
    pub rmse: f64,
}

/// Parameters of a learning curve; a model that lacks one leaves it out.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
pub struct Parameters {
    /// First parameter.
    pub alpha: f64,
    /// Second parameter.
    pub beta: f64,
    /// Third parameter, if the model has one.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub gamma: Option<f64>,
    /// Fourth parameter, if the model has one.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub epsilon: Option<f64>,
}

/// All learning curves through one set of points: what `sdp3 predict --json` prints.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Prediction {
    /// Name of the model with the least Mallows' C_p.
    pub best: String,
    /// The points fitted.
    pub points: Vec<CurvePoint>,
    /// The `N_s` at which curves and band are stated, ascending.
    pub slots: Vec<f64>,
    /// Every model, best first.
    pub models: Vec<FittedCurve>,
    /// The models in the order of each figure of merit.
    pub ranking: Ranking,
    /// Confidence band of the best model; absent where points without counts and deviations are as few as its parameters.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub band: Option<Band>,
}

/// Names of the models, best first.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
pub struct Ranking {
    /// By sum of squared errors.
    pub sse: Vec<String>,
    /// By corrected Akaike criterion, those that have one.
    pub aicc: Vec<String>,
    /// By leave-one-out error, those that have one.
    pub loo: Vec<String>,
    /// By Mallows' C_p, which chooses.
    pub cp: Vec<String>,
}

/// A confidence band of a learning curve.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Band {
    /// Model.
    pub model: String,
    /// Share of the bootstrap's curves within it.
    pub coverage: f64,
    /// Redrawn curves.
    pub draws: u32,
    /// What the bootstrap draws from: `stated deviations`, `test counts`, or `residuals` where a point has neither.
    pub source: String,
    /// The band, N_s ascending.
    pub points: Vec<BandPoint>,
}

/// A confidence band at one N_s.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct BandPoint {
    /// `N_s`.
    pub sensing_slots: f64,
    /// Lower end.
    pub low: f64,
    /// Upper end.
    pub high: f64,
}

/// A measured accuracy.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct CurvePoint {
    /// `N_s`.
    pub sensing_slots: f64,
    /// Accuracy, 0 to 1.
    pub accuracy: f64,
    /// Number of recordings it was counted on, if known.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub tested: Option<f64>,
    /// Standard deviation of the accuracy, if known.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub std: Option<f64>,
}

/// One model's fit with its figures of merit.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct FittedCurve {
    /// Name of the model.
    pub name: String,
    /// Fitted parameters.
    pub parameters: Parameters,
    /// Its accuracies at [`Prediction::slots`].
    pub accuracy: Vec<f64>,
    /// Sum of squared errors.
    pub sse: f64,
    /// Root mean squared error.
    pub rmse: f64,
    /// Corrected Akaike criterion; absent where there are too few points for it.
    pub aicc: Option<f64>,
    /// Root mean squared leave-one-out error; absent where there are too few points for it.
    pub loo: Option<f64>,
}

/// Outcome of `sdp3 verify`: what was compared, and where it differed.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Verify {
    /// Values and digests compared, all targets.
    pub compared: u64,
    /// How many differed; a target that could not run counts as one.
    pub mismatches: u64,
    /// Each target.
    pub targets: Vec<TargetVerdict>,
}

/// One target of the conformance suite.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct TargetVerdict {
    /// `host-reference`, `cortex-m4f`, `riscv32imac`, ...
    pub name: String,
    /// Values (host reference) or stage digests (firmware) compared.
    pub compared: u64,
    /// How many differed.
    pub mismatches: u64,
    /// Instructions the target executed for one recognition of the largest recording; absent on the host.
    pub instructions: Option<u64>,
    /// Instructions of the costliest recognition for each number of sensing slots.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub recognitions: Vec<Counted>,
    /// First difference, or why the target could not run; absent when all agreed.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub detail: Option<String>,
    /// The stages compared on this target.
    pub stages: Vec<StageVerdict>,
}

/// Instructions of one recognition.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub struct Counted {
    /// `N_s`.
    pub sensing_slots: u32,
    /// Instructions, from the first sample to the class.
    pub instructions: u64,
}

/// One stage of one target.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct StageVerdict {
    /// `beat`, `gram`, `projection`, `slow-time`, `frame`, `image`, `layer`, `logits`, `schedule`.
    pub stage: String,
    /// Values or digests compared.
    pub compared: u64,
    /// How many differed, or exceeded the bound.
    pub mismatches: u64,
    /// `bits` for integer stages and digests, else the bound of the error.
    pub rule: String,
    /// Largest error seen, for float stages against the f64 reference.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub largest_error: Option<f64>,
}

/// A spectrogram as the network sees it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Spectrogram {
    /// Class, or the name of the recording.
    pub title: String,
    /// Doppler rows, most negative first.
    pub rows: u32,
    /// STFT frames.
    pub frames: u32,
    /// Doppler frequency of the first row in Hz.
    pub first_row_hz: f64,
    /// Spacing of the rows in Hz.
    pub row_hz: f64,
    /// Spacing of the frames in seconds.
    pub frame_s: f64,
    /// Carrier in Hz: 2 v / lambda is the Doppler of a radial speed v.
    pub carrier_hz: f64,
    /// What intensities 0 to 255 span, in dB below the maximum.
    pub range_db: f64,
    /// Intensities `[row][frame]`, from 0 (black, at or below the range) to 255 (the maximum).
    pub intensities: Vec<u8>,
}

/// One point of the KL curve.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct KlPoint {
    /// AR(1) coefficient rho of the room channel.
    pub rho: f64,
    /// Divergence of the measured from the simulated intensities, in nats.
    pub kl: f64,
    /// The same without intensity 0, which is at or below the dynamic range.
    pub kl_without_floor: f64,
}

/// An interval.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Interval {
    /// Lower end.
    pub low: f64,
    /// Upper end.
    pub high: f64,
}

/// A model of what the room adds to a person's echo, on the measured windows.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct RoomModel {
    /// `AR room`, `white noise` (rho = 1 and fitted white noise, the null model), or `static room` (rho = 1).
    pub model: String,
    /// Divergence of the measured from the simulated intensities in nats, at the model's best parameter.
    pub kl: f64,
    /// 95 % interval of what its divergence is above the AR room's, over bootstrap draws of windows.
    pub kl_excess: Option<Interval>,
    /// Itakura-Saito divergence of the measured from the model's mean spectrum.
    pub spectral: f64,
    /// 95 % interval of what it is above the AR room's, on windows left out of the fit.
    pub spectral_excess: Option<Interval>,
    /// Power of the white noise that fits the spectrum, over the echo's, in dB.
    pub noise_db: Option<f64>,
}

/// The room by three models on the same windows.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct RoomFit {
    /// Windows behind it.
    pub windows: u32,
    /// AR(1) coefficient rho that fits the spectrum.
    pub rho: f64,
    /// Its 95 % interval, over bootstrap draws of windows.
    pub rho_interval: Option<Interval>,
    /// Power of the room's mean over that of its fluctuation in dB that fits the spectrum, with the simulated room's mean.
    pub k_factor_db: f64,
    /// Its 95 % interval.
    pub k_factor_interval: Option<Interval>,
    /// The models, the AR room first.
    pub models: Vec<RoomModel>,
    /// Which model the windows speak for, in words.
    pub verdict: String,
}

/// Outcome of the calibration: what `sdp3 calibrate --json` prints.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Calibration {
    /// Where rho came from, in words: a measured file, or the stored table and its entry.
    pub source: String,
    /// Carrier of the measured signal in Hz.
    pub carrier_hz: f64,
    /// The rho in use.
    pub rho: f64,
    /// Time between the samples that rho correlates, in s.
    pub interval_s: f64,
    /// Divergence at that rho, if a curve was computed.
    pub kl: Option<f64>,
    /// Divergence at rho = 1 (no sensing uncertainty), if a curve was computed.
    pub kl_without_uncertainty: Option<f64>,
    /// The curve, rho ascending.
    pub curve: Vec<KlPoint>,
    /// rho and the fluctuation's power, and the models compared, where a signal was measured and the room has a mean.
    pub room: Option<RoomFit>,
    /// What the curve compares, in words.
    pub curve_of: String,
    /// Intensities of the measured signal: share of each level.
    pub measured_pmf: Vec<f64>,
    /// Intensities simulated at the chosen rho.
    pub simulated_pmf: Vec<f64>,
    /// The measured spectrogram, if there is one.
    pub measured: Option<Spectrogram>,
    /// A simulated one at the chosen rho.
    pub simulated: Option<Spectrogram>,
}

/// Counts of truth against answer.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Confusion {
    /// `N_s`.
    pub sensing_slots: u32,
    /// `float` or `int8`.
    pub arithmetic: String,
    /// Row: truth; column: answer.
    pub counts: Vec<Vec<u32>>,
}

/// Loss and accuracy of one training epoch.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Epoch {
    /// Mean cross entropy over the epoch's batches, in nats.
    pub loss: f64,
    /// Share of the training set answered right during the epoch.
    pub accuracy: f64,
    /// Mean cross entropy on the validation set after the epoch, in nats, if there is one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub validation_loss: Option<f64>,
    /// Share of the validation set answered right.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub validation_accuracy: Option<f64>,
}

/// How one network was trained.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Training {
    /// `N_s`.
    pub sensing_slots: u32,
    /// Trained parameters.
    pub parameters: u32,
    /// Each epoch.
    pub epochs: Vec<Epoch>,
    /// Cross entropy of the float network on the test set, in nats.
    pub float_loss: f64,
}

/// How every network of a folder was trained: what `training.json` holds.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct TrainingHistory {
    /// One network per `N_s`.
    pub networks: Vec<Training>,
}

impl TrainingHistory {
    /// Name of its file.
    pub const FILE: &str = "training.json";
}

/// Everything the pictures show, beside [`Run`]: what `figures.json` holds.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Figures {
    /// Class names, in the order of the labels.
    pub classes: Vec<String>,
    /// One spectrogram per class.
    pub spectrograms: Vec<Spectrogram>,
    /// The calibration.
    pub calibration: Calibration,
    /// Training histories.
    pub training: Vec<Training>,
    /// Confusion matrices.
    pub confusion: Vec<Confusion>,
    /// All learning curves.
    pub prediction: Prediction,
    /// Operating points by weight `w_A` (w_R = 1 - w_A, both objectives normalised), case by case.
    pub weighted: Vec<WeightedPoint>,
    /// User placements: bits per slot, borders of the zones, operating points.
    pub cases: Vec<Case>,
    /// The slots of every point of [`Run::region`].
    pub plans: Vec<SlotPlan>,
    /// `spectrograms` with early exits; absent if there are more networks than exits.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub early_exits: Option<EarlyExitGallery>,
}

/// Optimum of the weighted sum for one weight.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct WeightedPoint {
    /// User placement.
    pub case: u32,
    /// Weight of accuracy, 0 to 1.
    pub weight: f64,
    /// `N_s` of the optimum.
    pub sensing_slots: u32,
    /// Its accuracy.
    pub accuracy: f64,
    /// Its throughput in bits per period.
    pub throughput_bit: f64,
}

/// One property of a channel model.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Property {
    /// Whether the model has it; absent where its standard defines no echo of a person that could have it.
    pub verdict: Option<bool>,
    /// What was measured, where there is a verdict.
    pub statistic: Option<f64>,
    /// The threshold.
    pub threshold: f64,
    /// `>=` or `<=`: the side of the threshold on which the verdict is true.
    pub relation: String,
    /// The statistic in words.
    pub meaning: String,
    /// The paper's verdict, if its Table I has this model.
    pub paper: Option<bool>,
    /// Why the verdict differs from the paper's, if it does.
    pub reason: String,
}

/// A model's row of the table.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ModelRow {
    /// Its name.
    pub name: String,
    /// Its properties, by name.
    pub properties: BTreeMap<String, Property>,
}

/// The paper's Table I from data.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ChannelTable {
    /// Seed of the experiments.
    pub seed: u64,
    /// Carrier in Hz.
    pub carrier_hz: f64,
    /// A row for every model.
    pub models: Vec<ModelRow>,
}

/// A spectrogram of the gallery and what it shows.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct GallerySpectrogram {
    /// Channel model.
    pub model: String,
    /// Class.
    pub class: String,
    /// Its picture.
    pub spectrogram: Spectrogram,
}
