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

/// A session of Acconeer's A121 at this path, with a frame rate or `null`.
fn a121(file: &std::path::Path, path: &str, frame_rate: &str, ticks: &[i64]) {
    let frames: Vec<(f64, f64)> = (0..ticks.len()).map(turning).map(|z| (z.re, z.im)).collect();
    let config = format!(r#"{{"groups": [{{"1": {{"frame_rate": {frame_rate}}}}}]}}"#);
    let mut builder = FileBuilder::new();
    builder.create_dataset("generation").with_vlen_strings(&["a121"]);
    builder.create_dataset("server_info").with_vlen_strings(&[r#"{"ticks_per_second": 1000}"#]);
    let mut result = builder.create_group("result");
    let shape = [ticks.len() as u64, 1, 1];
    result.create_dataset("frame").with_complex64_data(&frames).with_shape(&shape);
    result.create_dataset("tick").with_i64_data(ticks);
    let inside = ["entry_0", "group_0"].iter().fold(result.finish(), |inside, name| {
        let mut group = builder.create_group(name);
        group.add_group(inside);
        group.finish()
    });
    let mut names = path.rsplit('/');
    let mut session = builder.create_group(names.next().unwrap());
    session.create_dataset("session_config").with_vlen_strings(&[config.as_str()]);
    session.add_group(inside);
    let whole = names.fold(session.finish(), |inside, name| {
        let mut group = builder.create_group(name);
        group.add_group(inside);
        group.finish()
    });
    builder.add_group(whole);
    builder.write(file).unwrap();
}

#[test]
fn a121_sessions_have_the_rate_stated_or_that_of_their_ticks() {
    let folder = Folder::new();
    let file = folder.file("walk.h5");
    let ticks: Vec<i64> = (0..200).map(|n| 5000 + n * 85 / 2).collect();
    let [none, session] = ["null", "sessions/session_0"];
    for (session, frame_rate, rate_hz) in
        [(session, "12.0", 12.0), (session, none, 23.5), ("session", "12.0", 12.0), ("session", none, 23.5)]
    {
        a121(&file, session, frame_rate, &ticks);
        let signal = open(&file, &Stated::default()).unwrap();
        assert!((signal.rate_hz - rate_hz).abs() < 0.05, "{session}, {frame_rate}: {}", signal.rate_hz);
        assert_eq!((signal.carrier_hz, signal.about.shape), (60.5e9, vec![200, 1, 1]));
    }
    let mut paused = ticks.clone();
    paused[150..].iter_mut().for_each(|tick| *tick += 30);
    a121(&file, session, none, &paused);
    assert!(refusal(&file, &Stated::default()).contains("rate (Hz) is missing"));
    a121(&file, "session_0", none, &ticks);
    assert!(refusal(&file, &Stated::default()).contains("it has no frames of an A121 session"));
}

#[test]
fn a111_sessions_are_refused_by_name() {
    let folder = Folder::new();
    let file = folder.file("walk.h5");
    let mut builder = FileBuilder::new();
    for name in ["sensor_config_dump", "session_info"] {
        builder.create_dataset(name).with_vlen_strings(&["{}"]);
    }
    let data: Vec<(f64, f64)> = (0..400).map(turning).map(|z| (z.re, z.im)).collect();
    builder.create_dataset("data").with_complex64_data(&data).with_shape(&[400, 1, 1]);
    builder.write(&file).unwrap();
    let error = refusal(&file, &Stated::default());
    assert!(
        error.contains("it is a session of Acconeer's A111") && error.contains("--dataset data"),
        "{error}"
    );
    let (dataset, rate_hz) = (Some("data".into()), Some(80.0));
    let stated = Stated { dataset, rate_hz, carrier_hz: Some(60.5e9), ..Stated::default() };
    assert_eq!(open(&file, &stated).unwrap().about.shape, [400, 1, 1]);
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
