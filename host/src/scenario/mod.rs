//! A scenario: everything a run depends on besides its seed, read from TOML and validated once.
//!
//! Units are in the field names (`_m`, `_s`, `_hz`, `_db`, `_w`, `_deg`). Unknown keys are refused. Defaults are
//! the paper's section VI where it gives a value.

mod check;
mod defaults;

pub use check::ScenarioError;

use serde::{Deserialize, Serialize};
use std::path::PathBuf;

/// Speed of light in m/s.
pub const SPEED_OF_LIGHT: f64 = 299_792_458.0;

/// A person's motion: the five classes of the paper in the order of their labels, then those only simulated.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Class {
    /// A child or an adult standing.
    Standing,
    /// A child walking.
    ChildWalking,
    /// A child pacing (a slow walk).
    ChildPacing,
    /// An adult walking.
    AdultWalking,
    /// An adult pacing.
    AdultPacing,
    /// A child stepping on the spot.
    ChildStepping,
    /// An adult stepping on the spot.
    AdultStepping,
    /// A child running.
    ChildRunning,
    /// An adult running.
    AdultRunning,
}

impl Class {
    /// The paper's classes; the index is the label.
    pub const ALL: [Class; 5] =
        [Class::Standing, Class::ChildWalking, Class::ChildPacing, Class::AdultWalking, Class::AdultPacing];

    /// Every motion there is.
    pub const EVERY: [Class; 9] = [
        Class::Standing,
        Class::ChildWalking,
        Class::ChildPacing,
        Class::AdultWalking,
        Class::AdultPacing,
        Class::ChildStepping,
        Class::AdultStepping,
        Class::ChildRunning,
        Class::AdultRunning,
    ];

    /// Whether a child moves; standing people may be either.
    pub fn child(self) -> Option<bool> {
        match self {
            Class::Standing => None,
            Class::ChildWalking | Class::ChildPacing | Class::ChildStepping | Class::ChildRunning => {
                Some(true)
            }
            Class::AdultWalking | Class::AdultPacing | Class::AdultStepping | Class::AdultRunning => {
                Some(false)
            }
        }
    }

    /// Whether the person stays where it is.
    pub fn on_the_spot(self) -> bool {
        matches!(self, Class::Standing | Class::ChildStepping | Class::AdultStepping)
    }

    /// The name used in files and pages.
    pub fn name(self) -> &'static str {
        match self {
            Class::ChildStepping => "child-stepping",
            Class::AdultStepping => "adult-stepping",
            Class::ChildRunning => "child-running",
            Class::AdultRunning => "adult-running",
            Class::Standing => "standing",
            Class::ChildWalking => "child-walking",
            Class::ChildPacing => "child-pacing",
            Class::AdultWalking => "adult-walking",
            Class::AdultPacing => "adult-pacing",
        }
    }
}

/// Everything a run depends on besides its seed.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Scenario {
    /// Name shown in results.
    pub name: String,
    /// The room's walls.
    pub room: Room,
    /// The monostatic radar.
    pub radar: Radar,
    /// The time frame shared by sensing and communication.
    pub frame: Frame,
    /// The channel model.
    pub channel: Channel,
    /// The person sensed.
    pub target: Target,
    /// From slow time to the network's image.
    pub spectrogram: SpectrogramSettings,
    /// How networks are trained and tested.
    pub learning: Learning,
    /// The communication side.
    pub communication: Communication,
    /// The trade between the two.
    pub trade: Trade,
}

/// Room: a box with one corner at the origin.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Room {
    /// Length (x), width (y), height (z) in m.
    pub size_m: [f64; 3],
}

/// The radar at the base station. Sweep, bandwidth and sampling are the core's: 10 MHz in 100 us at 10 MHz.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Radar {
    /// Position in m.
    pub position_m: [f64; 3],
    /// Carrier frequency in Hz.
    pub carrier_hz: f64,
    /// Swept bandwidth in Hz: the radar module's, and the band the sub-carriers share.
    pub bandwidth_hz: f64,
    /// Transmit power in W.
    pub power_w: f64,
    /// Gain of the transmit antenna and of the receive antenna, each, in dB.
    pub antenna_gain_db: f64,
    /// Level of the side lobes below the main lobe in dB, each way: how others than the person sensed are seen.
    pub sidelobe_db: f64,
    /// Receiver noise figure in dB (290 K).
    pub noise_figure_db: f64,
    /// Head room between the strongest expected echo and the converter's full scale in dB.
    pub headroom_db: f64,
    /// Standard deviation of the oscillator's phase from slot to slot, after dechirping, in degrees.
    pub phase_noise_deg: f64,
    /// Gain mismatch of Q against I in dB.
    pub iq_gain_db: f64,
    /// Deviation of I and Q from quadrature in degrees.
    pub iq_phase_deg: f64,
}

