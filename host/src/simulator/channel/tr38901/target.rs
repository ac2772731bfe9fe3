//! The channel of a person (7.9.4.1): the link to it and the link from it in cascade, direct rays and clusters.
//!
//! A person is one scattering point, 1.5 m high in an adult of 1.75 m, with the aspect-dependent cross section of human model 2 (7.9.2.1)
//! and a polarisation matrix (7.9.2.2). Both links are drops that begin where it first stands: afterwards the direct path follows it exactly,
//! and the phase of every other path turns as it moves along the path's directions there. The radar's two links are one.
//!
//! Rays are coupled by option 2 of step 9: a direct ray with every ray of the other link, and clusters' rays in pairs at random.

use super::background::Setting;
use super::between;
use super::direction;
use super::link::{Link, Ray};
use super::parameters::{Parameters, in_sight};
use super::polarisation::{self, DIRECT, Matrix, product, received, transposed};
use super::procedure::Procedure;
use super::variables::Variables;
use crate::numerics::random::Random;
use crate::scenario::SPEED_OF_LIGHT;
use crate::simulator::body::{Vec3, dot, sub};
use crate::simulator::channel::ieee80211ay::unit;
use crate::simulator::channel::target::Target;
use crate::simulator::channel::{Complex64, Path, Scene, carrier_phase, wavelength};
use std::f64::consts::PI;

/// Deviation of the cross section's random factor in dB (Table 7.9.2.1-3).
const SCATTER_DB: f64 = 3.94;
/// Mean and deviation of a person's cross-polarisation power ratio in dB (Table 7.9.2.2-1).
const XPR_DB: (f64, f64) = (19.81, 4.25);
/// A path this far below the strongest is dropped, in dB (step 10, option 2).
const WEAKEST_DB: f64 = -40.0;
/// Height of the scattering point over that of the body: 1.5 m of 1.75 m (7.9.3).
const POINT: f64 = 1.5 / 1.75;

/// Aspect-dependent cross section of a person in dBsm (clause 7.9.2, model 2): two lobes, front and back.
///
/// `azimuth` and `zenith` in rad of the bisector in the body's frame, `bistatic` the angle between both ways in rad.
pub fn human_dbsm(azimuth: f64, zenith: f64, bistatic: f64) -> f64 {
    const MOST: f64 = 2.14;
    const RANGE: f64 = 7.7;
    let (az, th, beta) = (azimuth * 180.0 / PI, zenith * 180.0 / PI, bistatic * 180.0 / PI);
    let vertical = (12.0 * ((th - 90.0) / 55.7) * ((th - 90.0) / 55.7)).min(RANGE);
    let lobe = |centre: f64| {
        let off = (az - centre) - 360.0 * ((az - centre) / 360.0).round();
        (12.0 * (off / 216.65) * (off / 216.65)).min(RANGE)
    };
    let horizontal = lobe(0.0).min(lobe(180.0));
    let bent = 0.5714 * libm::sin(0.1 * beta / 2.0 * PI / 180.0)
        - 5.0 * libm::log10(libm::cos(beta * PI / 360.0).max(1e-6));
    (MOST - (vertical + horizontal).min(RANGE) - bent).max(MOST - RANGE)
}

/// The random factor of a cross section: lognormal with mean 1 (eq. 7.9.2-1), at most three deviations above its mean in dB.
pub fn scatter(random: &mut Random) -> f64 {
    let mean = -std::f64::consts::LN_10 / 20.0 * SCATTER_DB * SCATTER_DB;
    let db = (mean + SCATTER_DB * random.gaussian()).min(mean + 3.0 * SCATTER_DB);
    libm::pow(10.0, db / 10.0)
}

/// A person's scattering point at `t` seconds.
pub fn point(person: &Target, t: f64) -> Vec3 {
    let [x, y, _] = person.centre(t);
    [x, y, POINT * person.person.truth.height_m]
}

