//! Recordings of a radar, classified window by window through the core's chain.

use super::early_exits::stored::StoredExits;
use super::sample_supervision::Supervisor;
use crate::error::{Failure, Invalid};
use crate::formats::slots::Slots;
use crate::network::memory::OwnedMemory;
use crate::recordings::{self, Expected, Signal, Stated};
use crate::results::{Classified, ClassifiedRecording, ClassifiedWindow, SampleSupervision, UsedExits};
use sdp3_core::dsn::{Classification, Kernels, Model};
use sdp3_core::early_exit::EarlyExit;
use sdp3_core::pipeline::Pipeline;
use std::collections::VecDeque;
use std::io::Read;
use std::path::{Path, PathBuf};

pub use super::early_exits::stored::{EarlyExits, ModelFile};

/// The class of a window that is not sure enough.
const UNKNOWN: &str = "unknown";

/// What to classify with, and how.
#[derive(Debug, Clone)]
pub struct Classify {
    /// Model file.
    pub model: ModelFile,
    /// Exits before the model; absent: windows use all its slots.
    pub early_exits: Option<EarlyExits>,
    /// Slots from window to window; absent: as many as the model takes.
    pub step: Option<u32>,
    /// Windows of less confidence are unknown.
    pub least_confidence: f64,
    /// Whether the module's supervision looks at the samples of every slot. Windows are classified all the same.
    pub guard: bool,
    /// What was stated about the recordings.
    pub stated: Stated,
}

/// What is known once a stream has ended.
#[derive(Debug, Clone, PartialEq)]
pub struct Ended {
    /// What was used of early exits, if there are any.
    pub early_exits: Option<UsedExits>,
    /// What the supervision of samples said, if it looked.
    pub supervision: Option<SampleSupervision>,
}

impl Classify {
    /// Classifies recordings.
    ///
    /// # Errors
    ///
    /// Models or a recording that cannot be read; a recording of another radar, or shorter than a window.
    pub fn files(&self, files: &[PathBuf]) -> Result<Classified, Failure> {
        self.each_file(files, &mut |_, _, _| ())
    }

    /// As [`Self::files`]; `see` sees every recording with its slots and the model before its windows are classified.
    ///
    /// # Errors
    ///
    /// As [`Self::files`].
    pub(crate) fn each_file(
        &self,
        files: &[PathBuf],
        see: &mut dyn FnMut(&Signal, &Slots, &Model),
    ) -> Result<Classified, Failure> {
        let stored = self.stored()?;
        let exits = Exits::new(&stored)?;
        let (mut recordings, mut windows, mut slots) = (Vec::new(), 0, 0);
        for file in files {
            let found = self.file(&exits, file, see)?;
            windows += found.windows.len() as u64;
            slots += found.windows.iter().map(|window| u64::from(window.slots_used)).sum::<u64>();
            recordings.push(found);
        }
        let model = exits.last;
        Ok(Classified {
            model: self.model.name().display().to_string(),
            sensing_slots: model.sensing_slots() as u32,
            classes: (0..model.classes()).map(|class| model.class_name(class).to_owned()).collect(),
            early_exits: self.used(&stored, &exits, windows, slots),
            recordings,
        })
    }

    /// Classifies slots of little-endian int16 as they come, until they end; `each` sees every window.
    ///
    /// # Errors
    ///
    /// Models that cannot be read; a stream that breaks or ends within a slot; what `each` says.
    pub fn live(
        &self,
        source: &mut impl Read,
        each: &mut dyn FnMut(&ClassifiedWindow) -> Result<(), Failure>,
    ) -> Result<Ended, Failure> {
        let stored = self.stored()?;
        let exits = Exits::new(&stored)?;
        let mut slot = vec![0; 2 * exits.last.radar().values_per_slot()];
        let (mut windows, mut slots, mut read) = (0, 0, 0);
        let mut counted = |window: &ClassifiedWindow| {
            windows += 1;
            slots += u64::from(window.slots_used);
            each(window)
        };
        let supervision = self.windows(&exits, &mut counted, |push| {
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
                push(slot.as_chunks().0.iter().map(|&pair| i16::from_le_bytes(pair)).collect())?;
                read += 1;
            }
        })?;
        if windows == 0 {
            let legal = format!("at least {}", exits.last.sensing_slots());
            return Err(Invalid::new("slots", read, legal).at("standard input").into());
        }
        Ok(Ended { early_exits: self.used(&stored, &exits, windows, slots), supervision })
    }

    /// The models, once the options are checked.
    fn stored(&self) -> Result<StoredExits, Failure> {
        let share = self.least_confidence;
        if !(0.0..=1.0).contains(&share) {
            return Err(Invalid::option("--least-confidence", share, "0 to 1").into());
        }
        if self.step == Some(0) {
            return Err(Invalid::option("--step", 0, "1 and more").into());
        }
        StoredExits::read(&self.model, self.early_exits.as_ref())
    }

    fn used(&self, stored: &StoredExits, exits: &Exits, windows: u64, slots: u64) -> Option<UsedExits> {
        let folder = &self.early_exits.as_ref()?.folder;
        Some(stored.used(folder, &exits.all, windows, slots))
    }

    fn file(
        &self,
        exits: &Exits,
        file: &Path,
        see: &mut dyn FnMut(&Signal, &Slots, &Model),
    ) -> Result<ClassifiedRecording, Failure> {
        let model = &exits.last;
        let signal = recordings::open(file, &self.stated)?;
        let slots = expected(model)
            .slots(&signal, model.sensing_slots())
            .map_err(|invalid| invalid.at(file.display()))?;
        see(&signal, &slots, model);
        let mut found = Vec::new();
        let mut each = |window: &ClassifiedWindow| {
            found.push(window.clone());
            Ok(())
        };
        let supervision =
            self.windows(exits, &mut each, |push| slots.iter().try_for_each(|slot| push(slot.to_vec())))?;
        Ok(ClassifiedRecording {
            file: file.display().to_string(),
            format: signal.about.format.clone(),
            slots: slots.len() as u32,
            supervision,
            windows: found,
        })
    }

    /// Runs `feed` on windows of these exits. What the supervision of samples said, if it looks.
    fn windows(
        &self,
        exits: &Exits,
        each: &mut dyn FnMut(&ClassifiedWindow) -> Result<(), Failure>,
        feed: impl FnOnce(&mut dyn FnMut(Vec<i16>) -> Result<(), Failure>) -> Result<(), Failure>,
    ) -> Result<Option<SampleSupervision>, Failure> {
        let mut memory = OwnedMemory::for_model(&exits.last);
        // the fastest kernels are those of one model
        if let [_] = exits.all[..] {
            let pipeline = memory.pipeline(exits.last).map_err(|error| error.to_string())?;
            return self.begin(exits, pipeline, each).fed(feed);
        }
        let pipeline = memory.early_exits(exits.all.clone(), exits.threshold);
        self.begin(exits, pipeline.map_err(|error| error.to_string())?, each).fed(feed)
    }

    fn begin<'a, 'm, K: Kernels>(
        &self,
        exits: &'a Exits<'m>,
        pipeline: Pipeline<'m, 'a, K>,
        each: &'a mut dyn FnMut(&ClassifiedWindow) -> Result<(), Failure>,
    ) -> Windows<'a, 'm, K> {
        Windows {
            exits,
            pipeline,
            step: self.step.map_or(exits.last.sensing_slots(), |step| step as usize),
            least_confidence: self.least_confidence,
            slots: VecDeque::with_capacity(exits.last.sensing_slots()),
            used: 0,
            first: 0,
            skip: 0,
            supervisor: self.guard.then(|| Supervisor::new(exits.last.radar())),
            each,
        }
    }
}

