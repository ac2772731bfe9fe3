//! A motion as CSV: `time,joint,x,y,z` in s and m, one row for each of the seventeen joints at each time.
//!
//! The rows of a time follow one another, in any order of the joints; their names are [`JOINT_NAMES`] in any case.

use super::super::Vec3;
use super::super::gait::JOINTS;
use super::{
    COORDINATE_M, Capture, CaptureError, FILE_BYTES, FRAMES, JOINT_NAMES, Motion, coordinate_range, open,
    refuse,
};
use std::io::{BufRead, BufReader, Read};
use std::path::Path;

const HEADER: &str = "time,joint,x,y,z";
/// Longest line in bytes.
const LINE_BYTES: u64 = 1024;

/// Reads a motion.
///
/// # Errors
///
/// [`CaptureError`] names file, line, field or joint, value and legal range.
pub fn read(file: &Path) -> Result<Capture, CaptureError> {
    let text = BufReader::new(open(file)?.take(FILE_BYTES));
    let (times, frames) = rows(text, FRAMES[1]).map_err(|why| match why {
        Refused::Read(source) => CaptureError::Read { file: file.to_owned(), source },
        Refused::Value(why) => why.in_file(file),
    })?;
    Capture::new(times, frames).map_err(|why| why.in_file(file))
}

enum Refused {
    Read(std::io::Error),
    Value(CaptureError),
}

impl From<CaptureError> for Refused {
    fn from(why: CaptureError) -> Self {
        Refused::Value(why)
    }
}

/// The frame being read.
struct Group {
    time: f64,
    joints: [Option<Vec3>; JOINTS],
}

impl Group {
    /// Its joints, every one of which stood in the rows up to `line`.
    fn close(&self, line: usize) -> Result<[Vec3; JOINTS], CaptureError> {
        let mut frame = [[0.0; 3]; JOINTS];
        for (j, found) in self.joints.iter().enumerate() {
            frame[j] = found.ok_or_else(|| {
                let legal = format!("a row for each of the {JOINTS} joints at time {}", self.time);
                refuse(format!("line {line}"), format!("joint {}", JOINT_NAMES[j]), "missing", legal)
            })?;
        }
        Ok(frame)
    }
}

/// Times and joints of at most `most` frames.
fn rows(mut text: impl BufRead, most: usize) -> Result<Motion, Refused> {
    let (mut times, mut frames) = (Vec::new(), Vec::new());
    let mut group: Option<Group> = None;
    let (mut line, mut last) = (0, 0);
    let mut bytes = Vec::new();
    loop {
        bytes.clear();
        line += 1;
        let at = format!("line {line}");
        let length = (&mut text).take(LINE_BYTES + 1).read_until(b'\n', &mut bytes).map_err(Refused::Read)?;
        let row = String::from_utf8_lossy(&bytes);
        let row = if line == 1 { row.trim_start_matches('\u{feff}').trim() } else { row.trim() };
        if length as u64 > LINE_BYTES {
            return Err(refuse(at, "line", row, format!("at most {LINE_BYTES} bytes")).into());
        }
        if line == 1 {
            if row != HEADER {
                return Err(refuse(at, "header", row, HEADER).into());
            }
            continue;
        }
        if length == 0 {
            break;
        }
        if row.is_empty() {
            continue;
        }
        let (time, joint, position) = cells(&at, row)?;
        let open = match &mut group {
            Some(open) if open.time == time => open,
            before => {
                if let Some(before) = before {
                    if time < before.time {
                        let legal = format!("at least {}, the time of the rows before", before.time);
                        return Err(refuse(at, "time", time, legal).into());
                    }
                    frames.push(before.close(last)?);
                }
                if times.len() == most {
                    return Err(refuse(at, "frames", times.len() + 1, format!("at most {most}")).into());
                }
                times.push(time);
                before.insert(Group { time, joints: [None; JOINTS] })
            }
        };
        if open.joints[joint].replace(position).is_some() {
            let legal = format!("each joint once at time {time}");
            return Err(refuse(at, "joint", JOINT_NAMES[joint], legal).into());
        }
        last = line;
    }
    if let Some(open) = group {
        frames.push(open.close(last)?);
    }
    Ok((times, frames))
}

