//! The model file, read by a reader of its own, and its words.

use super::*;
use crate::network::interchange::header;
use crate::scenario::Scenario;

fn weighted(outputs: usize, inputs: usize, seed: i32) -> QuantizedLayer {
    let o = outputs as i32;
    QuantizedLayer {
        in_scale: 0.5,
        out_scale: 0.25 + seed as f32,
        in_zero: -128,
        out_zero: seed as i8,
        act_min: -128,
        act_max: 100,
        multipliers: (0..o).map(|i| (1 << 30) + 977 * i + seed).collect(),
        biases: (0..o).map(|i| 1000 * (i - 2) - seed).collect(),
        shifts: (0..o).map(|i| (i % 9 - 5) as i8).collect(),
        weights: (0..outputs * inputs).map(|i| (i as i32 * 37 + seed) as i8).collect(),
    }
}

pub(crate) fn network() -> QuantizedNetwork {
    let block = |s: i32| Block {
        affine: weighted(4, 1, s),
        conv1: weighted(4, 36, s + 1),
        conv2: weighted(4, 36, s + 2),
        add: Add {
            in1_scale: 1.5,
            in2_scale: 2.5,
            out_scale: 3.5,
            in1_zero: -1,
            in2_zero: -2,
            out_zero: -3,
            act_min: -128,
            act_max: 127,
            multipliers: [1 << 30, (1 << 30) + 1, i32::MAX],
            shifts: [-1, 0, -19],
        },
    };
    QuantizedNetwork {
        preprocessing: header(&Scenario::default(), 200),
        classes: ["standing", "child-walking", "adult-pacing"].map(String::from).to_vec(),
        stem_stride: 2,
        stem: weighted(4, 9, 3),
        blocks: vec![block(10), block(20)],
        head: weighted(3, 4, 30),
    }
}

/// A second reading of the format, field by field, that shares nothing with the writer.
struct Reader<'a>(&'a [u8], usize);

impl Reader<'_> {
    fn take<const N: usize>(&mut self) -> [u8; N] {
        self.1 += N;
        self.0[self.1 - N..self.1].try_into().unwrap()
    }
    fn i8(&mut self) -> i8 {
        i8::from_le_bytes(self.take())
    }
    fn u16(&mut self) -> u16 {
        u16::from_le_bytes(self.take())
    }
    fn u32(&mut self) -> u32 {
        u32::from_le_bytes(self.take())
    }
    fn f32(&mut self) -> f32 {
        f32::from_le_bytes(self.take())
    }
    fn i32s(&mut self, n: usize) -> Vec<i32> {
        (0..n).map(|_| i32::from_le_bytes(self.take())).collect()
    }
    fn i8s(&mut self, n: usize) -> Vec<i8> {
        let values = (0..n).map(|_| self.i8()).collect();
        for _ in n..n.next_multiple_of(4) {
            assert_eq!(self.i8(), 0);
        }
        values
    }
    fn weighted(&mut self, kind: i8, outputs: usize, inputs: usize) -> QuantizedLayer {
        assert_eq!(self.i8(), kind);
        let [in_zero, out_zero, act_min, act_max] = [self.i8(), self.i8(), self.i8(), self.i8()];
        assert_eq!(self.take::<3>(), [0; 3]);
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
        assert_eq!(self.i8(), 3);
        let [in1_zero, out_zero, act_min, act_max, in2_zero] =
            [self.i8(), self.i8(), self.i8(), self.i8(), self.i8()];
        assert_eq!(self.take::<2>(), [0; 2]);
        let [in1_scale, in2_scale, out_scale] = [self.f32(), self.f32(), self.f32()];
        let multipliers = self.i32s(3).try_into().unwrap();
        let shifts = self.i8s(3).try_into().unwrap();
        Add {
            in1_scale,
            in2_scale,
            out_scale,
            in1_zero,
            in2_zero,
            out_zero,
            act_min,
            act_max,
            multipliers,
            shifts,
        }
    }
}

