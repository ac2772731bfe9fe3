//! A model file is read to the last byte, and every field that is not legal is named with its value.

#[path = "model/conv.rs"]
mod conv;
#[path = "model/head.rs"]
mod head;
#[path = "model/network.rs"]
mod network;
#[path = "model/pool.rs"]
mod pool;
mod support;

use sdp3_core::config::RadarConfig;
use sdp3_core::dsn::model::{HEADER_LEN, NAME_LEN, REVISION_AT, SIGNATURE_LEN, crc32};
use sdp3_core::dsn::{Model, ModelError, Shape};
use support::{CHANNELS, altered, random_model};

static SIGNED: &[u8] = sdp3_testkit::models::DSN_200_SIGNED;

/// Where the layers begin: behind the header and three names.
const STEM: usize = HEADER_LEN + 3 * NAME_LEN;
/// Where a layer's scales begin, behind its kind, zero points and range.
const SCALES: usize = 8;
/// The same of its multipliers, where it has two scales.
const MULTIPLIERS: usize = SCALES + 8;
/// Where the addition begins: behind the stem, a normalisation and two convolutions.
const ADD: usize = STEM + channelwise(9) + channelwise(1) + 2 * channelwise(9 * CHANNELS);
/// An addition has three scales, multipliers and shifts, and a zero.
const HEAD: usize = ADD + 8 + 12 + 12 + 4;

/// Bytes of a layer with so many weights a channel. All its parts are whole words here.
const fn channelwise(taps: usize) -> usize {
    MULTIPLIERS + 4 * CHANNELS + 4 * CHANNELS + CHANNELS + CHANNELS * taps
}

/// What the parser says of the random model with other bytes somewhere.
fn outcome(at: usize, bytes: &[u8]) -> Result<(), ModelError> {
    Model::parse(&altered(&random_model(200, 1), at, bytes)).map(|_| ())
}

/// These are refused by this name and value; those are not refused by this name.
fn field<const N: usize>(
    name: &'static str,
    at: usize,
    bytes: fn(i64) -> [u8; N],
    illegal: &[i64],
    legal: &[i64],
) {
    for &value in illegal {
        assert_eq!(outcome(at, &bytes(value)), Err(ModelError::Field { name, value }));
    }
    for &value in legal {
        let named =
            matches!(outcome(at, &bytes(value)), Err(ModelError::Field { name: other, .. }) if other == name);
        assert!(!named, "{name} may be {value}");
    }
}

fn byte(value: i64) -> [u8; 1] {
    [value as u8]
}

fn two(value: i64) -> [u8; 2] {
    (value as u16).to_le_bytes()
}

fn four(value: i64) -> [u8; 4] {
    (value as u32).to_le_bytes()
}

#[test]
fn every_field_of_the_header_has_its_range() {
    assert_eq!(outcome(0, b"SDP3"), Ok(()));
    field("header_len", 6, two, &[63, 65, 0], &[64]);
    field("sensing_slots", 12, two, &[4001, 5000, 65535], &[200, 4000]);
    field("first_kept", 14, byte, &[9, 255], &[0, 1, 2, 8]);
    field("last_kept", 15, byte, &[0, 1, 9], &[2, 8]);
    field("window_len", 16, two, &[0, 1, 257, 65535], &[2, 128, 256]);
    field("hop", 18, two, &[0, 129], &[1, 128]);
    field("rows", 20, two, &[63, 65], &[64]);
    field("bins_per_row", 22, byte, &[0, 3, 5, 8], &[1, 2, 4]);
    field("stem_stride", 23, byte, &[0, 3], &[1, 2]);
    field("range", 24, two, &[0, 4096], &[1, 4095]);
    field("frames", 26, two, &[9, 11], &[10]);
    let bits = |beta: f32| i64::from(beta.to_bits());
    let illegal = [-0.1, 40.1, f32::INFINITY, f32::NAN, -f32::NAN].map(bits);
    field("kaiser_beta", 28, four, &illegal, &[0.0, 40.0].map(bits));
    field("channels", 32, byte, &[0, 2, 6, 33, 36], &[4, 8, 32]);
    field("blocks", 33, byte, &[0, 9], &[1, 8]);
    field("classes", 34, byte, &[0, 1, 17], &[2, 3, 16]);
    field("signature", 35, byte, &[2, 255], &[0, 1]);
    // a sensor that is none: a first sample of a gate, or one sample alone
    for at in 48..56 {
        assert!(matches!(outcome(at, &[1]), Err(ModelError::Field { name: "radar", .. })), "{at}");
    }
    assert_eq!(outcome(48, &[128, 0, 8, 12, 5, 4, 6, 0]), Ok(()));
    field("arena", 56, four, &[1, 256, i64::from(u32::MAX)], &[0]);
    for at in 60..64 {
        assert_eq!(outcome(at, &[1]), Err(ModelError::Field { name: "reserved", value: 0 }));
    }
}

