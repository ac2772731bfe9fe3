//! `scenario`, `simulate`, `calibrate`.

use crate::{object, parsed, refused};
use numpy::{Complex64, PyArray1, PyArrayMethods, PyReadonlyArray1};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use rayon::prelude::*;
use sdp3::dataset::{PER_CLASS, Work, part};
use sdp3::recordings::{Samples, Stated, signal};
use sdp3::scenario::{Class, Format};
use sdp3::simulator::calibration::{calibrate_measured, rho_of};

/// The scenario resolved, as TOML.
#[pyfunction]
#[pyo3(signature = (text = ""))]
pub fn scenario(text: &str) -> PyResult<String> {
    Ok(parsed(text)?.to_toml())
}

fn class(name: &str, field: &str) -> PyResult<Class> {
    Class::EVERY.into_iter().find(|class| class.name() == name).ok_or_else(|| {
        let names = Class::EVERY.map(Class::name).join(", ");
        refused(sdp3::error::Invalid::new(field, name, format!("one of {names}")))
    })
}

/// Recordings as arrays.
#[pyfunction]
#[pyo3(signature = (scenario = "", *, per_class = 1, seed = 1, classes = None, rho = None, raw = false))]
pub fn simulate<'py>(
    py: Python<'py>,
    scenario: &str,
    per_class: u32,
    seed: u64,
    classes: Option<Vec<String>>,
    rho: Option<f64>,
    raw: bool,
) -> PyResult<Bound<'py, PyDict>> {
    let mut scenario = parsed(scenario)?;
    if let Some(rho) = rho {
        scenario.channel.rho = Some(rho);
        scenario = parsed(&scenario.to_toml())?;
    }
    if !PER_CLASS.contains(&per_class) {
        return Err(refused(sdp3::error::Invalid::new("per_class", per_class, format!("{PER_CLASS:?}"))));
    }
    let classes = match classes {
        Some(names) => names.iter().map(|name| class(name, "classes")).collect::<PyResult<_>>()?,
        None => Class::ALL.to_vec(),
    };
    let rho = rho_of(&scenario);
    let work = Work::new(&scenario, rho, seed, per_class, classes, raw, false);
    let (count, slots) = (work.recordings() as usize, work.slots() as usize);
    let all: Vec<part::One> =
        py.detach(|| (0..count as u32).into_par_iter().map(|index| part::recording(&work, index)).collect());
    let frames = all.first().map_or(0, |one| one.image.len() / sdp3_core::dims::ROWS);
    let arrays = PyDict::new(py);
    let beat: Vec<i32> = all.iter().flat_map(|one| &one.beat).flatten().flat_map(|z| [z.re, z.im]).collect();
    arrays
        .set_item("beat", PyArray1::from_vec(py, beat).reshape([count, slots, sdp3_core::dims::BEATS, 2])?)?;
    let image: Vec<i8> = all.iter().flat_map(|one| one.image.iter().copied()).collect();
    arrays
        .set_item("image", PyArray1::from_vec(py, image).reshape([count, sdp3_core::dims::ROWS, frames])?)?;
    arrays.set_item("label", PyArray1::from_vec(py, all.iter().map(|one| one.label).collect()))?;
    if raw {
        let values =
            all.iter().filter_map(|one| one.slots.as_ref()).flat_map(|slots| slots.values.iter().copied());
        let mut shape = vec![count, slots, usize::from(scenario.radar.samples)];
        shape.extend((scenario.radar.format == Format::Complex).then_some(2));
        arrays.set_item("raw", PyArray1::from_vec(py, values.collect()).reshape(shape)?)?;
    }
    Ok(arrays)
}

/// rho of a measured signal.
#[pyfunction]
#[pyo3(signature = (signal, rate_hz, carrier_hz, *, motion = "adult-walking", scenario = "", seed = 1))]
pub fn calibrate<'py>(
    py: Python<'py>,
    signal: &Bound<'py, PyAny>,
    rate_hz: f64,
    carrier_hz: f64,
    motion: &str,
    scenario: &str,
    seed: u64,
) -> PyResult<Bound<'py, PyAny>> {
    let scenario = parsed(scenario)?;
    let motion = class(motion, "motion")?;
    let numpy = py.import("numpy")?;
    let samples = if numpy.call_method1("iscomplexobj", (signal,))?.extract()? {
        let array = numpy.call_method1("ascontiguousarray", (signal, "complex128"))?;
        let array: PyReadonlyArray1<Complex64> = array.extract()?;
        Samples::Complex(array.as_slice()?.to_vec())
    } else {
        let array = numpy.call_method1("ascontiguousarray", (signal, "float64"))?;
        let array: PyReadonlyArray1<f64> = array.extract()?;
        Samples::Real(array.as_slice()?.to_vec())
    };
    let stated = Stated { carrier_hz: Some(carrier_hz), rate_hz: Some(rate_hz), ..Default::default() };
    let measured = self::signal("signal", samples, &stated).map_err(refused)?;
    let found = py.detach(|| calibrate_measured(&scenario, &measured, motion, seed, &|_, _| ()));
    object(py, &found.map_err(refused)?)
}
