//! Legal values and files that explode: each is refused by name before it takes anything, or is done within a stated memory.
//!
//! Peaks are the child's largest resident set. Every explosion prints its time; `tests/budget` also holds refusals to two seconds.
#![cfg(target_os = "linux")]

use flate2::{Compression, FlushCompress};
use sdp3_tests::program;
use std::io::Read;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};
use tempfile::TempDir;

const MB: f64 = 1e6;
/// What a refusal may take.
const REFUSAL: f64 = 200.0 * MB;

struct Ended {
    code: i32,
    stderr: String,
    /// Largest resident set in bytes.
    peak: f64,
    seconds: f64,
}

/// Runs the command, words apart by blanks, in a folder, `@`, on two threads.
fn sdp3(folder: &TempDir, command: &str) -> Ended {
    let here = folder.path().to_string_lossy();
    let begun = Instant::now();
    let mut child = Command::new(std::env::var_os("SDP3").map_or_else(program, Into::into))
        .args(command.replace('@', &here).split_whitespace())
        .args(["-q", "--threads", "2", "--out", &format!("{here}/out")])
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .expect("the command starts");
    let mut errors = child.stderr.take().expect("piped");
    let errors = std::thread::spawn(move || {
        let mut text = String::new();
        errors.read_to_string(&mut text).map(|_| text).unwrap_or_default()
    });
    let status = format!("/proc/{}/status", child.id());
    let mut peak = 0.0;
    let code = loop {
        // without a peak once it has ended, until it is waited for
        let text = std::fs::read_to_string(&status).unwrap_or_default();
        let line = text.lines().find_map(|line| line.strip_prefix("VmHWM:"));
        let kib = line.and_then(|line| line.split_whitespace().next()?.parse::<f64>().ok());
        peak = kib.map_or(peak, |kib| 1024.0 * kib);
        if let Some(status) = child.try_wait().expect("a child") {
            break status.code().unwrap_or(-1);
        }
        if begun.elapsed() > Duration::from_secs(120) || peak > 1500.0 * MB {
            child.kill().expect("a child");
        }
        std::thread::sleep(Duration::from_millis(1));
    };
    let stderr = errors.join().expect("a reader");
    let seconds = begun.elapsed().as_secs_f64();
    println!("{code} {seconds:6.2} s {:6.0} MB  {:.100}", peak / MB, command);
    Ended { code, stderr, peak, seconds }
}

/// Refused in one line with these words.
fn refused(folder: &TempDir, command: &str, words: &[&str]) -> Ended {
    let ended = sdp3(folder, command);
    assert_eq!(ended.code, 2, "{command:.200}: {}", ended.stderr);
    for word in words {
        assert!(ended.stderr.contains(word), "{command:.200}: {word:?} is not in: {}", ended.stderr);
    }
    assert_eq!(ended.stderr.trim_end().lines().count(), 1, "{}", ended.stderr);
    assert!(ended.peak < REFUSAL, "{command:.200}: {:.0} MB", ended.peak / MB);
    if let Some(most) = std::env::var_os("SDP3_MOST_SECONDS") {
        let most: f64 = most.to_string_lossy().parse().expect("seconds");
        assert!(ended.seconds < most, "{command:.200}: {:.2} s", ended.seconds);
    }
    ended
}

/// Done within so many megabytes.
fn done(folder: &TempDir, command: &str, megabytes: f64) {
    let ended = sdp3(folder, command);
    assert_eq!(ended.code, 0, "{command:.200}: {}", ended.stderr);
    assert!(ended.peak < megabytes * MB, "{command:.200}: {:.0} MB", ended.peak / MB);
}

fn folder() -> TempDir {
    let folder = tempfile::tempdir().expect("a folder");
    write(&folder, "p.csv", "sensing_slots,accuracy\n200,0.78\n300,0.86\n400,0.91\n600,0.94\n1000,0.95\n");
    folder
}

fn write(folder: &TempDir, name: &str, content: impl AsRef<[u8]>) {
    std::fs::write(folder.path().join(name), content).expect("a file");
}

/// The beginning of commands that draw a region.
const OPTIMIZE: &str = "optimize --points @/p.csv";
const FEW_DRAWS: &str = "--set communication.draws=20";

