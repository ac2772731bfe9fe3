//! People in the way of waves: a body as a screen that diffracts around its four edges.
//!
//! 3GPP TR 38.901 clause 7.6.4.2 (blockage model B): amplitude 1 - (F_h1 + F_h2)(F_w1 + F_w2) with F = atan(+-pi/2 sqrt(pi/lambda
//! (D1 + D2 - r))) / pi for each edge, D1 and D2 its distances from the ends of the path and r the path's length, seen from the side
//! (h) and from above (w). The screen is as wide and as high as a human blocker of Table 7.6.4.2-5, 0.3 m by 1.7 m, scaled with the
//! height of the body.

use super::Scene;
use super::target::Target;
use crate::numerics::atan::atan;
use crate::numerics::vectors::vectorised;
use crate::scenario::Furniture;
use crate::simulator::body::gait::joint;
use crate::simulator::body::number::LANES;
use crate::simulator::body::primitives::{PRIMITIVES, Primitive};
use crate::simulator::body::{Vec3, add, scale, sub};
use std::f64::consts::{FRAC_PI_2, PI};

/// A screen that stands upright across a path.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Screen {
    /// Where it stands in m.
    pub place: [f64; 2],
    /// Its lower and upper edge in m.
    pub heights: [f64; 2],
    /// Its width in m.
    pub width: f64,
}

/// A path's straight leg between two points.
pub type Leg = (Vec3, Vec3);

/// Where a leg passes a screen, in m.
#[derive(Debug, Clone, Copy)]
pub struct Crossing {
    /// Length of the leg seen from above.
    pub leg_m: f64,
    /// How far along it the screen stands.
    pub at: f64,
    /// The edges of its width, across the leg.
    pub across: [f64; 2],
    /// Cosine of the leg's elevation.
    pub tilt: f64,
    /// Its lower and upper edge over the leg, at right angles to it.
    pub heights: [f64; 2],
}

#[inline(always)]
fn length([x, y]: [f64; 2]) -> f64 {
    (x * x + y * y).sqrt()
}

/// F of the edges of one view of N legs: their lengths, how far along them the edges are, and the lower and upper edge across them.
#[inline(always)]
fn edges<const N: usize>(leg_m: &[f64; N], at: &[f64; N], across: [&[f64; N]; 2], lambda: f64) -> [f64; N] {
    let mut tangents = [[0.0; N]; 2];
    for (tangents, across) in tangents.iter_mut().zip(across) {
        for n in 0..N {
            let edge = across[n];
            let excess = length([at[n], edge]) + length([leg_m[n] - at[n], edge]) - leg_m[n];
            tangents[n] = FRAC_PI_2 * (PI / lambda * excess.max(0.0)).sqrt();
        }
    }
    let [low, high] = [atan(&tangents[0]), atan(&tangents[1])];
    let mut sums = [0.0; N];
    for n in 0..N {
        let (low, high) = (low[n] / PI, high[n] / PI);
        // a leg that passes beside the screen: the nearer edge counts against the farther
        let upper = if across[1][n] >= 0.0 { low + high } else { low - high };
        sums[n] = if across[0][n] <= 0.0 { upper } else { high - low };
    }
    sums
}

impl Screen {
    /// A piece of furniture's; `None` for a piece without a size.
    pub fn furniture(piece: &Furniture) -> Option<Self> {
        let ([x, y, z], [width, height]) = (piece.centre_m, piece.size_m?);
        Some(Screen { place: [x, y], heights: [z - height / 2.0, z + height / 2.0], width })
    }

    /// A person's at `t` seconds.
    pub fn of(person: &Target, t: f64) -> Self {
        let height = person.person.truth.height_m;
        let base = |t: f64| person.person.joints(t)[joint::BASE];
        let [x, y, _] = person.rigid.map_or_else(|| base(t), |velocity| add(base(0.0), scale(velocity, t)));
        Screen { place: [x, y], heights: [0.0, height], width: 0.3 / 1.7 * height }
    }

    /// Where a leg passes the screen; `None` where the screen does not stand beside it, or one of the leg's ends is the screen's place.
    pub fn crossing(&self, leg: Leg) -> Option<Crossing> {
        let (crosses, crossing) = self.beside(leg);
        crosses.then_some(crossing)
    }

