use super::merge::{CSV, JSON, PARTIAL, merge};
use super::plan::{PLAN, Plan, Sweep};
use super::status::status;
use super::store::{CELLS, Store};
use super::{kubernetes, slurm};
use crate::dataset::Shard;
use crate::formats::points;
use crate::results::{Accuracy, Cell, Measurement, Throughput};
use crate::scenario::Scenario;
use crate::simulator::calibration::stored_rho;
use crate::store::output::Output;
use proptest::prelude::*;
use std::path::Path;

const SCENARIOS: &str = "[[scenario]]\nname = \"room\"\n[[scenario]]\nname = \"hall\"\n[scenario.room]\nsize_m = [6.0, 9.0, 4.0]\n";

fn load(folder: &Path, text: &str) -> Result<Sweep, String> {
    let file = folder.join("p.toml");
    std::fs::write(&file, text).unwrap();
    let seed = (!text.contains("seeds")).then_some(7);
    Sweep::load(&file, None, seed).map_err(|error| error.to_string())
}

fn sweep(text: &str) -> Sweep {
    load(tempfile::tempdir().unwrap().path(), text).unwrap()
}

/// A sweep of 2 x 2 x 3 x 2 cells.
fn some() -> Sweep {
    sweep(&format!("rho = [0.99, 1.0]\nsensing_slots = [200, 300, 500]\nseeds = [1, 2]\n{SCENARIOS}"))
}

/// Numbers that a measurement might have.
fn measured(cell: &Cell) -> Measurement {
    let int8 = 0.95 - 30.0 / f64::from(cell.sensing_slots) + cell.seed as f64 * 1e-3;
    let accuracy = Accuracy { sensing_slots: cell.sensing_slots, float: int8 + 0.01, int8, tested: 500 };
    let bits = |case| Throughput {
        case,
        slot_bit: vec![1500.25, 2500.5],
        communication_slots: vec![2000, 1200],
        throughput_bit: 3_000_000.125 + f64::from(cell.index),
    };
    Measurement { cell: cell.clone(), accuracy, throughput: vec![bits(1), bits(2)] }
}

/// A folder with every cell of a sweep.
fn filled(sweep: &Sweep) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let output = Output::create(folder.path()).unwrap();
    sweep.open(&output).unwrap();
    let store = Store::of(sweep, folder.path());
    sweep.cells.iter().for_each(|(cell, _)| store.keep(&output, &measured(cell)).unwrap());
    folder
}

#[test]
fn every_combination_is_a_cell_and_seeds_vary_fastest() {
    let sweep = some();
    assert_eq!(sweep.cells.len(), 24);
    let of = |k: usize| {
        let c = &sweep.cells[k].0;
        (c.scenario.as_str(), c.rho, c.sensing_slots, c.seed)
    };
    assert_eq!(
        [of(0), of(1), of(2)],
        [("room", 0.99, 200, 1), ("room", 0.99, 200, 2), ("room", 0.99, 300, 1)]
    );
    assert_eq!(
        [of(6), of(12), of(23)],
        [("room", 1.0, 200, 1), ("hall", 0.99, 200, 1), ("hall", 1.0, 500, 2)]
    );
    for (index, (cell, scenario)) in sweep.cells.iter().enumerate() {
        assert_eq!(cell.index as usize, index);
        assert_eq!(
            (scenario.channel.rho, &scenario.frame.sensing_slots),
            (Some(cell.rho), &vec![cell.sensing_slots])
        );
    }
}

#[test]
fn what_a_plan_leaves_out_is_the_scenarios_own() {
    let sweep = sweep("carrier_hz = [3.5e9, 60e9]\n");
    let own = Scenario::default();
    assert_eq!(sweep.cells.len(), 2 * own.frame.sensing_slots.len());
    let (first, last) = (&sweep.cells[0].0, &sweep.cells[sweep.cells.len() - 1].0);
    assert_eq!((first.seed, first.scenario == own.name), (7, true));
    // rho is the stored table's at the cell's carrier
    let mut there = own.clone();
    there.radar.carrier_hz = 60e9;
    assert_eq!((first.rho, first.carrier_hz), (stored_rho(&own).0, 3.5e9));
    assert_eq!((last.rho, last.carrier_hz), (stored_rho(&there).0, 60e9));
}