/// Bit by bit, as IEEE 802.3 defines it.
fn crc32(bytes: &[u8]) -> u32 {
    !bytes.iter().fold(!0u32, |crc, &byte| {
        (0..8).fold(crc ^ u32::from(byte), |c, _| (c >> 1) ^ (0xEDB8_8320 & (0u32.wrapping_sub(c & 1))))
    })
}

#[test]
fn an_independent_reading_returns_the_network() {
    let network = network();
    let bytes = network.to_bytes().unwrap();
    let mut r = Reader(&bytes, 0);
    assert_eq!(&r.take::<4>(), b"SDP3");
    assert_eq!((r.u16(), r.u16(), r.u32()), (1, 64, bytes.len() as u32));
    let sensing_slots = r.u16();
    let [first_kept, last_kept] = r.take();
    let (window_len, hop) = (r.u16(), r.u16());
    assert_eq!(r.u16(), 64);
    let [bins_per_row, stem_stride] = r.take();
    let range = r.u16();
    assert_eq!(r.u16(), 10, "frames of 200 slots");
    let kaiser_beta = r.f32();
    assert_eq!(r.take::<4>(), [4, 2, 3, 0]);
    let (carrier_khz, slow_time_us) = (r.u32(), r.u32());
    assert_eq!(r.take::<20>(), [0; 20]);
    let preprocessing = Preprocessing {
        radar: RadarConfig::PAPER,
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
    let names = (0..3).map(|_| String::from_utf8(r.take::<24>().to_vec()).unwrap());
    let classes = names.map(|n| n.trim_end_matches('\0').to_string()).collect();
    let stem = r.weighted(1, 4, 9);
    let blocks = (0..2)
        .map(|_| Block {
            affine: r.weighted(2, 4, 1),
            conv1: r.weighted(1, 4, 36),
            conv2: r.weighted(1, 4, 36),
            add: r.add(),
        })
        .collect();
    let head = r.weighted(4, 3, 4);
    assert_eq!(r.u32(), crc32(&bytes[..bytes.len() - 4]));
    assert_eq!(r.1, bytes.len());
    assert_eq!(QuantizedNetwork { preprocessing, classes, stem_stride, stem, blocks, head }, network);
}

#[test]
fn the_checksum_is_the_published_one() {
    // "Check" value of CRC-32/ISO-HDLC in the catalogue of parametrised CRC algorithms.
    assert_eq!(crc32fast::hash(b"123456789"), 0xCBF4_3926);
    assert_eq!(crc32(b"123456789"), 0xCBF4_3926);
}

#[test]
fn the_description_speaks_of_every_layer() {
    let text = network().describe();
    for part in ["200 sensing slots", "3.5 GHz", "64 x 10", "40.0 dB", "block 1 conv2", "head"] {
        assert!(text.contains(part), "{part} missing in {text}");
    }
}

#[test]
fn a_model_belongs_to_a_radar_and_a_number_of_slots() {
    let paper = Scenario::default();
    let bytes = network().to_bytes().unwrap();
    assert_eq!(bytes[RADAR_AT..RADAR_AT + 16], [0; 16], "the paper's radar leaves no trace");
    check_use(&bytes, &paper, 200).unwrap();
    let refused =
        |bytes: &[u8], scenario: &Scenario, slots| check_use(bytes, scenario, slots).unwrap_err().to_string();
    assert!(refused(&bytes, &paper, 300).contains("sensing_slots is 200, must be 300"));
    let bgt60 = crate::scenario::builtin::named("bgt60".as_ref()).unwrap().scenario();
    let error = refused(&bytes, &bgt60, 200);
    assert!(
        error.contains("1000 complex samples") && error.contains("must be 128 real samples of 12 bits"),
        "{error}"
    );
    let mut other = network();
    other.preprocessing.radar = bgt60.radar.config();
    let bytes = other.to_bytes().unwrap();
    check_use(&bytes, &bgt60, 200).unwrap();
    assert_eq!(QuantizedNetwork::from_bytes(&bytes).unwrap(), other);
    assert!(other.describe().contains("8 x 4 range bins from bin 6 on"), "{}", other.describe());
    other.preprocessing.radar.samples = 63;
    assert!(other.to_bytes().unwrap_err().to_string().contains("radar is RadarConfig"));
}
