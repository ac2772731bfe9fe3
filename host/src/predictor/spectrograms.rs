//! From recordings to the network's images, through the core's own front end.
//!
//! Networks are trained on exactly what the radar module will show them: raw 16-bit slots go through
//! `sdp3_core::front_end`, and an image is taken at every N_s on the way.

use super::parameters::Images;
use crate::conformance::compare::OwnedBuffers;
use crate::results::Spectrogram;
use crate::scenario::{Class, Scenario};
use crate::simulator::dataset::{Recording, Set, recording};
use rayon::prelude::*;
use sdp3_core::frame::{FFT_LEN, ROWS};
use sdp3_core::front_end::FrontEnd;
use std::sync::atomic::{AtomicU64, Ordering};

/// Labelled images of one set, one [`Images`] per number of sensing slots in the scenario, and their truth.
pub struct Collected {
    /// In the order of `frame.sensing_slots`.
    pub images: Vec<Images>,
}

/// The `item`-th recording of a set: classes take turns, so that any prefix is balanced.
pub fn item(scenario: &Scenario, rho: f64, seed: u64, set: Set, item: u32, slots: u32) -> (Recording, u8) {
    let classes = Class::ALL.len() as u32;
    let label = item % classes;
    let class = Class::ALL[label as usize];
    (recording(scenario, rho, seed, set, class, item / classes, slots), label as u8)
}

/// Images of `per_class` recordings of every class, `[recording]` in the order of [`item`].
pub fn collect(
    scenario: &Scenario,
    rho: f64,
    seed: u64,
    set: Set,
    per_class: u32,
    progress: &(dyn Fn(u64, u64) + Sync),
) -> Collected {
    let count = per_class * Class::ALL.len() as u32;
    let done = AtomicU64::new(0);
    let each: Vec<(Vec<Vec<i8>>, u8)> = (0..count)
        .into_par_iter()
        .map(|index| {
            let (recording, label) = item(scenario, rho, seed, set, index, scenario.largest_sensing_slots());
            let images = images_of(scenario, &recording);
            progress(done.fetch_add(1, Ordering::Relaxed) + 1, u64::from(count));
            (images, label)
        })
        .collect();
    let settings = scenario.spectrogram.preprocessing();
    let images = scenario
        .frame
        .sensing_slots
        .iter()
        .enumerate()
        .map(|(n, &slots)| Images {
            rows: ROWS,
            frames: settings.frames(slots as usize),
            pixels: each.iter().flat_map(|(images, _)| images[n].iter().copied()).collect(),
            labels: each.iter().map(|&(_, label)| label).collect(),
        })
        .collect();
    Collected { images }
}

/// One recording's image at every N_s of the scenario.
pub fn images_of(scenario: &Scenario, recording: &Recording) -> Vec<Vec<i8>> {
    let settings = scenario.spectrogram.preprocessing();
    let slots = recording.slots.len();
    let mut buffers = OwnedBuffers::new(slots, settings.frames(slots), 0);
    let Some(mut front_end) = FrontEnd::new(settings, buffers.view().front_end) else { return Vec::new() };
    let mut images = Vec::new();
    for slot in &recording.slots {
        front_end.push(slot, &mut ());
        if scenario.frame.sensing_slots.contains(&(front_end.taken() as u32)) {
            images.push(front_end.image(&mut ()).map(<[i8]>::to_vec).unwrap_or_default());
        }
    }
    images
}

/// An image with its axes.
pub fn picture(scenario: &Scenario, title: &str, image: &[i8]) -> Spectrogram {
    let row_hz = f64::from(scenario.spectrogram.bins_per_row) / (FFT_LEN as f64 * scenario.interval_s());
    Spectrogram {
        title: title.to_owned(),
        rows: ROWS as u32,
        frames: (image.len() / ROWS) as u32,
        first_row_hz: -(ROWS as f64 / 2.0) * row_hz,
        row_hz,
        frame_s: f64::from(scenario.spectrogram.hop) * scenario.interval_s(),
        grey: image.iter().map(|&p| (i16::from(p) + 128) as u8).collect(),
    }
}