#[test]
fn a_scenario_with_aliasing_limbs_is_warned_of_once() {
    // 4.66 m/s are unambiguous at 3.5 GHz with N_m = 3 and 12, not with 19, and at 60 GHz with none but 0
    let scenario = |n: u32, slots: u32| {
        format!(
            "[[scenario]]\nname = \"every {}\"\nframe = {{ spacing_slots = {n}, sensing_slots = [{slots}, {}] }}\n",
            n + 1,
            slots + 10
        )
    };
    let aliasing = |head: &str| {
        let plan = format!("{head}rho = [0.99, 1.0]\n{}{}", scenario(12, 160), scenario(19, 160));
        sweep(&plan).warnings().into_iter().collect::<Vec<_>>()
    };
    let of = |found: &[String], words: &[&str]| {
        assert_eq!(found.len(), words.len(), "{found:?}");
        found.iter().zip(words).for_each(|(text, word)| assert!(text.starts_with(word), "{text}"));
    };
    of(&aliasing(""), &["every 20: limbs at 4.7 m/s alias above 4.3 m/s"]);
    of(&aliasing("carrier_hz = [60e9]\n"), &["every 13: limbs at 4.7 m/s", "every 20: limbs at 4.7 m/s"]);
}

#[test]
fn plans_that_cannot_be_are_refused_by_field_value_and_range() {
    let folder = tempfile::tempdir().unwrap();
    let refused = |text: &str, words: &[&str]| {
        let error = load(folder.path(), text).unwrap_err();
        words.iter().for_each(|word| assert!(error.contains(word), "{word:?} is not in: {error}"));
    };
    refused("seed = [1]\n", &["p.toml", "line 1", "`seed`", "seeds"]);
    refused("[[scenario]]\nname = \"a\"\nchanel = 1\n", &["p.toml", "chanel", "channel"]);
    refused("rho = 0.9\n", &["p.toml", "sequence"]);
    refused("sensing_slots = [-1]\n", &["p.toml", "-1", "u32"]);
    for axis in ["carrier_hz", "rho", "sensing_slots", "seeds"] {
        refused(&format!("{axis} = []\n"), &[&format!("{axis} is []"), "at least one value"]);
    }
    refused("seeds = [1, 2, 1]\n", &["p.toml", "seeds[2] is 1", "twice"]);
    refused("rho = [1.5]\n", &["p.toml", "channel.rho is 1.5", "0 to 1"]);
    refused("rho = [nan]\n", &["channel.rho is NaN", "0 to 1"]);
    refused("carrier_hz = [1e3]\n", &["radar.carrier_hz is 1000", "500000000 to 100000000000"]);
    refused("sensing_slots = [10]\n", &["frame.sensing_slots is 10", "N_s (N_m + 1) <= N"]);
    refused("name = \"Mine\"\n", &["name is \"Mine\"", "a-z"]);
    refused("scenarios = [\"none.toml\"]\n", &["none.toml"]);
    refused(
        "[[scenario]]\nname = \"a\"\n[[scenario]]\nname = \"a\"\n",
        &["scenario[1].name is \"a\"", "of its own"],
    );
    refused("[[scenario]]\nname = \"a, b\"\n", &["scenario[0].name", "without commas"]);
    let many: Vec<u64> = (0..50_001).collect();
    refused(&format!("seeds = {many:?}\nrho = [0.9, 0.99]\n"), &["cells", "is 600012", "at most 100000"]);
    let file = folder.path().join("p.toml");
    std::fs::write(&file, SCENARIOS).unwrap();
    let error = Sweep::load(&file, Some(&Scenario::default()), None).unwrap_err().to_string();
    assert!(error.contains("--scenario") && error.contains("p.toml"), "{error}");
    std::fs::write(&file, format!("seeds = [3]\n{SCENARIOS}")).unwrap();
    let error = Sweep::load(&file, None, Some(3)).unwrap_err().to_string();
    assert!(error.contains("--seed") && error.contains("p.toml"), "{error}");
}

#[test]
fn a_folder_belongs_to_one_plan() {
    let folder = filled(&some());
    let output = Output::create(folder.path()).unwrap();
    some().open(&output).unwrap();
    let other =
        sweep(&format!("rho = [0.99, 1.0]\nsensing_slots = [200, 300, 500]\nseeds = [1, 3]\n{SCENARIOS}"));
    let error = other.open(&output).unwrap_err().to_string();
    for word in [PLAN, "seeds[1] = 2", "says 3", "--out"] {
        assert!(error.contains(word), "{word:?} is not in: {error}");
    }
}

