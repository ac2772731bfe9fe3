//! Table I of the paper, measured: five properties of every channel model, each a statistic held against a threshold.
//!
//! Consistency is asked of the link to a receiver that walks, motion and micro-Doppler of the radar's echo of a person, uncertainty of the
//! radar's channel while everything stands still. No statistic knows which model it is applied to. Where a standard defines no echo of
//! a person, motion and micro-Doppler are not asked: an echo that we made up would say nothing of the standard.

use super::{Complex64, Path, Scene, model, phasor, wavelength};
use crate::numerics::random::Random;
use crate::results::{ChannelTable, ModelRow, Property};
use crate::scenario::{Class, Model, Scenario};
use crate::simulator::body::gait::joint;
use crate::simulator::body::motion::{GroundTruth, Person};
use crate::simulator::body::{Vec3, dot, norm, scale, sub};
use crate::simulator::channel::ieee80211ay::unit;
use crate::simulator::channel::target::Target;
use rayon::prelude::*;
use std::collections::BTreeMap;
use std::f64::consts::{PI, TAU};

/// Stream number of the experiments.
const STREAM: u64 = 201;
/// Memory of the models that have one: the paper's.
const RHO: f64 = 0.997;
/// Receivers dropped for the consistency statistics.
const USERS: u64 = 120;
/// People drawn for the motion statistics.
const PEOPLE: u64 = 12;
/// Slots of a recording: 1 s at the default frame.
const SLOTS: u32 = 1000;
/// Slots let pass first, for a memory's first response to fade.
const SETTLE: u32 = 2000;

/// Names of the properties, in their order.
pub const PROPERTIES: [&str; 5] = [
    "large_scale_consistency",
    "small_scale_consistency",
    "motion_consistency",
    "micro_doppler",
    "sensing_uncertainty",
];

/// What the paper's Table I says of a model: the same five, `None` where it has no row.
fn paper(model: Model) -> Option<[bool; 5]> {
    match model {
        Model::Dahc => Some([true, true, true, true, true]),
        Model::Primitive | Model::RayTracing => Some([true, true, true, true, false]),
        Model::Statistical => Some([true, false, false, false, false]),
        Model::Ieee80211ay | Model::Tr38901 | Model::Quadriga | Model::Metis => {
            Some([true, true, false, false, false])
        }
        Model::Ieee80211ax => None,
    }
}

/// Whether a model says how a moving person echoes.
fn has_echo(model: Model) -> bool {
    !matches!(
        model,
        Model::Statistical | Model::Ieee80211ay | Model::Ieee80211ax | Model::Quadriga | Model::Metis
    )
}

/// Why a verdict may differ from the paper's, or is not given.
fn reason(model: Model, property: &str) -> &'static str {
    match (model, property) {
        (_, "motion_consistency" | "micro_doppler") if !has_echo(model) => {
            "not defined: the standard has no echo of a moving person"
        }
        (Model::Tr38901, "motion_consistency") => {
            "the paper cites the release before sensing; the sensing additions (clause 7.9) give the person a scatterer \
             that moves with it"
        }
        (Model::Statistical, "small_scale_consistency" | "sensing_uncertainty") => {
            "Saleh and Valenzuela state no temporal correlation, as the paper says; here their rays fade by TGn's Doppler spectrum \
             (channel.doppler)"
        }
        (Model::Ieee80211ax, _) => "the paper's table has no row for it",
        _ => "",
    }
}

pub fn table(scenario: &Scenario, seed: u64, progress: &(dyn Fn(u64, u64) + Sync)) -> ChannelTable {
    let models = Model::ALL.iter().enumerate().map(|(n, &name)| {
        let mut scenario = scenario.clone();
        scenario.channel.model = name;
        let row = row(&scenario, seed);
        progress(n as u64 + 1, Model::ALL.len() as u64);
        row
    });
    ChannelTable { seed, carrier_hz: scenario.radar.carrier_hz, models: models.collect() }
}

