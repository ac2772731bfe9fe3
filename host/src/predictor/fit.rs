//! Least squares for the learning curves: globally over a grid of shapes, then locally by simplex.
//!
//! Eq. (fitting1), by variable projection (Golub and Pereyra, 1973): for every shape the two linear parameters follow exactly,
//! with 0 <= A <= 1 over the points and v >= 0; what is left has at most two dimensions. Deterministic.

use super::models::Model;
use super::points::range;
use super::shape::{Shape, Ties};
use crate::results::{CurvePoint, Parameters};

/// Sum of squared errors of given parameters.
pub fn sse(model: Model, p: &Parameters, points: &[CurvePoint]) -> f64 {
    points.iter().map(|x| (model.at(p, x.sensing_slots) - x.accuracy).powi(2)).sum()
}

/// Best legal parameters and their squared error; points are checked.
pub fn fit(model: Model, points: &[CurvePoint]) -> (Parameters, f64) {
    let (low, _) = range(points);
    let error = |t: [f64; 2]| solved(Shape::at(model, low, t), points).map_or(f64::INFINITY, |(_, e)| e);
    let best = match Shape::dimensions(model) {
        0 => [0.0; 2],
        1 => search(&error, grid(160, 1), 1),
        _ => search(&error, grid(40, 40), 2),
    };
    finish(model, Shape::at(model, low, best), points)
}

/// As [`fit`], from the grid's coarse form: for resampled points, where no digit counts.
pub fn fit_coarsely(model: Model, points: &[CurvePoint]) -> Parameters {
    let (low, _) = range(points);
    let error = |t: [f64; 2]| solved(Shape::at(model, low, t), points).map_or(f64::INFINITY, |(_, e)| e);
    let best = match Shape::dimensions(model) {
        0 => [0.0; 2],
        1 => search(&error, grid(24, 1), 1),
        _ => search(&error, grid(12, 12), 2),
    };
    finish(model, Shape::at(model, low, best), points).0
}

fn finish(model: Model, shape: Shape, points: &[CurvePoint]) -> (Parameters, f64) {
    let (low, _) = range(points);
    let flat = Shape::flat(model, low);
    let candidates = [shape, flat].into_iter().filter_map(|shape| solved(shape, points));
    let best = candidates.min_by(|a, b| a.1.total_cmp(&b.1));
    best.unwrap_or((Parameters::default(), f64::INFINITY))
}

/// Parameters and squared error of the best legal curve of a shape; `None` if its parameters are no finite numbers.
fn solved(shape: Shape, points: &[CurvePoint]) -> Option<(Parameters, f64)> {
    let samples: Vec<(f64, f64)> =
        points.iter().map(|x| (shape.basis(x.sensing_slots), x.accuracy)).collect();
    let (u, v) = project(&samples, shape.ties());
    // v = 0 has no logarithm; 1e-9 is far below any accuracy's last digit
    let v = v.max(1e-9);
    let values = shape.parameters(u, v);
    let error: f64 = samples.iter().map(|(phi, a)| (u + v * phi - a).powi(2)).sum();
    (values.iter().all(|p| p.is_finite()) && error.is_finite())
        .then(|| (shape.model().parameters(&values), error))
}

/// u and v of least squared error with v >= 0 and 0 <= u + v phi <= 1 for all samples: every set of active bounds is tried.
fn project(samples: &[(f64, f64)], ties: Ties) -> (f64, f64) {
    let n = samples.len() as f64;
    let low = samples.iter().map(|s| s.0).fold(f64::INFINITY, f64::min);
    let high = samples.iter().map(|s| s.0).fold(f64::NEG_INFINITY, f64::max);
    let mean = |f: fn(&(f64, f64)) -> f64| samples.iter().map(f).sum::<f64>() / n;
    let (phi, a) = (mean(|s| s.0), mean(|s| s.1));
    // least squares of a - a0 = v (phi - phi0)
    let through = |phi0: f64, a0: f64| {
        let (mut top, mut bottom) = (0.0, 0.0);
        for (phi, a) in samples {
            top += (phi - phi0) * (a - a0);
            bottom += (phi - phi0) * (phi - phi0);
        }
        if bottom > 0.0 { (top / bottom).max(0.0) } else { 0.0 }
    };
    match ties {
        Ties::Offset => ((a - phi).clamp(-low, (1.0 - high).max(-low)), 1.0),
        Ties::Proportional => (0.0, through(0.0, 0.0).min(1.0 / high.max(1e-300))),
        Ties::Free => {
            let slope = through(phi, a);
            let legal = |&(u, v): &(f64, f64)| u + v * low >= -1e-12 && u + v * high <= 1.0 + 1e-12;
            let error =
                |(u, v): (f64, f64)| samples.iter().map(|(p, a)| (u + v * p - a).powi(2)).sum::<f64>();
            let (ceiling, floor) = (through(high, 1.0), through(low, 0.0));
            let both = 1.0 / (high - low).max(1e-300);
            let candidates = [
                (a - slope * phi, slope),
                (a, 0.0),
                (1.0 - ceiling * high, ceiling),
                (-floor * low, floor),
                (-both * low, both),
            ];
            let best = candidates.into_iter().filter(legal).min_by(|&x, &y| error(x).total_cmp(&error(y)));
            best.unwrap_or((a, 0.0))
        }
    }
}