/// Time, joint and position of a row.
fn cells(at: &str, row: &str) -> Result<(f64, usize, Vec3), CaptureError> {
    let mut split = row.split(',').map(str::trim);
    let cells: [&str; 5] = std::array::from_fn(|_| split.next().unwrap_or(""));
    if split.next().is_some() {
        return Err(refuse(at, "columns", row.split(',').count(), HEADER));
    }
    let time = cells[0].parse::<f64>().ok().filter(|t| t.is_finite());
    let time = time.ok_or_else(|| refuse(at, "time", cells[0], "a finite number of seconds"))?;
    let joint = JOINT_NAMES.iter().position(|name| name.eq_ignore_ascii_case(cells[1]));
    let joint = joint.ok_or_else(|| refuse(at, "joint", cells[1], JOINT_NAMES.join(", ")))?;
    let mut position = [0.0; 3];
    for (axis, name) in ["x", "y", "z"].into_iter().enumerate() {
        let cell = cells[axis + 2];
        let number = cell.parse::<f64>().ok().filter(|m| (-COORDINATE_M..=COORDINATE_M).contains(m));
        position[axis] = number.ok_or_else(|| {
            refuse(at, format!("{name} of {}", JOINT_NAMES[joint]), cell, coordinate_range())
        })?;
    }
    Ok((time, joint, position))
}

#[cfg(test)]
mod tests {
    use super::super::super::gait::Gait;
    use super::super::super::{norm, scale, sub};
    use super::*;
    use std::fmt::Write;

    fn written(hz: f64, n: usize) -> (Gait, String) {
        let gait = Gait::new(1.75, 1.0);
        let mut text = format!("{HEADER}\n");
        for k in 0..n {
            let t = k as f64 / hz;
            for ([x, y, z], name) in gait.pose(t / gait.cycle_s()).iter().zip(JOINT_NAMES) {
                writeln!(text, "{t},{name},{x:.6},{y:.6},{z:.6}").unwrap();
            }
        }
        (gait, text)
    }

    fn read_text(text: &[u8]) -> Result<Capture, CaptureError> {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("walk.CSV");
        std::fs::write(&file, text).unwrap();
        Capture::read(&file)
    }

    #[test]
    fn a_walk_comes_back_within_a_millimetre_between_the_samples() {
        let (gait, text) = written(100.0, 151);
        let capture = read_text(text.as_bytes()).unwrap();
        assert_eq!((capture.frames(), capture.unit_m()), (151, 1.0));
        let furthest = |a: &[Vec3; JOINTS], b: &[Vec3; JOINTS]| {
            a.iter().zip(b).map(|(a, b)| norm(sub(*a, *b))).fold(0.0, f64::max)
        };
        let (mut place, mut speed, e) = (0.0_f64, 0.0_f64, 1e-5);
        for k in 0..=3000 {
            let t = 5e-4 * f64::from(k);
            let truth = |t: f64| gait.pose(t / gait.cycle_s());
            let (positions, velocities) = capture.at(t);
            place = place.max(furthest(&positions, &truth(t)));
            // the truth's velocity by central differences; the natural ends are off by up to 0.3 h of the acceleration
            if (100..=2900).contains(&k) {
                let (before, after) = (truth(t - e), truth(t + e));
                let slope = std::array::from_fn(|j| scale(sub(after[j], before[j]), 0.5 / e));
                speed = speed.max(furthest(&velocities, &slope));
            }
        }
        assert!(place < 1e-3, "{place} m");
        assert!(speed < 0.1, "{speed} m/s");
    }

