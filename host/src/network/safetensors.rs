//! Float parameters as safetensors: the network that other programs train or look at.
//!
//! Names and layouts are PyTorch's; all tensors are float32, C channels, K classes, `b` counts blocks from 0:
//!
//! ```text
//! stem.weight [C, 1, 3, 3]      stem.bias [C]
//! blocks.b.norm1.weight, .bias, .running_mean, .running_var [C]       BatchNorm2d, epsilon 1e-5
//! blocks.b.conv1.weight [C, C, 3, 3]      blocks.b.conv1.bias [C] may be there
//! blocks.b.norm2.weight, .bias, .running_mean, .running_var [C]
//! blocks.b.conv2.weight [C, C, 3, 3]      blocks.b.conv2.bias [C]
//! head.weight [K, C]      head.bias [K]
//! ```
//!
//! The image is `[1, 64, frames]`, `(pixel + 128) / 255`; convolutions are padded as TensorFlow's `SAME`, which at
//! stride 2 is one row and column behind only. The metadata's `stem_stride` is 1 or 2. A `num_batches_tracked` is
//! passed over.

use crate::error::Invalid;
use safetensors::SafeTensors;
use safetensors::tensor::{Dtype, TensorView, serialize};
use std::collections::{BTreeSet, HashMap};
use std::fmt::Display;
use thiserror::Error;

use super::parameters::{Architecture, BlockParameters, Norm, Parameters, Weights};
use sdp3_core::dsn::conv::MAX_CHANNELS;
use sdp3_core::dsn::head::MAX_CLASSES;
use sdp3_core::dsn::model::MAX_BLOCKS;

/// Metadata's name of the input convolution's stride.
const STRIDE: &str = "stem_stride";

/// Why a file's tensors are not this network's.
#[derive(Debug, Error)]
pub enum SafetensorsError {
    /// The container is not whole.
    #[error("not a readable safetensors file: {0}")]
    Container(#[from] safetensors::SafeTensorError),
    /// A field that may not be what it is.
    #[error(transparent)]
    Invalid(#[from] Invalid),
}

fn wrong(field: impl Display, value: impl Display, legal: impl Display) -> SafetensorsError {
    Invalid::new(field, value, legal).into()
}

/// Names, shapes and values of every tensor.
fn list(p: &Parameters) -> Vec<(String, Vec<usize>, &[f32])> {
    let Architecture { channels: c, classes, .. } = p.architecture;
    let mut all: Vec<(String, Vec<usize>, &[f32])> = vec![
        ("stem.weight".into(), vec![c, 1, 3, 3], &p.stem.weights),
        ("stem.bias".into(), vec![c], &p.stem.biases),
        ("head.weight".into(), vec![classes, c], &p.head.weights),
        ("head.bias".into(), vec![classes], &p.head.biases),
    ];
    for (b, block) in p.blocks.iter().enumerate() {
        for (norm, n) in [("norm1", &block.norm1), ("norm2", &block.norm2)] {
            let parts = [
                ("weight", &n.gamma),
                ("bias", &n.beta),
                ("running_mean", &n.mean),
                ("running_var", &n.variance),
            ];
            all.extend(
                parts.map(|(part, values)| (format!("blocks.{b}.{norm}.{part}"), vec![c], &values[..])),
            );
        }
        all.push((format!("blocks.{b}.conv1.weight"), vec![c, c, 3, 3], &block.conv1));
        all.push((format!("blocks.{b}.conv2.weight"), vec![c, c, 3, 3], &block.conv2.weights));
        all.push((format!("blocks.{b}.conv2.bias"), vec![c], &block.conv2.biases));
    }
    all
}

/// A network's parameters as a file.
///
/// # Errors
/// A list of values of another length than its shape's.
pub fn write(parameters: &Parameters) -> Result<Vec<u8>, SafetensorsError> {
    let list = list(parameters);
    for (name, shape, values) in &list {
        let count: usize = shape.iter().product();
        if values.len() != count {
            return Err(wrong(format!("tensor {name}: number of values"), values.len(), count.to_string()));
        }
    }
    let bytes: Vec<Vec<u8>> =
        list.iter().map(|(.., values)| values.iter().flat_map(|v| v.to_le_bytes()).collect()).collect();
    let views = list
        .iter()
        .zip(&bytes)
        .map(|((name, shape, _), bytes)| Ok((name, TensorView::new(Dtype::F32, shape.clone(), bytes)?)));
    let views = views.collect::<Result<Vec<_>, safetensors::SafeTensorError>>()?;
    let metadata = HashMap::from([(STRIDE.to_owned(), parameters.architecture.stem_stride.to_string())]);
    Ok(serialize(views, Some(metadata))?)
}

/// Whether parameters are a network that this program has, and of the architecture they name.
///
/// # Errors
/// The tensor, its value and what is legal.
pub fn check(parameters: &Parameters) -> Result<(), SafetensorsError> {
    let named = parameters.architecture;
    let found = read(&write(parameters)?, named.stem_stride)?.architecture;
    match found == named {
        true => Ok(()),
        false => Err(wrong("architecture", format!("{named:?}"), format!("{found:?}"))),
    }
}

/// Tensors by name, and which have been asked for.
struct Tensors<'a> {
    file: SafeTensors<'a>,
    taken: BTreeSet<String>,
}

impl Tensors<'_> {
    fn shape(&self, name: &str, legal: &str) -> Result<Vec<usize>, SafetensorsError> {
        let tensor = self.file.tensor(name).map_err(|_| wrong(format!("tensor {name}"), "missing", legal))?;
        Ok(tensor.shape().to_vec())
    }

