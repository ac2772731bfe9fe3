//! A motion as Biovision BVH: a skeleton of named bones, then the numbers of its channels for each frame.
//!
//! The channels of a bone act in their order, each in the axes the ones before have turned; a position channel replaces
//! the bone's OFFSET along its axis, as in what writes and reads such files today. BVH has y up and a person at rest
//! facing z with the left hand along x: (x, y, z) there is (z, x, y) here, a rotation, so that the person faces x.
//! BVH has no unit: see [`UNITS_M`]. Loops, not recursion, read the tree; nothing is allocated for what a count claims.

use super::super::Vec3;
use super::super::gait::JOINTS;
use super::skeleton::{self, Bone};
use super::{Capture, CaptureError, FILE_BYTES, FRAMES, Motion, STEP_S, open, refuse};
use super::{height, median_segments};
use std::f64::consts::PI;
use std::io::Read;
use std::path::Path;
use std::str::{Lines, SplitWhitespace};

/// Units in m a file may be in: metres, centimetres, inches, and CMU's and ACCAD's 1/0.45 inches. Where none is given it
/// is the one that makes the person of the first frame, with its height from its limbs, nearest to [`HEIGHT_M`].
pub const UNITS_M: [f64; 4] = [1.0, 0.01, 0.0254, 0.0254 / 0.45];
/// Height in m of the person whom an unknown unit is guessed by.
pub const HEIGHT_M: f64 = 1.7;
/// Deepest nesting of bones.
pub const DEPTH: usize = 64;
/// Most bones, end sites among them.
pub const BONES: usize = 512;

/// Reads a motion in a unit of length in m, or in the likeliest of [`UNITS_M`].
///
/// # Errors
///
/// [`CaptureError`] names file, line or frame, field, value and legal range.
pub fn read(file: &Path, unit_m: Option<f64>) -> Result<Capture, CaptureError> {
    let mut text = String::new();
    let read = open(file)?.take(FILE_BYTES).read_to_string(&mut text);
    read.map_err(|source| CaptureError::Read { file: file.to_owned(), source })?;
    parse(&text, unit_m).map_err(|why| why.in_file(file))
}

/// The motion in the text of a file; see [`read`].
///
/// # Errors
///
/// [`CaptureError`] names line or frame, field, value and legal range.
pub fn parse(text: &str, unit_m: Option<f64>) -> Result<Capture, CaptureError> {
    if let Some(unit) = unit_m.filter(|unit| !(1e-6..=1e3).contains(unit)) {
        return Err(refuse("reader", "unit_m", unit, "0.000001 to 1000"));
    }
    let mut words = Words::new(text);
    let (bones, moves) = hierarchy(&mut words)?;
    let found = skeleton::find(&bones)?;
    let (times, mut frames) = motion(&mut words, &bones, &moves, &found)?;
    let unit_m = unit_m.unwrap_or_else(|| {
        let high = height(&median_segments(&frames[..1]));
        let off = |unit: &f64| (high * unit - HEIGHT_M).abs();
        UNITS_M.into_iter().min_by(|a, b| off(a).total_cmp(&off(b))).unwrap_or(1.0)
    });
    frames.iter_mut().flatten().flatten().for_each(|value| *value *= unit_m);
    let capture = Capture::new(times, frames)?;
    Ok(Capture { unit_m, ..capture })
}

/// What a number of a frame does: moves along or turns about an axis.
#[derive(Debug, Clone, Copy)]
enum Channel {
    Move(usize),
    Turn(usize),
}

const CHANNELS: [(&str, Channel); 6] = [
    ("Xposition", Channel::Move(0)),
    ("Yposition", Channel::Move(1)),
    ("Zposition", Channel::Move(2)),
    ("Xrotation", Channel::Turn(0)),
    ("Yrotation", Channel::Turn(1)),
    ("Zrotation", Channel::Turn(2)),
];

/// How a bone stands on its parent.
#[derive(Debug, Clone, Default)]
struct Placing {
    offset: Option<Vec3>,
    channels: Option<Vec<Channel>>,
}

/// The words of a text and the line of the one read last.
struct Words<'a> {
    lines: Lines<'a>,
    words: SplitWhitespace<'a>,
    line: usize,
}

impl<'a> Words<'a> {
    fn new(text: &'a str) -> Self {
        let lines = text.trim_start_matches('\u{feff}').lines();
        Words { lines, words: "".split_whitespace(), line: 0 }
    }