#[test]
fn traced_periods() {
    let folder = folder();
    let schedule = format!("schedule --sensing-slots 300 {FEW_DRAWS}");
    let traced = |periods: u32| format!("{schedule} --periods {periods} --traced {periods}");
    refused(&folder, &traced(100_000), &["--traced is 100000", "0 to 2500"]);
    done(&folder, &traced(600), 80.0);
    let written = std::fs::metadata(folder.path().join("out/trace.json")).expect("a trace").len();
    assert!(written as f64 > 100.0 * MB, "{written} bytes");
    let long = format!("{schedule} --periods 10000000 --max-time 10m");
    refused(&folder, &long, &["--periods x frame.period_slots is 10000000 x 4000", "10 min (--max-time)"]);
}

#[test]
fn draws_and_sub_carriers() {
    let folder = folder();
    let draws = "--set communication.draws=1000000 --max-time 1m";
    let wide = "--set communication.subcarriers=65536 --set communication.bandwidth_hz=2e9 \
                --set communication.cases=[[[1.5,3.0,1.0]]]";
    let words = ["communication.draws x users x sub-carriers is 1000000 x 6 x 467", "1 min (--max-time)"];
    refused(&folder, &format!("{OPTIMIZE} {draws}"), &words);
    refused(&folder, &format!("run {draws}"), &words);
    refused(&folder, &format!("{OPTIMIZE} {draws} {wide}"), &["1000000 x 1 x 65536"]);
    done(&folder, &format!("{OPTIMIZE} --set communication.draws=200 {wide}"), 100.0);
}

#[test]
fn batches_images_and_epochs_of_trainings() {
    let large = "--set learning.train_per_class=2000 --set learning.batch=10000 --set learning.channels=32";
    let network = "learning.batch x learning.channels x learning.blocks is 10000 x 32 x";
    for command in ["train", "run", "study learning-curve"] {
        let folder = folder();
        refused(&folder, &format!("{command} {large}"), &[network, "4 GiB (--max-memory)"]);
        let left = std::fs::read_dir(folder.path().join("out")).expect("a folder").count();
        assert_eq!(left, 0, "{command} left something");
    }
    let folder = folder();
    let images = "learning.train_per_class x learning.windows x frame.sensing_slots is 100000 x 100";
    let many = "train --set learning.train_per_class=100000 --set learning.windows=100";
    refused(&folder, many, &[images, "4 GiB (--max-memory)"]);
    let study =
        "study learning-curve --seeds 1000 --set learning.epochs=10000 --set frame.sensing_slots=[300]";
    refused(&folder, study, &["trainings of the study", "is 1000,", "30 d (--max-time)"]);
}

#[test]
fn points_to_fit() {
    let folder = folder();
    let row = |n: u32| format!("{},{},500\n", 200 + n, 0.5 + 0.0004 * f64::from(n));
    let points: String = (0..1000).map(row).collect();
    write(&folder, "many.csv", format!("sensing_slots,accuracy,tested\n{points}"));
    for command in ["predict", "optimize"] {
        let command = format!("{command} --points @/many.csv --max-time 10");
        refused(&folder, &command, &["many.csv: points is 1000", "10 s (--max-time)"]);
    }
}

#[test]
fn combinations_of_a_sweep() {
    let folder = folder();
    let values: Vec<String> = (0..5000).map(|k| (1.0 + f64::from(k) / 1e4).to_string()).collect();
    let values = values.join(",");
    let powers = format!("{OPTIMIZE} --sweep power_w={values}");
    let all = format!("{powers} --sweep distance={values}");
    let combinations = "--sweep (combinations) x communication.cases is 25000000 x 2";
    refused(&folder, &all, &[combinations, "4 GiB (--max-memory)"]);
    let words = ["--sweep (combinations) x communication.draws", "is 5000 x 20", "1 min (--max-time)"];
    refused(&folder, &format!("{powers} --max-time 1m"), &words);
    done(&folder, &format!("{OPTIMIZE} --sweep power_w=0.1,1 --sweep users=1,2 {FEW_DRAWS}"), 100.0);
}

