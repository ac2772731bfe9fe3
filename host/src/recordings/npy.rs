//! NumPy arrays: `.npy`, and one array of an `.npz` archive.
//!
//! Integers of 8 to 32 bits, floats and complex numbers of either byte order. Shapes: see [`super::array`].

use super::array::{Array, Numbers, checked_shape};
use super::{Contents, MeasuredError, Source};
use crate::formats::numpy;
use crate::store::limited;
use rustfft::num_complex::{Complex32, Complex64};
use std::io::{BufReader, Read};

/// Reads a `.npy` file.
pub(super) fn read(source: Source) -> Result<Contents, MeasuredError> {
    array(source)?.contents(source, "NPY")
}

/// The array in a `.npy` file.
pub(super) fn array(source: Source) -> Result<Array, MeasuredError> {
    let file = limited::open(source.0, limited::WHOLE).map_err(|e| source.unreadable("NPY", e))?;
    let array = numpy::array(BufReader::new(file)).map_err(|e| source.unreadable("NPY", e))?;
    array_of(source, array)
}

/// Reads an array of a `.npz` file: the one named, or its only one.
pub(super) fn read_archive(source: Source, name: Option<&str>) -> Result<Contents, MeasuredError> {
    let broken = |error| source.unreadable("NPZ", error);
    let file = limited::open(source.0, limited::WHOLE).map_err(broken)?;
    let mut archive = numpy::archive(BufReader::new(file)).map_err(broken)?;
    let mut names: Vec<String> = archive
        .file_names()
        .flatten()
        .filter_map(|name| Some(name.strip_suffix(".npy")?.to_owned()))
        .collect();
    names.sort();
    let name = match (name, names.as_slice()) {
        (Some(name), _) => name,
        (None, [only]) => only,
        (None, _) => {
            return Err(source.value("--dataset", "not given", format!("one of {}", names.join(", "))));
        }
    };
    let array = numpy::by_name(&mut archive, name).map_err(broken)?;
    let array =
        array.ok_or_else(|| source.value("--dataset", name, format!("one of {}", names.join(", "))))?;
    array_of(source, array)?.contents(source, "NPZ")
}

fn array_of(source: Source, array: numpy::Array<impl Read>) -> Result<Array, MeasuredError> {
    let shape = checked_shape(source, &array.shape)?;
    if shape.len() > 1 && array.fortran_order {
        return Err(source.value("fortran_order", "True", "False: numpy.ascontiguousarray makes it so"));
    }
    let numbers = match array.kind() {
        "i1" => real::<i8>(array),
        "i2" => array.into_vec::<i16>().map(Numbers::Int16),
        "i4" => real::<i32>(array),
        "u1" => real::<u8>(array),
        "u2" => real::<u16>(array),
        "u4" => real::<u32>(array),
        "f4" => real::<f32>(array),
        "f8" => array.into_vec::<f64>().map(Numbers::Real),
        "c8" => array.into_vec::<Complex32>().map(|values| {
            let wide = |z: Complex32| Complex64::new(f64::from(z.re), f64::from(z.im));
            Numbers::Complex(values.into_iter().map(wide).collect())
        }),
        "c16" => array.into_vec::<Complex64>().map(Numbers::Complex),
        _ => return Err(source.value("dtype", &array.descr, "integers, floats or complex numbers")),
    };
    Ok(Array { shape, numbers: numbers.map_err(|e| source.unreadable("NPY", e))? })
}

fn real<T: numpy::Value + Into<f64>>(array: numpy::Array<impl Read>) -> std::io::Result<Numbers> {
    Ok(Numbers::Real(array.into_vec::<T>()?.into_iter().map(Into::into).collect()))
}
