//! Training: parameters from labelled spectrograms, the same bits whatever the number of threads.
//!
//! Cross entropy, images shuffled every epoch, masked and mixed ([`augmentation`]); the optimiser and its learning rate are the scenario's. Trainings run side by side; one alone uses several threads.

pub(crate) mod augmentation;
pub(crate) mod batches;
pub(crate) mod steps;

use crate::error::Invalid;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex};

use burn::optim::{GradientsParams, ModuleOptimizer};
use burn::tensor::activation::log_softmax;
use burn::tensor::{Bytes, Device, Tensor};
use thiserror::Error;

use augmentation::{augment, stream};
use batches::{Batch, batches, split};
use steps::{optimizer, rate};

use super::backbone::Workspace;
use super::burn_model::Network;
use super::checkpoint::{Best, Bits, Checkpoint, Undecodable, decode, encode, identity};
use super::float_network::first_maximum;
use super::parameters::{Architecture, Images, Parameters, shuffled};
use crate::results::Epoch;
use crate::scenario::Learning;
use crate::store::record::Identity;

/// Why a training could not begin.
#[derive(Debug, Error)]
pub enum TrainingError {
    /// A field that may not be what it is.
    #[error(transparent)]
    Invalid(#[from] Invalid),
    /// A checkpoint that cannot be resumed from.
    #[error("checkpoint: {0}")]
    Checkpoint(#[from] Undecodable),
    /// What the caller found wrong after an epoch.
    #[error("training: {0}")]
    EpochCallback(String),
    /// The operating system refused a thread.
    #[error("training thread: {0}")]
    Thread(String),
}

/// A trained network.
#[derive(Debug, Clone, PartialEq)]
pub struct Trained {
    /// Its parameters: after the last epoch, or the best on the validation set if there is one.
    pub parameters: Parameters,
    /// Loss and accuracy of every epoch, on the batches as they were learned from.
    pub epochs: Vec<Epoch>,
}

/// Where a training runs.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Backend {
    /// The processor, through the backbone's own passes.
    #[default]
    Cpu,
    /// A GPU through Vulkan, Metal, DirectX 12 or WebGPU.
    #[cfg(feature = "wgpu")]
    Wgpu,
    /// A GPU of NVIDIA.
    #[cfg(feature = "cuda")]
    Cuda,
}

impl Backend {
    /// Those of this build.
    const ALL: &[Backend] = &[
        Backend::Cpu,
        #[cfg(feature = "wgpu")]
        Backend::Wgpu,
        #[cfg(feature = "cuda")]
        Backend::Cuda,
    ];

    /// The backend of this name, if this build has it.
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.iter().copied().find(|backend| backend.name() == name)
    }

    /// Its name.
    pub fn name(self) -> &'static str {
        match self {
            Backend::Cpu => "cpu",
            #[cfg(feature = "wgpu")]
            Backend::Wgpu => "wgpu",
            #[cfg(feature = "cuda")]
            Backend::Cuda => "cuda",
        }
    }

    /// Whether its device is there and computes. A processor's always is.
    ///
    /// # Errors
    ///
    /// What the device's driver says.
    pub fn ready(self) -> Result<(), String> {
        if self == Backend::Cpu {
            return Ok(());
        }
        // burn panics where there is no device, on a thread of its own
        let hook = std::panic::take_hook();
        let message = Arc::new(Mutex::new(String::new()));
        let first = Arc::clone(&message);
        std::panic::set_hook(Box::new(move |panic| {
            let mut first = first.lock().unwrap_or_else(|e| e.into_inner());
            if first.is_empty() {
                *first = panic.to_string().lines().skip(1).collect::<Vec<_>>().join(" ");
            }
        }));
        let tried = std::panic::catch_unwind(|| Tensor::<1>::ones([1], &self.device()).into_data());
        std::panic::set_hook(hook);
        let message = message.lock().unwrap_or_else(|e| e.into_inner());
        tried.map(drop).map_err(|_| format!("--backend {}: no usable device: {message}", self.name()))
    }

    fn device(self) -> Device {
        match self {
            Backend::Cpu => Device::flex(),
            #[cfg(feature = "wgpu")]
            Backend::Wgpu => Device::wgpu(burn::tensor::DeviceKind::DefaultDevice),
            #[cfg(feature = "cuda")]
            Backend::Cuda => Device::cuda(0),
        }
    }
}

