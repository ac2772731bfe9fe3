//! Bad input: exit code 2, a message naming file, field, value and legal range, and nothing written.

use sdp3_tests::{call, outcome, program};
use std::path::Path;

/// Runs the command in a fresh folder prepared by `prepare` and checks exit code, words, and that no result exists.
fn refused(arguments: &[&str], prepare: impl Fn(&Path), words: &[&str]) {
    let folder = tempfile::tempdir().expect("a folder");
    prepare(folder.path());
    let here = folder.path().to_string_lossy().into_owned();
    let arguments: Vec<String> = arguments.iter().map(|a| a.replace('@', &here)).collect();
    let arguments: Vec<&str> = arguments.iter().map(String::as_str).collect();
    let (code, stdout, stderr) = outcome(&call(&program(), &arguments));
    assert_eq!(code, 2, "{arguments:?}: {stdout}{stderr}");
    for word in words {
        assert!(stderr.contains(word), "{arguments:?}: {word:?} is not in: {stderr}");
    }
    for name in [
        "run.json",
        "figures.json",
        "report.html",
        "calibration.json",
        "optimize.json",
        "campaign.json",
        "targets.json",
    ] {
        assert!(!folder.path().join("out").join(name).exists(), "{arguments:?} wrote {name}");
    }
}

fn scenario(text: &'static str) -> impl Fn(&Path) {
    move |folder: &Path| std::fs::write(folder.join("s.toml"), text).expect("a scenario")
}

const RUN: [&str; 5] = ["run", "--scenario", "@/s.toml", "--out", "@/out"];

#[test]
fn unknown_key() {
    refused(&RUN, scenario("[radar]\ncarier_hz = 3.5e9\n"), &["s.toml", "carier_hz", "carrier_hz", "line 2"]);
}

#[test]
fn rho_out_of_range() {
    refused(&RUN, scenario("[channel]\nrho = 1.01\n"), &["s.toml", "channel.rho", "1.01", "0 to 1"]);
    refused(&RUN, scenario("[channel]\nrho = -0.5\n"), &["s.toml", "channel.rho", "-0.5", "0 to 1"]);
}

#[test]
fn more_sensing_slots_than_fit_the_period() {
    let words = ["s.toml", "frame.sensing_slots", "600", "N_s (N_m + 1) <= N = 2000"];
    refused(&RUN, scenario("[frame]\nperiod_slots = 2000\nsensing_slots = [200, 600]\n"), &words);
}

#[test]
fn a_file_that_is_no_wav() {
    let calibrate = ["calibrate", "--measured", "@/x.wav", "--carrier", "24e9", "--out", "@/out"];
    let prepare = |folder: &Path| std::fs::write(folder.join("x.wav"), b"RIFF but no more").expect("a file");
    refused(&calibrate, prepare, &["x.wav", "not a readable WAV"]);
    refused(&calibrate, |_| (), &["x.wav"]);
}

/// A NumPy array of doubles, one dimension.
fn npy(values: &[f64]) -> Vec<u8> {
    let header = format!("{{'descr': '<f8', 'fortran_order': False, 'shape': ({},), }}", values.len());
    let mut bytes = b"\x93NUMPY\x01\x00\x76\x00".to_vec();
    bytes.extend(format!("{header:<117}\n").bytes());
    bytes.extend(values.iter().flat_map(|v| v.to_le_bytes()));
    bytes
}

#[test]
fn samples_that_are_no_numbers() {
    let calibrate =
        ["calibrate", "--measured", "@/x.npy", "--carrier", "24e9", "--rate", "1e3", "--out", "@/out"];
    let mut values = vec![0.5; 4000];
    values[1234] = f64::NAN;
    let prepare = |folder: &Path| std::fs::write(folder.join("x.npy"), npy(&values)).expect("a file");
    refused(&calibrate, prepare, &["x.npy", "sample 1234 is NaN", "finite"]);
}

#[test]
fn too_few_recordings_to_learn_from_or_to_test() {
    let one = "[learning]\ntest_per_class = 1\n";
    refused(&RUN, scenario(one), &["s.toml", "learning.test_per_class", "1", "2 to 100000"]);
    let one = "[learning]\ntrain_per_class = 1\n";
    refused(&RUN, scenario(one), &["s.toml", "learning.train_per_class", "1", "2 to 100000"]);
}