fn row(scenario: &Scenario, seed: u64) -> ModelRow {
    let name = scenario.channel.model;
    let (large, small) = consistency(scenario, seed);
    let moving = |statistic: fn(&Scenario, u64) -> f64| has_echo(name).then(|| statistic(scenario, seed));
    let found = [
        (
            Some(large),
            Limit::AtLeast(0.5),
            "correlation, over receivers, of the local mean power (dB) half a metre apart",
        ),
        (
            Some(small),
            Limit::AtLeast(0.9),
            "least correlation of response, delay spread, mean delay and mean angle over 1 mm and 1 ms",
        ),
        (
            moving(motion),
            Limit::AtMost(0.05),
            "median relative error of the Doppler of a rigid body that moves at 1 m/s",
        ),
        (
            moving(micro_doppler),
            Limit::AtLeast(15.0),
            "density at limb speeds (1.5 to 5 times the torso's) over that beyond (5.5 to 8) and 40 dB below the torso's, dB, median",
        ),
        (
            Some(uncertainty(scenario, seed)),
            Limit::AtLeast(1e-6),
            "share of the power that the last slot does not predict while nothing moves",
        ),
    ];
    let expected = paper(name);
    let properties: BTreeMap<String, Property> = PROPERTIES
        .iter()
        .zip(found)
        .enumerate()
        .map(|(n, (property, (statistic, limit, meaning)))| {
            let verdict = statistic.map(|statistic| limit.holds(statistic));
            let paper = expected.map(|row| row[n]);
            let differs = paper.is_none() || paper != verdict;
            let reason = if differs { reason(name, property).to_owned() } else { String::new() };
            let (threshold, relation) = limit.shown();
            let meaning = meaning.to_owned();
            (
                property.to_string(),
                Property { verdict, statistic, threshold, relation, meaning, paper, reason },
            )
        })
        .collect();
    ModelRow { name: name.name().to_owned(), properties }
}

/// On which side of a threshold a property holds.
#[derive(Debug, Clone, Copy)]
enum Limit {
    AtLeast(f64),
    AtMost(f64),
}

impl Limit {
    fn holds(self, x: f64) -> bool {
        match self {
            Limit::AtLeast(t) => x >= t,
            Limit::AtMost(t) => x <= t,
        }
    }

    fn shown(self) -> (f64, String) {
        match self {
            Limit::AtLeast(t) => (t, ">=".into()),
            Limit::AtMost(t) => (t, "<=".into()),
        }
    }
}

/// Frequencies at which a response is sampled, in Hz.
const FREQUENCIES: [f64; 4] = [-3.75e6, -1.25e6, 1.25e6, 3.75e6];

/// A snapshot of a link.
#[derive(Debug, Clone, Copy)]
struct Snapshot {
    response: [Complex64; FREQUENCIES.len()],
    power: f64,
    spread: f64,
    delay: f64,
    angle: Vec3,
}

fn snapshot(paths: &[Path]) -> Snapshot {
    let power: f64 = paths.iter().map(|p| p.gain.norm_sqr()).sum();
    let mean = |f: &dyn Fn(&Path) -> f64| -> f64 {
        paths.iter().map(|p| p.gain.norm_sqr() * f(p)).sum::<f64>() / power.max(f64::MIN_POSITIVE)
    };
    let delay = mean(&|p| p.delay_s);
    let spread = mean(&|p| (p.delay_s - delay) * (p.delay_s - delay)).sqrt();
    let angle = std::array::from_fn(|axis| mean(&|p| p.arrival[axis]));
    let response =
        FREQUENCIES.map(|f| paths.iter().map(|p| p.gain * phasor(-TAU * f * p.delay_s)).sum::<Complex64>());
    Snapshot { response, power, spread, delay, angle }
}