#[test]
fn a_boundary_of_a_million_points() {
    let folder = folder();
    let optimize =
        |n: u32| format!("{OPTIMIZE} {FEW_DRAWS} --set frame.spacing_slots=0 --set frame.period_slots={n}");
    let words = ["frame.period_slots / (frame.spacing_slots + 1) is 1000000", "100 MiB (--max-memory)"];
    refused(&folder, &format!("{} --max-memory 100MiB", optimize(1_000_000)), &words);
    done(&folder, &optimize(300_000), 120.0);
}

#[test]
fn cells_of_a_plan() {
    let folder = folder();
    let seeds: Vec<String> = (1..=100_000).map(|seed| seed.to_string()).collect();
    write(&folder, "p.toml", format!("sensing_slots = [300]\nseeds = [{}]\n", seeds.join(",")));
    done(&folder, "sweep @/p.toml --slurm --dry-run --shards 2", 100.0);
    // some 25 days of two processors
    refused(&folder, "sweep @/p.toml --max-time 2d", &["cells of the shard is 100000", "2 d (--max-time)"]);
}

#[test]
fn a_manifest_that_names_a_file_many_times() {
    let folder = folder();
    let record = format!("{{\"name\":\"part-00000.npz\",\"bytes\":1,\"sha256\":\"{}\"}}", "0".repeat(64));
    write(&folder, "manifest.json", format!("{{\"files\":[{}]}}", vec![record; 20_000].join(",")));
    refused(&folder, "train --data @", &["manifest.json", "part-00000.npz", "there once"]);
}

#[test]
fn results_with_a_hole_of_gigabytes() {
    let folder = folder();
    std::fs::create_dir_all(folder.path().join("out")).expect("a folder");
    for name in ["points.json", "network.json", "out/run.json", "manifest.json", "signal.sigmf-data"] {
        let file = std::fs::File::create(folder.path().join(name)).expect("a file");
        file.set_len(3 << 30).expect("a hole");
    }
    let most = "3221225472 bytes, at most";
    refused(&folder, "predict --points @/points.json", &["points.json", most]);
    refused(&folder, "export @/network.json --to @/n.safetensors", &["network.json", most]);
    refused(&folder, "report", &["run.json", most]);
    refused(&folder, "train --data @", &["manifest.json", "line 1"]);
    let about = "{\"global\":{\"core:datatype\":\"ri8\",\"core:sample_rate\":1e4}}";
    write(&folder, "signal.sigmf-meta", about);
    let calibrate = "calibrate --measured @/signal.sigmf-meta --carrier 24e9";
    refused(&folder, calibrate, &["size (bytes) is 3221225472", "4 GiB (--max-memory)"]);
}

/// Zeros of so many MiB behind a start, deflated: a kilobyte a MiB.
fn deflated(start: &[u8], mib: usize) -> Vec<u8> {
    let mut deflate = flate2::Compress::new(Compression::best(), false);
    let mut block = |bytes: &[u8]| {
        let mut out = Vec::with_capacity(1 << 16);
        deflate.compress_vec(bytes, &mut out, FlushCompress::Full).expect("room");
        out
    };
    // behind a full flush every block is like the one before it
    let [start, zeros] = [block(start), block(&vec![0; 1 << 20])];
    [start, zeros.repeat(mib), vec![3, 0]].concat()
}

/// A ZIP archive of one deflated file that states this size.
fn archive(name: &str, deflated: &[u8], size: u32) -> Vec<u8> {
    let length = deflated.len() as u32;
    let mut about = [20_u16, 0, 8, 0, 33].map(u16::to_le_bytes).concat();
    about.extend([0, length, size].map(u32::to_le_bytes).concat());
    about.extend([name.len() as u16, 0].map(u16::to_le_bytes).concat());
    let local = [b"PK\x03\x04", &about[..], name.as_bytes(), deflated].concat();
    let central = [b"PK\x01\x02\x14\x00", &about[..], &[0; 14], name.as_bytes()].concat();
    let place = [central.len() as u32, local.len() as u32].map(u32::to_le_bytes).concat();
    [&local[..], &central, b"PK\x05\x06\0\0\0\0\x01\0\x01\0", &place, &[0; 2]].concat()
}

