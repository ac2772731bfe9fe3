//! Where a person goes: straight legs joined by arcs, so that a turn is walked and not jumped.
//!
//! Arc length is the parameter; position and heading are continuous, the heading's rate is speed over radius. Two ways to
//! draw one: bounce off the walls of a room, or pass through way points.

use super::number::Real;
use std::f64::consts::{PI, TAU};

/// Radius of a turn in m; smaller where there is no room for it.
const RADIUS_M: f64 = 0.25;
/// Smallest radius: a turn on the spot.
const PIVOT_M: f64 = 0.05;

/// From `start` metres on: a point, a heading in rad, a curvature in 1/m (0: straight).
#[derive(Debug, Clone, Copy, PartialEq)]
struct Leg {
    start: f64,
    from: [f64; 2],
    heading: f64,
    /// cos and sin of it.
    direction: [f64; 2],
    curvature: f64,
}

impl Leg {
    fn new(start: f64, from: [f64; 2], heading: f64, curvature: f64) -> Self {
        let direction = [libm::cos(heading), libm::sin(heading)];
        Leg { start, from, heading, direction, curvature }
    }

    /// x, y, cos and sin of the heading, `s` metres into the leg, and their slopes.
    #[inline(always)]
    fn at(&self, s: f64) -> ([f64; 4], [f64; 4]) {
        let ([x, y], [c0, s0], k) = (self.from, self.direction, self.curvature);
        if k == 0.0 {
            return ([x + s * c0, y + s * s0, c0, s0], [c0, s0, 0.0, 0.0]);
        }
        let heading = self.heading + k * s;
        let (sine, cosine) = (libm::sin(heading), libm::cos(heading));
        let place = [x + (sine - s0) / k, y - (cosine - c0) / k, cosine, sine];
        (place, [cosine, sine, -k * sine, k * cosine])
    }
}

/// A path on the ground, walked at a constant speed.
#[derive(Debug, Clone)]
pub struct Trajectory {
    legs: Vec<Leg>,
    speed: f64,
}

/// The path under construction.
struct Drawing {
    legs: Vec<Leg>,
    s: f64,
    at: [f64; 2],
    heading: f64,
}

impl Drawing {
    fn new(at: [f64; 2], heading: f64) -> Self {
        Drawing { legs: Vec::new(), s: 0.0, at, heading }
    }

    /// Goes on for `length` metres.
    fn go(&mut self, length: f64, curvature: f64) {
        let leg = Leg::new(self.s, self.at, self.heading, curvature);
        let ([x, y, ..], _) = leg.at(length);
        self.legs.push(leg);
        self.s += length;
        self.at = [x, y];
        self.heading += curvature * length;
    }

    /// Turns by `angle` rad (left is positive).
    fn turn(&mut self, angle: f64, radius: f64) {
        if angle != 0.0 {
            self.go(angle.abs() * radius, angle.signum() / radius);
        }
    }
}

impl Trajectory {
    /// Stays at `at`, looking along `heading` (rad, counter-clockwise from x).
    pub fn standing(at: [f64; 2], heading: f64) -> Self {
        Trajectory { legs: vec![Leg::new(0.0, at, heading, 0.0)], speed: 0.0 }
    }

    /// Walks at `speed` m/s for `duration` s and turns before the borders `[low, high]` of x and y, as a billiard ball
    /// would but along arcs. With `turns` false it walks straight on.
    pub fn bouncing(
        at: [f64; 2],
        heading: f64,
        speed: f64,
        duration: f64,
        borders: [[f64; 2]; 2],
        turns: bool,
    ) -> Self {
        let mut drawing = Drawing::new(at, heading);
        let length = speed * duration;
        // a leg between two turns is at least a pivot long, so their number is bounded
        while turns && drawing.s < length && drawing.legs.len() < 10_000 {
            let direction = [libm::cos(drawing.heading), libm::sin(drawing.heading)];
            // the border met first, and how far straight on the turn before it begins
            let (mut nearest, mut axis_met) = (f64::INFINITY, 0);
            for axis in 0..2 {
                let d = direction[axis];
                if d.abs() < 1e-9 {
                    continue;
                }
                let bulge = RADIUS_M * (1.0 - direction[1 - axis].abs());
                let room = if d > 0.0 {
                    borders[axis][1] - drawing.at[axis]
                } else {
                    drawing.at[axis] - borders[axis][0]
                };
                let distance = (room - bulge) / d.abs();
                if distance < nearest {
                    (nearest, axis_met) = (distance, axis);
                }
            }
            if drawing.s + nearest >= length {
                break;
            }
            if nearest > 0.0 {
                drawing.go(nearest, 0.0);
            }
            // mirror the heading at that border, turning away from it; the arc carries 2 R cos along it, onwards, and from a
            // head-on meeting to where there is more room
            let other = 1 - axis_met;
            let (met, along) = (direction[axis_met], direction[other]);
            let rooms = [drawing.at[other] - borders[other][0], borders[other][1] - drawing.at[other]];
            let onwards = if along.abs() > 1e-6 { along > 0.0 } else { rooms[1] > rooms[0] };
            let most = if nearest >= 0.0 { RADIUS_M } else { PIVOT_M };
            let radius = (rooms[usize::from(onwards)] / (2.0 * met.abs()).max(1e-9)).clamp(PIVOT_M, most);
            let left = (met > 0.0) == onwards;
            let side = if left == (axis_met == 0) { 1.0 } else { -1.0 };
            drawing.turn(side * (PI - 2.0 * libm::acos(met.abs().min(1.0))), radius);
        }
        drawing.go(f64::INFINITY.min(length + 1.0), 0.0);
        Trajectory { legs: drawing.legs, speed }
    }

