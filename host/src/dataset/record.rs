//! What is said of a dataset's recordings: label and truth.

use crate::scenario::Class;
use crate::simulator::body::motion::GroundTruth;
use serde::{Deserialize, Serialize};

/// What is true of a recording.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(from = "Row", into = "Row")]
pub struct TruthRecord {
    /// Its number in the dataset.
    pub index: u32,
    /// Its label, an index into the classes.
    pub label: u8,
    /// The person.
    pub truth: GroundTruth,
}

/// The same as one flat object. serde's `flatten` would read no number where another crate of the program has turned on
/// serde_json's `arbitrary_precision`.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Row {
    index: u32,
    label: u8,
    class: Class,
    child: bool,
    height_m: f64,
    speed_m_s: f64,
    heading_deg: f64,
    phase: f64,
    start_m: [f64; 2],
}

impl From<Row> for TruthRecord {
    fn from(row: Row) -> Self {
        let Row { index, label, class, child, height_m, speed_m_s, heading_deg, phase, start_m } = row;
        let truth = GroundTruth { class, child, height_m, speed_m_s, heading_deg, phase, start_m };
        TruthRecord { index, label, truth }
    }
}

impl From<TruthRecord> for Row {
    fn from(record: TruthRecord) -> Self {
        let TruthRecord { index, label, truth } = record;
        let GroundTruth { class, child, height_m, speed_m_s, heading_deg, phase, start_m } = truth;
        Row { index, label, class, child, height_m, speed_m_s, heading_deg, phase, start_m }
    }
}
