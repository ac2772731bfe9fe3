//! A recording: a function of (scenario, rho, seed, set, class, index) alone.
//!
//! People, channel, noise and impairments draw from streams of their own, slot after slot, so that the first n slots do not
//! depend on how many follow. The same recording exists twice: as raw slots, and as the beats the core would make of them,
//! formed without the samples in between.

use super::body::Vec3;
use super::body::capture::Capture;
use super::body::gait::joint;
use super::body::motion::{GroundTruth, Person};
use super::channel::target::Target;
use super::channel::{Blocks, ChannelModel, Path, Scene, Sensor, model};
use super::radar::{Draws, Receiver};
use crate::formats::slots::Slots;
use crate::numerics::random::Random;
use crate::scenario::{AntennaPattern, Class, Scenario};
use sdp3_core::dims::Beat;
use std::cell::Cell;

/// What a recording is for; recordings of different sets share nothing.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Set {
    /// Learning.
    Train,
    /// Testing.
    Test,
    /// Simulated signals of the calibration.
    Calibration,
    /// Surrogate of a measurement when none is given.
    Surrogate,
    /// Pictures and demonstrations.
    Demo,
}

/// Raw slots and what is true of them.
#[derive(Debug, Clone)]
pub struct Recording {
    /// Sensing slots, in order.
    pub slots: Slots,
    /// The person.
    pub truth: GroundTruth,
}

/// The radar's channel in a recording, slot after slot.
pub struct Simulation<'a> {
    scenario: &'a Scenario,
    people: Vec<Target>,
    channel: Box<dyn ChannelModel>,
    sensor: Sensor,
    front: f64,
    taken: u32,
    paths: Vec<Path>,
}

/// Random streams of a recording.
fn stream(seed: u64, set: Set, part: u64, class: Class, index: u32) -> Random {
    Random::new(seed, set as u64 * 8 + part, class as u64, u64::from(index))
}

/// The scene of a recording's sensing slot.
fn scene<'p>(scenario: &Scenario, slot: u32, people: &'p [Target]) -> Scene<'p> {
    let radar = scenario.radar.position_m;
    Scene { slot, time_s: f64::from(slot) * scenario.interval_s(), from: radar, to: radar, people }
}

impl<'a> Simulation<'a> {
    /// Draws the people and the room.
    pub fn new(scenario: &'a Scenario, rho: f64, seed: u64, set: Set, class: Class, index: u32) -> Self {
        let mut random = stream(seed, set, 0, class, index);
        let radar = scenario.radar.position_m;
        Simulation {
            people: scene_people(scenario, class, &mut random),
            channel: model(scenario, radar, radar, rho, stream(seed, set, 1, class, index)),
            sensor: Sensor::of(scenario),
            // transmit power and both antennas at boresight
            front: scenario.radar.power_w.sqrt() * libm::pow(10.0, scenario.radar.antenna_gain_db / 10.0),
            taken: 0,
            paths: Vec::new(),
            scenario,
        }
    }

    /// What is true of the person.
    pub fn truth(&self) -> &GroundTruth {
        &self.people[0].person.truth
    }

    /// The paths of the next sensing slot, with their amplitudes at the receiver in sqrt W.
    pub fn advance(&mut self) -> &[Path] {
        let mut paths = std::mem::take(&mut self.paths);
        paths.clear();
        self.channel.paths(&scene(self.scenario, self.taken, &self.people), &mut paths);
        self.taken += 1;
        let (front, antenna) = (self.front, &self.sensor.antenna);
        match antenna.is_constant() {
            true => paths.iter_mut().for_each(|path| path.gain *= front),
            false => paths.iter_mut().for_each(|path| path.gain *= front * antenna.weight(path)),
        }
        self.paths = paths;
        &self.paths
    }

    /// The range samples of the next `count` sensing slots by the radar's response, without noise.
    pub fn advance_blocks(&mut self, count: u32) -> Vec<Blocks> {
        self.advance_blocks_in(Vec::new(), count)
    }