/// Correlation coefficient of paired numbers; 1 where neither varies.
fn correlation(pairs: &[(f64, f64)]) -> f64 {
    let n = pairs.len() as f64;
    let (mx, my) = pairs.iter().fold((0.0, 0.0), |(x, y), p| (x + p.0 / n, y + p.1 / n));
    let (mut xx, mut yy, mut xy) = (0.0, 0.0, 0.0);
    for (x, y) in pairs {
        xx += (x - mx) * (x - mx);
        yy += (y - my) * (y - my);
        xy += (x - mx) * (y - my);
    }
    let scale = (mx * mx + my * my) * n * 1e-24;
    if xx <= scale && yy <= scale { 1.0 } else { xy / (xx * yy).sqrt().max(f64::MIN_POSITIVE) }
}

/// Large- and small-scale consistency: receivers walk 0.6 m at 1 m/s, a slot every millimetre.
fn consistency(scenario: &Scenario, seed: u64) -> (f64, f64) {
    let station = scenario.radar.position_m;
    let walks: Vec<(Vec<Snapshot>, Snapshot, Snapshot)> = (0..USERS)
        .into_par_iter()
        .map(|index| {
            let mut random = Random::new(seed, STREAM, 0, index);
            let start = receiver(scenario, &mut random);
            let angle = TAU * random.uniform();
            let direction = [libm::cos(angle), libm::sin(angle), 0.0];
            let mut channel = model(scenario, station, start, RHO, random);
            // what is looked at; the first slots show one and the same draw of every model's start
            let stretches = [0..100, 200..230, 500..600];
            let mut seen = [const { Vec::new() }; 3];
            let mut paths = Vec::new();
            for slot in 0..600 {
                let to = std::array::from_fn(|k| start[k] + 1e-3 * f64::from(slot) * direction[k]);
                paths.clear();
                let scene = Scene { slot, time_s: f64::from(slot) * 1e-3, from: station, to, people: &[] };
                channel.paths(&scene, &mut paths);
                if let Some(k) = stretches.iter().position(|slots| slots.contains(&slot)) {
                    seen[k].push(snapshot(&paths));
                }
            }
            let [first, middle, last] = seen;
            (middle, local(&first), local(&last))
        })
        .collect();
    let pairs = |f: &dyn Fn(&Snapshot) -> f64| -> Vec<(f64, f64)> {
        walks.iter().map(|(_, first, last)| (f(first), f(last))).collect()
    };
    let large = correlation(&pairs(&|l| libm::log10(l.power)));
    let neighbours = |f: &dyn Fn(&Snapshot) -> f64| -> f64 {
        let pairs: Vec<(f64, f64)> = walks
            .iter()
            .flat_map(|(snapshots, ..)| {
                snapshots.windows(2).map(|pair| (f(&pair[0]), f(&pair[1]))).collect::<Vec<_>>()
            })
            .collect();
        correlation(&pairs)
    };
    let (mut product, mut power) = (Complex64::default(), 0.0);
    for (snapshots, ..) in &walks {
        for pair in snapshots.windows(2) {
            // each walk counts alike, near or far
            let energy: f64 = pair.iter().flat_map(|l| l.response).map(|h| h.norm_sqr()).sum::<f64>() / 2.0;
            let inner: Complex64 =
                pair[0].response.iter().zip(&pair[1].response).map(|(a, b)| a * b.conj()).sum();
            product += inner / energy.max(f64::MIN_POSITIVE);
            power += 1.0;
        }
    }
    let small = [
        product.norm() / power,
        neighbours(&|l| l.spread),
        neighbours(&|l| l.delay),
        neighbours(&|l| l.angle[0]),
        neighbours(&|l| l.angle[1]),
    ];
    (large, small.into_iter().fold(f64::INFINITY, f64::min))
}

/// A receiver at 1 m height, at least 0.7 m from the walls and from the base station.
fn receiver(scenario: &Scenario, random: &mut Random) -> Vec3 {
    loop {
        let size = scenario.room.size_m;
        let within = |random: &mut Random, size: f64| 0.7 + (size - 1.4).max(0.0) * random.uniform();
        let place = [within(random, size[0]), within(random, size[1]), 1.0];
        if norm(sub(place, scenario.radar.position_m)) > 0.7 {
            return place;
        }
    }
}

