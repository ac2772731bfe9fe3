//! Datasets as NPZ with a manifest: what `numpy.load` reads.
//!
//! `dataset.npz` holds `image` int8 `[recording, 64, frames]`, `beat` int32 `[recording, slot, 8, 2]` (re, im) and `label` uint8
//! `[recording]`; `manifest.json` the scenario, rho, seed, units, truth and SHA-256.

use crate::conformance::compare::OwnedBuffers;
use crate::output::Output;
use crate::pipeline::Failure;
use crate::predictor::spectrograms::item;
use crate::scenario::{Class, Scenario};
use crate::simulator::body::motion::Truth;
use crate::simulator::dataset::Set;
use npyz::WriterBuilder;
use rayon::prelude::*;
use sdp3_core::dechirp::dechirp;
use sdp3_core::front_end::FrontEnd;
use serde::Serialize;
use sha2::{Digest, Sha256};
use std::io::Write;
use std::sync::atomic::{AtomicU64, Ordering};

/// What was written.
#[derive(Debug, Serialize)]
pub struct Manifest {
    /// Resolved scenario.
    pub scenario: Scenario,
    /// Memory of the room channel.
    pub rho: f64,
    /// Seed.
    pub seed: u64,
    /// Recordings.
    pub recordings: u32,
    /// Sensing slots of each.
    pub sensing_slots: u32,
    /// Class names, by label.
    pub classes: Vec<String>,
    /// Meaning and unit of each array.
    pub arrays: Vec<(String, String)>,
    /// SHA-256 of `dataset.npz`.
    pub sha256: String,
    /// What is true of each recording.
    pub truth: Vec<Truth>,
}

struct One {
    image: Vec<i8>,
    beat: Vec<i32>,
    label: u8,
    truth: Truth,
}

fn one(scenario: &Scenario, rho: f64, seed: u64, index: u32) -> One {
    let (recording, label) = item(scenario, rho, seed, Set::Train, index, scenario.largest_sensing_slots());
    let settings = scenario.spectrogram.preprocessing();
    let slots = recording.slots.len();
    let mut buffers = OwnedBuffers::new(slots, settings.frames(slots), 0);
    let mut image = Vec::new();
    if let Some(mut front_end) = FrontEnd::new(settings, buffers.view().front_end) {
        recording.slots.iter().for_each(|slot| {
            front_end.push(slot, &mut ());
        });
        image = front_end.image(&mut ()).map(<[i8]>::to_vec).unwrap_or_default();
    }
    let beat =
        recording.slots.iter().flat_map(|slot| dechirp(slot).map(|z| [z.re, z.im])).flatten().collect();
    One { image, beat, label, truth: recording.truth }
}

/// Simulates `per_class` recordings of every class and writes them.
///
/// # Errors
///
/// Files that cannot be written.
pub fn write(
    scenario: &Scenario,
    rho: f64,
    seed: u64,
    per_class: u32,
    output: &Output,
    progress: &(dyn Fn(u64, u64) + Sync),
) -> Result<Manifest, Failure> {
    let count = per_class * Class::ALL.len() as u32;
    let slots = scenario.largest_sensing_slots();
    let frames = scenario.spectrogram.preprocessing().frames(slots as usize);
    let done = AtomicU64::new(0);
    let all: Vec<One> = (0..count)
        .into_par_iter()
        .map(|index| {
            let made = one(scenario, rho, seed, index);
            progress(done.fetch_add(1, Ordering::Relaxed) + 1, u64::from(count));
            made
        })
        .collect();
    let (n, slot_count) = (u64::from(count), u64::from(slots));
    let mut archive = npyz::npz::NpzWriter::new(std::io::Cursor::new(Vec::new()));
    let options = Default::default();
    {
        let mut array =
            archive.array("image", options)?.default_dtype().shape(&[n, 64, frames as u64]).begin_nd()?;
        all.iter().flat_map(|one| &one.image).try_for_each(|value| array.push(value))?;
        array.finish()?;
    }
    {
        let mut array =
            archive.array("beat", options)?.default_dtype().shape(&[n, slot_count, 8, 2]).begin_nd()?;
        all.iter().flat_map(|one| &one.beat).try_for_each(|value| array.push(value))?;
        array.finish()?;
    }
    {
        let mut array = archive.array("label", options)?.default_dtype().shape(&[n]).begin_nd()?;
        all.iter().try_for_each(|one| array.push(&one.label))?;
        array.finish()?;
    }
    let mut cursor = archive.zip_writer().finish()?;
    cursor.flush()?;
    let bytes = cursor.into_inner();
    output.write("dataset.npz", &bytes)?;
    let manifest = Manifest {
        scenario: scenario.clone(),
        rho,
        seed,
        recordings: count,
        sensing_slots: slots,
        classes: Class::ALL.iter().map(|class| class.name().to_owned()).collect(),
        arrays: [
            ("image", "int8 [recording, doppler, frame]: grey level minus 128"),
            (
                "beat",
                "int32 [recording, slot, fast_time, re/im]: dechirped blocks of 125 samples in 1/8 ADC LSB",
            ),
            ("label", "uint8 [recording]: index into classes"),
        ]
        .map(|(name, text)| (name.to_owned(), text.to_owned()))
        .to_vec(),
        sha256: Sha256::digest(&bytes).iter().map(|byte| format!("{byte:02x}")).collect(),
        truth: all.into_iter().map(|one| one.truth).collect(),
    };
    output.write_json("manifest.json", &manifest)?;
    Ok(manifest)
}
