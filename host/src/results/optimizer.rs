//! Results of the optimizer: regions, operating points, schedules, campaigns, early exits.

use super::{Curve, Retested, WeightedPoint};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// One point of the accuracy-throughput boundary.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct RegionPoint {
    /// User placement: `1` or `2` in the paper's section VI.
    pub case: u32,
    /// `N_s`.
    pub sensing_slots: u32,
    /// `N_c,k` of each user.
    pub communication_slots: Vec<u32>,
    /// Predicted accuracy, 0 to 1.
    pub accuracy: f64,
    /// Lower end of its confidence band.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub accuracy_low: Option<f64>,
    /// Upper end of its confidence band.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub accuracy_high: Option<f64>,
    /// Worst user's throughput in bits per period.
    pub throughput_bit: f64,
    /// The same by Theorem 1, over real numbers of slots.
    pub closed_form_bit: f64,
    /// Whether `N_s` lies outside the points that the curve was fitted to.
    #[serde(default)]
    pub extrapolated: bool,
    /// Which of the paper's three zones it lies in.
    pub zone: Zone,
}

/// The region and the point chosen on it: what `sdp3 optimize` finds.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Optimum {
    /// The learning curve.
    pub curve: Curve,
    /// Boundary of every user placement.
    pub region: Vec<RegionPoint>,
    /// The point for the scheduler.
    pub operating_point: OperatingPoint,
    /// Operating points by weight.
    pub weighted: Vec<WeightedPoint>,
    /// User placements.
    pub cases: Vec<Case>,
    /// Every N_m where the points are of several: its operating point by its own curve. Region and `operating_point` are of the best.
    #[serde(skip_serializing_if = "Vec::is_empty", default)]
    pub spacings: Vec<Spacing>,
    /// Share of the larger normalised marginal rate below which a point is saturated.
    pub zone_ratio: f64,
    /// With `--retest` the accuracies that the curve goes through.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub retested: Option<Retested>,
}

/// Where one zone ends and another begins.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Border {
    /// The first N_s of the second zone.
    pub sensing_slots: u32,
    /// Zone of fewer sensing slots.
    pub from: Zone,
    /// Zone of more.
    pub to: Zone,
    /// Normalised marginal rate |dA / dR| there.
    pub marginal: f64,
    /// Whether `N_s` lies outside the points that the curve was fitted to.
    #[serde(default)]
    pub extrapolated: bool,
}

/// A user's link at its expected gains.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Link {
    /// OFDM sub-carriers M.
    pub subcarriers: u32,
    /// Bits that a sub-carrier carries in a symbol, mean of all.
    pub subcarrier_bit: f64,
    /// Share of the sub-carriers that carry the most bits of the largest modulation; absent without a largest one.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub full_share: Option<f64>,
    /// Share of the power that is spent: below 1 where all sub-carriers carry the most.
    pub power_share: f64,
}

/// A user placement.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Case {
    /// Number, from 1.
    pub case: u32,
    /// Bits of one slot for each user at the expected gains: the paper's approximation, which the optimizer uses.
    pub slot_bit: Vec<f64>,
    /// Bits of one slot for each user, expected over fading.
    pub slot_bit_over_fading: Vec<f64>,
    /// What `slot_bit` is made of; nothing where the scenario states it.
    #[serde(default)]
    pub links: Vec<Link>,
    /// Borders of the zones.
    pub borders: Vec<Border>,
    /// The operating point; absent if no point satisfies the rule.
    pub operating_point: Option<OperatingPoint>,
}

/// The operating point at one N_m, by the curve through the points measured there.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Spacing {
    /// N_m.
    pub spacing_slots: u32,
    /// The learning curve.
    pub curve: Curve,
    /// Most sensing slots that fit the period.
    pub most_sensing_slots: u32,
    /// Fastest radial speed that does not alias, m/s.
    pub unambiguous_m_s: f64,
    /// N_s of the operating point; absent if no point satisfies the rule.
    pub sensing_slots: Option<u32>,
    /// Whether it lies outside the points that the curve was fitted to.
    pub extrapolated: bool,
    /// Its accuracy by the curve.
    pub accuracy: Option<f64>,
    /// Its worst throughput in bits per period.
    pub throughput_bit: Option<f64>,
    /// Time observed: N_s times the interval between sensing slots, in s.
    pub observation_s: Option<f64>,
}

/// The operating point of one combination of a sweep.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct SweepRow {
    /// Carrier in Hz.
    pub carrier_hz: f64,
    /// Transmit power in W.
    pub power_w: f64,
    /// K.
    pub users: u32,
    /// Factor on the users' distance.
    pub distance: f64,
    /// User placement.
    pub case: u32,
    /// N_s; absent if no point satisfies the rule.
    pub sensing_slots: Option<u32>,
    /// Accuracy.
    pub accuracy: Option<f64>,
    /// Worst throughput in bits per period.
    pub throughput_bit: Option<f64>,
    /// Zone.
    pub zone: Option<Zone>,
    /// Where the users' bits are from: whether their channels have people in them.
    #[serde(default)]
    pub channels: String,
}

