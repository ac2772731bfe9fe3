//! What faults on purpose became.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Faults of one kind.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
pub struct FaultRow {
    /// What was done.
    pub kind: String,
    /// How often.
    pub injected: u64,
    /// Told exactly once, by their name.
    pub detected: u64,
    /// Followed by a whole period as wanted; samples and models: not used.
    pub recovered: u64,
    /// Not told.
    pub silent: u64,
    /// Promises broken on the way.
    pub broken: u64,
}

/// Spoiled samples in recordings, and what they cost.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct SpoiledRow {
    /// What was done.
    pub kind: String,
    /// Recordings.
    pub recordings: u32,
    /// Share of the slots that the guarded station asked for that it was done to.
    pub slots: f64,
    /// Share of those that the guard refused.
    pub refused: f64,
    /// Share of recordings recognised if nothing looks at samples.
    pub unguarded: f64,
    /// Share of recordings recognised by the guarded station.
    pub guarded: f64,
    /// Share of recordings without a verdict from it: too few slots were left.
    pub without_verdict: f64,
}

/// A fault campaign: what `sdp3 schedule --faults` finds.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Faults {
    /// Seed of the first part.
    pub seed: u64,
    /// Faults in all parts.
    pub events: u64,
    /// Digest of the first part's outcomes, `events_of_part` faults: firmware finds the same.
    pub digest_of_part: String,
    /// Faults of a part.
    pub events_of_part: u64,
    /// Schedule, model, samples.
    pub rows: Vec<FaultRow>,
    /// Share of untouched recordings recognised.
    pub accuracy: f64,
    /// What spoiled samples cost.
    pub spoiled: Vec<SpoiledRow>,
    /// Whether no fault of schedule or model was silent and no promise broke.
    pub held: bool,
}
