//! Memory for those cases of the conformance suite that fit a board with 128 KiB of RAM. `tests/boards` leaves the rest out.

use sdp3_core::config::RadarConfig;
use sdp3_core::dsn::Shape;
use sdp3_core::pipeline::PipelineMemory;

/// The largest recording and network.
const LARGEST: Shape =
    Shape { sensing_slots: 200, frames: 10, channels: 16, stem_stride: 1, arena: 0, radar: RadarConfig::PAPER };
/// Values of a slot of 1000 complex samples.
pub const SLOT_VALUES: usize = LARGEST.radar.values_per_slot();
/// The longest model file.
pub const MODEL_BYTES: usize = 24 * 1024;

/// Memory of one pipeline after another. The references are those of a range gate over 256 samples.
pub type SuiteMemory = PipelineMemory<
    2048,
    { LARGEST.sensing_slots },
    { LARGEST.workspace_len() },
    { LARGEST.winograd_sizes().vectors },
    { LARGEST.winograd_sizes().words },
>;
