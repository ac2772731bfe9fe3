//! Networks in and out: the files of other programs become model files, and the other way round.
//!
//! The ending of a file's name says what it is: `.sdp3`, `.graph`, `.tflite`, `.safetensors`, `.json` (float parameters).

use std::path::{Path, PathBuf};

use schemars::JsonSchema;
use sdp3_core::dsn::Model;
use serde::Serialize;

use super::parameters::Parameters;
use super::quantization::{QuantizationReport, quantize};
use super::safetensors;
use super::spectrograms::{Part, Recordings};
use crate::error::{Failure, Invalid};
use crate::formats::model_file::{Preprocessing, QuantizedNetwork};
use crate::formats::tflite::{self, ImportDefaults};
use crate::progress::Progress;
use crate::scenario::{Class, Scenario};
use crate::simulator::calibration::rho_of;
use crate::store::limited;
use crate::store::output::Output;

/// Simulated recordings of each class that activation ranges are measured on.
const CALIBRATION_PER_CLASS: u32 = 20;

/// What was read, in words and numbers.
#[derive(Debug, Serialize, JsonSchema)]
pub struct Exchanged {
    /// The file read.
    pub from: PathBuf,
    /// The file written.
    pub to: PathBuf,
    /// Its length in bytes.
    pub bytes: usize,
    /// What quantisation did, if the network came in floating point.
    pub quantization: Option<QuantizationReport>,
}

/// The settings of a conversion, for what a file does not say.
pub struct Conversion<'a> {
    /// Preprocessing, classes and the room that calibration images are simulated in.
    pub scenario: &'a Scenario,
    /// Seed of the calibration images.
    pub seed: u64,
    /// Sensing slots of the recordings, where the file does not say; absent: the scenario's first that fits.
    pub sensing_slots: Option<u16>,
    /// How to show progress.
    pub progress: Progress,
}

fn named(file: &Path) -> impl Fn(&dyn std::fmt::Display) -> Failure + '_ {
    move |error| format!("{}: {error}", file.display()).into()
}

/// The ending of a name, in small letters.
fn ending(file: &Path) -> String {
    file.extension().unwrap_or_default().to_string_lossy().to_ascii_lowercase()
}

fn read(file: &Path) -> Result<Vec<u8>, Failure> {
    limited::read(file, limited::NETWORK).map_err(|e| named(file)(&e))
}

/// Writes a network for other programs: a model file as `.tflite`, float parameters as `.safetensors`.
///
/// # Errors
/// The file and what is wrong with it.
pub fn export(from: &Path, to: &Path) -> Result<Exchanged, Failure> {
    let bytes = match (ending(from).as_str(), ending(to).as_str()) {
        ("sdp3", "tflite") => {
            let bytes = read(from)?;
            let model = Model::parse(&bytes).map_err(|e| named(from)(&e))?;
            if let Some(graph) = model.graph() {
                let found = format!("a graph of {} operators", graph.nodes().count());
                let legal = "the paper's; a graph came from a .tflite file";
                return Err(Invalid::new("network", found, legal).at(from.display()).into());
            }
            let network = QuantizedNetwork::from_bytes(&bytes).map_err(|e| named(from)(&e))?;
            tflite::export(&network).map_err(|e| named(from)(&e))?
        }
        ("json", "safetensors") => {
            let parameters: Parameters = serde_json::from_slice(&read(from)?).map_err(|e| named(from)(&e))?;
            safetensors::write(&parameters).map_err(|e| named(from)(&e))?
        }
        (a, b) => {
            let legal = "MODEL.sdp3 to FILE.tflite, or NETWORK.json (float parameters) to FILE.safetensors";
            return Err(Invalid::option("export", format!(".{a} to .{b}"), legal).into());
        }
    };
    written(from, to, &bytes, None)
}

