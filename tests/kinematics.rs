//! The gait and its cross sections against scipy's: a program of its own, written from the published model.
//!
//! The vectors and the Python program that made them lie in `tests/oracles`.

use sdp3::simulator::body::gait::{Gait, JOINTS};
use sdp3::simulator::body::primitives::{PRIMITIVES, primitives};
use sdp3::simulator::body::{Vec3, norm, sub};
use serde_json::Value;

fn golden() -> Value {
    serde_json::from_str(include_str!("oracles/kinematics.json")).expect("JSON")
}

fn list(value: &Value) -> &Vec<Value> {
    value.as_array().expect("a list")
}

fn number(value: &Value) -> f64 {
    value.as_f64().expect("a number")
}

fn vector(value: &Value) -> Vec3 {
    assert_eq!(list(value).len(), 3);
    std::array::from_fn(|axis| number(&value[axis]))
}

/// Fourth-order derivative by the phase.
fn derivative(curve: impl Fn(f64) -> Vec3, phase: f64) -> Vec3 {
    let step = 1e-4;
    let at = |k: f64| curve(phase + k * step);
    let (a, b, c, d) = (at(-2.0), at(-1.0), at(1.0), at(2.0));
    std::array::from_fn(|axis| (a[axis] - 8.0 * b[axis] + 8.0 * c[axis] - d[axis]) / (12.0 * step))
}

#[test]
fn joints_and_translations_are_scipys() {
    let golden = golden();
    let (mut joints, mut translations) = (0, 0);
    for case in list(&golden["cases"]) {
        let (rv, height) = (number(&case["rv"]), number(&case["height"]));
        let gait = Gait::new(height, rv);
        for (k, phase) in list(&golden["phases"]).iter().map(number).enumerate() {
            let pose = gait.pose(phase);
            assert_eq!(list(&case["joints"][k]).len(), JOINTS);
            for (j, expected) in list(&case["joints"][k]).iter().enumerate() {
                // the vectors are rounded to 1e-9 m in each coordinate
                let error = norm(sub(pose[j], vector(expected)));
                assert!(error < 1e-9, "RV {rv} height {height} phase {phase} joint {j}: {error}");
                joints += 1;
            }
            if let Some(expected) = case.get("translation") {
                let error = norm(sub(gait.translation(phase), vector(&expected[k])));
                assert!(error < 1e-9, "RV {rv} phase {phase}: {error}");
                translations += 1;
            }
        }
    }
    assert!(joints >= 4_000 && translations >= 120, "{joints} {translations}");
}

#[test]
fn velocities_are_scipys() {
    let golden = golden();
    let mut compared = 0;
    for case in list(&golden["cases"]) {
        let Some(velocities) = case.get("velocities") else { continue };
        let (rv, height) = (number(&case["rv"]), number(&case["height"]));
        let gait = Gait::new(height, rv);
        for (k, phase) in list(&golden["phases"]).iter().map(number).enumerate() {
            for (j, expected) in list(&velocities[k]).iter().enumerate() {
                let error = norm(sub(derivative(|t| gait.pose(t)[j], phase), vector(expected)));
                assert!(error < 1e-6, "RV {rv} phase {phase} joint {j}: {error}");
                compared += 1;
            }
            let found = derivative(|t| gait.translation(t), phase);
            let error = norm(sub(found, vector(&case["translation_velocity"][k])));
            assert!(error < 1e-6, "RV {rv} phase {phase}: {error}");
        }
    }
    assert!(compared >= 2_000, "{compared}");
}

#[test]
fn cross_sections_are_numpys() {
    let golden = golden();
    let radar = vector(&golden["radar"]);
    for case in list(&golden["cases"]) {
        let (rv, height) = (number(&case["rv"]), number(&case["height"]));
        let gait = Gait::new(height, rv);
        for (k, phase) in list(&golden["phases"]).iter().map(number).enumerate() {
            let found =
                primitives(&gait.pose(phase), gait.segments(), height).map(|p| p.cross_section(radar));
            assert_eq!(list(&case["cross_sections"][k]).len(), PRIMITIVES);
            for (b, expected) in list(&case["cross_sections"][k]).iter().map(number).enumerate() {
                let error = (found[b] / expected - 1.0).abs();
                assert!(error < 1e-9, "RV {rv} height {height} phase {phase} primitive {b}: {error}");
            }
        }
    }
}