/// Nodes of a grid over the box.
fn grid(across: u32, down: u32) -> Vec<[f64; 2]> {
    let node = |k: u32, n: u32| if n > 1 { f64::from(k) / f64::from(n - 1) } else { 0.0 };
    (0..across).flat_map(|i| (0..down).map(move |j| [node(i, across), node(j, down)])).collect()
}

/// The best of the simplex descents from the eight best nodes.
fn search(error: &dyn Fn([f64; 2]) -> f64, nodes: Vec<[f64; 2]>, dimensions: usize) -> [f64; 2] {
    let mut ranked: Vec<(f64, [f64; 2])> = nodes.into_iter().map(|t| (error(t), t)).collect();
    ranked.sort_by(|a, b| a.0.total_cmp(&b.0));
    // neighbours lead to the same valley: starts are kept apart
    let mut starts: Vec<(f64, [f64; 2])> = Vec::new();
    for candidate in ranked {
        let apart = |s: &(f64, [f64; 2])| (0..2).any(|k| (s.1[k] - candidate.1[k]).abs() > 0.08);
        if starts.len() < 8 && starts.iter().all(apart) {
            starts.push(candidate);
        }
    }
    let ends = starts.into_iter().map(|(_, t)| descend(error, t, dimensions));
    ends.min_by(|a, b| a.0.total_cmp(&b.0)).map_or([0.0; 2], |(_, t)| t)
}

/// Nelder and Mead's simplex (1965) within the box, restarted until nothing is gained.
fn descend(error: &dyn Fn([f64; 2]) -> f64, start: [f64; 2], dimensions: usize) -> (f64, [f64; 2]) {
    let clamp = |t: [f64; 2]| t.map(|t| t.clamp(0.0, 1.0));
    let mut best = (error(start), start);
    for size in [0.03, 0.01, 0.003, 0.001, 0.0003] {
        let mut simplex = vec![best];
        for k in 0..dimensions {
            let mut t = best.1;
            t[k] += if t[k] + size > 1.0 { -size } else { size };
            simplex.push((error(t), t));
        }
        for _ in 0..120 {
            simplex.sort_by(|a, b| a.0.total_cmp(&b.0));
            let worst = simplex[dimensions];
            if worst.0 - simplex[0].0 <= 1e-13 * simplex[0].0 {
                break;
            }
            let mut centre = [0.0; 2];
            for (_, t) in &simplex[..dimensions] {
                (0..2).for_each(|k| centre[k] += t[k] / dimensions as f64);
            }
            let along = |by: f64| {
                let t = clamp([0, 1].map(|k| centre[k] + by * (worst.1[k] - centre[k])));
                (error(t), t)
            };
            let reflected = along(-1.0);
            simplex[dimensions] = if reflected.0 < simplex[0].0 {
                let expanded = along(-2.0);
                if expanded.0 < reflected.0 { expanded } else { reflected }
            } else if reflected.0 < simplex[dimensions - 1].0 {
                reflected
            } else {
                let contracted = along(if reflected.0 < worst.0 { -0.5 } else { 0.5 });
                if contracted.0 < worst.0 {
                    contracted
                } else {
                    let first = simplex[0].1;
                    for vertex in &mut simplex[1..] {
                        let t = [0, 1].map(|k| (vertex.1[k] + first[k]) / 2.0);
                        *vertex = (error(t), t);
                    }
                    continue;
                }
            };
        }
        simplex.sort_by(|a, b| a.0.total_cmp(&b.0));
        best = simplex[0];
    }
    best
}
