//! What several of the core's tests need: small networks of random numbers, memory of exactly the size asked for, noise.
#![allow(dead_code)] // not every test needs everything

use rand_core::SeedableRng;
use rand_xoshiro::Xoshiro128PlusPlus;
use sdp3_core::config::RadarConfig;
use sdp3_core::crc32::crc32;
use sdp3_core::dims::{Beat, Complex, ZERO_BEAT};
use sdp3_core::dsn::Model;
use sdp3_core::dsn::winograd::{WinogradMemory, WinogradSizes};
use sdp3_core::pipeline::PipelineBuffers;
use sdp3_core::signal::front_end::{Clutter, FrontEndBuffers, workspace_len};
use sdp3_core::simd::dual_mac::I16x8;
use sdp3_testkit::random_model::{self, Numbers, Size};
use sdp3_testkit::signals::noise;

/// Channels of [`random_model`].
pub const CHANNELS: usize = 8;

/// The file of a network for `slots` sensing slots: one block, three classes, one frame every eight slots.
pub fn random_model(slots: u16, seed: u64) -> Vec<u8> {
    let size = Size { channels: CHANNELS, stride: 2, blocks: 1, slots, window: 128, hop: 8 };
    let mut bytes = vec![0; 1 << 13];
    let length = random_model::write(size, seed, Numbers::Trained, crc32, &mut bytes);
    bytes.truncate(length);
    bytes
}

/// The file with other bytes at `at`, its checksum corrected.
pub fn altered(file: &[u8], at: usize, bytes: &[u8]) -> Vec<u8> {
    let mut file = file.to_vec();
    file[at..at + bytes.len()].copy_from_slice(bytes);
    let end = file.len() - 4;
    let checksum = crc32(&file[..end]);
    file[end..].copy_from_slice(&checksum.to_le_bytes());
    file
}

/// Values of a slot of the paper's radar.
pub const VALUES: usize = RadarConfig::PAPER.values_per_slot();

/// Slots of seeded noise.
pub fn noise_slots(count: usize, seed: u64) -> Vec<[i16; VALUES]> {
    let mut random = Xoshiro128PlusPlus::seed_from_u64(seed);
    let mut slot = [0; VALUES];
    (0..count).map(|_| (noise(&mut random, &mut slot), slot).1).collect()
}

/// A pipeline's memory, element by element.
#[derive(Clone)]
pub struct Memory {
    pub beats: Vec<Beat>,
    pub workspace: Vec<Complex<i32>>,
    pub clutter: Box<Clutter>,
    pub vectors: Vec<I16x8>,
    pub words: Vec<i32>,
}

impl Memory {
    /// Exactly what a model's pipeline borrows.
    pub fn of(model: &Model<'_>) -> Self {
        let sizes = WinogradSizes::of(model);
        Memory {
            workspace: vec![Complex::new(0, 0); model.shape().workspace_len()],
            vectors: vec![[0; 4]; sizes.vectors],
            words: vec![0; sizes.words],
            ..Self::of_front_end(model.sensing_slots(), model.frames())
        }
    }

    /// What the front end of an image of so many frames borrows.
    pub fn of_front_end(slots: usize, frames: usize) -> Self {
        Memory {
            beats: vec![ZERO_BEAT; slots],
            workspace: vec![Complex::new(0, 0); workspace_len(slots, frames)],
            clutter: Box::new(Clutter::new()),
            vectors: Vec::new(),
            words: Vec::new(),
        }
    }

    pub fn view(&mut self) -> PipelineBuffers<'_> {
        PipelineBuffers {
            front_end: FrontEndBuffers {
                reference: &mut [],
                beats: &mut self.beats,
                workspace: &mut self.workspace,
                clutter: &mut self.clutter,
            },
            kernels: WinogradMemory { vectors: &mut self.vectors, words: &mut self.words },
        }
    }
}

/// Takes one element away.
pub type Shorten = fn(&mut Memory);

/// Every part of the memory and what shortens it; the last two are the kernels'.
pub const SHORTER: [(&str, Shorten); 4] = [
    ("beats", |m| _ = m.beats.pop()),
    ("workspace", |m| _ = m.workspace.pop()),
    ("vectors", |m| _ = m.vectors.pop()),
    ("words", |m| _ = m.words.pop()),
];