#[test]
fn an_image_needs_a_column_behind_the_pooling() {
    let file = random_model(200, 1);
    for (frames, stride, legal) in [(1, 1, false), (2, 1, true), (1, 2, false), (2, 2, false), (3, 2, true)] {
        let slots = 128 + 8 * (frames - 1);
        let file = altered(&file, 12, &two(slots));
        let file = altered(&file, 26, &two(frames));
        let found = Model::parse(&altered(&file, 23, &[stride])).map(|model| model.frames() as i64);
        let refused = ModelError::Field { name: "sensing_slots", value: slots };
        assert_eq!(found, if legal { Ok(frames) } else { Err(refused) }, "{frames} {stride}");
    }
}

#[test]
fn a_recording_fits_the_gram_matrix() {
    for (slots, legal) in [(4000, true), (4001, false), (5000, false)] {
        let file = altered(&random_model(200, 1), 12, &two(slots));
        let file = altered(&file, 26, &two((slots - 128) / 8 + 1));
        let refused = Err(ModelError::Field { name: "sensing_slots", value: slots });
        let found = Model::parse(&file).map(|model| model.sensing_slots() as i64);
        assert_eq!(found, if legal { Ok(slots) } else { refused });
    }
}

#[test]
fn no_more_components_are_dropped_than_there_are_range_samples() {
    let four = RadarConfig { range_samples: 4, ..RadarConfig::BGT60 };
    for (radar, first, legal) in [
        (RadarConfig::DOPPLER, 0, true),
        (RadarConfig::DOPPLER, 1, true),
        (RadarConfig::DOPPLER, 2, false),
        (RadarConfig::DOPPLER_IQ, 2, false),
        (four, 4, true),
        (four, 5, false),
        (RadarConfig::PAPER, 8, true),
    ] {
        let file = altered(&random_model(200, 1), 48, &radar.to_bytes());
        let found = Model::parse(&altered(&file, 14, &[first])).map(|model| model.preprocessing().kept.first);
        let refused = Err(ModelError::Field { name: "first_kept", value: i64::from(first) });
        assert_eq!(found, if legal { Ok(first) } else { refused }, "{radar:?}");
    }
}

#[test]
fn names_are_text() {
    let refused = Err(ModelError::Field { name: "class_name", value: 0 });
    assert_eq!(outcome(HEADER_LEN + NAME_LEN, &[0]), refused, "empty");
    assert_eq!(outcome(HEADER_LEN, b"a\0b"), refused, "a zero within");
    assert_eq!(outcome(HEADER_LEN, &[0xff]), refused, "not UTF-8");
    let file = altered(&random_model(200, 1), HEADER_LEN + NAME_LEN, b"abcdefghijklmnopqrstuvwx");
    let model = Model::parse(&file).expect("a model");
    let names = [0, 1, 2, 3].map(|class| model.class_name(class));
    assert_eq!(names, ["a", "abcdefghijklmnopqrstuvwx", "c", ""]);
}