/// Peak learning rate of fine-tuning over that of a training from random weights.
pub const FINE_TUNING_RATE: f64 = 0.1;

/// One training of several.
#[derive(Debug, Clone, Default)]
pub struct Job {
    /// Seed of weights and shuffling.
    pub seed: u64,
    /// Where it runs.
    pub backend: Backend,
    /// What to begin with, of the settings' architecture; absent: random weights.
    pub start: Option<Parameters>,
    /// Where to go on, instead of at the beginning; of this very training.
    pub resume: Option<Checkpoint>,
}

impl Job {
    /// What its checkpoints belong to.
    pub fn identity(&self, images: &Images, settings: &Learning, classes: usize) -> Identity {
        let mut identity =
            identity(architecture(settings, classes), settings, self.seed, images, self.backend.name());
        if let Some(start) = &self.start {
            identity.push(("start", serde_json::to_value(Bits::new(start)).unwrap_or_default()));
        }
        identity
    }
}

/// The network that a training's settings describe.
pub fn architecture(settings: &Learning, classes: usize) -> Architecture {
    Architecture {
        channels: usize::from(settings.channels),
        blocks: usize::from(settings.blocks),
        stem_stride: usize::from(settings.stem_stride),
        classes,
    }
}

/// Sees the state after every epoch, from any thread; an error ends the training.
pub type EpochCallback<'a> = dyn Fn(&dyn Fn() -> Checkpoint, &[Epoch]) -> Result<(), String> + Sync + 'a;

/// As [`EpochCallback`], with the job's number first.
pub type EpochCallbacks<'a> =
    dyn Fn(usize, &dyn Fn() -> Checkpoint, &[Epoch]) -> Result<(), String> + Sync + 'a;

/// Trains one network per job and images, `workers` at a time, and returns them in order.
///
/// `after_epoch(job, checkpoint, epochs)` is called after every epoch, from any thread; an error of its ends the training.
/// The results do not depend on `workers`.
///
/// # Errors
/// The first job's error, if any failed.
pub fn train_all(
    images: &[Images],
    jobs: &[Job],
    settings: &Learning,
    classes: usize,
    workers: usize,
    after_epoch: &EpochCallbacks,
) -> Result<Vec<Trained>, TrainingError> {
    // The longest first, so that no worker is left with it at the end.
    let mut order: Vec<usize> = (0..jobs.len().min(images.len())).collect();
    order.sort_by_key(|&j| std::cmp::Reverse(images[j].pixels.len()));
    let threads = (workers / jobs.len().max(1)).max(1);
    let next = AtomicUsize::new(0);
    let results: Vec<Mutex<Option<Result<Trained, TrainingError>>>> =
        order.iter().map(|_| Mutex::new(None)).collect();
    let work = || {
        while let Some(&j) = order.get(next.fetch_add(1, Ordering::Relaxed)) {
            let after_epoch =
                |state: &dyn Fn() -> Checkpoint, epochs: &[Epoch]| after_epoch(j, state, epochs);
            let trained = train(&images[j], settings, classes, &jobs[j], threads, &after_epoch);
            *results[j].lock().unwrap_or_else(|e| e.into_inner()) = Some(trained);
        }
    };
    std::thread::scope(|scope| {
        for _ in 1..workers.clamp(1, jobs.len().max(1)) {
            // a thread that the system refuses is a worker less
            let _ = std::thread::Builder::new().spawn_scoped(scope, work);
        }
        work();
    });
    results
        .into_iter()
        .map(|slot| {
            let lost = || Err(TrainingError::Thread("ended without a result".into()));
            slot.into_inner().unwrap_or_else(|e| e.into_inner()).unwrap_or_else(lost)
        })
        .collect()
}

