//! Segments, floor, room and speeds of the motions, over many people.

use super::super::gait::Gait;
use super::super::motion::Person;
use super::super::{norm, sub};
use super::*;
use crate::scenario::Scenario;
use joint::*;

const CLASSES: [Class; 6] =
    [Class::SittingDown, Class::StandingUp, Class::Falling, Class::Bending, Class::Waving, Class::Jumping];
const PEOPLE: u64 = 60;

/// The motion of a person of 1.6 to 1.9 m.
fn drawn(class: Class, index: u64) -> (Activity, f64) {
    let height = 1.6 + 0.3 * index as f64 / PEOPLE as f64;
    let segments = *Gait::new(height, 1.0).segments();
    let random = &mut Random::new(3, 0, class as u64, index);
    (Activity::draw(class, height, &segments, random).unwrap(), height)
}

/// Positions and velocities.
fn kinematics(activity: &Activity, t: f64) -> [(Vec3, Vec3); JOINTS] {
    activity.joints(Dual::variable(t)).map(|p| (p.map(|x| x.value), p.map(|x| x.rate)))
}

fn times(seconds: f64) -> impl Iterator<Item = f64> {
    (0..(seconds * 500.0) as u32).map(|k| f64::from(k) * 2e-3)
}

fn greatest(values: impl Iterator<Item = f64>) -> f64 {
    values.fold(f64::NEG_INFINITY, f64::max)
}

/// Everybody's speeds, or heights: `(smallest, largest)` of a number a person.
fn range(class: Class, of: impl Fn(&Activity, f64) -> f64) -> (f64, f64) {
    let found: Vec<f64> = (0..PEOPLE).map(|k| drawn(class, k)).map(|(a, height)| of(&a, height)).collect();
    (-greatest(found.iter().map(|x| -x)), greatest(found.into_iter()))
}

fn within(found: (f64, f64), low: f64, high: f64) {
    println!("{found:?} within {low} to {high}");
    assert!(low <= found.0 && found.1 <= high, "{found:?}");
}

#[test]
fn segments_are_rigid() {
    for class in CLASSES {
        for index in 0..PEOPLE {
            let (activity, _) = drawn(class, index);
            let s = activity.segments;
            let mut segments = vec![(BASE, NECK, s.torso), (NECK, HEAD, s.head)];
            for side in 0..2 {
                segments.extend([
                    (NECK, SHOULDER + side, s.half_shoulder),
                    (SHOULDER + side, ELBOW + side, s.upper_arm),
                    (ELBOW + side, HAND + side, s.lower_arm),
                    (BASE, HIP + side, s.half_hip),
                    (HIP + side, KNEE + side, s.thigh),
                    (KNEE + side, ANKLE + side, s.shank),
                    (ANKLE + side, TOE + side, s.foot),
                ]);
            }
            for joints in times(4.0).step_by(20).map(|t| activity.joints(t)) {
                for &(a, b, length) in &segments {
                    let error = norm(sub(joints[a], joints[b])) - length;
                    assert!(error.abs() < 1e-9, "{class:?} {index}: {a} to {b}: {error}");
                }
            }
        }
    }
}

#[test]
fn nobody_goes_through_the_floor_or_faster_than_eight_metres_a_second() {
    for class in CLASSES {
        let joints = |a: &Activity| times(4.0).flat_map(|t| kinematics(a, t)).collect::<Vec<_>>();
        let low = range(class, |a, _| -greatest(joints(a).iter().map(|(p, _)| -p[2])));
        let fast = range(class, |a, _| greatest(joints(a).iter().map(|(_, v)| norm(*v))));
        println!("{class:?}: lowest {low:?} m, fastest {fast:?} m/s");
        assert!(low.0 > 0.0 && fast.0 > 0.5 && fast.1 < 8.0, "{class:?}: {low:?} {fast:?}");
    }
}

#[test]
fn velocities_do_not_jump() {
    for class in CLASSES {
        let worst = range(class, |a, _| {
            let mut last = kinematics(a, 0.0);
            greatest(times(4.0).skip(1).map(|t| {
                let now = kinematics(a, t);
                let change = |j: usize| norm(sub(now[j].1, last[j].1));
                let most = greatest((0..JOINTS).map(change));
                last = now;
                most / 2e-3
            }))
        });
        println!("{class:?}: greatest acceleration {worst:?} m/s^2");
        assert!(worst.1 < 400.0, "{class:?}: {worst:?}");
    }
}

