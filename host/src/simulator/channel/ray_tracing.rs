//! `ray-tracing`: a deterministic channel from geometry alone.
//!
//! Image method up to second order off slabs or half spaces ([`super::room`]), diffuse scattering of rough surfaces
//! ([`super::roughness`]), people and furniture as screens that waves bend around ([`super::diffraction`]), and a moving body of sixteen
//! primitives seen directly, by way of one surface or of two, its limbs behind its torso ([`super::shadowing`]). Nothing is random. With a
//! bare interior, smooth surfaces and none of the rest it is the baseline of the paper.

use super::diffraction::kept;
use super::room::{Plane, StaticPath, image, legs, orders};
use super::roughness::Traced;
use super::shadowing::{Screen, behind_torso};
use super::target::{Target, direct, scattered};
use super::{ChannelModel, Complex64, Path, Scene, wavelength};
use crate::scenario::Scenario;
use crate::simulator::body::Vec3;
use crate::simulator::body::primitives::{PRIMITIVES, Primitive};

#[derive(Debug, Clone)]
pub struct RayTracing {
    lambda: f64,
    traced: Traced,
    furniture: Vec<Screen>,
    diffraction: bool,
    shadowing: bool,
    occlusion: bool,
    /// The surfaces of every path between an end and a person: none, one, and with double bounce two.
    bounces: Vec<Vec<Plane>>,
}

/// A path between an end and a person: the end's image, what screens leave of it and what the torso leaves of each primitive.
struct Approach {
    image: Vec3,
    kept: Complex64,
    limbs: [f64; PRIMITIVES],
}

/// A direction from an image as it is at the end itself.
fn unfolded(mut direction: Vec3, planes: &[Plane]) -> Vec3 {
    planes.iter().for_each(|&(axis, _)| direction[axis] *= -1.0);
    direction
}

impl RayTracing {
    /// In a scenario's room.
    pub fn new(scenario: &Scenario) -> Self {
        let (channel, traced) = (&scenario.channel, Traced::new(scenario));
        let mut bounces = vec![Vec::new()];
        bounces.extend(orders(traced.map.size, if channel.double_bounce { 2 } else { 1 }));
        RayTracing {
            lambda: wavelength(scenario.radar.carrier_hz),
            furniture: traced.map.furniture.iter().filter_map(Screen::furniture).collect(),
            diffraction: channel.diffraction,
            shadowing: channel.shadowing,
            occlusion: channel.occlusion,
            bounces,
            traced,
        }
    }

    /// The paths between an end and a person.
    fn approaches(
        &self,
        end: Vec3,
        primitives: &[Primitive; PRIMITIVES],
        screens: &[Screen],
    ) -> Vec<Approach> {
        let one = |planes: &Vec<Plane>| {
            let image = planes.iter().fold(end, |p, &plane| image(p, plane));
            Approach {
                image,
                kept: match screens {
                    [] => Complex64::new(1.0, 0.0),
                    _ => {
                        let legs = legs(self.traced.map.size, planes, end, primitives[1].centre);
                        kept(screens, &legs, self.lambda, self.diffraction)
                    }
                },
                limbs: match self.occlusion {
                    true => behind_torso(image, primitives, self.lambda),
                    false => [1.0; PRIMITIVES],
                },
            }
        };
        self.bounces.iter().map(one).collect()
    }