    /// The same in memory that was that of other range samples.
    fn advance_blocks_in(&mut self, mut beats: Vec<Blocks>, count: u32) -> Vec<Blocks> {
        beats.clear();
        beats.resize(count as usize, Blocks::default());
        let scene = scene(self.scenario, self.taken, &self.people);
        self.channel.beats(&scene, self.scenario.interval_s(), &self.sensor, &mut beats);
        self.taken += count;
        beats.iter_mut().flatten().for_each(|z| *z *= self.front);
        beats
    }

    /// The part of the next `count` slots' range samples that rho does not change, for [`Simulation::with_fluctuation`].
    pub fn steady_blocks(&mut self, count: u32) -> Vec<Blocks> {
        let mut beats = vec![Blocks::default(); count as usize];
        let scene = scene(self.scenario, self.taken, &self.people);
        self.channel.steady_beats(&scene, self.scenario.interval_s(), &self.sensor, &mut beats);
        self.taken += count;
        beats
    }

    /// The range samples of the next slots, of which an equal simulation has made the steady part, at whatever rho: as
    /// [`Simulation::advance_blocks`] has them but for rounding.
    pub fn with_fluctuation(&mut self, steady: &[Blocks]) -> Vec<Blocks> {
        let mut beats = steady.to_vec();
        self.channel.fluctuation(&self.sensor, &mut beats);
        self.taken += steady.len() as u32;
        beats.iter_mut().flatten().for_each(|z| *z *= self.front);
        beats
    }

    /// Where the person is now; for warnings.
    pub fn place(&self) -> Vec3 {
        let scene = scene(self.scenario, self.taken, &self.people);
        self.people[0].person.joints(scene.time_s)[joint::BASE]
    }
}

/// Everybody in the room: the person of the recording first.
pub(crate) fn scene_people(scenario: &Scenario, class: Class, random: &mut Random) -> Vec<Target> {
    let (room, radar) = (scenario.room.size_m, scenario.radar.position_m);
    let mut person = Person::draw(class, &scenario.target, room, radar, random);
    if let Some(capture) = scenario.target.capture.as_ref().and_then(|file| Capture::shared(file).ok()) {
        // a captured motion starts where the scenario says, also near a wall
        person.truth.start_m = scenario.target.begin_m();
        person = Person::captured(person.truth, capture);
    }
    let mut people = vec![Target::new(person, random)];
    // an antenna without a pattern looks at the person of the recording, and sees others by its side lobes, out and back
    let side = match scenario.radar.antenna_pattern {
        AntennaPattern::Constant => libm::pow(10.0, -2.0 * scenario.radar.sidelobe_db / 20.0),
        _ => 1.0,
    };
    let mut other = |class: Class, start_m: [f64; 2], heading_deg: Option<f64>, random: &mut Random| {
        let mut target = scenario.target.clone();
        (target.start_m, target.heading_spread_deg) = (start_m, 180.0);
        target.waypoints_m.clear();
        let drawn = Person::draw(class, &target, room, radar, random);
        let mut truth = drawn.truth.clone();
        truth.heading_deg = heading_deg.unwrap_or(truth.heading_deg);
        let person = Person::new(truth, room, random);
        let mut target = Target::new(person, random);
        target.gain = side;
        people.push(target);
    };
    if scenario.channel.interferer {
        // a second adult walks on the other side of the room, as far from the radar
        let start = [room[0] - scenario.target.start_m[0], scenario.target.start_m[1]];
        other(Class::AdultWalking, start, None, random);
    }
    for person in &scenario.target.others {
        other(person.class, person.start_m, person.heading_deg, random);
    }
    people
}

/// The person of a recording.
pub(crate) fn target_of(scenario: &Scenario, seed: u64, set: Set, class: Class, index: u32) -> Target {
    scene_people(scenario, class, &mut stream(seed, set, 0, class, index)).swap_remove(0)
}

/// The radar's channel and its receiver in a recording.
pub struct Recorder<'a> {
    simulation: Simulation<'a>,
    receiver: Receiver<'a>,
}