impl Conversion<'_> {
    /// Reads another program's network: `.tflite` becomes a model file, or a graph of its own; `.safetensors` is quantised, or kept in floating
    /// point as `.json`.
    ///
    /// # Errors
    /// The file, the field, its value and what is legal.
    pub fn import(&self, from: &Path, to: &Path) -> Result<Exchanged, Failure> {
        match (ending(from).as_str(), ending(to).as_str()) {
            ("tflite", "sdp3") => {
                let import_defaults = ImportDefaults {
                    preprocessing: header(self.scenario, 0),
                    sensing_slots: self.sensing_slots(),
                    classes: Class::ALL.iter().map(|c| c.name().to_owned()).collect(),
                };
                let (model, stated) =
                    tflite::import_model(&read(from)?, &import_defaults).map_err(|e| named(from)(&e))?;
                if let Some(n) = self.sensing_slots.filter(|n| *n != stated) {
                    let legal = format!("{stated}, the sensing slots that it takes");
                    return Err(Invalid::new("--slots", n, legal).at(from.display()).into());
                }
                written(from, to, &model, None)
            }
            ("tflite", "graph") => {
                let graph = tflite::import_graph(&read(from)?).map_err(|e| named(from)(&e))?;
                written(from, to, &graph, None)
            }
            ("safetensors", "json") => {
                let parameters = self.parameters(from)?;
                written(from, to, &serde_json::to_vec(&parameters)?, None)
            }
            ("safetensors", "sdp3") => {
                let parameters = self.parameters(from)?;
                let (network, report) = self.quantized(from, &parameters)?;
                written(from, to, &network.to_bytes().map_err(|e| named(from)(&e))?, Some(report))
            }
            (a, b) => {
                let legal = "FILE.tflite to MODEL.sdp3 or NETWORK.graph, or FILE.safetensors to MODEL.sdp3 or NETWORK.json";
                Err(Invalid::option("import", format!(".{a} to .{b}"), legal).into())
            }
        }
    }

    fn sensing_slots(&self) -> Vec<u16> {
        match self.sensing_slots {
            Some(n) => vec![n],
            None => self.scenario.frame.sensing_slots.iter().map(|&n| n as u16).collect(),
        }
    }

    fn parameters(&self, from: &Path) -> Result<Parameters, Failure> {
        let stride = self.scenario.learning.stem_stride as usize;
        safetensors::read(&read(from)?, stride).map_err(|e| named(from)(&e))
    }

    /// Quantises float parameters, ranges measured on simulated recordings of the scenario.
    fn quantized(
        &self,
        from: &Path,
        parameters: &Parameters,
    ) -> Result<(QuantizedNetwork, QuantizationReport), Failure> {
        let classes: Vec<String> = Class::ALL.iter().map(|c| c.name().to_owned()).collect();
        if parameters.architecture.classes != classes.len() {
            let legal = format!("{}: {}", classes.len(), classes.join(", "));
            let found = Invalid::new("tensor head.weight: classes", parameters.architecture.classes, legal);
            return Err(found.at(from.display()).into());
        }
        // weights alone do not say how long the recordings were
        let Some(n) = self.sensing_slots else {
            let legal = "the sensing slots it was trained with";
            return Err(Invalid::new("--slots", "missing", legal).at(from.display()).into());
        };
        let mut scenario = self.scenario.clone();
        scenario.frame.sensing_slots = vec![n.into()];
        scenario.check("command line: --slots")?;
        let rho = rho_of(&scenario);
        let stage = self.progress.stage("simulate", "calibration recordings");
        let per_class = CALIBRATION_PER_CLASS;
        let images = Recordings { scenario: &scenario, rho, seed: self.seed, part: Part::Train, per_class }
            .images(&|done, all| stage.at(done, all));
        stage.finish(&format!("calibration: {per_class} recordings of each class at rho = {rho}"));
        quantize(parameters, header(self.scenario, n.into()), &classes, &images.images[0])
            .map_err(|e| named(from)(&e))
    }
}

/// What the radar module must know to make the network's images.
pub fn header(scenario: &Scenario, sensing_slots: u32) -> Preprocessing {
    let p = scenario.spectrogram.preprocessing();
    Preprocessing {
        radar: scenario.radar.config(),
        sensing_slots: sensing_slots as u16,
        first_kept: p.kept.first,
        last_kept: p.kept.last,
        window_len: p.window,
        hop: p.hop,
        bins_per_row: p.bins_per_row,
        range: p.range,
        kaiser_beta: p.beta,
        carrier_khz: (scenario.radar.carrier_hz / 1e3).round() as u32,
        slow_time_us: (scenario.interval_s() * 1e6).round() as u32,
    }
}

fn written(
    from: &Path,
    to: &Path,
    bytes: &[u8],
    quantization: Option<QuantizationReport>,
) -> Result<Exchanged, Failure> {
    Output::write_file(to, bytes)?;
    Ok(Exchanged { from: from.to_owned(), to: to.to_owned(), bytes: bytes.len(), quantization })
}

impl Exchanged {
    /// The conversion in words: files, and per activation its range, error and clipped share.
    pub fn describe(&self) -> String {
        let mut text = format!("{} -> {}, {} bytes", self.from.display(), self.to.display(), self.bytes);
        if let Some(report) = &self.quantization {
            text.push('\n');
            text.push_str(&report.table());
        }
        text
    }
}
