//! Quantisation after training: a float network becomes an int8 one, with a report of what that cost.
//!
//! TensorFlow Lite's 8-bit specification: weights symmetric per output channel, activations on one grid per tensor,
//! biases in steps of the accumulator, scale ratios as Q31 multipliers with a shift (Jacob et al., 2018).

use crate::error::Invalid;

mod report;
pub use report::{LayerReport, QuantizationReport};

use super::calibration::{ActivationQuant, QuantParams, Rule, calibrate};
use super::float_network::{FloatNetwork, FoldedBlock, FoldedLayer};
use super::parameters::{Images, Parameters, shuffled};
use crate::formats::model_file::rescale::{add_ratios, multiplier, ratio};
use crate::formats::model_file::{Add, Block, Preprocessing, QuantizedLayer, QuantizedNetwork};

/// Training images that are used, at most.
pub const CALIBRATION_IMAGES: usize = 100;

fn ratio_too_large(layer: &str, channel: usize, ratio: f64) -> Invalid {
    let field = format!("{layer}: ratio of scales of output channel {channel}");
    Invalid::new(field, format!("{ratio:e}"), "below 128")
}

fn no_images() -> Invalid {
    Invalid::new("number of images", 0, "at least 1").at("calibration")
}

/// Converts a trained network into int8; ranges are measured on `images`, of which at most
/// [`CALIBRATION_IMAGES`] are used.
///
/// # Errors
/// No image; weights with a scale or an accumulator outside the format's range.
pub fn quantize(
    parameters: &Parameters,
    preprocessing: Preprocessing,
    classes: &[String],
    images: &Images,
) -> Result<(QuantizedNetwork, QuantizationReport), Invalid> {
    quantize_folded(&FloatNetwork::new(parameters), preprocessing, classes, images)
}

/// As [`quantize`], of a network with folded normalisations.
///
/// # Errors
/// As [`quantize`].
pub fn quantize_folded(
    float: &FloatNetwork,
    preprocessing: Preprocessing,
    classes: &[String],
    images: &Images,
) -> Result<(QuantizedNetwork, QuantizationReport), Invalid> {
    if images.is_empty() {
        return Err(no_images());
    }
    let images = drawn(images, CALIBRATION_IMAGES);
    let mut best: Option<(f64, Rule, ActivationQuant, Converted)> = None;
    let mut int8_loss = Vec::new();
    for (rule, activation_quant) in calibrate(float, &images) {
        let converted = convert(float, &activation_quant)?;
        let loss = converted
            .fake_quantised
            .evaluate(&images, |(), a, v| round_all(activation_quant.of(a), v))
            .0
            .loss;
        int8_loss.push((rule, loss));
        if best.as_ref().is_none_or(|b| loss < b.0) {
            best = Some((loss, rule, activation_quant, converted));
        }
    }
    let (_, rule, activation_quant, converted) = best.ok_or_else(no_images)?;
    let report = QuantizationReport {
        images: images.len(),
        rule,
        float_loss: float.classify(&images).loss,
        int8_loss,
        loss_before_qat: None,
        layers: report::compare(float, &converted.fake_quantised, &activation_quant, &images),
    };
    let network = QuantizedNetwork {
        preprocessing,
        classes: classes.to_vec(),
        stem_stride: float.architecture.stem_stride as u8,
        stem: converted.stem,
        blocks: converted.blocks,
        head: converted.head,
    };
    Ok((network, report))
}

/// At most `most` images, drawn without regard to their order, which may repeat the classes.
fn drawn(images: &Images, most: usize) -> Images {
    let mut chosen = shuffled(images.len(), 0, 0);
    chosen.truncate(most);
    Images {
        rows: images.rows,
        frames: images.frames,
        pixels: chosen.iter().flat_map(|&i| images.image(i).iter().copied()).collect(),
        labels: chosen.iter().map(|&i| images.labels[i]).collect(),
    }
}

fn round_all(grid: QuantParams, values: &mut [f32]) {
    values.iter_mut().for_each(|v| *v = grid.round(*v));
}

/// The int8 layers, and the float network with their rounded weights that fake-quantises them.
struct Converted {
    stem: QuantizedLayer,
    blocks: Vec<Block>,
    head: QuantizedLayer,
    fake_quantised: FloatNetwork,
}

