//! The int8 network by TFLite's 8-bit specification, from the bytes of a model file by a parser of its own.
//!
//! CONV_2D (SAME), MAX_POOL_2D, DEPTHWISE_CONV_2D 1x1, ADD, AVERAGE_POOL_2D, with gemmlowp's double rounding.

/// A tensor `[height][width][channels]` of int8 values held as i64.
#[derive(Debug, Clone)]
struct Tensor {
    height: usize,
    width: usize,
    channels: usize,
    data: Vec<i64>,
}

impl Tensor {
    fn zeros(height: usize, width: usize, channels: usize) -> Self {
        Tensor { height, width, channels, data: vec![0; height * width * channels] }
    }

    fn at(&self, y: usize, x: usize, c: usize) -> i64 {
        self.data[(y * self.width + x) * self.channels + c]
    }

    fn set(&mut self, y: usize, x: usize, c: usize, value: i64) {
        self.data[(y * self.width + x) * self.channels + c] = value;
    }
}

/// What the reference network answers.
#[derive(Debug)]
pub struct ReferenceOutput {
    /// Every layer's output: pooled stem; per block affine, convolution, convolution, sum; averaged features.
    pub layers: Vec<Vec<i64>>,
    /// One for each class.
    pub logits: Vec<i64>,
    /// Softmax probability of the largest logit.
    pub confidence: f64,
}

/// Preprocessing fields of a model file.
#[derive(Debug, Clone, Copy)]
pub struct Header {
    pub first: usize,
    pub last: usize,
    pub window: usize,
    pub hop: usize,
    /// Bins summed into a row.
    pub bins_per_row: usize,
    /// Range in level units.
    pub range: i64,
    pub beta: f64,
    /// Frames of the image.
    pub frames: usize,
    pub radar: Radar,
}

/// Radar fields of a model file: eight bytes, or zeros for the paper's.
#[derive(Debug, Clone, Copy)]
pub struct Radar {
    /// Samples of a sweep.
    pub samples: usize,
    pub kept: usize,
    pub real: bool,
    /// Dechirped in the sensor.
    pub analog: bool,
    /// Bins of a range sample, 0 without a gate.
    pub bins: usize,
    /// First bin of the gate.
    pub first_bin: usize,
}

impl Radar {
    /// Whether range samples are real.
    pub fn one_sided(&self) -> bool {
        self.real && self.bins == 0
    }
}

pub fn header(model: &[u8]) -> Header {
    let half = |at: usize| usize::from(model[at]) + 256 * usize::from(model[at + 1]);
    let radar = match half(48) {
        0 => Radar { samples: 1000, kept: 8, real: false, analog: false, bins: 0, first_bin: 0 },
        samples => Radar {
            samples,
            kept: usize::from(model[50]),
            real: model[52] & 1 != 0,
            analog: model[52] & 4 != 0,
            bins: usize::from(model[53]),
            first_bin: half(54),
        },
    };
    Header {
        radar,
        first: usize::from(model[14]),
        last: usize::from(model[15]),
        window: half(16),
        hop: half(18),
        bins_per_row: usize::from(model[22]),
        range: half(24) as i64,
        frames: half(26),
        beta: f64::from(f32::from_le_bytes([model[28], model[29], model[30], model[31]])),
    }
}

struct Bytes<'a> {
    model: &'a [u8],
    at: usize,
}

impl Bytes<'_> {
    fn i8(&mut self) -> i64 {
        self.at += 1;
        i64::from(self.model[self.at - 1] as i8)
    }

    fn i32(&mut self) -> i64 {
        self.at += 4;
        let b = &self.model[self.at - 4..self.at];
        i64::from(i32::from_le_bytes([b[0], b[1], b[2], b[3]]))
    }

    fn f32(&mut self) -> f64 {
        f64::from(f32::from_bits(self.i32() as i32 as u32))
    }

    fn many(&mut self, count: usize, each: fn(&mut Self) -> i64) -> Vec<i64> {
        (0..count).map(|_| each(self)).collect()
    }

    fn pad(&mut self, count: usize) {
        self.at += (4 - count % 4) % 4;
    }

    /// A layer with per-channel quantisation.
    fn layer(&mut self, channels: usize, taps: usize) -> Layer {
        let begin = self.many(8, Self::i8);
        self.f32();
        let scale = self.f32();
        let multiplier = self.many(channels, Self::i32);
        let bias = self.many(channels, Self::i32);
        let shift = self.many(channels, Self::i8);
        self.pad(channels);
        let weights = self.many(channels * taps, Self::i8);
        self.pad(channels * taps);
        Layer {
            in_zp: begin[1],
            out_zp: begin[2],
            low: begin[3],
            high: begin[4],
            multiplier,
            bias,
            shift,
            weights,
            scale,
        }
    }
}

struct Layer {
    in_zp: i64,
    out_zp: i64,
    low: i64,
    high: i64,
    multiplier: Vec<i64>,
    bias: Vec<i64>,
    shift: Vec<i64>,
    weights: Vec<i64>,
    scale: f64,
}

impl Layer {
    fn output(&self, o: usize, accumulator: i64) -> i64 {
        let scaled = requantize(self.bias[o] + accumulator, self.multiplier[o], self.shift[o]);
        (scaled + self.out_zp).clamp(self.low, self.high)
    }
}

