//! NumPy arrays from anywhere, and archives of them (`.npz`).
//!
//! NumPy Enhancement Proposal 1: magic, version, length, the text of a Python dictionary with three keys, values. The text is read
//! without recursion, and no memory is reserved for what the header only states.

use rustfft::num_complex::Complex;
use std::io::{Error, ErrorKind, Read, Result, Seek};
use zip::{ZipArchive, result::ZipError};

/// Most bytes of a header: what version 1 of the format can state.
const LONGEST: u32 = 1 << 16;
const PREFIX: usize = 8;
/// Bytes of values that are read at a time: whole values of every size.
const BLOCK: usize = 1 << 16;

/// An array: what its header says, and the reader of its values.
#[derive(Debug)]
pub struct Array<R> {
    /// Type of the values as the header has it, with its quotes: `'<i2'`; of records a list.
    pub descr: String,
    /// Whether the first index changes fastest.
    pub fortran_order: bool,
    /// Length of every axis.
    pub shape: Vec<u64>,
    values: R,
}

/// A number of an array.
pub trait Value: Sized {
    /// Its kind and bytes as NumPy writes them, behind the byte order.
    const KIND: &str;
    const SIZE: usize;
    /// The number of exactly so many bytes.
    fn of(bytes: &[u8], big_endian: bool) -> Self;
}

macro_rules! values {
    ($($type:ty: $kind:literal),*) => {$(
        impl Value for $type {
            const KIND: &str = $kind;
            const SIZE: usize = size_of::<$type>();

            fn of(bytes: &[u8], big_endian: bool) -> Self {
                let mut own = [0; size_of::<$type>()];
                own.copy_from_slice(bytes);
                if big_endian { Self::from_be_bytes(own) } else { Self::from_le_bytes(own) }
            }
        }
    )*};
}

values!(i8: "i1", i16: "i2", i32: "i4", u8: "u1", u16: "u2", u32: "u4", f32: "f4", f64: "f8");

macro_rules! complex_values {
    ($($part:ty: $kind:literal),*) => {$(
        impl Value for Complex<$part> {
            const KIND: &str = $kind;
            const SIZE: usize = 2 * size_of::<$part>();

            fn of(bytes: &[u8], big_endian: bool) -> Self {
                let (re, im) = bytes.split_at(size_of::<$part>());
                Complex::new(<$part>::of(re, big_endian), <$part>::of(im, big_endian))
            }
        }
    )*};
}

complex_values!(f32: "c8", f64: "c16");

impl<R: Read> Array<R> {
    /// Type of the values without quotes, byte order first: `<i2`.
    pub fn dtype(&self) -> &str {
        self.descr.trim_matches(['\'', '"'])
    }

    /// The type without its byte order: `i2`.
    pub fn kind(&self) -> &str {
        self.dtype().trim_start_matches(['<', '>', '|', '='])
    }

    /// All values, in the array's own order.
    ///
    /// # Errors
    ///
    /// What the reader says; values of another type, or fewer than the shape says.
    pub fn into_vec<T: Value>(self) -> Result<Vec<T>> {
        if self.kind() != T::KIND {
            return Err(invalid(format!("the type is {}, not {}", self.descr, T::KIND)));
        }
        let bytes = self.shape.iter().try_fold(T::SIZE as u64, |all, &axis| all.checked_mul(axis));
        let bytes = bytes.ok_or_else(|| invalid("the shape has more values than can be counted"))?;
        let big_endian = self.dtype().starts_with('>');
        let (mut values, mut block) = (self.values.take(bytes), Vec::with_capacity(BLOCK));
        let (mut found, mut read) = (Vec::new(), 0);
        loop {
            block.clear();
            values.by_ref().take(BLOCK as u64).read_to_end(&mut block)?;
            read += block.len() as u64;
            found.extend(block.chunks_exact(T::SIZE).map(|value| T::of(value, big_endian)));
            if block.len() < BLOCK {
                break;
            }
        }
        match read == bytes {
            true => Ok(found),
            false => Err(invalid(format!("{read} bytes of values, the shape says {bytes}"))),
        }
    }
}

/// An array.
///
/// # Errors
///
/// What the reader says; a header that is none, or longer than 64 KiB.
pub fn array<R: Read>(mut reader: R) -> Result<Array<R>> {
    let mut prefix = [0; PREFIX];
    reader.read_exact(&mut prefix)?;
    if prefix[..6] != *b"\x93NUMPY" || !(1..=3).contains(&prefix[6]) {
        return Err(invalid("it does not begin as an array of version 1 to 3"));
    }
    let mut length = [0; 4];
    reader.read_exact(&mut length[..if prefix[6] == 1 { 2 } else { 4 }])?;
    let length = u32::from_le_bytes(length);
    if length > LONGEST {
        return Err(invalid(format!("header of {length} bytes, at most {LONGEST} are read")));
    }
    let mut header = vec![0; length as usize];
    reader.read_exact(&mut header)?;
    let fields = std::str::from_utf8(&header).ok().and_then(fields);
    let (descr, fortran_order, shape) =
        fields.ok_or_else(|| invalid("the header is not a dictionary of descr, fortran_order and shape"))?;
    Ok(Array { descr: descr.to_owned(), fortran_order, shape, values: reader })
}

