//! Motion recorded elsewhere: the seventeen joints of [`super::gait`] over time, from a CSV or BVH file.
//!
//! Metres and seconds; x and y span the ground, z is up. Between the frames a spline carries position and velocity.

pub(crate) mod bvh;
pub(crate) mod csv;
mod skeleton;
mod spline;

use super::gait::{JOINTS, Segments, joint};
use super::{Vec3, norm, sub};
use crate::error::Invalid;
use spline::Spline;
use std::collections::BTreeMap;
use std::fmt::Display;
use std::fs::File;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};

/// Names of the joints, in the order of [`super::gait`].
pub const JOINT_NAMES: [&str; JOINTS] = [
    "base",
    "neck",
    "head",
    "left_shoulder",
    "right_shoulder",
    "left_elbow",
    "right_elbow",
    "left_hand",
    "right_hand",
    "left_hip",
    "right_hip",
    "left_knee",
    "right_knee",
    "left_ankle",
    "right_ankle",
    "left_toe",
    "right_toe",
];

/// Fewest and most frames of a motion.
pub const FRAMES: [usize; 2] = [4, 1_000_000];
/// Largest magnitude of a coordinate in m.
pub const COORDINATE_M: f64 = 1e3;
/// Shortest and longest time between frames in s.
pub const STEP_S: [f64; 2] = [1e-6, 1e3];
/// Shortest and longest limb in m; in centimetres or millimetres a body is beyond it.
pub const LIMB_M: [f64; 2] = [0.01, 2.0];
/// Largest file in bytes.
pub const FILE_BYTES: u64 = 1 << 30;

/// The limbs the ellipsoids stand on; a right one ends one joint further.
const MIDDLE: [(usize, usize); 2] = [(joint::BASE, joint::NECK), (joint::NECK, joint::HEAD)];
const LEFT: [(usize, usize); 7] = [
    (joint::NECK, joint::SHOULDER),
    (joint::SHOULDER, joint::ELBOW),
    (joint::ELBOW, joint::HAND),
    (joint::BASE, joint::HIP),
    (joint::HIP, joint::KNEE),
    (joint::KNEE, joint::ANKLE),
    (joint::ANKLE, joint::TOE),
];

/// Times in s and the joints at each.
type Motion = (Vec<f64>, Vec<[Vec3; JOINTS]>);

/// Why a motion cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum CaptureError {
    /// The file cannot be read.
    #[error("{file}: {source}")]
    Read {
        /// The file.
        file: PathBuf,
        /// What the system says.
        source: std::io::Error,
    },
    /// A field that may not be what it is.
    #[error(transparent)]
    Invalid(#[from] Invalid),
}

impl CaptureError {
    fn in_file(self, file: &Path) -> Self {
        match self {
            CaptureError::Invalid(invalid) => invalid.at(file.display()).into(),
            read => read,
        }
    }
}

/// A refusal; of a long value the beginning.
fn refuse(at: impl Display, field: impl Display, value: impl Display, legal: impl Display) -> CaptureError {
    let value: String = value.to_string().chars().take(60).collect();
    let absent = matches!(value.as_str(), "missing" | "end of the file");
    let value = if absent { value } else { format!("{value:?}") };
    Invalid::new(field, value, legal).at(at).into()
}

/// A recorded motion.
#[derive(Debug, Clone)]
pub struct Capture {
    spline: Spline,
    segments: Segments,
    unit_m: f64,
}

impl Capture {
    /// Joints in m at `times` in s, which are shifted to begin at 0.
    ///
    /// # Errors
    ///
    /// Fewer or more frames than [`FRAMES`], as many times as frames not given, a step outside [`STEP_S`], a coordinate
    /// that is not finite or beyond [`COORDINATE_M`], a limb outside [`LIMB_M`].
    pub fn new(times: Vec<f64>, joints: Vec<[Vec3; JOINTS]>) -> Result<Self, CaptureError> {
        let [fewest, most] = FRAMES;
        if !(fewest..=most).contains(&times.len()) {
            return Err(refuse("motion", "frames", times.len(), format!("{fewest} to {most}")));
        }
        if joints.len() != times.len() {
            return Err(refuse(
                "motion",
                "frames",
                joints.len(),
                format!("{}, one for each time", times.len()),
            ));
        }
        let start = times[0];
        let shifted: Vec<f64> = times.iter().map(|t| t - start).collect();
        for (index, pair) in shifted.windows(2).enumerate() {
            let step = pair[1] - pair[0];
            if !(STEP_S[0]..=STEP_S[1]).contains(&step) {
                let legal = format!("{} to {} s after the frame before", STEP_S[0], STEP_S[1]);
                return Err(refuse(format!("frame {}", index + 2), "time", times[index + 1], legal));
            }
        }
        for (index, frame) in joints.iter().enumerate() {
            check(frame).map_err(|(field, value, legal)| {
                refuse(format!("frame {}", index + 1), field, value, legal)
            })?;
        }
        let segments = median_segments(&joints);
        Ok(Capture { spline: Spline::new(shifted, joints), segments, unit_m: 1.0 })
    }