/// The radar that a model was trained for.
fn expected(model: &Model) -> Expected {
    Expected {
        owner: "the model's",
        radar: model.radar(),
        interval_us: f64::from(model.interval_us()),
        carrier_hz: 1e3 * f64::from(model.carrier_khz()),
    }
}

/// The exits of a window, the last of which is the model.
struct Exits<'m> {
    all: Vec<EarlyExit<'m>>,
    last: Model<'m>,
    threshold: f32,
}

impl<'m> Exits<'m> {
    fn new(stored: &'m StoredExits) -> Result<Self, Failure> {
        let all = stored.exits()?;
        let last = all.last().ok_or("no model")?.model;
        Ok(Exits { all, last, threshold: stored.threshold as f32 })
    }
}

/// Slots of the window under way.
struct Windows<'a, 'm, K> {
    exits: &'a Exits<'m>,
    pipeline: Pipeline<'m, 'a, K>,
    step: usize,
    least_confidence: f64,
    /// Slots from the window's first on, and whether the module would not use them.
    slots: VecDeque<(Vec<i16>, bool)>,
    /// How many of them the pipeline has.
    used: usize,
    /// Number of the window's first slot.
    first: usize,
    /// Slots to pass over until then.
    skip: usize,
    supervisor: Option<Supervisor>,
    each: &'a mut dyn FnMut(&ClassifiedWindow) -> Result<(), Failure>,
}

impl<K: Kernels> Windows<'_, '_, K> {
    /// Takes all slots. What the supervision of samples said, if it looks.
    fn fed(
        mut self,
        feed: impl FnOnce(&mut dyn FnMut(Vec<i16>) -> Result<(), Failure>) -> Result<(), Failure>,
    ) -> Result<Option<SampleSupervision>, Failure> {
        feed(&mut |slot| self.push(slot))?;
        Ok(self.supervisor.map(Supervisor::found))
    }

    /// Takes a slot, and ends the windows that are sure with it, or complete.
    fn push(&mut self, slot: Vec<i16>) -> Result<(), Failure> {
        let faulty = self.supervisor.as_mut().is_some_and(|supervisor| supervisor.is_faulty(&slot));
        if self.skip > 0 {
            self.skip -= 1;
            return Ok(());
        }
        self.slots.push_back((slot, faulty));
        while let Some((slot, _)) = self.slots.get(self.used) {
            self.pipeline.push(slot, &mut ()).map_err(|error| error.to_string())?;
            self.used += 1;
            if let Some(found) = self.pipeline.classify(&mut ())
                && found.stop
            {
                self.end(&found)?;
            }
        }
        Ok(())
    }

    /// Ends the window, and begins the next.
    fn end(&mut self, found: &Classification) -> Result<(), Failure> {
        let model = &self.exits.last;
        let confidence = f64::from(found.confidence);
        let sure = confidence >= self.least_confidence;
        let faulty = self.slots.iter().take(self.used).filter(|(_, faulty)| *faulty).count();
        let class = if sure { model.class_name(usize::from(found.class)) } else { UNKNOWN };
        (self.each)(&ClassifiedWindow {
            first_slot: self.first as u32,
            start_s: self.first as f64 * 1e-6 * f64::from(model.interval_us()),
            slots_used: self.used as u32,
            faulty_slots: self.supervisor.is_some().then_some(faulty as u32),
            class: class.to_owned(),
            confidence,
            logits: found.logits.to_vec(),
        })?;
        let passed = self.step.min(self.slots.len());
        self.slots.drain(..passed);
        self.skip = self.step - passed;
        self.first += self.step;
        self.used = 0;
        self.pipeline.reset();
        Ok(())
    }
}
