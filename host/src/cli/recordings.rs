//! Commands on the user's own recordings: `inspect`, `classify`.

use super::context::{Context, say};
use crate::error::{Failure, Invalid};
use crate::network::classify::{Classify, EarlyExits};
use crate::pipeline::classes_over_time;
use crate::recordings::{Chirps, Stated, annotations};
use crate::report::paper::{self, Form};
use crate::report::recordings::{
    classified, classified_csv, classified_window, inspection, supervision, used_exits, window_csv,
};
use crate::scenario::budget::Budget;
use crate::store::output::Output;
use crate::text::shown;
use clap::{Args, ValueEnum};
use std::path::{Path, PathBuf};

/// What the user knows of a recording.
#[derive(Debug, Clone, Args)]
pub struct StatedArgs {
    /// Carrier in Hz, instead of what the file says.
    #[arg(long, value_name = "HZ", requires = "measured")]
    pub carrier: Option<f64>,
    /// Sampling or slow-time rate in Hz, instead of what the file says.
    #[arg(long, value_name = "HZ", requires = "measured")]
    pub rate: Option<f64>,
    /// Gain of the sensor in dB, which is subtracted.
    #[arg(long, value_name = "DB", requires = "measured", allow_negative_numbers = true)]
    pub gain: Option<f64>,
    /// Which array of an NPZ or MATLAB file, or which dataset of an HDF5 file.
    #[arg(long, value_name = "NAME", requires = "measured")]
    pub dataset: Option<String>,
    /// Receive antenna of a radar module, from 1.
    #[arg(long, value_name = "N", requires = "measured")]
    pub antenna: Option<u32>,
    /// Chirp of every frame of a radar module, from 1, or all.
    #[arg(long, value_name = "N|all", requires = "measured")]
    pub chirp: Option<Chirps>,
    /// Description of a DCA1000 capture: the sensor's .cfg or mmWave Studio's .mmwave.json; absent: the one beside it.
    #[arg(long, value_name = "FILE", requires = "measured")]
    pub config: Option<PathBuf>,
}

impl StatedArgs {
    /// With what reading may take.
    pub fn stated(self, budget: Budget) -> Stated {
        let StatedArgs { carrier, rate, gain, dataset, antenna, chirp, config } = self;
        Stated {
            carrier_hz: carrier,
            rate_hz: rate,
            gain_db: gain,
            dataset,
            antenna,
            chirp,
            config,
            first: false,
            budget,
        }
    }
}

/// A recording to look at.
#[derive(Debug, Clone, Args)]
pub struct InspectArgs {
    /// A recording: WAV, CSV, NPY, NPZ, MATLAB, SigMF, HDF5, a folder of Infineon's radar SDK, a capture of TI's DCA1000.
    #[arg(value_name = "PATH")]
    pub measured: PathBuf,
    #[command(flatten)]
    pub stated: StatedArgs,
}

/// Recordings to classify.
#[derive(Debug, Clone, Args)]
pub struct ClassifyArgs {
    /// Model file.
    pub model: PathBuf,
    /// Recordings of raw slots, as `sdp3 inspect` reads them; or `-`: slots from standard input, little-endian int16 without pauses.
    #[arg(id = "measured", value_name = "PATH", required = true)]
    pub measured: Vec<PathBuf>,
    #[command(flatten)]
    pub stated: StatedArgs,
    /// Slots from window to window; absent: the model's sensing slots, so that windows do not overlap.
    #[arg(long, value_name = "SLOTS")]
    pub step: Option<u32>,
    /// End a window as soon as an exit is sure: the models in this folder with fewer slots than MODEL, which is one of them, with the weights that `sdp3 early-exits` wrote there.
    #[arg(long, value_name = "DIR")]
    pub early_exits: Option<PathBuf>,
    /// Confidence that ends a window; absent: that of the operating point that `sdp3 early-exits` found. Above 1, up to 2, none does.
    #[arg(long, value_name = "CONFIDENCE", requires = "early_exits")]
    pub threshold: Option<f64>,
    /// Also say which slots the module's supervision of samples would refuse: silent, stuck, saturated or offset converters.
    #[arg(long)]
    pub guard: bool,
    /// Picture to draw, .svg, .png or .pdf: each recording's spectrogram, with class and confidence over time below it.
    #[arg(long, value_name = "FILE")]
    pub picture: Option<PathBuf>,
    /// What is printed, where --json is not given.
    #[arg(long, value_enum, default_value_t = Format::Text, conflicts_with = "json")]
    pub format: Format,
    /// Windows of less confidence are `unknown`.
    #[arg(long, value_name = "0..1", default_value_t = 0.0)]
    pub least_confidence: f64,
}

