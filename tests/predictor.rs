//! Learning curves against scipy on 200 random sets of points, and the paper's Table III through the command line.
//!
//! The vectors and the program that made them lie in `tests/oracles`.

use sdp3::predictor::fit::{fit, sse};
use sdp3::predictor::{Model, paper};
use sdp3::results::{CurvePoint, Prediction};
use sdp3_tests::{call, outcome, program};
use serde_json::Value;

#[test]
fn no_fit_is_worse_than_scipys() {
    let vectors: Value = serde_json::from_str(include_str!("oracles/learning_curves.json")).expect("JSON");
    let numbers = |value: &Value| -> Vec<f64> {
        value.as_array().expect("a list").iter().map(|v| v.as_f64().expect("a number")).collect()
    };
    let curves = vectors["curves"].as_array().expect("curves");
    assert_eq!(curves.len(), 200);
    let (mut better, mut worst) = (0, ("", 0.0_f64));
    for curve in curves {
        let points: Vec<CurvePoint> = numbers(&curve["sensing_slots"])
            .into_iter()
            .zip(numbers(&curve["accuracy"]))
            .map(|(sensing_slots, accuracy)| CurvePoint { sensing_slots, accuracy, tested: None, std: None })
            .collect();
        for model in Model::ALL {
            let (parameters, error) = fit(model, &points);
            let own = sse(model, &parameters, &points);
            assert!((own - error).abs() <= 1e-6 * error + 1e-12, "{}: {own} {error}", model.name());
            let scipy = curve["sse"][model.name()].as_f64().expect("an error");
            assert!(error <= 1.001 * scipy + 1e-12, "{}: {error} against {scipy}: {points:?}", model.name());
            better += u32::from(error < 0.999 * scipy);
            if error / scipy > worst.1 {
                worst = (model.name(), error / scipy);
            }
        }
    }
    println!(
        "1400 fits: {better} better than scipy's by 0.1 % or more; worst ratio {:.6} ({})",
        worst.1, worst.0
    );
}

#[test]
fn table_iii_comes_out_of_the_command() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("points.csv");
    let rows: String = paper::POINTS.iter().map(|(n, a)| format!("{n},{a}\n")).collect();
    std::fs::write(&file, format!("sensing_slots,accuracy\n{rows}")).expect("points");
    let out = folder.path().join("out");
    let [file, out] = [&file, &out].map(|path| path.to_str().expect("a path"));
    let arguments = ["predict", "--json", "--points", file, "--out", out];
    let (code, stdout, stderr) = outcome(&call(&program(), &arguments));
    assert_eq!(code, 0, "{stderr}");
    let value: Value = serde_json::from_str(&stdout).expect("JSON");
    assert_eq!(value["best"], "pow3");
    for model in value["models"].as_array().expect("models") {
        for field in ["name", "parameters", "sse", "rmse", "aicc", "loo"] {
            assert!(model.get(field).is_some(), "{field} of {model}");
        }
    }
    let prediction: Prediction = serde_json::from_str(&stdout).expect("a prediction");
    for row in paper::TABLE_III {
        let m = prediction.models.iter().find(|m| m.name == row.model.name()).expect("every model");
        // what the printed parameters give; pow4's give something else than what is printed beside them
        let given = sse(row.model, &row.model.parameters(row.parameters), &prediction.points);
        let agrees = (given / row.sse - 1.0).abs() < 0.01;
        assert_eq!(agrees, row.consistent, "{}: {given} {}", m.name, row.sse);
        assert!(m.sse <= given && m.sse <= row.sse * 1.01, "{}: {} {given}", m.name, m.sse);
    }
    let place = |list: &[String], name: &str| list.iter().position(|n| n == name);
    assert_eq!(place(&prediction.ranking.sse, "pow4"), Some(0));
    assert_eq!(place(&prediction.ranking.cp, "pow3"), Some(0));
    let band = prediction.band.expect("a band");
    assert!(band.points.iter().all(|p| p.low <= p.high));
}