#[test]
fn nobody_leaves_the_room() {
    let mut scenario = Scenario::default();
    let (room, radar) = (scenario.room.size_m, scenario.radar.position_m);
    scenario.target.heading_spread_deg = 180.0;
    for class in CLASSES {
        for index in 0..PEOPLE {
            let random = &mut Random::new(5, 0, class as u64, index);
            scenario.target.start_m = [random.uniform() * room[0], random.uniform() * room[1]];
            let person = Person::draw(class, &scenario.target, room, radar, random);
            for joints in times(4.0).step_by(10).map(|t| person.joints(t)) {
                let inside = |p: &Vec3| (0..3).all(|axis| (-0.01..=room[axis]).contains(&p[axis]));
                assert!(joints.iter().all(inside), "{class:?} {index}: {joints:?}");
            }
        }
    }
}

#[test]
fn sitting_down_ends_as_standing_up_begins() {
    for index in 0..PEOPLE {
        let (up, height) = drawn(Class::StandingUp, index);
        let Kind::Rise(rise) = &up.kind else { panic!("{up:?}") };
        let down = Activity { kind: Kind::Rise(Rise { up: false, ..rise.clone() }), ..up.clone() };
        for (a, b) in [(-5.0, 5.0), (5.0, -5.0)] {
            let pairs = up.joints(a).into_iter().zip(down.joints(b));
            assert!(pairs.into_iter().all(|(a, b)| norm(sub(a, b)) < 1e-12));
        }
        // hips are as high above the seat as stated, and in standing those of the gait within 1 cm
        let [seated, standing] = [-5.0, 5.0].map(|t| up.joints(t)[HIP][2]);
        let seat = seated - HIPS_ABOVE_SEAT * height;
        assert!((0.42..=0.50).contains(&seat), "{seat}");
        assert!((standing - 0.53 * height).abs() < 0.01, "{standing}");
    }
}

#[test]
fn who_stands_up_takes_one_and_a_half_to_three_seconds() {
    let lean = |a: &Activity, t: f64| {
        let joints = a.joints(t);
        let [x, _, z] = sub(joints[NECK], joints[BASE]);
        libm::atan2(x, z) * 180.0 / PI
    };
    within(range(Class::StandingUp, |a, _| greatest(times(4.0).map(|t| lean(a, t - 1.5)))), 30.0, 45.0);
    let moving = |a: &Activity| {
        let fast = |t: &f64| greatest(kinematics(a, *t).iter().map(|(_, v)| norm(*v))) > 0.02;
        times(8.0).map(|t| t - 4.0).filter(fast).count() as f64 * 2e-3
    };
    within(range(Class::StandingUp, |a, _| moving(a)), 1.3, 3.0);
    within(range(Class::SittingDown, |a, _| moving(a)), 1.3, 3.0);
    let rising = |a: &Activity| greatest(times(4.0).map(|t| kinematics(a, t - 1.5)[BASE].1[2]));
    within(range(Class::StandingUp, |a, _| rising(a)), 0.25, 1.1);
}

#[test]
fn who_falls_meets_the_floor_as_fast_as_measured_and_lies_still() {
    let fall = |a: &Activity| match &a.kind {
        Kind::Fall(fall) => fall.clone(),
        _ => panic!("{a:?}"),
    };
    let sides: std::collections::BTreeSet<_> =
        (0..PEOPLE).map(|k| format!("{:?}", fall(&drawn(Class::Falling, k).0).side)).collect();
    assert_eq!(sides.len(), 4);
    let at_impact = |a: &Activity, joint: usize| -kinematics(a, fall(a).impact_s)[joint].1[2];
    within(range(Class::Falling, |a, _| at_impact(a, BASE)), 2.3, 3.3);
    within(
        range(Class::Falling, |a, _| greatest(times(3.0).map(|t| -kinematics(a, t)[HEAD].1[2]))),
        2.3,
        5.5,
    );
    within(
        range(Class::Falling, |a, _| greatest(times(2.0).map(|t| -kinematics(a, t)[BASE].1[2]))),
        2.3,
        3.5,
    );
    within(range(Class::Falling, |a, _| fall(a).duration_s), 0.5, 1.6);
    // the descent: from a tenth of the way to the impact
    let descent = |a: &Activity| {
        let high = a.joints(-5.0)[BASE][2];
        let low = a.joints(5.0)[BASE][2];
        let falling = |t: &f64| a.joints(*t)[BASE][2] < high - 0.1 * (high - low) && *t < fall(a).impact_s;
        times(3.0).map(|t| t - 1.0).filter(falling).count() as f64 * 2e-3
    };
    within(range(Class::Falling, |a, _| descent(a)), 0.2, 0.6);
    for index in 0..PEOPLE {
        let (a, height) = drawn(Class::Falling, index);
        let lying = kinematics(&a, 3.0);
        assert!(lying.iter().all(|(_, v)| norm(*v) < 1e-12));
        let high = |j: usize| lying[j].0[2];
        assert!([BASE, NECK, HEAD].iter().all(|&j| (0.03..0.4).contains(&high(j))), "{lying:?}");
        let along = norm(sub(lying[HEAD].0, lying[ANKLE].0)) / height;
        assert!((0.6..0.95).contains(&along), "{along}");
    }
}