#[test]
fn measured_signals_that_cannot_be() {
    let silence = |seconds: usize| {
        move |folder: &Path| {
            let (rate, size) = (8000_u32, 16_000 * seconds);
            let mut wav = b"RIFF".to_vec();
            wav.extend((36 + size as u32).to_le_bytes());
            wav.extend(b"WAVEfmt \x10\0\0\0\x01\0\x01\0");
            wav.extend([rate, 2 * rate].map(u32::to_le_bytes).concat());
            wav.extend(b"\x02\0\x10\0data");
            wav.extend((size as u32).to_le_bytes());
            wav.resize(wav.len() + size, 0);
            std::fs::write(folder.join("x.wav"), wav).expect("a file");
        }
    };
    let calibrate = |extra: &'static str| ["calibrate", "--measured", "@/x.wav", extra, "--out", "@/out"];
    refused(&calibrate("--carrier=24e9"), silence(2), &["x.wav", "mean power is 0"]);
    refused(&calibrate("--carrier=24e9"), silence(1), &["x.wav", "length (s) is 1.000", "at least 1.5"]);
    refused(&calibrate("--carrier=-3"), silence(2), &["x.wav", "carrier (Hz) is -3", "0.5e9 to 100e9"]);
    refused(&calibrate("--gain=3"), silence(2), &["x.wav", "carrier (Hz)", "stated with --carrier"]);
    refused(&calibrate("--motion=flying"), silence(2), &["'flying' for '--motion", "adult-walking"]);
}

/// A scenario with people that move as a file of joints says.
fn captured(joints: &'static str) -> impl Fn(&Path) {
    move |folder: &Path| {
        let toml = format!("[target]\ncapture = {:?}\n", folder.join("joints.csv"));
        std::fs::write(folder.join("s.toml"), toml).expect("a scenario");
        std::fs::write(folder.join("joints.csv"), joints).expect("joints");
    }
}

const SIMULATE: [&str; 7] = ["simulate", "--per-class", "1", "--scenario", "@/s.toml", "--out", "@/out"];

#[test]
fn joints_that_are_missing_or_not_numbers_or_go_back_in_time() {
    let joints = "time,joint,x,y,z\n0,base,0,0,1\n0,neck,0,0,1.5\n0.1,base,0.1,0,1\n0.1,neck,0.1,0,1.5\n";
    refused(&SIMULATE, captured(joints), &["joints.csv", "joint", "head"]);
    let joints = "time,joint,x,y,z\n0,base,0,NaN,1\n";
    refused(&SIMULATE, captured(joints), &["joints.csv", "line 2", "y", "NaN"]);
    let joints = "time,joint,x,y,z\n0.1,base,0,0,1\n0.1,neck,0,0,1.5\n0,base,0,0,1\n";
    refused(&SIMULATE, captured(joints), &["joints.csv", "line 4", "time"]);
}

/// The options that simulate a body which moves as `place` says.
fn moving(frames: u32, place: impl Fn(f64) -> [f64; 3]) -> impl Fn(&Path) {
    let mut rest = vec![("base", [0.0, 0.0, 1.0]), ("neck", [0.0, 0.0, 1.5]), ("head", [0.0, 0.0, 1.7])];
    let limbs =
        [("shoulder", 1.45), ("elbow", 1.15), ("hand", 0.9), ("hip", 0.95), ("knee", 0.5), ("ankle", 0.1)];
    let names: Vec<(String, [f64; 3])> = [("left", 0.2), ("right", -0.2)]
        .iter()
        .flat_map(|&(side, y)| {
            let joint = move |(joint, z): (&str, f64)| (format!("{side}_{joint}"), [0.0, y, z]);
            limbs.map(joint).into_iter().chain([(format!("{side}_toe"), [0.2, y, 0.05])])
        })
        .collect();
    rest.extend(names.iter().map(|(name, at)| (name.as_str(), *at)));
    let mut joints = "time,joint,x,y,z\n".to_owned();
    for frame in 0..frames {
        let t = f64::from(frame) / 40.0;
        let [dx, dy, dz] = place(t);
        for (joint, [x, y, z]) in &rest {
            joints += &format!("{t},{joint},{},{},{}\n", x + dx, y + dy, z + dz);
        }
    }
    captured(joints.leak())
}