/// Trains one network on `threads` threads; `after_epoch` is called after every epoch.
///
/// The result does not depend on `threads`, nor on how often it was interrupted and resumed.
///
/// # Errors
/// Images with a size or labels that do not fit; a checkpoint of another training; what `after_epoch` says; no thread.
pub fn train(
    images: &Images,
    settings: &Learning,
    classes: usize,
    job: &Job,
    threads: usize,
    after_epoch: &EpochCallback,
) -> Result<Trained, TrainingError> {
    check(images, settings, classes)?;
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads.max(1)).build();
    let pool = pool.map_err(|e| TrainingError::Thread(e.to_string()))?;
    pool.install(|| Learner::new(images, settings, classes, job)?.run(after_epoch))
}

fn check(images: &Images, settings: &Learning, classes: usize) -> Result<(), TrainingError> {
    let ensure = |field, value: usize, good: bool, legal: String| {
        Invalid::unless(good, field, value, legal).map_err(|invalid| invalid.at("training images").into())
    };
    let stride = usize::from(settings.stem_stride);
    let pixels = images.len() * images.rows * images.frames;
    ensure("number", images.len(), images.len() >= 2, "at least 2".into())?;
    ensure("pixels", images.pixels.len(), images.pixels.len() == pixels, format!("{pixels}"))?;
    ensure("rows", images.rows, images.rows > stride, format!("more than {stride}"))?;
    ensure("frames", images.frames, images.frames > stride, format!("more than {stride}"))?;
    let largest = usize::from(images.labels.iter().copied().max().unwrap_or(0));
    ensure("largest label", largest, largest < classes, format!("below {classes}"))
}

/// A training under way.
struct Learner<'a> {
    images: &'a Images,
    settings: &'a Learning,
    architecture: Architecture,
    seed: u64,
    backend: Backend,
    network: Network,
    optimizer: ModuleOptimizer,
    /// Which images are learned from, and which validate.
    train: Vec<usize>,
    validate: Vec<usize>,
    epochs: Vec<Epoch>,
    best: Option<Best>,
    workspace: Workspace,
}

