//! Times training steps as `sdp3 train` takes them, on random images of 64 x 64 pixels; `tests/bench train` runs it.
//!
//!     cargo run --release --example training_speed -- BATCH THREADS STEM_STRIDE [CHANNELS] [EPOCHS] [BACKEND]
//!
//! Prints one JSON object: the least and the median time of a step, each averaged over an epoch of about 500 images.

use sdp3::network::parameters::Images;
use sdp3::network::training::{Backend, Job, train};
use sdp3::scenario::Learning;
use std::sync::Mutex;
use std::time::Instant;

/// Images of an epoch, about.
const IMAGES: usize = 500;

fn main() {
    let mut arguments: Vec<String> = std::env::args().skip(1).collect();
    let backend = if arguments.len() > 5 { arguments.remove(5) } else { "cpu".to_owned() };
    let backend = Backend::named(&backend).expect("a backend of this build");
    let mut numbers = arguments.iter().map(|text| text.parse::<usize>().expect("a number"));
    let mut number = |default: usize| numbers.next().unwrap_or(default);
    let (batch, threads, stride, channels, epochs) =
        (number(100), number(1), number(1), number(16), number(10));
    let in_epoch = (IMAGES / batch).max(1);
    let count = in_epoch * batch;
    let mut state = 1u32;
    let mut random = || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (state >> 24) as u8
    };
    let images = Images {
        rows: 64,
        frames: 64,
        pixels: (0..count * 64 * 64).map(|_| random() as i8).collect(),
        labels: (0..count).map(|_| random() % 5).collect(),
    };
    let settings = Learning {
        epochs: epochs as u32,
        batch: batch as u32,
        channels: channels as u8,
        stem_stride: stride as u8,
        ..Learning::default()
    };
    let ends = Mutex::new(vec![Instant::now()]);
    let end = || ends.lock().expect("not poisoned").push(Instant::now());
    let watch = |_: &dyn Fn() -> _, _: &[_]| {
        end();
        Ok(())
    };
    train(&images, &settings, 5, &Job { backend, ..Job::default() }, threads, &watch)
        .expect("images that fit");
    let ends = ends.into_inner().expect("not poisoned");
    let mut steps: Vec<f64> =
        ends[1..].windows(2).map(|w| (w[1] - w[0]).as_secs_f64() * 1e3 / in_epoch as f64).collect();
    steps.sort_by(f64::total_cmp);
    let found = serde_json::json!({
        "least_ms": steps[0],
        "median_ms": steps[steps.len() / 2],
        "samples_per_s": batch as f64 * 1e3 / steps[0],
    });
    println!("{found}");
}
