use super::*;
use crate::formats::numpy;
use crate::simulator::dataset::Set;
use crate::store::digest::hex;
use crate::store::file_record::FileRecord;
use serde_json::Value;
use sha2::{Digest, Sha512};
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

/// Short recordings; 21 per class are a part and five recordings.
fn scenario() -> Scenario {
    let text = "name = \"short\"\n[frame]\nsensing_slots = [40]\n[spectrogram]\nwindow = 16\nhop = 8\n";
    toml::from_str(text).unwrap()
}

struct Case {
    folder: tempfile::TempDir,
    scenario: Scenario,
    raw: bool,
    sigmf: bool,
}

impl Case {
    fn new(raw: bool, sigmf: bool) -> Self {
        Case { folder: tempfile::tempdir().unwrap(), scenario: scenario(), raw, sigmf }
    }

    fn path(&self) -> &Path {
        self.folder.path()
    }

    fn make(&self, seed: u64, per_class: u32, shard: &str) -> Result<Written, OutputError> {
        let output = Output::create(self.path()).unwrap();
        self.work(seed, per_class).write(shard.parse().unwrap(), &output, &|_, _| ())
    }

    fn work(&self, seed: u64, per_class: u32) -> Work<'_> {
        Work::new(&self.scenario, 0.997, seed, per_class, Class::ALL.to_vec(), self.raw, self.sigmf)
    }

    fn files(&self) -> BTreeMap<String, Vec<u8>> {
        let entries = std::fs::read_dir(self.path()).unwrap().map(Result::unwrap);
        entries.map(|e| (e.file_name().into_string().unwrap(), std::fs::read(e.path()).unwrap())).collect()
    }

    fn manifest(&self) -> Value {
        serde_json::from_slice(&std::fs::read(self.path().join(manifest::NAME)).unwrap()).unwrap()
    }
}

fn threads(n: usize) -> rayon::ThreadPool {
    rayon::ThreadPoolBuilder::new().num_threads(n).build().unwrap()
}

/// Names only, so that a failure prints no bytes.
fn differing(a: &BTreeMap<String, Vec<u8>>, b: &BTreeMap<String, Vec<u8>>) -> Vec<String> {
    let names: BTreeSet<&String> = a.keys().chain(b.keys()).collect();
    names.into_iter().filter(|name| a.get(*name) != b.get(*name)).cloned().collect()
}

#[test]
fn bytes_do_not_depend_on_threads_shards_or_order() {
    let (one, two, shards) = (Case::new(true, true), Case::new(true, true), Case::new(true, true));
    let written = threads(1).install(|| one.make(7, 41, "1/1")).unwrap();
    let expected = Written { recordings: 205, parts: 3, made: 3, kept: 0, manifest: Some(manifest::NAME) };
    assert_eq!(written, expected);
    threads(3).install(|| two.make(7, 41, "1/1")).unwrap();
    assert_eq!(one.files().len(), 3 + 2 * 3 + 2 * 205);
    assert_eq!(differing(&one.files(), &two.files()), [""; 0]);
    for (shard, last) in [("3/3", false), ("1/3", false), ("2/3", true)] {
        let written = shards.make(7, 41, shard).unwrap();
        assert_eq!((written.made, written.kept, written.manifest.is_some()), (1, 0, last), "{shard}");
        assert_eq!(shards.path().join(manifest::NAME).exists(), last, "{shard}");
    }
    assert_eq!(differing(&one.files(), &shards.files()), [""; 0]);
    let other = Case::new(true, true);
    other.make(8, 41, "1/1").unwrap();
    assert!(
        differing(&one.files(), &other.files()).contains(&"part-00000.npz".to_owned()),
        "the seed matters"
    );
}

#[test]
fn what_is_missing_or_damaged_is_made_again_and_the_rest_is_kept() {
    let case = Case::new(false, true);
    case.make(3, 21, "1/1").unwrap();
    let whole = case.files();
    let npz = whole["part-00000.npz"].clone();
    let mut flipped = npz.clone();
    flipped[npz.len() / 2] ^= 1;
    let damages: [(&str, Option<&[u8]>); 7] = [
        ("part-00000.npz", None),
        ("part-00000.npz", Some(&npz[..npz.len() - 1])),
        ("part-00000.npz", Some(&flipped)),
        ("part-00001.json", None),
        ("part-00001.json", Some(b"{\"files\": [")),
        ("recording-00102.sigmf-meta", None),
        ("recording-00099.sigmf-data", Some(b"")),
    ];
    for (name, content) in damages {
        let path = case.path().join(name);
        match content {
            None => std::fs::remove_file(&path).unwrap(),
            Some(bytes) => std::fs::write(&path, bytes).unwrap(),
        }
        let half = format!("{name}.sdp3-partial-0123456789abcdef");
        std::fs::write(case.path().join(half), b"half").unwrap();
        let written = case.make(3, 21, "1/1").unwrap();
        assert_eq!((written.made, written.kept), (1, 1), "{name}");
        assert_eq!(differing(&whole, &case.files()), [""; 0], "{name}");
    }
    for name in [manifest::NAME, REQUEST, Scenario::FILE] {
        std::fs::remove_file(case.path().join(name)).unwrap();
        assert_eq!(case.make(3, 21, "1/1").unwrap().made, 0);
        assert_eq!(differing(&whole, &case.files()), [""; 0], "{name}");
    }
}

