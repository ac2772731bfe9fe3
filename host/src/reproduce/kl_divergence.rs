//! KL divergence between experiment and hybrid channel over rho, and that of ray tracing: the upper half of the paper's calibration figure.

use super::made::{Made, number, statement};
use super::settings::Settings;
use super::work::{Divergence, ROOMS, Task, Work};
use crate::error::Failure;
use crate::report::panels::THIRD;
use crate::report::plot::{Axis, INK, Plot, STYLES};
use crate::results::{Compared, Estimate};

/// The paper's rho in each of [`ROOMS`].
const PAPER: [f64; 3] = [0.997, 0.997, 0.996];
/// Half a unit of the paper's last digit; the search resolves 2 % of 1 - rho.
const TOLERANCE: f64 = 0.0005;

pub fn tasks(seeds: &[u64]) -> Vec<Task> {
    let rooms = |settings| (0..ROOMS.len()).map(move |room| (settings, room));
    let all = Settings::BOTH.into_iter().flat_map(rooms);
    let task = |(settings, room)| seeds.iter().map(move |&seed| Task::Divergence { settings, room, seed });
    all.flat_map(task).collect()
}

/// A room in words.
pub fn words(room: usize) -> String {
    let (carrier_hz, interferer) = ROOMS[room];
    format!("{} GHz, scenario {}", carrier_hz / 1e9, if interferer { 2 } else { 1 })
}

fn panel(found: &Divergence) -> String {
    // rho = 1 stands left of all others
    let least = found.curve.iter().map(|p| 1.0 - p.rho).filter(|&x| x > 1e-12).fold(0.1, f64::min) / 3.0;
    let at = |rho: f64| (1.0 - rho).max(least);
    let mut x = Axis::new(least / 1.5, 0.12, "1 − ρ (no unit)");
    x.log = true;
    let all = || found.curve.iter().map(|p| p.kl).chain([found.ray_tracing]).map(|kl| kl.max(1e-4));
    let mut y =
        Axis::new(all().fold(1.0, f64::min) / 1.5, all().fold(0.1, f64::max) * 1.5, "KL divergence (nat)");
    y.log = true;
    let mut plot = Plot::new("KL divergence over 1 - rho", x, y);
    let dahc = plot.series("DAHC", STYLES[0]);
    let points: Vec<_> = found.curve.iter().map(|p| (at(p.rho), p.kl.max(1e-4))).collect();
    plot.line(dahc, &points, 1.4);
    for point in &points {
        plot.dot(dahc, *point, 2.0, "");
    }
    let rays = plot.series("ray tracing", STYLES[1]);
    plot.line(rays, &[(least, found.ray_tracing), (0.08, found.ray_tracing)], 1.4);
    let ring = plot.series(&format!("minimum, ρ = {}", found.rho), INK);
    let best = found.curve.iter().map(|p| p.kl).fold(f64::INFINITY, f64::min);
    plot.ring(ring, (at(found.rho), best.max(1e-4)), "");
    plot.svg(THIRD)
}

/// Every room's divergences, `[room][settings][seed]`.
pub fn found(work: &Work<'_>) -> Result<Vec<[Vec<Divergence>; 2]>, Failure> {
    (0..ROOMS.len()).map(|room| work.both(|settings, seed| work.divergence(settings, room, seed))).collect()
}

/// The first seed's panels: the rooms with both settings.
pub fn panels(found: &[[Vec<Divergence>; 2]], panel: fn(&Divergence) -> String) -> Vec<(String, String)> {
    let of = |settings: usize| {
        found.iter().enumerate().map(move |(room, both)| {
            let caption = format!("{}, {}", words(room), Settings::BOTH[settings].words());
            (caption, panel(&both[settings][0]))
        })
    };
    of(0).chain(of(1)).collect()
}