    fn next(&mut self) -> Option<&'a str> {
        loop {
            if let Some(word) = self.words.next() {
                return Some(word);
            }
            self.words = self.lines.next()?.split_whitespace();
            self.line += 1;
        }
    }

    fn refuse(&self, field: &str, value: &str, legal: &str) -> CaptureError {
        refuse(format!("line {}", self.line), field, value, legal)
    }

    fn some(&mut self, field: &str, legal: &str) -> Result<&'a str, CaptureError> {
        self.next().ok_or_else(|| self.refuse(field, "end of the file", legal))
    }

    fn expect(&mut self, word: &str) -> Result<(), CaptureError> {
        let found = self.some("keyword", word)?;
        if found.eq_ignore_ascii_case(word) { Ok(()) } else { Err(self.refuse("keyword", found, word)) }
    }

    fn number(&mut self, field: &str) -> Result<f64, CaptureError> {
        const LEGAL: &str = "a finite number";
        let word = self.some(field, LEGAL)?;
        let number = word.parse::<f64>().ok().filter(|x| x.is_finite());
        number.ok_or_else(|| self.refuse(field, word, LEGAL))
    }

    fn count(&mut self, field: &str, least: usize, most: usize) -> Result<usize, CaptureError> {
        let legal = format!("{least} to {most}");
        let word = self.some(field, &legal)?;
        let count = word.parse().ok().filter(|n| (least..=most).contains(n));
        count.ok_or_else(|| self.refuse(field, word, &legal))
    }
}

/// The bones up to and including the word MOTION, parents first, which is the order of their channels.
fn hierarchy(words: &mut Words) -> Result<(Vec<Bone>, Vec<Placing>), CaptureError> {
    words.expect("HIERARCHY")?;
    let (mut bones, mut places) = (Vec::<Bone>::new(), Vec::<Placing>::new());
    let mut open: Vec<usize> = Vec::new();
    loop {
        let word = words.some("keyword", "MOTION after the hierarchy")?;
        let parent = open.last().copied();
        let inner = parent.filter(|&bone| !bones[bone].end);
        match (word.to_ascii_uppercase().as_str(), parent) {
            ("ROOT", None) if bones.is_empty() => {}
            ("JOINT" | "END", Some(_)) if inner.is_some() => {}
            ("OFFSET", Some(bone)) if places[bone].offset.is_none() => {
                let offset =
                    [words.number("OFFSET x")?, words.number("OFFSET y")?, words.number("OFFSET z")?];
                places[bone].offset = Some(offset);
                continue;
            }
            ("CHANNELS", Some(bone)) if inner.is_some() && places[bone].channels.is_none() => {
                places[bone].channels = Some(channels(words)?);
                continue;
            }
            ("}", Some(bone)) if places[bone].offset.is_some() => {
                open.pop();
                continue;
            }
            ("MOTION", None) if !bones.is_empty() => return Ok((bones, places)),
            _ => {
                let legal = match parent {
                    None if bones.is_empty() => "ROOT",
                    None => "MOTION, for there is one ROOT",
                    Some(_) => {
                        "JOINT, End Site (not in an End Site), one OFFSET, at most one CHANNELS, then }"
                    }
                };
                return Err(words.refuse("keyword", word, legal));
            }
        }
        let end = word.eq_ignore_ascii_case("END");
        if end {
            words.expect("Site")?;
        }
        let name = name(words)?;
        if bones.len() == BONES {
            return Err(words.refuse("bones", &(BONES + 1).to_string(), &format!("at most {BONES}")));
        }
        if open.len() == DEPTH {
            return Err(words.refuse("depth", &(DEPTH + 1).to_string(), &format!("at most {DEPTH}")));
        }
        open.push(bones.len());
        bones.push(Bone { name: if end { String::new() } else { name }, parent, end });
        places.push(Placing::default());
    }
}

/// The words up to the opening brace, joined; an End Site needs none.
fn name(words: &mut Words) -> Result<String, CaptureError> {
    let mut name = String::new();
    for _ in 0..16 {
        match words.some("name", "a name, then {")? {
            "{" => return Ok(name),
            word => name.push_str(word),
        }
    }
    Err(words.refuse("name", &name, "at most 15 words, then {"))
}

fn channels(words: &mut Words) -> Result<Vec<Channel>, CaptureError> {
    let n = words.count("CHANNELS", 0, 6)?;
    let legal = CHANNELS.map(|(name, _)| name).join(", ");
    (0..n)
        .map(|_| {
            let word = words.some("channel", &legal)?;
            let known = CHANNELS.iter().find(|(name, _)| name.eq_ignore_ascii_case(word));
            known.map(|&(_, channel)| channel).ok_or_else(|| words.refuse("channel", word, &legal))
        })
        .collect()
}