#[test]
fn merging_is_exact_and_repeats_itself() {
    let folder = filled(&some());
    let merged = merge(folder.path(), false).unwrap();
    assert_eq!((merged.cells.len(), merged.groups.len()), (24, 4));
    let group = &merged.groups[3];
    assert_eq!(
        (group.scenario.as_str(), group.rho, group.points.len(), group.cases.len()),
        ("hall", 1.0, 3, 2)
    );
    let point = &group.points[1];
    assert_eq!((point.sensing_slots, point.seeds, point.tested), (300, 2, 1000));
    assert!((point.int8.mean - (0.85 + 1.5e-3)).abs() < 1e-12);
    assert!(group.cases.iter().all(|case| case.operating_point.is_some()) && group.curve.is_some());
    let read = |name: &str| std::fs::read_to_string(folder.path().join(name)).unwrap();
    let before = (read(CSV), read(JSON));
    let rows: Vec<&str> = before.0.lines().collect();
    assert_eq!(rows.len(), 25);
    assert!(
        rows[24].starts_with("23,hall,")
            && rows[24].ends_with(",500,0.2,3000023.125,3000023.125,3.000023125,3.000023125"),
        "{}",
        rows[24]
    );
    assert!(
        rows[0].ends_with("chance,throughput_bit_1,throughput_bit_2,throughput_mbit_s_1,throughput_mbit_s_2"),
        "{}",
        rows[0]
    );
    // cells 20 and 21, over a period of 1 s
    let bits = &point.throughput[1];
    assert_eq!((bits.case, bits.throughput_bit, bits.throughput_bit_s), (2, 3_000_020.625, 3_000_020.625));
    assert_eq!((merged.chance, merged.missing.len()), (0.2, 0));
    assert_eq!(serde_json::from_str::<crate::results::Merged>(&before.1).unwrap(), merged);
    merge(folder.path(), false).unwrap();
    assert_eq!((read(CSV), read(JSON)), before);
}

#[test]
fn missing_damaged_and_foreign_cells_are_named_and_nothing_is_written() {
    let refused = |change: &dyn Fn(&Path), words: &[&str]| {
        let folder = filled(&some());
        change(folder.path());
        let error = merge(folder.path(), false).unwrap_err().to_string();
        words.iter().for_each(|word| assert!(error.contains(word), "{word:?} is not in: {error}"));
        assert!(!folder.path().join(CSV).exists() && !folder.path().join(JSON).exists());
    };
    let cell = |folder: &Path, number: u32| folder.join(CELLS).join(format!("{number:05}.json"));
    refused(
        &|f| std::fs::remove_file(cell(f, 3)).unwrap(),
        &["00003.json: missing", "N_s = 300, seed 2", "1 of 24"],
    );
    let copy = |folder: &Path, from: u32, to: u32| {
        std::fs::copy(cell(folder, from), cell(folder, to)).unwrap();
    };
    // shard 2/3
    let shard: Shard = "2/3".parse().unwrap();
    let gone = |f: &Path| {
        (0..24).filter(|k| shard.has(*k)).for_each(|k| std::fs::remove_file(cell(f, k)).unwrap());
    };
    refused(&gone, &["8 of 24", "00001.json", "00022.json", "sdp3 sweep"]);
    refused(&|f| std::fs::write(cell(f, 5), b"{").unwrap(), &["00005.json: damaged", "EOF"]);
    refused(&|f| copy(f, 4, 5), &["00005.json: foreign: cell.index is 4, must be 5"]);
    refused(&|f| copy(f, 4, 24), &["00024.json: foreign", "0 to 23"]);
    let unexpected = |f: &Path| {
        let other = filled(&sweep("rho = [0.98]\nsensing_slots = [200]\n"));
        std::fs::copy(cell(other.path(), 0), cell(f, 0)).unwrap();
    };
    refused(&unexpected, &["00000.json: foreign: plan is "]);
    let newer = |f: &Path| {
        let text = std::fs::read_to_string(f.join(PLAN)).unwrap().replace("seeds = [1, 2]", "seeds = [1, 3]");
        std::fs::write(f.join(PLAN), text).unwrap();
    };
    refused(&newer, &["24 of 24", "and 16 more", "plan is "]);
    let empty = tempfile::tempdir().unwrap();
    let error = merge(&empty.path().join("none"), false).unwrap_err().to_string();
    assert!(error.contains("none: no sweep") && error.contains(PLAN), "{error}");
    assert!(!empty.path().join("none").exists());
}