#[test]
fn every_field_of_a_layer_has_its_range() {
    for (layer, kind) in [(STEM, 1), (STEM + channelwise(9), 2), (ADD, 3), (HEAD, 4)] {
        field("layer.kind", layer, byte, &[0, 5, 7], &[kind]);
        // from -128 to 127 and back
        assert_eq!(outcome(layer + 3, &[7, 7]), Ok(()));
        assert_eq!(outcome(layer + 3, &[8, 7]), Err(ModelError::Field { name: "layer.act_min", value: 8 }));
        let low = Err(ModelError::Field { name: "layer.act_min", value: -127 });
        assert_eq!(outcome(layer + 3, &[129, 128]), low);
        field("layer.reserved", layer + 6, two, &[1, 256, 65535], &[0]);
        let add = layer == ADD;
        let (scales, multipliers, shifts) = match add {
            true => {
                (["add.in1_scale", "add.in2_scale", "add.out_scale"].as_slice(), SCALES + 12, SCALES + 24)
            }
            false => (["layer.in_scale", "layer.out_scale"].as_slice(), MULTIPLIERS, {
                MULTIPLIERS + 8 * if layer == HEAD { 3 } else { CHANNELS }
            }),
        };
        let bits = |scale: f32| i64::from(scale.to_bits());
        let illegal = [0.0, -0.0, -1.0, f32::INFINITY, f32::NAN].map(bits);
        for (k, name) in scales.iter().enumerate() {
            field(name, layer + SCALES + 4 * k, four, &illegal, &[1e-30, 1.0, f32::MAX].map(bits));
        }
        let names = if add { ["add.multiplier", "add.shift"] } else { ["layer.multiplier", "layer.shift"] };
        for k in 0..3 {
            let at = layer + multipliers + 4 * k;
            field(
                names[0],
                at,
                four,
                &[1, (1 << 30) - 1, -1, i64::from(i32::MIN)],
                &[0, 1 << 30, i64::from(i32::MAX)],
            );
            field(names[1], layer + shifts + k, byte, &[8, 127, -32, -128], &[-31, 0, 7]);
        }
        if add {
            field("add.reserved", layer + shifts + 3, byte, &[1, 255], &[0]);
        }
    }
}

#[test]
fn layers_end_where_the_content_does() {
    let file = random_model(200, 1);
    let content = file.len() - 4;
    let resized = |length: usize| {
        let mut file = file.clone();
        file.resize(length + 4, 0);
        let file = altered(&file, 8, &four(length as i64 + 4));
        Model::parse(&file).map(|_| ())
    };
    assert_eq!(resized(content), Ok(()));
    for have in [content - 1, content / 2, HEADER_LEN, content + 1, content + 4] {
        assert_eq!(resized(have), Err(ModelError::Layers { need: content, have }));
    }
}

#[test]
fn the_header_is_what_the_model_says_of_itself() {
    let file = random_model(200, 1);
    let file = altered(&file, 36, &four(24_125_000));
    let file = altered(&file, 40, &four(1000));
    let file = altered(&file, REVISION_AT, &four(7));
    let model = Model::parse(&file).expect("a model");
    assert_eq!((model.carrier_khz(), model.interval_us(), model.revision()), (24_125_000, 1000, 7));
    assert_eq!((model.channels(), model.blocks(), model.classes()), (CHANNELS, 1, 3));
    let signed = Model::parse(SIGNED).expect("a model");
    assert_eq!((signed.channels(), signed.blocks(), signed.classes()), (8, 5, 5));
    let other = altered(&file, HEAD + SCALES + 4, &0.25_f32.to_le_bytes());
    assert_eq!((model.logit_scale(), Model::parse(&other).expect("a model").logit_scale()), (1.0, 0.25));
    assert!(!model.is_signed() && Model::parse(SIGNED).expect("a model").is_signed());
    let shape = Shape {
        sensing_slots: 200,
        frames: 10,
        channels: CHANNELS,
        stem_stride: 2,
        arena: 0,
        radar: RadarConfig::PAPER,
    };
    assert_eq!((Shape::of(&file), model.shape()), (Some(shape), shape));
    assert_eq!(Shape::of(&file[..HEADER_LEN]), Some(shape));
    assert_eq!(Shape::of(&file[..HEADER_LEN - 1]), None);
    for at in 0..4 {
        assert_eq!(Shape::of(&altered(&file, at, b"?")), None);
    }
}

