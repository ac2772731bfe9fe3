//! The radar module: `dechirp`, `Scheduler`, `Model`.

use crate::{parsed, refused};
use numpy::{PyArray1, PyArrayMethods, PyReadonlyArrayDyn, PyUntypedArrayMethods};
use pyo3::prelude::*;
use sdp3::error::Invalid;
use sdp3::formats::slots::Slots;
use sdp3::network::inference::Classifier;
use sdp3::network::memory::OwnedMemory;
use sdp3_core::config::{RadarConfig, SampleFormat};
use sdp3_core::dims::{BEATS, ROWS};
use sdp3_core::dsn::{Classification, Model as Parsed};
use sdp3_core::probe::Probe;
use sdp3_core::scheduler::{SensingLayout, SlotUse, USERS};
use sdp3_core::signal::stft::NativeStft;

/// Raw slots of an array [slow time, samples, 2], or [slow time, samples] of a real converter.
fn slots(array: &PyReadonlyArrayDyn<'_, i16>, radar: RadarConfig) -> PyResult<Slots> {
    let samples = usize::from(radar.samples);
    let (legal, words) = match radar.format {
        SampleFormat::Complex => (vec![samples, 2], format!("[slow time, {samples}, 2]")),
        SampleFormat::Real => (vec![samples], format!("[slow time, {samples}]")),
    };
    let shape = array.shape();
    if shape.get(1..) != Some(&legal[..]) {
        return Err(refused(Invalid::new("slots: shape", format!("{shape:?}"), words)));
    }
    Ok(Slots { values: array.as_array().iter().copied().collect(), per_slot: radar.values_per_slot() })
}

/// [slow time, samples, 2] or [slow time, samples] to [slow time, 8, 2], for the radar of a scenario.
#[pyfunction]
#[pyo3(signature = (slots, scenario = ""))]
pub fn dechirp<'py>(
    py: Python<'py>,
    slots: PyReadonlyArrayDyn<'py, i16>,
    scenario: &str,
) -> PyResult<Bound<'py, numpy::PyArray3<i32>>> {
    let radar = parsed(scenario)?.radar.config();
    let beats = self::slots(&slots, radar)?.beats(radar).unwrap_or_default();
    let values = beats.iter().flatten().flat_map(|z| [z.re, z.im]).collect();
    PyArray1::from_vec(py, values).reshape([beats.len(), BEATS, 2])
}

/// The scheduler.
#[pyclass]
pub struct Scheduler(sdp3_core::scheduler::Scheduler);

fn number(slot: SlotUse) -> i8 {
    match slot {
        SlotUse::Sensing => -1,
        SlotUse::Idle => -2,
        SlotUse::Communication(k) => k as i8,
    }
}

#[pymethods]
impl Scheduler {
    #[new]
    fn new(period: u32, spacing: u32, sensing: u32, rates: Vec<u32>) -> PyResult<Self> {
        let sensing = SensingLayout::new(period, spacing, sensing).map_err(refused)?;
        if rates.is_empty() || rates.len() > USERS {
            let n = rates.len();
            return Err(refused(Invalid::new("rates: number of users", n, format!("1 to {USERS}"))));
        }
        let mut all = [0; USERS];
        all.iter_mut().zip(rates).for_each(|(to, rate)| *to = rate);
        Ok(Scheduler(sdp3_core::scheduler::Scheduler::new(sensing, all)))
    }

    fn next(&mut self) -> i8 {
        number(self.0.next_slot())
    }

    fn play<'py>(&mut self, py: Python<'py>, slots: usize) -> Bound<'py, PyArray1<i8>> {
        PyArray1::from_vec(py, (0..slots).map(|_| number(self.0.next_slot())).collect())
    }

    fn lose(&mut self) {
        self.0.on_lost();
    }

    fn end_sensing(&mut self) {
        self.0.end_sensing();
    }

    fn set_rate(&mut self, user: usize, rate: u32) -> PyResult<()> {
        if user >= USERS {
            return Err(refused(Invalid::new("user", user, format!("0 to {}", USERS - 1))));
        }
        self.0.planner_mut().set_rate(user, rate);
        Ok(())
    }

    fn set_sensing_slots(&mut self, slots: u32) -> PyResult<()> {
        self.0.planner_mut().set_sensing_slots(slots).map_err(refused)
    }

    #[getter]
    fn position(&self) -> u32 {
        self.0.position()
    }

    #[getter]
    fn shares(&self) -> Vec<u32> {
        self.0.plan().shares().to_vec()
    }

    #[getter]
    fn longest_waits(&self) -> Vec<Option<u32>> {
        (0..USERS).map(|k| self.0.plan().longest_wait(k)).collect()
    }
}