/// gemmlowp: round(a b / 2^31) to nearest with its nudge, then round(x / 2^n) with halves away from zero.
fn requantize(accumulator: i64, multiplier: i64, shift: i64) -> i64 {
    let shifted = i64::from((accumulator as i32).wrapping_shl(shift.max(0) as u32));
    let product = shifted * multiplier;
    // truncating division after adding half of the divisor towards the product's sign
    let nudge = if product >= 0 { 1 << 30 } else { 1 - (1 << 30) };
    let high = (product + nudge) / (1 << 31);
    let divisor = 1_i64 << (-shift).max(0);
    if high >= 0 { (high + divisor / 2) / divisor } else { -((-high + divisor / 2) / divisor) }
}

fn conv(input: &Tensor, layer: &Layer, outputs: usize, stride: usize) -> Tensor {
    let axis = |n: usize| {
        let out = n.div_ceil(stride);
        (out, ((out as i64 - 1) * stride as i64 + 3 - n as i64).max(0) / 2)
    };
    let ((height, top), (width, left)) = (axis(input.height), axis(input.width));
    let mut result = Tensor::zeros(height, width, outputs);
    for y in 0..height {
        for x in 0..width {
            for o in 0..outputs {
                let mut sum = 0;
                for ky in 0..3 {
                    for kx in 0..3 {
                        let yy = (y * stride) as i64 + ky - top;
                        let xx = (x * stride) as i64 + kx - left;
                        if yy < 0 || xx < 0 || yy >= input.height as i64 || xx >= input.width as i64 {
                            continue;
                        }
                        for i in 0..input.channels {
                            let tap = ((o * 3 + ky as usize) * 3 + kx as usize) * input.channels + i;
                            sum += (input.at(yy as usize, xx as usize, i) - layer.in_zp) * layer.weights[tap];
                        }
                    }
                }
                result.set(y, x, o, layer.output(o, sum));
            }
        }
    }
    result
}

/// Runs the network of a model file on an image `[64][frames]`.
pub fn infer(model: &[u8], image: &[i8]) -> ReferenceOutput {
    let h = header(model);
    let stride = usize::from(model[23]);
    let (channels, blocks, classes) =
        (usize::from(model[32]), usize::from(model[33]), usize::from(model[34]));
    let mut bytes = Bytes { model, at: 64 + 24 * classes };
    let data = image.iter().map(|&p| i64::from(p)).collect();
    let input = Tensor { height: 64, width: h.frames, channels: 1, data };

    let stem = conv(&input, &bytes.layer(channels, 9), channels, stride);
    let mut x = Tensor::zeros(stem.height / 2, stem.width / 2, channels);
    for y in 0..x.height {
        for column in 0..x.width {
            for c in 0..channels {
                let square = [(0, 0), (0, 1), (1, 0), (1, 1)];
                let most = square.iter().map(|(dy, dx)| stem.at(2 * y + dy, 2 * column + dx, c)).max();
                x.set(y, column, c, most.expect("four"));
            }
        }
    }
    let mut layers = vec![x.data.clone()];
    for _ in 0..blocks {
        let affine = bytes.layer(channels, 1);
        let mut t = x.clone();
        for (index, value) in t.data.iter_mut().enumerate() {
            let c = index % channels;
            *value = affine.output(c, (*value - affine.in_zp) * affine.weights[c]);
        }
        layers.push(t.data.clone());
        for _ in 0..2 {
            t = conv(&t, &bytes.layer(channels, 9 * channels), channels, 1);
            layers.push(t.data.clone());
        }
        let begin = bytes.many(8, Bytes::i8);
        bytes.at += 12; // three scales, for people
        let multiplier = bytes.many(3, Bytes::i32);
        let shift = bytes.many(4, Bytes::i8);
        for (a, b) in x.data.iter_mut().zip(&t.data) {
            let left = requantize((*a - begin[1]) << 20, multiplier[0], shift[0]);
            let right = requantize((b - begin[5]) << 20, multiplier[1], shift[1]);
            *a = (requantize(left + right, multiplier[2], shift[2]) + begin[2]).clamp(begin[3], begin[4]);
        }
        layers.push(x.data.clone());
    }
    let pixels = (x.height * x.width) as i64;
    let features: Vec<i64> = (0..channels)
        .map(|c| {
            let sum: i64 = x.data.iter().skip(c).step_by(channels).sum();
            let magnitude = (sum.abs() + pixels / 2) / pixels;
            if sum < 0 { -magnitude } else { magnitude }
        })
        .collect();
    layers.push(features.clone());
    let head = bytes.layer(classes, channels);
    let logits: Vec<i64> = (0..classes)
        .map(|o| {
            let row = &head.weights[o * channels..(o + 1) * channels];
            head.output(o, features.iter().zip(row).map(|(x, w)| (x - head.in_zp) * w).sum())
        })
        .collect();
    let top = logits.iter().copied().max().unwrap_or(0);
    let sum: f64 = logits.iter().map(|&q| libm::exp((q - top) as f64 * head.scale)).sum();
    ReferenceOutput { layers, logits, confidence: 1.0 / sum }
}

#[cfg(test)]
mod tests {
    use super::requantize;

    #[test]
    fn double_rounding_by_hand() {
        // 5 * 2^30 / 2^31 = 2.5 -> 3; then / 2 = 1.5 -> 2 (single rounding of 1.25 would give 1)
        assert_eq!(requantize(5, 1 << 30, -1), 2);
        // -5: the nudge takes -2.5 to -2; / 2 = -1
        assert_eq!(requantize(-5, 1 << 30, -1), -1);
        assert_eq!(requantize(3, 1 << 30, 2), 6);
    }
}
