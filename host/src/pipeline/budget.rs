//! What commands need, by formulas over the resolved scenario: bytes and seconds of the items that can grow without end. `tests/budget`
//! holds memory to what was measured; times are rough, a factor of two either way.
//!
//! | item | memory in bytes | time in s |
//! |---|---|---|
//! | links ([`regions`]) | none: one draw at a time | combinations x users x draws x (30e-6 + 90e-9 x sub-carriers) |
//! | boundary ([`regions`]) | `POINT` x N_s of one case, `ROW` x rows of a sweep | combinations x cases x N_s x 1e-6 |
//! | training ([`training`]) | images x 64 x frames x 3, `4 x batch x channels x pixels x (2 blocks + 3)` of each network at work | `expected.rs` |
//! | learning curves ([`fits`]) | none | points x 0.1 |
//! | point targets ([`targets`]) | none: rows go to their file | instants x classes x 60e-6 |
//! | periods ([`campaign`]) | none: the trace goes to its file | periods x slots x 30e-9 |
//!
//! Recordings are held to the budget by their reader, 24 bytes a number.

use super::Job;
use crate::error::Invalid;
use crate::scenario::Scenario;
use crate::scenario::budget::{Budget, Need};
#[cfg(feature = "train")]
use {crate::scenario::Class, sdp3_core::dims::ROWS};

/// Seconds of a draw of a link: the channel, and each sub-carrier with its share of the power.
const DRAW_S: f64 = 30e-6;
const SUBCARRIER_S: f64 = 90e-9;
/// Seconds and bytes of a point of a boundary, its shares, its place in the Pareto order.
const POINT_S: f64 = 1e-6;
const POINT: f64 = 150.0;
/// Bytes of a row of a sweep, and of its text.
const ROW: f64 = 600.0;
/// Seconds of the seven curves, their leave-one-out and their bands, for every point.
const FIT_S: f64 = 0.1;
/// Seconds of the sixteen rows of an instant.
const INSTANT_S: f64 = 60e-6;
/// Seconds of a decision of the scheduler.
const DECISION_S: f64 = 30e-9;

/// Seconds of the draws of all links of a scenario.
pub(super) fn links_s(scenario: &Scenario) -> f64 {
    let m = &scenario.communication;
    let draws = m.cases.iter().map(Vec::len).sum::<usize>() as f64 * f64::from(m.draws);
    let each = DRAW_S + SUBCARRIER_S * f64::from(m.used_subcarriers());
    if m.slot_bit.is_some() { 0.0 } else { draws * each }
}

/// Refuses links and boundaries of so many variants of a scenario.
///
/// # Errors
///
/// What needs most.
pub(super) fn regions(scenario: &Scenario, budget: Budget, combinations: u64) -> Result<(), Invalid> {
    let (m, f) = (&scenario.communication, &scenario.frame);
    let (cases, users) = (m.cases.len() as f64, m.cases.iter().map(Vec::len).sum::<usize>());
    let slots = f64::from(f.period_slots / (f.spacing_slots + 1));
    let all = combinations as f64;
    let frame = ("frame.period_slots / (frame.spacing_slots + 1)", f.period_slots / (f.spacing_slots + 1));
    let mut memory = vec![Need::new(frame.0, frame.1, POINT * slots)];
    let mut time = vec![Need::new(frame.0, frame.1, all * cases * slots * POINT_S)];
    if combinations > 1 {
        memory.push(Need::new(
            "--sweep (combinations) x communication.cases",
            format!("{combinations} x {cases}"),
            all * cases * ROW,
        ));
    }
    let (draws, subcarriers) = (m.draws, m.used_subcarriers());
    let (mut fields, mut values) =
        ("communication.draws x users x sub-carriers", format!("{draws} x {users} x {subcarriers}"));
    if combinations > 1 {
        fields = "--sweep (combinations) x communication.draws x users x sub-carriers";
        values = format!("{combinations} x {values}");
    }
    time.push(Need::new(fields, values, all * links_s(scenario)));
    budget.check_memory(&memory)?;
    budget.check_time(&time)
}

/// Seconds of all learning curves through so many points.
pub(super) fn fits(points: usize) -> [Need; 1] {
    [Need::new("points", points, FIT_S * points as f64)]
}

/// Refuses too many instants of all classes.
///
/// # Errors
///
/// The time they cover, and what is between two of them.
pub(super) fn targets(budget: Budget, duration_s: f64, every_s: f64, instants: u64) -> Result<(), Invalid> {
    let values = format!("{duration_s} / {every_s}, {instants} instants of all classes");
    budget.check_time(&[Need::new("--duration-s / --every-s", values, instants as f64 * INSTANT_S)])
}