/// What an array begins with, version 1.0: its values follow, the last index fastest.
pub fn header(descr: &str, shape: &[usize]) -> Vec<u8> {
    let axes: String = shape.iter().map(|n| format!("{n}, ")).collect();
    let axes = if shape.len() == 1 { axes.trim_end() } else { axes.trim_end_matches(", ") };
    let header = format!("{{'descr': '{descr}', 'fortran_order': False, 'shape': ({axes}), }}");
    // magic, version and length are 10 bytes; the data begins at a multiple of 64
    let length = (10 + header.len() + 1).next_multiple_of(64) - 10;
    let text = format!("{header:<width$}\n", width = length - 1);
    [b"\x93NUMPY\x01\x00", (length as u16).to_le_bytes().as_slice(), text.as_bytes()].concat()
}

/// The values of `descr`, `fortran_order` and `shape` in the text of a dictionary.
fn fields(header: &str) -> Option<(&str, bool, Vec<u64>)> {
    let (mut descr, mut fortran_order, mut shape) = (None, None, None);
    let mut rest = header.trim().strip_prefix('{')?.strip_suffix('}')?.trim();
    while !rest.is_empty() {
        let quote = rest.chars().next().filter(|first| matches!(first, '\'' | '"'))?;
        let (key, behind) = rest[1..].split_once(quote)?;
        let behind = behind.trim_start().strip_prefix(':')?;
        let (value, behind) = behind.split_at(value_len(behind));
        let value = value.trim();
        match key {
            "descr" => descr = Some(value),
            "fortran_order" => {
                fortran_order = Some(matches!(value, "True" | "False").then_some(value == "True")?)
            }
            "shape" => {
                let axes = value.strip_prefix('(')?.strip_suffix(')')?.split(',').map(str::trim);
                let axes = axes
                    .filter(|axis| !axis.is_empty())
                    .map(str::parse)
                    .collect::<std::result::Result<_, _>>();
                shape = Some(axes.ok()?);
            }
            _ => return None,
        }
        rest = behind.strip_prefix(',').unwrap_or(behind).trim_start();
    }
    Some((descr?, fortran_order?, shape?))
}

/// Bytes before the first comma outside brackets and quotes.
fn value_len(text: &str) -> usize {
    let (mut depth, mut quote) = (0_i32, None);
    for (at, symbol) in text.char_indices() {
        match (quote, symbol) {
            (Some(open), _) if open == symbol => quote = None,
            (Some(_), _) => (),
            (None, '\'' | '"') => quote = Some(symbol),
            (None, '(' | '[' | '{') => depth += 1,
            (None, ')' | ']' | '}') => depth -= 1,
            (None, ',') if depth == 0 => return at,
            _ => (),
        }
    }
    text.len()
}

/// The archive of a `.npz` file.
///
/// # Errors
///
/// What the reader says; bytes that are no archive.
pub fn archive<R: Read + Seek>(reader: R) -> Result<ZipArchive<R>> {
    ZipArchive::new(reader).map_err(|error| match error {
        ZipError::Io(error) => error,
        error => invalid(error),
    })
}

/// The array of this name in an archive, if there is one.
///
/// # Errors
///
/// As [`array()`]; an archive that is none.
pub fn by_name<'a, R: Read + Seek>(
    archive: &'a mut ZipArchive<R>,
    name: &str,
) -> Result<Option<Array<impl Read + use<'a, R>>>> {
    match archive.by_name(&format!("{name}.npy")) {
        Ok(file) => array(file).map(Some),
        Err(ZipError::FileNotFound) => Ok(None),
        Err(ZipError::Io(error)) => Err(error),
        Err(error) => Err(invalid(error)),
    }
}

fn invalid(reason: impl ToString) -> Error {
    Error::new(ErrorKind::InvalidData, reason.to_string())
}

/// Adds an array to an archive, written by npyz.
#[cfg(test)]
pub fn write<T: npyz::AutoSerialize + Copy>(
    archive: &mut zip::ZipWriter<std::fs::File>,
    name: &str,
    shape: &[u64],
    values: &[T],
) {
    use npyz::WriterBuilder;
    archive.start_file(format!("{name}.npy"), zip::write::SimpleFileOptions::default()).unwrap();
    let mut writer =
        npyz::WriteOptions::new().default_dtype().shape(shape).writer(archive).begin_nd().unwrap();
    writer.extend(values.iter().copied()).unwrap();
    writer.finish().unwrap();
}