/// Time frame: slots, period, spacing.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Frame {
    /// Slot duration T_s in s.
    pub slot_s: f64,
    /// Slots in a scheduling period, N.
    pub period_slots: u32,
    /// Communication slots between two sensing slots, N_m.
    pub spacing_slots: u32,
    /// The numbers of sensing slots N_s that are studied, ascending.
    pub sensing_slots: Vec<u32>,
}

/// How the room's channel remembers.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum ArMode {
    /// As printed: v_1 = Upsilon_1, v_j = rho v_{j-1} + (1 - rho) Upsilon_j.
    Paper,
    /// v_j = rho v_{j-1} + sqrt(1 - rho^2) Upsilon_j: the power does not depend on rho.
    VariancePreserving,
    /// Rays given by geometry keep their phase; only the diffuse rays are redrawn.
    Consistent,
}

/// Channel models, by the names of the paper's Table I.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Model {
    /// The data-assisted hybrid channel.
    Dahc,
    /// Primitives and a room that never changes.
    Primitive,
    /// Image method with Fresnel materials.
    RayTracing,
    /// Saleh-Valenzuela.
    Statistical,
    /// IEEE 802.11ay quasi-deterministic conference room.
    #[serde(rename = "80211ay")]
    Ieee80211ay,
    /// IEEE 802.11 TGn/TGac/TGax taps.
    #[serde(rename = "80211ax")]
    Ieee80211ax,
    /// 3GPP TR 38.901 indoor office.
    #[serde(rename = "38901")]
    Tr38901,
    /// QuaDRiGa's drifting clusters.
    Quadriga,
    /// METIS' map-based hybrid.
    Metis,
}

impl Model {
    /// All models.
    pub const ALL: [Model; 9] = [
        Model::Dahc,
        Model::Primitive,
        Model::RayTracing,
        Model::Statistical,
        Model::Ieee80211ay,
        Model::Ieee80211ax,
        Model::Tr38901,
        Model::Quadriga,
        Model::Metis,
    ];

    /// The name used on the command line and in files.
    pub fn name(self) -> &'static str {
        match self {
            Model::Dahc => "dahc",
            Model::Primitive => "primitive",
            Model::RayTracing => "ray-tracing",
            Model::Statistical => "statistical",
            Model::Ieee80211ay => "80211ay",
            Model::Ieee80211ax => "80211ax",
            Model::Tr38901 => "38901",
            Model::Quadriga => "quadriga",
            Model::Metis => "metis",
        }
    }
}

/// The TGn model that suits the room.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Tgn {
    /// Residential, rms delay spread 15 ns.
    B,
    /// Small office, 30 ns.
    C,
    /// Typical office, 50 ns.
    D,
}

/// When the room's recursion advances.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Advance {
    /// Once per sensing slot, as the authors' recordings were made.
    SensingSlot,
    /// Once per slot, also in those between two sensing slots.
    Slot,
}

/// Room channel statistics.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Clusters {
    /// IEEE 802.11ay conference room: image-method clusters with diffuse rays.
    #[serde(rename = "80211ay")]
    Ieee80211ay,
    /// IEEE 802.11ax / TGn model B taps.
    #[serde(rename = "80211ax")]
    Ieee80211ax,
}

/// The channel model and its settings.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Channel {
    /// Which model.
    pub model: Model,
    /// Memory of the room channel; absent: taken from the calibration table.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rho: Option<f64>,
    /// The recursion.
    pub mode: ArMode,
    /// Where the room's responses come from.
    pub clusters: Clusters,
    /// When the recursion advances.
    pub advance: Advance,
    /// Whether the room's response starts with the power it settles at instead of Upsilon's.
    pub stationary_start: bool,
    /// Taps of `80211ax` and of the hybrid channel with those statistics.
    pub tgn: Tgn,
    /// Whether people and furniture may block reflections (`80211ay` and the hybrid channel with those statistics).
    pub blockage: bool,
    /// Line of sight (`38901`, `quadriga`).
    pub line_of_sight: bool,
    /// Whether a second person walks in the room (the paper's scenario 2).
    pub interferer: bool,
}

/// The person sensed.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Target {
    /// Ground position at the start in m.
    pub start_m: [f64; 2],
    /// Way points on the ground in m; with two or more the walk leads through them and the heading is theirs.
    pub waypoints_m: Vec<[f64; 2]>,
    /// Whether who comes near a wall turns; else the walk goes straight on.
    pub turns: bool,
    /// Headings are uniform within plus or minus this many degrees around the direction to the radar.
    pub heading_spread_deg: f64,
    /// Standard deviation of the walking speed relative to its mean.
    pub speed_jitter: f64,
    /// Range of an adult's height in m.
    pub adult_height_m: [f64; 2],
    /// Range of a child's height in m.
    pub child_height_m: [f64; 2],
    /// Joints of the first person from a motion capture (CSV or BVH) instead of the gait.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub capture: Option<PathBuf>,
    /// Further people in the room.
    pub others: Vec<Other>,
}