#[test]
fn envelopes_are_whole() {
    // the check value of CRC-32 in every catalogue of checksums
    assert_eq!(crc32(b"123456789"), 0xcbf4_3926);
    let file = random_model(200, 1);
    for have in [0, 4, 67] {
        assert_eq!(Model::parse(&file[..have]).err(), Some(ModelError::Truncated { need: 68, have }));
    }
    let short =
        |have: usize| Model::parse(&altered(&altered(&file[..have], 8, &four(have as i64)), 35, &[1])).err();
    let need = HEADER_LEN + SIGNATURE_LEN + 4;
    assert_eq!(short(68), Some(ModelError::Truncated { need, have: 68 }));
    assert_eq!(short(need - 1), Some(ModelError::Truncated { need, have: need - 1 }));
    // whole, but there are no names and no layers
    let content = HEAD + MULTIPLIERS + 3 * 8 + 4 + 3 * CHANNELS;
    assert_eq!(short(need), Some(ModelError::Layers { need: content, have: HEADER_LEN }));
    let mut damaged = file.clone();
    damaged[100] ^= 1;
    let content = &damaged[..file.len() - 4];
    let (stated, computed) = (crc32(&file[..file.len() - 4]), crc32(content));
    assert_eq!(Model::parse(&damaged).err(), Some(ModelError::Checksum { stated, computed }));
}

#[test]
fn every_defect_has_its_words() {
    for (error, words) in [
        (ModelError::Truncated { need: 68, have: 3 }, "truncated: it needs at least 68 bytes and has 3"),
        (ModelError::Magic, "not a model: it does not begin with \"SDP3\""),
        (ModelError::Version { found: 9 }, "version 9; this program reads version 1"),
        (
            ModelError::Length { stated: 5, have: 6 },
            "truncated or extended: its header says 5 bytes, it has 6",
        ),
        (
            ModelError::Checksum { stated: 0xa, computed: 0xb },
            "damaged: its checksum is 0000000a, its content's 0000000b",
        ),
        (ModelError::Field { name: "hop", value: 0 }, "field hop has the illegal value 0"),
        (ModelError::Unsigned, "not signed; a signature is required"),
        (ModelError::Signature, "its signature does not belong to this key and content"),
        (
            ModelError::Older { revision: 1, oldest: 2 },
            "revision 1 is a rollback: the oldest that is taken is 2",
        ),
        (ModelError::Layers { need: 9, have: 8 }, "its layers need 9 bytes, it has 8"),
    ] {
        assert_eq!(error.to_string(), words);
    }
}

#[cfg(feature = "signature")]
#[test]
fn a_key_takes_its_own_models_that_are_not_too_old() {
    use sdp3_core::dsn::model::KEY_LEN;
    let key: [u8; KEY_LEN] = *sdp3_testkit::models::PUBLIC_KEY;
    assert_eq!(Model::parse_signed(SIGNED, &key, 0).map(|model| model.revision()), Ok(0));
    let older = ModelError::Older { revision: 0, oldest: 1 };
    assert_eq!(Model::parse_signed(SIGNED, &key, 1).err(), Some(older));
    let unsigned = random_model(200, 1);
    assert_eq!(Model::parse_signed(&unsigned, &key, 0).err(), Some(ModelError::Unsigned));
    // one bit of the content, of the signature, of the key
    let refused = Some(ModelError::Signature);
    let flip = |at: usize| altered(SIGNED, at, &[SIGNED[at] ^ 1]);
    assert_eq!(Model::parse_signed(&flip(REVISION_AT), &key, 0).err(), refused);
    assert_eq!(Model::parse_signed(&flip(SIGNED.len() - 5), &key, 0).err(), refused);
    let mut other = key;
    other[KEY_LEN - 1] ^= 1;
    assert_eq!(Model::parse_signed(SIGNED, &other, 0).err(), refused);
}