pub fn make(work: &Work<'_>) -> Result<Made, Failure> {
    let found = found(work)?;
    let mut made = Made {
        caption: "Calibration of the hybrid channel, walking: KL divergence over rho (Fig. 6, a to c)",
        columns: 3,
        ..Made::default()
    };
    let estimate = |of: &[Divergence], value: &dyn Fn(&Divergence) -> f64| {
        Some(Estimate::of_seeds(&of.iter().map(value).collect::<Vec<_>>()))
    };
    let least = |d: &Divergence| d.curve.iter().map(|p| p.kl).fold(f64::INFINITY, f64::min);
    for (room, both) in found.iter().enumerate() {
        let [printed, here] = both;
        let of = |value: &dyn Fn(&Divergence) -> f64| [estimate(printed, value), estimate(here, value)];
        let rho = number(&format!("{}: rho at the minimum", words(room)), Some(PAPER[room]), of(&|d| d.rho));
        made.numbers.push(Compared { tolerance: TOLERANCE, ..rho });
        made.numbers.push(number(&format!("{}: KL at the minimum, nat", words(room)), None, of(&least)));
        made.numbers.push(number(
            &format!("{}: KL of ray tracing, nat", words(room)),
            None,
            of(&|d| d.ray_tracing),
        ));
    }
    let every = |holds: &dyn Fn(usize, usize) -> bool| {
        [0, 1].map(|settings| Some((0..ROOMS.len()).all(|room| holds(room, settings))))
    };
    let mean = |room: usize, settings: usize, value: &dyn Fn(&Divergence) -> f64| {
        let all = &found[room][settings];
        all.iter().map(value).sum::<f64>() / all.len() as f64
    };
    let without = |d: &Divergence| d.curve.last().map_or(f64::NAN, |p| p.kl);
    made.statements = vec![
        statement(
            "the divergence has its minimum below rho = 1 (there it is at most half of that at 1)",
            every(&|room, s| mean(room, s, &least) <= 0.5 * mean(room, s, &without)),
        ),
        statement(
            "ray tracing is farther from the experiment than the calibrated hybrid channel (twice and more)",
            every(&|room, s| mean(room, s, &|d| d.ray_tracing) >= 2.0 * mean(room, s, &least)),
        ),
        statement(
            "a second person makes rho smaller (60 GHz)",
            [0, 1].map(|s| Some(mean(2, s, &|d| d.rho) < mean(1, s, &|d| d.rho))),
        ),
    ];
    for recording in &work.measured {
        let found = work.measured(recording)?;
        let one = |value: f64| Some(Estimate { mean: value, low: value, high: value });
        for (what, value) in [
            ("rho at the minimum", found.rho),
            ("KL at the minimum, nat", found.dahc),
            ("KL at rho = 1, nat", found.without_uncertainty),
            ("KL of ray tracing, nat", found.ray_tracing),
        ] {
            made.numbers.push(number(
                &format!("measured, {}: {what}", recording.name),
                None,
                [None, one(value)],
            ));
        }
        let uncertain = found.rho < 1.0 && found.dahc <= 0.5 * found.without_uncertainty;
        made.statements.push(statement(
            &format!("measured, {}: the divergence has its minimum below rho = 1", recording.name),
            [None, Some(uncertain)],
        ));
        made.statements.push(statement(
            &format!(
                "measured, {}: ray tracing is farther than the calibrated hybrid channel",
                recording.name
            ),
            [None, Some(found.ray_tracing >= 2.0 * found.dahc)],
        ));
    }
    made.panels = panels(&found, panel);
    if !work.measured.is_empty() {
        made.notes.push(
            "The measured rows need `--measured FOLDER`, and `--carrier HZ` where the files do not say it."
                .into(),
        );
    }
    made.notes.push(EXPERIMENT.to_owned());
    made.notes.push("Its range samples have neither noise nor a front end.".into());
    Ok(made)
}

/// What the experiment is.
pub const EXPERIMENT: &str = "The paper's recordings are not public. What stands for them is simulated, but not by the hybrid channel: ray tracing in a furnished \
    room with rough surfaces and diffraction, in which somebody else stands, and other people with twice the spread of speeds. The paper's baseline is ray tracing in a bare room. They share an origin, which favours ray tracing here; \
    and nothing in that room fluctuates but people.";