/// An array's start with this shape.
fn npy(descr: &str, shape: &str) -> Vec<u8> {
    let header = format!("{{'descr': '{descr}', 'fortran_order': False, 'shape': {shape}, }}");
    [b"\x93NUMPY\x01\x00", &118_u16.to_le_bytes()[..], format!("{header:<117}\n").as_bytes()].concat()
}

#[test]
fn archives_that_inflate() {
    let folder = folder();
    let calibrate = "calibrate --measured @/a.npz --carrier 24e9 --rate 200";
    let bomb = |shape: &str, mib: usize, size: u32| {
        let archive = archive("a.npy", &deflated(&npy("<f8", shape), mib), size);
        assert!((archive.len() as f64) < 3.0 * MB, "{} bytes", archive.len());
        write(&folder, "a.npz", archive);
    };
    bomb("(268435456,)", 2048, (2 << 30) + 128);
    refused(&folder, calibrate, &["a.npz: shape is [268435456]", "4 GiB (--max-memory)"]);
    bomb("(8388608,)", 64, (64 << 20) + 128);
    refused(&folder, &format!("{calibrate} --max-memory 100MiB"), &["a.npz: shape is [8388608]", "100 MiB"]);
    // it is zeros, which are read
    refused(&folder, calibrate, &["a.npz: mean power is 0"]);
    // what is inflated is counted: more than the shape says is not looked at, whatever size is stated
    for size in [8128, (2 << 30) + 128] {
        bomb("(1000,)", 2048, size);
        refused(&folder, calibrate, &["a.npz: mean power is 0"]);
    }
}

/// The memory that the command says it needs, when it may have none, in bytes.
fn estimate(folder: &TempDir, command: &str) -> f64 {
    let ended = refused(folder, &format!("{command} --max-memory 1"), &["1 bytes (--max-memory)"]);
    let (_, behind) = ended.stderr.split_once("about ").expect("an estimate");
    let mut words = behind.split_whitespace();
    let number: f64 = words.next().and_then(|word| word.parse().ok()).expect("a number");
    let unit = match words.next() {
        Some("KiB") => 1024.0,
        Some("MiB") => 1048576.0,
        Some("GiB") => 1073741824.0,
        unit => panic!("{unit:?} is no unit: {}", ended.stderr),
    };
    number * unit
}

#[test]
fn estimates_are_near_what_is_measured() {
    let folder = folder();
    let train = |fields: &str| {
        let fields: Vec<String> = fields.split(' ').map(|one| format!("--set learning.{one}")).collect();
        format!("train --set learning.epochs=1 {}", fields.join(" "))
    };
    let short = "--set frame.sensing_slots=[300]";
    let network = "train_per_class=40 windows=1 stem_stride=1 batch=200";
    let images = "train_per_class=60 windows=40 stem_stride=2 batch=10 channels=4 blocks=1";
    let slots = "--set frame.spacing_slots=0 --set frame.period_slots=600000";
    let numbers = 4_000_000;
    write(&folder, "a.npy", [npy("<c16", &format!("({numbers},)")), vec![0xFF; 16 * numbers]].concat());
    let nothing = sdp3(&folder, "scenario list").peak;
    for (command, code) in [
        (format!("{} {short}", train(&format!("{network} channels=32 blocks=5"))), 0),
        (format!("{} {short}", train(&format!("{network} channels=16 blocks=8"))), 0),
        (format!("{} --set frame.sensing_slots=[1000]", train(images)), 0),
        (format!("{OPTIMIZE} {FEW_DRAWS} {slots}"), 0),
        // refused when it has been read: NaN
        ("calibrate --measured @/a.npy --carrier 24e9 --rate 200".to_owned(), 2),
    ] {
        let estimated = estimate(&folder, &command);
        let ended = sdp3(&folder, &command);
        assert_eq!(ended.code, code, "{}", ended.stderr);
        let measured = ended.peak - nothing;
        println!("estimated {:.0} MB, measured {:.0} MB", estimated / MB, measured / MB);
        let ratio = estimated / measured;
        assert!((0.5..2.0).contains(&ratio), "{command}: {ratio:.2} of {:.0} MB", measured / MB);
    }
}