    /// Walks at `speed` m/s through way points: straight to each, then an arc towards the next; straight on at the end.
    /// Fewer than two points: stands.
    pub fn through(points: &[[f64; 2]], speed: f64) -> Self {
        let [first, second, rest @ ..] = points else {
            return Self::standing(points.first().copied().unwrap_or([0.0; 2]), 0.0);
        };
        let bearing = |a: [f64; 2], b: [f64; 2]| libm::atan2(b[1] - a[1], b[0] - a[0]);
        let mut drawing = Drawing::new(*first, bearing(*first, *second));
        drawing.go(distance(*first, *second), 0.0);
        for &next in rest {
            let radius = RADIUS_M.min(distance(drawing.at, next) / 4.0);
            if radius <= 0.0 {
                continue;
            }
            let left = tangent(drawing.at, drawing.heading, next, radius, 1.0);
            let right = tangent(drawing.at, drawing.heading, next, radius, -1.0);
            drawing.turn(if left.abs() <= right.abs() { left } else { right }, radius);
            drawing.go(distance(drawing.at, next), 0.0);
        }
        drawing.go(1e6, 0.0);
        Trajectory { legs: drawing.legs, speed }
    }

    /// x, y in m, cos and sin of the heading at time `t` in s.
    #[inline(always)]
    pub fn at<R: Real>(&self, t: R) -> [R; 4] {
        t.lift(|t| {
            let s = self.speed * t.max(0.0);
            let leg = self.legs[self.legs.partition_point(|leg| leg.start <= s).max(1) - 1];
            let (values, slopes) = leg.at(s - leg.start);
            (values, slopes.map(|slope| slope * self.speed))
        })
    }
}

fn distance(a: [f64; 2], b: [f64; 2]) -> f64 {
    libm::hypot(b[0] - a[0], b[1] - a[1])
}

/// How far to turn (left positive) on a circle of `radius` until the heading points at `to`; `side` 1 left, -1 right.
fn tangent(at: [f64; 2], heading: f64, to: [f64; 2], radius: f64, side: f64) -> f64 {
    let normal = heading + side * PI / 2.0;
    let centre = [at[0] + radius * libm::cos(normal), at[1] + radius * libm::sin(normal)];
    let away = distance(centre, to);
    let straight = (away * away - radius * radius).max(0.0).sqrt();
    let target = libm::atan2(to[1] - centre[1], to[0] - centre[0]) + side * libm::atan2(radius, straight);
    let turn = side * (target - heading);
    // rounding must not make a full circle of no turn
    let turn = turn - TAU * (turn / TAU).floor();
    side * if turn > TAU - 1e-9 { 0.0 } else { turn }
}

#[cfg(test)]
mod tests {
    use super::super::number::Dual;
    use super::*;

    fn smooth(path: &Trajectory, speed: f64, seconds: f64) {
        let dt = 1e-3;
        for step in 0..(seconds / dt) as u32 {
            let t = f64::from(step) * dt;
            let [x, y, c, s] = path.at(Dual::variable(t));
            let [x1, y1, ..] = path.at(t + dt);
            assert!((c.value * c.value + s.value * s.value - 1.0).abs() < 1e-12);
            // the velocity is the speed along the heading, and no step is longer
            assert!((x.rate - speed * c.value).abs() < 1e-12 && (y.rate - speed * s.value).abs() < 1e-12);
            assert!(distance([x.value, y.value], [x1, y1]) <= speed * dt * (1.0 + 1e-9), "{t}");
        }
    }

    #[test]
    fn nobody_walks_through_a_wall() {
        let borders = [[0.3, 2.7], [0.4, 4.1]];
        for n in 0..40 {
            let heading = 0.37 + f64::from(n);
            let path = Trajectory::bouncing([1.0, 2.0], heading, 0.9, 40.0, borders, true);
            smooth(&path, 0.9, 40.0);
            for step in 0..4000 {
                let [x, y, ..] = path.at(f64::from(step) * 0.01);
                assert!((0.15..=2.85).contains(&x) && (0.25..=4.25).contains(&y), "{heading}: {x} {y}");
            }
        }
    }

    #[test]
    fn way_points_are_met_in_their_order() {
        let points = [[0.5, 0.5], [2.5, 0.5], [2.5, 4.0], [0.5, 4.0], [2.4, 3.9], [0.5, 4.0]];
        let path = Trajectory::through(&points, 0.8);
        smooth(&path, 0.8, 15.0);
        let mut next = 0;
        for step in 0..40_000 {
            let [x, y, ..] = path.at(f64::from(step) * 0.5e-3);
            if next < points.len() && distance([x, y], points[next]) < 1e-3 {
                next += 1;
            }
        }
        assert_eq!(next, points.len());
    }
}
