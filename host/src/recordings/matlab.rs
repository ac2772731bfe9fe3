//! MATLAB files of version 5 (`save -v6` and `-v7`): one array of numbers, and `rate_hz` and `carrier_hz` if there.
//!
//! The layout is that of "MAT-File Format" (The MathWorks): elements of a tag and data, either byte order, each perhaps compressed with
//! zlib. Arrays are stored column by column. int16 arrays `[slot, sample]` are raw slots; where they are complex, I and Q.

use super::array::{Array, Numbers, checked_shape};
use super::{Contents, MeasuredError, Source};
use crate::store::limited;
use flate2::read::ZlibDecoder;
use rustfft::num_complex::Complex64;
use std::borrow::Cow;
use std::io::Read;

pub(super) const FORMAT: &str = "MATLAB 5";
/// How such a file begins.
pub(super) const MAGIC: &[u8] = b"MATLAB 5.0 MAT-file";
const HEADER: usize = 128;

/// Types of elements.
const MATRIX: u32 = 14;
const COMPRESSED: u32 = 15;
/// Classes of arrays.
const DOUBLE: u8 = 6;
const INT16: u8 = 10;
const UINT64: u8 = 15;
/// The flag of an array with imaginary parts.
const COMPLEX: u8 = 8;

/// Numbers of a variable, column by column.
pub(super) struct Variable {
    pub name: String,
    pub shape: Vec<u64>,
    pub int16: bool,
    pub real: Vec<f64>,
    pub imaginary: Option<Vec<f64>>,
}

/// Bytes in the file's order.
#[derive(Clone, Copy)]
struct Order {
    big_endian: bool,
}

pub(super) fn read(source: Source, name: Option<&str>) -> Result<Contents, MeasuredError> {
    let broken = |reason: &str| source.unreadable(FORMAT, reason);
    let size = std::fs::metadata(source.0).map_err(|error| source.unreadable(FORMAT, error))?.len();
    source.fits("size (bytes)", size, size)?;
    let bytes = limited::read(source.0, limited::WHOLE).map_err(|error| source.unreadable(FORMAT, error))?;
    let order = match bytes.get(HEADER - 2..HEADER) {
        Some(b"IM") => Order { big_endian: false },
        Some(b"MI") => Order { big_endian: true },
        Some(other) => {
            let value = String::from_utf8_lossy(other).into_owned();
            return Err(source.value("endian indicator", format!("{value:?}"), "\"IM\" or \"MI\""));
        }
        None => return Err(broken("it ends within its header")),
    };
    let mut variables = Vec::new();
    let mut rest = &bytes[HEADER..];
    while !rest.is_empty() {
        let (kind, data) = order.element(&mut rest).ok_or_else(|| broken("it ends within an element"))?;
        let element =
            if kind == COMPRESSED { Cow::Owned(inflated(source, data)?) } else { Cow::Borrowed(data) };
        let matrix = if kind == COMPRESSED {
            let (inner, data) =
                order.element(&mut &element[..]).ok_or_else(|| broken("a compressed element is empty"))?;
            if inner == MATRIX { Some(data) } else { None }
        } else {
            (kind == MATRIX).then_some(&element[..])
        };
        if let Some(matrix) = matrix {
            variables
                .extend(order.variable(matrix).ok_or_else(|| broken("an array is shorter than it says"))?);
        }
    }
    let scalar = |name: &str| variables.iter().find(|v| v.name == name).and_then(|v| v.real.first().copied());
    let (rate_hz, carrier_hz) = (scalar("rate_hz"), scalar("carrier_hz"));
    let mut arrays: Vec<Variable> = variables.into_iter().filter(|v| v.real.len() > 1).collect();
    if arrays.is_empty() {
        return Err(broken("it holds no array of numbers"));
    }
    let names: Vec<&str> = arrays.iter().map(|v| v.name.as_str()).collect();
    let legal = format!("one of {}", names.join(", "));
    let chosen = match name {
        Some(name) => names.iter().position(|found| *found == name),
        None => (arrays.len() == 1).then_some(0),
    };
    let Some(chosen) = chosen else {
        return Err(source.value("--dataset", name.unwrap_or("not given"), legal));
    };
    let mut contents = arrays.swap_remove(chosen).array(source)?.contents(source, FORMAT)?;
    (contents.rate_hz, contents.carrier_hz) = (rate_hz, carrier_hz);
    Ok(contents)
}

/// What a compressed element holds, no more of it than may be read.
fn inflated(source: Source, data: &[u8]) -> Result<Vec<u8>, MeasuredError> {
    let mut bytes = Vec::new();
    let most = source.1.memory.0;
    let decoded = ZlibDecoder::new(data).take(most.saturating_add(1)).read_to_end(&mut bytes);
    decoded.map_err(|error| source.unreadable(FORMAT, error))?;
    source.fits("size of a compressed array (bytes)", bytes.len(), bytes.len() as u64)?;
    Ok(bytes)
}

impl Order {
    fn u32(self, bytes: &[u8]) -> Option<u32> {
        let four = *bytes.first_chunk()?;
        Some(if self.big_endian { u32::from_be_bytes(four) } else { u32::from_le_bytes(four) })
    }

