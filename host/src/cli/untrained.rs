//! The commands that train, in a build that cannot: each says what it would take.

use super::context::Context;
use super::job::RunArgs;
use super::training::{QuantizeArgs, StudyArgs, TrainArgs};
use crate::dataset::Shard;
use crate::error::Failure;
use crate::experiments::sweep::plan::Sweep;
use crate::results::Swept;

fn refusal<T>(what: &str) -> Result<T, Failure> {
    Err(format!("this build cannot {what}: build it with the feature `train`").into())
}

pub fn run(_: &Context, _: RunArgs) -> Result<bool, Failure> {
    refusal("train")
}

pub fn train(_: &Context, _: TrainArgs) -> Result<bool, Failure> {
    refusal("train")
}

pub fn quantize(_: &Context, _: QuantizeArgs) -> Result<bool, Failure> {
    refusal("quantize")
}

pub fn study(_: &Context, _: StudyArgs) -> Result<bool, Failure> {
    refusal("train")
}

pub fn shard(_: &Context, _: &Sweep, _: Shard) -> Result<Swept, Failure> {
    refusal("train")
}