#[test]
fn captures_that_are_short_or_leave_the_room_or_are_of_several_classes() {
    let one = [&SIMULATE[..], &["--classes", "adult-walking"]].concat();
    let slowly = |t: f64| [0.0, -0.8 * t, 0.0];
    refused(&one, moving(20, slowly), &["joints.csv", "duration is 0.475 s", "1000 sensing slots"]);
    refused(&one, moving(80, |t| [0.0, 0.0, 1.5 * t]), &["joints.csv", "head z is", "to 3 m"]);
    // to and fro within a frame's time
    let darts = |t: f64| [0.0, if (40.0 * t).round() % 2.0 == 0.0 { 0.0 } else { -1.5 }, 0.0];
    refused(&one, moving(80, darts), &["joints.csv", "speed is", "at most 30 m/s"]);
    refused(&SIMULATE, moving(80, slowly), &["--classes", "target.capture is one motion"]);
    let folder = tempfile::tempdir().expect("a folder");
    moving(80, slowly)(folder.path());
    let here = folder.path().to_string_lossy().into_owned();
    let arguments: Vec<String> = one.iter().map(|a| a.replace('@', &here)).collect();
    let arguments: Vec<&str> = arguments.iter().map(String::as_str).chain(["-q"]).collect();
    let (code, stdout, stderr) = outcome(&call(&program(), &arguments));
    assert_eq!(code, 0, "{stdout}{stderr}");
    let sidecar = std::fs::read(folder.path().join("out/part-00000.json")).expect("a sidecar");
    let sidecar: serde_json::Value = serde_json::from_slice(&sidecar).expect("JSON");
    let truth = |field: &str| sidecar["truth"][0][field].as_f64().expect("a number");
    assert!(
        (truth("speed_m_s") - 0.8).abs() < 1e-3 && (truth("heading_deg") + 90.0).abs() < 1e-3,
        "{sidecar}"
    );
}

#[test]
fn classes_antennas_and_people_that_cannot_be() {
    let twice = [&SIMULATE[..], &["--classes", "standing,standing"]].concat();
    refused(&twice, scenario(""), &["--classes", "standing twice", "each class once"]);
    let gain = "[radar]\nantenna_gain_db = 30\n";
    refused(&SIMULATE, scenario(gain), &["radar.antenna_gain_db", "30", "below radar.sidelobe_db = 30"]);
    let low = "[room]\nsize_m = [3, 4.5, 1.8]\n";
    refused(&SIMULATE, scenario(low), &["target.adult_height_m", "1.9", "b <= 1.8"]);
    let outside = "[[room.furniture]]\ncentre_m = [1, 1, 9]\ncross_section_dbsm = 0\n";
    refused(&SIMULATE, scenario(outside), &["room.furniture[0].centre_m", "inside the room"]);
}

#[test]
fn rooms_that_cannot_be() {
    let receiver = "[communication]\ncases = [[[1.5, 3.0, 1.0], [1.5, 40.0, 1.0]]]\n";
    refused(
        &SIMULATE,
        scenario(receiver),
        &["communication.cases[0][1]", "[1.5, 40.0, 1.0]", "inside the room"],
    );
    let bandwidth = "[radar]\nbandwidth_hz = -10e6\n";
    refused(&SIMULATE, scenario(bandwidth), &["radar.bandwidth_hz", "-10000000", "10000000"]);
    let outside = "[target]\nstart_m = [1.5, 50.0]\n";
    refused(&SIMULATE, scenario(outside), &["target.start_m", "[1.5, 50.0]", "inside the room"]);
    // inside at first, through a wall after some steps
    let leaves = "[target]\nstart_m = [0.2, 4.0]\nheading_spread_deg = 180.0\nturns = false\n";
    refused(&SIMULATE, scenario(leaves), &["target.turns", "leave it after", "s of"]);
}

