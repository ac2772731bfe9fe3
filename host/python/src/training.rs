//! `train`: networks from labelled recordings, in files or in arrays.

use crate::{object, refused, toml};
use numpy::{PyReadonlyArrayDyn, PyUntypedArrayMethods};
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict};
use sdp3::error::Invalid;
use sdp3::formats::slots::Slots;
use sdp3::recordings::{Chirps, Stated};
use sdp3::train::{Held, Labelled, Method, Training};
use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, mpsc};
use std::thread;
use std::time::Duration;

/// How often signals are looked for, such as that of Ctrl-C.
const SIGNALS: Duration = Duration::from_millis(100);

/// A choice by its name.
fn named<T: Copy>(field: &str, name: &str, all: &[(&str, T)]) -> PyResult<T> {
    all.iter().find(|(own, _)| *own == name).map(|(_, one)| *one).ok_or_else(|| {
        let names: Vec<&str> = all.iter().map(|(own, _)| *own).collect();
        refused(Invalid::new(field, name, format!("one of {}", names.join(", "))))
    })
}

/// A path, or an array [slot, value] or [slot, sample, 2].
fn held(recording: &Bound<'_, PyAny>, name: &str) -> PyResult<Held> {
    if let Ok(path) = recording.extract::<PathBuf>() {
        return Ok(Held::File(path));
    }
    let refuse = |field, value: String, legal| refused(Invalid::new(field, value, legal).at(name));
    let Ok(array) = recording.extract::<PyReadonlyArrayDyn<'_, i16>>() else {
        let found = recording.getattr("dtype").unwrap_or_else(|_| recording.get_type().into_any());
        return Err(refuse("type", found.to_string(), "a path, or an array of int16"));
    };
    let shape = array.shape();
    let per_slot = match *shape {
        [_, values] => values,
        [_, samples, 2] => 2 * samples,
        _ => 0,
    };
    if per_slot == 0 {
        return Err(refuse("shape", format!("{shape:?}"), "[slot, value] or [slot, sample, 2]"));
    }
    Ok(Held::Slots(Slots { values: array.as_array().iter().copied().collect(), per_slot }))
}

/// Runs work without the GIL. A signal, such as that of Ctrl-C, sets `stop`; its exception is raised once the work has ended.
fn interruptible<T: Send>(py: Python<'_>, stop: &AtomicBool, work: impl FnOnce() -> T + Send) -> PyResult<T> {
    py.detach(|| {
        thread::scope(|scope| {
            let (ended, end) = mpsc::channel::<()>();
            let worker = scope.spawn(move || {
                let _ended = ended;
                work()
            });
            let mut raised = Ok(());
            while end.recv_timeout(SIGNALS) == Err(mpsc::RecvTimeoutError::Timeout) {
                if raised.is_ok() {
                    raised = Python::attach(|py| py.check_signals());
                    stop.store(raised.is_err(), Ordering::Relaxed);
                }
            }
            let found = worker.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic));
            raised.map(|()| found)
        })
    })
}

/// Networks that learned from labelled recordings, tested by cross-validation.
#[pyfunction]
#[pyo3(signature = (recordings, labels, scenario = "", *, persons = None, method = "recordings", folds = 5, hold_out_classes = false,
    sensing_slots = None, epochs = None, preset = "quick", seed = 1, out = None, resume = false, progress = false, carrier_hz = None,
    rate_hz = None, dataset = None, antenna = None, chirp = None))]
pub fn train<'py>(
    py: Python<'py>,
    recordings: Vec<Bound<'py, PyAny>>,
    labels: Vec<String>,
    scenario: &str,
    persons: Option<Vec<Option<String>>>,
    method: &str,
    folds: u32,
    hold_out_classes: bool,
    sensing_slots: Option<Vec<u32>>,
    epochs: Option<u32>,
    preset: &str,
    seed: u64,
    out: Option<PathBuf>,
    resume: bool,
    progress: bool,
    carrier_hz: Option<f64>,
    rate_hz: Option<f64>,
    dataset: Option<String>,
    antenna: Option<u32>,
    chirp: Option<u32>,
) -> PyResult<Bound<'py, PyAny>> {
    use Method::{FineTuning, Recordings, WithSimulation};
    let methods =
        [("recordings", Recordings), ("with-simulation", WithSimulation), ("fine-tuning", FineTuning)];
    let method = named("method", method, &methods)?;
    let quick = named("preset", preset, &[("quick", true), ("paper", false)])?;
    let count = recordings.len();
    let persons = persons.unwrap_or_else(|| vec![None; count]);
    for (field, found) in [("labels", labels.len()), ("persons", persons.len())] {
        let legal = format!("{count}, one a recording");
        Invalid::unless(found == count, format!("number of {field}"), found, legal).map_err(refused)?;
    }
    if let Some(n) = labels.iter().position(String::is_empty) {
        return Err(refused(Invalid::new(format!("labels[{n}]"), "\"\"", "not empty")));
    }
    let width = count.saturating_sub(1).to_string().len();
    let mut labelled = Vec::with_capacity(count);
    for (n, ((recording, class), person)) in recordings.iter().zip(labels).zip(persons).enumerate() {
        // in the order of their names, which the parts of the cross-validation follow
        let name = format!("recordings[{n:0width$}]");
        let held = held(recording, &name)?;
        let name = if let Held::File(path) = &held { path.display().to_string() } else { name };
        labelled.push(Labelled { name, held, class, person, span_s: None });
    }
    let folder = match out {
        Some(_) => None,
        None => Some(py.import("tempfile")?.call_method0("TemporaryDirectory")?),
    };
    let out = match (out, &folder) {
        (None, Some(folder)) => folder.getattr("name")?.extract()?,
        (out, _) => out.unwrap_or_default(),
    };
    let stop = Arc::new(AtomicBool::new(false));
    let chirp = chirp.map(Chirps::One);
    let training = Training {
        scenario: toml(scenario).to_owned(),
        quick,
        sensing_slots,
        epochs,
        seed,
        method,
        folds,
        hold_out_classes,
        stated: Stated { carrier_hz, rate_hz, dataset, antenna, chirp, ..Stated::default() },
        out,
        resume,
        progress,
        stop: stop.clone(),
    };
    let found = interruptible(py, &stop, || training.learn(labelled));
    if let Some(folder) = folder {
        folder.call_method0("cleanup")?;
    }
    let (found, files) = found?.map_err(refused)?;
    let models = PyDict::new(py);
    for (sensing_slots, file) in files {
        models.set_item(sensing_slots, PyBytes::new(py, &file))?;
    }
    let answer = object(py, &found)?;
    answer.set_item("models", models)?;
    Ok(answer)
}