    #[test]
    fn order_case_blank_lines_and_byte_order_mark_do_not_matter() {
        let (_, text) = written(50.0, 4);
        let mut lines: Vec<String> = text.lines().map(str::to_uppercase).collect();
        lines[0] = format!("\u{feff}{HEADER}");
        lines[1..18].reverse();
        lines.insert(9, String::new());
        let (a, b) = (read_text(text.as_bytes()).unwrap(), read_text(lines.join("\r\n").as_bytes()).unwrap());
        assert_eq!(a.at(0.03), b.at(0.03));
    }

    #[test]
    fn what_is_wrong_is_named_with_its_line() {
        let (_, good) = written(100.0, 5);
        let good: Vec<&str> = good.lines().collect();
        let with = |line: usize, row: &str| {
            let mut lines = good.clone();
            lines[line - 1] = row;
            lines.join("\n")
        };
        let without = |line: usize| {
            let mut lines = good.clone();
            lines.remove(line - 1);
            lines.join("\n")
        };
        for (text, expected) in [
            (String::new(), "line 1: header is \"\""),
            (with(1, "t,joint,x,y,z"), "line 1: header is \"t,joint,x,y,z\""),
            (format!("{HEADER}\n"), "motion: frames is \"0\""),
            (with(3, "0,nose,0,0,1"), "line 3: joint is \"nose\""),
            (with(3, "0,base,0,0,1"), "line 3: joint is \"base\""),
            (with(3, "zero,neck,0,0,1"), "line 3: time is \"zero\""),
            (with(3, "inf,neck,0,0,1"), "line 3: time is \"inf\""),
            (with(3, "0,neck,NaN,0,1"), "line 3: x of neck is \"NaN\""),
            (with(3, "0,neck,0,-inf,1"), "line 3: y of neck is \"-inf\""),
            (with(3, "0,neck,0,0,1e4"), "line 3: z of neck is \"1e4\""),
            (with(3, "0,neck,0,0"), "line 3: z of neck is \"\""),
            (with(3, "0,neck,0,0,1,2"), "line 3: columns is \"6\""),
            (with(20, "-1,neck,0,0,1"), "line 20: time is \"-1\""),
            (with(20, "0.02,neck,0,0,1"), "line 19: joint neck is missing"),
            (without(18), "line 17: joint right_toe is missing"),
            (without(good.len()), "line 85: joint right_toe is missing"),
            (with(3, &"9".repeat(2000)), "line 3: line is \"9999"),
            (with(9, "0,right_hand,0,0,1.7"), "line 10: joint is \"right_hand\""),
        ] {
            let found = read_text(text.as_bytes()).map(|_| ()).unwrap_err().to_string();
            assert!(found.contains("walk.CSV, ") && found.contains(expected), "{found}\n{expected}");
        }
        let binary = read_text(&[0xff, 0xfe, 0, 10, 7]).map(|_| ()).unwrap_err().to_string();
        assert!(binary.contains("line 1: header"), "{binary}");
    }

    #[test]
    fn too_many_frames_are_refused_while_reading() {
        let (_, text) = written(100.0, 6);
        let Err(Refused::Value(why)) = rows(text.as_bytes(), 5) else { panic!("accepted") };
        assert!(why.to_string().starts_with("line 87: frames is \"6\""), "{why}");
        assert!(rows(text.as_bytes(), 6).is_ok());
    }

    #[test]
    fn no_bytes_make_it_panic() {
        use crate::numerics::random::Random;
        let (_, text) = written(100.0, 4);
        let mut random = Random::new(7, 0, 0, 0);
        for _ in 0..1000 {
            let mut bytes = text.clone().into_bytes();
            for _ in 0..1 + random.bits() % 4 {
                let at = random.bits() as usize % bytes.len();
                bytes[at] = random.bits() as u8;
            }
            if let Ok((times, frames)) = rows(bytes.as_slice(), 10)
                && let Ok(capture) = Capture::new(times, frames)
            {
                assert!(capture.at(0.015).1.iter().flatten().all(|v| v.is_finite()));
            }
        }
    }
}