/// A model file.
#[pyclass(frozen)]
pub struct Model {
    file: Vec<u8>,
}

/// Keeps the network's image.
#[derive(Default)]
struct Kept(Vec<i8>);

impl Probe for Kept {
    fn image(&mut self, image: &[i8]) {
        self.0 = image.to_vec();
    }
}

impl Model {
    fn parsed(&self) -> PyResult<Parsed<'_>> {
        Parsed::parse(&self.file).map_err(refused)
    }

    /// Slots through the pipeline.
    fn recognise(
        &self,
        slots: &PyReadonlyArrayDyn<'_, i16>,
        probe: &mut impl Probe,
    ) -> PyResult<Classification> {
        let model = self.parsed()?;
        let slots = self::slots(slots, model.radar())?;
        if slots.len() != model.sensing_slots() {
            let (have, need) = (slots.len(), model.sensing_slots());
            return Err(refused(Invalid::new(
                "number of slots",
                have,
                format!("{need}, as the model takes"),
            )));
        }
        let mut memory = OwnedMemory::for_model(&model);
        let mut pipeline = memory.pipeline::<NativeStft>(model).map_err(refused)?;
        for slot in &slots {
            pipeline.push(slot, &mut ()).map_err(refused)?;
        }
        pipeline.classify(probe).ok_or_else(|| refused("slots: too few for a window"))
    }
}

#[pymethods]
impl Model {
    #[new]
    fn new(file: Vec<u8>) -> PyResult<Self> {
        let model = Model { file };
        model.parsed()?;
        Ok(model)
    }

    #[getter]
    fn classes(&self) -> PyResult<Vec<String>> {
        let model = self.parsed()?;
        Ok((0..model.classes()).map(|class| model.class_name(class).to_owned()).collect())
    }

    #[getter]
    fn sensing_slots(&self) -> PyResult<usize> {
        Ok(self.parsed()?.sensing_slots())
    }

    #[getter]
    fn frames(&self) -> PyResult<usize> {
        Ok(self.parsed()?.frames())
    }

    #[getter]
    fn revision(&self) -> PyResult<u32> {
        Ok(self.parsed()?.revision())
    }

    #[getter]
    fn signed(&self) -> PyResult<bool> {
        Ok(self.parsed()?.is_signed())
    }

    fn image<'py>(
        &self,
        py: Python<'py>,
        slots: PyReadonlyArrayDyn<'py, i16>,
    ) -> PyResult<Bound<'py, numpy::PyArray2<i8>>> {
        let mut kept = Kept::default();
        self.recognise(&slots, &mut kept)?;
        PyArray1::from_vec(py, kept.0).reshape([ROWS, self.frames()?])
    }

    fn logits<'py>(
        &self,
        py: Python<'py>,
        image: PyReadonlyArrayDyn<'py, i8>,
    ) -> PyResult<Bound<'py, numpy::PyArrayDyn<i8>>> {
        let model = self.parsed()?;
        let (frames, classes) = (model.frames(), model.classes());
        let shape = image.shape().to_vec();
        let count = match shape[..] {
            [ROWS, f] if f == frames => 1,
            [count, ROWS, f] if f == frames => count,
            _ => {
                let legal = format!("[{ROWS}, {frames}] or [recording, {ROWS}, {frames}]");
                return Err(refused(Invalid::new("image: shape", format!("{shape:?}"), legal)));
            }
        };
        let pixels: Vec<i8> = image.as_array().iter().copied().collect();
        let mut classifier = Classifier::new(model);
        let mut logits = Vec::with_capacity(count * classes);
        for image in pixels.chunks_exact(ROWS * frames) {
            logits.extend_from_slice(&classifier.classify(image, &mut ()).logits);
        }
        let wanted = if shape.len() == 2 { vec![classes] } else { vec![count, classes] };
        PyArray1::from_vec(py, logits).reshape(wanted)
    }

    fn classify(&self, slots: PyReadonlyArrayDyn<'_, i16>) -> PyResult<(String, f32)> {
        let answer = self.recognise(&slots, &mut ())?;
        let model = self.parsed()?;
        Ok((model.class_name(usize::from(answer.class)).to_owned(), answer.confidence))
    }
}
