//! Antennas: amplitude over direction, relative to isotropic ones.
//!
//! The element of 3GPP TR 38.901 Table 7.3-1 with one beam width for both planes, which follows from the gain: A = -min(12 (theta /
//! w)^2 + 12 (phi / w)^2, A_m) dB below the maximum, w chosen so that the pattern's directivity is the gain (no losses). Or a
//! measured table. Or the same gain in every direction, which no antenna has: the paper's.

use super::{Path, wavelength};
use crate::error::Invalid;
use crate::numerics::atan::atan2;
use crate::numerics::exp::exp;
use crate::numerics::vectors::vectorised;
use crate::scenario::{AntennaPattern, Radar, Scenario};
use crate::simulator::body::{Vec3, dot, norm, scale, sub};
use crate::store::limited;
use std::f64::consts::PI;
use std::path::Path as FilePath;
use std::sync::{Arc, Mutex, PoisonError};

/// Where an antenna points and how it weighs other directions.
#[derive(Debug, Clone)]
pub struct Antenna {
    /// Unit vectors: boresight, left of it and up from it.
    axes: [Vec3; 3],
    pattern: Pattern,
}

#[derive(Debug, Clone)]
enum Pattern {
    /// Boresight gain everywhere.
    Constant,
    /// Beam width w in rad and floor A_m in dB.
    Element { width: f64, floor_db: f64 },
    /// Measured.
    Table(Arc<Table>),
}

/// A measured pattern: gain below the maximum in dB over azimuth and elevation from boresight.
#[derive(Debug, PartialEq)]
pub struct Table {
    /// Ascending, degrees.
    azimuth: Vec<f64>,
    /// Ascending, degrees.
    elevation: Vec<f64>,
    /// `[elevation][azimuth]`, dB.
    gain_db: Vec<f64>,
}

/// The last patterns: a run has one radar, its tests a few.
static PATTERNS: Mutex<Vec<(Radar, Pattern)>> = Mutex::new(Vec::new());
const KEPT: usize = 4;

/// Amplitudes of levels in dB.
#[inline(always)]
fn amplitudes<const N: usize>(mut levels_db: [f64; N]) -> [f64; N] {
    for level in &mut levels_db {
        *level *= std::f64::consts::LN_10 / 20.0;
    }
    exp(&levels_db)
}

/// dB below the maximum of the element at two angles from boresight in rad.
#[inline(always)]
fn element_db(azimuth: f64, elevation: f64, width: f64, floor_db: f64) -> f64 {
    let (a, e) = (azimuth / width, elevation / width);
    -(12.0 * (a * a + e * e)).min(floor_db)
}

/// Integral of the element's relative power over the sphere, 4 pi over the directivity: the floor everywhere, and the beam above it, which
/// ends at w sqrt(A_m / 12) from boresight.
fn integral(width: f64, floor_db: f64) -> f64 {
    let floor = libm::pow(10.0, -floor_db / 10.0);
    let radius = width * (floor_db / 12.0).sqrt();
    let steps = 96;
    let mut sum = 0.0;
    for ring in 0..steps {
        let r = (f64::from(ring) + 0.5) / f64::from(steps) * radius;
        for spoke in 0..steps {
            // a quarter of the beam; the others are its mirror images
            let angle = (f64::from(spoke) + 0.5) / f64::from(steps) * PI / 2.0;
            let (azimuth, elevation) = (r * libm::cos(angle), r * libm::sin(angle));
            if azimuth < PI && elevation < PI / 2.0 {
                let [power] = amplitudes([2.0 * element_db(azimuth, elevation, width, floor_db)]);
                sum += (power - floor) * r * libm::cos(elevation);
            }
        }
    }
    4.0 * PI * floor + 4.0 * sum * radius * PI / 2.0 / f64::from(steps * steps)
}

/// Beam width in rad at which the element's directivity is a gain, by bisection; `None` below 6 dB, and where the floor alone radiates more.
fn width_of(gain_db: f64, floor_db: f64) -> Option<f64> {
    let wanted = 4.0 * PI / libm::pow(10.0, gain_db / 10.0);
    if gain_db < 6.0 || integral(1e-3, floor_db) >= wanted {
        return None;
    }
    let (mut low, mut high) = (1e-3, PI);
    for _ in 0..50 {
        let middle = (low * high).sqrt();
        if integral(middle, floor_db) < wanted { low = middle } else { high = middle }
    }
    Some((low * high).sqrt())
}

impl Antenna {
    /// One with the same gain in every direction.
    pub fn constant() -> Self {
        Antenna { axes: axes([1.0, 0.0, 0.0]), pattern: Pattern::Constant }
    }