#[test]
fn limbs_that_alias_are_warned_of() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = |name: &str| folder.path().join(name).to_string_lossy().into_owned();
    std::fs::write(file("s.toml"), "[radar]\ncarrier_hz = 24e9\n[frame]\nsensing_slots = [200]\n")
        .expect("a scenario");
    let simulate = ["simulate", "--per-class", "1", "--scenario", &file("s.toml"), "--out", &file("out")];
    let (code, _, stderr) = outcome(&call(&program(), &simulate));
    assert_eq!(code, 0, "{stderr}");
    assert!(stderr.contains("warning") && stderr.contains("frame.spacing_slots = "), "{stderr}");
}

#[test]
fn an_output_folder_that_cannot_be_written() {
    refused(&["run", "--out", "/proc/sdp3"], |_| (), &["/proc/sdp3", "--out"]);
    let prepare = |folder: &Path| std::fs::write(folder.join("file"), b"").expect("a file");
    refused(&["simulate", "--out", "@/file/below"], prepare, &["file/below", "--out"]);
}

#[test]
fn commands_that_need_a_run_say_so() {
    for command in ["verify", "schedule", "report", "optimize", "predict"] {
        refused(&[command, "--out", "@/out"], |_| (), &["run.json", "`sdp3 run`"]);
    }
    refused(&["quantize", "--out", "@/out"], |_| (), &["scenario.toml"]);
}

#[test]
fn points_out_of_range() {
    let predict = ["predict", "--points", "@/p.csv"];
    let points =
        |text: &'static str| move |folder: &Path| std::fs::write(folder.join("p.csv"), text).expect("a file");
    refused(
        &predict,
        points("sensing_slots,accuracy\n200,1.5\n"),
        &["p.csv", "line 2", "accuracy", "1.5", "0 to 1"],
    );
    refused(&predict, points("sensing_slots,accuracy\n200,NaN\n"), &["line 2", "NaN"]);
    refused(
        &predict,
        points("sensing_slots,accuracy,tested\n200,1.0,1\n"),
        &["p.csv", "line 2", "tested", "\"1\"", "at least 2"],
    );
    refused(&predict, points("a,b\n"), &["header", "sensing_slots,accuracy"]);
    refused(&predict, points("sensing_slots,accuracy\n200,0.5\n"), &["p.csv", "at least 2"]);
}

/// A scenario and the paper's points beside it.
fn with_points(text: &'static str) -> impl Fn(&Path) {
    move |folder: &Path| {
        scenario(text)(folder);
        let points = "sensing_slots,accuracy\n200,0.7885\n300,0.9016\n400,0.9142\n500,0.9309\n1000,0.9554\n";
        std::fs::write(folder.join("p.csv"), points).expect("points");
    }
}

#[test]
fn trades_that_cannot_be() {
    let optimize = |extra: &[&'static str]| {
        let mut all = vec!["optimize", "--scenario", "@/s.toml", "--points", "@/p.csv", "--out", "@/out"];
        all.extend(extra);
        all
    };
    let nobody = with_points("[communication]\ncases = [[]]\n");
    refused(&optimize(&[]), nobody, &["s.toml", "communication.cases[0] (users) is 0", "1 to 8"]);
    let silent = with_points("[communication]\nslot_bit = [[1500, 0, 3000], [1500, 2500, 3000]]\n");
    refused(&optimize(&[]), silent, &["s.toml", "communication.slot_bit[0][1] is 0", "1 to 1000000000"]);
    let fewer = with_points("[communication]\nslot_bit = [[1500, 2500], [1500, 2500, 3000]]\n");
    refused(&optimize(&[]), fewer, &["s.toml", "communication.slot_bit (users) is [2, 3]", "[3, 3]"]);
    let short = with_points("[frame]\nperiod_slots = 500\n");
    refused(&optimize(&[]), short, &["s.toml", "frame.period_slots is 500", "at least 512", "STFT window"]);
    refused(
        &optimize(&["--accuracy", "0.99"]),
        with_points(""),
        &["no point", "accuracy at least 0.99", "accuracies"],
    );
    refused(&optimize(&["--accuracy", "1.5"]), with_points(""), &["--accuracy is 1.5", "0 to 1"]);
    refused(&optimize(&["--throughput", "1e12"]), with_points(""), &["no point", "throughput at least"]);
    refused(&optimize(&["--weights", "1"]), with_points(""), &["--weights", "two numbers"]);
    refused(&optimize(&["--curve", "spline"]), with_points(""), &["'spline' for '--curve", "pow3"]);
    refused(&optimize(&["--sweep", "power_w=0"]), with_points(""), &["power_w is 0", "above 0"]);
    refused(&optimize(&["--sweep", "colour=3"]), with_points(""), &["--sweep", "carrier_hz, power_w"]);
    let one = |folder: &Path| {
        with_points("")(folder);
        std::fs::write(folder.join("p.csv"), "sensing_slots,accuracy\n200,0.5\n").expect("points");
    };
    refused(&optimize(&[]), one, &["p.csv", "1 given", "at least 2"]);
    let none = |folder: &Path| {
        with_points("")(folder);
        std::fs::write(folder.join("p.csv"), "sensing_slots,accuracy\n").expect("points");
    };
    refused(&optimize(&[]), none, &["p.csv", "0 given", "at least 2"]);
}

