//! The Boulic-Thalmann walk: joint positions of one gait cycle for any height and relative velocity.
//!
//! Boulic, Thalmann, Thalmann, "A global human walking model with real-time kinematic personification" (1990), in the
//! form of Chen's micro-Doppler model with its known slips corrected. Angles in degrees, phase t in [0, 1).

pub use super::limbs::{JOINTS, Segments, joint};

use super::limbs::{Turn, along, arm, leg};
use super::number::Real;
use super::{Vec3, add};
use crate::numerics::pchip::Periodic;

/// One person's walk at one relative velocity.
#[derive(Debug, Clone)]
pub struct Gait {
    segments: Segments,
    rv: f64,
    support: f64,
    thorax: Periodic,
    hip: Periodic,
    knee: Periodic,
    ankle: Periodic,
    elbow: Periodic,
}

#[inline(always)]
fn sine<R: Real>(turns: R) -> R {
    turns.sin_cos_turns().0
}

#[inline(always)]
fn cosine<R: Real>(turns: R) -> R {
    turns.sin_cos_turns().1
}

impl Gait {
    /// `rv` is the speed over H_t in 1/s, 0 < rv <= 3; `height` in m.
    pub fn new(height: f64, rv: f64) -> Self {
        let rv = rv.clamp(1e-3, 3.0);
        let cycle = 1.346 / rv.sqrt();
        let ds = (0.752 * cycle - 0.143) / cycle;
        let p = (rv - 0.5) / 0.8;
        let q = (rv - 1.3) / 1.7;
        let (hip, knee, ankle, elbow): (Vec<_>, Vec<_>, Vec<_>, Vec<_>) = if rv < 0.5 {
            (
                vec![(-0.1, 50.0 * rv), (0.5, -30.0 * rv)],
                vec![(0.17, 3.0), (0.4, 3.0), (0.75, 140.0 * rv), (1.0, 3.0)],
                vec![
                    (0.0, -3.0),
                    (0.08, -30.0 * rv - 3.0),
                    (0.5, 22.0 * rv - 3.0),
                    (ds, -34.0 * rv - 3.0),
                    (0.85, -3.0),
                ],
                vec![(0.05, 6.0 * rv + 3.0), (0.5, 34.0 * rv + 3.0), (0.9, 10.0 * rv + 3.0)],
            )
        } else if rv < 1.3 {
            (
                vec![(-0.1, 25.0), (0.5, -15.0)],
                vec![(0.17, 3.0), (0.4, 3.0), (0.75, 70.0), (1.0, 3.0)],
                vec![(0.0, -3.0), (0.08, -18.0), (0.5, 8.0), (ds, -20.0), (0.85, -3.0)],
                vec![(0.05, 6.0 + 8.0 * p), (0.5 + 0.01 * p, 20.0 + 24.0 * p), (0.9, 8.0 + 9.0 * p)],
            )
        } else {
            (
                vec![(-0.1 + 0.2 * q, 25.0 + 5.0 * q), (0.5, -15.0), (0.9, 25.0 + 6.0 * q)],
                vec![
                    (0.17 - 0.05 * q, 3.0 + 22.0 * q),
                    (0.4, 3.0),
                    (0.75 - 0.05 * q, 70.0 - 5.0 * q),
                    (1.0 - 0.03 * q, 3.0 + 3.0 * q),
                ],
                vec![
                    (0.0, -3.0 + 5.0 * q),
                    (0.08, -18.0 + 4.0 * q),
                    (0.5 - 0.1 * q, 8.0 - 3.0 * q),
                    (ds, -20.0 - 8.0 * q),
                    (0.85, -3.0 + 5.0 * q),
                ],
                vec![
                    (0.05, 14.0 - 6.0 * q),
                    (0.51 + 0.04 * q, 44.0 + 26.0 * q),
                    (0.9 - 0.1 * q, 17.0 - 6.0 * q),
                ],
            )
        };
        // at the border of the regimes two hip points coincide modulo 1: one of them is kept
        let hip: Vec<_> = if hip.len() == 3 && q <= 1e-9 { hip[..2].to_vec() } else { hip };
        let thorax =
            [(0.1, 4.0 * rv / 3.0), (0.4, -4.5 * rv / 3.0), (0.6, -4.0 * rv / 3.0), (0.9, 4.5 * rv / 3.0)];
        Gait {
            segments: Segments::of_height(height),
            rv,
            support: ds,
            thorax: Periodic::new(&thorax),
            hip: Periodic::new(&hip),
            knee: Periodic::new(&knee),
            ankle: Periodic::new(&ankle),
            elbow: Periodic::new(&elbow),
        }
    }