    /// Reads a `.csv` ([`csv`]) or `.bvh` ([`bvh`]) file.
    ///
    /// # Errors
    ///
    /// [`CaptureError`] names file, line or frame, field, value and legal range.
    pub fn read(file: &Path) -> Result<Self, CaptureError> {
        let extension = file.extension().and_then(|e| e.to_str()).unwrap_or("").to_ascii_lowercase();
        match extension.as_str() {
            "csv" => csv::read(file),
            "bvh" => bvh::read(file, None),
            other => Err(refuse(file.display(), "extension", other, "csv or bvh")),
        }
    }

    /// The same, read once per process however many recordings use it.
    ///
    /// # Errors
    ///
    /// Those of [`Capture::read`].
    pub fn shared(file: &Path) -> Result<Arc<Self>, CaptureError> {
        static READ: Mutex<BTreeMap<PathBuf, Arc<Capture>>> = Mutex::new(BTreeMap::new());
        let mut read = READ.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(capture) = read.get(file) {
            return Ok(capture.clone());
        }
        let capture = Arc::new(Self::read(file)?);
        read.insert(file.to_owned(), capture.clone());
        Ok(capture)
    }

    /// Duration in s.
    pub fn duration_s(&self) -> f64 {
        self.spline.end()
    }

    /// Frames.
    pub fn frames(&self) -> usize {
        self.spline.frames()
    }

    /// Height of the person in m, estimated from [`Self::segments`], thus in any posture: shank, thigh, torso and head
    /// over their share of the height in [`Segments::of_height`].
    pub fn height_m(&self) -> f64 {
        height(&self.segments)
    }

    /// Segment lengths: the medians over the frames and both sides.
    pub fn segments(&self) -> Segments {
        self.segments
    }

    /// Metres in the file's unit of length, 1 for a CSV.
    pub fn unit_m(&self) -> f64 {
        self.unit_m
    }

    /// Positions in m and velocities in m/s of the joints at `t` seconds: a natural cubic spline and its derivative.
    /// Before the start and after the end the joints rest where the motion starts and ends.
    pub fn at(&self, t: f64) -> ([Vec3; JOINTS], [Vec3; JOINTS]) {
        let inside = t.clamp(0.0, self.duration_s());
        let (positions, velocities) = self.spline.at(inside);
        (positions, if inside == t { velocities } else { [[0.0; 3]; JOINTS] })
    }
}

/// Field, value and legal range of what is wrong with a frame.
fn check(frame: &[Vec3; JOINTS]) -> Result<(), (String, f64, String)> {
    for (j, position) in frame.iter().enumerate() {
        for (axis, &value) in ["x", "y", "z"].into_iter().zip(position) {
            if !(-COORDINATE_M..=COORDINATE_M).contains(&value) {
                return Err((format!("{} {axis}", JOINT_NAMES[j]), value, coordinate_range()));
            }
        }
    }
    let sides =
        (0..2).flat_map(|side| LEFT.map(|(a, b)| (if a > joint::HEAD { a + side } else { a }, b + side)));
    for (a, b) in MIDDLE.into_iter().chain(sides) {
        let length = norm(sub(frame[a], frame[b]));
        if !(LIMB_M[0]..=LIMB_M[1]).contains(&length) {
            let field = format!("limb {}-{}", JOINT_NAMES[a], JOINT_NAMES[b]);
            return Err((field, length, format!("{} to {} m", LIMB_M[0], LIMB_M[1])));
        }
    }
    Ok(())
}

fn coordinate_range() -> String {
    format!("a number of metres in -{COORDINATE_M} to {COORDINATE_M}")
}

fn height(s: &Segments) -> f64 {
    let one = Segments::of_height(1.0);
    (s.leg() + s.torso + s.head) / (one.leg() + one.torso + one.head)
}

/// Median lengths; no frames make them all NaN.
fn median_segments(frames: &[[Vec3; JOINTS]]) -> Segments {
    let median = |pairs: &[(usize, usize)]| {
        let length = |(a, b): (usize, usize)| frames.iter().map(move |f| norm(sub(f[a], f[b])));
        let mut all: Vec<f64> = pairs.iter().flat_map(|&pair| length(pair)).collect();
        let middle = all.len() / 2;
        if all.is_empty() { f64::NAN } else { *all.select_nth_unstable_by(middle, f64::total_cmp).1 }
    };
    let limb = |a: usize, b: usize| median(&[(a, b), (a + 1, b + 1)]);
    use joint::*;
    Segments {
        head: median(&[(NECK, HEAD)]),
        half_shoulder: median(&[(SHOULDER, SHOULDER + 1)]) / 2.0,
        torso: median(&[(BASE, NECK)]),
        half_hip: median(&[(HIP, HIP + 1)]) / 2.0,
        thigh: limb(HIP, KNEE),
        shank: limb(KNEE, ANKLE),
        foot: limb(ANKLE, TOE),
        upper_arm: limb(SHOULDER, ELBOW),
        lower_arm: limb(ELBOW, HAND),
    }
}