/// The paper's three zones of the region.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Zone {
    /// Throughput is near its maximum: a little throughput given up adds much accuracy.
    CommunicationSaturation,
    /// Each costs the other: where an operating point belongs.
    Adversarial,
    /// Accuracy is near its maximum: more sensing adds almost nothing.
    SensingSaturation,
}

impl Zone {
    /// Name in files.
    pub fn name(self) -> &'static str {
        match self {
            Zone::CommunicationSaturation => "communication-saturation",
            Zone::Adversarial => "adversarial",
            Zone::SensingSaturation => "sensing-saturation",
        }
    }
}

/// The operating point chosen on the boundary.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct OperatingPoint {
    /// User placement.
    pub case: u32,
    /// `N_s`.
    pub sensing_slots: u32,
    /// `N_m`: communication slots between two sensing slots.
    pub spacing_slots: u32,
    /// `N`.
    pub period_slots: u32,
    /// Length of the period in s: bits per period over it are bit/s.
    pub period_s: f64,
    /// `N_c,k` of each user.
    pub communication_slots: Vec<u32>,
    /// Bits one slot carries to each user.
    pub slot_bit: Vec<f64>,
    /// Predicted accuracy.
    pub accuracy: f64,
    /// Worst user's throughput in bits per period.
    pub throughput_bit: f64,
    /// Zone of the point.
    pub zone: Zone,
    /// Whether `N_s` lies outside the points that the curve was fitted to.
    #[serde(default)]
    pub extrapolated: bool,
    /// How it was chosen, in words.
    pub rule: String,
    /// Where the users' bits are from: whether their channels have people in them.
    #[serde(default)]
    pub channels: String,
}

/// One period as the core's scheduler played it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Schedule {
    /// `N`.
    pub period_slots: u32,
    /// Slots used for sensing.
    pub sensing_slots: u32,
    /// Slots each user got.
    pub communication_slots: Vec<u32>,
    /// Longest run of slots each user waited.
    pub longest_wait_slots: Vec<u32>,
    /// Bits delivered to each user.
    pub delivered_bit: Vec<f64>,
    /// The period run-length coded: `[use, slots]`, use -1 sensing, -2 idle, else the user's index.
    pub timeline: Vec<(i32, u32)>,
    /// Class the core recognised at the end of the sensing slots, if signals were played.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub recognised: Option<Recognised>,
    /// Where the users' bits are from: whether their channels have people in them.
    #[serde(default)]
    pub channels: String,
}

/// One period of a boundary's point as the core's scheduler plays it, in as many numbers as a picture needs.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct SlotPlan {
    /// User placement.
    pub case: u32,
    /// `N_s`.
    pub sensing_slots: u32,
    /// Longest run of slots each user waits.
    pub longest_wait_slots: Vec<u32>,
    /// Uses of the first slots, one by one: -1 sensing, -2 idle, else the user's index.
    pub first: Vec<i32>,
    /// The whole period in columns of (nearly) equal width: slots of `[sensing, user 0, user 1, ..]` in each.
    pub columns: Vec<Vec<u32>>,
}

/// A recognition made while a period was played.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Recognised {
    /// Class played.
    pub truth: String,
    /// Class recognised by the core.
    pub class: String,
    /// Its confidence, 0 to 1.
    pub confidence: f64,
}

/// Thousands of periods as the core's scheduler played them: what `sdp3 schedule --periods` finds.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Campaign {
    /// Periods.
    pub periods: u32,
    /// Slots decided.
    pub decisions: u64,
    /// Slots used for sensing.
    pub sensing_slots: u64,
    /// Idle slots.
    pub idle_slots: u64,
    /// Every user that may be there.
    pub users: Vec<CampaignUser>,
    /// What the boundaries did.
    pub replans: Replans,
    /// Recognitions, if people moved in front of the radar.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub recognitions: Option<Recognitions>,
    /// The first period as [`Schedule::timeline`], for its picture.
    #[serde(skip)]
    pub timeline: Vec<(i32, u32)>,
    /// Properties that did not hold, the first twenty.
    pub violations: Vec<String>,
    /// Where the users' bits are from: whether their channels have people in them.
    #[serde(default)]
    pub channels: String,
}

/// A user in a campaign.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
pub struct CampaignUser {
    /// Periods it was there.
    pub periods: u64,
    /// Slots it had.
    pub slots: u64,
    /// Bits that arrived for it; those delivered if there is always something to send.
    pub offered_bit: f64,
    /// Bits delivered to it.
    pub delivered_bit: f64,
    /// Most slots between two of its own while it had a share.
    pub longest_wait_slots: u32,
    /// The bound that held, largest of all periods.
    pub wait_bound_slots: u32,
}