    /// Duration of a cycle in s.
    pub fn cycle_s(&self) -> f64 {
        1.346 / self.rv.sqrt()
    }

    /// Segment lengths.
    pub fn segments(&self) -> &Segments {
        &self.segments
    }

    /// Translation of the pelvis at phase `t` in units of H_t (the published figures, which public code takes as m).
    #[inline(always)]
    pub fn translation<R: Real>(&self, t: R) -> Vec3<R> {
        let rv = self.rv;
        let (lateral, forward) = if rv < 0.5 {
            (-0.128 * rv * rv + 0.128 * rv, -0.084 * rv * rv + 0.084 * rv)
        } else {
            (-0.032, -0.021)
        };
        let vertical = 0.015 * rv;
        let phase = 0.625 - self.support;
        [
            sine(t.times(2.0).plus(2.0 * phase)).times(forward),
            sine(t.plus(-0.1)).times(lateral),
            sine(t.times(2.0).plus(-0.35)).times(vertical).plus(-vertical),
        ]
    }

    /// Pelvis roll in degrees.
    #[inline(always)]
    fn roll<R: Real>(&self, t: R) -> R {
        let a = 1.66 * self.rv;
        let [offset, sign, turns] = t.lift(|t| {
            let t = t - t.floor();
            // (offset, sign of the cosine, start of the piece, turns per cycle)
            let (offset, sign, start, turns) = match t {
                t if t < 0.15 => (-a, a, 0.0, 10.0 / 3.0),
                t if t < 0.5 => (-a, -a, 0.15, 10.0 / 7.0),
                t if t < 0.65 => (a, -a, 0.5, 10.0 / 3.0),
                _ => (a, a, 0.65, 10.0 / 7.0),
            };
            ([offset, sign, turns * (t - start)], [0.0, 0.0, turns])
        });
        offset + sign * turns.sin_cos_turns().1
    }

    /// Joint positions at phase `t`, relative to the pelvis centre, in m: x forward, y left, z up.
    #[inline(always)]
    pub fn pose<R: Real>(&self, t: R) -> [Vec3<R>; JOINTS] {
        let s = &self.segments;
        let aside = |width: f64, up: f64| [R::of(0.0), R::of(width), R::of(up)];
        let flex = if self.rv < 0.5 { -8.0 * self.rv * self.rv + 8.0 * self.rv } else { 2.0 };
        let flex = Turn::degrees(sine(t.times(2.0).plus(-0.1)).times(flex).plus(-flex));
        let roll = Turn::degrees(-self.roll(t));
        let swing = cosine(t);
        let torsion = Turn::degrees(swing.times(-4.0 * self.rv));
        let thorax = Turn::degrees(t.on(&self.thorax));
        let upper = |v: Vec3<R>| thorax.yaw(flex.pitch(v));
        let lower = |v: Vec3<R>| torsion.yaw(roll.tilt(v));

        let mut joints = [[R::of(0.0); 3]; JOINTS];
        joints[joint::NECK] = upper(along(s.torso));
        joints[joint::HEAD] = upper(along(s.torso + s.head));
        for (side, sign, phase) in [(0, 1.0, t.plus(0.5)), (1, -1.0, t)] {
            let amplitude = 9.88 * self.rv;
            // half a cycle later the cosine has changed its sign
            let shoulder = Turn::degrees(swing.times(sign * amplitude).plus(3.0 - amplitude / 2.0));
            let elbow = Turn::degrees(phase.on(&self.elbow));
            let root = aside(sign * s.half_shoulder, s.torso);
            let [elbow, hand] = arm(s, shoulder, elbow);
            joints[joint::SHOULDER + side] = upper(root);
            joints[joint::ELBOW + side] = upper(add(elbow, root));
            joints[joint::HAND + side] = upper(add(hand, root));

            let hip = Turn::degrees(phase.on(&self.hip));
            let knee = Turn::degrees(-phase.on(&self.knee));
            let ankle = Turn::degrees(phase.on(&self.ankle));
            let root = aside(sign * s.half_hip, 0.0);
            let [knee, ankle, toe] = leg(s, hip, knee, ankle);
            joints[joint::HIP + side] = lower(root);
            joints[joint::KNEE + side] = lower(add(knee, root));
            joints[joint::ANKLE + side] = lower(add(ankle, root));
            joints[joint::TOE + side] = lower(add(toe, root));
        }
        joints
    }
}

