use super::*;
use crate::formats::numpy;
use npyz::WriterBuilder;
use std::f64::consts::TAU;

#[cfg(feature = "hdf5")]
mod hdf5;

struct Folder(tempfile::TempDir);

impl Folder {
    fn new() -> Self {
        Folder(tempfile::tempdir().unwrap())
    }

    fn file(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    fn npy<T: npyz::AutoSerialize + Copy>(&self, name: &str, shape: &[u64], values: &[T]) -> PathBuf {
        let file = self.file(name);
        let mut bytes = Vec::new();
        let mut writer =
            npyz::WriteOptions::new().default_dtype().shape(shape).writer(&mut bytes).begin_nd().unwrap();
        writer.extend(values).unwrap();
        writer.finish().unwrap();
        std::fs::write(&file, bytes).unwrap();
        file
    }

    fn wav(&self, channels: u16, frames: u32) -> PathBuf {
        let file = self.file("sensor.wav");
        let spec = hound::WavSpec {
            channels,
            sample_rate: 8000,
            bits_per_sample: 16,
            sample_format: hound::SampleFormat::Int,
        };
        let mut writer = hound::WavWriter::create(&file, spec).unwrap();
        (0..frames * u32::from(channels)).for_each(|n| writer.write_sample((n % 100) as i16 * 256).unwrap());
        writer.finalize().unwrap();
        file
    }

    fn sigmf(&self, datatype: &str, extra: &str, data: &[u8]) -> PathBuf {
        let meta = format!(
            "{{\"global\": {{\"core:datatype\": \"{datatype}\", \"core:sample_rate\": 100.0{extra}}}, \
             \"captures\": [{{\"core:sample_start\": 0, \"core:frequency\": 5.8e9}}], \"annotations\": []}}"
        );
        std::fs::write(self.file("walk.sigmf-meta"), meta).unwrap();
        std::fs::write(self.file("walk.sigmf-data"), data).unwrap();
        self.file("walk.sigmf-meta")
    }
}

fn stated() -> Stated {
    Stated { carrier_hz: Some(24e9), rate_hz: Some(200.0), ..Stated::default() }
}

fn refusal(file: &Path, stated: &Stated) -> String {
    let error = read(file, stated).unwrap_err().to_string();
    assert!(error.contains(&file.file_name().unwrap().to_string_lossy()[..]), "{error}");
    error
}

fn turning(n: usize) -> Complex64 {
    let (sin, cos) = (TAU * 0.01 * n as f64).sin_cos();
    Complex64::new(cos, sin)
}

#[test]
fn wav_is_real_with_one_channel_and_complex_with_two() {
    let folder = Folder::new();
    let carrier = Stated { carrier_hz: Some(24e9), ..Stated::default() };
    let signal = read(&folder.wav(1, 16_000), &carrier).unwrap();
    assert_eq!((signal.rate_hz, signal.samples.len()), (8000.0, 16_000));
    assert!(matches!(&signal.samples, Samples::Real(x) if x[1] == 1.0 / 128.0));
    let signal = read(&folder.wav(2, 16_000), &carrier).unwrap();
    assert!(matches!(&signal.samples, Samples::Complex(z) if z[1] == Complex64::new(2.0, 3.0) / 128.0));
    let error = refusal(&folder.wav(3, 16_000), &carrier);
    assert!(error.contains("channels is 3") && error.contains("1 (real) or 2"), "{error}");
    let error = refusal(&folder.wav(1, 100), &carrier);
    assert!(error.contains("length (s) is 0.013") && error.contains("at least 1.5"), "{error}");
    let error = refusal(&folder.wav(1, 16_000), &Stated::default());
    assert!(error.contains("carrier (Hz)") && error.contains("--carrier"), "{error}");
    std::fs::write(folder.file("noise.wav"), b"not a wav at all").unwrap();
    let error = refusal(&folder.file("noise.wav"), &carrier);
    assert!(error.contains("not a readable WAV"), "{error}");
}

#[test]
fn arrays_mean_what_their_shapes_say() {
    let folder = Folder::new();
    let time: Vec<Complex64> = (0..400).map(turning).collect();
    let signal = read(&folder.npy("cell.npy", &[400], &time), &stated()).unwrap();
    assert!(matches!(&signal.samples, Samples::Complex(z) if *z == time));
    // the second of three cells moves
    let cells: Vec<Complex64> = time.iter().flat_map(|&z| [Complex64::ONE * 9.0, z, z * 0.1]).collect();
    let signal = read(&folder.npy("cells.npy", &[400, 3], &cells), &stated()).unwrap();
    assert!(matches!(&signal.samples, Samples::Complex(z) if *z == time));
    // two sweeps that differ by their sign of noise
    let sweeps: Vec<Complex64> =
        time.iter().flat_map(|&z| [Complex64::ZERO, z + 0.5, Complex64::ZERO, z - 0.5]).collect();
    let signal = read(&folder.npy("sweeps.npy", &[400, 2, 2], &sweeps), &stated()).unwrap();
    assert!(
        matches!(&signal.samples, Samples::Complex(z) if z.iter().zip(&time).all(|(a, b)| (a - b).norm() < 1e-12))
    );
    let real: Vec<f32> = (0..800).map(|n| n as f32).collect();
    let signal = read(&folder.npy("iq.npy", &[400, 2], &real), &stated()).unwrap();
    assert!(matches!(&signal.samples, Samples::Complex(z) if z[3] == Complex64::new(6.0, 7.0)));
    let signal = read(&folder.npy("real.npy", &[800], &real), &stated()).unwrap();
    assert!(matches!(&signal.samples, Samples::Real(x) if x[3] == 3.0));
    let counts: Vec<i16> = (0..800).collect();
    let signal = read(&folder.npy("counts.npy", &[400, 2], &counts), &stated()).unwrap();
    assert!(matches!(&signal.samples, Samples::Complex(z) if z[3] == Complex64::new(6.0, 7.0)));
    assert_eq!(signal.about.axes, "[time], complex");
    let raw: Vec<i16> = (0..300 * 2000).map(|n| (n % 1000) as i16).collect();
    let signal = read(&folder.npy("raw.npy", &[300, 1000, 2], &raw), &stated()).unwrap();
    assert!(matches!(&signal.samples, Samples::Slots(s) if s.len() == 300 && s[1][7] == 7));
    let signal = read(&folder.npy("real-slots.npy", &[1200, 500], &raw), &stated()).unwrap();
    assert!(matches!(&signal.samples, Samples::Slots(s) if s.len() == 1200 && s[3][7] == 507));
}

#[test]
fn arrays_that_mean_nothing_are_refused() {
    let folder = Folder::new();
    let error = refusal(&folder.npy("cube.npy", &[4, 5, 5], &[1.0_f64; 100]), &stated());
    assert!(error.contains("shape is [4, 5, 5]") && error.contains("[slot, samples, 2]"), "{error}");
    let mut values = [1.0_f64; 400];
    values[77] = f64::NAN;
    let error = refusal(&folder.npy("nan.npy", &[400], &values), &stated());
    assert!(error.contains("sample 77 is NaN") && error.contains("finite"), "{error}");
    values[77] = 1e200;
    let error = refusal(&folder.npy("huge.npy", &[400], &values), &stated());
    assert!(error.contains("mean power is inf"), "{error}");
    let error = refusal(&folder.npy("silence.npy", &[400], &[0.0_f64; 400]), &stated());
    assert!(error.contains("mean power is 0"), "{error}");
    let file = folder.npy("rate.npy", &[400], &[1.0_f64; 400]);
    let error = refusal(&file, &Stated { rate_hz: Some(-5.0), ..stated() });
    assert!(error.contains("rate (Hz) is -5") && error.contains("10 to 400000"), "{error}");
    let error = refusal(&file, &Stated { rate_hz: Some(f64::NAN), ..stated() });
    assert!(error.contains("rate (Hz) is NaN"), "{error}");
    let error = refusal(&file, &Stated { gain_db: Some(1e9), ..stated() });
    assert!(error.contains("--gain is 1000000000"), "{error}");
    let whole = std::fs::read(&file).unwrap();
    for cut in [0, 5, 40, 100, 1000, whole.len() - 1] {
        std::fs::write(&file, &whole[..cut]).unwrap();
        let error = refusal(&file, &stated());
        assert!(error.contains("not a readable NPY"), "{cut}: {error}");
    }
    let error = refusal(&folder.file("absent.npy"), &stated());
    assert!(error.contains("No such file"), "{error}");
    std::fs::write(folder.file("signal.xyz"), "noise").unwrap();
    let error = refusal(&folder.file("signal.xyz"), &stated());
    assert!(error.contains("extension is \"xyz\"") && error.contains(".sigmf-meta"), "{error}");
}

#[test]
fn an_archive_gives_the_array_that_is_named() {
    let folder = Folder::new();
    let file = folder.file("session.npz");
    let mut archive = zip::ZipWriter::new(std::fs::File::create(&file).unwrap());
    for (name, value) in [("left", 1.0_f64), ("right", 2.0)] {
        numpy::write(&mut archive, name, &[400], &[value; 400]);
    }
    archive.finish().unwrap();
    let error = refusal(&file, &stated());
    assert!(error.contains("--dataset is not given") && error.contains("left, right"), "{error}");
    let right = Stated { dataset: Some("right".into()), ..stated() };
    assert!(matches!(read(&file, &right).unwrap().samples, Samples::Real(x) if x == vec![2.0; 400]));
    let middle = Stated { dataset: Some("middle".into()), ..stated() };
    assert!(refusal(&file, &middle).contains("--dataset is middle"));
}

/// A capture of two antennas and two chirps of four complex samples, and its commands; every word says where it belongs.
fn capture(folder: &Folder, frames: i16) -> PathBuf {
    let word = |frame: i16, chirp: i16, antenna: i16, sample: i16, q: i16| {
        1000 * frame + 100 * chirp + 20 * antenna + 2 * sample + q
    };
    let mut bytes = Vec::new();
    for (frame, chirp, antenna) in
        (0..frames).flat_map(|f| (0..2).flat_map(move |c| (0..2).map(move |a| (f, c, a))))
    {
        for (sample, q) in [(0, 0), (1, 0), (0, 1), (1, 1), (2, 0), (3, 0), (2, 1), (3, 1)] {
            bytes.extend(word(frame, chirp, antenna, sample, q).to_le_bytes());
        }
    }
    std::fs::write(folder.file("capture.bin"), bytes).unwrap();
    let commands = "channelCfg 5 3 0\nadcCfg 2 1\nadcbufCfg -1 0 0 1 1\nprofileCfg 0 77 7 5 60 0 0 50 1 4 5000 0 0 30\n\
                    chirpCfg 0 0 0 0 0 0 0 1\nchirpCfg 1 1 0 0 0 0 0 2\nframeCfg 0 1 1 0 1 1 0\n";
    std::fs::write(folder.file("capture.cfg"), commands).unwrap();
    folder.file("capture.bin")
}

#[test]
fn an_antenna_and_a_chirp_are_taken_from_a_capture() {
    let folder = Folder::new();
    let file = capture(&folder, 3);
    let taken = Stated { antenna: Some(2), chirp: Some(Chirps::One(2)), ..Stated::default() };
    let signal = open(&file, &taken).unwrap();
    let Samples::Slots(slots) = &signal.samples else { panic!("{signal:?}") };
    assert_eq!((slots.len(), &slots[1]), (3, &[1120, 1121, 1122, 1123, 1124, 1125, 1126, 1127][..]));
    let sensor = signal.about.sensor.unwrap();
    assert_eq!(signal.about.shape, [3, 2, 2, 4]);
    assert_eq!((sensor.antennas, sensor.chirps, sensor.transmitters), (2, 2, vec![1, 2]));
    assert!((sensor.carrier_hz - 77.25e9).abs() < 1.0 && (sensor.bandwidth_hz - 40e6).abs() < 1.0);
    assert!((signal.rate_hz - 1000.0).abs() < 1e-9);
    let commands = std::fs::read_to_string(folder.file("capture.cfg")).unwrap();
    for (from, to, words) in [
        ("frameCfg 0 1 1", "frameCfg 0 600 1", "first and last chirp is 0 to 600"),
        ("frameCfg 0 1 1", "frameCfg 0 1 4e9", "chirps of a frame is 4294967295, must be 1 to 65536"),
        ("1 4 5000", "1 4000000000 5000", "samples is 4000000000"),
        ("profileCfg", "profileCfg 1 2\nprofileCfg", "profileCfg is in 2 lines"),
    ] {
        std::fs::write(folder.file("capture.cfg"), commands.replace(from, to)).unwrap();
        let error = open(&file, &taken).unwrap_err().to_string();
        assert!(error.contains("capture.cfg") && error.contains(words), "{error}");
    }
    std::fs::write(folder.file("capture.cfg"), commands).unwrap();
    let error = refusal(&file, &Stated { antenna: Some(3), ..taken.clone() });
    assert!(error.contains("--antenna is 3, must be 1 to 2"), "{error}");
    let error = refusal(&file, &Stated { chirp: None, ..taken.clone() });
    assert!(error.contains("--chirp is not given, must be 1 to 2"), "{error}");
    let error = refusal(&file, &Stated { chirp: Some(Chirps::All), ..taken });
    assert!(error.contains("--chirp is all") && error.contains("leave a pause"), "{error}");
}

#[test]
fn a_matlab_file_without_an_array_is_refused() {
    let folder = Folder::new();
    let file = folder.file("one.mat");
    std::fs::write(&file, mat(&[1.0])).unwrap();
    assert!(refusal(&file, &Stated::default()).contains("it holds no array of numbers"));
}

/// A MATLAB file with one row of doubles.
fn mat(values: &[f64]) -> Vec<u8> {
    let element = |kind: u32, data: &[u8]| {
        let mut bytes = [kind.to_le_bytes(), (data.len() as u32).to_le_bytes()].concat();
        bytes.extend(data);
        bytes.resize(bytes.len().next_multiple_of(8), 0);
        bytes
    };
    let doubles: Vec<u8> = values.iter().flat_map(|v| v.to_le_bytes()).collect();
    let sizes = [1_u32, values.len() as u32].map(u32::to_le_bytes).concat();
    let parts =
        [element(6, &[6, 0, 0, 0, 0, 0, 0, 0]), element(5, &sizes), element(1, b"x"), element(9, &doubles)];
    let mut bytes = b"MATLAB 5.0 MAT-file".to_vec();
    bytes.resize(124, b' ');
    bytes.extend([0, 1, b'I', b'M']);
    bytes.extend(element(14, &parts.concat()));
    bytes
}

#[test]
fn changed_bytes_of_any_format_are_read_or_refused() {
    let folder = Folder::new();
    let values: Vec<f64> = (0..400).map(|n| (0.1 * f64::from(n)).sin()).collect();
    let mut files = vec![
        capture(&folder, 3),
        folder.file("capture.cfg"),
        folder.file("walk.mat"),
        folder.file("walk.csv"),
    ];
    std::fs::write(&files[2], mat(&values)).unwrap();
    let rows: Vec<String> =
        values.iter().enumerate().map(|(n, v)| format!("{},{v}", n as f64 / 100.0)).collect();
    std::fs::write(&files[3], format!("time,x\n{}\n", rows.join("\n"))).unwrap();
    let config = r#"{"device_config": {"fmcw_single_shape": {"rx_antennas": [1, 3], "start_frequency_Hz": 60e9, "end_frequency_Hz": 61e9,
        "num_chirps_per_frame": 1, "num_samples_per_chirp": 8, "chirp_repetition_time_s": 1e-3, "frame_repetition_time_s": 1e-3,
        "sample_rate_Hz": 2e6}}}"#;
    std::fs::write(folder.file("config.json"), config).unwrap();
    let counts: Vec<u16> = (0..4 * 2 * 8).map(|n| (n * 37 % 4096) as u16).collect();
    files.push(folder.npy("radar.npy", &[4, 2, 1, 8], &counts));
    files.push(folder.file("config.json"));
    let stated = Stated { carrier_hz: Some(24e9), rate_hz: Some(200.0), first: true, ..Stated::default() };
    for file in &files {
        // a description is read beside the capture that it describes
        let read_by = if file.ends_with("capture.cfg") { &files[0] } else { file };
        let whole = std::fs::read(file).unwrap();
        let signal = open(read_by, &stated).unwrap();
        assert!(!signal.samples.is_empty());
        for at in (0..whole.len()).step_by(1 + whole.len() / 400) {
            for change in [0, 255, whole[at] ^ 1, b'9'] {
                let mut changed = whole.clone();
                changed[at] = change;
                std::fs::write(file, changed).unwrap();
                let _ = open(read_by, &stated);
            }
            std::fs::write(file, &whole[..at]).unwrap();
            let _ = open(read_by, &stated);
        }
        std::fs::write(file, whole).unwrap();
    }
    let Samples::Slots(slots) = open(&folder.file("radar.npy"), &stated).unwrap().samples else {
        panic!("no slots")
    };
    assert_eq!(slots[1], [592, 629, 666, 703, 740, 777, 814, 851].map(|count: i16| count - 2048));
}

