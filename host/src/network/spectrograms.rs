//! From recordings to the network's images, through the core's own front end.
//!
//! Networks are trained on what the radar module will show them: beats, or raw 16-bit slots, go through
//! `sdp3_core::signal::front_end`, and an image is taken at every N_s on the way.

use super::parameters::Images;
use super::vector_stft::VectorStft;
use crate::formats::slots::Slots;
use crate::network::memory::OwnedMemory;
use crate::numerics::vectors::vectorised;
use crate::results::{GallerySpectrogram, Spectrogram};
use crate::scenario::{Class, Model, Radar, Scenario};
use crate::simulator::calibration::rho_of;
use crate::simulator::dataset::{Set, beats, recording};
use rayon::prelude::*;
use sdp3_core::dims::{Beat, FFT_LEN, ROWS};
use sdp3_core::signal::front_end::{FrontEnd, workspace_len};
use std::ops::Range;
use std::sync::atomic::{AtomicU64, Ordering};

/// Labelled images of one set, one [`Images`] per number of sensing slots in the scenario, and their truth.
pub struct Collected {
    /// In the order of `frame.sensing_slots`.
    pub images: Vec<Images>,
}

impl Collected {
    /// More of the same set.
    pub fn extend(&mut self, more: &Collected) {
        if self.images.is_empty() {
            self.images.clone_from(&more.images);
            return;
        }
        for (images, more) in self.images.iter_mut().zip(&more.images) {
            images.pixels.extend(&more.pixels);
            images.labels.extend(&more.labels);
        }
    }
}

/// Class and index within it of the `item`-th recording of a set: classes take turns, so that any prefix is balanced.
pub fn item(item: u32) -> (Class, u32) {
    let classes = Class::ALL.len() as u32;
    (Class::ALL[(item % classes) as usize], item / classes)
}

/// Which recordings of a scenario and seed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Part {
    /// Those learned from; every window is an image of its own.
    Train,
    /// Those behind them, from the range samples on, which no network was trained on: early exits are fitted on them, comparisons test
    /// with them.
    Calibration,
    Test,
    Demo,
}

/// The first `per_class` recordings of every class of a part, in the order of [`item`].
#[derive(Debug, Clone, Copy)]
pub struct Recordings<'a> {
    pub scenario: &'a Scenario,
    /// AR(1) coefficient rho of the room channel.
    pub rho: f64,
    /// Seed of everything random.
    pub seed: u64,
    pub part: Part,
    /// How many of every class.
    pub per_class: u32,
}

/// A recording, as far as the front end needs it.
enum Recorded {
    Slots(Slots),
    Beats(Vec<Beat>),
}