    /// A person's echoes by every pair of paths with no more reflections than `bounces` has.
    fn echoes(&self, scene: &Scene, person: &Target, screens: &[Screen], paths: &mut Vec<Path>) {
        let primitives = person.primitives(scene.time_s);
        let out = self.approaches(scene.from, &primitives, screens);
        let elsewhere = (scene.to != scene.from).then(|| self.approaches(scene.to, &primitives, screens));
        let back = elsewhere.as_ref().unwrap_or(&out);
        let most = self.bounces.last().map_or(0, Vec::len);
        let bent = 1..self.bounces.len();
        let mut pairs: Vec<(usize, usize)> = bent.clone().map(|i| (i, 0)).collect();
        pairs.extend(bent.clone().map(|j| (0, j)));
        pairs.extend(bent.clone().flat_map(|i| bent.clone().map(move |j| (i, j))));
        pairs.retain(|&(i, j)| self.bounces[i].len() + self.bounces[j].len() <= most);
        let limbs = || primitives.iter().zip(&person.phases).enumerate();
        let straight = limbs().map(|limb| (limb, &[(0, 0)][..]));
        for ((k, (primitive, phase)), pairs) in straight.chain(limbs().map(|limb| (limb, &pairs[..]))) {
            for &(i, j) in pairs {
                let (out, back) = (&out[i], &back[j]);
                let bent = Scene { from: out.image, to: back.image, ..*scene };
                let root = person.gain
                    * person.weights[k]
                    * primitive.root_bistatic_cross_section(bent.from, bent.to);
                let mut path = scattered(&bent, primitive.centre, root, self.lambda, *phase);
                let surfaces = self.traced.map.reflected(&self.bounces[i], path.departure)
                    * self.traced.map.reflected(&self.bounces[j], path.arrival);
                path.gain *= surfaces * out.kept * back.kept * (out.limbs[k] * back.limbs[k]);
                path.departure = unfolded(path.departure, &self.bounces[i]);
                path.arrival = unfolded(path.arrival, &self.bounces[j]);
                paths.push(path);
            }
        }
    }
}