    /// The element of a gain, its lowest level `floor_db` below the maximum, pointing along `towards`. Below 6 dB: constant gain.
    pub fn element(gain_db: f64, floor_db: f64, towards: Vec3) -> Self {
        let pattern = match width_of(gain_db, floor_db) {
            Some(width) => Pattern::Element { width, floor_db },
            None => Pattern::Constant,
        };
        Antenna { axes: axes(towards), pattern }
    }

    /// A scenario's radar's: its pattern, pointing at `radar.boresight_m` or else 1 m above where the person sensed begins.
    pub fn of(scenario: &Scenario) -> Self {
        let radar = &scenario.radar;
        let [x, y] = scenario.target.begin_m();
        let towards = sub(radar.boresight_m.unwrap_or([x, y, 1.0]), radar.position_m);
        let mut kept = PATTERNS.lock().unwrap_or_else(PoisonError::into_inner);
        let is_this = |(key, _): &&(Radar, Pattern)| {
            (key.antenna_pattern, &key.antenna_table) == (radar.antenna_pattern, &radar.antenna_table)
                && (key.antenna_gain_db, key.sidelobe_db) == (radar.antenna_gain_db, radar.sidelobe_db)
        };
        if let Some((_, pattern)) = kept.iter().find(is_this) {
            return Antenna { axes: axes(towards), pattern: pattern.clone() };
        }
        let antenna = match (radar.antenna_pattern, &radar.antenna_table) {
            (AntennaPattern::Element, _) => {
                Antenna::element(radar.antenna_gain_db, radar.sidelobe_db, towards)
            }
            // the file was read when the scenario was checked
            (AntennaPattern::Table, Some(file)) => match Table::read(file) {
                Ok(table) => Antenna { axes: axes(towards), pattern: Pattern::Table(Arc::new(table)) },
                Err(_) => Antenna::constant(),
            },
            _ => Antenna::constant(),
        };
        kept.insert(0, (radar.clone(), antenna.pattern.clone()));
        kept.truncate(KEPT);
        antenna
    }

    /// Unit vector that it looks along.
    pub fn boresight(&self) -> Vec3 {
        self.axes[0]
    }

    /// Whether every direction has the same gain.
    pub fn is_constant(&self) -> bool {
        matches!(self.pattern, Pattern::Constant)
    }

    /// Amplitude in a direction (not normalised), relative to boresight.
    pub fn amplitude(&self, direction: Vec3) -> f64 {
        self.amplitudes(&direction.map(|x| [x]))[0]
    }

    /// Those in N directions, `[axis][direction]`.
    #[inline(always)]
    pub fn amplitudes<const N: usize>(&self, directions: &Vec3<[f64; N]>) -> [f64; N] {
        if self.is_constant() {
            return [1.0; N];
        }
        vectorised(
            #[inline(always)]
            || {
                let [mut x, mut y, mut z, mut across] = [[0.0; N]; 4];
                for n in 0..N {
                    let direction = [directions[0][n], directions[1][n], directions[2][n]];
                    x[n] = dot(self.axes[0], direction);
                    y[n] = dot(self.axes[1], direction);
                    z[n] = dot(self.axes[2], direction);
                    across[n] = (x[n] * x[n] + y[n] * y[n]).sqrt();
                }
                let (azimuth, elevation) = (atan2(&y, &x), atan2(&z, &across));
                let mut levels_db = [0.0; N];
                match &self.pattern {
                    Pattern::Constant => {}
                    Pattern::Element { width, floor_db } => {
                        for n in 0..N {
                            levels_db[n] = element_db(azimuth[n], elevation[n], *width, *floor_db);
                        }
                    }
                    Pattern::Table(table) => {
                        for n in 0..N {
                            levels_db[n] = table.at(azimuth[n].to_degrees(), elevation[n].to_degrees());
                        }
                    }
                }
                amplitudes(levels_db)
            },
        )
    }

    /// Amplitude of a path that leaves and arrives by this antenna.
    pub fn weight(&self, path: &Path) -> f64 {
        self.weights([path])[0]
    }

    /// Those of N paths.
    pub fn weights<const N: usize>(&self, paths: [&Path; N]) -> [f64; N] {
        let towards = |direction: fn(&Path) -> Vec3| {
            self.amplitudes(&std::array::from_fn(|axis| paths.map(|path| direction(path)[axis])))
        };
        let out = towards(|path| path.departure);
        let back = match paths.iter().all(|path| path.arrival == path.departure) {
            true => out,
            false => towards(|path| path.arrival),
        };
        std::array::from_fn(|n| out[n] * back[n])
    }
}

