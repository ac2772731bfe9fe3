//! Reads a model file back into numbers, scales included, which the radar module checks but does not keep.
//!
//! `sdp3_core::dsn::Model::parse` has judged every byte before the first is read here.

use sdp3_core::config::RadarConfig;
use sdp3_core::dsn::{Model, ModelError};

use super::{Add, Block, HEADER_BYTES, NAME_BYTES, Preprocessing, QuantizedLayer, QuantizedNetwork};

/// Bytes of a file that was found sound, from the front; what is missing reads as zero.
struct Reader<'a>(&'a [u8]);

impl<'a> Reader<'a> {
    fn bytes(&mut self, count: usize) -> &'a [u8] {
        let (head, tail) = self.0.split_at_checked(count).unwrap_or((self.0, &[]));
        self.0 = tail;
        head
    }

    fn take<const N: usize>(&mut self) -> [u8; N] {
        self.bytes(N).first_chunk().copied().unwrap_or([0; N])
    }

    fn u16(&mut self) -> u16 {
        u16::from_le_bytes(self.take())
    }

    fn f32(&mut self) -> f32 {
        f32::from_le_bytes(self.take())
    }

    fn i32s(&mut self, count: usize) -> Vec<i32> {
        (0..count).map(|_| i32::from_le_bytes(self.take())).collect()
    }

    /// `count` values and the zeros that fill the last word.
    fn i8s(&mut self, count: usize) -> Vec<i8> {
        let values = self.bytes(count.next_multiple_of(4));
        values.iter().take(count).map(|&v| v as i8).collect()
    }

    /// Zero points of input and output, activation range, second input's zero point.
    fn prefix(&mut self) -> [i8; 5] {
        let [_, values @ .., _, _] = self.take::<8>();
        values.map(|v| v as i8)
    }

    fn weighted(&mut self, outputs: usize, inputs: usize) -> QuantizedLayer {
        let [in_zero, out_zero, act_min, act_max, _] = self.prefix();
        QuantizedLayer {
            in_zero,
            out_zero,
            act_min,
            act_max,
            in_scale: self.f32(),
            out_scale: self.f32(),
            multipliers: self.i32s(outputs),
            biases: self.i32s(outputs),
            shifts: self.i8s(outputs),
            weights: self.i8s(outputs * inputs),
        }
    }

    fn add(&mut self) -> Add {
        let [in1_zero, out_zero, act_min, act_max, in2_zero] = self.prefix();
        Add {
            in1_zero,
            in2_zero,
            out_zero,
            act_min,
            act_max,
            in1_scale: self.f32(),
            in2_scale: self.f32(),
            out_scale: self.f32(),
            multipliers: [0; 3].map(|_: i32| i32::from_le_bytes(self.take())),
            shifts: {
                let [skip, branch, sum, _] = self.take();
                [skip, branch, sum].map(|v: u8| v as i8)
            },
        }
    }
}

/// What a header says besides the preprocessing.
pub(in crate::formats) struct Header {
    /// From raw slots to the image.
    pub preprocessing: Preprocessing,
    /// Stride of the input convolution.
    pub stem_stride: u8,
    /// Channels, blocks and classes.
    pub sizes: [u8; 3],
}

/// The header's fields as they stand there; `None` if it is short, of another format or version.
pub(super) fn header(bytes: &[u8]) -> Option<Header> {
    let mut r = Reader(bytes.get(..HEADER_BYTES)?);
    if &r.take() != b"SDP3" || r.u16() != super::VERSION {
        return None;
    }
    r.bytes(6);
    let sensing_slots = r.u16();
    let [first_kept, last_kept] = r.take();
    let (window_len, hop) = (r.u16(), r.u16());
    r.bytes(2);
    let [bins_per_row, stem_stride] = r.take();
    let range = r.u16();
    r.bytes(2);
    let kaiser_beta = r.f32();
    let [channels, blocks, classes, _] = r.take();
    let (carrier_khz, slow_time_us) = (u32::from_le_bytes(r.take()), u32::from_le_bytes(r.take()));
    r.bytes(super::RADAR_AT - 44);
    let preprocessing = Preprocessing {
        radar: RadarConfig::from_bytes(r.take())?,
        sensing_slots,
        first_kept,
        last_kept,
        window_len,
        hop,
        bins_per_row,
        range,
        kaiser_beta,
        carrier_khz,
        slow_time_us,
    };
    Some(Header { preprocessing, stem_stride, sizes: [channels, blocks, classes] })
}

/// Header and class names that begin a model file; `None` if they are not a whole one's.
pub(in crate::formats) fn header_and_names(bytes: &[u8]) -> Option<(Header, Vec<String>)> {
    let header = header(bytes)?;
    let names = bytes.get(HEADER_BYTES..).filter(|n| n.len() == usize::from(header.sizes[2]) * NAME_BYTES)?;
    let text = |name: &[u8]| Some(std::str::from_utf8(name).ok()?.trim_end_matches('\0').to_owned());
    let names = names.chunks_exact(NAME_BYTES).map(text).collect::<Option<_>>()?;
    Some((header, names))
}

impl QuantizedNetwork {
    /// Reads a model file with the paper's network.
    ///
    /// # Errors
    /// What the radar module's parser finds wrong; no channels, if a graph is in the network's place.
    pub fn from_bytes(bytes: &[u8]) -> Result<QuantizedNetwork, ModelError> {
        let model = Model::parse(bytes)?;
        let (c, classes) = (model.channels(), model.classes());
        if c == 0 {
            return Err(ModelError::Field { name: "channels", value: 0 });
        }
        let Header { preprocessing, stem_stride, .. } = header(bytes).ok_or(ModelError::Magic)?;
        let mut r = Reader(bytes);
        r.bytes(HEADER_BYTES + classes * NAME_BYTES);
        let stem = r.weighted(c, 9);
        let block = |r: &mut Reader<'_>| Block {
            affine: r.weighted(c, 1),
            conv1: r.weighted(c, 9 * c),
            conv2: r.weighted(c, 9 * c),
            add: r.add(),
        };
        let blocks = (0..model.blocks()).map(|_| block(&mut r)).collect();
        let classes = (0..classes).map(|k| model.class_name(k).to_owned()).collect();
        let head = r.weighted(model.classes(), c);
        Ok(QuantizedNetwork { preprocessing, classes, stem_stride, stem, blocks, head })
    }
}

#[cfg(test)]
mod tests {
    use super::super::tests::network;
    use super::*;

    #[test]
    fn what_was_written_is_read() {
        let network = network();
        assert_eq!(QuantizedNetwork::from_bytes(&network.to_bytes().unwrap()).unwrap(), network);
    }

    #[test]
    fn damage_is_refused() {
        let bytes = network().to_bytes().unwrap();
        assert!(QuantizedNetwork::from_bytes(&bytes[..bytes.len() - 1]).is_err());
        assert!(QuantizedNetwork::from_bytes(b"SDP3").is_err());
        assert!(header(&bytes[..63]).is_none());
    }
}