fn convert(float: &FloatNetwork, activation_quant: &ActivationQuant) -> Result<Converted, Invalid> {
    let (stem, rounded_stem) = convert_layer("stem", &float.stem, QuantParams::IMAGE, activation_quant.stem)?;
    let (mut blocks, mut rounded_blocks) = (Vec::new(), Vec::new());
    let mut x = activation_quant.stem;
    for (b, (block, &[affine, conv1, conv2, add])) in
        float.blocks.iter().zip(&activation_quant.blocks).enumerate()
    {
        let name = |layer: &str| format!("block {b} {layer}");
        let (affine_layer, rounded_affine) = convert_layer(&name("affine"), &block.affine, x, affine)?;
        let (conv1_layer, rounded_conv1) = convert_layer(&name("conv1"), &block.conv1, affine, conv1)?;
        let (conv2_layer, rounded_conv2) = convert_layer(&name("conv2"), &block.conv2, conv1, conv2)?;
        blocks.push(Block {
            affine: affine_layer,
            conv1: conv1_layer,
            conv2: conv2_layer,
            add: convert_add(&name("add"), x, conv2, add)?,
        });
        rounded_blocks.push(FoldedBlock {
            affine: rounded_affine,
            conv1: rounded_conv1,
            conv2: rounded_conv2,
        });
        x = add;
    }
    let (head, rounded_head) = convert_layer("head", &float.head, x, activation_quant.logits)?;
    let fake_quantised = FloatNetwork {
        architecture: float.architecture,
        stem: rounded_stem,
        blocks: rounded_blocks,
        head: rounded_head,
    };
    Ok(Converted { stem, blocks, head, fake_quantised })
}

/// The float network with the weights that int8 has on these activation_quant.
#[cfg(all(test, feature = "train"))]
pub(super) fn fake_quantize(
    float: &FloatNetwork,
    activation_quant: &ActivationQuant,
) -> Result<FloatNetwork, Invalid> {
    convert(float, activation_quant).map(|converted| converted.fake_quantised)
}

/// One layer with weights; also what its rounded weights and biases stand for.
fn convert_layer(
    name: &str,
    layer: &FoldedLayer,
    input: QuantParams,
    output: QuantParams,
) -> Result<(QuantizedLayer, FoldedLayer), Invalid> {
    let outputs = layer.biases.len();
    let mut out = QuantizedLayer {
        in_scale: input.scale,
        out_scale: output.scale,
        in_zero: input.zero,
        out_zero: output.zero,
        act_min: -128,
        act_max: 127,
        multipliers: Vec::with_capacity(outputs),
        biases: Vec::with_capacity(outputs),
        shifts: Vec::with_capacity(outputs),
        weights: Vec::with_capacity(layer.weights.len()),
    };
    let mut rounded = FoldedLayer { weights: Vec::new(), biases: Vec::new() };
    let in_scale = f64::from(input.scale);
    let kernels = layer.weights.chunks_exact(layer.weights.len() / outputs);
    for (channel, (kernel, &bias)) in kernels.zip(&layer.biases).enumerate() {
        let step = weight_scale(kernel, bias, in_scale);
        let scale = f64::from(step);
        let quantized = kernel.iter().map(|w| (w / scale).round().clamp(-127.0, 127.0) as i8);
        let start = out.weights.len();
        out.weights.extend(quantized);
        let quantized_bias = (bias / (in_scale * scale)).round();
        let ratio = ratio(input.scale, step, output.scale);
        let fail = || ratio_too_large(name, channel, ratio);
        let (multiplier, shift) = multiplier(ratio).ok_or_else(fail)?;
        let weights: f64 = out.weights[start..].iter().map(|&w| f64::from(w).abs()).sum();
        let largest = 255.0 * weights + quantized_bias.abs();
        let limit = libm::exp2(31.0 - f64::from(shift.max(0)));
        if largest >= limit {
            let field = format!("{name}: largest sum of output channel {channel}");
            return Err(Invalid::new(field, largest, format!("below {limit}")));
        }
        out.biases.push(quantized_bias as i32);
        out.multipliers.push(multiplier);
        out.shifts.push(shift);
        rounded.weights.extend(out.weights[start..].iter().map(|&w| f64::from(w) * scale));
        rounded.biases.push(quantized_bias * in_scale * scale);
    }
    Ok((out, rounded))
}

/// Step of a channel's weights: the largest is 127 of them, and the bias fits 30 bits. In f32, as every file format
/// for int8 networks holds it, so that the multiplier made of it is the one another program makes.
fn weight_scale(kernel: &[f64], bias: f64, in_scale: f64) -> f32 {
    let largest = kernel.iter().fold(0.0f64, |m, w| m.max(w.abs()));
    let scale = (largest / 127.0).max(bias.abs() / in_scale / f64::from(1u32 << 30)) as f32;
    if scale.is_normal() { scale } else { 1.0 }
}