/// Cross section of a person in m^2 without its random factor: towards where the wave comes from and where it goes, unit vectors.
fn cross_section(person: &Target, [a, b]: [Vec3; 2]) -> f64 {
    let bisector = unit([a[0] + b[0], a[1] + b[1], a[2] + b[2]]);
    let heading = person.person.truth.heading_deg * PI / 180.0;
    let azimuth = libm::atan2(bisector[1], bisector[0]) - heading;
    let zenith = libm::acos(bisector[2].clamp(-1.0, 1.0));
    let beta = libm::acos(dot(a, b).clamp(-1.0, 1.0));
    let size = person.gain * person.person.truth.height_m / 1.75;
    size * size * libm::pow(10.0, human_dbsm(azimuth, zenith, beta) / 10.0)
}

/// One of the two links, as steps 2 to 9 drew it.
#[derive(Debug, Clone)]
struct Leg {
    parameters: Parameters,
    link: Link,
}

impl Leg {
    fn draw(ends: (Vec3, Vec3), possible: bool, setting: Setting, random: &mut Random) -> Self {
        let los = in_sight(possible, ends.0, ends.1, random);
        let parameters = Parameters::indoor_office(setting.carrier_hz, los);
        let at = Variables::draw(&parameters, random);
        let link = Procedure::new(parameters.clone(), &at, setting.room_m, random).link(&at);
        Leg { parameters, link }
    }

    /// The direct ray.
    fn direct(&self) -> Option<Ray> {
        let ray = Ray {
            delay_s: 0.0,
            power: self.link.direct,
            arrival: [0.0; 2],
            departure: [0.0; 2],
            matrix: DIRECT,
        };
        self.parameters.los.then_some(ray)
    }

    /// Power ratio over a distance in m, shadowing included.
    fn gain(&self, distance_m: f64, carrier_hz: f64) -> f64 {
        libm::pow(10.0, (self.link.shadow_db - self.parameters.loss_db(distance_m, carrier_hz)) / 10.0)
    }
}

/// A path by way of the person that is not direct in both links.
#[derive(Debug, Clone)]
struct CascadedPath {
    /// Share of the power times the cross section in m^2.
    section: f64,
    coefficient: Complex64,
    delay_s: f64,
    departure: Vec3,
    arrival: Vec3,
    /// From the person towards where the wave comes from and where it goes.
    sides: [Vec3; 2],
}

/// The channel by way of one person.
#[derive(Debug, Clone)]
pub struct Cascade {
    setting: Setting,
    start: Vec3,
    there: Leg,
    back: Leg,
    /// The share of the direct path in the power with its random factor, and its coefficient.
    direct: (f64, Complex64),
    paths: Vec<CascadedPath>,
}

/// The three matrices in a row, normalised (eq. 7.9.4-4).
fn cascaded(back: &Matrix, person: &Matrix, there: &Matrix) -> Matrix {
    let whole = product(&product(back, person), there);
    let scale = ((whole[0][0].norm_sqr() + whole[1][1].norm_sqr()) / 2.0).sqrt().max(f64::MIN_POSITIVE);
    whole.map(|row| row.map(|z| z / scale))
}

impl Cascade {
    pub fn new(
        person: &Target,
        scene: &Scene,
        possible: bool,
        setting: Setting,
        random: &mut Random,
    ) -> Self {
        let start = point(person, scene.time_s);
        let there = Leg::draw((scene.from, start), possible, setting, random);
        let back = match scene.monostatic() {
            true => Leg { link: there.link.reversed(), ..there.clone() },
            false => Leg::draw((start, scene.to), possible, setting, random),
        };
        let mut cascade =
            Cascade { setting, start, there, back, direct: (0.0, Complex64::default()), paths: Vec::new() };
        cascade.couple(person, scene, random);
        cascade
    }