    /// Whether the screen stands beside the leg, and where the leg passes it if so.
    #[inline(always)]
    fn beside(&self, (a, b): Leg) -> (bool, Crossing) {
        let [dx, dy, dz] = sub(b, a);
        let leg_m = length([dx, dy]);
        let (ex, ey) = (dx / leg_m, dy / leg_m);
        let (px, py) = (self.place[0] - a[0], self.place[1] - a[1]);
        let at = px * ex + py * ey;
        let crosses = (leg_m >= 1e-3) & (at >= 1e-6) & (at <= leg_m - 1e-6);
        let across = py * ex - px * ey;
        // from the side: heights over the leg where it passes, at right angles to it
        let slope = dz / leg_m;
        let tilt = 1.0 / (1.0 + slope * slope).sqrt();
        let passing = a[2] + slope * at;
        let crossing = Crossing {
            leg_m,
            at,
            across: [across - self.width / 2.0, across + self.width / 2.0],
            tilt,
            heights: [(self.heights[0] - passing) * tilt, (self.heights[1] - passing) * tilt],
        };
        (crosses, crossing)
    }

    /// Amplitudes that N legs keep, and how far behind the screen they end in m; 1 and 0 where the screen does not stand beside a leg.
    #[inline(always)]
    fn passed<const N: usize>(&self, legs: &[Leg; N], lambda: f64) -> [(f64, f64); N] {
        vectorised(
            #[inline(always)]
            || {
                let [mut leg_m, mut at, mut left, mut right] = [[0.0; N]; 4];
                let [mut slant_m, mut slant_at, mut low, mut high] = [[0.0; N]; 4];
                let mut crosses = [false; N];
                for n in 0..N {
                    let (crossed, c) = self.beside(legs[n]);
                    crosses[n] = crossed;
                    (leg_m[n], at[n], left[n], right[n]) = (c.leg_m, c.at, c.across[0], c.across[1]);
                    (slant_m[n], slant_at[n]) = (c.leg_m / c.tilt, c.at / c.tilt);
                    (low[n], high[n]) = (c.heights[0], c.heights[1]);
                }
                let wide = edges(&leg_m, &at, [&left, &right], lambda);
                let high = edges(&slant_m, &slant_at, [&low, &high], lambda);
                let mut passed = [(1.0, 0.0); N];
                for n in 0..N {
                    if crosses[n] {
                        passed[n] = ((1.0 - wide[n] * high[n]).clamp(0.0, 1.0), leg_m[n] - at[n]);
                    }
                }
                passed
            },
        )
    }

    /// Amplitude that a leg keeps.
    pub fn transmission(&self, leg: Leg, lambda: f64) -> f64 {
        self.passed(&[leg], lambda)[0].0
    }
}

/// Amplitude that a path of several legs keeps behind everybody.
pub fn transmission(screens: &[Screen], legs: &[Leg], lambda: f64) -> f64 {
    transmissions(screens, [legs].into_iter(), lambda)[0]
}

/// Amplitude that each of several paths keeps behind everybody.
pub fn transmissions<'a>(
    screens: &[Screen],
    paths: impl Iterator<Item = &'a [Leg]> + Clone,
    lambda: f64,
) -> Vec<f64> {
    let legs: Vec<Leg> = paths.clone().flatten().copied().collect();
    let mut kept = vec![1.0; legs.len()];
    for (legs, kept) in legs.chunks(LANES).zip(kept.chunks_mut(LANES)) {
        let legs: [Leg; LANES] = std::array::from_fn(|n| legs[n.min(legs.len() - 1)]);
        for screen in screens {
            let passed = screen.passed(&legs, lambda);
            kept.iter_mut().zip(passed).for_each(|(kept, (passed, _))| *kept *= passed);
        }
    }
    let mut kept = kept.into_iter();
    paths.map(|legs| kept.by_ref().take(legs.len()).product()).collect()
}

/// Amplitudes of a person's primitives behind its own torso, there and back.
pub fn own_torso(scene: &Scene, person: &Target, t: f64, lambda: f64) -> [f64; PRIMITIVES] {
    let primitives = person.primitives(t);
    let there = behind_torso(scene.from, &primitives, lambda);
    let back = if scene.monostatic() { there } else { behind_torso(scene.to, &primitives, lambda) };
    std::array::from_fn(|k| there[k] * back[k])
}