/// What period boundaries did.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
pub struct Replans {
    /// Boundaries.
    pub boundaries: u64,
    /// Those with a new plan.
    pub replanned: u64,
    /// Users that joined.
    pub joined: u64,
    /// Users that left.
    pub left: u64,
    /// Rates that changed.
    pub rates: u64,
    /// Changes of N_s.
    pub retargeted: u64,
    /// Communication slots lost.
    pub lost_slots: u64,
    /// Sensing slots lost.
    pub lost_sensing_slots: u64,
    /// Sensing slots given back to the users.
    pub released_slots: u64,
}

/// Recognitions in a campaign.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
pub struct Recognitions {
    /// Periods in which a person moved in front of the radar.
    pub count: u64,
    /// Those recognised.
    pub correct: u64,
    /// Those without a classification: a lost sensing slot, or too few for the first exit.
    pub unclassified: u64,
    /// Sensing slots used in them.
    pub slots: u64,
}

/// An early exit.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub struct FittedExit {
    /// Sensing slots after which it classifies.
    pub sensing_slots: u32,
    /// Weight of a logit step of each exit so far, first to own, in 2^-16 nat.
    pub weights: Vec<i32>,
}

/// The effect of a threshold.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct EarlyExitPoint {
    /// Confidence that stops; above 1 none does.
    pub threshold: f64,
    /// Sensing slots of the last exit.
    pub most_sensing_slots: u32,
    /// Share recognised, 0 to 1.
    pub accuracy: f64,
    /// Mean confidence of the classifications; equal to the accuracy if calibrated.
    pub confidence: f64,
    /// Mean number of sensing slots.
    pub sensing_slots: f64,
    /// Recordings that stopped at each exit.
    pub stops: Vec<u32>,
}

/// A static number of sensing slots and the early-exit policy of the same accuracy.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct EarlyExitGain {
    /// N_s of the network alone.
    pub static_slots: u32,
    /// Its accuracy.
    pub static_accuracy: f64,
    /// The early-exit policy.
    pub early_exit: EarlyExitPoint,
    /// Share of the sensing slots it saves.
    pub saved: f64,
}

/// A point of the region with early exits.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct EarlyExitRegionPoint {
    /// User placement.
    pub case: u32,
    /// Expected worst throughput in bits per period.
    pub throughput_bit: f64,
    /// Threshold, accuracy, sensing slots.
    pub point: EarlyExitPoint,
}

/// The region with early exits beside the static one: what `sdp3 early-exits` finds.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct EarlyExitResult {
    /// Exits and weights: with a threshold, all that the radar module needs beside the models.
    pub exits: Vec<FittedExit>,
    /// Recordings the weights were fitted to and thresholds chosen on.
    pub calibrated_on: u32,
    /// Test recordings.
    pub tested: u32,
    /// For every static N_s the policy of its accuracy.
    pub gains: Vec<EarlyExitGain>,
    /// Accuracy at every static N_s with the logits of all earlier exits added.
    pub fused_accuracy: Vec<f64>,
    /// The region with early exits of every user placement.
    pub region: Vec<EarlyExitRegionPoint>,
    /// The static points of every user placement, measured on the same test recordings.
    pub static_region: Vec<StaticPoint>,
    /// The threshold and last exit that the rule chooses in `optimizer.case`.
    pub operating_point: EarlyExitRegionPoint,
    /// Where the users' bits are from: whether their channels have people in them.
    #[serde(default)]
    pub channels: String,
}

/// Recordings of the gallery with early exits.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct EarlyExitGallery {
    /// Confidence that stops, chosen for the accuracy of the operating point; above 1 none does.
    pub threshold: f64,
    /// Sensing slots of the last exit in use.
    pub most_sensing_slots: u32,
    /// Recordings that weights and threshold were fitted to.
    pub calibrated_on: u32,
    /// A recording of every class.
    pub recordings: Vec<EarlyExitRecording>,
}

/// Every exit's classification of one recording.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct EarlyExitRecording {
    /// Its class.
    pub truth: String,
    /// Every exit, fewest slots first.
    pub exits: Vec<ExitClassification>,
    /// Sensing slots after which the core stops at the gallery's threshold.
    pub stops_after: u32,
}

/// An exit's classification.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ExitClassification {
    /// Sensing slots used.
    pub sensing_slots: u32,
    /// Frames of the spectrogram they make.
    pub frames: u32,
    /// The class.
    pub class: String,
    /// Its calibrated probability by the core, 0 to 1.
    pub confidence: f64,
    /// Probabilities of all classes by the same evidence, in f64.
    pub probabilities: Vec<f64>,
}

/// A static point as measured.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct StaticPoint {
    /// User placement.
    pub case: u32,
    /// N_s.
    pub sensing_slots: u32,
    /// Accuracy.
    pub accuracy: f64,
    /// Worst throughput in bits per period.
    pub throughput_bit: f64,
}