impl Recordings<'_> {
    /// Images at every N_s of all of them, `[recording]`, or `[recording][window]` of training recordings.
    pub fn images(&self, progress: &(dyn Fn(u64, u64) + Sync)) -> Collected {
        gathered(self.scenario, &self.map(|| (), |(), images| images, progress))
    }

    /// The images that scenarios make of the same recordings, which are simulated once: they may differ in `spectrogram` alone.
    pub fn images_of_each(
        &self,
        scenarios: &[Scenario],
        progress: &(dyn Fn(u64, u64) + Sync),
    ) -> Vec<Collected> {
        let each = self.each(
            0..self.count(),
            || (),
            |(), class, recorded| {
                let labelled = |images| (class, images);
                scenarios
                    .iter()
                    .map(|s| self.windows(s, &recorded).into_iter().map(labelled).collect())
                    .collect()
            },
            progress,
        );
        let mut found: Vec<Vec<(u8, Vec<Vec<i8>>)>> = scenarios.iter().map(|_| Vec::new()).collect();
        for of_recording in each {
            let of_recording: Vec<Vec<_>> = of_recording;
            found.iter_mut().zip(of_recording).for_each(|(found, windows)| found.extend(windows));
        }
        scenarios.iter().zip(&found).map(|(scenario, each)| gathered(scenario, each)).collect()
    }

    /// How many they are in all classes.
    pub fn count(&self) -> u32 {
        self.per_class * Class::ALL.len() as u32
    }

    /// `answer` to the images at every N_s of each of them, with its label; every thread makes a `state` of its own. Each is simulated
    /// once and passes the front end once.
    pub fn map<S, T: Send>(
        &self,
        state: impl Fn() -> S + Sync + Send,
        answer: impl Fn(&mut S, Vec<Vec<i8>>) -> T + Sync + Send,
        progress: &(dyn Fn(u64, u64) + Sync),
    ) -> Vec<(u8, T)> {
        self.map_some(0..self.count(), state, answer, progress)
    }

    /// As [`Self::map`], of the recordings of these numbers in the order of [`item`].
    pub fn map_some<S, T: Send>(
        &self,
        items: Range<u32>,
        state: impl Fn() -> S + Sync + Send,
        answer: impl Fn(&mut S, Vec<Vec<i8>>) -> T + Sync + Send,
        progress: &(dyn Fn(u64, u64) + Sync),
    ) -> Vec<(u8, T)> {
        let one = |state: &mut S, class, recorded| -> Vec<_> {
            let windows = self.windows(self.scenario, &recorded).into_iter();
            windows.map(|images| (class, answer(state, images))).collect()
        };
        self.each(items, state, one, progress).into_iter().flatten().collect()
    }

    /// What `answer` makes of each of some recordings and its label, in the order of [`item`].
    fn each<S, T: Send>(
        &self,
        items: Range<u32>,
        state: impl Fn() -> S + Sync + Send,
        answer: impl Fn(&mut S, u8, Recorded) -> T + Sync + Send,
        progress: &(dyn Fn(u64, u64) + Sync),
    ) -> Vec<T> {
        let count = items.len() as u64;
        let done = AtomicU64::new(0);
        let one = |state: &mut S, index: u32| {
            let (class, n) = item(index);
            let answer = answer(state, class as u8, self.recorded(class, n));
            progress(done.fetch_add(1, Ordering::Relaxed) + 1, count);
            answer
        };
        items.into_par_iter().map_init(state, one).collect()
    }

    /// A recording. Those that are tested or shown go the whole way through raw slots; the others start at the beats.
    fn recorded(&self, class: Class, n: u32) -> Recorded {
        let Recordings { scenario, rho, seed, .. } = *self;
        let slots = scenario.largest_sensing_slots();
        let raw = |set| Recorded::Slots(recording(scenario, rho, seed, set, class, n, slots).slots);
        let beats = |n, slots| Recorded::Beats(beats(scenario, rho, seed, Set::Train, class, n, slots).0);
        let learning = &scenario.learning;
        match self.part {
            Part::Train => beats(n, learning.training_slots(slots)),
            Part::Calibration => beats(learning.train_per_class + n, slots),
            Part::Test => raw(Set::Test),
            Part::Demo => raw(Set::Demo),
        }
    }

    /// Images of a recording's windows.
    fn windows(&self, scenario: &Scenario, recorded: &Recorded) -> Vec<Vec<Vec<i8>>> {
        match recorded {
            Recorded::Slots(slots) => vec![images_of(scenario, slots)],
            Recorded::Beats(beats) if self.part == Part::Train => windows_of(scenario, beats),
            Recorded::Beats(beats) => vec![images_of_beats(scenario, beats)],
        }
    }
}

/// Images of stored training recordings, as [`Recordings::images`] makes them of simulated ones.
pub fn collect_from(scenario: &Scenario, recordings: Vec<(Class, Vec<Beat>)>) -> Collected {
    let each: Vec<(u8, Vec<Vec<i8>>)> = recordings
        .par_iter()
        .flat_map_iter(|(class, beats)| {
            let slots = scenario.learning.training_slots(scenario.largest_sensing_slots());
            let windows = windows_of(scenario, &beats[..slots as usize]);
            windows.into_iter().map(move |images| (*class as u8, images))
        })
        .collect();
    gathered(scenario, &each)
}

/// Every recording's images, N_s by N_s.
fn gathered(scenario: &Scenario, each: &[(u8, Vec<Vec<i8>>)]) -> Collected {
    let settings = scenario.spectrogram.preprocessing();
    let images = scenario
        .frame
        .sensing_slots
        .iter()
        .enumerate()
        .map(|(n, &slots)| Images {
            rows: ROWS,
            frames: settings.frames(slots as usize),
            pixels: each.iter().flat_map(|(_, images)| images[n].iter().copied()).collect(),
            labels: each.iter().map(|&(label, _)| label).collect(),
        })
        .collect();
    Collected { images }
}