/// Times in s and the `found` joints in the file's unit, turned to z up.
fn motion(
    words: &mut Words,
    bones: &[Bone],
    places: &[Placing],
    found: &[usize; JOINTS],
) -> Result<Motion, CaptureError> {
    if places.iter().all(|place| place.channels.as_ref().is_none_or(Vec::is_empty)) {
        return Err(refuse("hierarchy", "CHANNELS", 0, "at least 1 in all"));
    }
    words.expect("Frames:")?;
    let n = words.count("Frames", FRAMES[0], FRAMES[1])?;
    words.expect("Frame")?;
    words.expect("Time:")?;
    let step = words.number("Frame Time")?;
    if !(STEP_S[0]..=STEP_S[1]).contains(&step) {
        let legal = format!("{} to {} s", STEP_S[0], STEP_S[1]);
        return Err(words.refuse("Frame Time", &step.to_string(), &legal));
    }
    let mut frames = Vec::new();
    let mut world = vec![([0.0; 3], [[0.0; 3]; 3]); bones.len()];
    for frame in 1..=n {
        for (b, (bone, place)) in bones.iter().zip(places).enumerate() {
            let mut offset = place.offset.unwrap_or([0.0; 3]);
            let mut turn = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
            for channel in place.channels.iter().flatten() {
                let Some(word) = words.next() else {
                    let at = format!("bone {} of frame {frame}", bone.name);
                    let legal = format!("a number for each channel of {n} frames");
                    return Err(words.refuse(&at, "end of the file", &legal));
                };
                let number = word.parse::<f64>().ok().filter(|x| x.is_finite());
                let value = number.ok_or_else(|| words.refuse(&bone.name, word, "a finite number"))?;
                match *channel {
                    Channel::Move(axis) => offset[axis] = value,
                    Channel::Turn(axis) => rotate(&mut turn, axis, value),
                }
            }
            world[b] = match bone.parent {
                None => (offset, turn),
                Some(parent) => {
                    let (position, basis) = world[parent];
                    let row = |i: usize, v: Vec3| super::super::dot(basis[i], v);
                    let column = |k: usize| [turn[0][k], turn[1][k], turn[2][k]];
                    let placed = std::array::from_fn(|i| position[i] + row(i, offset));
                    (placed, std::array::from_fn(|i| std::array::from_fn(|k| row(i, column(k)))))
                }
            };
        }
        frames.push(found.map(|b| {
            let [x, y, z] = world[b].0;
            [z, x, y]
        }));
    }
    if let Some(word) = words.next() {
        return Err(words.refuse("MOTION", word, &format!("nothing after the {n} frames")));
    }
    Ok(((0..n).map(|k| k as f64 * step).collect(), frames))
}

/// `turn` times the right-handed rotation about `axis` by an angle in degrees.
fn rotate(turn: &mut [Vec3; 3], axis: usize, degrees: f64) {
    let angle = degrees * PI / 180.0;
    let (s, c) = (libm::sin(angle), libm::cos(angle));
    let (i, j) = ((axis + 1) % 3, (axis + 2) % 3);
    for row in turn {
        (row[i], row[j]) = (c * row[i] + s * row[j], c * row[j] - s * row[i]);
    }
}

#[cfg(test)]
mod tests {
    use super::super::super::gait::joint::*;
    use super::super::super::{norm, sub};
    use super::*;
    use crate::numerics::random::Random;

    const TURNS: &str = "CHANNELS 3 Zrotation Xrotation Yrotation";

    /// A skeleton of 174 cm, its lengths in a unit of which `k` are a cm, and frames of 6 + 4 + 17 x 3 numbers.
    fn file(k: f64, frames: &[String]) -> String {
        let bone = |kind: &str, name: &str, [x, y, z]: Vec3, rest: &str, inner: &str| {
            let (x, y, z) = (x * k, y * k, z * k);
            format!("{kind} {name}\n{{\n\tOFFSET {x} {y} {z}\n\t{rest}\n{inner}}}\n")
        };
        let joint = |name: &str, offset: Vec3, inner: &str| bone("JOINT", name, offset, TURNS, inner);
        let end = |offset: Vec3| bone("End", "Site", offset, "", "");
        let (mut upper, mut lower) = (String::new(), String::new());
        for (side, x) in [("Left", 1.0), ("Right", -1.0)] {
            let name = |part: &str| format!("{side}{part}");
            let hand = joint(&name("Hand"), [0.0, -26.0, 0.0], &end([0.0, -8.0, 0.0]));
            let elbow = joint(&name("ForeArm"), [0.0, -30.0, 0.0], &hand);
            upper += &joint(&name("Arm"), [18.0 * x, 0.0, 0.0], &elbow);
            let foot = joint(&name("Foot"), [0.0, -42.0, 0.0], &end([0.0, -4.0, 20.0]));
            let knee = joint(&name("Leg"), [0.0, -42.0, 0.0], &foot);
            lower += &joint(&name("UpLeg"), [10.0 * x, 0.0, 0.0], &knee);
        }
        let head = joint("Head", [0.0, 10.0, 0.0], &end([0.0, 14.0, 0.0]));
        let four = "CHANNELS 4 Yposition Zrotation Xrotation Yrotation";
        let neck = bone("JOINT", "Neck", [0.0, 3.0, 0.0], four, &(head + &upper));
        let six = "CHANNELS 6 Xposition Yposition Zposition Zrotation Xrotation Yrotation";
        let root = bone("ROOT", "Hips", [7.0, 8.0, 9.0], six, &(neck + &lower));
        let n = frames.len();
        format!("HIERARCHY\n{root}MOTION\nFrames: {n}\nFrame Time: 0.01\n{}\n", frames.join("\n"))
    }