/// How windows are printed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Format {
    /// A line a window: its time in s, its class, its confidence, the slots it used.
    Text,
    /// A table with the logits.
    Csv,
    /// The description of a SigMF recording with the windows as its annotations.
    Sigmf,
}

pub fn inspect(context: &Context, args: InspectArgs) -> Result<bool, Failure> {
    let stated = args.stated.stated(context.common.budget());
    let found = context.job()?.inspect(&args.measured, &stated)?;
    context.print(&found, || inspection(&found))?;
    Ok(true)
}

/// The kind of picture that a file's name asks for.
fn drawn_as(file: &Path) -> Result<Form, Invalid> {
    let legal = "a name that ends in .svg, .png or .pdf";
    Form::of(file).ok_or_else(|| Invalid::option("--picture", file.display(), legal))
}

pub fn classify(context: &Context, args: ClassifyArgs) -> Result<bool, Failure> {
    let ClassifyArgs {
        model,
        measured,
        stated,
        step,
        early_exits,
        threshold,
        guard,
        picture,
        format,
        least_confidence,
    } = args;
    let picture = picture.map(|file| drawn_as(&file).map(|form| (file, form))).transpose()?;
    let early_exits = early_exits.map(|folder| EarlyExits { folder, threshold });
    let stated = stated.stated(context.common.budget());
    let request = Classify { model: model.into(), early_exits, step, least_confidence, guard, stated };
    if measured == [Path::new("-")] {
        if format == Format::Sigmf {
            return Err(Invalid::option(
                "--format",
                "sigmf",
                "text or csv: standard input has no description",
            )
            .into());
        }
        if let Some((file, _)) = picture {
            let legal = "absent: standard input is classified as it comes";
            return Err(Invalid::option("--picture", file.display(), legal).into());
        }
        let mut header = (format == Format::Csv).then(|| window_csv(None));
        let ended = request.live(&mut std::io::stdin().lock(), &mut |window| {
            context.print_line(window, || match format {
                Format::Csv => {
                    header.take().unwrap_or_default() + &window_csv(Some(("standard input", window)))
                }
                _ => classified_window(window),
            })
        })?;
        let said = ended.supervision.as_ref().map(supervision);
        let lines: Vec<String> = said.into_iter().chain(ended.early_exits.as_ref().map(used_exits)).collect();
        if format == Format::Text && !context.common.json && !lines.is_empty() {
            say(&shown(&lines.join("\n")))?;
        }
        return Ok(true);
    }
    let (found, drawn) = match picture {
        None => (request.files(&measured)?, None),
        Some((file, form)) => {
            let (found, svg) = classes_over_time::picture(&request, &measured)?;
            (found, Some((file, paper::form("--picture", &svg, form)?)))
        }
    };
    let text = match format {
        Format::Text => classified(&found),
        Format::Csv => classified_csv(&found),
        Format::Sigmf => {
            let ([file], [recording]) = (&measured[..], &found.recordings[..]) else {
                let legal = "of one recording: a description describes one";
                return Err(Invalid::option("--format", "sigmf", legal).into());
            };
            annotations::annotated(file, &recording.windows)?
        }
    };
    if let Some((file, bytes)) = drawn {
        Output::write_file(&file, &bytes)?;
    }
    context.print(&found, || text)?;
    Ok(true)
}