    /// The finite values of a tensor of this shape.
    fn take(&mut self, name: &str, shape: &[usize]) -> Result<Vec<f32>, SafetensorsError> {
        let legal = format!("float32 {shape:?}");
        let tensor =
            self.file.tensor(name).map_err(|_| wrong(format!("tensor {name}"), "missing", &legal))?;
        if tensor.dtype() != Dtype::F32 || tensor.shape() != shape {
            let found = format!("{:?} {:?}", tensor.dtype(), tensor.shape());
            return Err(wrong(format!("tensor {name}"), found, legal));
        }
        self.taken.insert(name.to_owned());
        let (words, _) = tensor.data().as_chunks::<4>();
        let values: Vec<f32> = words.iter().map(|w| f32::from_le_bytes(*w)).collect();
        match values.iter().position(|v| !v.is_finite()) {
            Some(at) => Err(wrong(format!("tensor {name}, value {at}"), values[at], "finite")),
            None => Ok(values),
        }
    }

    fn norm(&mut self, name: &str, c: usize) -> Result<Norm, SafetensorsError> {
        let mut part = |part: &str| self.take(&format!("{name}.{part}"), &[c]);
        let (gamma, beta) = (part("weight")?, part("bias")?);
        let (mean, variance) = (part("running_mean")?, part("running_var")?);
        match variance.iter().position(|&v| v < 0.0) {
            Some(at) => {
                Err(wrong(format!("tensor {name}.running_var, value {at}"), variance[at], "0 or above"))
            }
            None => Ok(Norm { gamma, beta, mean, variance }),
        }
    }

    fn block(&mut self, b: usize, c: usize) -> Result<BlockParameters, SafetensorsError> {
        let name = |part: &str| format!("blocks.{b}.{part}");
        let norm1 = self.norm(&name("norm1"), c)?;
        let conv1 = self.take(&name("conv1.weight"), &[c, c, 3, 3])?;
        let mut norm2 = self.norm(&name("norm2"), c)?;
        if self.file.tensor(&name("conv1.bias")).is_ok() {
            // (x + bias) - mean = x - (mean - bias)
            let bias = self.take(&name("conv1.bias"), &[c])?;
            norm2.mean.iter_mut().zip(bias).for_each(|(mean, bias)| *mean -= bias);
        }
        let weights = self.take(&name("conv2.weight"), &[c, c, 3, 3])?;
        let biases = self.take(&name("conv2.bias"), &[c])?;
        Ok(BlockParameters { norm1, conv1, norm2, conv2: Weights { weights, biases } })
    }
}

