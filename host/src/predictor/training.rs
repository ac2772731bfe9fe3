//! Training: parameters from labelled spectrograms, the same bits whatever the number of threads.
//!
//! AdamW (Loshchilov and Hutter, 2019) under a one-cycle learning rate (Smith and Topin, 2019), cross entropy, images
//! shuffled every epoch. Trainings run side by side; one alone uses several threads.

use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

use burn::optim::{AdamWConfig, GradientsParams};
use burn::tensor::activation::log_softmax;
use burn::tensor::{Device, Tensor, TensorData};
use thiserror::Error;

use super::float_network::first_maximum;
use super::network::Network;
use super::parameters::{Architecture, Images, Parameters, shuffled};
use super::trunk::Workspace;
use crate::results::Epoch;
use crate::scenario::Learning;

/// Share of the steps in which the learning rate rises.
const WARM_UP: f64 = 0.3;
/// Peak over the first learning rate.
const START_DIVISOR: f64 = 25.0;
/// Peak over the last learning rate.
const END_DIVISOR: f64 = 1e4;

/// Why a training could not begin.
#[derive(Debug, Error)]
pub enum TrainingError {
    /// Images that cannot be learned from.
    #[error("training images: {field} is {value}, must be {legal}")]
    Images {
        /// Which field.
        field: &'static str,
        /// What it holds.
        value: String,
        /// What it may hold.
        legal: String,
    },
    /// The operating system refused a thread.
    #[error("training thread: {0}")]
    Thread(String),
}

/// A trained network.
#[derive(Debug, Clone, PartialEq)]
pub struct Trained {
    /// Its parameters.
    pub parameters: Parameters,
    /// Loss and accuracy of every epoch, on the batches as they were learned from.
    pub epochs: Vec<Epoch>,
}

/// One training of several.
#[derive(Debug, Clone, Copy)]
pub struct Job<'a> {
    /// What to learn from.
    pub images: &'a Images,
    /// Seed of weights and shuffling.
    pub seed: u64,
}

/// Trains one network per job, `workers` at a time, and returns them in order.
///
/// `progress(job, epoch)` is called after every epoch, from any thread. The results do not depend on `workers`.
///
/// # Errors
/// The first job's error, if any failed.
pub fn train_all(
    jobs: &[Job],
    settings: &Learning,
    classes: usize,
    workers: usize,
    progress: &(dyn Fn(usize, &Epoch) + Sync),
) -> Result<Vec<Trained>, TrainingError> {
    // The longest first, so that no worker is left with it at the end.
    let mut order: Vec<usize> = (0..jobs.len()).collect();
    order.sort_by_key(|&j| std::cmp::Reverse(jobs[j].images.pixels.len()));
    let threads = (workers / jobs.len().max(1)).max(1);
    let next = AtomicUsize::new(0);
    let results: Vec<Mutex<Option<Result<Trained, TrainingError>>>> =
        jobs.iter().map(|_| Mutex::new(None)).collect();
    std::thread::scope(|scope| {
        for _ in 0..workers.clamp(1, jobs.len().max(1)) {
            scope.spawn(|| {
                while let Some(&j) = order.get(next.fetch_add(1, Ordering::Relaxed)) {
                    let report = |epoch: &Epoch| progress(j, epoch);
                    let trained = train(jobs[j].images, settings, classes, jobs[j].seed, threads, &report);
                    *results[j].lock().unwrap_or_else(|e| e.into_inner()) = Some(trained);
                }
            });
        }
    });
    results
        .into_iter()
        .map(|slot| {
            let lost = || Err(TrainingError::Thread("ended without a result".into()));
            slot.into_inner().unwrap_or_else(|e| e.into_inner()).unwrap_or_else(lost)
        })
        .collect()
}

/// Trains one network on `threads` threads; `progress` is called after every epoch.
///
/// The result does not depend on `threads`.
///
/// # Errors
/// Images whose size or labels do not fit; no thread.
pub fn train(
    images: &Images,
    settings: &Learning,
    classes: usize,
    seed: u64,
    threads: usize,
    progress: &(dyn Fn(&Epoch) + Sync),
) -> Result<Trained, TrainingError> {
    check(images, settings, classes)?;
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads.max(1)).build();
    let pool = pool.map_err(|e| TrainingError::Thread(e.to_string()))?;
    Ok(pool.install(|| run(images, settings, classes, seed, progress)))
}