/// Images at every N_s of each window of a training recording, evenly spaced from its beginning to its end.
fn windows_of(scenario: &Scenario, beats: &[Beat]) -> Vec<Vec<Vec<i8>>> {
    let windows = scenario.learning.windows as usize;
    if windows == 1 {
        return vec![images_of_beats(scenario, beats)];
    }
    let mut short = scenario.clone();
    let mut window = |w: usize| {
        let mut images = Vec::new();
        for &slots in &scenario.frame.sensing_slots {
            let first = (beats.len() - slots as usize) * w / (windows - 1);
            short.frame.sensing_slots = vec![slots];
            images.extend(images_of_beats(&short, &beats[first..first + slots as usize]));
        }
        images
    };
    (0..windows).map(&mut window).collect()
}

/// Images at every N_s of labelled recordings of any length: windows `step(N_s)` slots from one to the next, recording by recording.
pub fn sliding(
    scenario: &Scenario,
    recordings: &[(u8, &[Beat])],
    step: impl Fn(usize) -> usize + Sync,
) -> Collected {
    let of = |&slots: &u32| {
        let mut short = scenario.clone();
        short.frame.sensing_slots = vec![slots];
        let length = slots as usize;
        let windows = |(label, beats): &(u8, &[Beat])| -> Vec<(u8, Vec<i8>)> {
            let first = (0..(beats.len() + 1).saturating_sub(length)).step_by(step(length).max(1));
            first
                .flat_map(|first| images_of_beats(&short, &beats[first..first + length]))
                .map(|image| (*label, image))
                .collect()
        };
        let each: Vec<(u8, Vec<i8>)> = recordings.par_iter().flat_map_iter(windows).collect();
        Images {
            rows: ROWS,
            frames: scenario.spectrogram.preprocessing().frames(length),
            pixels: each.iter().flat_map(|(_, image)| image.iter().copied()).collect(),
            labels: each.iter().map(|&(label, _)| label).collect(),
        }
    };
    Collected { images: scenario.frame.sensing_slots.iter().map(of).collect() }
}

/// Images at every N_s of the scenario of a recording's raw slots.
pub fn images_of(scenario: &Scenario, slots: &Slots) -> Vec<Vec<i8>> {
    let wanted = &scenario.frame.sensing_slots;
    images_on_the_way(
        scenario,
        slots.len(),
        wanted,
        #[inline(always)]
        |front_end, n| front_end.push(&slots[n], &mut ()),
    )
}

/// Images at every N_s of the scenario of a recording's beats.
pub fn images_of_beats(scenario: &Scenario, beats: &[Beat]) -> Vec<Vec<i8>> {
    images_of_first_beats(scenario, beats, &scenario.frame.sensing_slots)
}

/// Image of all of a recording's beats; empty if they do not fill a window.
pub fn image_of_beats(scenario: &Scenario, beats: &[Beat]) -> Vec<i8> {
    images_of_first_beats(scenario, beats, &[beats.len() as u32]).pop().unwrap_or_default()
}

fn images_of_first_beats(scenario: &Scenario, beats: &[Beat], wanted: &[u32]) -> Vec<Vec<i8>> {
    images_on_the_way(
        scenario,
        beats.len(),
        wanted,
        #[inline(always)]
        |front_end, n| front_end.push_beat(beats[n], &mut ()),
    )
}