/// The addition of a skip on grid `a` and a branch on grid `b`.
fn convert_add(name: &str, a: QuantParams, b: QuantParams, sum: QuantParams) -> Result<Add, Invalid> {
    let ratios = add_ratios(a.scale, b.scale, sum.scale);
    let mut pairs = [(0, 0); 3];
    for (channel, (pair, &ratio)) in pairs.iter_mut().zip(&ratios).enumerate() {
        let fail = || ratio_too_large(name, channel, ratio);
        *pair = multiplier(ratio).ok_or_else(fail)?;
    }
    Ok(Add {
        in1_scale: a.scale,
        in2_scale: b.scale,
        out_scale: sum.scale,
        in1_zero: a.zero,
        in2_zero: b.zero,
        out_zero: sum.zero,
        act_min: -128,
        act_max: 127,
        multipliers: pairs.map(|p| p.0),
        shifts: pairs.map(|p| p.1),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::network::integer::infer;
    use crate::network::parameters::Architecture;
    use crate::network::synthetic::{stripes, trained_looking};

    fn preprocessing(frames: u16) -> Preprocessing {
        Preprocessing {
            radar: sdp3_core::config::RadarConfig::PAPER,
            sensing_slots: 128 + 8 * (frames - 1),
            first_kept: 2,
            last_kept: 8,
            window_len: 128,
            hop: 8,
            bins_per_row: 1,
            range: 1063,
            kaiser_beta: 10.0,
            carrier_khz: 3_500_000,
            slow_time_us: 1000,
        }
    }

    fn names() -> Vec<String> {
        (0..5).map(|i| format!("class {i}")).collect()
    }

    #[test]
    fn int8_answers_as_the_fake_quantized_network_and_nearly_as_float() {
        for (stem_stride, frames) in [(1, 10), (2, 35)] {
            let architecture = Architecture { channels: 8, blocks: 2, stem_stride, classes: 5 };
            let parameters = trained_looking(architecture, 21);
            let images = stripes(frames, 6, 1);
            let (network, report) =
                quantize(&parameters, preprocessing(frames as u16), &names(), &images).unwrap();
            assert_eq!(report.layers.len(), 2 + 4 * 2 + 2);
            assert!(report.layers.iter().all(|l| l.sqnr_db > 15.0), "{report:#?}");
            let float = FloatNetwork::new(&parameters);
            let step = network.head.out_scale;
            for image in (0..images.len()).map(|i| images.image(i)) {
                let exact = float.forward(image, 64, &mut |_, _| {});
                for (a, b) in infer(&network, image).iter().zip(&exact) {
                    assert!((a - b).abs() < 14.0 * step, "{a} {b} {step}");
                }
            }
        }
    }

    #[test]
    fn calibration_sees_every_class() {
        let images = stripes(10, 100, 1);
        let chosen = drawn(&images, CALIBRATION_IMAGES);
        assert_eq!((chosen.len(), chosen.pixels.len()), (100, 100 * 640));
        for class in 0..5 {
            let count = chosen.labels.iter().filter(|&&l| l == class).count();
            assert!((10..=30).contains(&count), "{count} of class {class}");
        }
    }

    #[test]
    fn a_silent_channel_keeps_its_bias() {
        let layer = FoldedLayer { weights: vec![0.0; 4], biases: vec![0.5, -0.25, 0.0, 0.9] };
        let output = QuantParams::covering(-1.0, 1.0);
        let (weighted, rounded) = convert_layer("head", &layer, QuantParams::IMAGE, output).unwrap();
        for (channel, bias) in [0.5f32, -0.25, 0.0, 0.9].into_iter().enumerate() {
            assert!((rounded.biases[channel] - f64::from(bias)).abs() < 1e-6);
            let q = weighted.out(channel, i64::from(weighted.biases[channel])) as i8;
            assert_eq!(q, output.quantize(bias), "{channel}");
        }
    }

    #[test]
    fn what_cannot_be_said_is_refused_by_name() {
        let layer = FoldedLayer { weights: vec![1.0], biases: vec![0.0] };
        let fine = QuantParams { scale: 1e-9, zero: 0 };
        let error = convert_layer("block 3 conv1", &layer, QuantParams::IMAGE, fine).unwrap_err().to_string();
        assert!(error.starts_with("block 3 conv1: ratio of scales of output channel 0 is "), "{error}");
        let none = Images { rows: 64, frames: 10, pixels: vec![], labels: vec![] };
        let parameters =
            trained_looking(Architecture { channels: 4, blocks: 1, stem_stride: 1, classes: 5 }, 1);
        assert!(quantize(&parameters, preprocessing(10), &names(), &none).is_err());
    }

    #[cfg(feature = "train")]
    #[test]
    fn a_trained_network_answers_alike_in_int8() {
        use crate::network::float_network::first_maximum;
        use crate::scenario::Learning;
        let settings = Learning { epochs: 12, batch: 20, channels: 8, stem_stride: 2, ..Learning::default() };
        let training = stripes(24, 40, 1);
        let job = crate::network::training::Job { seed: 7, ..Default::default() };
        let trained =
            crate::network::training::train(&training, &settings, 5, &job, 2, &|_, _| Ok(())).unwrap();
        let (network, _) = quantize(&trained.parameters, preprocessing(24), &names(), &training).unwrap();
        assert_eq!(network.to_bytes().unwrap().len() % 4, 0);
        let held_out = stripes(24, 60, 2);
        let float = FloatNetwork::new(&trained.parameters).classify(&held_out);
        let agree = (0..held_out.len())
            .filter(|&i| first_maximum(&infer(&network, held_out.image(i))) == float.classes[i])
            .count();
        assert!(agree * 100 >= held_out.len() * 98, "{agree} of {}", held_out.len());
    }
}