fn check(images: &Images, settings: &Learning, classes: usize) -> Result<(), TrainingError> {
    let demand = |field, value: usize, good: bool, legal: String| match good {
        true => Ok(()),
        false => Err(TrainingError::Images { field, value: value.to_string(), legal }),
    };
    let stride = usize::from(settings.stem_stride);
    let pixels = images.len() * images.rows * images.frames;
    demand("number", images.len(), images.len() >= 2, "at least 2".into())?;
    demand("pixels", images.pixels.len(), images.pixels.len() == pixels, format!("{pixels}"))?;
    demand("rows", images.rows, images.rows > stride, format!("more than {stride}"))?;
    demand("frames", images.frames, images.frames > stride, format!("more than {stride}"))?;
    let largest = usize::from(images.labels.iter().copied().max().unwrap_or(0));
    demand("largest label", largest, largest < classes, format!("below {classes}"))
}

fn run(
    images: &Images,
    settings: &Learning,
    classes: usize,
    seed: u64,
    progress: &(dyn Fn(&Epoch) + Sync),
) -> Trained {
    let architecture = Architecture {
        channels: usize::from(settings.channels),
        blocks: usize::from(settings.blocks),
        stem_stride: usize::from(settings.stem_stride),
        classes,
    };
    let device = Device::flex().autodiff();
    let mut network = Network::new(&Parameters::initial(architecture, seed), &device);
    let mut optimizer =
        AdamWConfig::new().with_epsilon(1e-8).with_weight_decay(settings.weight_decay as f32).init();
    let batches = batches(images.len(), settings.batch as usize);
    let steps = batches.len() * settings.epochs as usize;
    let mut epochs = Vec::with_capacity(settings.epochs as usize);
    let (mut step, workspace) = (0, Workspace::default());
    for e in 0..settings.epochs {
        let order = shuffled(images.len(), seed, u64::from(e));
        let (mut loss_sum, mut right) = (0.0, 0);
        for range in &batches {
            let batch = &order[range.clone()];
            let (input, truth) = tensors(images, batch, classes, &device);
            let logits = network.forward_batch(input, &workspace);
            let answers: Vec<f32> = logits.to_data().iter::<f32>().collect();
            let labels = batch.iter().map(|&i| images.labels[i]);
            right +=
                answers.chunks(classes).zip(labels).filter(|(l, label)| first_maximum(l) == *label).count();
            let loss = (log_softmax(logits, 1) * truth).sum() / -(batch.len() as f64);
            loss_sum +=
                f64::from(loss.to_data().iter::<f32>().next().unwrap_or(f32::NAN)) * batch.len() as f64;
            let gradients = GradientsParams::from_grads(loss.backward(), &network);
            let rate = one_cycle(step, steps, settings.learning_rate);
            network = optimizer.step(rate, network, gradients);
            step += 1;
        }
        let n = images.len() as f64;
        let epoch = Epoch { loss: loss_sum / n, accuracy: right as f64 / n };
        progress(&epoch);
        epochs.push(epoch);
    }
    Trained { parameters: network.parameters(), epochs }
}

/// Images `[batch, 1, rows, frames]` and their classes one-hot `[batch, classes]`.
fn tensors(images: &Images, batch: &[usize], classes: usize, device: &Device) -> (Tensor<4>, Tensor<2>) {
    let pixels: Vec<f32> =
        batch.iter().flat_map(|&i| images.image(i).iter().map(|&p| (f32::from(p) + 128.0) / 255.0)).collect();
    let mut truth = vec![0.0f32; batch.len() * classes];
    for (row, &i) in batch.iter().enumerate() {
        truth[row * classes + usize::from(images.labels[i])] = 1.0;
    }
    let shape = [batch.len(), 1, images.rows, images.frames];
    (
        Tensor::from_data(TensorData::new(pixels, shape), device),
        Tensor::from_data(TensorData::new(truth, [batch.len(), classes]), device),
    )
}

/// Cuts `count` images into batches that differ by at most one image, as near to `size` as possible.
fn batches(count: usize, size: usize) -> Vec<std::ops::Range<usize>> {
    let number = ((count + size / 2) / size.max(1)).max(1);
    (0..number).map(|b| b * count / number..(b + 1) * count / number).collect()
}