/// Refuses too many periods of the scheduler.
///
/// # Errors
///
/// The periods and their slots.
pub(super) fn campaign(job: &Job, periods: u32) -> Result<(), Invalid> {
    let slots = job.scenario.frame.period_slots;
    let seconds = f64::from(periods) * f64::from(slots) * DECISION_S;
    job.budget.check_time(&[Need::new(
        "--periods x frame.period_slots",
        format!("{periods} x {slots}"),
        seconds,
    )])
}

/// Memory of trainings on `workers` threads: the images of all N_s, with those of `tested` recordings of each class, and the activations
/// of the networks that are at work together.
#[cfg(feature = "train")]
pub(super) fn training(scenario: &Scenario, tested: u32, workers: usize) -> Vec<Need> {
    let (l, settings) = (&scenario.learning, scenario.spectrogram.preprocessing());
    let slots = &scenario.frame.sensing_slots;
    let frames: Vec<usize> = slots.iter().map(|&n| settings.frames(n as usize)).collect();
    let classes = Class::ALL.len() as f64;
    let learned = f64::from(l.train_per_class) * f64::from(l.windows);
    let pixels = (ROWS * frames.iter().sum::<usize>()) as f64;
    // every image once as it is made and once in its set, which grows by doubling
    let images = 3.0 * classes * (learned + f64::from(tested)) * pixels;
    let (count, size) = (classes * learned, f64::from(l.batch));
    // as training cuts them, near to the size
    let batch = (count / (count / size + 0.5).floor().max(1.0)).ceil();
    let stride = usize::from(l.stem_stride);
    let plane = |size: usize| (size.div_ceil(stride) / 2 + 1) as f64;
    let tensors = 2.0 * f64::from(l.blocks) + 3.0;
    let network = |frames: usize| {
        let activations = f64::from(l.channels) * plane(ROWS) * plane(frames) * tensors;
        4.0 * batch * (activations + 3.0 * (ROWS * frames) as f64)
    };
    // the longest are begun first
    let mut at_work: Vec<f64> = frames.iter().map(|&frames| network(frames)).collect();
    at_work.sort_by(|a, b| b.total_cmp(a));
    let at_work: f64 = at_work.iter().take(workers).sum();
    vec![
        Need::new(
            "learning.train_per_class x learning.windows x frame.sensing_slots",
            format!("{} x {} x {slots:?}", l.train_per_class, l.windows),
            images,
        ),
        Need::new(
            "learning.batch x learning.channels x learning.blocks",
            format!("{} x {} x {}", l.batch, l.channels, l.blocks),
            at_work,
        ),
    ]
}

#[cfg(all(test, feature = "train"))]
mod tests {
    use super::*;
    use crate::scenario::Override;

    fn scenario(set: &[&str]) -> Scenario {
        let set: Vec<Override> = set.iter().map(|one| one.parse().unwrap()).collect();
        Scenario::default().with(&set, "built in").unwrap()
    }

    #[test]
    fn needs_grow_with_every_factor() {
        let of = |set: &[&str]| training(&scenario(set), 0, 1).iter().map(|n| n.amount).collect::<Vec<_>>();
        let base = ["learning.train_per_class=1000", "learning.batch=50"];
        let usual = of(&base);
        let with = |one: &'static str| of(&[&base[..], &[one]].concat());
        let ratio = |found: Vec<f64>, k: usize| found[k] / usual[k];
        assert!((ratio(with("learning.train_per_class=2000"), 0) - 2.0).abs() < 1e-9);
        assert!((ratio(with("learning.batch=100"), 1) - 2.0).abs() < 0.02);
        assert!(ratio(with("learning.channels=32"), 1) > 1.5);
        assert!(ratio(with("learning.blocks=8"), 1) > 1.2);
        // a batch is never larger than what is learned from
        assert_eq!(
            of(&["learning.train_per_class=2", "learning.batch=10000"]),
            of(&["learning.train_per_class=2", "learning.batch=5000"])
        );
    }

    #[test]
    fn the_field_that_needs_most_is_named() {
        let refused = |set: &[&str], combinations: u64, budget: Budget| {
            regions(&scenario(set), budget, combinations).unwrap_err().to_string()
        };
        let usual = Budget::default();
        assert!(refused(&[], u64::MAX, usual).starts_with("--sweep (combinations) x communication.cases is"));
        let minute = Budget { time: crate::scenario::budget::Time(60.0), ..usual };
        let found = refused(&["communication.draws=1000000"], 1, minute);
        assert!(
            found.starts_with("communication.draws x users x sub-carriers is 1000000 x 6 x 467"),
            "{found}"
        );
        let small = Budget { memory: crate::scenario::budget::Memory(1 << 20), ..usual };
        let found = refused(&["frame.period_slots=1000000", "frame.spacing_slots=0"], 1, small);
        assert!(found.starts_with("frame.period_slots / (frame.spacing_slots + 1) is 1000000"), "{found}");
        regions(&scenario(&[]), usual, 1).unwrap();
    }
}