impl<'a> Learner<'a> {
    fn new(
        images: &'a Images,
        settings: &'a Learning,
        classes: usize,
        job: &Job,
    ) -> Result<Learner<'a>, TrainingError> {
        let architecture = architecture(settings, classes);
        let mut parameters = match &job.start {
            Some(start) => start.clone(),
            None => Parameters::initial(architecture, job.seed),
        };
        let mut optimizer = optimizer(settings);
        let (mut epochs, mut best) = (Vec::new(), None);
        if let Some(checkpoint) = &job.resume {
            parameters = checkpoint.parameters.parameters(architecture)?;
            let bytes = Bytes::from_bytes_vec(decode(&checkpoint.optimizer)?);
            optimizer = optimizer.from_bytes(bytes).map_err(|_| Undecodable("optimizer"))?;
            (epochs, best) = (checkpoint.epochs.clone(), checkpoint.best.clone());
        }
        let (train, validate) = split(&images.labels, settings.validation, settings.windows as usize);
        let network = Network::new(&parameters, &job.backend.device().autodiff());
        let workspace = Workspace::default();
        let backend = job.backend;
        Ok(Learner {
            images,
            settings,
            architecture,
            seed: job.seed,
            backend,
            network,
            optimizer,
            train,
            validate,
            epochs,
            best,
            workspace,
        })
    }

    fn run(mut self, after_epoch: &EpochCallback) -> Result<Trained, TrainingError> {
        while self.epochs.len() < self.settings.epochs as usize && !self.stopped() {
            self.epoch();
            after_epoch(&|| self.checkpoint(), &self.epochs).map_err(TrainingError::EpochCallback)?;
        }
        let parameters = match &self.best {
            Some(best) => best.parameters.parameters(self.architecture)?,
            None => self.network.parameters(),
        };
        Ok(Trained { parameters, epochs: self.epochs })
    }

    /// Whether patience has run out.
    fn stopped(&self) -> bool {
        let patience = self.settings.patience as usize;
        self.best.as_ref().is_some_and(|b| patience > 0 && self.epochs.len() > b.epoch + patience)
    }

    fn checkpoint(&self) -> Checkpoint {
        Checkpoint {
            epochs: self.epochs.clone(),
            parameters: Bits::new(&self.network.parameters()),
            best: self.best.clone(),
            optimizer: self.optimizer.into_bytes().map_or_else(|_| String::new(), |bytes| encode(&bytes)),
        }
    }

    fn epoch(&mut self) {
        let number = self.epochs.len();
        let classes = self.architecture.classes;
        let device = self.backend.device().autodiff();
        let order = shuffled(self.train.len(), self.seed, number as u64);
        let batches = batches(self.train.len(), self.settings.batch as usize);
        let steps = batches.len() * self.settings.epochs as usize;
        let (mut loss_sum, mut right) = (0.0, 0);
        for (index, range) in batches.iter().enumerate() {
            let batch: Vec<usize> = order[range.clone()].iter().map(|&i| self.train[i]).collect();
            let mut augmented = Batch::of(self.images, &batch, classes);
            augment(&mut augmented, self.settings, &mut stream(self.seed, number, index));
            let (input, truth) = augmented.tensors(&device);
            let logits = match self.backend {
                Backend::Cpu => self.network.forward_batch(input, &self.workspace),
                #[cfg(any(feature = "wgpu", feature = "cuda"))]
                _ => self.network.forward(input),
            };
            right += self.right(&logits, &batch);
            let loss = (log_softmax(logits, 1) * truth).sum() / -(batch.len() as f64);
            loss_sum += scalar(&loss) * batch.len() as f64;
            let gradients = GradientsParams::from_grads(loss.backward(), &self.network);
            let rate = rate(self.settings, number * batches.len() + index, steps);
            self.network = self.optimizer.step(rate, self.network.clone(), gradients);
        }
        let n = self.train.len() as f64;
        let (loss, accuracy) = (loss_sum / n, right as f64 / n);
        let mut epoch = Epoch { loss, accuracy, validation_loss: None, validation_accuracy: None };
        if !self.validate.is_empty() {
            let (loss, accuracy) = self.validation();
            (epoch.validation_loss, epoch.validation_accuracy) = (Some(loss), Some(accuracy));
            if self.best.as_ref().is_none_or(|best| loss < best.loss) {
                let parameters = Bits::new(&self.network.parameters());
                self.best = Some(Best { epoch: number, loss, parameters });
            }
        }
        self.epochs.push(epoch);
    }

    /// Mean cross entropy and accuracy on the validation set.
    fn validation(&self) -> (f64, f64) {
        let device = self.backend.device();
        let network = Network::new(&self.network.parameters(), &device);
        let (mut loss, mut right) = (0.0, 0);
        for batch in self.validate.chunks(100) {
            let classes = self.architecture.classes;
            let (input, truth) = Batch::of(self.images, batch, classes).tensors(&device);
            let logits = network.forward(input);
            right += self.right(&logits, batch);
            loss -= scalar(&(log_softmax(logits, 1) * truth).sum());
        }
        (loss / self.validate.len() as f64, right as f64 / self.validate.len() as f64)
    }

    /// How many of these images have the largest logit at their label.
    fn right(&self, logits: &Tensor<2>, batch: &[usize]) -> usize {
        let answers: Vec<f32> = logits.to_data().iter::<f32>().collect();
        let labels = batch.iter().map(|&i| self.images.labels[i]);
        let answers = answers.chunks(self.architecture.classes).zip(labels);
        answers.filter(|(l, label)| first_maximum(l) == *label).count()
    }
}

