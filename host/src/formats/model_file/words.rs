//! A network in words: sensor, spectrogram, layers, sizes.

use super::{Preprocessing, QuantizedNetwork, ROWS};
use sdp3_core::config::{Dechirp, RadarConfig, SampleFormat};
use std::fmt::Write as _;

impl Preprocessing {
    /// Sensor and spectrogram in words, a line each.
    pub(super) fn describe(&self) -> String {
        let (p, mut text) = (self, String::new());
        let _ = writeln!(
            text,
            "takes {} sensing slots of {} {} us apart at {} GHz",
            p.sensing_slots,
            sweep_words(&p.radar),
            p.slow_time_us,
            f64::from(p.carrier_khz) / 1e6
        );
        let _ = writeln!(
            text,
            "keeps singular components {} to {}, window {} (Kaiser, beta {}), hop {}, image {} x {}, {} bin(s) a \
             row, {:.1} dB",
            if p.first_kept == 0 { "that are not static".to_owned() } else { p.first_kept.to_string() },
            p.last_kept,
            p.window_len,
            p.kaiser_beta,
            p.hop,
            ROWS,
            p.frames(),
            p.bins_per_row,
            f64::from(p.range) / 64.0 * 10.0 * std::f64::consts::LOG10_2
        );
        text
    }
}

impl QuantizedNetwork {
    /// The network in words: preprocessing, layers, sizes.
    pub fn describe(&self) -> String {
        let mut text = String::new();
        let _ = writeln!(
            text,
            "deep spectrogram network, int8, {} parameters, {} classes: {}",
            self.parameters(),
            self.classes.len(),
            self.classes.join(", ")
        );
        text.push_str(&self.preprocessing.describe());
        let c = self.channels();
        let _ = writeln!(
            text,
            "stem: convolution 3x3, 1 -> {c}, stride {}, max pool 2x2; {} residual blocks of two convolutions 3x3, \
             {c} -> {c}; mean over the image; {c} -> {} logits",
            self.stem_stride,
            self.blocks.len(),
            self.classes.len()
        );
        for (name, _, _, layer) in self.weighted() {
            let _ = writeln!(
                text,
                "  {name}: {} weights, output step {:.6}, zero at {}",
                layer.weights.len(),
                layer.out_scale,
                layer.out_zero
            );
        }
        text
    }
}

/// A slot's samples and what becomes of them, in words.
pub(super) fn sweep_words(radar: &RadarConfig) -> String {
    let format = match radar.format {
        SampleFormat::Complex => "complex",
        SampleFormat::Real => "real",
    };
    let dechirp = match (radar.dechirp, radar.gate) {
        (Dechirp::Digital, _) => format!("dechirped into {} blocks", radar.range_samples),
        (Dechirp::Analog, None) => format!("of a beat summed in {} blocks", radar.range_samples),
        (Dechirp::Analog, Some(gate)) => format!(
            "of a beat gated to {} x {} range bins from bin {} on",
            radar.range_samples, gate.bins_per_sample, gate.first_bin
        ),
    };
    let justified = if radar.left_justified { ", left-justified," } else { "" };
    format!("{} {format} samples of {} bits{justified} {dechirp}", radar.samples, radar.converter_bits)
}
