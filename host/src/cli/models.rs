//! Model files: `export`, `import`, `model`, `sign`, `key`.

use super::context::{Context, folder_of, name_of};
use clap::Args;
use sdp3::formats::model_file::Summary;
use sdp3::formats::model_file::signature::{new_key, read_key, sign as signed};
use sdp3::output::Output;
use sdp3::pipeline::Failure;
use sdp3::predictor::interchange::{self, Exchange};
use std::path::PathBuf;

/// A network to write for other programs.
#[derive(Debug, Clone, Args)]
pub struct ExportArgs {
    /// MODEL.sdp3, or NETWORK.json as `sdp3 train` writes it.
    #[arg(value_name = "FILE")]
    pub from: PathBuf,
    /// FILE.tflite of a model file, FILE.safetensors of float parameters.
    #[arg(long, value_name = "FILE")]
    pub to: PathBuf,
}

/// Another program's network.
#[derive(Debug, Clone, Args)]
pub struct ImportArgs {
    /// FILE.tflite or FILE.safetensors.
    #[arg(value_name = "FILE")]
    pub from: PathBuf,
    /// MODEL.sdp3; of .safetensors also NETWORK.json, float parameters as `sdp3 quantize` reads them.
    #[arg(long, value_name = "FILE")]
    pub to: PathBuf,
    /// Sensing slots it was trained with, where the file does not say.
    #[arg(long, value_name = "N")]
    pub slots: Option<u16>,
}

/// A model file to tell about.
#[derive(Debug, Clone, Args)]
pub struct ModelArgs {
    /// MODEL.sdp3.
    #[arg(value_name = "FILE")]
    pub file: PathBuf,
    /// Public key that must have signed it.
    #[arg(long, value_name = "NAME.pub")]
    pub key: Option<PathBuf>,
}

/// A model file to sign.
#[derive(Debug, Clone, Args)]
pub struct SignArgs {
    /// MODEL.sdp3.
    #[arg(value_name = "FILE")]
    pub file: PathBuf,
    /// Secret key.
    #[arg(long, value_name = "NAME.key")]
    pub key: PathBuf,
    /// Its revision: firmware that ran a later one refuses it.
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub revision: u32,
    /// Where the signed model goes.
    #[arg(long, value_name = "FILE")]
    pub to: PathBuf,
}

/// A key pair to make.
#[derive(Debug, Clone, Args)]
pub struct KeyArgs {
    /// NAME; existing files are kept.
    #[arg(value_name = "NAME")]
    pub name: PathBuf,
}

pub fn export(context: &Context, args: &ExportArgs) -> Result<bool, Failure> {
    let done = interchange::export(&args.from, &args.to)?;
    context.print(&done, || done.describe())?;
    Ok(true)
}

pub fn import(context: &Context, args: &ImportArgs) -> Result<bool, Failure> {
    let exchange = Exchange {
        scenario: &context.scenario,
        seed: context.common.seed,
        sensing_slots: args.slots,
        progress: context.progress,
    };
    let done = exchange.import(&args.from, &args.to)?;
    context.print(&done, || done.describe())?;
    Ok(true)
}

/// `false` if the key given did not sign it.
pub fn model(context: &Context, args: &ModelArgs) -> Result<bool, Failure> {
    let found = Summary::read(&args.file, args.key.as_deref())?;
    context.print(&found, || found.describe())?;
    Ok(found.signature_holds != Some(false))
}

pub fn sign(context: &Context, args: &SignArgs) -> Result<bool, Failure> {
    let SignArgs { file, key, revision, to } = args;
    let model = std::fs::read(file).map_err(|e| format!("{}: {e}", file.display()))?;
    let model = signed(&model, read_key(key)?, *revision).map_err(|e| format!("{}: {e}", file.display()))?;
    let written = Output::create(&folder_of(to))?.write(&name_of(to), &model)?;
    context.print_files(&[written])?;
    Ok(true)
}

pub fn key(context: &Context, args: &KeyArgs) -> Result<bool, Failure> {
    context.print_files(&new_key(&args.name)?)?;
    Ok(true)
}
