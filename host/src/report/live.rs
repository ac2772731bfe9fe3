//! What makes the page compute: the program of the commands in WebAssembly, and the models and the scenario that it reads.

use super::spectrograms::colour;
use crate::scenario::{Communication, Model, Scenario};
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use flate2::{Compression, write::GzEncoder};
use serde::Serialize;
use std::collections::BTreeMap;
use std::io::Write;

/// The program and its files, as the page's script reads them.
#[derive(Debug, Serialize)]
pub struct Live {
    /// The program (`sdp3-page.wasm`), gzip in Base64.
    program: String,
    /// Model files in Base64, by N_s.
    models: BTreeMap<u32, String>,
    /// The scenario in TOML.
    scenario: String,
    /// What of it the controls set.
    communication: Communication,
    /// Whether the accuracy depends on rho: whether the channel model has one.
    has_rho: bool,
    /// Test recordings of each class.
    test_per_class: u32,
    /// Time from one sensing slot to the next in s.
    interval_s: f64,
    /// Colours of the intensities 0 to 255 of a spectrogram.
    colours: Vec<[u8; 3]>,
}

impl Live {
    /// A program with the models of a run by N_s, in the run's scenario.
    ///
    /// # Errors
    ///
    /// What the compression of the program says.
    pub fn new(
        program: &[u8],
        models: impl Iterator<Item = (u32, Vec<u8>)>,
        scenario: &Scenario,
    ) -> std::io::Result<Self> {
        let mut packed = GzEncoder::new(Vec::new(), Compression::best());
        packed.write_all(program)?;
        Ok(Live {
            program: STANDARD.encode(packed.finish()?),
            models: models.map(|(slots, bytes)| (slots, STANDARD.encode(bytes))).collect(),
            scenario: scenario.to_toml(),
            communication: scenario.communication.clone(),
            has_rho: scenario.channel.model == Model::Dahc,
            test_per_class: scenario.learning.test_per_class,
            interval_s: scenario.interval_s(),
            colours: (0..=255).map(colour).collect(),
        })
    }
}