#[test]
fn a_complete_dataset_is_left_alone() {
    let case = Case::new(false, false);
    case.make(3, 21, "1/1").unwrap();
    let times = || {
        let entries = std::fs::read_dir(case.path()).unwrap().map(Result::unwrap);
        entries
            .map(|e| (e.file_name(), e.metadata().unwrap().modified().unwrap()))
            .collect::<BTreeMap<_, _>>()
    };
    let before = times();
    let written = case.make(3, 21, "1/1").unwrap();
    assert_eq!((written.made, written.kept), (0, 2));
    assert_eq!(before, times());
}

#[test]
fn another_dataset_is_refused_and_not_touched() {
    let mut case = Case::new(false, false);
    case.make(3, 1, "1/1").unwrap();
    let before = case.files();
    let refused = |case: &Case, seed, per_class, words: &[&str]| {
        let text = case.make(seed, per_class, "1/1").unwrap_err().to_string();
        for word in words.iter().chain(&["only the same options", "--out"]) {
            assert!(text.contains(word), "{word:?} is not in: {text}");
        }
        assert_eq!(differing(&before, &case.files()), [""; 0]);
    };
    refused(&case, 4, 1, &["request.json: seed = 3", "says 4"]);
    refused(&case, 3, 2, &["request.json: per_class = 1", "says 2"]);
    case.sigmf = true;
    refused(&case, 3, 1, &["request.json: sigmf = false", "says true"]);
    case.sigmf = false;
    case.scenario.radar.power_w *= 2.0;
    refused(&case, 3, 1, &["scenario.toml: radar.power_w = "]);
    // without its scenario.toml the dataset still knows its scenario
    let text = std::fs::read(case.path().join(Scenario::FILE)).unwrap();
    std::fs::remove_file(case.path().join(Scenario::FILE)).unwrap();
    let refusal = case.make(3, 1, "1/1").unwrap_err().to_string();
    assert!(refusal.contains("scenario_sha256"), "{refusal}");
    std::fs::write(case.path().join(Scenario::FILE), text).unwrap();
    case.scenario = scenario();
    std::fs::write(case.path().join(REQUEST), "{\"seed\": 3").unwrap();
    let refusal = case.make(3, 1, "1/1").unwrap_err().to_string();
    assert!(refusal.contains("request.json") && refusal.contains("line 1"), "{refusal}");
}

#[test]
fn the_manifest_names_every_file_and_every_truth() {
    let case = Case::new(false, true);
    case.make(3, 21, "1/1").unwrap();
    let manifest = case.manifest();
    let mut files = case.files();
    files.remove(manifest::NAME).unwrap();
    for row in manifest["files"].as_array().unwrap() {
        let record: FileRecord = serde_json::from_value(row.clone()).unwrap();
        let bytes = files.remove(&record.name).unwrap_or_else(|| panic!("{}", record.name));
        assert_eq!(record, FileRecord::new(record.name.clone(), &bytes));
    }
    assert!(files.is_empty(), "{:?}", files.keys());
    let truth = manifest["truth"].as_array().unwrap();
    assert_eq!((truth.len(), &manifest["recordings"]), (105, &Value::from(105)));
    for (index, row) in truth.iter().enumerate() {
        let record: TruthRecord = serde_json::from_value(row.clone()).unwrap();
        assert_eq!((record.index as usize, record.label as usize), (index, index % 5));
        assert_eq!(record.truth.class, Class::ALL[index % 5]);
        assert_eq!(manifest["classes"][index % 5], record.truth.class.name());
    }
    let names: Vec<_> = manifest["arrays"].as_array().unwrap().iter().map(|a| a["name"].clone()).collect();
    assert_eq!(names, ["image", "beat", "label"]);
    assert_eq!((&manifest["sensing_slots"], &manifest["scenario"]["name"]), (&40.into(), &"short".into()));
}

