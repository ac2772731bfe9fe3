//! A network as the bytes of a model file.

use super::{
    Add, HEADER_BYTES, KIND_ADD, KIND_BATCH_NORM, KIND_CONV, KIND_HEAD, ModelFileError, NAME_BYTES,
    Preprocessing, QuantizedLayer, QuantizedNetwork, RADAR_AT, ROWS, VERSION, check,
};
use sdp3_core::dsn::Model;
use sdp3_core::dsn::model::ARENA_AT;
use sdp3_core::graph::Graph;

/// A model file with a graph in the place of the paper's network.
///
/// # Errors
/// What the radar module's parser finds wrong.
pub fn with_graph(
    preprocessing: &Preprocessing,
    classes: &[String],
    graph: &[u8],
) -> Result<Vec<u8>, ModelFileError> {
    let arena = Graph::parse(graph)?.arena() as u32;
    let mut out = header(preprocessing, [0; 3], classes.len());
    out[ARENA_AT..ARENA_AT + 4].copy_from_slice(&arena.to_le_bytes());
    check::names(classes)?;
    append_names(classes, &mut out);
    out.extend_from_slice(graph);
    let out = closed(out);
    Model::parse(&out)?;
    Ok(out)
}

/// The header, its length still zero, for so many channels, blocks and such a stride of the stem.
fn header(p: &Preprocessing, [channels, blocks, stem_stride]: [u8; 3], classes: usize) -> Vec<u8> {
    let mut out = Vec::with_capacity(HEADER_BYTES);
    out.extend_from_slice(b"SDP3");
    out.extend_from_slice(&VERSION.to_le_bytes());
    out.extend_from_slice(&(HEADER_BYTES as u16).to_le_bytes());
    out.extend_from_slice(&0u32.to_le_bytes());
    out.extend_from_slice(&p.sensing_slots.to_le_bytes());
    out.extend_from_slice(&[p.first_kept, p.last_kept]);
    out.extend_from_slice(&p.window_len.to_le_bytes());
    out.extend_from_slice(&p.hop.to_le_bytes());
    out.extend_from_slice(&ROWS.to_le_bytes());
    out.extend_from_slice(&[p.bins_per_row, stem_stride]);
    out.extend_from_slice(&p.range.to_le_bytes());
    out.extend_from_slice(&p.frames().to_le_bytes());
    out.extend_from_slice(&p.kaiser_beta.to_le_bytes());
    out.extend_from_slice(&[channels, blocks, classes as u8, 0]);
    out.extend_from_slice(&p.carrier_khz.to_le_bytes());
    out.extend_from_slice(&p.slow_time_us.to_le_bytes());
    out.resize(RADAR_AT, 0);
    out.extend_from_slice(&p.radar.to_bytes());
    out.resize(HEADER_BYTES, 0);
    out
}

fn append_names(classes: &[String], out: &mut Vec<u8>) {
    for name in classes {
        out.extend_from_slice(name.as_bytes());
        out.resize(out.len() + NAME_BYTES - name.len(), 0);
    }
}

/// With the file's length in its header and the checksum behind it.
pub(in crate::formats) fn closed(mut out: Vec<u8>) -> Vec<u8> {
    let total = out.len() as u32 + 4;
    out[8..12].copy_from_slice(&total.to_le_bytes());
    let checksum = crc32fast::hash(&out);
    out.extend_from_slice(&checksum.to_le_bytes());
    out
}

impl QuantizedNetwork {
    /// The file's bytes.
    ///
    /// # Errors
    /// Names the first field the format cannot hold, with its value and legal range.
    pub fn to_bytes(&self) -> Result<Vec<u8>, ModelFileError> {
        self.check()?;
        let mut out = self.header();
        append_names(&self.classes, &mut out);
        self.stem.append(KIND_CONV, &mut out);
        for block in &self.blocks {
            block.affine.append(KIND_BATCH_NORM, &mut out);
            block.conv1.append(KIND_CONV, &mut out);
            block.conv2.append(KIND_CONV, &mut out);
            block.add.append(&mut out);
        }
        self.head.append(KIND_HEAD, &mut out);
        Ok(closed(out))
    }

    fn header(&self) -> Vec<u8> {
        header(
            &self.preprocessing,
            [self.channels() as u8, self.blocks.len() as u8, self.stem_stride],
            self.classes.len(),
        )
    }
}

impl QuantizedLayer {
    fn append(&self, kind: u8, out: &mut Vec<u8>) {
        prefix(kind, [self.in_zero, self.out_zero, self.act_min, self.act_max, 0], out);
        out.extend_from_slice(&self.in_scale.to_le_bytes());
        out.extend_from_slice(&self.out_scale.to_le_bytes());
        for value in self.multipliers.iter().chain(&self.biases) {
            out.extend_from_slice(&value.to_le_bytes());
        }
        padded(&self.shifts, out);
        padded(&self.weights, out);
    }
}

impl Add {
    fn append(&self, out: &mut Vec<u8>) {
        prefix(KIND_ADD, [self.in1_zero, self.out_zero, self.act_min, self.act_max, self.in2_zero], out);
        for scale in [self.in1_scale, self.in2_scale, self.out_scale] {
            out.extend_from_slice(&scale.to_le_bytes());
        }
        for multiplier in self.multipliers {
            out.extend_from_slice(&multiplier.to_le_bytes());
        }
        padded(&self.shifts, out);
    }
}

/// The eight bytes every layer begins with.
fn prefix(kind: u8, [in_zero, out_zero, act_min, act_max, in2_zero]: [i8; 5], out: &mut Vec<u8>) {
    out.push(kind);
    out.extend([in_zero, out_zero, act_min, act_max, in2_zero].map(|v| v as u8));
    out.extend([0, 0]);
}

/// Bytes, then zeros up to a multiple of 4.
fn padded(values: &[i8], out: &mut Vec<u8>) {
    out.extend(values.iter().map(|&v| v as u8));
    out.resize(out.len().next_multiple_of(4), 0);
}