    /// Steps 9 to 13: couples rays, and draws the cross section's factor and the polarisation of each way.
    fn couple(&mut self, person: &Target, scene: &Scene, random: &mut Random) {
        let received = |m: &Matrix| received(m, self.setting.polarisation);
        let (mine, theirs) = (self.there.direct(), self.back.direct());
        if let (Some(a), Some(b)) = (mine, theirs) {
            let matrix = cascaded(&b.matrix, &polarisation::draw(XPR_DB, random), &a.matrix);
            self.direct = (a.power * b.power * scatter(random), received(&matrix));
        }
        let mut paths = Vec::new();
        let mut add = |a: &Ray, b: &Ray, factor: f64, matrix: &Matrix| {
            paths.push(self.cascaded_path(person, scene, [a, b], factor, received(matrix)));
        };
        if let Some(a) = mine {
            for b in &self.back.link.rays {
                let (factor, own) = (scatter(random), polarisation::draw(XPR_DB, random));
                let matrix = cascaded(&b.matrix, &own, &a.matrix);
                add(&a, b, factor, &matrix);
                if scene.monostatic() {
                    // the same path in the other direction
                    let reversed = Ray { arrival: b.departure, departure: b.arrival, ..*b };
                    add(&reversed, &a, factor, &transposed(&matrix));
                }
            }
        }
        if let Some(b) = theirs.filter(|_| !scene.monostatic()) {
            for a in &self.there.link.rays {
                let (factor, own) = (scatter(random), polarisation::draw(XPR_DB, random));
                add(a, &b, factor, &cascaded(&b.matrix, &own, &a.matrix));
            }
        }
        let mut others: Vec<&Ray> = self.back.link.rays.iter().collect();
        for k in (1..others.len()).rev() {
            others.swap(k, (random.bits() % (k as u64 + 1)) as usize);
        }
        for (a, b) in self.there.link.rays.iter().zip(others) {
            let (factor, own) = (scatter(random), polarisation::draw(XPR_DB, random));
            add(a, b, factor, &cascaded(&b.matrix, &own, &a.matrix));
        }
        let direct = self.direct.0 * cross_section(person, self.towards_ends(scene, self.start));
        let most = paths.iter().map(|path| path.section).fold(direct, f64::max);
        paths.retain(|path| path.section >= most * libm::pow(10.0, WEAKEST_DB / 10.0));
        self.paths = paths;
    }

    /// Unit vectors from a place of the person towards both ends.
    fn towards_ends(&self, scene: &Scene, place: Vec3) -> [Vec3; 2] {
        [scene.from, scene.to].map(|end| unit(sub(end, place)))
    }

    fn cascaded_path(
        &self,
        person: &Target,
        scene: &Scene,
        [a, b]: [&Ray; 2],
        factor: f64,
        coefficient: Complex64,
    ) -> CascadedPath {
        let [from, to] = self.towards_ends(scene, self.start);
        let sides = [direction(from, a.arrival), direction(to, b.departure)];
        let excess = self.there.link.excess_s + self.back.link.excess_s;
        let length = between(scene.from, self.start) + between(self.start, scene.to);
        CascadedPath {
            section: a.power * b.power * factor * cross_section(person, sides),
            coefficient,
            delay_s: a.delay_s + b.delay_s + excess + length / SPEED_OF_LIGHT,
            departure: direction(from.map(|x| -x), a.departure),
            arrival: direction(to.map(|x| -x), b.arrival),
            sides,
        }
    }