/// Means over a stretch, which average the fading out.
fn local(snapshots: &[Snapshot]) -> Snapshot {
    let n = snapshots.len() as f64;
    let mut mean = snapshots[0];
    mean.power =
        snapshots.iter().map(|l| l.response.iter().map(|h| h.norm_sqr()).sum::<f64>()).sum::<f64>() / n;
    mean
}

/// The radar's slow-time signal of a person, the mean taken off; `settle` slots pass before.
fn slow_time(scenario: &Scenario, people: &[Target], random: Random, settle: u32) -> Vec<Complex64> {
    let radar = scenario.radar.position_m;
    let mut channel = model(scenario, radar, radar, RHO, random);
    let mut paths = Vec::new();
    let mut signal: Vec<Complex64> = (0..settle + SLOTS)
        .filter_map(|slot| {
            // the person starts when the room has settled
            let time_s = f64::from(slot.saturating_sub(settle)) * scenario.interval_s();
            paths.clear();
            channel.paths(&Scene { slot, time_s, from: radar, to: radar, people }, &mut paths);
            (slot >= settle).then(|| paths.iter().map(|p| p.gain).sum())
        })
        .collect();
    let power = |signal: &[Complex64]| signal.iter().map(|z| z.norm_sqr()).sum::<f64>();
    let before = power(&signal);
    let mean: Complex64 = signal.iter().sum::<Complex64>() / f64::from(SLOTS);
    signal.iter_mut().for_each(|z| *z -= mean);
    if power(&signal) < 1e-24 * before {
        // nothing moved: what is left is rounding
        signal.fill(Complex64::default());
    }
    signal
}

/// Power at Doppler frequency `hz`: a Blackman-windowed, zero-padded snapshot.
fn spectrum(signal: &[Complex64], interval_s: f64) -> Vec<(f64, f64)> {
    let n = 4096;
    let mut x: Vec<Complex64> = signal
        .iter()
        .enumerate()
        .map(|(k, z)| {
            let t = TAU * (k as f64 + 0.5) / signal.len() as f64;
            z * (0.42 - 0.5 * libm::cos(t) + 0.08 * libm::cos(2.0 * t))
        })
        .collect();
    x.resize(n, Complex64::default());
    rustfft::FftPlanner::new().plan_fft_forward(n).process(&mut x);
    (0..n)
        .map(|k| {
            let bin = if k < n / 2 { k as f64 } else { k as f64 - n as f64 };
            (bin / (n as f64 * interval_s), x[k].norm_sqr())
        })
        .collect()
}