/// Reads a network's parameters; `stem_stride` is used where the file's metadata does not say.
///
/// # Errors
/// A damaged container; a tensor that is missing, unknown, of another shape or type, or not finite.
pub fn read(file: &[u8], stem_stride: usize) -> Result<Parameters, SafetensorsError> {
    let (_, metadata) = SafeTensors::read_metadata(file)?;
    let stated = metadata.metadata().as_ref().and_then(|m| m.get(STRIDE));
    let stem_stride = match stated.map(String::as_str) {
        None => stem_stride,
        Some("1") => 1,
        Some("2") => 2,
        Some(other) => return Err(wrong(format!("metadata {STRIDE}"), other, "1 or 2")),
    };
    let mut t = Tensors { file: SafeTensors::deserialize(file)?, taken: BTreeSet::new() };
    let legal = format!("[C, 1, 3, 3] with C a multiple of 4 up to {MAX_CHANNELS}");
    let shape = t.shape("stem.weight", &legal)?;
    let c = match shape[..] {
        [c, 1, 3, 3] if (4..=MAX_CHANNELS).contains(&c) && c.is_multiple_of(4) => c,
        _ => return Err(wrong("tensor stem.weight: shape", format!("{shape:?}"), legal)),
    };
    let legal = format!("[2 to {MAX_CLASSES}, {c}]");
    let shape = t.shape("head.weight", &legal)?;
    let classes = match shape[..] {
        [k, inputs] if (2..=MAX_CLASSES).contains(&k) && inputs == c => k,
        _ => return Err(wrong("tensor head.weight: shape", format!("{shape:?}"), legal)),
    };
    let blocks = (0..).take_while(|b| t.file.tensor(&format!("blocks.{b}.conv1.weight")).is_ok()).count();
    if !(1..=MAX_BLOCKS).contains(&blocks) {
        return Err(wrong("number of blocks.b.conv1.weight", blocks, format!("1 to {MAX_BLOCKS}")));
    }
    let architecture = Architecture { channels: c, blocks, stem_stride, classes };
    let stem = Weights { weights: t.take("stem.weight", &[c, 1, 3, 3])?, biases: t.take("stem.bias", &[c])? };
    let head =
        Weights { weights: t.take("head.weight", &[classes, c])?, biases: t.take("head.bias", &[classes])? };
    let blocks = (0..blocks).map(|b| t.block(b, c)).collect::<Result<_, _>>()?;
    let known = |name: &str| t.taken.contains(name) || name.ends_with(".num_batches_tracked");
    let mut names = t.file.names();
    names.sort_unstable();
    match names.into_iter().find(|name| !known(name)) {
        Some(name) => {
            Err(wrong(format!("tensor {name:?}"), "there", "absent: the network has no such tensor"))
        }
        None => Ok(Parameters { architecture, stem, blocks, head }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::network::synthetic::trained_looking;

    fn network() -> Parameters {
        trained_looking(Architecture { channels: 8, blocks: 2, stem_stride: 2, classes: 5 }, 3)
    }

    #[test]
    fn what_was_written_is_read() {
        let file = write(&network()).unwrap();
        assert_eq!(read(&file, 1).unwrap(), network());
        assert_eq!(file, write(&network()).unwrap());
    }

    #[test]
    fn a_bias_before_a_normalisation_goes_into_its_mean() {
        let parameters = network();
        let bias: Vec<u8> = (0..8).flat_map(|i| (0.25 * i as f32).to_le_bytes()).collect();
        let file = write(&parameters).unwrap();
        let tensors = SafeTensors::deserialize(&file).unwrap();
        let extra = ("blocks.1.conv1.bias".to_owned(), TensorView::new(Dtype::F32, vec![8], &bias).unwrap());
        let file = serialize(tensors.tensors().into_iter().chain([extra]), None).unwrap();
        let found = read(&file, 2).unwrap();
        for (i, (a, b)) in found.blocks[1].norm2.mean.iter().zip(&parameters.blocks[1].norm2.mean).enumerate()
        {
            assert_eq!(*a, b - 0.25 * i as f32);
        }
    }

    #[test]
    fn parameters_are_of_the_architecture_they_name() {
        assert!(check(&network()).is_ok());
        let error = |change: fn(&mut Architecture)| {
            let mut p = network();
            change(&mut p.architecture);
            check(&p).unwrap_err().to_string()
        };
        assert_eq!(error(|a| a.channels = 16), "tensor stem.weight: number of values is 72, must be 144");
        let other = error(|a| a.blocks = 7);
        assert!(other.contains("blocks: 7") && other.contains("blocks: 2"), "{other}");
    }

    #[test]
    fn errors_name_tensor_value_and_range() {
        let corrupted = |change: fn(&mut Parameters)| {
            let mut p = network();
            change(&mut p);
            read(&write(&p).unwrap(), 1).unwrap_err().to_string()
        };
        assert_eq!(
            corrupted(|p| p.blocks[1].conv2.weights[5] = f32::NAN),
            "tensor blocks.1.conv2.weight, value 5 is NaN, must be finite"
        );
        assert!(
            corrupted(|p| p.blocks[0].norm1.variance[2] = -1.0)
                .contains("running_var, value 2 is -1, must be 0")
        );
        assert!(corrupted(|p| p.architecture.stem_stride = 3).contains("stem_stride is 3, must be 1 or 2"));
        let file = write(&network()).unwrap();
        assert!(
            read(&file[..file.len() - 1], 1).unwrap_err().to_string().contains("not a readable safetensors")
        );
        let tensors = SafeTensors::deserialize(&file).unwrap();
        let but = |name: &str| tensors.tensors().into_iter().filter(|(n, _)| n != name).collect::<Vec<_>>();
        let error = read(&serialize(but("head.bias"), None).unwrap(), 1).unwrap_err().to_string();
        assert_eq!(error, "tensor head.bias is missing, must be float32 [5]");
        let mut more = but("");
        more.push(("blocks.2.conv9".into(), TensorView::new(Dtype::F32, vec![1], &[0; 4]).unwrap()));
        let error = read(&serialize(more, None).unwrap(), 1).unwrap_err().to_string();
        assert!(error.starts_with("tensor \"blocks.2.conv9\" is there"), "{error}");
    }
}