    /// Steps 14 and 15: the paths of one slot; `kept` is the amplitude that others leave of the direct path.
    pub fn paths(&self, person: &Target, scene: &Scene, kept: f64, paths: &mut Vec<Path>) {
        let lambda = wavelength(self.setting.carrier_hz);
        let place = point(person, scene.time_s);
        let distances = [between(scene.from, place), between(place, scene.to)];
        let loss = self.there.gain(distances[0], self.setting.carrier_hz)
            * self.back.gain(distances[1], self.setting.carrier_hz)
            * (4.0 * PI / (lambda * lambda));
        let ends = self.towards_ends(scene, place);
        let (share, coefficient) = self.direct;
        if share > 0.0 {
            let length = distances[0] + distances[1];
            let amplitude = (loss * share * cross_section(person, ends)).sqrt() * kept;
            paths.push(Path {
                gain: carrier_phase(length, lambda) * coefficient * amplitude,
                delay_s: length / SPEED_OF_LIGHT,
                departure: ends[0].map(|x| -x),
                arrival: ends[1].map(|x| -x),
            });
        }
        let moved = sub(place, self.start);
        for path in &self.paths {
            let longer = -dot(path.sides[0], moved) - dot(path.sides[1], moved);
            paths.push(Path {
                gain: carrier_phase(longer, lambda) * path.coefficient * (loss * path.section).sqrt(),
                delay_s: path.delay_s + longer / SPEED_OF_LIGHT,
                departure: path.departure,
                arrival: path.arrival,
            });
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scenario::Polarisation;
    use crate::simulator::body::motion::{GroundTruth, Person};

    #[test]
    fn a_human_is_widest_in_front_and_behind() {
        let front = human_dbsm(0.0, PI / 2.0, 0.0);
        println!(
            "number: 38.901 sensing, cross section of a person from the front {front:.2} dBsm (Table 7.9.2.1-3: 2.14 dBsm)"
        );
        assert!((front - 2.14).abs() < 1e-12);
        assert!((human_dbsm(PI, PI / 2.0, 0.0) - front).abs() < 1e-9);
        assert!(human_dbsm(PI / 2.0, PI / 2.0, 0.0) < front - 2.0);
        assert!((human_dbsm(0.0, 0.0, 0.0) - (2.14 - 7.7)).abs() < 1e-9);
        // the mean over all directions of the radar, linear
        let (mut sum, mut whole) = (0.0, 0.0);
        for (zenith, azimuth) in (0..180).flat_map(|z| (0..360).map(move |a| (z, a))) {
            let [zenith, azimuth] = [zenith, azimuth].map(|degrees| (f64::from(degrees) + 0.5) * PI / 180.0);
            sum += libm::sin(zenith) * libm::pow(10.0, human_dbsm(azimuth, zenith, 0.0) / 10.0);
            whole += libm::sin(zenith);
        }
        let mean = 10.0 * libm::log10(sum / whole);
        println!(
            "number: 38.901 sensing, its mean over all directions {mean:.2} dBsm (Table 7.9.2.1-3: -1.37 dBsm)"
        );
        assert!((mean + 1.37).abs() < 0.03, "{mean}");
    }

    #[test]
    fn sensing_cross_section_factor_and_polarisation_are_the_tables() {
        let mut random = Random::new(792, 1, 0, 0);
        let n = 10_000.0;
        let factors: Vec<f64> = (0..10_000).map(|_| scatter(&mut random)).collect();
        let mean = factors.iter().sum::<f64>() / n;
        let db: Vec<f64> = factors.iter().map(|f| 10.0 * libm::log10(*f)).collect();
        let centre = db.iter().sum::<f64>() / n;
        let deviation = (db.iter().map(|x| (x - centre) * (x - centre)).sum::<f64>() / n).sqrt();
        let ratios: Vec<f64> = (0..10_000)
            .map(|_| -20.0 * libm::log10(polarisation::draw(XPR_DB, &mut random)[1][0].norm()))
            .collect();
        let xpr = ratios.iter().sum::<f64>() / n;
        println!(
            "number: 38.901 sensing, random factor of the cross section: mean {mean:.3}, {centre:.2} +- {deviation:.2} dB (Table 7.9.2.1-3: 1, -1.79 +- 3.94 dB); cross-polarisation {xpr:.2} dB (Table 7.9.2.2-1: 19.81 dB)"
        );
        assert!((mean - 1.0).abs() < 0.03 && (deviation / 3.94 - 1.0).abs() < 0.03, "{mean} {deviation}");
        assert!((xpr / 19.81 - 1.0).abs() < 0.03);
    }

    fn adult() -> Target {
        let truth = GroundTruth::standing(1.75, [3.0, 4.0]);
        let mut random = Random::new(1, 0, 0, 0);
        Target::new(Person::new(truth, [20.0, 20.0, 3.0], &mut random), &mut random)
    }

    const SETTING: Setting =
        Setting { carrier_hz: 3.5e9, room_m: 20.0, polarisation: Polarisation::Vertical };

    #[test]
    fn sensing_a_persons_ways_have_the_coupling_loss_of_the_calibration() {
        // Table 7.9.6.1-2: PL(d1) + PL(d2) + 10 lg(c^2 / (4 pi f^2)) - 10 lg sigma + SF1 + SF2
        let person = adult();
        let radar = [3.0, 1.0, 3.0];
        let scene = Scene { slot: 0, time_s: 0.0, from: radar, to: radar, people: &[] };
        let place = point(&person, 0.0);
        let lambda = wavelength(3.5e9);
        let sigma = cross_section(&person, [unit(sub(radar, place)); 2]);
        for (los, from, to) in [(true, -0.5, 0.5), (false, -28.0, -23.0)] {
            let (mut off, mut direct, mut count, n) = (0.0, 0.0, 0, 4000);
            for index in 0..n {
                let mut random = Random::new(796, 1, 0, index);
                let cascade = Cascade::new(&person, &scene, los, SETTING, &mut random);
                let mut paths = Vec::new();
                cascade.paths(&person, &scene, 1.0, &mut paths);
                let shadow = 2.0 * cascade.there.link.shadow_db;
                let law = 2.0 * cascade.there.parameters.loss_db(between(radar, place), 3.5e9) - shadow
                    + 10.0 * libm::log10(lambda * lambda / (4.0 * PI) / sigma);
                let power: f64 = paths.iter().map(|path| path.gain.norm_sqr()).sum();
                off += power * libm::pow(10.0, law / 10.0) / n as f64;
                count += paths.len();
                if los {
                    direct += paths[0].gain.norm_sqr() / power / n as f64;
                    let length = paths[0].delay_s * SPEED_OF_LIGHT;
                    assert!((length - 2.0 * between(radar, place)).abs() < 1e-9);
                }
            }
            let off = 10.0 * libm::log10(off);
            // pairs of option 2 have the share 1 / (rays of a link) of all pairs' power
            println!(
                "number: 38.901 sensing, a person's channel, line of sight {los}: {off:+.2} dB of the calibration's coupling loss ({}), {:.0} paths, {direct:.2} of the power direct",
                if los { "0 dB" } else { "option 2: -25 dB" },
                count as f64 / n as f64
            );
            assert!((from..to).contains(&off), "{off}");
        }
    }

    #[test]
    fn sensing_the_radars_two_links_are_one() {
        let person = adult();
        let radar = [3.0, 1.0, 1.0];
        let scene = Scene { slot: 0, time_s: 0.0, from: radar, to: radar, people: &[] };
        for possible in [true, false] {
            let cascade = Cascade::new(&person, &scene, possible, SETTING, &mut Random::new(7, 1, 0, 0));
            assert_eq!(cascade.there.link, cascade.back.link.reversed());
            assert_eq!(cascade.direct.0 > 0.0, possible);
            // every path exists in the other direction too: as much power leaves in a direction as comes from it
            if possible {
                let sum = |f: fn(&CascadedPath) -> Vec3| -> f64 {
                    let one = |path: &CascadedPath| path.section * f(path)[0];
                    cascade.paths.iter().map(one).sum()
                };
                let (out, home) = (sum(|path| path.departure), sum(|path| path.arrival));
                let whole: f64 = cascade.paths.iter().map(|path| path.section).sum();
                assert!((out - home).abs() < 0.05 * whole, "{out} {home} {whole}");
            }
        }
    }
}