/// Boresight, left and up; up as near to the room's as can be.
fn axes(towards: Vec3) -> [Vec3; 3] {
    let forward = scale(towards, 1.0 / norm(towards).max(1e-9));
    let [x, y, _] = forward;
    let across = (x * x + y * y).sqrt();
    let left = if across < 1e-6 { [0.0, 1.0, 0.0] } else { [-y / across, x / across, 0.0] };
    let up = [
        forward[1] * left[2] - forward[2] * left[1],
        forward[2] * left[0] - forward[0] * left[2],
        forward[0] * left[1] - forward[1] * left[0],
    ];
    [forward, left, up]
}

/// Where the far field of an aperture of this gain begins in m: 2 D^2 / lambda with G = (pi D / lambda)^2, hence 2 G lambda / pi^2.
pub fn far_field_m(gain_db: f64, carrier_hz: f64) -> f64 {
    2.0 * libm::pow(10.0, gain_db / 10.0) * wavelength(carrier_hz) / (PI * PI)
}

impl Table {
    /// A CSV of azimuth in degrees, elevation in degrees and gain in dB, a full grid in any order, one line of names first.
    ///
    /// # Errors
    ///
    /// The field and what is wrong with the file.
    pub fn read(file: &FilePath) -> Result<Self, Invalid> {
        let text = limited::read_text(file, limited::TEXT);
        let text = text.map_err(|error| refused(file, &error.to_string()))?;
        Self::parse(&text).map_err(|what| refused(file, &what))
    }

    fn parse(text: &str) -> Result<Self, String> {
        let mut rows: Vec<[f64; 3]> = Vec::new();
        let mut reader =
            csv::ReaderBuilder::new().has_headers(true).trim(csv::Trim::All).from_reader(text.as_bytes());
        for (line, record) in reader.records().enumerate() {
            let record = record.map_err(|error| error.to_string())?;
            let values: Vec<f64> = record.iter().filter_map(|field| field.parse().ok()).collect();
            let row: [f64; 3] = values
                .try_into()
                .map_err(|_| format!("line {} has no three numbers (azimuth, elevation, gain)", line + 2))?;
            if row.iter().any(|x| !x.is_finite()) || row[0].abs() > 180.0 || row[1].abs() > 90.0 {
                return Err(format!("line {} is outside -180 to 180 by -90 to 90 degrees", line + 2));
            }
            rows.push(row);
        }
        let axis = |k: usize| {
            let mut values: Vec<f64> = rows.iter().map(|row| row[k]).collect();
            values.sort_by(f64::total_cmp);
            values.dedup();
            values
        };
        let (azimuth, elevation) = (axis(0), axis(1));
        if azimuth.len() < 2 || elevation.len() < 2 || rows.len() != azimuth.len() * elevation.len() {
            return Err("is no full grid of two or more azimuths by two or more elevations".into());
        }
        rows.sort_by(|a, b| a[1].total_cmp(&b[1]).then(a[0].total_cmp(&b[0])));
        let on_grid = rows
            .iter()
            .enumerate()
            .all(|(k, row)| row[0] == azimuth[k % azimuth.len()] && row[1] == elevation[k / azimuth.len()]);
        if !on_grid {
            return Err("states a direction twice".into());
        }
        let most = rows.iter().map(|row| row[2]).fold(f64::NEG_INFINITY, f64::max);
        Ok(Table { gain_db: rows.iter().map(|row| row[2] - most).collect(), azimuth, elevation })
    }

    /// dB below the maximum, bilinear; directions outside the table have its nearest value.
    fn at(&self, azimuth_deg: f64, elevation_deg: f64) -> f64 {
        let place = |axis: &[f64], x: f64| {
            let after = axis.partition_point(|&a| a < x).clamp(1, axis.len() - 1);
            let (a, b) = (axis[after - 1], axis[after]);
            (after - 1, ((x - a) / (b - a)).clamp(0.0, 1.0))
        };
        let ((i, s), (j, t)) = (place(&self.azimuth, azimuth_deg), place(&self.elevation, elevation_deg));
        let value = |j: usize, i: usize| self.gain_db[j * self.azimuth.len() + i];
        let row = |j: usize| value(j, i) * (1.0 - s) + value(j, i + 1) * s;
        row(j) * (1.0 - t) + row(j + 1) * t
    }
}