    /// Numbers of the root and of the arm and forearm of the left; the others are 0.
    fn frame(k: f64, root: [f64; 6], arm: [f64; 3], forearm: [f64; 3]) -> String {
        let mut all: Vec<f64> = root.to_vec();
        all[..3].iter_mut().for_each(|value| *value *= k);
        all.extend([50.0 * k, 0.0, 0.0, 0.0]);
        all.extend([0.0; 3]); // head
        all.extend(arm);
        all.extend(forearm);
        all.resize(10 + 3 * 13, 0.0);
        all.iter().map(f64::to_string).collect::<Vec<_>>().join(" ")
    }

    fn example(k: f64) -> String {
        let rest = frame(k, [0.0, 90.0, 0.0, 0.0, 0.0, 0.0], [0.0; 3], [0.0; 3]);
        let turned = frame(k, [0.0, 90.0, 5.0, 0.0, 0.0, 90.0], [0.0, -90.0, 0.0], [90.0, 0.0, 0.0]);
        let lying = frame(k, [0.0, 90.0, 0.0, 90.0, 90.0, 0.0], [0.0; 3], [0.0; 3]);
        file(k, &[rest.clone(), turned, lying, rest])
    }

    #[test]
    fn joints_stand_where_a_calculation_by_hand_puts_them() {
        let capture = parse(&example(1.0), None).unwrap();
        assert_eq!((capture.unit_m(), capture.frames()), (0.01, 4));
        assert!((capture.height_m() - 1.58 / 0.909).abs() < 1e-9);
        for (t, joint, expected) in [
            (0.0, BASE, [0.0, 0.0, 0.9]),
            (0.0, NECK, [0.0, 0.0, 1.4]), // its Yposition replaces the 3 of its OFFSET
            (0.0, HEAD, [0.0, 0.0, 1.64]),
            (0.0, SHOULDER, [0.0, 0.18, 1.4]),
            (0.0, HAND + 1, [0.0, -0.18, 0.84]),
            (0.0, ANKLE, [0.0, 0.1, 0.06]),
            (0.0, TOE + 1, [0.2, -0.1, 0.02]),
            (0.01, SHOULDER, [-0.13, 0.0, 1.4]),
            (0.01, ELBOW, [-0.13, 0.3, 1.4]),
            (0.01, HAND, [-0.39, 0.3, 1.4]),
            (0.01, TOE, [-0.05, 0.2, 0.02]),
            (0.02, NECK, [0.5, 0.0, 0.9]), // Z then X in the turned axes: y to z
            (0.02, SHOULDER, [0.5, 0.0, 1.08]), // x to y
        ] {
            let found = capture.at(t).0[joint];
            assert!(norm(sub(found, expected)) < 1e-9, "{t} {joint}: {found:?} {expected:?}");
        }
    }

    #[test]
    fn the_unit_is_guessed_or_given() {
        for unit in UNITS_M {
            let capture = parse(&example(0.01 / unit), None).unwrap();
            assert_eq!(capture.unit_m(), unit);
            assert!((capture.at(0.0).0[HEAD][2] - 1.64).abs() < 1e-9);
        }
        let half = parse(&example(1.0), Some(0.005)).unwrap();
        assert!((half.at(0.0).0[HEAD][2] - 0.82).abs() < 1e-9 && half.unit_m() == 0.005);
        assert!(parse(&example(1.0), Some(f64::NAN)).unwrap_err().to_string().contains("unit_m"));
    }

