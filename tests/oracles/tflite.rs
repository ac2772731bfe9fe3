//! Writes what the TensorFlow Lite oracle compares: exported networks, images, and every layer the core computes.
//!
//! `oracle-tflite FOLDER VALUES SEED [MODEL.sdp3]...` makes at least VALUES layer outputs. Per network NAME.tflite,
//! NAME.images `[count][64][frames]` and NAME.layers, for each image all layers but the stem before its pooling, which
//! the core never holds as a whole; all int8.

use sdp3::formats::model_file::QuantizedNetwork;
use sdp3::formats::tflite::export;
use sdp3::network::parameters::Architecture;
use sdp3_tests::networks::{images, layers, quantized};
use std::path::Path;

/// Channels, blocks, stride of the stem, classes, frames.
const SHAPES: [[usize; 5]; 11] = [
    [8, 5, 1, 5, 35],
    [8, 5, 2, 5, 110],
    [16, 5, 1, 5, 35],
    [16, 5, 2, 5, 110],
    [16, 5, 1, 5, 10],
    [8, 2, 2, 9, 23],
    [16, 3, 2, 9, 60],
    [4, 1, 1, 2, 17],
    [12, 8, 2, 16, 48],
    [32, 2, 2, 5, 60],
    [16, 1, 1, 5, 8],
];

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [folder, values, seed, models @ ..] = &arguments[..] else {
        return Err("usage: oracle-tflite FOLDER VALUES SEED [MODEL.sdp3]...".into());
    };
    let (folder, values, seed): (_, usize, u64) = (Path::new(folder), values.parse()?, seed.parse()?);
    let mut networks = Vec::new();
    for (i, [channels, blocks, stem_stride, classes, frames]) in SHAPES.into_iter().enumerate() {
        let architecture = Architecture { channels, blocks, stem_stride, classes };
        let name = format!("{i:02}-width{channels}-blocks{blocks}-stride{stem_stride}-frames{frames}");
        networks.push((name, quantized(architecture, frames as u16, seed + i as u64)));
    }
    for model in models {
        let network =
            QuantizedNetwork::from_bytes(&std::fs::read(model)?).map_err(|e| format!("{model}: {e}"))?;
        let stem = Path::new(model).file_stem().unwrap_or_default().to_string_lossy().into_owned();
        networks.push((format!("{:02}-file-{stem}", networks.len()), network));
    }
    let share = values.div_ceil(networks.len());
    for (i, (name, network)) in networks.iter().enumerate() {
        let (file, frames) = (network.to_bytes()?, usize::from(network.preprocessing.frames()));
        let (mut pixels, mut outputs) = (Vec::new(), Vec::new());
        let mut batch = 0;
        while outputs.len() < share {
            let made = images(frames, 16, 2, seed + 1000 * i as u64 + batch);
            for k in 0..made.len() {
                pixels.extend(made.image(k).iter().map(|&p| p as u8));
                outputs.extend(layers(&file, made.image(k)).concat().iter().map(|&v| v as u8));
            }
            batch += 1;
        }
        std::fs::write(folder.join(format!("{name}.tflite")), export(network)?)?;
        std::fs::write(folder.join(format!("{name}.images")), pixels)?;
        std::fs::write(folder.join(format!("{name}.layers")), outputs)?;
    }
    Ok(())
}