/// A further person.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Other {
    /// Its motion.
    pub class: Class,
    /// Ground position at the start in m.
    pub start_m: [f64; 2],
    /// Heading in degrees, counter-clockwise from the x axis; absent: any.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub heading_deg: Option<f64>,
}

/// From slow time to the network's image.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct SpectrogramSettings {
    /// First singular component kept, the paper's d; 1 keeps the clutter.
    pub first_kept: u8,
    /// Last singular component kept (of 8).
    pub last_kept: u8,
    /// Kaiser window length N_w in sensing slots.
    pub window: u16,
    /// Kaiser window's beta. The paper has 10; 4 resolves slow bodies better and gains 4 points of accuracy at N_s = 200.
    pub beta: f32,
    /// Sensing slots between two frames.
    pub hop: u16,
    /// FFT bins averaged into one of the 64 rows: 1, 2 or 4.
    pub bins_per_row: u8,
    /// Dynamic range in dB; weaker is black.
    pub range_db: f64,
}

/// How a training takes its steps.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Optimizer {
    /// Adam with decoupled weight decay (Loshchilov and Hutter, 2019).
    Adamw,
    /// Adam (Kingma and Ba, 2015); no weight decay.
    Adam,
    /// Gradient descent with momentum 0.9, without dampening or weight decay.
    Momentum,
}

/// How a training's learning rate goes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Schedule {
    /// Up to the peak and down to nothing (Smith and Topin, 2019).
    OneCycle,
    /// The same for every step.
    Constant,
}

/// Training and testing.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Learning {
    /// Training recordings per class.
    pub train_per_class: u32,
    /// Windows of every training recording, the first at its beginning, the last N_s slots later: with more than one, training
    /// recordings last twice the largest N_s, and every window is an image of its own.
    pub windows: u32,
    /// Test recordings per class, never trained on.
    pub test_per_class: u32,
    /// Passes over the training set.
    pub epochs: u32,
    /// Recordings per step.
    pub batch: u32,
    /// How steps are taken.
    pub optimizer: Optimizer,
    /// How the learning rate goes.
    pub schedule: Schedule,
    /// Learning rate: the peak of the one-cycle schedule, or the constant.
    pub learning_rate: f64,
    /// AdamW's weight decay.
    pub weight_decay: f64,
    /// Images of a batch are mixed in pairs by a share drawn from Beta(mixup, mixup), 0..=1; 0: never.
    pub mixup: f64,
    /// Widest band of rows that goes dark in an image learned from; 0: none.
    pub mask_rows: u32,
    /// Share of the training recordings kept for validation, 0..=0.5; the best epoch on them is kept.
    pub validation: f64,
    /// Epochs without a better loss on the validation recordings before training stops; 0: never.
    pub patience: u32,
    /// Cross entropy in nats that int8 may add on training images; above it the network is tuned with int8's rounding.
    pub tune_above: f64,
    /// Images, counted as often as they are shown, of such a tuning.
    pub tuning_images: u32,
    /// Channels of every convolution: a multiple of 4, 4..=32.
    pub channels: u8,
    /// Residual blocks.
    pub blocks: u8,
    /// Stride of the input convolution: 1 or 2.
    pub stem_stride: u8,
}

/// The communication side.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Communication {
    /// OFDM sub-carriers M over the radar's 10 MHz.
    pub subcarriers: u32,
    /// Duration of an OFDM symbol with its prefix T_o in s.
    pub symbol_s: f64,
    /// Transmit power in W, shared by the sub-carriers.
    pub power_w: f64,
    /// Noise figure of the receivers in dB.
    pub noise_figure_db: f64,
    /// Receiver positions in m, one list per case.
    pub cases: Vec<Vec<[f64; 3]>>,
    /// Channel draws averaged for the expected gain of a sub-carrier.
    pub draws: u32,
    /// Bits that one slot carries to every receiver, one list per case, where links are known: no channel is asked then.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub slot_bit: Option<Vec<Vec<f64>>>,
}

/// Zones and operating point.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Trade {
    /// Weight of normalised accuracy in the operating point's weighted sum (throughput has the rest).
    pub accuracy_weight: f64,
    /// Case (1-based) whose operating point the scheduler plays.
    pub case: u32,
    /// A point is saturated where the smaller normalised marginal rate is below this share of the larger.
    pub zone_ratio: f64,
}

impl Learning {
    /// Sensing slots of a training recording in which the longest window has `slots`.
    pub fn training_slots(&self, slots: u32) -> u32 {
        if self.windows > 1 { 2 * slots } else { slots }
    }
}