#[test]
fn parts_hold_the_recordings_and_sigmf_the_same_samples() {
    let case = Case::new(true, true);
    case.make(3, 21, "1/1").unwrap();
    let mut archive =
        numpy::archive(std::fs::File::open(case.path().join("part-00001.npz")).unwrap()).unwrap();
    let frames = scenario().spectrogram.preprocessing().frames(40) as u64;
    let shape = |archive: &mut _, name: &str| numpy::by_name(archive, name).unwrap().unwrap().shape;
    assert_eq!(shape(&mut archive, "image"), [5, 64, frames]);
    assert_eq!(shape(&mut archive, "beat"), [5, 40, 8, 2]);
    assert_eq!(shape(&mut archive, "raw"), [5, 40, 1000, 2]);
    let labels: Vec<u8> = numpy::by_name(&mut archive, "label").unwrap().unwrap().into_vec().unwrap();
    assert_eq!(labels, [0, 1, 2, 3, 4]);
    let images: Vec<i8> = numpy::by_name(&mut archive, "image").unwrap().unwrap().into_vec().unwrap();
    assert!(images.iter().any(|&pixel| pixel != images[0]));
    let raw: Vec<i16> = numpy::by_name(&mut archive, "raw").unwrap().unwrap().into_vec().unwrap();
    // recording 100, made alone
    let direct =
        crate::simulator::dataset::recording(&case.scenario, 0.997, 3, Set::Train, Class::ALL[0], 20, 40);
    assert_eq!(raw[..2000], direct.slots[0]);
    let data = std::fs::read(case.path().join("recording-00104.sigmf-data")).unwrap();
    let samples: Vec<i16> = data.chunks_exact(2).map(|b| i16::from_le_bytes([b[0], b[1]])).collect();
    assert_eq!(raw[4 * 80_000..], samples[..]);
    let meta = std::fs::read(case.path().join("recording-00104.sigmf-meta")).unwrap();
    let meta: Value = serde_json::from_slice(&meta).unwrap();
    assert_eq!(meta["global"]["core:sha512"], hex(&Sha512::digest(&data)));
    assert_eq!(meta["annotations"][0]["core:sample_count"], 40_000);
    assert_eq!(meta["annotations"][0]["core:label"], "adult-pacing");
}

#[test]
fn shards_are_counted_from_one() {
    assert_eq!("2/3".parse(), Ok(Shard { index: 2, count: 3 }));
    for bad in ["0/3", "4/3", "1", "1/0", "a/b", "-1/2", "1/2/3", ""] {
        let error = bad.parse::<Shard>().unwrap_err();
        assert!(error.contains("1/N to N/N"), "{error}");
    }
}

/// A dataset of 2 recordings per class with other labels and beats, digests included.
fn foreign<T: npyz::AutoSerialize + Copy>(labels: &[u8], beats: &[T], name: &str) -> String {
    let case = Case::new(false, false);
    case.make(7, 2, "1/1").unwrap();
    let path = case.path().join("part-00000.npz");
    let mut archive = zip::ZipWriter::new(std::fs::File::create(&path).unwrap());
    numpy::write(&mut archive, "label", &[labels.len() as u64], labels);
    numpy::write(&mut archive, name, &[beats.len() as u64 / 640, 40, 8, 2], beats);
    archive.finish().unwrap();
    let output = Output::create(case.path()).unwrap();
    let (mut sidecar, _) = part::sidecar(0, &output).unwrap();
    sidecar.files[0] = FileRecord::of(&output, "part-00000.npz").unwrap();
    output.write_json("part-00000.json", &sidecar).unwrap();
    manifest::write(&case.work(7, 2), &output).unwrap();
    Stored::open(case.path()).unwrap().each(|_| ()).unwrap_err().to_string()
}

#[test]
fn a_manifest_is_held_to_its_last_field() {
    let case = Case::new(false, false);
    case.make(7, 2, "1/1").unwrap();
    let (output, whole) = (Output::create(case.path()).unwrap(), case.manifest());
    let fields = whole.as_object().unwrap();
    assert_eq!(fields.len(), 11);
    let inner = [("files", 1, "bytes"), ("truth", 3, "label"), ("truth", 9, "index")];
    let edits = fields.keys().map(|field| (format!("/{field}"), field.clone()));
    let inner =
        inner.map(|(list, k, field)| (format!("/{list}/{k}/{field}"), format!("{list}[{k}].{field}")));
    for (place, field) in edits.chain(inner) {
        let mut edited = whole.clone();
        *edited.pointer_mut(&place).unwrap() = "x".into();
        output.write_json(manifest::NAME, &edited).unwrap();
        let error = Stored::open(case.path()).unwrap_err().to_string();
        // a list of files that is none is not even read
        let words = if matches!(field.split('[').next(), Some("files")) { "manifest.json" } else { &field };
        assert!(error.contains("manifest.json") && error.contains(words), "{field}: {error}");
    }
    let mut twice = whole.clone();
    let files = twice["files"].as_array_mut().unwrap();
    files.push(files[2].clone());
    output.write_json(manifest::NAME, &twice).unwrap();
    let error = Stored::open(case.path()).unwrap_err().to_string();
    assert!(error.contains("part-00000.npz") && error.contains("there once"), "{error}");
    output.write_json(manifest::NAME, &whole).unwrap();
    // the same values in another text
    let error = Stored::open(case.path()).unwrap_err().to_string();
    assert!(error.contains("its text is another"), "{error}");
}