#[cfg(test)]
mod tests {
    use super::super::{norm, sub};
    use super::joint::*;
    use super::*;

    /// (joint, position at t = 0, .25, .5, .75) of the right side for H = 1.75.
    type Row = (usize, [Vec3; 4]);

    fn check(rv: f64, rows: &[Row], translations: Option<&[Vec3; 4]>) {
        let gait = Gait::new(1.75, rv);
        for (index, t) in [0.0, 0.25, 0.5, 0.75].into_iter().enumerate() {
            let pose = gait.pose(t);
            for (joint, expected) in rows {
                let error = norm(sub(pose[*joint], expected[index]));
                assert!(
                    error < 1e-4,
                    "RV {rv} joint {joint} t {t}: {:?} {:?}",
                    pose[*joint],
                    expected[index]
                );
            }
            if let Some(translations) = translations {
                let error = norm(sub(gait.translation(t), translations[index]));
                assert!(error < 2e-5, "RV {rv} t {t}: {:?}", gait.translation(t));
            }
        }
    }

    #[test]
    fn golden_positions_at_walking_speed() {
        let rows: [Row; 9] = [
            (
                HEAD,
                [
                    [0.0405, -0.0010, 0.7304],
                    [0.0105, 0.0, 0.7314],
                    [0.0405, 0.0010, 0.7304],
                    [0.0105, 0.0, 0.7314],
                ],
            ),
            (
                NECK,
                [
                    [0.0279, -0.0007, 0.5032],
                    [0.0073, 0.0, 0.5039],
                    [0.0279, 0.0007, 0.5032],
                    [0.0073, 0.0, 0.5039],
                ],
            ),
            (
                SHOULDER + 1,
                [
                    [0.0222, -0.2273, 0.5032],
                    [0.0078, -0.2266, 0.5039],
                    [0.0337, -0.2258, 0.5032],
                    [0.0067, -0.2266, 0.5039],
                ],
            ),
            (
                ELBOW + 1,
                [
                    [-0.0629, -0.2251, 0.1854],
                    [-0.0081, -0.2266, 0.1753],
                    [0.0610, -0.2252, 0.1754],
                    [-0.0092, -0.2266, 0.1753],
                ],
            ),
            (
                HAND + 1,
                [
                    [-0.0796, -0.2247, -0.0800],
                    [0.0742, -0.2264, -0.0776],
                    [0.2310, -0.2208, -0.0291],
                    [0.0784, -0.2268, -0.0758],
                ],
            ),
            (
                HIP + 1,
                [
                    [0.0117, -0.1667, 0.0],
                    [0.0, -0.1669, 0.0079],
                    [-0.0117, -0.1667, 0.0],
                    [0.0, -0.1669, -0.0079],
                ],
            ),
            (
                KNEE + 1,
                [
                    [0.1721, -0.1555, -0.3974],
                    [0.0003, -0.1871, -0.4204],
                    [-0.1224, -0.1590, -0.4141],
                    [0.0917, -0.1472, -0.4262],
                ],
            ),
            (
                ANKLE + 1,
                [
                    [0.3122, -0.1457, -0.8044],
                    [-0.0218, -0.2073, -0.8499],
                    [-0.3454, -0.1434, -0.7821],
                    [-0.2721, -0.1364, -0.6563],
                ],
            ),
            (
                TOE + 1,
                [
                    [0.5521, -0.1289, -0.7352],
                    [0.2233, -0.2097, -0.9002],
                    [-0.1160, -0.1594, -0.8810],
                    [-0.1819, -0.1254, -0.8895],
                ],
            ),
        ];
        let translations = [
            [0.00542, 0.01881, -0.02714],
            [-0.00542, -0.02589, -0.00286],
            [0.00542, -0.01881, -0.02714],
            [-0.00542, 0.02589, -0.00286],
        ];
        check(1.0, &rows, Some(&translations));
    }

