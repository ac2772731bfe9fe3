//! sdp3 on numpy arrays.
//!
//! One file for what is simulated, one for what is optimized, one for the radar module, one for recordings. Every function calls what the command of its name
//! calls; answers that are no arrays are the commands' JSON as Python objects. Bad input is a `ValueError` with the command's words.

mod radar;
mod recordings;
mod simulator;
mod optimizer;

use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use sdp3::scenario::Scenario;
use serde::Serialize;
use std::fmt::Display;
use std::path::Path;

/// An error of the library as a `ValueError`.
fn refused(reason: impl Display) -> PyErr {
    PyValueError::new_err(reason.to_string())
}

/// A scenario from TOML text; empty: the paper's.
fn parsed(text: &str) -> PyResult<Scenario> {
    let scenario = Scenario::parse(text, Path::new("scenario")).map_err(refused)?;
    sdp3::simulator::dataset::check(&scenario).map_err(refused)?;
    Ok(scenario)
}

/// A result as dictionaries, lists and numbers: what `--json` prints.
fn object<'py>(py: Python<'py>, value: &impl Serialize) -> PyResult<Bound<'py, PyAny>> {
    let text = serde_json::to_string(value).map_err(refused)?;
    py.import("json")?.call_method1("loads", (text,))
}

#[pymodule]
fn _sdp3(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add("__version__", env!("CARGO_PKG_VERSION"))?;
    module.add("CLASSES", sdp3::scenario::Class::EVERY.map(|class| class.name()))?;
    module.add_function(wrap_pyfunction!(simulator::scenario, module)?)?;
    module.add_function(wrap_pyfunction!(simulator::simulate, module)?)?;
    module.add_function(wrap_pyfunction!(simulator::calibrate, module)?)?;
    module.add_function(wrap_pyfunction!(optimizer::fit, module)?)?;
    module.add_function(wrap_pyfunction!(optimizer::optimize, module)?)?;
    module.add_function(wrap_pyfunction!(radar::dechirp, module)?)?;
    module.add_function(wrap_pyfunction!(recordings::read, module)?)?;
    module.add_function(wrap_pyfunction!(recordings::classify, module)?)?;
    module.add_class::<radar::Scheduler>()?;
    module.add_class::<radar::Model>()
}
