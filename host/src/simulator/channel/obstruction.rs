//! What people do to the paths of the hybrid channel while they move: shadows on the room and on each other, limbs behind the torso.
//!
//! Amplitudes are computed at every eighth sensing slot and lie on straight lines in between: a body moves by less than a tenth of its
//! width in that time.

use super::room::StaticPath;
use super::shadowing::{Screen, others, own_torso, transmission, transmissions};
use super::{Scene, wavelength};
use crate::scenario::Scenario;
use crate::simulator::body::primitives::PRIMITIVES;

/// Sensing slots between two nodes.
pub const SPACING: u32 = 8;

/// Amplitudes that paths keep at one time.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Amplitudes {
    /// The direct path to a receiver.
    pub direct: f64,
    /// Each constant path of the room.
    pub room: Vec<f64>,
    /// Each primitive of each person.
    pub people: Vec<[f64; PRIMITIVES]>,
}

/// The nodes around the present slot.
#[derive(Debug, Clone)]
pub struct Obstruction {
    shadowing: bool,
    occlusion: bool,
    interval_s: f64,
    lambda: f64,
    nodes: [Option<(u32, Amplitudes)>; 2],
}

impl Obstruction {
    /// As a scenario switches it.
    pub fn new(scenario: &Scenario) -> Self {
        Obstruction {
            shadowing: scenario.channel.shadowing,
            occlusion: scenario.channel.occlusion,
            interval_s: scenario.interval_s(),
            lambda: wavelength(scenario.radar.carrier_hz),
            nodes: [None, None],
        }
    }

    /// Whether anything changes.
    pub fn is_on(&self) -> bool {
        self.shadowing || self.occlusion
    }

    /// Node number `node` and the one after it, of the recording that `scene` belongs to.
    pub fn nodes(&mut self, scene: &Scene, node: u32, room: &[StaticPath]) -> [&Amplitudes; 2] {
        for (k, node) in [node, node + 1].into_iter().enumerate() {
            let has =
                |slot: &Option<(u32, Amplitudes)>| slot.as_ref().is_some_and(|(number, _)| *number == node);
            if k == 0 && has(&self.nodes[1]) {
                self.nodes.swap(0, 1);
            }
            if !has(&self.nodes[k]) {
                let slots = f64::from(node * SPACING) - f64::from(scene.slot);
                let t = scene.time_s + slots * self.interval_s;
                self.nodes[k] = Some((node, self.amplitudes(scene, t, room)));
            }
        }
        static NOTHING: Amplitudes = Amplitudes { direct: 1.0, room: Vec::new(), people: Vec::new() };
        self.nodes.each_ref().map(|node| node.as_ref().map_or(&NOTHING, |(_, amplitudes)| amplitudes))
    }

    /// The amplitudes of one slot.
    pub fn at(&mut self, scene: &Scene, room: &[StaticPath]) -> Amplitudes {
        let people = self.people(scene, room);
        let share = share(scene.slot);
        let [a, b] = self.nodes(scene, scene.slot / SPACING, room);
        let mix = |(a, b): (&f64, &f64)| a + (b - a) * share;
        let room = a.room.iter().zip(&b.room).map(mix).collect();
        Amplitudes { direct: mix((&a.direct, &b.direct)), room, people }
    }

    /// Those of one slot's primitives alone, `[person][primitive]`.
    pub fn people(&mut self, scene: &Scene, room: &[StaticPath]) -> Vec<[f64; PRIMITIVES]> {
        let share = share(scene.slot);
        let [a, b] = self.nodes(scene, scene.slot / SPACING, room);
        let mix = |(a, b): (&[f64; PRIMITIVES], &[f64; PRIMITIVES])| {
            std::array::from_fn(|k| a[k] + (b[k] - a[k]) * share)
        };
        a.people.iter().zip(&b.people).map(mix).collect()
    }

    fn amplitudes(&self, scene: &Scene, t: f64, room: &[StaticPath]) -> Amplitudes {
        let screens: Vec<Screen> = match self.shadowing {
            true => scene.people.iter().map(|person| Screen::of(person, t)).collect(),
            false => Vec::new(),
        };
        let of = |(number, person): (usize, _)| {
            let mut amplitudes = match self.occlusion {
                true => own_torso(scene, person, t, self.lambda),
                false => [1.0; PRIMITIVES],
            };
            if self.shadowing && screens.len() > 1 {
                let kept = others(scene, &screens, number, t, self.lambda);
                amplitudes.iter_mut().for_each(|amplitude| *amplitude *= kept);
            }
            amplitudes
        };
        Amplitudes {
            direct: match scene.monostatic() {
                true => 1.0,
                false => transmission(&screens, &[(scene.from, scene.to)], self.lambda),
            },
            room: transmissions(&screens, room.iter().map(|path| &path.legs[..]), self.lambda),
            people: scene.people.iter().enumerate().map(of).collect(),
        }
    }
}

/// Where between its nodes a slot lies, 0 to 1.
pub fn share(slot: u32) -> f64 {
    f64::from(slot % SPACING) / f64::from(SPACING)
}