/// A person who walks towards the radar; its torso's analytic Doppler in Hz at mid-recording.
fn walker(scenario: &Scenario, random: &mut Random) -> Target {
    let mut target = scenario.target.clone();
    target.heading_spread_deg = 15.0;
    let (room, radar) = (scenario.room.size_m, scenario.radar.position_m);
    Target::new(Person::draw(Class::AdultWalking, &target, room, radar, random), random)
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

/// Motion consistency: a rigid body at 1 m/s against 2 v_r / lambda.
fn motion(scenario: &Scenario, seed: u64) -> f64 {
    let lambda = wavelength(scenario.radar.carrier_hz);
    let errors = (0..PEOPLE).into_par_iter().map(|index| {
        let mut random = Random::new(seed, STREAM, 1, index);
        let radar = scenario.radar.position_m;
        let truth = GroundTruth::standing(1.75, [1.5 + 0.8 * (random.uniform() - 0.5), 3.8]);
        let person = Person::new(truth, scenario.room.size_m, &mut random);
        let mut target = Target::new(person, &mut random);
        let towards = unit(sub(radar, target.centre(0.0)));
        let velocity = unit([towards[0], towards[1], 0.0]);
        target.rigid = Some(velocity);
        let signal = slow_time(scenario, std::slice::from_ref(&target), random, SETTLE);
        let middle = target.centre(0.5 * f64::from(SLOTS) * scenario.interval_s());
        let exact = 2.0 * dot(velocity, unit(sub(radar, middle))) / lambda;
        // what is slower than a fifth of it is the room's
        let fastest = spectrum(&signal, scenario.interval_s())
            .into_iter()
            .filter(|(hz, _)| hz.abs() > 0.2 * exact.abs())
            .max_by(|a, b| a.1.total_cmp(&b.1));
        match fastest {
            Some((hz, power)) if power > 0.0 => (hz / exact - 1.0).abs(),
            _ => 1.0,
        }
    });
    median(errors.collect())
}

/// Micro-Doppler: power density at limb speeds over that beyond them, in dB, of a walker. A spectrum that just falls as 1 / f^2, as a
/// fading channel's does, reaches 12 dB; one line, however clean, none.
fn micro_doppler(scenario: &Scenario, seed: u64) -> f64 {
    let lambda = wavelength(scenario.radar.carrier_hz);
    let ratios = (0..PEOPLE).into_par_iter().map(|index| {
        let mut random = Random::new(seed, STREAM, 2, index);
        let target = walker(scenario, &mut random);
        let (place, velocity) = target.person.kinematics(0.5)[joint::BASE];
        let radial = dot(velocity, unit(sub(scenario.radar.position_m, place)));
        let torso = 2.0 * target.person.truth.speed_m_s.max(radial.abs()) / lambda;
        let signal = slow_time(scenario, &[target], random, SETTLE);
        let spectrum = spectrum(&signal, scenario.interval_s());
        let total: f64 = spectrum.iter().map(|s| s.1).sum();
        let density = |low: f64, high: f64| -> f64 {
            let band: Vec<f64> = spectrum
                .iter()
                .filter(|(hz, _)| (low * torso..high * torso).contains(&hz.abs()))
                .map(|s| s.1)
                .collect();
            band.iter().sum::<f64>() / band.len().max(1) as f64
        };
        // a silent spectrum has the density of rounding on both sides
        let floor = 1e-30 * total + f64::MIN_POSITIVE;
        let beyond = density(5.5, 8.0) + 1e-4 * density(0.5, 1.5);
        10.0 * libm::log10((density(1.5, 5.0) + floor) / (beyond + floor))
    });
    median(ratios.collect())
}

/// Sensing uncertainty: 1 - |correlation of neighbouring slots|^2 while nothing moves.
fn uncertainty(scenario: &Scenario, seed: u64) -> f64 {
    let shares = (0..PEOPLE).into_par_iter().map(|index| {
        let mut random = Random::new(seed, STREAM, 3, index);
        let mut target = walker(scenario, &mut random);
        target.rigid = Some(scale([1.0, 0.0, 0.0], 0.0));
        let radar = scenario.radar.position_m;
        let mut channel = model(scenario, radar, radar, RHO, random);
        let people = [target];
        let (mut cross, mut power) = (Complex64::default(), 0.0);
        let mut last: Option<Complex64> = None;
        let mut paths = Vec::new();
        for slot in 0..SETTLE + SLOTS {
            let time_s = f64::from(slot) * scenario.interval_s();
            paths.clear();
            channel.paths(&Scene { slot, time_s, from: radar, to: radar, people: &people }, &mut paths);
            let h: Complex64 = paths.iter().map(|p| p.gain * phasor(PI * p.delay_s * 1e6)).sum();
            if let Some(last) = last.replace(h)
                && slot > SETTLE
            {
                cross += h * last.conj();
                power += 0.5 * (h.norm_sqr() + last.norm_sqr());
            }
        }
        let share = 1.0 - cross.norm_sqr() / (power * power);
        // what rounding leaves is nothing
        if share < 1e-12 { 0.0 } else { share }
    });
    median(shares.collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn correlation_knows_its_extremes() {
        let line: Vec<(f64, f64)> = (0..9).map(|x| (f64::from(x), 3.0 - 2.0 * f64::from(x))).collect();
        assert!((correlation(&line) + 1.0).abs() < 1e-12);
        assert_eq!(correlation(&[(2.0, 2.0), (2.0, 2.0)]), 1.0);
    }
}