/// Amplitudes of a person's primitives behind its own torso, one way, seen from `end`.
///
/// The torso is a screen of its own girth. A primitive within the torso's radius behind its axis goes over from seen to hidden.
pub fn behind_torso(end: Vec3, primitives: &[Primitive; PRIMITIVES], lambda: f64) -> [f64; PRIMITIVES] {
    let torso = &primitives[1];
    let [radius, half] = torso.semi;
    let [x, y, z] = torso.centre;
    let screen = Screen { place: [x, y], heights: [z - half, z + half], width: 2.0 * radius };
    let passed = screen.passed(&primitives.map(|primitive| (end, primitive.centre)), lambda);
    let mut amplitudes = passed.map(|(kept, behind)| {
        let s = (behind / radius).clamp(0.0, 1.0);
        1.0 - (1.0 - kept) * s * s * (3.0 - 2.0 * s)
    });
    // head and torso
    amplitudes[..2].fill(1.0);
    amplitudes
}

/// Amplitude of a person's echo behind the others, there and back.
pub fn others(scene: &Scene, screens: &[Screen], person: usize, t: f64, lambda: f64) -> f64 {
    let centre = scene.people[person].centre(t);
    let mut kept = 1.0;
    for (_, screen) in screens.iter().enumerate().filter(|(other, _)| *other != person) {
        kept *= screen.transmission((scene.from, centre), lambda)
            * screen.transmission((scene.to, centre), lambda);
    }
    kept
}

/// The point at a share of the path between two points.
pub fn between(a: Vec3, b: Vec3, share: f64) -> Vec3 {
    add(a, scale(sub(b, a), share))
}

#[cfg(test)]
mod tests {
    use super::*;

    const LEG: Leg = ([0.0, 0.0, 1.0], [6.0, 0.0, 1.0]);

    fn screen(y: f64) -> Screen {
        Screen { place: [3.0, y], heights: [0.0, 1.7], width: 0.3 }
    }

    fn db(y: f64, lambda: f64) -> f64 {
        20.0 * libm::log10(screen(y).transmission(LEG, lambda))
    }

    #[test]
    fn a_body_in_the_way_costs_what_the_formula_says() {
        // by hand at 60 GHz: the width's edges 0.15 m off the middle of 6 m: D1 + D2 - r = 2 sqrt(9 + 0.0225) - 6 = 7.495 mm,
        // atan(pi/2 sqrt(pi / 4.997 mm * 7.495 mm)) / pi = 0.4096; heights 1 m below and 0.7 m above: 0.4847 and 0.4782
        let expected = 1.0 - (0.4847 + 0.4782) * (2.0 * 0.4096);
        let found = screen(0.0).transmission(LEG, 4.996_5e-3);
        assert!((found - expected).abs() < 2e-3, "{found} {expected}");
        assert!((-14.5..-12.5).contains(&db(0.0, 5e-3)), "{}", db(0.0, 5e-3));
        // less at 3.5 GHz, where the wave bends around
        assert!((-7.0..-4.0).contains(&db(0.0, 0.0857)), "{}", db(0.0, 0.0857));
    }

    #[test]
    fn shadows_have_edges_of_six_decibels_and_end() {
        // at the edge of a screen much wider than the Fresnel zone half of the field is left
        let wide = Screen { place: [3.0, -50.0], heights: [-50.0, 50.0], width: 100.0 };
        assert!((20.0 * libm::log10(wide.transmission(LEG, 5e-3)) + 6.0).abs() < 0.2);
        assert!(db(1.5, 5e-3).abs() < 0.2 && db(1.5, 0.0857).abs() < 0.7);
        // behind the receiver, and at its back, there is nothing in the way
        let away = Screen { place: [7.0, 0.0], ..screen(0.0) };
        assert_eq!(away.transmission(LEG, 5e-3), 1.0);
        // a step aside changes little: no jumps
        let mut last = db(0.0, 5e-3);
        for k in 1..2000 {
            let now = db(f64::from(k) * 1e-3, 5e-3);
            assert!((now - last).abs() < 0.3, "{k} mm: {last} {now}");
            last = now;
        }
    }
}
