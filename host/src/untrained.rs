//! The commands that train, in a build that cannot: each says what it would take.

use crate::cli::{MeasuredArgs, ProofArgs, Study, TrainArgs};
use sdp3::formats::measured::Stated;
use sdp3::pipeline::{Failure, Job};
use std::path::Path;

fn refusal(what: &str) -> Result<bool, Failure> {
    Err(format!("this build cannot {what}: build it with the feature `train`").into())
}

pub fn run(_: &Job, _: MeasuredArgs, _: &ProofArgs, _: usize, _: bool) -> Result<bool, Failure> {
    refusal("train")
}

pub fn train(_: Job, _: TrainArgs, _: (bool, usize), _: bool) -> Result<bool, Failure> {
    refusal("train")
}

pub fn quantize(_: &Job, _: Option<&Path>, _: bool) -> Result<bool, Failure> {
    refusal("quantize")
}

pub fn study(
    _: &Job,
    _: (Study, u32),
    _: Option<(&Path, Stated)>,
    _: usize,
    _: bool,
) -> Result<bool, Failure> {
    refusal("train")
}
