//! JSON Schemas (2020-12) of what every command prints with `--json`, made from the types.
//!
//! The folder `schemas` holds them, one file each; `tests/schemas.rs` keeps the files equal to the types, and the command
//! `tests/schemas` holds every command's real output to them.

use crate::dataset::Written;
use crate::formats::model_file::{ModelCheck, Shown};
use crate::network::interchange::Exchanged;
use crate::network::operator_outputs::Inferred;
use crate::results::{
    Calibration, Campaign, ChannelTable, Checked, Classified, EarlyExitResult, Files, Inspection,
    LearnedRecordings, Listed, Merged, Optimum, Prediction, Reproduction, Run, Schedule, Submitted, SweepRow,
    SweepStatus, Swept, Training, Verify,
};
use crate::scenario::Scenario;
use crate::simulator::calibration::stored::Table;
use crate::simulator::targets::PointTargets;
use schemars::{JsonSchema, schema_for};
use serde_json::Value;

macro_rules! published {
    ($($name:literal),+ $(,)?) => {
        [$(($name, include_str!(concat!("../schemas/", $name, ".json")))),+]
    };
}

/// Every schema by its name: a command's, with hyphens between its words, or `scenario`.
pub const PUBLISHED: [(&str, &str); 34] = published![
    "calibrate",
    "channels",
    "classify",
    "early-exits",
    "export",
    "gallery",
    "import",
    "infer",
    "inspect",
    "man",
    "merge",
    "model-keygen",
    "model-show",
    "model-sign",
    "model-verify",
    "optimize",
    "predict",
    "quantize",
    "report",
    "reproduce",
    "run",
    "scenario",
    "scenario-check",
    "scenario-list",
    "scenario-new",
    "scenario-show",
    "schedule",
    "schema",
    "simulate",
    "study",
    "sweep",
    "targets",
    "train",
    "verify",
];

/// A measured signal's channel correlation, or with `--table` the table.
#[derive(JsonSchema)]
#[serde(untagged)]
#[allow(dead_code)]
enum Calibrated {
    Found(Box<Calibration>),
    Table(Table),
}

/// The region and the point chosen, or with `--sweep` the points of every combination.
#[derive(JsonSchema)]
#[serde(untagged)]
#[allow(dead_code)]
enum Optimized {
    Region(Box<Optimum>),
    Sweep(Vec<SweepRow>),
}

/// One period, or with `--periods` many.
#[derive(JsonSchema)]
#[serde(untagged)]
#[allow(dead_code)]
enum Scheduled {
    Period(Schedule),
    Campaign(Box<Campaign>),
}

/// The study's result; which one its name says.
#[cfg(feature = "train")]
#[derive(JsonSchema)]
#[serde(untagged)]
#[allow(dead_code)]
enum Studied {
    LearningCurve(Box<crate::experiments::learning_curve::LearningCurve>),
    Robustness(crate::experiments::robustness::Robustness),
    Fidelity(Box<crate::experiments::fidelity::Fidelity>),
    SimToReal(Box<crate::experiments::sim_to_real::SimToReal>),
    Baselines(crate::experiments::baselines::Baselines),
    Ablation(Box<crate::experiments::ablation::Ablation>),
    Clutter(crate::experiments::clutter::Clutter),
    Selection(crate::experiments::selection::Selection),
}

/// The histories of the networks, or with `--recordings` how well they recognise what they did not learn from.
#[derive(JsonSchema)]
#[serde(untagged)]
#[allow(dead_code)]
enum Learned {
    Histories(Vec<Training>),
    Recordings(LearnedRecordings),
}

/// What a shard did, with `--slurm` or `--kubernetes` the job's files, or with `--status` where the sweep stands.
#[derive(JsonSchema)]
#[serde(untagged)]
#[allow(dead_code)]
enum ShardOrJob {
    Shard(Swept),
    Job(Submitted),
    Status(SweepStatus),
}

/// The schema of this name as the types have it; of none that this build has no type for.
pub fn of_types(name: &str) -> Option<Value> {
    let schema = match name {
        "scenario" | "scenario-show" => return Some(Scenario::schema()),
        "early-exits" => schema_for!(EarlyExitResult),
        "calibrate" => schema_for!(Calibrated),
        "classify" => schema_for!(Classified),
        "channels" => schema_for!(ChannelTable),
        "export" | "import" => schema_for!(Exchanged),
        "infer" => schema_for!(Inferred),
        "inspect" => schema_for!(Inspection),
        "gallery" | "man" | "model-keygen" | "model-sign" | "quantize" | "report" | "scenario-new" => {
            schema_for!(Files)
        }
        "merge" => schema_for!(Merged),
        "model-show" => schema_for!(Shown),
        "model-verify" => schema_for!(ModelCheck),
        "optimize" => schema_for!(Optimized),
        "predict" => schema_for!(Prediction),
        "reproduce" => schema_for!(Vec<Reproduction>),
        "run" => schema_for!(Run),
        "scenario-check" => schema_for!(Checked),
        "scenario-list" => schema_for!(Vec<Listed>),
        "schedule" => schema_for!(Scheduled),
        "schema" => schema_for!(Vec<String>),
        "simulate" => schema_for!(Written),
        #[cfg(feature = "train")]
        "study" => schema_for!(Studied),
        "sweep" => schema_for!(ShardOrJob),
        "targets" => schema_for!(PointTargets),
        "train" => schema_for!(Learned),
        "verify" => schema_for!(Verify),
        _ => return None,
    };
    Some(schema.to_value())
}