#[test]
fn a_request_is_held_to_its_ranges_with_its_digest_corrected() {
    for (field, value, words) in [
        ("rho", Value::from(-1.0), "rho is -1, must be 0 to 1"),
        ("per_class", 0.into(), "per_class is 0, must be 2 to"),
        ("classes", Value::Array(vec![]), "classes is "),
        ("scenario_sha256", "0".into(), "scenario_sha256 is 0, must be "),
        ("seed", 8.into(), "manifest.json: files[1].sha256 is "),
    ] {
        let case = Case::new(false, false);
        case.make(7, 2, "1/1").unwrap();
        let output = Output::create(case.path()).unwrap();
        let mut request: Value = output.read_json(REQUEST, "").unwrap();
        request[field] = value;
        output.write_json(REQUEST, &request).unwrap();
        let mut manifest = case.manifest();
        let files = manifest["files"].as_array_mut().unwrap();
        let own = files.iter_mut().find(|file| file["name"] == REQUEST).unwrap();
        *own = serde_json::to_value(FileRecord::of(&output, REQUEST).unwrap()).unwrap();
        output.write_json(manifest::NAME, &manifest).unwrap();
        let error = Stored::open(case.path()).unwrap_err().to_string();
        assert!(error.contains(words), "{words:?} is not in: {error}");
    }
}

#[test]
fn parts_of_others_are_refused_by_array_value_and_range() {
    let labels: Vec<u8> = (0..10).map(|n| n % 5).collect();
    let silence = [0_i32; 6400];
    let missing: Vec<u8> = labels.iter().map(|&l| if l == 2 { 1 } else { l }).collect();
    let name = Class::ALL[1].name();
    for (error, words) in [
        (foreign(&missing, &silence, "beat"), vec![name, "is 4", "must be 2", "per_class"]),
        (foreign(&[9; 10], &silence, "beat"), vec!["part-00000.npz", "label of recording 0 is 9", "below 5"]),
        (foreign(&labels, &[f32::NAN; 6400], "beat"), vec!["beat: dtype is", "<f4", "must be '<i4'"]),
        (foreign(&labels, &silence[..5760], "beat"), vec!["beat: recordings is 9", "10, as many as label"]),
        (foreign(&labels, &silence, "beats"), vec!["part-00000.npz", "beat is missing"]),
    ] {
        words.iter().for_each(|word| assert!(error.contains(word), "{word:?} is not in: {error}"));
    }
}

#[test]
fn raw_slots_of_a_real_sensor_are_stored_and_measured_again() {
    let mut case = Case::new(true, true);
    case.scenario.radar = crate::scenario::builtin::named(Path::new("bgt60")).unwrap().scenario().radar;
    case.scenario.check("test").unwrap();
    case.make(3, 2, "1/1").unwrap();
    let mut archive =
        numpy::archive(std::fs::File::open(case.path().join("part-00000.npz")).unwrap()).unwrap();
    let raw = numpy::by_name(&mut archive, "raw").unwrap().unwrap();
    assert_eq!(raw.shape, [10, 40, 128]);
    let raw: Vec<i16> = raw.into_vec().unwrap();
    assert!(raw.iter().all(|value| (-2048..2048).contains(value)) && raw.iter().any(|value| *value != 0));
    let meta: Value =
        serde_json::from_slice(&std::fs::read(case.path().join("recording-00004.sigmf-meta")).unwrap())
            .unwrap();
    assert_eq!(meta["global"]["core:datatype"], "ri16_le");
    assert_eq!(
        (&meta["global"]["core:sample_rate"], &meta["global"]["sdp3:slot_samples"]),
        (&2e6.into(), &128.into())
    );
    assert_eq!(case.manifest()["arrays"][3]["axes"].as_array().unwrap().len(), 3);
    // what was stored is read as slots of that radar, but for being too short
    let file = case.path().join("recording-00004.sigmf-meta");
    let short = crate::recordings::read(&file, &Default::default()).unwrap_err().to_string();
    assert!(short.contains("length (s)") && short.contains("0.040"), "{short}");
    Stored::open(case.path())
        .unwrap()
        .each(|part| assert!(part.iter().all(|(_, beats)| beats.len() == 40)))
        .unwrap();
}