#[cfg(test)]
mod tests {
    use super::*;

    fn file(version: u8, length: u32, header: &str) -> Vec<u8> {
        let size = length.to_le_bytes();
        let size = if version == 1 { &size[..2] } else { &size[..] };
        [b"\x93NUMPY".as_slice(), &[version, 0], size, header.as_bytes(), &[7, 0, 9, 0]].concat()
    }

    fn of(header: &str) -> Result<(String, bool, Vec<u64>)> {
        let array = array(std::io::Cursor::new(file(2, header.len() as u32, header)));
        array.map(|array| (array.descr, array.fortran_order, array.shape))
    }

    #[test]
    fn plain_arrays_of_all_versions_are_read() {
        let header = "{'descr': '<i2', 'fortran_order': False, 'shape': (2,), }\n";
        for version in [1, 2, 3] {
            let bytes = file(version, header.len() as u32, header);
            let found = array(bytes.as_slice()).unwrap();
            assert_eq!((&found.shape[..], found.dtype(), found.kind()), (&[2][..], "<i2", "i2"));
            assert_eq!(found.into_vec::<i16>().unwrap(), [7, 9]);
        }
        let swapped = header.replace('<', ">");
        let found = array(file(1, swapped.len() as u32, &swapped).as_slice()).unwrap().into_vec::<i16>();
        assert_eq!(found.unwrap(), [0x700, 0x900]);
    }

    #[test]
    fn headers_are_dictionaries_in_any_order_and_spacing() {
        let records = "[('a, b', '<f4'), (\"c'\", '<i2', (2, 3))]";
        for (header, found) in [
            ("{\"shape\":(3,4),\"descr\":\"|u1\",\"fortran_order\":True}", ("\"|u1\"", true, vec![3, 4])),
            ("{ 'fortran_order' : False , 'shape' : () , 'descr' : '<c16' , }   ", ("'<c16'", false, vec![])),
            (
                &format!("{{'descr': {records}, 'fortran_order': False, 'shape': (5, )}}"),
                (records, false, vec![5]),
            ),
        ] {
            let (descr, order, shape) = found;
            assert_eq!(of(header).unwrap(), (descr.to_owned(), order, shape), "{header}");
        }
    }

    #[test]
    fn what_is_no_header_is_refused_however_deep_or_long() {
        for bracket in ["{", "[", "("] {
            assert!(of(&bracket.repeat(60_000)).is_err());
            assert!(of(&format!("{{'descr': {}", bracket.repeat(60_000))).is_err());
        }
        for header in [
            "",
            "{}",
            "{'descr': '<i2', 'fortran_order': False}",
            "{'descr': '<i2', 'fortran_order': 0, 'shape': (2,)}",
            "{'descr': '<i2', 'fortran_order': False, 'shape': (-2,)}",
            "{'descr': '<i2', 'fortran_order': False, 'shape': 2}",
            "{'descr': '<i2', 'fortran_order': False, 'shape': (2,), 'more': 1}",
            "{descr: '<i2', 'fortran_order': False, 'shape': (2,)}",
        ] {
            assert!(of(header).is_err(), "{header}");
        }
        let refused = |bytes: Vec<u8>| array(bytes.as_slice()).err().map(|e| e.to_string());
        let words = refused(file(2, u32::MAX, ""));
        assert_eq!(words.as_deref(), Some("header of 4294967295 bytes, at most 65536 are read"));
        assert!(refused(file(1, 90, "{}")).is_some() && refused(b"\x93NUM".to_vec()).is_some());
        assert!(refused(file(4, 2, "{}")).is_some());
    }

    #[test]
    fn values_are_as_many_and_of_the_type_that_the_header_says() {
        let read = |shape: &str| {
            let header = format!("{{'descr': '<i2', 'fortran_order': False, 'shape': {shape}, }}");
            array(file(1, header.len() as u32, &header).as_slice()).unwrap().into_vec::<i16>()
        };
        assert_eq!(read("(1,)").unwrap(), [7]);
        assert_eq!(read("()").unwrap(), [7]);
        assert!(read("(3,)").is_err());
        assert!(read("(4294967296, 4294967296)").is_err() && read("(1000000000000,)").is_err());
        let header = "{'descr': '<i2', 'fortran_order': False, 'shape': (1,), }";
        assert!(array(file(1, header.len() as u32, header).as_slice()).unwrap().into_vec::<u16>().is_err());
    }
}
