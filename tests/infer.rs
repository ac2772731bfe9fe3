//! A clock for int8 inference in this process, driven line by line: what `tests/bench infer` compares with its peers.
//!
//! `bench-infer make FOLDER` writes the benchmark's networks from a seed: NAME.sdp3, NAME.tflite and NAME.images.
//! `bench-infer clock FILE.sdp3 FILE.images` prints the instruction sets there are, then answers each line
//! `INSTRUCTION-SET COUNT` with the nanoseconds of COUNT single inferences, one thread, and the logits of the last.

use sdp3::formats::tflite::export;
use sdp3::network::inference::{Isa, VectorKernels};
use sdp3::network::parameters::Architecture;
use sdp3_core::dims::ROWS;
use sdp3_core::dsn::{Model, infer};
use sdp3_tests::networks::{images, quantized};
use std::io::{BufRead, Write};
use std::path::Path;
use std::time::Instant;

/// Name and stride of the stem.
const NETWORKS: [(&str, usize); 2] = [("flat", 1), ("stride2", 2)];
const FRAMES: u16 = 64;
const IMAGES: usize = 16;

type Result<T> = std::result::Result<T, Box<dyn std::error::Error>>;

fn make(folder: &Path) -> Result<()> {
    for (name, stem_stride) in NETWORKS {
        let network = quantized(Architecture { channels: 16, blocks: 5, stem_stride, classes: 5 }, FRAMES, 1);
        let images = images(usize::from(FRAMES), IMAGES, 5, 2);
        std::fs::write(folder.join(format!("{name}.sdp3")), network.to_bytes()?)?;
        std::fs::write(folder.join(format!("{name}.tflite")), export(&network)?)?;
        let pixels: Vec<u8> = images.pixels.iter().map(|&p| p as u8).collect();
        std::fs::write(folder.join(format!("{name}.images")), pixels)?;
    }
    Ok(())
}

/// Times `count` inferences, image after image.
fn time(model: &Model, isa: Isa, images: &[Vec<i8>], count: usize) -> Result<String> {
    let mut scratch = vec![0; model.shape().scratch_bytes()];
    let mut kernels = VectorKernels::new(model, isa).ok_or("not available here")?;
    let mut line = String::new();
    let mut logits = String::new();
    for image in images.iter().cycle().take(count) {
        let started = Instant::now();
        let answer = infer(model, image, &mut scratch, &mut kernels, &mut ());
        line += &format!("{} ", started.elapsed().as_nanos());
        logits = format!("{:?}", answer.logits.as_slice());
    }
    Ok(line + &logits)
}

fn clock(file: &Path, images: &Path) -> Result<()> {
    let file = std::fs::read(file)?;
    let model = Model::parse(&file).map_err(|e| e.to_string())?;
    let pixels: Vec<i8> = std::fs::read(images)?.into_iter().map(|b| b as i8).collect();
    let images: Vec<Vec<i8>> = pixels.chunks_exact(ROWS * model.frames()).map(<[i8]>::to_vec).collect();
    let names: Vec<&str> = Isa::ALL.into_iter().filter(|isa| isa.available()).map(Isa::name).collect();
    println!("{}", names.join(" "));
    for line in std::io::stdin().lock().lines() {
        let line = line?;
        let (name, count) = line.split_once(' ').ok_or("a line is INSTRUCTION-SET COUNT")?;
        let isa = Isa::ALL.into_iter().find(|isa| isa.name() == name).ok_or("no such instruction set")?;
        println!("{}", time(&model, isa, &images, count.parse()?)?);
        std::io::stdout().flush()?;
    }
    Ok(())
}

fn main() -> Result<()> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    match &arguments.iter().map(String::as_str).collect::<Vec<_>>()[..] {
        ["make", folder] => make(Path::new(folder)),
        ["clock", file, images] => clock(Path::new(file), Path::new(images)),
        _ => Err("usage: bench-infer make FOLDER | clock FILE.sdp3 FILE.images".into()),
    }
}
