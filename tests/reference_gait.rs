//! The gait against NIST's reference. Its files are not part of the product: `tests/measured FOLDER` builds this test and names their folder.

use sdp3::simulator::body::gait::{Gait, JOINTS};
use sdp3::simulator::body::{Vec3, norm, sub};

/// Rows of comma-separated numbers.
fn table(folder: &std::path::Path, name: &str) -> Vec<Vec<f64>> {
    let file = folder.join(name);
    let text = std::fs::read_to_string(&file).unwrap_or_else(|e| panic!("{}: {e}", file.display()));
    let row = |line: &str| line.split(',').map(|v| v.parse().expect("a number")).collect();
    text.lines().map(row).collect()
}

/// NIST's target of its Q-D channel realization software: RV = 2, height 1.8 m, one cycle in 2680 steps. Its elbows are
/// wrong (limbs change their length) and its hands follow a misprinted control point; see the simulator's `gait`.
#[test]
fn the_reference_gait_within_a_quarter_millimetre() {
    let folder = std::env::var_os("SDP3_REFERENCE_GAIT").expect("SDP3_REFERENCE_GAIT names the folder");
    let folder = std::path::Path::new(&folder);
    let (bases, joints) = (table(folder, "TargetBase0.dat"), table(folder, "TargetJoints0.dat"));
    assert_eq!((bases.len(), joints.len()), (2680, 2680));
    let gait = Gait::new(1.8, 2.0);
    let base = |n: usize| -> Vec3 { std::array::from_fn(|axis| bases[n][axis]) };
    let way = sub(base(2679), base(0));
    let (sin, cos) = way[1].atan2(way[0]).sin_cos();
    let turned = |v: Vec3| [cos * v[0] + sin * v[1], cos * v[1] - sin * v[0], v[2]];
    let (mut worst, mut worst_way) = (0.0_f64, 0.0_f64);
    for n in 0..2680 {
        let phase = n as f64 / 2680.0;
        let pose = gait.pose(phase);
        for joint in (1..JOINTS).filter(|joint| !(5..=8).contains(joint)) {
            let at = 3 * (joint - 1);
            let found = turned(sub([joints[n][at], joints[n][at + 1], joints[n][at + 2]], base(n)));
            worst = worst.max(norm(sub(found, pose[joint])));
        }
        // the pelvis: its translation in m, as public code has it, and 1.346 m of way a cycle
        let shift = |t: f64| gait.translation(t);
        let mut expected = sub(shift(phase), shift(0.0));
        expected[0] += 1.346 * phase;
        worst_way = worst_way.max(norm(sub(turned(sub(base(n), base(0))), expected)));
    }
    println!("reference gait: joints within {:.4} mm, pelvis within {:.4} mm", worst * 1e3, worst_way * 1e3);
    assert!(worst < 0.25e-3, "{worst}");
    assert!(worst_way < 0.25e-3, "{worst_way}");
}