impl<'a> Recorder<'a> {
    /// Of the recording with these coordinates.
    pub fn new(scenario: &'a Scenario, rho: f64, seed: u64, set: Set, class: Class, index: u32) -> Self {
        let receiver = Receiver::new(scenario, |draws| {
            let part = match draws {
                Draws::Noise => 2,
                Draws::Phases => 3,
                Draws::Module => 4,
                Draws::Oscillator => 5,
            };
            stream(seed, set, part, class, index)
        });
        Recorder { simulation: Simulation::new(scenario, rho, seed, set, class, index), receiver }
    }

    /// The next raw slots, in memory that was that of others.
    pub fn slots(&mut self, memory: Vec<i16>, count: u32) -> Slots {
        let per_slot = self.simulation.scenario.radar.config().values_per_slot();
        let mut raw = Slots::in_memory(memory, per_slot, count as usize);
        (0..count).for_each(|_| self.receiver.slot(self.simulation.advance(), &mut raw.values));
        raw
    }

    /// What the core makes of the next raw slots, to -60 dB of the signal; the noise is drawn per range sample, with the covariance it
    /// has there.
    fn beats(&mut self, count: u32) -> Vec<Beat> {
        if self.receiver.needs_samples() {
            let config = self.simulation.scenario.radar.config();
            return self.slots(Vec::new(), count).beats(config).unwrap_or_default();
        }
        let blocks = self.simulation.advance_blocks_in(SPARE.take(), count);
        let beats = self.receiver.beats(&blocks);
        SPARE.set(blocks);
        beats
    }

    /// What is true of the person.
    pub fn truth(&self) -> &GroundTruth {
        self.simulation.truth()
    }
}

thread_local! {
    /// The last recording's range samples: fresh memory costs a fault a page.
    static SPARE: Cell<Vec<Blocks>> = const { Cell::new(Vec::new()) };
}

/// The recording with these coordinates.
pub fn recording(
    scenario: &Scenario,
    rho: f64,
    seed: u64,
    set: Set,
    class: Class,
    index: u32,
    slots: u32,
) -> Recording {
    let mut recorder = Recorder::new(scenario, rho, seed, set, class, index);
    Recording { slots: recorder.slots(Vec::new(), slots), truth: recorder.truth().clone() }
}

