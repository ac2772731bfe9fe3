//! Recordings of a radar, classified window by window through the core's chain.

use crate::error::{Failure, Invalid};
use crate::network::memory::{HostPipeline, OwnedMemory};
use crate::recordings::{self, Expected, Stated};
use crate::results::{Classified, ClassifiedRecording, ClassifiedWindow};
use crate::store::limited;
use sdp3_core::dsn::Model;
use std::collections::VecDeque;
use std::io::Read;
use std::path::{Path, PathBuf};

/// The class of a window that is not sure enough.
const UNKNOWN: &str = "unknown";

/// What to classify with, and how.
#[derive(Debug, Clone)]
pub struct Classify {
    /// Model file.
    pub model: PathBuf,
    /// Slots from window to window; absent: as many as the model takes.
    pub step: Option<u32>,
    /// Windows of less confidence are unknown.
    pub least_confidence: f64,
    /// What was stated about the recordings.
    pub stated: Stated,
}

impl Classify {
    /// Classifies recordings.
    ///
    /// # Errors
    ///
    /// A model or a recording that cannot be read; a recording of another radar, or shorter than a window.
    pub fn files(&self, files: &[PathBuf]) -> Result<Classified, Failure> {
        let bytes = self.bytes()?;
        let model = self.parsed(&bytes)?;
        let recordings: Result<Vec<_>, Failure> = files.iter().map(|file| self.file(&model, file)).collect();
        Ok(Classified {
            model: self.model.display().to_string(),
            sensing_slots: model.sensing_slots() as u32,
            classes: (0..model.classes()).map(|class| model.class_name(class).to_owned()).collect(),
            recordings: recordings?,
        })
    }

    /// Classifies slots of little-endian int16 as they come, until they end; `each` sees every window.
    ///
    /// # Errors
    ///
    /// A model that cannot be read; a stream that breaks or ends within a slot; what `each` says.
    pub fn live(
        &self,
        source: &mut impl Read,
        each: &mut dyn FnMut(&ClassifiedWindow) -> Result<(), Failure>,
    ) -> Result<(), Failure> {
        let bytes = self.bytes()?;
        let model = self.parsed(&bytes)?;
        let mut slot = vec![0; 2 * model.radar().values_per_slot()];
        self.windows(&model, each, |windows| {
            loop {
                let mut filled = 0;
                while filled < slot.len() {
                    match source.read(&mut slot[filled..])? {
                        0 if filled == 0 => return Ok(()),
                        0 => {
                            let legal = format!("a multiple of {}, a slot", slot.len());
                            return Err(Invalid::new(
                                "bytes",
                                format!("{filled} after the last slot"),
                                legal,
                            )
                            .at("standard input")
                            .into());
                        }
                        n => filled += n,
                    }
                }
                windows.push(slot.as_chunks().0.iter().map(|&pair| i16::from_le_bytes(pair)).collect())?;
            }
        })
    }

    fn bytes(&self) -> Result<Vec<u8>, Failure> {
        let read = limited::read(&self.model, limited::NETWORK);
        Ok(read.map_err(|error| format!("{}: {error}", self.model.display()))?)
    }

    fn parsed<'m>(&self, bytes: &'m [u8]) -> Result<Model<'m>, Failure> {
        let share = self.least_confidence;
        if !(0.0..=1.0).contains(&share) {
            return Err(Invalid::option("--least-confidence", share, "0 to 1").into());
        }
        if self.step == Some(0) {
            return Err(Invalid::option("--step", 0, "1 and more").into());
        }
        Ok(Model::parse(bytes).map_err(|error| format!("{}: {error}", self.model.display()))?)
    }

    fn file(&self, model: &Model, file: &Path) -> Result<ClassifiedRecording, Failure> {
        let signal = recordings::open(file, &self.stated)?;
        let expected = Expected {
            owner: "the model's",
            per_slot: model.radar().values_per_slot(),
            interval_us: f64::from(model.interval_us()),
            carrier_hz: 1e3 * f64::from(model.carrier_khz()),
        };
        let slots =
            expected.slots(&signal, model.sensing_slots()).map_err(|invalid| invalid.at(file.display()))?;
        let mut found = Vec::new();
        let mut each = |window: &ClassifiedWindow| {
            found.push(window.clone());
            Ok(())
        };
        self.windows(model, &mut each, |windows| {
            slots.iter().try_for_each(|slot| windows.push(slot.to_vec()))
        })?;
        Ok(ClassifiedRecording {
            file: file.display().to_string(),
            format: signal.about.format.clone(),
            slots: slots.len() as u32,
            windows: found,
        })
    }

    /// Runs `feed` on windows of this model.
    fn windows(
        &self,
        model: &Model,
        each: &mut dyn FnMut(&ClassifiedWindow) -> Result<(), Failure>,
        feed: impl FnOnce(&mut Windows) -> Result<(), Failure>,
    ) -> Result<(), Failure> {
        let mut memory = OwnedMemory::for_model(model);
        let pipeline = memory.pipeline(*model).map_err(|error| error.to_string())?;
        feed(&mut Windows {
            model,
            pipeline,
            step: self.step.map_or(model.sensing_slots(), |step| step as usize),
            least_confidence: self.least_confidence,
            slots: VecDeque::with_capacity(model.sensing_slots()),
            first: 0,
            skip: 0,
            each,
        })
    }
}

/// Slots of the window under way.
struct Windows<'a> {
    model: &'a Model<'a>,
    pipeline: HostPipeline<'a, 'a>,
    step: usize,
    least_confidence: f64,
    slots: VecDeque<Vec<i16>>,
    /// Number of the window's first slot.
    first: usize,
    /// Slots to pass over until then.
    skip: usize,
    each: &'a mut dyn FnMut(&ClassifiedWindow) -> Result<(), Failure>,
}

impl Windows<'_> {
    /// Takes a slot, and classifies the window that it completes.
    fn push(&mut self, slot: Vec<i16>) -> Result<(), Failure> {
        if self.skip > 0 {
            self.skip -= 1;
            return Ok(());
        }
        self.slots.push_back(slot);
        let length = self.model.sensing_slots();
        if self.slots.len() < length {
            return Ok(());
        }
        self.pipeline.reset();
        for slot in &self.slots {
            self.pipeline.push(slot, &mut ()).map_err(|error| error.to_string())?;
        }
        let Some(found) = self.pipeline.classify(&mut ()) else { return Err("no classification".into()) };
        let confidence = f64::from(found.confidence);
        let sure = confidence >= self.least_confidence;
        let class = if sure { self.model.class_name(usize::from(found.class)) } else { UNKNOWN };
        (self.each)(&ClassifiedWindow {
            first_slot: self.first as u32,
            start_s: self.first as f64 * 1e-6 * f64::from(self.model.interval_us()),
            class: class.to_owned(),
            confidence,
            logits: found.logits.to_vec(),
        })?;
        self.slots.drain(..self.step.min(length));
        self.skip = self.step.saturating_sub(length);
        self.first += self.step;
        Ok(())
    }
}