#[test]
fn who_jumps_flies_as_a_body_thrown_up() {
    let airborne = |a: &Activity| {
        let floor = a.joints(-50.0)[ANKLE][2].min(a.frame.ankle_m);
        times(3.0).filter(|t| a.joints(*t)[ANKLE][2] > floor + 1e-9).collect::<Vec<_>>()
    };
    for index in 0..PEOPLE {
        let (a, _) = drawn(Class::Jumping, index);
        let Kind::Jump(jump) = &a.kind else { panic!("{a:?}") };
        let [[off, ..], .., [on, ..]] = jump.flight.0[..] else { panic!("{jump:?}") };
        let [off, on] = [off, on].map(|t| t + jump.start_s);
        let height = GRAVITY * (on - off) * (on - off) / 8.0;
        assert!((0.15..=0.40).contains(&height), "{height}");
        let base = |t: f64| a.joints(t)[BASE][2];
        for k in 0..=20 {
            let t = (on - off) * f64::from(k) / 20.0;
            let thrown = base(off) + t * (0.5 * GRAVITY * (on - off) - 0.5 * GRAVITY * t);
            assert!((base(off + t) - thrown).abs() < 1e-9, "{index}: {t}");
        }
        // the feet leave the floor and come back
        let lifted = airborne(&a);
        assert!(lifted.iter().any(|t| (t - 0.5 * (off + on)).abs() < 2e-3) && lifted.len() > 100);
        let before = a.joints(off - 1e-3);
        assert!((before[ANKLE][2] - a.frame.ankle_m).abs() < 1e-9);
    }
    within(range(Class::Jumping, |a, _| greatest(times(3.0).map(|t| kinematics(a, t)[BASE].1[2]))), 1.7, 2.9);
}

#[test]
fn one_arm_waves_and_the_trunk_bends() {
    for index in 0..PEOPLE {
        let (a, _) = drawn(Class::Waving, index);
        let Kind::Wave(wave) = &a.kind else { panic!("{a:?}") };
        let (first, hands) = (a.joints(0.0), |t: f64| a.joints(t)[HAND + wave.arm]);
        assert!(norm(sub(hands(0.0), hands(1.0 / wave.rate_hz))) < 1e-9);
        let still = |j: &usize| *j != ELBOW + wave.arm && *j != HAND + wave.arm;
        let now = a.joints(0.3);
        assert!((0..JOINTS).filter(still).all(|j| norm(sub(first[j], now[j])) < 1e-12));
        assert!(hands(0.0)[2] > first[ELBOW + wave.arm][2]);
    }
    within(
        range(Class::Waving, |a, _| {
            greatest(
                times(2.0).map(|t| norm(kinematics(a, t)[HAND].1).max(norm(kinematics(a, t)[HAND + 1].1))),
            )
        }),
        0.4,
        4.5,
    );
    let lowest = |a: &Activity, height: f64| -greatest(times(4.0).map(|t| -a.joints(t)[HEAD][2])) / height;
    within(range(Class::Bending, lowest), 0.4, 0.8);
    within(
        range(Class::Bending, |a, _| greatest(times(4.0).map(|t| norm(kinematics(a, t)[HEAD].1)))),
        0.8,
        2.5,
    );
}

#[test]
fn motions_are_functions_of_their_draws() {
    for class in CLASSES {
        let one = |index| drawn(class, index).0.joints(0.4);
        assert_eq!(one(7), one(7));
        assert_ne!(one(7), one(8));
    }
    let segments = *Gait::new(1.7, 1.0).segments();
    for class in Class::EVERY.into_iter().filter(|class| !CLASSES.contains(class)) {
        let mut random = Random::new(1, 0, 0, 0);
        assert!(Activity::draw(class, 1.7, &segments, &mut random).is_none());
        assert_eq!(random.bits(), Random::new(1, 0, 0, 0).bits(), "{class:?} draws nothing");
    }
}
