//! HDF5 and MATLAB 7.3.

use super::*;
use hdf5_pure::{AttrValue, FileBuilder};

#[test]
fn hdf5_knows_complex_cells_and_attributes() {
    let folder = Folder::new();
    let file = folder.file("cells.h5");
    let time: Vec<(f64, f64)> = (0..400).map(turning).map(|z| (z.re, z.im)).collect();
    let mut builder = FileBuilder::new();
    let dataset = builder.create_dataset("slow_time").with_complex64_data(&time).with_shape(&[400]);
    dataset.set_attr("rate_hz", AttrValue::F64(50.0));
    dataset.set_attr("carrier_hz", AttrValue::I64(60_000_000_000));
    builder.write(&file).unwrap();
    let signal = read(&file, &Stated::default()).unwrap();
    assert_eq!((signal.rate_hz, signal.carrier_hz), (50.0, 60e9));
    assert!(
        matches!(&signal.samples, Samples::Complex(z) if z.iter().enumerate().all(|(n, &z)| z == turning(n)))
    );
    let other = Stated { dataset: Some("fast_time".into()), ..Stated::default() };
    let error = refusal(&file, &other);
    assert!(error.contains("\"fast_time\"") && error.contains("one of slow_time"), "{error}");
    let whole = std::fs::read(&file).unwrap();
    for cut in (0..whole.len()).step_by(97) {
        std::fs::write(&file, &whole[..cut]).unwrap();
        refusal(&file, &Stated::default());
    }
}

/// A file of version 7.3 as MATLAB writes it: HDF5 behind 512 bytes, axes the other way round.
#[test]
fn matlab_7_3_is_read_column_by_column() {
    let folder = Folder::new();
    let file = folder.file("walk.mat");
    let mut builder = FileBuilder::new();
    builder.with_userblock(512);
    let class = |name: &str| AttrValue::AsciiString(name.into());
    // 300 slots of 64 samples are stored as `[64, 300]`
    let slots: Vec<i16> = (0..300 * 64).map(|k| (k * 7 % 4001 - 2000) as i16).collect();
    let columns: Vec<i16> =
        (0..64).flat_map(|sample| (0..300).map(move |slot| slot * 64 + sample)).map(|k| slots[k]).collect();
    builder
        .create_dataset("walk")
        .with_i16_data(&columns)
        .with_shape(&[64, 300])
        .set_attr("MATLAB_class", class("int16"));
    builder
        .create_dataset("note")
        .with_u16_data(&[119, 97, 108, 107])
        .with_shape(&[4, 1])
        .set_attr("MATLAB_class", class("char"));
    for (name, value) in [("rate_hz", 500.0), ("carrier_hz", 60e9)] {
        builder
            .create_dataset(name)
            .with_f64_data(&[value])
            .with_shape(&[1, 1])
            .set_attr("MATLAB_class", class("double"));
    }
    builder.write(&file).unwrap();
    let mut bytes = std::fs::read(&file).unwrap();
    bytes[..19].copy_from_slice(b"MATLAB 7.3 MAT-file");
    std::fs::write(&file, &bytes).unwrap();
    let signal = open(&file, &Stated::default()).unwrap();
    assert_eq!(
        (signal.rate_hz, signal.carrier_hz, signal.about.format.as_str()),
        (500.0, 60e9, "MATLAB 7.3")
    );
    assert!(
        matches!(&signal.samples, Samples::Slots(found) if found.values == slots && found.per_slot == 64)
    );
    let other = Stated { dataset: Some("note".into()), ..Stated::default() };
    assert!(refusal(&file, &other).contains("one of walk"));
}
