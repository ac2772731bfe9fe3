//! `train` of a build that cannot.

use pyo3::exceptions::PyNotImplementedError;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyTuple};

/// Says so.
#[pyfunction]
#[pyo3(signature = (*_positional, **_named))]
pub fn train(_positional: &Bound<'_, PyTuple>, _named: Option<&Bound<'_, PyDict>>) -> PyResult<()> {
    Err(PyNotImplementedError::new_err("this build cannot train: build it with the feature `train`"))
}