impl ChannelModel for RayTracing {
    fn paths(&mut self, scene: &Scene, paths: &mut Vec<Path>) {
        let ends = (scene.from, scene.to);
        let people = scene.people.iter().filter(|_| self.shadowing);
        let mut screens: Vec<Screen> = people.map(|person| Screen::of(person, scene.time_s)).collect();
        screens.extend(&self.furniture);
        let (lambda, diffraction) = (self.lambda, self.diffraction);
        if let Some(path) = direct(scene, lambda) {
            paths.push(Path { gain: path.gain * kept(&screens, &[ends], lambda, diffraction), ..path });
        }
        let (people, resting) = screens.split_at(screens.len() - self.furniture.len());
        let by = |screens, legs: &[_]| kept(screens, legs, lambda, diffraction);
        let resting = |paths: &[StaticPath]| paths.iter().map(|path| by(resting, &path.legs)).collect();
        for StaticPath { path, legs } in self.traced.paths(ends, resting) {
            paths.push(Path { gain: path.gain * by(people, legs), ..*path });
        }
        for (number, person) in scene.people.iter().enumerate() {
            let mut others = screens.clone();
            if self.shadowing {
                others.remove(number);
            }
            self.echoes(scene, person, &others, paths);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scenario::{Class, Furniture, SPEED_OF_LIGHT};
    use crate::simulator::body::motion::Person;
    use crate::simulator::body::{norm, sub};

    const RADAR: Vec3 = [1.5, 1.0, 1.0];

    fn person(scenario: &Scenario) -> Target {
        let mut random = crate::numerics::random::Random::new(1, 0, 0, 0);
        let person =
            Person::draw(Class::Standing, &scenario.target, scenario.room.size_m, RADAR, &mut random);
        Target::new(person, &mut random)
    }

    fn paths(scenario: &Scenario, to: Vec3, people: &[Target]) -> Vec<Path> {
        let mut paths = Vec::new();
        let scene = Scene { slot: 0, time_s: 0.0, from: RADAR, to, people };
        RayTracing::new(scenario).paths(&scene, &mut paths);
        paths
    }

    #[test]
    fn images_of_second_order_are_as_long_as_by_hand() {
        let mut scenario = Scenario::default();
        scenario.channel.double_bounce = true;
        let people = [person(&scenario)];
        let (room, all) = (paths(&scenario, RADAR, &[]), paths(&scenario, RADAR, &people));
        let length = |path: &Path| path.delay_s * SPEED_OF_LIGHT;
        // the radar 1.5 m off a wall and 2 m below the ceiling: 2 sqrt(1.5^2 + 2^2) = 5 m by way of both
        let corner = room
            .iter()
            .map(length)
            .fold(f64::INFINITY, |best, l| if (l - 5.0).abs() < (best - 5.0).abs() { l } else { best });
        // out by the wall x = 0, back by the ceiling: the radar's images at (-1.5, 1, 1) and (1.5, 1, 5)
        let torso = people[0].centre(0.0);
        let by_hand = norm(sub(torso, [-1.5, 1.0, 1.0])) + norm(sub(torso, [1.5, 1.0, 5.0]));
        let echoes = &all[room.len()..];
        assert_eq!(echoes.len(), PRIMITIVES * (1 + 24 + 24 + 36));
        let found = echoes.iter().find(|path| (length(path) - by_hand).abs() < 1e-9).map(length);
        println!(
            "number: wall and ceiling {corner:.4} m (by hand 5 m), wall, torso, ceiling {:.4} m (by hand {by_hand:.4} m)",
            found.unwrap_or(0.0)
        );
        assert!((corner - 5.0).abs() < 1e-12 && found.is_some(), "{corner}");
        // it leaves towards the wall and comes from the ceiling
        let path = echoes.iter().find(|path| (length(path) - by_hand).abs() < 1e-9).unwrap();
        assert!(path.departure[0] < 0.0 && path.arrival[2] > 0.0, "{path:?}");
    }

    #[test]
    fn what_stands_in_the_way_hides_bends_and_scatters() {
        let mut scenario = Scenario::default();
        scenario.radar.carrier_hz = 60e9;
        let to = [1.5, 4.0, 1.0];
        let direct = |scenario: &Scenario, people: &[Target]| {
            10.0 * libm::log10(paths(scenario, to, people)[0].gain.norm_sqr())
        };
        let free = direct(&scenario, &[]);
        // a cupboard in the middle, its upper edge on the way: half the field
        let cupboard =
            Furniture { centre_m: [1.5, 2.5, 0.5], cross_section_dbsm: -10.0, size_m: Some([2.0, 1.0]) };
        scenario.room.furniture = vec![cupboard];
        let bent = direct(&scenario, &[]) - free;
        scenario.channel.diffraction = false;
        assert_eq!(direct(&scenario, &[]), f64::NEG_INFINITY);
        // a person who stands there instead
        (scenario.room.furniture, scenario.channel.diffraction) = (Vec::new(), true);
        scenario.target.start_m = [1.5, 2.5];
        let people = [person(&scenario)];
        let behind = direct(&scenario, &people) - free;
        scenario.channel.shadowing = false;
        println!(
            "number: direct path over a cupboard's edge {bent:.2} dB (half the field: -6.02 dB), through a person {behind:.1} dB"
        );
        assert!((bent + 6.02).abs() < 0.6 && (-40.0..-8.0).contains(&behind), "{bent} {behind}");
        assert_eq!(direct(&scenario, &people), free);
    }

    #[test]
    fn limbs_behind_the_torso_and_rough_walls_show() {
        let mut scenario = Scenario::default();
        scenario.channel.shadowing = false;
        let people = [person(&scenario)];
        let power = |scenario: &Scenario, people: &[Target]| {
            paths(scenario, RADAR, people).iter().map(|p| p.gain.norm_sqr()).sum::<f64>()
        };
        let (seen, empty) = (power(&scenario, &people), power(&scenario, &[]));
        scenario.channel.occlusion = false;
        assert!(power(&scenario, &people) > seen && seen > empty);
        scenario.channel.scattering = 0.0;
        let smooth = paths(&scenario, RADAR, &[]).len();
        assert_eq!(smooth, 24 + scenario.room.furniture.len());
    }
}