    /// Type and data of the next element; `rest` goes on behind its padding.
    fn element<'a>(self, rest: &mut &'a [u8]) -> Option<(u32, &'a [u8])> {
        let first = self.u32(rest)?;
        // a small element has its length in the upper half of its type
        let (kind, length, from) = match first >> 16 {
            0 => (first, self.u32(rest.get(4..)?)? as usize, 8_usize),
            length => (first & 0xffff, length as usize, 4),
        };
        let data = rest.get(from..from.checked_add(length)?)?;
        let end = if from == 4 { 8 } else { from + length };
        // compressed elements are not padded
        let end = if kind == COMPRESSED { end } else { end.next_multiple_of(8) };
        *rest = rest.get(end.min(rest.len())..)?;
        Some((kind, data))
    }

    /// The array of numbers in a matrix element; `Some(None)` of another class.
    #[allow(clippy::option_option)]
    fn variable(self, mut rest: &[u8]) -> Option<Option<Variable>> {
        if rest.is_empty() {
            return Some(None);
        }
        let (_, flags) = self.element(&mut rest)?;
        let flags = self.u32(flags)?.to_le_bytes();
        let (_, sizes) = self.element(&mut rest)?;
        let shape: Vec<u64> =
            sizes.chunks_exact(4).map(|size| self.u32(size).map(u64::from)).collect::<Option<_>>()?;
        let (_, name) = self.element(&mut rest)?;
        let class = flags[0];
        if !(DOUBLE..=UINT64).contains(&class) {
            return Some(None);
        }
        let all = shape.iter().try_fold(1_u64, |all, &n| all.checked_mul(n))?;
        let mut part = || {
            let (kind, data) = self.element(&mut rest)?;
            self.numbers(kind, data).filter(|numbers| numbers.len() as u64 == all)
        };
        let real = part()?;
        let imaginary = if flags[1] & COMPLEX != 0 { Some(part()?) } else { None };
        let name = String::from_utf8_lossy(name).into_owned();
        Some(Some(Variable { name, shape, int16: class == INT16, real, imaginary }))
    }

    /// Numbers of an element.
    fn numbers(self, kind: u32, data: &[u8]) -> Option<Vec<f64>> {
        let size = match kind {
            1 | 2 => 1,
            3 | 4 => 2,
            5..=7 => 4,
            9 | 12 | 13 => 8,
            _ => return None,
        };
        let number = |bytes: &[u8]| {
            let mut eight = [0; 8];
            eight[..size].copy_from_slice(bytes);
            if self.big_endian {
                eight[..size].reverse();
            }
            let low = u32::from_le_bytes([eight[0], eight[1], eight[2], eight[3]]);
            match kind {
                1 => f64::from(low as i8),
                3 => f64::from(low as i16),
                5 => f64::from(low.cast_signed()),
                7 => f64::from(f32::from_bits(low)),
                9 => f64::from_le_bytes(eight),
                12 => i64::from_le_bytes(eight) as f64,
                13 => u64::from_le_bytes(eight) as f64,
                _ => f64::from(low),
            }
        };
        Some(data.chunks_exact(size).map(number).collect())
    }
}

impl Variable {
    /// The variable row by row; a row or a column is one axis.
    pub(super) fn array(self, source: Source) -> Result<Array, MeasuredError> {
        let mut shape = checked_shape(source, &self.shape)?;
        let real = by_rows(self.real, &shape);
        let imaginary = self.imaginary.map(|values| by_rows(values, &shape));
        if let [1, n] | [n, 1] = shape[..] {
            shape = vec![n];
        }
        let numbers = match (self.int16, imaginary) {
            (true, None) => Numbers::Int16(real.into_iter().map(|v| v as i16).collect()),
            (true, Some(imaginary)) if shape.len() == 2 => {
                shape.push(2);
                Numbers::Int16(
                    real.into_iter().zip(imaginary).flat_map(|(i, q)| [i as i16, q as i16]).collect(),
                )
            }
            (_, Some(imaginary)) => {
                Numbers::Complex(real.into_iter().zip(imaginary).map(|(i, q)| Complex64::new(i, q)).collect())
            }
            (false, None) => Numbers::Real(real),
        };
        Ok(Array { shape, numbers })
    }
}

/// Values stored column by column, row by row.
fn by_rows(values: Vec<f64>, shape: &[usize]) -> Vec<f64> {
    if shape.iter().filter(|&&n| n > 1).count() < 2 {
        return values;
    }
    // the distance in the file from one index of an axis to the next
    let steps: Vec<usize> =
        shape.iter().scan(1, |step, &n| Some(std::mem::replace(step, *step * n))).collect();
    let mut index = vec![0; shape.len()];
    (0..values.len())
        .map(|_| {
            let at: usize = index.iter().zip(&steps).map(|(i, step)| i * step).sum();
            for axis in (0..shape.len()).rev() {
                index[axis] += 1;
                if index[axis] < shape[axis] {
                    break;
                }
                index[axis] = 0;
            }
            values[at]
        })
        .collect()
}
