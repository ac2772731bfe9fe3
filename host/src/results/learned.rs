//! What was learned from labelled recordings.

use super::Estimate;
use schemars::JsonSchema;
use serde::Serialize;

/// Networks that learned from labelled recordings.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct LearnedRecordings {
    /// What they learned from: `recordings`, `with-simulation` or `fine-tuning`.
    pub method: String,
    /// Their classes, in the order of the logits.
    pub classes: Vec<String>,
    /// Recording by recording.
    pub recordings: Vec<LearnedRecording>,
    /// N_s by N_s, tested by cross-validation.
    pub networks: Vec<LearnedNetwork>,
}

/// A recording that was learned from.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct LearnedRecording {
    /// Its path below the folder.
    pub file: String,
    /// Its class.
    pub class: String,
    /// Who is in it, if that is known.
    pub person: Option<String>,
    /// Part of the cross-validation that it is tested in, from 1.
    pub fold: u32,
    /// Length in s.
    pub seconds: f64,
}

/// How well networks recognise recordings that they did not learn from.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct LearnedNetwork {
    /// Slots of a window.
    pub sensing_slots: u32,
    /// Windows that were tested; they do not overlap.
    pub windows: u32,
    /// Share of them that float networks recognise.
    pub float: f64,
    /// Share of them that int8 networks recognise.
    pub int8: f64,
    /// Balanced accuracy in int8 with its 95 % interval, recordings redrawn as wholes.
    pub balanced: Estimate,
    /// Share of the windows that are of the most frequent class: what always naming it would score.
    pub majority: f64,
    /// With classes held out: how to tell windows of none of the classes.
    pub unknown: Option<Unknown>,
    /// Windows `[class][answer]` in int8.
    pub confusion: Vec<Vec<u32>>,
}

/// A threshold of confidence for windows of no known class. Of known classes are the windows of the cross-validation; of unknown ones
/// those of each class, by networks that learned the others. The threshold was chosen on these windows, so that both shares are optimistic.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct Unknown {
    /// Confidence below which a window is unknown, for `sdp3 classify --least-confidence`.
    pub least_confidence: f64,
    /// Share of windows of known classes at or above it.
    pub known_kept: f64,
    /// Share of windows of unknown classes below it.
    pub unknown_refused: f64,
    /// Area under the ROC curve: 0.5 is chance, 1 separates all.
    pub auroc: f64,
}
