//! Model files: `export`, `import`, `infer`, `model show`, `sign`, `verify`, `keygen`.

use super::context::Context;
use crate::error::{Failure, Invalid};
use crate::formats::model_file::signature::{new_key, read_public_key, read_secret_key, sign as signed};
use crate::formats::model_file::{ModelCheck, Shown, Summary};
use crate::network::interchange::{self, Conversion};
use crate::network::operator_outputs::infer as inferred;
use crate::store::limited;
use crate::store::output::Output;
use clap::{Args, Subcommand};
use std::path::{Path, PathBuf};

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
    /// MODEL.sdp3; of .tflite also NETWORK.graph, a network of any input that is not the radar's; of .safetensors also NETWORK.json, float parameters as `sdp3 quantize` reads them.
    #[arg(long, value_name = "FILE")]
    pub to: PathBuf,
    /// Sensing slots it was trained with, where the file does not say.
    #[arg(long, value_name = "N")]
    pub slots: Option<u16>,
}

/// A network, and the inputs that it runs on.
#[derive(Debug, Clone, Args)]
pub struct InferArgs {
    /// NETWORK.graph or MODEL.sdp3.
    #[arg(value_name = "NETWORK")]
    pub network: PathBuf,
    /// Array of int8 inputs, [count, height, width, channels]; of a model file its images, [count, 64, frames, 1].
    #[arg(value_name = "INPUTS.npy")]
    pub inputs: PathBuf,
    /// Where the outputs go, an array of int8, [count, values].
    #[arg(long, value_name = "OUTPUTS.npy")]
    pub to: PathBuf,
    /// Write the outputs of every operator, one behind the other, instead of the last one's.
    #[arg(long)]
    pub layers: bool,
}

/// What to do with model files.
#[derive(Debug, Clone, Args)]
pub struct ModelArgs {
    /// What to do.
    #[command(subcommand)]
    pub command: ModelCommand,
}

/// The commands about model files.
#[derive(Debug, Clone, Subcommand)]
pub enum ModelCommand {
    /// Show what a model file holds: envelope, network, memory it needs.
    #[command(after_help = "Examples:
  sdp3 model show out/models/dsn-1000.sdp3
  sdp3 model show signed.sdp3 --json")]
    Show(ShowArgs),
    /// Make a key pair: NAME.key, to be kept secret, signs; NAME.pub is what firmware is built with. Existing files are kept.
    #[command(after_help = "Examples:
  sdp3 model keygen radio
  sdp3 model keygen keys/release --json")]
    Keygen(KeygenArgs),
    /// Sign a model file, for firmware that accepts only signed models.
    #[command(after_help = "Examples:
  sdp3 model sign out/models/dsn-1000.sdp3 --key radio.key --revision 7 --to signed.sdp3")]
    Sign(SignArgs),
    /// Check whether firmware built with a public key accepts the model: exit code 1 and the reason if it does not.
    #[command(after_help = "Examples:
  sdp3 model verify signed.sdp3 --key radio.pub
  sdp3 model verify signed.sdp3 --key radio.pub --oldest 7 --json")]
    Verify(VerifyArgs),
}

/// A model file to show.
#[derive(Debug, Clone, Args)]
pub struct ShowArgs {
    /// MODEL.sdp3 or NETWORK.graph.
    #[arg(value_name = "FILE")]
    pub file: PathBuf,
}

/// A model file and the key to verify it with.
#[derive(Debug, Clone, Args)]
pub struct VerifyArgs {
    /// MODEL.sdp3.
    #[arg(value_name = "FILE")]
    pub file: PathBuf,
    /// Public key that must have signed it.
    #[arg(long, value_name = "NAME.pub")]
    pub key: PathBuf,
    /// The largest revision the radio has run: an older one is a rollback.
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub oldest: u32,
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
pub struct KeygenArgs {
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
    let conversion = Conversion {
        scenario: &context.scenario,
        seed: context.common.seed(),
        sensing_slots: args.slots,
        progress: context.progress,
    };
    let done = conversion.import(&args.from, &args.to)?;
    context.print(&done, || done.describe())?;
    Ok(true)
}

pub fn infer(context: &Context, args: &InferArgs) -> Result<bool, Failure> {
    let done = inferred(&args.network, &args.inputs, &args.to, args.layers)?;
    context.print(&done, || done.describe())?;
    Ok(true)
}

pub fn model(context: &Context, args: &ModelArgs) -> Result<bool, Failure> {
    match &args.command {
        ModelCommand::Show(args) => show(context, args),
        ModelCommand::Keygen(args) => keygen(context, args),
        ModelCommand::Sign(args) => sign(context, args),
        ModelCommand::Verify(args) => verify(context, args),
    }
}

fn read(file: &Path) -> Result<Vec<u8>, Failure> {
    Ok(limited::read(file, limited::NETWORK).map_err(|error| format!("{}: {error}", file.display()))?)
}

fn show(context: &Context, args: &ShowArgs) -> Result<bool, Failure> {
    let found = Shown::of(&read(&args.file)?).map_err(|error| format!("{}: {error}", args.file.display()))?;
    context.print(&found, || found.describe())?;
    Ok(true)
}

fn keygen(context: &Context, args: &KeygenArgs) -> Result<bool, Failure> {
    context.print_files(&new_key(&args.name)?)?;
    Ok(true)
}

fn sign(context: &Context, args: &SignArgs) -> Result<bool, Failure> {
    let SignArgs { file, key, revision, to } = args;
    // a key, for one
    if to.exists() && !read(to).is_ok_and(|bytes| Summary::of(&bytes).is_ok()) {
        return Err(Invalid::option("--to", to.display(), "a model file or no file yet").into());
    }
    let model = signed(&read(file)?, read_secret_key(key)?, *revision)
        .map_err(|error| format!("{}: {error}", file.display()))?;
    context.print_files(&[Output::write_file(to, &model)?])?;
    Ok(true)
}

/// `false` if firmware with that key would refuse the model.
fn verify(context: &Context, args: &VerifyArgs) -> Result<bool, Failure> {
    let verdict = ModelCheck::of(&read(&args.file)?, &read_public_key(&args.key)?, args.oldest);
    context.print(&verdict, || format!("{}: {}", args.file.display(), verdict.describe()))?;
    Ok(verdict.accepted)
}
