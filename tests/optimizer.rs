//! Water-filling, the weighted sum and the whole integer problem against scipy and trying all, 200 random instances each.
//!
//! The vectors and the program that made them lie in `tests/oracles`.

use sdp3::optimizer::operating_point::{Rule, choose};
use sdp3::optimizer::region::{Point, point};
use sdp3::optimizer::theorem::Theorem;
use sdp3::optimizer::water_filling::allocate;
use sdp3::results::{Curve, Parameters};
use sdp3_tests::{call, outcome, program};
use serde_json::Value;

fn golden() -> Value {
    serde_json::from_str(include_str!("oracles/allocation.json")).expect("JSON")
}

fn number(value: &Value) -> f64 {
    value.as_f64().expect("a number")
}

fn numbers(value: &Value) -> Vec<f64> {
    value.as_array().expect("a list").iter().map(number).collect()
}

fn instances<'a>(golden: &'a Value, kind: &str) -> &'a Vec<Value> {
    let all = golden[kind].as_array().expect("instances");
    assert_eq!(all.len(), 200, "{kind}");
    all
}

/// The pow3 curve of an instance.
fn curve(instance: &Value) -> Curve {
    let of = |name: &str| number(&instance["curve"][name]);
    let parameters =
        Parameters { alpha: of("alpha"), beta: of("beta"), gamma: Some(of("gamma")), epsilon: None };
    Curve { model: "pow3".into(), parameters, rmse: 0.0 }
}

fn weights(instance: &Value) -> (f64, f64) {
    (number(&instance["weights"][0]), number(&instance["weights"][1]))
}

#[test]
fn water_filling_is_the_convex_solvers() {
    let golden = golden();
    for instance in instances(&golden, "water_filling") {
        let found = allocate(&numbers(&instance["gamma"]));
        let expected = number(&instance["rate"]);
        assert!((found.rate_bit / expected - 1.0).abs() < 1e-9, "{} {expected}", found.rate_bit);
        assert!((found.shares.iter().sum::<f64>() - 1.0).abs() < 1e-9);
    }
}

#[test]
fn the_weighted_sum_is_the_convex_solvers() {
    let golden = golden();
    for instance in instances(&golden, "weighted") {
        let bits = numbers(&instance["bits"]);
        let theorem = Theorem::new(number(&instance["period"]) as u32, &bits);
        let linear = &instance["linear"];
        let expected = number(&linear["throughput"]);
        assert!((theorem.throughput_bit(number(&linear["n"])) / expected - 1.0).abs() < 1e-9);
        // whole slots on the boundary of real numbers: at most as good, and next to it
        let [from, to] = [0, 1].map(|end| number(&instance["range"][end]) as u32);
        let on_boundary = |sensing_slots: u32| Point {
            throughput_bit: theorem.throughput_bit(f64::from(sensing_slots)),
            ..point(number(&instance["period"]) as u32, &curve(instance), &bits, sensing_slots)
        };
        let points: Vec<Point> = (from..=to).map(on_boundary).collect();
        let (a, r) = weights(instance);
        let chosen = &points[choose(&points, Rule::Weights(a, r)).expect("a point")];
        let value = (a * chosen.accuracy + r * chosen.throughput_bit) / number(&instance["value"]);
        assert!((1.0 - 1e-4..1.0 + 1e-9).contains(&value), "{value} {chosen:?} {instance}");
    }
}

#[test]
fn whole_slots_are_the_optimum_found_by_trying_all() {
    let golden = golden();
    for instance in instances(&golden, "integer") {
        let period = number(&instance["period"]) as u32;
        let (bits, curve) = (numbers(&instance["bits"]), curve(instance));
        let throughput = instance["throughput"].as_object().expect("throughputs");
        let mut points = Vec::new();
        for (n, best) in throughput {
            let p = point(period, &curve, &bits, n.parse().expect("N_s"));
            assert_eq!(p.shares.iter().sum::<u32>() + p.sensing_slots, period);
            assert!(
                (p.throughput_bit - number(best)).abs() <= 1e-12 * number(best),
                "{p:?} {best} {instance}"
            );
            points.push(p);
        }
        points.sort_by_key(|p| p.sensing_slots);
        let (least, most) = (points[0].sensing_slots, points[points.len() - 1].sensing_slots);
        assert_eq!(least, number(&instance["window"]) as u32);
        assert_eq!(most, period / (number(&instance["spacing"]) as u32 + 1));
        let (a, r) = weights(instance);
        let chosen = &points[choose(&points, Rule::Weights(a, r)).expect("a point")];
        let value = a * chosen.accuracy + r * chosen.throughput_bit;
        assert!((value / number(&instance["value"]) - 1.0).abs() < 1e-12, "{chosen:?} {instance}");
    }
}

