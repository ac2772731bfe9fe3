//! Power-on self test: the signal chain on a seeded signal with known digests, and a network's kernels against the plain loops.
//!
//! It shows a wrong build, a damaged table or a floating-point unit in flush-to-zero mode before the first slot does. The generator
//! of the signal is the caller's, by the interface of rand_core.

use crate::config::RadarConfig;
use crate::digest::{Digest, DigestProbe};
use crate::dims::{Beat, Complex, ZERO_BEAT};
use crate::dsn::format::MAX_BLOCKS;
use crate::dsn::{Kernels, Model, Network, Portable, image_mut};
use crate::probe::Probe;
use crate::signal::fast_time::FastTime;
use crate::signal::front_end::{Clutter, FrontEnd, FrontEndBuffers, Preprocessing, workspace_len};
use crate::signal::stft::{FixedStft, FloatStft, Stft};
use bytemuck::must_cast_slice_mut;
use heapless::Vec;
use rand_core::Rng;

/// Window of the test's transform and slots of its recording: two frames.
const WINDOW: u16 = 32;
const SLOTS: usize = 40;

/// What [`run`] gives with `rand_xoshiro::Xoshiro128PlusPlus::seed_from_u64(3)`, on every processor.
pub const KNOWN_ANSWERS: [u64; 2] = [0xc02c_8aa4_477d_951a, 0x6d0a_a8e9_1e4f_49bb];

/// Digests of all stages up to the image, of 40 slots of noise with the transform in f32 and of 40 more with that in integers: window
/// and twiddles of both, the chirp, the clutter removal and the logarithm.
///
/// Cost: some 12 kB of stack and the time of 80 sensing slots.
pub fn run(rng: &mut impl Rng) -> [u64; 2] {
    let mut beats: [Beat; SLOTS] = [ZERO_BEAT; SLOTS];
    let mut workspace = [Complex::new(0, 0); workspace_len(SLOTS, 2)];
    let mut clutter = Clutter::new();
    let (beats, workspace, clutter) = (&mut beats[..], &mut workspace[..], &mut clutter);
    run_in(&mut FrontEndBuffers { reference: &mut [], beats, workspace, clutter }, rng)
}

/// [`run`] in memory of at least 40 slots and two frames; else zeros.
pub(crate) fn run_in(buffers: &mut FrontEndBuffers<'_>, rng: &mut impl Rng) -> [u64; 2] {
    [signal_chain::<FloatStft>(buffers, rng), signal_chain::<FixedStft>(buffers, rng)]
}

#[inline(never)] // one after the other on the same stack
fn signal_chain<T: Stft>(buffers: &mut FrontEndBuffers<'_>, rng: &mut impl Rng) -> u64 {
    let FrontEndBuffers { beats, workspace, clutter, .. } = buffers;
    let Some(beats) = beats.get_mut(..SLOTS) else { return 0 };
    let buffers = FrontEndBuffers { reference: &mut [], beats, workspace, clutter };
    let settings = Preprocessing { window: WINDOW, ..Preprocessing::default() };
    let mut made = FrontEnd::<T>::new(RadarConfig::PAPER, settings, buffers);
    let Some(front_end) = &mut made else { return 0 };
    let mut probe = DigestProbe::new();
    let Some(fast_time) = FastTime::new(RadarConfig::PAPER, &mut []) else { return 0 };
    for _ in 0..SLOTS {
        push_noise(front_end, &fast_time, rng, &mut probe);
    }
    front_end.image(&mut probe);
    let mut all = Digest::new();
    probe.stages().for_each(|(_, digest)| all.value(digest.hash().to_le_bytes()));
    all.hash()
}

/// The slot lies in the workspace.
fn push_noise<T: Stft>(
    front_end: &mut FrontEnd<'_, T>,
    fast_time: &FastTime<'_>,
    rng: &mut impl Rng,
    probe: &mut impl Probe,
) -> Option<()> {
    let values: &mut [i16] = must_cast_slice_mut(front_end.workspace());
    let slot = values.get_mut(..RadarConfig::PAPER.values_per_slot())?;
    for pair in slot.as_chunks_mut::<2>().0 {
        let word = rng.next_u32();
        // arithmetic shifts keep the sign: about +-4096 LSB
        *pair = [(word as i16) >> 3, ((word >> 16) as i16) >> 3];
    }
    let beat = fast_time.beat(slot)?;
    front_end.push_beat(beat, probe).then_some(())
}

/// Digests of every operator's output; of a graph those of the first.
struct Operators(Vec<u64, { 4 * MAX_BLOCKS + 2 }>);

impl Probe for Operators {
    fn layer(&mut self, _index: usize, activations: &[i8]) {
        let mut digest = Digest::new();
        activations.iter().for_each(|value| digest.value(value.to_le_bytes()));
        let _ = self.0.push(digest.hash()); // the paper's network has no more
    }
}

/// The first operator, from 0, with an output by `kernels` other than that of the plain loops, on an image of noise; `None` if all agree.
///
/// Scratch as of [`Network::step`]; what it holds is lost. Cost: one recognition and one by the plain loops, some four times as long.
#[inline(never)] // its digests do not lie under what else its caller does
pub fn network(
    model: &Model<'_>,
    scratch: &mut [i8],
    kernels: &mut impl Kernels,
    rng: &mut impl Rng,
) -> Option<usize> {
    let seed = rng.next_u32();
    let tested = infer_noise(model, seed, scratch, kernels);
    let plain = infer_noise(model, seed, scratch, &mut Portable);
    let all = model.operators().min(plain.0.capacity());
    (0..all).find(|&k| plain.0.get(k).is_none_or(|digest| tested.0.get(k) != Some(digest)))
}

/// The network on an image of noise, the same for the same seed.
fn infer_noise(model: &Model<'_>, seed: u32, scratch: &mut [i8], kernels: &mut impl Kernels) -> Operators {
    for (pixel, n) in image_mut(scratch, model.frames()).iter_mut().zip(0_u32..) {
        *pixel = (seed.wrapping_add(n).wrapping_mul(0x9e37_79b9) >> 24) as i8;
    }
    let (mut network, mut operators) = (Network::new(), Operators(Vec::new()));
    while network.step(model, scratch, kernels, &mut operators).is_none() {}
    operators
}
