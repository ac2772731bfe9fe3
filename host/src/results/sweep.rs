//! What a sweep measures: one cell, and the table of all.

use super::{Accuracy, Case, Curve, CurvePoint, Spread};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// What one cell of a sweep measures.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Cell {
    /// Number in the plan, from 0.
    pub index: u32,
    /// Name of the scenario.
    pub scenario: String,
    /// Carrier in Hz.
    pub carrier_hz: f64,
    /// AR(1) coefficient rho of the room channel.
    pub rho: f64,
    /// N_s.
    pub sensing_slots: u32,
    /// Seed everything random is drawn from.
    pub seed: u64,
}

/// A cell measured end to end.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Measurement {
    /// Which.
    pub cell: Cell,
    /// Shares recognised in float and by the core's int8 network.
    pub accuracy: Accuracy,
    /// What the slots left over carry, one for each user placement of the scenario.
    pub throughput: Vec<Throughput>,
}

/// What the slots that sensing leaves carry to the users of a placement.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Throughput {
    /// Number of the placement, from 1.
    pub case: u32,
    /// Bits of one slot for each user.
    pub slot_bit: Vec<f64>,
    /// `N_c` of every user.
    pub communication_slots: Vec<u32>,
    /// Worst user's bits per period.
    pub throughput_bit: f64,
}

/// What a shard did: what `sdp3 sweep --json` prints.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub struct Swept {
    /// SHA-256 of the resolved plan.
    pub plan: String,
    /// The shard, I/N.
    pub shard: String,
    /// Cells of the whole plan.
    pub cells: u32,
    /// Cells made now.
    pub made: u32,
    /// Cells of this shard that were there.
    pub kept: u32,
    /// Cells of the whole plan that are still missing.
    pub missing: u32,
}

/// Job files and, where they were handed in, the numbers they got: what `sdp3 sweep --slurm --json` prints.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub struct Submitted {
    /// Shards.
    pub shards: u32,
    /// The files written.
    pub files: Vec<String>,
    /// Number of the array job.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub array: Option<String>,
    /// Number of the merge that depends on it.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub merge: Option<String>,
}

/// Where a sweep stands: what `sdp3 sweep --status --json` prints.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct SweepStatus {
    /// SHA-256 of the resolved plan.
    pub plan: String,
    /// Cells of the plan.
    pub cells: u32,
    /// Cells that are there.
    pub done: u32,
    /// Cells without a file.
    pub missing: u32,
    /// Cells with a damaged or foreign file.
    pub unusable: u32,
    /// Every file that cannot be used, with the reason.
    pub faults: Vec<String>,
    /// The same counts for every shard.
    pub shards: Vec<ShardStatus>,
    /// Estimated time in s for the cells that are not there, at the pace of the last ones made; absent with fewer than three.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub left_s: Option<f64>,
}

/// Where a shard of a sweep stands.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub struct ShardStatus {
    /// The shard, I/N.
    pub shard: String,
    /// Its cells.
    pub cells: u32,
    /// Cells that are there.
    pub done: u32,
    /// Cells without a file.
    pub missing: u32,
    /// Cells with a damaged or foreign file.
    pub unusable: u32,
}

/// All of a sweep: what `sdp3 merge --json` prints and `merged.json` holds.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Merged {
    /// Name of the plan.
    pub name: String,
    /// Program and version that made every cell.
    pub program: String,
    /// SHA-256 of the resolved plan.
    pub plan: String,
    /// Share recognised by guessing: one class of as many as are tested in equal numbers.
    pub chance: f64,
    /// Every cell, in the plan's order.
    pub cells: Vec<Measurement>,
    /// Cells of the plan that a partial merge lacks.
    #[serde(skip_serializing_if = "Vec::is_empty", default)]
    pub missing: Vec<Cell>,
    /// Cells that differ in N_s and seed alone, together.
    pub groups: Vec<Group>,
}

/// A scenario at one carrier and one rho.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Group {
    /// Name of the scenario.
    pub scenario: String,
    /// Carrier in Hz.
    pub carrier_hz: f64,
    /// AR(1) coefficient rho of the room channel.
    pub rho: f64,
    /// N_m.
    pub spacing_slots: u32,
    /// Accuracy over N_s, mean and deviation over the seeds.
    pub points: Vec<GroupPoint>,
    /// The best learning curve through the int8 means; absent where a curve needs more N_s.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub curve: Option<Curve>,
    /// Zones and operating point by that curve, one for each user placement.
    pub cases: Vec<Case>,
    /// Where the users' bits are from: whether their channels have people in them.
    #[serde(default)]
    pub channels: String,
}

/// One N_s of a group.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct GroupPoint {
    /// N_s.
    pub sensing_slots: u32,
    /// Float accuracy.
    pub float: Spread,
    /// int8 accuracy.
    pub int8: Spread,
    /// Seeds.
    pub seeds: u32,
    /// Test recordings of all seeds.
    pub tested: u32,
    /// What the slots left over carry, one for each user placement.
    pub throughput: Vec<PointThroughput>,
}

impl GroupPoint {
    /// The int8 mean as a point of a learning curve; of several seeds with the standard error of the mean.
    pub fn curve_point(&self) -> CurvePoint {
        CurvePoint {
            sensing_slots: f64::from(self.sensing_slots),
            accuracy: self.int8.mean,
            tested: Some(f64::from(self.tested)),
            std: self.int8.standard_error(),
        }
    }
}

/// Throughput of a placement at one N_s, mean over the seeds.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct PointThroughput {
    /// Number of the placement, from 1.
    pub case: u32,
    /// Worst user's bits per period.
    pub throughput_bit: f64,
    /// The same in bits per second.
    pub throughput_bit_s: f64,
}