#[test]
fn case_two_contains_case_one_at_every_number_of_slots() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = |name: &str| folder.path().join(name).to_string_lossy().into_owned();
    let points = "sensing_slots,accuracy,tested\n200,0.7885,500\n300,0.9016,500\n400,0.9142,500\n500,0.9309,500\n\
                  600,0.9292,500\n1000,0.9554,500\n";
    std::fs::write(file("p.csv"), points).expect("points");
    let optimize = |rule: &[&str]| {
        // without a largest modulation, which both placements reach
        let fixed = [
            "optimize",
            "--json",
            "--scenario",
            "as-printed",
            "--points",
            &file("p.csv"),
            "--out",
            &file("out"),
        ];
        let fixed = fixed.map(String::from);
        let arguments: Vec<&str> = fixed.iter().map(String::as_str).chain(rule.iter().copied()).collect();
        let (code, stdout, stderr) = outcome(&call(&program(), &arguments));
        assert_eq!(code, 0, "{stderr}");
        serde_json::from_str::<Value>(&stdout).expect("JSON")
    };
    let found = optimize(&["--accuracy", "0.93"]);
    let boundary = std::fs::read_to_string(file("out/boundary.csv")).expect("the boundary");
    let rows: Vec<Vec<&str>> = boundary.lines().skip(1).map(|line| line.split(',').collect()).collect();
    let of = |case: &str| rows.iter().filter(|r| r[0] == case).cloned().collect::<Vec<_>>();
    let (one, two) = (of("1"), of("2"));
    // 152 sensing slots, the fewest that an image takes, to 1000
    assert_eq!((one.len(), two.len()), (849, 849));
    for (one, two) in one.iter().zip(&two) {
        let bit = |row: &Vec<&str>| row[3].parse::<f64>().expect("bits");
        assert_eq!(one[1], two[1]);
        assert!(bit(two) > bit(one), "N_s = {}", one[1]);
    }
    // the fewest slots that reach it
    let point = &found["operating_point"];
    let at = |n: u64| one.iter().find(|r| r[1] == n.to_string()).map(|r| r[2].parse::<f64>().expect("A"));
    let n = point["sensing_slots"].as_u64().expect("N_s");
    assert!(at(n).is_some_and(|a| a >= 0.93) && at(n - 1).is_some_and(|a| a < 0.93));
    assert_eq!(found["cases"].as_array().map(Vec::len), Some(2));
    assert_eq!(found["cases"][0]["borders"].as_array().map(Vec::len), Some(2));
    // points of one N_m leave no other to compare it with
    assert!(found.get("spacings").is_none());
    // throughput asked for is throughput got, and one slot more of sensing would not do
    let asked = number(&point["throughput_bit"]);
    let again = optimize(&["--throughput", &asked.to_string()]);
    assert!(again["operating_point"]["sensing_slots"].as_u64() >= Some(n));
    assert!(number(&again["operating_point"]["throughput_bit"]) >= asked);
}

#[test]
fn the_spacing_of_the_most_throughput_is_chosen_and_its_boundary_written() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = |name: &str| folder.path().join(name).to_string_lossy().into_owned();
    let points = "spacing_slots,sensing_slots,accuracy,tested\n3,200,0.80,500\n3,300,0.86,500\n3,400,0.92,500\n3,600,0.96,500\n\
                  3,1000,0.98,500\n12,160,0.93,500\n12,200,0.96,500\n12,250,0.98,500\n12,300,0.99,500\n";
    std::fs::write(file("p.csv"), points).expect("points");
    let (points, out) = (file("p.csv"), file("out"));
    let optimize = |rest: &[&str]| {
        let fixed = ["optimize", "--json", "--points", &points, "--out", &out];
        outcome(&call(&program(), &[&fixed[..], rest].concat()))
    };
    let of = |rest: &[&str]| {
        let (code, stdout, stderr) = optimize(rest);
        assert_eq!(code, 0, "{stderr}");
        serde_json::from_str::<Value>(&stdout).expect("JSON")
    };
    let found = of(&["--accuracy", "0.95"]);
    let point = &found["operating_point"];
    assert_eq!(point["spacing_slots"], 12);
    let [three, twelve] = [0, 1].map(|at| &found["spacings"][at]);
    assert_eq!((&three["spacing_slots"], &twelve["spacing_slots"]), (&3.into(), &12.into()));
    for field in ["sensing_slots", "accuracy", "throughput_bit"] {
        assert_eq!(twelve[field], point[field], "{field}");
    }
    assert!(number(&three["throughput_bit"]) < number(&point["throughput_bit"]));
    // the boundary is that of the chosen N_m: 152 to 4000 / 13 = 307 slots
    let boundary = std::fs::read_to_string(file("out/boundary.csv")).expect("the boundary");
    let case_one = boundary.lines().filter(|line| line.starts_with("1,"));
    assert_eq!(case_one.count(), 307 - 152 + 1);
    // the scenario beside it is legal, and goes on
    let scenario = file("out/optimize-scenario.toml");
    assert_eq!(&of(&["--accuracy", "0.95", "--scenario", &scenario])["operating_point"], point);
    // N_m = 3 alone gives the row that it has among several
    let text = std::fs::read_to_string(&points).expect("points");
    let alone: Vec<&str> = text.lines().filter(|line| !line.starts_with("12,")).collect();
    std::fs::write(&points, alone.join("\n")).expect("points");
    let again = of(&["--accuracy", "0.95"]);
    for field in ["sensing_slots", "accuracy", "throughput_bit"] {
        assert_eq!(three[field], again["operating_point"][field], "{field}");
    }
    assert!(again.get("spacings").is_none());
    // a sweep of links is of one N_m, and so is a learning curve
    std::fs::write(&points, text).expect("points");
    let (code, _, stderr) = optimize(&["--sweep", "users=1,3"]);
    assert!(code == 2 && stderr.contains("--sweep takes points of one N_m"), "{stderr}");
    let (code, _, stderr) = outcome(&call(&program(), &["predict", "--points", &points, "--out", &out]));
    assert!(code == 2 && stderr.contains("spacing_slots is 3, 12, must be one N_m"), "{stderr}");
}
