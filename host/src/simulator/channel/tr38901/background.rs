//! The radar's background channel (7.9.4.2): three reference points around it, each a link without line of sight.
//!
//! A radar nearer to the height of a base station (3 m) than to that of a terminal (1 m, Table 7.2-2) has the parameters of a base
//! station. Arrivals are as departures: a wave comes back from where it went. Its path has the length to the point.

use super::parameters::Parameters;
use super::polarisation::received;
use super::procedure::Procedure;
use super::variables::Variables;
use super::{between, direction};
use crate::numerics::random::Random;
use crate::scenario::{Polarisation, SPEED_OF_LIGHT};
use crate::simulator::body::{Vec3, sub};
use crate::simulator::channel::ieee80211ay::unit;
use crate::simulator::channel::{Path, carrier_phase, wavelength};
use std::f64::consts::TAU;

/// Shape, rate and offset of a Gamma distribution in m.
type Gamma = [f64; 3];
/// Horizontal distance and height of a reference point: base station (Table 7.9.4.2-1) and terminal (Table 7.9.4.2-2).
const STATION: [Gamma; 2] = [[4.236, 0.192_55, 4.99], [1.3293, 0.1442, -13.19]];
const TERMINAL: [Gamma; 2] = [[4.3733, 0.4457, 4.6302], [0.2974, 0.4103, 2.9711]];
/// Where a radar starts to be a base station in m: half way between both heights.
const STATION_HEIGHT_M: f64 = 2.0;

/// What the channel needs to know besides the place.
#[derive(Debug, Clone, Copy)]
pub struct Setting {
    pub carrier_hz: f64,
    /// The room's longest side in m.
    pub room_m: f64,
    pub polarisation: Polarisation,
}

/// Draws from a shifted gamma distribution.
fn draw([shape, rate, offset]: Gamma, random: &mut Random) -> f64 {
    random.gamma(shape) / rate + offset
}

/// Step 2: the reference points, a third of a turn apart.
pub fn reference_points(radar: Vec3, random: &mut Random) -> [Vec3; 3] {
    let [distance, height] = if radar[2] < STATION_HEIGHT_M { TERMINAL } else { STATION };
    let turn = TAU * random.uniform();
    std::array::from_fn(|r| {
        let (away, angle) = (draw(distance, random), turn + TAU / 3.0 * r as f64);
        [radar[0] + away * libm::cos(angle), radar[1] + away * libm::sin(angle), draw(height, random)]
    })
}

/// Steps 3 to 5: the paths of the three links.
pub fn background(radar: Vec3, setting: Setting, random: &mut Random) -> Vec<Path> {
    let mut paths = Vec::new();
    let parameters = Parameters::indoor_office(setting.carrier_hz, false);
    for point in reference_points(radar, random) {
        let at = Variables::draw(&parameters, random);
        let procedure = Procedure::new(parameters.clone(), &at, setting.room_m, random);
        let link = procedure.link(&at);
        let (distance, towards) = (between(radar, point), unit(sub(point, radar)));
        let gain =
            libm::pow(10.0, (link.shadow_db - parameters.loss_db(distance, setting.carrier_hz)) / 20.0);
        let first = carrier_phase(distance, wavelength(setting.carrier_hz));
        paths.extend(link.rays.iter().map(|ray| Path {
            gain: first * received(&ray.matrix, setting.polarisation) * (gain * ray.power.sqrt()),
            delay_s: distance / SPEED_OF_LIGHT + link.excess_s + ray.delay_s,
            departure: direction(towards, ray.departure),
            arrival: direction(towards, ray.arrival),
        }));
    }
    paths
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sensing_reference_points_are_as_far_and_high_as_the_tables() {
        for (name, radar_height, [distance, height]) in
            [("base station", 3.0, STATION), ("terminal", 1.0, TERMINAL)]
        {
            let mut random = Random::new(79, 1, 0, 0);
            let radar = [1.0, 2.0, radar_height];
            let (mut away, mut high) = (Vec::new(), Vec::new());
            for _ in 0..10_000 {
                let points = reference_points(radar, &mut random);
                for [x, y, z] in points {
                    away.push((x - radar[0]).hypot(y - radar[1]));
                    high.push(z);
                }
                let angle = |p: Vec3| libm::atan2(p[1] - radar[1], p[0] - radar[0]);
                let apart = (angle(points[1]) - angle(points[0])).rem_euclid(TAU);
                assert!((apart - TAU / 3.0).abs() < 1e-9, "{apart}");
            }
            for (what, values, [shape, rate, offset]) in
                [("distance", away, distance), ("height", high, height)]
            {
                let n = values.len() as f64;
                let mean = values.iter().sum::<f64>() / n;
                let deviation = (values.iter().map(|v| (v - mean) * (v - mean)).sum::<f64>() / n).sqrt();
                let exact = (shape / rate + offset, shape.sqrt() / rate);
                println!(
                    "number: 38.901 sensing, {what} of a {name}'s reference points {mean:.2} +- {deviation:.2} m (Tables 7.9.4.2: {:.2} +- {:.2} m)",
                    exact.0, exact.1
                );
                assert!((mean - exact.0).abs() < 0.03 * exact.1 && (deviation / exact.1 - 1.0).abs() < 0.03);
            }
        }
    }

    #[test]
    fn sensing_background_is_the_sum_of_three_links_without_line_of_sight() {
        let setting = Setting { carrier_hz: 3.5e9, room_m: 50.0, polarisation: Polarisation::Vertical };
        let radar = [0.0, 0.0, 3.0];
        let (mut found, mut exact, n) = (0.0, 0.0, 3000);
        for index in 0..n {
            let mut random = Random::new(794, 1, 0, index);
            let power: f64 =
                background(radar, setting, &mut random).iter().map(|path| path.gain.norm_sqr()).sum();
            found += 10.0 * libm::log10(power) / n as f64;
            // path losses and shadowing of the table alone
            let mut random = Random::new(795, 1, 0, index);
            let parameters = Parameters::indoor_office(3.5e9, false);
            let law: f64 = reference_points(radar, &mut random)
                .iter()
                .map(|&p| {
                    let shadow = 8.03 * random.gaussian();
                    libm::pow(10.0, (shadow - parameters.path_loss_db(between(radar, p), 3.5e9)) / 10.0)
                })
                .sum();
            exact += 10.0 * libm::log10(law) / n as f64;
        }
        println!(
            "number: 38.901 sensing, background of a base station at 3.5 GHz {found:.2} dB (eq. 7.9.4-15 with path loss and shadowing alone: {exact:.2} dB)"
        );
        assert!((found - exact).abs() < 0.5, "{found} {exact}");
    }
}