#[test]
fn sigmf_says_its_rate_and_carrier() {
    let folder = Folder::new();
    let bytes: Vec<u8> = (0..400_i16).flat_map(|n| [n, -n]).flat_map(i16::to_le_bytes).collect();
    let signal = read(&folder.sigmf("ci16_le", "", &bytes), &Stated::default()).unwrap();
    assert_eq!((signal.rate_hz, signal.carrier_hz), (100.0, 5.8e9));
    assert!(matches!(&signal.samples, Samples::Complex(z) if z[3] == Complex64::new(3.0, -3.0) / 32768.0));
    let big: Vec<u8> = (0..400).flat_map(|n| (n as f32).to_be_bytes()).collect();
    let signal = read(&folder.sigmf("rf32_be", "", &big), &Stated::default()).unwrap();
    assert!(matches!(&signal.samples, Samples::Real(x) if x[399] == 399.0));
    let signal = read(&folder.sigmf("ci8", "", &[64; 800]), &Stated::default()).unwrap();
    assert!(matches!(&signal.samples, Samples::Complex(z) if z[0] == Complex64::new(0.5, 0.5)));
    for (datatype, extra, field) in [
        ("ci16", "", "core:datatype"),
        ("ri8_le", "", "core:datatype"),
        ("cu16_le", "", "core:datatype"),
        ("ci16_le", ", \"core:num_channels\": 2", "core:num_channels is 2"),
        ("ci16_le", ", \"core:dataset\": \"../secret\"", "core:dataset"),
        ("ci16_le", ", \"sdp3:slot_samples\": 1000", "sdp3:slot_samples"),
        ("cf64_le", "", "size (bytes) is 1601"),
    ] {
        let mut bytes = bytes.clone();
        bytes.resize(if datatype == "cf64_le" { 1601 } else { 1600 }, 0);
        let error = refusal(&folder.sigmf(datatype, extra, &bytes), &Stated::default());
        assert!(error.contains(field), "{datatype}{extra}: {error}");
    }
    std::fs::remove_file(folder.file("walk.sigmf-data")).unwrap();
    let error = refusal(&folder.file("walk.sigmf-meta"), &Stated::default());
    assert!(error.contains("walk.sigmf-data"), "{error}");
    std::fs::write(folder.file("walk.sigmf-meta"), "{").unwrap();
    assert!(refusal(&folder.file("walk.sigmf-meta"), &Stated::default()).contains("not a readable SigMF"));
}

#[cfg(not(feature = "hdf5"))]
#[test]
fn without_hdf5_the_way_to_it_is_named() {
    let folder = Folder::new();
    std::fs::write(folder.file("cells.h5"), b"\x89HDF").unwrap();
    let error = refusal(&folder.file("cells.h5"), &stated());
    assert!(error.contains("--features hdf5"), "{error}");
}