fn scalar(tensor: &Tensor<1>) -> f64 {
    f64::from(tensor.to_data().iter::<f32>().next().unwrap_or(f32::NAN))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::network::float_network::FloatNetwork;
    use crate::network::synthetic::stripes;
    use crate::scenario::{Optimizer, Schedule};

    fn settings(epochs: u32) -> Learning {
        Learning { epochs, batch: 20, channels: 4, blocks: 2, stem_stride: 2, ..Learning::default() }
    }

    fn job(seed: u64) -> Job {
        Job { seed, ..Job::default() }
    }

    fn alone(images: &Images, settings: &Learning, seed: u64, threads: usize) -> Trained {
        train(images, settings, 5, &job(seed), threads, &|_, _| Ok(())).unwrap()
    }

    fn bits(trained: &Trained) -> Vec<u64> {
        trained.epochs.iter().map(|e| e.loss.to_bits()).collect()
    }

    #[test]
    fn it_learns_to_tell_stripes_it_never_saw() {
        let trained = alone(&stripes(24, 40, 1), &settings(12), 7, 2);
        let answers = FloatNetwork::new(&trained.parameters).classify(&stripes(24, 20, 2));
        assert!(answers.accuracy() >= 0.95, "{}", answers.accuracy());
        assert!(trained.epochs[11].loss < 0.3 * trained.epochs[0].loss);
    }

    #[test]
    fn neither_threads_nor_neighbours_change_a_bit() {
        let (images, others) = (stripes(24, 8, 1), stripes(30, 8, 2));
        let one = alone(&images, &settings(2), 7, 1);
        for threads in [1, 2, 3] {
            let inside = alone(&images, &settings(2), 7, threads);
            assert_eq!(bits(&inside), bits(&one));
            assert_eq!(inside.parameters, one.parameters);
        }
        assert_ne!(alone(&images, &settings(2), 9, 1).parameters, one.parameters);
        let both = [others, images];
        for workers in [1, 2] {
            let found =
                train_all(&both, &[job(8), job(7)], &settings(2), 5, workers, &|_, _, _| Ok(())).unwrap();
            assert_eq!(found[1], one);
        }
    }

    #[test]
    fn unfit_images_are_refused_by_name() {
        let mut images = stripes(24, 1, 1);
        let refuse = |i: &Images, classes| {
            train(i, &settings(1), classes, &job(1), 1, &|_, _| Ok(())).unwrap_err().to_string()
        };
        assert_eq!(refuse(&images, 4), "training images: largest label is 4, must be below 4");
        images.pixels.pop();
        assert!(refuse(&images, 5).starts_with("training images: pixels is 7679, must be 7680"));
    }

    #[test]
    fn an_interrupted_training_goes_on_with_the_same_bits() {
        let images = stripes(24, 8, 1);
        for (optimizer, schedule) in [
            (Optimizer::Adamw, Schedule::OneCycle),
            (Optimizer::Adam, Schedule::Constant),
            (Optimizer::Momentum, Schedule::Constant),
        ] {
            let settings = Learning { optimizer, schedule, validation: 0.25, patience: 3, ..settings(5) };
            let whole = alone(&images, &settings, 7, 1);
            let stored = Mutex::new(String::new());
            let stop = |state: &dyn Fn() -> Checkpoint, epochs: &[Epoch]| {
                *stored.lock().unwrap() = serde_json::to_string(&state()).unwrap();
                if epochs.len() == 2 { Err("enough".to_owned()) } else { Ok(()) }
            };
            let error = train(&images, &settings, 5, &job(7), 2, &stop).unwrap_err();
            assert_eq!(error.to_string(), "training: enough");
            let resume = Some(serde_json::from_str(&stored.lock().unwrap()).unwrap());
            let rest = Job { resume, ..job(7) };
            let resumed = train(&images, &settings, 5, &rest, 2, &|_, _| Ok(())).unwrap();
            assert_eq!(resumed, whole, "{optimizer:?}");
            let wider = Learning { channels: 8, ..settings };
            let error = train(&images, &wider, 5, &rest, 2, &|_, _| Ok(())).unwrap_err().to_string();
            assert_eq!(error, "checkpoint: parameters cannot be decoded");
        }
    }

    #[test]
    fn training_stops_when_validation_stops_improving() {
        // labels that say nothing about the images: validation can only get worse
        let mut images = stripes(24, 8, 1);
        images.labels.iter_mut().enumerate().for_each(|(i, label)| *label = (i / 5 % 5) as u8);
        let settings = Learning { validation: 0.5, patience: 2, learning_rate: 0.05, ..settings(30) };
        let trained = alone(&images, &settings, 7, 1);
        let losses: Vec<f64> = trained.epochs.iter().map(|e| e.validation_loss.unwrap()).collect();
        let best = losses.iter().enumerate().min_by(|a, b| a.1.total_cmp(b.1)).unwrap().0;
        assert_eq!(losses.len(), best + 3, "{losses:?}");
        assert!(losses.len() < 30);
    }
}