    #[test]
    fn golden_positions_at_slow_and_fast_walks() {
        let slow: [Row; 2] = [
            (
                KNEE + 1,
                [
                    [0.1345, -0.1634, -0.4086],
                    [0.0003, -0.1752, -0.4255],
                    [-0.0938, -0.1646, -0.4194],
                    [0.0735, -0.1591, -0.4255],
                ],
            ),
            (
                TOE + 1,
                [
                    [0.4882, -0.1536, -0.7747],
                    [0.2241, -0.1841, -0.9010],
                    [-0.0436, -0.1660, -0.8923],
                    [-0.1043, -0.1495, -0.9361],
                ],
            ),
        ];
        let translations = [
            [-0.01376, -0.01806, -0.01085],
            [0.01376, 0.02485, -0.00115],
            [-0.01376, 0.01806, -0.01085],
            [0.01376, -0.02485, -0.00115],
        ];
        check(0.4, &slow, Some(&translations));
        let fast: [Row; 3] = [
            (
                KNEE + 1,
                [
                    [0.1920, -0.1466, -0.3916],
                    [0.0111, -0.1989, -0.4148],
                    [-0.1289, -0.1537, -0.4141],
                    [0.0969, -0.1353, -0.4290],
                ],
            ),
            (
                TOE + 1,
                [
                    [0.5777, -0.1034, -0.7161],
                    [0.2245, -0.2351, -0.8946],
                    [-0.1295, -0.1536, -0.8884],
                    [-0.1557, -0.0999, -0.8974],
                ],
            ),
            (
                HAND + 1,
                [
                    [-0.1633, -0.2202, -0.0591],
                    [0.0716, -0.2264, -0.0714],
                    [0.3021, -0.2145, 0.0292],
                    [0.0708, -0.2269, -0.0710],
                ],
            ),
        ];
        check(1.6, &fast, None); // no translations are tabulated at this speed
    }

    #[test]
    fn limbs_keep_their_lengths_and_sides_mirror() {
        for rv in [0.3, 0.8, 1.3, 2.2, 3.0] {
            let gait = Gait::new(1.7, rv);
            let s = *gait.segments();
            for step in 0..100 {
                let t = f64::from(step) / 100.0;
                let (now, later) = (gait.pose(t), gait.pose(t + 0.5));
                for (a, b, length) in [
                    (SHOULDER, ELBOW, s.upper_arm),
                    (ELBOW, HAND, s.lower_arm),
                    (HIP, KNEE, s.thigh),
                    (KNEE, ANKLE, s.shank),
                    (ANKLE, TOE, s.foot),
                ] {
                    for side in 0..2 {
                        let found = norm(sub(now[a + side], now[b + side]));
                        assert!((found - length).abs() < 1e-9);
                    }
                }
                for left in [SHOULDER, ELBOW, HAND, HIP, KNEE, ANKLE, TOE] {
                    let [x, y, z] = later[left + 1];
                    assert!(norm(sub(now[left], [x, -y, z])) < 1e-9, "rv {rv} t {t} joint {left}");
                }
            }
        }
    }
}