/// One pass: an image whenever as many slots are in as one of `wanted`, in ascending order.
fn images_on_the_way(
    scenario: &Scenario,
    slots: usize,
    wanted: &[u32],
    push: impl Fn(&mut FrontEnd<'_, VectorStft>, usize) -> bool,
) -> Vec<Vec<i8>> {
    let settings = scenario.spectrogram.preprocessing();
    let radar = scenario.radar.config();
    let mut memory = OwnedMemory::new(&radar, slots, workspace_len(slots, settings.frames(slots)));
    let Some(mut front_end) = FrontEnd::new(radar, settings, memory.view().front_end) else {
        return Vec::new();
    };
    let image = |end: usize| {
        vectorised(
            #[inline(always)]
            || {
                for n in front_end.taken()..end {
                    push(&mut front_end, n);
                }
            },
        );
        front_end.image(&mut ()).map(<[i8]>::to_vec).unwrap_or_default()
    };
    wanted.iter().map(|&end| end as usize).filter(|&end| end <= slots).map(image).collect()
}

/// Length of a gallery's recordings in s, three steps of a walk, and the most slots the front end takes.
const GALLERY_S: f64 = 2.0;
const MOST_SLOTS: u32 = 4000;

/// Kaiser beta of a gallery's spectrograms: side lobes below what 50 dB show.
const PICTURE_BETA: f32 = 10.0;

/// A gallery: every channel model, at 3.5, 24 and 60 GHz, every class of the paper.
pub fn gallery(
    scenario: &Scenario,
    seed: u64,
    progress: &(dyn Fn(u64, u64) + Sync),
) -> Vec<GallerySpectrogram> {
    // spacing and rows that show the toes at each carrier, and a hop of 4 to 8 ms
    let carriers = [(3.5e9, 3, 1, 8), (24e9, 1, 4, 16), (60e9, 0, 4, 16)];
    let total = (Model::ALL.len() * carriers.len() * Class::ALL.len()) as u64;
    let wanted: Vec<_> = Model::ALL
        .into_iter()
        .flat_map(|model| carriers.into_iter().flat_map(move |c| Class::ALL.map(|class| (model, c, class))))
        .collect();
    let done = AtomicU64::new(0);
    wanted
        .into_par_iter()
        .map(|(model, (carrier_hz, spacing, bins, hop), class)| {
            let mut scenario = scenario.clone();
            scenario.channel.model = model;
            scenario.radar = scenario.radar.with_sweep_of(&Radar::default());
            scenario.radar.carrier_hz = carrier_hz;
            scenario.frame.spacing_slots = spacing;
            scenario.spectrogram.bins_per_row = bins;
            scenario.spectrogram.hop = hop;
            let title = format!("{}, {}, {} GHz", class.name(), model.name(), carrier_hz / 1e9);
            let spectrogram = example(&scenario, &title, class, seed);
            progress(done.fetch_add(1, Ordering::Relaxed) + 1, total);
            GallerySpectrogram { model: model.name().into(), class: class.name().into(), spectrogram }
        })
        .collect()
}

/// The spectrogram of a person of a class in a scenario, [`GALLERY_S`] long.
pub fn example(scenario: &Scenario, title: &str, class: Class, seed: u64) -> Spectrogram {
    let mut scenario = scenario.clone();
    scenario.spectrogram.beta = PICTURE_BETA;
    let slots = ((GALLERY_S / scenario.interval_s()).round() as u32).min(MOST_SLOTS);
    scenario.frame.sensing_slots = vec![slots];
    let rho = rho_of(&scenario);
    let (beats, _) = beats(&scenario, rho, seed, Set::Demo, class, 0, slots);
    let image = images_of_beats(&scenario, &beats).pop().unwrap_or_default();
    picture(&scenario, title, &image)
}

/// An image with its axes.
pub fn picture(scenario: &Scenario, title: &str, image: &[i8]) -> Spectrogram {
    let row_hz = f64::from(scenario.spectrogram.bins_per_row) / (FFT_LEN as f64 * scenario.interval_s());
    let middle_hz = if scenario.radar.config().one_sided() { 0.25 / scenario.interval_s() } else { 0.0 };
    Spectrogram {
        title: title.to_owned(),
        rows: ROWS as u32,
        frames: (image.len() / ROWS) as u32,
        first_row_hz: middle_hz - (ROWS as f64 / 2.0) * row_hz,
        row_hz,
        frame_s: f64::from(scenario.spectrogram.hop) * scenario.interval_s(),
        carrier_hz: scenario.radar.carrier_hz,
        range_db: scenario.spectrogram.range_db,
        intensities: image.iter().map(|&p| (i16::from(p) + 128) as u8).collect(),
    }
}