    #[test]
    fn what_is_wrong_is_named_with_its_line() {
        let good = example(1.0);
        let lines = good.lines().count();
        let last = good.trim_end().rsplit_once(' ').unwrap().0;
        let deep = format!("HIERARCHY ROOT a {{ {}", "JOINT b { ".repeat(100_000));
        let wide = format!("HIERARCHY ROOT a {{ {}", "JOINT b { OFFSET 0 0 0 } ".repeat(600));
        let still: Vec<&str> = good.lines().filter(|line| !line.contains("CHANNELS")).collect();
        for (text, expected) in [
            (still.join("\n"), "hierarchy: CHANNELS is \"0\""),
            (String::new(), "line 0: keyword is end of the file"),
            (good.replace("HIERARCHY", "HIERARCHIE"), "line 1: keyword is \"HIERARCHIE\""),
            (good.replacen("ROOT", "JOINT", 1), "line 2: keyword is \"JOINT\""),
            (good.replacen("OFFSET 7", "OFFSET seven", 1), "line 4: OFFSET x is \"seven\""),
            (good.replacen("OFFSET 7", "OFFSET nan", 1), "line 4: OFFSET x is \"nan\""),
            (good.replacen("CHANNELS 6", "CHANNELS 7", 1), "line 5: CHANNELS is \"7\""),
            (good.replacen("Xposition", "Xscale", 1), "line 5: channel is \"Xscale\""),
            (good.replacen("LeftLeg", "LeftPeg", 1), "hierarchy: joint left_knee is missing"),
            (good.replacen("Frames: 4", "Frames: 3", 1), "Frames is \"3\""),
            (
                good.replacen("Frames: 4", "Frames: 99999999999999999999", 1),
                "Frames is \"99999999999999999999\"",
            ),
            (good.replacen("Frames: 4", "Frames: 900000", 1), "bone Hips of frame 5 is end of the file"),
            (good.replacen("Frame Time: 0.01", "Frame Time: 0", 1), "Frame Time is \"0\""),
            (last.to_owned(), "bone RightFoot of frame 4 is end of the file"),
            (format!("{good} 1"), "MOTION is \"1\""),
            (good.replacen("0 90 5", "0 90 inf", 1), "Hips is \"inf\""),
            (good.replacen("0 90 5", "0 90 1e6", 1), "frame 2: base x is \"10000\""),
            (good.replacen("OFFSET 0 -26 0", "OFFSET 0 0 0", 1), "limb left_elbow-left_hand is \"0\""),
            (deep, "line 1: depth is \"65\""),
            (wide, "line 1: bones is \"513\""),
        ] {
            let found = parse(&text, None).map(|_| ()).unwrap_err().to_string();
            assert!(found.contains(expected), "{found}\n{expected}");
        }
        let folder = tempfile::tempdir().unwrap();
        let named = folder.path().join("walk.Bvh");
        std::fs::write(&named, &good).unwrap();
        assert_eq!(Capture::read(&named).unwrap().frames(), 4);
        std::fs::write(&named, last).unwrap();
        let found = Capture::read(&named).unwrap_err().to_string();
        assert!(found.contains(&format!("walk.Bvh, line {lines}: ")), "{found}");
    }

    #[test]
    fn no_bytes_make_it_panic() {
        let good = example(1.0);
        let words = [
            "{",
            "}",
            "JOINT",
            "End Site",
            "-1e308",
            "nan",
            "OFFSET",
            "CHANNELS 6",
            "MOTION",
            "Frames: 7",
            "",
        ];
        let mut random = Random::new(11, 0, 0, 0);
        let mut accepted = 0;
        for _ in 0..3000 {
            let mut bytes = good.clone().into_bytes();
            for _ in 0..1 + random.bits() % 3 {
                let at = random.bits() as usize % bytes.len();
                match random.bits() % 4 {
                    0 => bytes[at] = random.bits() as u8,
                    1 => bytes.truncate(at + 1),
                    2 => bytes[at] = b"0123456789.-e \n"[random.bits() as usize % 15],
                    _ => {
                        let word = words[random.bits() as usize % words.len()];
                        let until = (at + random.bits() as usize % 20).min(bytes.len());
                        bytes.splice(at..until, word.bytes());
                    }
                }
                if bytes.is_empty() {
                    break;
                }
            }
            if let Ok(capture) = parse(&String::from_utf8_lossy(&bytes), None) {
                accepted += 1;
                let (positions, velocities) = capture.at(0.6 * capture.duration_s());
                assert!(positions.iter().chain(&velocities).flatten().all(|v| v.is_finite()));
            }
        }
        assert!((10..2900).contains(&accepted), "{accepted}");
    }
}