fn refused(file: &FilePath, what: &str) -> Invalid {
    let legal = "a CSV of azimuth and elevation in degrees and gain in dB, a full grid";
    Invalid::new("radar.antenna_table", format!("{} ({what})", file.display()), legal)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::simulator::channel::Complex64;

    /// Directivity: 4 pi over the integral of the relative power over the sphere, by the midpoint rule.
    fn directivity(power: impl Fn(f64, f64) -> f64) -> f64 {
        let (rows, columns) = (720, 1440);
        let (de, da) = (PI / f64::from(rows), 2.0 * PI / f64::from(columns));
        let mut sum = 0.0;
        for row in 0..rows {
            let elevation = (f64::from(row) + 0.5) * de - PI / 2.0;
            let ring: f64 =
                (0..columns).map(|column| power((f64::from(column) + 0.5) * da - PI, elevation)).sum();
            sum += ring * libm::cos(elevation) * de * da;
        }
        4.0 * PI / sum
    }

    #[test]
    fn the_element_integrates_to_its_directivity_within_two_percent() {
        for (gain_db, floor_db) in [(8.0, 30.0), (15.0, 30.0), (25.0, 30.0), (25.0, 40.0), (33.0, 45.0)] {
            let width = width_of(gain_db, floor_db).unwrap();
            let found = directivity(|azimuth, elevation| {
                libm::pow(10.0, element_db(azimuth, elevation, width, floor_db) / 10.0)
            });
            let exact = libm::pow(10.0, gain_db / 10.0);
            assert!((found / exact - 1.0).abs() < 0.02, "{gain_db} dB: {found} of {exact}");
        }
    }

    #[test]
    fn half_the_power_is_left_at_half_the_beam_width() {
        let antenna = Antenna::element(25.0, 30.0, [0.0, 2.0, 0.0]);
        let Pattern::Element { width, .. } = antenna.pattern else { panic!("{antenna:?}") };
        assert!((width.to_degrees() - 10.3).abs() < 1.5, "{}", width.to_degrees());
        for (direction, db) in [
            ([0.0, 1.0, 0.0], 0.0),
            ([libm::sin(width / 2.0), libm::cos(width / 2.0), 0.0], -3.0),
            ([0.0, libm::cos(width / 2.0), libm::sin(width / 2.0)], -3.0),
            ([0.0, -1.0, 0.0], -30.0),
        ] {
            let found = 20.0 * libm::log10(antenna.amplitude(direction));
            assert!((found - db).abs() < 0.02, "{direction:?}: {found}");
        }
        assert_eq!(Antenna::constant().amplitude([0.3, -1.0, 0.2]), 1.0);
    }

    #[test]
    fn paths_are_weighed_by_departure_and_arrival_alike_eight_at_a_time() {
        let table = Table::parse("az,el,gain\n-90,-45,-20\n90,-45,-6\n-90,45,-12\n90,45,0\n").unwrap();
        let measured = Antenna { axes: axes([1.0, 1.0, 0.5]), pattern: Pattern::Table(Arc::new(table)) };
        for antenna in [Antenna::element(15.0, 30.0, [1.0, 0.5, -0.1]), measured] {
            for returns_apart in [0.0, 0.3] {
                let paths: [Path; 8] = std::array::from_fn(|n| {
                    let departure = [1.0, 0.2 * n as f64 - 0.7, 0.1];
                    let arrival = [1.0, departure[1] + returns_apart * (n % 3) as f64, 0.1];
                    Path { gain: Complex64::ONE, delay_s: 0.0, departure, arrival }
                });
                let weights = antenna.weights(paths.each_ref());
                for (path, weight) in paths.iter().zip(weights) {
                    let alone = antenna.amplitude(path.departure) * antenna.amplitude(path.arrival);
                    assert_eq!((weight, antenna.weight(path)), (alone, alone), "{path:?}");
                }
                // the floor is the same for several
                let mut differ = weights.to_vec();
                differ.dedup();
                assert!(differ.len() > 4, "{weights:?}");
            }
        }
    }

    #[test]
    fn an_aperture_of_25_decibels_is_in_its_far_field_from_5_metres_at_3_5_gigahertz() {
        assert!((far_field_m(25.0, 3.5e9) - 5.49).abs() < 0.01);
        assert!((far_field_m(25.0, 60e9) - 0.320).abs() < 0.001);
    }

    #[test]
    fn tables_are_interpolated_and_refused_by_line() {
        let table = Table::parse("az,el,gain\n-10,-10,1\n10,-10,3\n-10,10,5\n10,10,7\n").unwrap();
        assert_eq!(table.at(10.0, 10.0), 0.0);
        assert_eq!(table.at(0.0, 0.0), -3.0);
        assert_eq!(table.at(99.0, -99.0), -4.0);
        for (text, what) in [
            ("az,el,gain\n1,2\n", "line: 2"),
            ("az,el,gain\n0,0,1\n1,0,1\n0,95,1\n", "line 4"),
            ("az,el,gain\n0,0,1\n1,0,1\n0,1,1\n", "full grid"),
            ("az,el,gain\n0,0,1\n0,0,1\n0,1,1\n1,1,3\n", "twice"),
        ] {
            let error = Table::parse(text).unwrap_err();
            assert!(error.contains(what), "{text}: {error}");
        }
    }
}