#[test]
fn a_merged_sweep_is_a_file_of_points_of_every_spacing() {
    let scenarios = "[[scenario]]\nname = \"a\"\n[[scenario]]\nname = \"b\"\nframe = { spacing_slots = 12, sensing_slots = [200, 300] }\n";
    let folder = filled(&sweep(&format!("sensing_slots = [200, 300]\nseeds = [1, 2]\n{scenarios}")));
    let merged = merge(folder.path(), false).unwrap();
    let found = points::read(&folder.path().join(JSON)).unwrap();
    assert_eq!(found.keys().copied().collect::<Vec<_>>(), [Some(3), Some(12)]);
    for (group, points) in merged.groups.iter().zip(found.values()) {
        assert_eq!(points, &group.points.iter().map(|p| p.curve_point()).collect::<Vec<_>>());
        assert!(points.iter().all(|p| p.tested == Some(1000.0) && p.std.is_some()), "{points:?}");
    }
    // at two values of rho there are two groups of an N_m
    let folder = filled(&some());
    merge(folder.path(), false).unwrap();
    let refused = points::read(&folder.path().join(JSON)).unwrap_err().to_string();
    assert!(refused.contains("group 2: spacing_slots is 3"), "{refused}");
}

#[test]
fn a_partial_merge_joins_what_is_there() {
    let folder = filled(&some());
    let cell = |number: u32| folder.path().join(CELLS).join(format!("{number:05}.json"));
    std::fs::remove_file(cell(3)).unwrap();
    std::fs::write(cell(23), b"{").unwrap();
    let merged = merge(folder.path(), true).unwrap();
    let missing: Vec<u32> = merged.missing.iter().map(|cell| cell.index).collect();
    assert_eq!((merged.cells.len(), missing), (22, vec![3, 23]));
    assert_eq!(merged.groups[0].points[1].seeds, 1);
    let read = |name: &str| std::fs::read_to_string(folder.path().join(name)).unwrap();
    assert_eq!(read(PARTIAL[0]).lines().count(), 23);
    assert_eq!(serde_json::from_str::<crate::results::Merged>(&read(PARTIAL[1])).unwrap(), merged);
    assert!(!folder.path().join(CSV).exists() && !folder.path().join(JSON).exists());
    std::fs::copy(cell(4), cell(5)).unwrap();
    let error = merge(folder.path(), true).unwrap_err().to_string();
    assert!(error.contains("00005.json: foreign"), "{error}");
    (0..24).for_each(|k| drop(std::fs::remove_file(cell(k))));
    assert!(merge(folder.path(), true).unwrap_err().to_string().contains("no cell is there"));
}

#[test]
fn a_status_counts_every_shard_and_changes_nothing() {
    let sweep = some();
    let folder = filled(&sweep);
    let cell = |number: u32| folder.path().join(CELLS).join(format!("{number:05}.json"));
    [1, 4, 7].iter().for_each(|&number| std::fs::remove_file(cell(number)).unwrap());
    std::fs::write(cell(5), b"{").unwrap();
    let found = status(&sweep, folder.path(), 3).unwrap();
    assert_eq!((found.cells, found.done, found.missing, found.unusable), (24, 20, 3, 1));
    let shards: Vec<_> =
        found.shards.iter().map(|s| (s.shard.as_str(), s.done, s.missing, s.unusable)).collect();
    assert_eq!(shards, [("1/3", 8, 0, 0), ("2/3", 5, 3, 0), ("3/3", 7, 0, 1)]);
    assert!(found.faults.len() == 1 && found.faults[0].contains("00005.json: damaged"), "{:?}", found.faults);
    assert!(found.left_s.is_some_and(|left| left < 60.0), "{:?}", found.left_s);
    let none = folder.path().join("none");
    let found = status(&sweep, &none, 1).unwrap();
    assert_eq!((found.done, found.missing, found.left_s, none.exists()), (0, 24, None, false));
}

