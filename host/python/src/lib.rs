//! sdp3 on numpy arrays.
//!
//! One file for what is simulated, one for what is optimized, one for the radar module, one for recordings, one for training. Every function calls what the command of its name
//! calls; answers that are no arrays are the commands' JSON as Python objects. Bad input is a `ValueError` with the command's words.

mod optimizer;
mod radar;
mod recordings;
mod simulator;
#[cfg_attr(not(feature = "train"), path = "untrained.rs")]
mod training;

use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use sdp3::scenario::{Scenario, builtin};
use serde::Serialize;
use std::fmt::Display;
use std::path::Path;

/// An error of the library as a `ValueError`.
fn refused(reason: impl Display) -> PyErr {
    PyValueError::new_err(reason.to_string())
}

/// The TOML of a scenario, which may be given as the name of a built-in one.
fn toml(text: &str) -> &str {
    builtin::named(Path::new(text)).map_or(text, |built_in| built_in.toml)
}

/// A scenario from TOML or by its name; empty: the paper's.
fn parsed(text: &str) -> PyResult<Scenario> {
    let scenario = Scenario::parse(toml(text), Path::new("scenario")).map_err(refused)?;
    sdp3::simulator::validity::check(&scenario).map_err(refused)?;
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
    module.add_function(wrap_pyfunction!(training::train, module)?)?;
    module.add_class::<radar::Scheduler>()?;
    module.add_class::<radar::Model>()
}