/// Opens a regular file of at most [`FILE_BYTES`].
fn open(file: &Path) -> Result<File, CaptureError> {
    let read = |source| CaptureError::Read { file: file.to_owned(), source };
    let about = std::fs::metadata(file).map_err(read)?;
    if !about.is_file() {
        return Err(refuse(file.display(), "kind", "no regular file", "a regular file"));
    }
    if about.len() > FILE_BYTES {
        return Err(refuse(file.display(), "bytes", about.len(), format!("at most {FILE_BYTES}")));
    }
    File::open(file).map_err(read)
}

#[cfg(test)]
mod tests {
    use super::super::gait::Gait;
    use super::*;

    /// Frames of a walk, `hz` a second for `n` frames.
    fn walk(hz: f64, n: usize) -> Motion {
        let gait = Gait::new(1.75, 1.0);
        let times: Vec<f64> = (0..n).map(|k| k as f64 / hz).collect();
        let joints = times.iter().map(|t| gait.pose(t / gait.cycle_s())).collect();
        (times, joints)
    }

    fn message(result: Result<Capture, CaptureError>) -> String {
        result.map(|_| ()).unwrap_err().to_string()
    }

    #[test]
    fn a_walk_keeps_its_segments_and_height_and_starts_at_zero() {
        let (times, joints) = walk(100.0, 200);
        let capture = Capture::new(times.iter().map(|t| t + 5e8).collect(), joints.clone()).unwrap();
        assert!((capture.duration_s() - 1.99).abs() < 1e-6 && capture.frames() == 200);
        assert!((capture.height_m() - 1.75).abs() < 1e-9);
        let (found, true_) = (capture.segments(), Segments::of_height(1.75));
        assert!((found.foot - true_.foot).abs() < 1e-9 && (found.half_hip - true_.half_hip).abs() < 1e-9);
        let (before, still) = capture.at(-1.0);
        assert_eq!((before, still), (joints[0], [[0.0; 3]; JOINTS]));
        let (after, still) = capture.at(9.0);
        assert!(norm(sub(after[joint::TOE], joints[199][joint::TOE])) < 1e-12 && still[3] == [0.0; 3]);
        assert!(norm(capture.at(capture.duration_s()).1[joint::TOE]) > 0.01);
    }

    #[test]
    fn what_is_no_motion_is_refused_by_name() {
        let (times, joints) = walk(100.0, 10);
        let with = |change: &dyn Fn(&mut Motion)| {
            let mut motion = (times.clone(), joints.clone());
            change(&mut motion);
            message(Capture::new(motion.0, motion.1))
        };
        for (found, parts) in [
            (with(&|(t, j)| (t.truncate(3), j.truncate(3)).0), ["motion: frames is \"3\"", "4 to 1000000"]),
            (with(&|(t, _)| t.resize(1_000_001, 0.0)), ["frames is \"1000001\"", "4 to 1000000"]),
            (with(&|(t, _)| t.truncate(9)), ["frames is \"10\"", "9, one for each time"]),
            (with(&|(t, _)| t[4] = t[3]), ["frame 5: time is \"0.03\"", "after the frame before"]),
            (with(&|(t, _)| t[4] = f64::NAN), ["frame 5: time is \"NaN\"", "after the frame before"]),
            (with(&|(t, _)| t[9] = f64::INFINITY), ["frame 10: time is \"inf\"", "after the frame before"]),
            (
                with(&|(_, j)| j[1][joint::TOE + 1][1] = f64::NAN),
                ["frame 2: right_toe y is \"NaN\"", "-1000 to 1000"],
            ),
            (
                with(&|(_, j)| j[1][joint::HEAD][2] = 1000.1),
                ["frame 2: head z is \"1000.1\"", "-1000 to 1000"],
            ),
            (
                with(&|(_, j)| j[2][joint::ELBOW + 1] = j[2][joint::SHOULDER + 1]),
                ["frame 3: limb right_shoulder-right_elbow is \"0\"", "0.01 to 2 m"],
            ),
            (
                with(&|(_, j)| j.iter_mut().for_each(|f| *f = f.map(|p| super::super::scale(p, 100.0)))),
                ["frame 1: limb base-neck is \"50.", "0.01 to 2 m"],
            ),
        ] {
            assert!(parts.iter().all(|part| found.contains(part)), "{found}");
        }
        let (found, folder) = (message(Capture::read(Path::new("walk.FBX"))), std::env::temp_dir());
        assert_eq!(found, "walk.FBX: extension is \"fbx\", must be csv or bvh");
        assert!(message(Capture::read(&folder.join("sdp3-no-such.csv"))).contains("sdp3-no-such.csv: "));
    }

    #[test]
    fn a_folder_is_no_file() {
        let folder = tempfile::tempdir().unwrap();
        let named = folder.path().join("walk.csv");
        std::fs::create_dir(&named).unwrap();
        assert!(message(Capture::read(&named)).ends_with("a regular file"));
    }
}