#[test]
fn schedules_that_cannot_be() {
    let schedule = |extra: &[&'static str]| {
        let mut all = vec!["schedule", "--periods", "3", "--out", "@/out"];
        all.extend(extra);
        all
    };
    refused(&schedule(&[]), |_| (), &["run.json", "`sdp3 run`"]);
    refused(&schedule(&["--sensing-slots", "1001"]), |_| (), &["--sensing-slots is 1001", "0 to 1000"]);
    refused(&schedule(&["--sensing-slots", "300", "--loss", "2"]), |_| (), &["--loss is 2", "0 to 1"]);
    refused(&["schedule", "--periods", "0", "--out", "@/out"], |_| (), &["--periods", "1 to 10000000"]);
    refused(&["early-exits", "--out", "@/out"], |_| (), &["scenario.toml"]);
}

#[test]
fn unknown_arguments_and_targets() {
    refused(&["run", "--sed", "1", "--out", "@/out"], |_| (), &["--sed"]);
    refused(&["run", "--targets", "z80", "--out", "@/out"], |_| (), &["z80", "cortex-m4f"]);
}

#[test]
fn datasets_that_cannot_be() {
    refused(
        &["simulate", "--per-class", "0", "--out", "@/out"],
        |_| (),
        &["--per-class", "'0'", "1 to 2000000"],
    );
    for shard in ["0/3", "4/3", "2", "1/0"] {
        refused(&["simulate", "--shard", shard, "--out", "@/out"], |_| (), &["--shard", shard, "1/N to N/N"]);
    }
    let another = |folder: &Path| {
        std::fs::create_dir_all(folder.join("out")).expect("a folder");
        std::fs::write(folder.join("out/request.json"), "{\"seed\": 3}").expect("a request");
    };
    refused(
        &["simulate", "--per-class", "1", "--out", "@/out"],
        another,
        &["request.json", "classes", "--out"],
    );
}

#[test]
fn point_targets_that_cannot_be() {
    let targets = |option: &str, value: &str, words: &[&str]| {
        refused(&["targets", option, value, "--out", "@/out"], |_| (), words);
    };
    for value in ["0", "-1", "101", "NaN"] {
        targets(&format!("--every-s={value}"), "--quiet", &["--every-s", value, "0.00001 to 100 s"]);
    }
    targets("--duration-s", "121", &["--duration-s", "121", "0.00001 to 120 s"]);
    targets("--index", "2000000", &["--index", "2000000", "0 to 1999999"]);
    targets("--classes", "flying", &["--classes", "flying", "adult-walking"]);
    refused(
        &["targets", "--duration-s", "120", "--every-s", "0.00001", "--max-time", "1m", "--out", "@/out"],
        |_| (),
        &["--duration-s / --every-s", "120 / 0.00001", "60000000 instants", "--max-time"],
    );
    let file = |folder: &Path| std::fs::write(folder.join("out"), "").expect("a file");
    refused(&["targets", "--out", "@/out/below"], file, &["out/below", "--out"]);
}
