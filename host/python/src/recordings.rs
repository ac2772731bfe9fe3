//! `read`, `classify`: recordings in files, or slots in an array.

use crate::{object, refused};
use numpy::{PyArray1, PyArrayMethods, PyReadonlyArrayDyn};
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict};
use sdp3::network::classify::{Classify, EarlyExits, ModelFile};
use sdp3::recordings::{Chirps, Samples, Stated, open};
use serde_json::json;
use std::io::Cursor;
use std::path::PathBuf;

/// A recording as an array, with what its file says.
#[pyfunction]
#[pyo3(signature = (file, *, carrier_hz = None, rate_hz = None, gain_db = None, dataset = None, antenna = None, chirp = None))]
pub fn read<'py>(
    py: Python<'py>,
    file: PathBuf,
    carrier_hz: Option<f64>,
    rate_hz: Option<f64>,
    gain_db: Option<f64>,
    dataset: Option<String>,
    antenna: Option<u32>,
    chirp: Option<u32>,
) -> PyResult<Bound<'py, PyDict>> {
    let chirp = chirp.map(Chirps::One);
    let stated = Stated { carrier_hz, rate_hz, gain_db, dataset, antenna, chirp, ..Stated::default() };
    let signal = py.detach(|| open(&file, &stated)).map_err(refused)?;
    let recording = PyDict::new(py);
    match signal.samples {
        Samples::Real(x) => recording.set_item("samples", PyArray1::from_vec(py, x))?,
        Samples::Complex(z) => recording.set_item("samples", PyArray1::from_vec(py, z))?,
        Samples::Slots(slots) => {
            let shape = [slots.len(), slots.per_slot];
            recording.set_item("samples", PyArray1::from_vec(py, slots.values).reshape(shape)?)?;
        }
    }
    recording.set_item("rate_hz", signal.rate_hz)?;
    recording.set_item("carrier_hz", signal.carrier_hz)?;
    recording.set_item("power_db", signal.power_db)?;
    recording.set_item("about", object(py, &signal.about)?)?;
    Ok(recording)
}

/// The windows of a recording, or of slots.
#[pyfunction]
#[pyo3(signature = (model, recording, *, step = None, least_confidence = 0.0, early_exits = None, threshold = None, guard = false,
    carrier_hz = None, rate_hz = None, dataset = None, antenna = None, chirp = None))]
pub fn classify<'py>(
    py: Python<'py>,
    model: &Bound<'py, PyAny>,
    recording: &Bound<'py, PyAny>,
    step: Option<u32>,
    least_confidence: f64,
    early_exits: Option<PathBuf>,
    threshold: Option<f64>,
    guard: bool,
    carrier_hz: Option<f64>,
    rate_hz: Option<f64>,
    dataset: Option<String>,
    antenna: Option<u32>,
    chirp: Option<u32>,
) -> PyResult<Bound<'py, PyAny>> {
    let chirp = chirp.map(Chirps::One);
    let stated = Stated { carrier_hz, rate_hz, dataset, antenna, chirp, ..Stated::default() };
    let early_exits = early_exits.map(|folder| EarlyExits { folder, threshold });
    let model = match model.cast::<PyBytes>() {
        Ok(file) => ModelFile::Bytes(file.as_bytes().to_vec()),
        Err(_) => ModelFile::Path(model.extract()?),
    };
    let request = Classify { model, early_exits, step, least_confidence, guard, stated };
    if let Ok(file) = recording.extract::<PathBuf>() {
        let found = py.detach(|| request.files(&[file]));
        return object(py, &found.map_err(refused)?);
    }
    let array = py.import("numpy")?.call_method1("ascontiguousarray", (recording, "int16"))?;
    let array: PyReadonlyArrayDyn<i16> = array.extract()?;
    let bytes: Vec<u8> = array.as_slice()?.iter().flat_map(|value| value.to_le_bytes()).collect();
    let mut windows = Vec::new();
    let ended = request.live(&mut Cursor::new(bytes), &mut |window| {
        windows.push(window.clone());
        Ok(())
    });
    let ended = ended.map_err(refused)?;
    let found =
        json!({ "windows": windows, "early_exits": ended.early_exits, "supervision": ended.supervision });
    object(py, &found)
}