#[test]
fn job_files_name_the_plan_and_every_shard() {
    let folder = tempfile::tempdir().unwrap();
    let output = Output::create(&folder.path().join("it's 100%")).unwrap();
    let sweep = some();
    let jobs = slurm::write(&sweep, 6, &["--partition=long".into()], &output).unwrap().written();
    let array = std::fs::read_to_string(&jobs.files[0]).unwrap();
    for word in [
        "#SBATCH --array=1-6\n",
        "#SBATCH --requeue\n",
        "#SBATCH --partition=long\n",
        "it's 100%%/logs/shard-%a.log\"\n",
        "it'\\''s 100%/sweep.toml'",
        "scontrol requeue",
    ] {
        assert!(array.contains(word), "{word:?} is not in: {array}");
    }
    let merge = std::fs::read_to_string(&jobs.files[1]).unwrap();
    assert!(merge.contains(" merge '") && merge.contains("--partition=long"), "{merge}");
    for option in ["long", "--wrap\rrm", "-p a\n#SBATCH -p b", "-p\u{2028}"] {
        let error = slurm::write(&sweep, 6, &[option.into()], &output).unwrap_err().to_string();
        assert!(error.contains(&format!("--sbatch is {option:?}")), "{error}");
    }
    for name in ["a\n#SBATCH --wrap=x", "a\"b"] {
        let output = Output::create(&folder.path().join(name)).unwrap();
        let error = slurm::write(&sweep, 6, &[], &output).unwrap_err().to_string();
        assert!(error.contains("--out is ") && error.contains("printable"), "{error}");
        assert!(!output.path("sweep.sbatch").exists());
    }
    let jobs = kubernetes::write(&sweep, 6, ("radar/sdp3:0.1", "shared"), &output).unwrap();
    let job = std::fs::read_to_string(&jobs.files[0]).unwrap();
    let documents = job.split("\n---\n").map(|text| serde_json::from_str::<serde_json::Value>(text).unwrap());
    let [plan, job]: [serde_json::Value; 2] = documents.collect::<Vec<_>>().try_into().unwrap();
    assert_eq!(plan["data"]["sweep.toml"], sweep.plan.to_toml());
    assert_eq!((&job["spec"]["completionMode"], &job["spec"]["completions"]), (&"Indexed".into(), &6.into()));
    let container = &job["spec"]["template"]["spec"]["containers"][0];
    assert_eq!((&container["image"], &container["env"][0]["value"]), (&"radar/sdp3:0.1".into(), &"6".into()));
}

fn axis<T: Clone + std::fmt::Debug + 'static>(
    values: &[T],
) -> impl Strategy<Value = Option<Vec<T>>> + use<T> {
    let most = values.len();
    prop::option::of(prop::sample::subsequence(values.to_vec(), 1..=most))
}

prop_compose! {
    fn plans()(
        carrier_hz in axis(&[3.5e9, 24.125e9, 60e9]),
        rho in axis(&[0.9, 0.997, 1.0]),
        sensing_slots in axis(&[200, 300, 400, 1000]),
        seeds in axis(&[0, 1, 5, i64::MAX as u64]),
        rooms in 0_usize..=3,
    ) -> Plan {
        let scenario = (0..rooms).map(|k| Scenario { name: format!("room {k}"), ..Default::default() }).collect();
        Plan { name: "drawn".into(), scenarios: vec![], carrier_hz, rho, sensing_slots, seeds, scenario }
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 64, failure_persistence: None, ..Default::default() })]

    #[test]
    fn shards_cover_every_cell_exactly_once(plan in plans(), count in 1_u32..=40) {
        let sweep = sweep(&plan.to_toml());
        let axes = [
            plan.scenario.len().max(1),
            plan.carrier_hz.map_or(1, |a| a.len()),
            plan.rho.map_or(1, |a| a.len()),
            plan.sensing_slots.map_or(Scenario::default().frame.sensing_slots.len(), |a| a.len()),
            plan.seeds.map_or(1, |a| a.len()),
        ];
        prop_assert_eq!(sweep.cells.len(), axes.iter().product::<usize>());
        let mut times = vec![0; sweep.cells.len()];
        for index in 1..=count {
            let shard = Shard::new(index, count).unwrap();
            sweep.cells.iter().filter(|(cell, _)| shard.has(cell.index)).for_each(|(cell, _)| times[cell.index as usize] += 1);
        }
        prop_assert!(times.iter().all(|&times| times == 1), "{:?}", times);
        let mut keys: Vec<String> = sweep.cells.iter().map(|(c, _)| format!("{:?}", Cell { index: 0, ..c.clone() })).collect();
        keys.sort();
        keys.dedup();
        prop_assert_eq!(keys.len(), sweep.cells.len());
    }

    #[test]
    fn a_resolved_plan_resolves_to_itself(plan in plans()) {
        let once = sweep(&plan.to_toml());
        let twice = sweep(&once.plan.to_toml());
        prop_assert_eq!(once, twice);
    }
}
