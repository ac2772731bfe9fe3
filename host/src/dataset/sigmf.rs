//! SigMF 1.2.6: a recording's raw slots as `recording-00000.sigmf-data`, described by `recording-00000.sigmf-meta`.
//!
//! <https://sigmf.org>. The data is 16-bit I and Q in turn, or real values, little-endian, one slot after the other.

use super::Work;
use crate::PROGRAM;
use crate::simulator::body::motion::GroundTruth;
use crate::store::digest::hex;
use crate::store::file_record::FileRecord;
use crate::store::output::{Output, OutputError, to_json};
use sdp3_core::config::SampleFormat;
use serde::Serialize;
use sha2::{Digest, Sha512};

/// Version of the specification.
const VERSION: &str = "1.2.6";

/// Names of a recording's data and of their description.
pub fn names(index: u32) -> [String; 2] {
    ["data", "meta"].map(|kind| format!("recording-{index:05}.sigmf-{kind}"))
}

#[derive(Serialize)]
struct Meta<'a> {
    global: Global<'a>,
    captures: [Capture; 1],
    annotations: [Annotation<'a>; 1],
}

#[derive(Serialize)]
struct Global<'a> {
    #[serde(rename = "core:datatype")]
    datatype: &'a str,
    #[serde(rename = "core:sample_rate")]
    sample_rate: f64,
    #[serde(rename = "core:version")]
    version: &'a str,
    #[serde(rename = "core:num_channels")]
    num_channels: u32,
    #[serde(rename = "core:sha512")]
    sha512: String,
    #[serde(rename = "core:author")]
    author: &'a str,
    #[serde(rename = "core:recorder")]
    recorder: &'a str,
    #[serde(rename = "core:hw")]
    hw: &'a str,
    #[serde(rename = "core:description")]
    description: String,
    #[serde(rename = "core:extensions")]
    extensions: [Extension; 1],
    #[serde(rename = "sdp3:slot_samples")]
    slot_samples: u16,
    #[serde(rename = "sdp3:slot_rate")]
    slot_rate_hz: f64,
}

/// The namespace that says where slots begin.
#[derive(Serialize)]
struct Extension {
    name: &'static str,
    version: &'static str,
    optional: bool,
}

#[derive(Serialize)]
struct Capture {
    #[serde(rename = "core:sample_start")]
    sample_start: u64,
    #[serde(rename = "core:frequency")]
    frequency: f64,
}

#[derive(Serialize)]
struct Annotation<'a> {
    #[serde(rename = "core:sample_start")]
    sample_start: u64,
    #[serde(rename = "core:sample_count")]
    sample_count: u64,
    #[serde(rename = "core:label")]
    label: &'a str,
    #[serde(rename = "core:comment")]
    comment: String,
}

/// Writes a recording's two files and says what they are.
///
/// # Errors
///
/// Files that cannot be written.
pub fn write(
    work: &Work,
    index: u32,
    truth: &GroundTruth,
    raw: &[u8],
    output: &Output,
) -> Result<Vec<FileRecord>, OutputError> {
    let Work { scenario, rho, request } = work;
    let interval_s = scenario.interval_s();
    let (slots, samples) = (work.slots(), scenario.radar.samples);
    let meta = Meta {
        global: Global {
            datatype: match scenario.radar.config().format {
                SampleFormat::Complex => "ci16_le",
                SampleFormat::Real => "ri16_le",
            },
            sample_rate: scenario.radar.sample_rate_hz,
            version: VERSION,
            num_channels: 1,
            sha512: hex(&Sha512::digest(raw)),
            author: env!("CARGO_PKG_AUTHORS"),
            recorder: PROGRAM,
            hw: "simulated radar",
            description: format!(
                "Recording {index} of scenario {}, rho {rho}, seed {}: {slots} raw radar slots of {samples} samples, one \
                 after the other; a slot begins every {interval_s} s.",
                scenario.name, request.seed
            ),
            extensions: [Extension { name: "sdp3", version: "1.0.0", optional: true }],
            slot_samples: samples,
            slot_rate_hz: 1.0 / interval_s,
        },
        captures: [Capture { sample_start: 0, frequency: scenario.radar.carrier_hz }],
        annotations: [Annotation {
            sample_start: 0,
            sample_count: u64::from(slots) * u64::from(samples),
            label: truth.class.name(),
            comment: format!(
                "height {} m, speed {} m/s, heading {} deg",
                truth.height_m, truth.speed_m_s, truth.heading_deg
            ),
        }],
    };
    let meta = format!("{}\n", to_json(&meta));
    let [data_name, meta_name] = names(index);
    output.write(&data_name, raw)?;
    output.write(&meta_name, meta.as_bytes())?;
    Ok(vec![FileRecord::new(data_name, raw), FileRecord::new(meta_name, meta.as_bytes())])
}