/// Learning rate of a step: a rising half cosine, then a falling one.
fn one_cycle(step: usize, steps: usize, peak: f64) -> f64 {
    let half_cosine = |from: f64, to: f64, share: f64| {
        to + (from - to) * (1.0 + libm::cos(std::f64::consts::PI * share)) / 2.0
    };
    let position = (step as f64 + 0.5) / steps as f64;
    if position < WARM_UP {
        half_cosine(peak / START_DIVISOR, peak, position / WARM_UP)
    } else {
        half_cosine(peak, peak / END_DIVISOR, (position - WARM_UP) / (1.0 - WARM_UP))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::predictor::float_network::FloatNetwork;
    use crate::predictor::synthetic::stripes;

    fn settings(epochs: u32) -> Learning {
        Learning { epochs, batch: 20, channels: 4, blocks: 2, stem_stride: 2, ..Learning::default() }
    }

    fn bits(trained: &Trained) -> Vec<u64> {
        trained.epochs.iter().map(|e| e.loss.to_bits()).collect()
    }

    #[test]
    fn it_learns_to_tell_stripes_it_never_saw() {
        let trained = train(&stripes(24, 40, 1), &settings(12), 5, 7, 2, &|_| {}).unwrap();
        let answers = FloatNetwork::new(&trained.parameters).classify(&stripes(24, 20, 2));
        assert!(answers.accuracy() >= 0.95, "{}", answers.accuracy());
        assert!(trained.epochs[11].loss < 0.3 * trained.epochs[0].loss);
    }

    #[test]
    fn neither_threads_nor_neighbours_change_a_bit() {
        let (images, others) = (stripes(24, 8, 1), stripes(30, 8, 2));
        let alone = train(&images, &settings(2), 5, 7, 1, &|_| {}).unwrap();
        for threads in [1, 2, 3] {
            let inside = train(&images, &settings(2), 5, 7, threads, &|_| {}).unwrap();
            assert_eq!(bits(&inside), bits(&alone));
            assert_eq!(inside.parameters, alone.parameters);
        }
        let jobs = [Job { images: &others, seed: 8 }, Job { images: &images, seed: 7 }];
        for workers in [1, 2] {
            let both = train_all(&jobs, &settings(2), 5, workers, &|_, _| {}).unwrap();
            assert_eq!(both[1], alone);
        }
        assert_ne!(train(&images, &settings(2), 5, 9, 1, &|_| {}).unwrap().parameters, alone.parameters);
    }

    #[test]
    fn the_learning_rate_rises_to_its_peak_and_falls_to_nothing() {
        let rates: Vec<f64> = (0..1000).map(|s| one_cycle(s, 1000, 5e-3)).collect();
        assert!((rates[0] - 5e-3 / 25.0).abs() < 1e-7);
        assert!(rates[..300].is_sorted() && rates[300..].iter().rev().is_sorted());
        assert!((rates[300] - 5e-3).abs() < 1e-7 && (rates[999] - 5e-7).abs() < 1e-7);
    }

    #[test]
    fn every_epoch_takes_every_image_once() {
        let mut order = shuffled(500, 3, 1);
        assert_ne!(order, shuffled(500, 3, 2));
        assert_eq!(order, shuffled(500, 3, 1));
        order.sort();
        assert!(order.into_iter().eq(0..500));
        let sizes = |count, size| batches(count, size).iter().map(|b| b.len()).collect::<Vec<_>>();
        assert_eq!(sizes(500, 50), vec![50; 10]);
        assert_eq!(sizes(103, 50), vec![51, 52]);
        assert_eq!(sizes(3, 50), vec![3]);
    }

    #[test]
    fn unfit_images_are_refused_by_name() {
        let mut images = stripes(24, 1, 1);
        let refuse =
            |i: &Images, classes| train(i, &settings(1), classes, 1, 1, &|_| {}).unwrap_err().to_string();
        assert_eq!(refuse(&images, 4), "training images: largest label is 4, must be below 4");
        images.pixels.pop();
        assert!(refuse(&images, 5).starts_with("training images: pixels is 7679, must be 7680"));
    }
}