/// The same recording as beats.
pub fn beats(
    scenario: &Scenario,
    rho: f64,
    seed: u64,
    set: Set,
    class: Class,
    index: u32,
    slots: u32,
) -> (Vec<Beat>, GroundTruth) {
    let mut recorder = Recorder::new(scenario, rho, seed, set, class, index);
    (recorder.beats(slots), recorder.truth().clone())
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use crate::scenario::builtin::named;
    use crate::scenario::{ArMode, Clusters, FrontEnd, Model};

    fn shipped(name: &str) -> Scenario {
        named(name.as_ref()).unwrap().scenario()
    }

    /// The same with a real module's front end.
    fn typical(name: &str) -> Scenario {
        let mut scenario = shipped(name);
        scenario.radar.front_end = FrontEnd::Typical;
        scenario
    }

    #[test]
    fn a_recording_depends_on_its_coordinates_alone() {
        let models = Model::ALL.map(|model| {
            let mut scenario = Scenario::default();
            scenario.channel.model = model;
            scenario
        });
        let real = ["conference-room", "bgt60", "iwr"].map(typical);
        for scenario in models.into_iter().chain([shipped("bgt60"), shipped("iwr")]).chain(real) {
            let take =
                |index, slots| recording(&scenario, 0.997, 5, Set::Train, Class::AdultWalking, index, slots);
            let (long, short) = (take(3, 40), take(3, 25));
            assert_eq!(long.slots.first(25), short.slots.values, "{}", scenario.name);
            assert_eq!((long.slots.len(), short.slots.len()), (40, 25));
            assert_ne!(take(4, 25).slots, short.slots, "{}", scenario.name);
            assert_eq!(long.truth, short.truth);
        }
    }

    /// FNV-1a of numbers' bytes.
    fn digest(bytes: impl Iterator<Item = u8>) -> u64 {
        bytes
            .fold(0xcbf2_9ce4_8422_2325, |hash, byte| (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3))
    }

    #[test]
    fn recordings_of_the_papers_radar_keep_their_bits() {
        // digests of raw slots, beats and block means of commit 2205390, before radars had other sweeps; the models of
        // 802.11ay (signs of reflections), 802.11ax (plane waves), 38901 (the whole procedure) and METIS have new laws since
        let golden = [
            [0x8b41_2ecc_533d_667a, 0x5725_5606_4928_81fe, 0x506f_1bb0_6814_fcd8],
            [0xe52a_d5b1_d62c_264c, 0xf800_04fc_0aa4_2d3e, 0x4b18_2f8a_bea1_f9ae],
            [0xff05_0d67_2c5f_de9d, 0xade6_9337_f458_2482, 0x9288_df77_52c3_8818],
            [0x46a9_b2bd_c105_c30e, 0x8471_2587_a029_51fa, 0x5660_b932_8fc7_c204],
            [0xa61e_c8d1_3d94_2318, 0x8fa4_693a_838b_3b88, 0x9696_a9ab_c181_7415],
            [0x7a3f_c81c_1618_4d08, 0x8376_f618_c88b_b3f2, 0x7e18_379f_2a65_0d68],
            [0x6c47_742d_27e0_1da9, 0x8c73_ef49_5ab0_65cf, 0x8740_2caa_cd92_3705],
            [0xdaea_5797_1daa_4560, 0xb9a4_f445_e81f_8533, 0x8e8c_89ca_a441_98a1],
            [0xa383_f43c_27ea_0c2d, 0xa904_1617_4869_21e2, 0x3f13_d6a1_a9b9_19b9],
        ];
        for (k, (model, golden)) in Model::ALL.into_iter().zip(golden).enumerate() {
            let mut s = shipped("as-printed");
            s.channel.model = model;
            if k % 2 == 1 {
                s.radar.carrier_hz = 60e9;
                (s.channel.interferer, s.channel.clusters) = (true, Clusters::Ieee80211ay);
            }
            if k % 3 == 2 {
                s.radar.phase_noise_deg = 3.0;
                (s.radar.iq_gain_db, s.radar.iq_phase_deg) = (Some(1.0), Some(2.0));
            }
            let class = Class::ALL[k % 5];
            let raw = recording(&s, 0.997, 9, Set::Test, class, 2, 20).slots;
            let beats = beats(&s, 0.997, 9, Set::Train, class, 3, 40).0;
            let blocks = Simulation::new(&s, 0.99, 7, Set::Surrogate, class, 1).advance_blocks(30);
            let found = [
                digest(raw.to_le_bytes().into_iter()),
                digest(beats.iter().flatten().flat_map(|z| [z.re, z.im]).flat_map(i32::to_le_bytes)),
                digest(blocks.iter().flatten().flat_map(|z| [z.re, z.im]).flat_map(f64::to_le_bytes)),
            ];
            assert_eq!(found, golden, "{model:?}: {found:x?}");
        }
    }

    /// Power of the difference between range samples made of raw slots and those made without, over their own, in dB.
    pub(crate) fn disagreement(scenario: &Scenario) -> f64 {
        let raw = recording(scenario, 0.997, 5, Set::Train, Class::AdultWalking, 0, 60);
        let (fast, truth) = beats(scenario, 0.997, 5, Set::Train, Class::AdultWalking, 0, 60);
        assert_eq!(raw.truth, truth);
        let (mut error, mut power) = (0.0, 0.0);
        for (raw, fast) in raw.slots.beats(scenario.radar.config()).unwrap().iter().zip(&fast) {
            for (a, b) in raw.iter().zip(fast) {
                let (re, im) = (f64::from(a.re - b.re), f64::from(a.im - b.im));
                error += re * re + im * im;
                power += f64::from(a.re) * f64::from(a.re) + f64::from(a.im) * f64::from(a.im);
            }
        }
        10.0 * libm::log10(error / power)
    }

    #[test]
    fn a_fluctuation_on_the_steady_part_of_another_rho_makes_the_same_beats() {
        let as_set = Model::ALL.map(|model| (model, ArMode::Rician));
        for (model, mode) in as_set.into_iter().chain([(Model::Dahc, ArMode::Paper)]) {
            let mut scenario = Scenario::default();
            (scenario.channel.model, scenario.channel.mode) = (model, mode);
            let of = |rho| Simulation::new(&scenario, rho, 7, Set::Calibration, Class::AdultWalking, 2);
            let whole = of(0.99).advance_blocks(300);
            let sum = of(0.99).with_fluctuation(&of(1.0).steady_blocks(300));
            let error: f64 =
                whole.iter().flatten().zip(sum.iter().flatten()).map(|(a, b)| (a - b).norm_sqr()).sum();
            let power: f64 = whole.iter().flatten().map(|z| z.norm_sqr()).sum();
            assert!(power > 0.0 && error < 1e-28 * power, "{model:?} {mode:?}: {error:e} of {power:e}");
        }
    }

    #[test]
    fn raw_slots_and_beats_agree_to_sixty_decibels() {
        // without a converter's noise: its full scale is brought down to the signal
        let at = |model, carrier_hz| {
            let mut scenario = Scenario::default();
            scenario.channel.model = model;
            scenario.radar.carrier_hz = carrier_hz;
            scenario.radar.front_end = FrontEnd::Ideal;
            (scenario.radar.iq_gain_db, scenario.radar.iq_phase_deg) = (Some(1.0), Some(2.0));
            scenario
        };
        let fine = |name: &str| {
            // the 12 bits of a small converter would round more than that away
            let mut scenario = shipped(name);
            scenario.radar.front_end = FrontEnd::Ideal;
            scenario.radar.converter_bits = 16;
            scenario.radar.power_w *= 1e4;
            scenario
        };
        let mut blocks = fine("iwr");
        (blocks.radar.bins_per_sample, blocks.radar.first_bin) = (0, 0);
        let mut chirp = at(Model::Dahc, 5.8e9);
        (chirp.radar.bandwidth_hz, chirp.radar.sample_rate_hz) = (40e6, 40e6);
        (chirp.radar.sweep_s, chirp.radar.samples) = (40e-6, 1600);
        (chirp.radar.iq_gain_db, chirp.radar.iq_phase_deg) = (None, None);
        for mut scenario in [
            at(Model::Dahc, 3.5e9),
            at(Model::Dahc, 60e9),
            at(Model::RayTracing, 3.5e9),
            at(Model::Quadriga, 24e9),
            fine("bgt60"),
            fine("iwr"),
            blocks,
            chirp,
        ] {
            scenario.check("test").unwrap();
            scenario.radar.noise_figure_db = 0.0;
            scenario.radar.phase_noise_deg = 3.0;
            let db = disagreement(&scenario);
            let (name, carrier_hz) = (&scenario.name, scenario.radar.carrier_hz);
            assert!(db < -60.0, "{name} at {carrier_hz:e}: {db} dB");
        }
    }

    #[test]
    fn the_converter_is_well_driven() {
        let real = ["conference-room", "bgt60", "iwr"].map(typical);
        for scenario in [Scenario::default(), shipped("bgt60"), shipped("iwr")].into_iter().chain(real) {
            let full = (1_u16 << (scenario.radar.converter_bits - 1)) - 1;
            let mut loudest = 0;
            let mut clipped = 0;
            for index in 0..10 {
                let recording = recording(&scenario, 0.997, 1, Set::Test, Class::AdultWalking, index, 30);
                for s in recording.slots.values {
                    loudest = loudest.max(s.unsigned_abs());
                    clipped += u32::from(s.unsigned_abs() >= full);
                }
            }
            assert!(loudest > full / 10 && clipped == 0, "{}: {loudest}, clipped {clipped}", scenario.name);
        }
    }
}
