//! What the model file can say: every field held to its range before a byte is written.
//!
//! The ranges are the format's own; the radar module's parser refuses what this would.

use crate::error::Invalid;
use sdp3_core::dsn::ModelError;
use sdp3_core::signal::clutter::GRAM_SLOTS;
use std::fmt::Display;
use thiserror::Error;

use super::{KIND_HEAD, NAME_BYTES, QuantizedLayer, QuantizedNetwork};

/// Why a network could not be written.
#[derive(Debug, Error)]
pub enum ModelFileError {
    /// A field that may not be what it is.
    #[error(transparent)]
    Invalid(#[from] Invalid),
    /// The radar module refuses it.
    #[error(transparent)]
    Model(#[from] ModelError),
    /// The file system refused.
    #[error("model file {path}: {source}")]
    Io {
        /// The file.
        path: String,
        /// What the system said.
        source: std::io::Error,
    },
}

/// Holds class names to what the format has room for.
pub(super) fn names(classes: &[String]) -> Result<(), ModelFileError> {
    for (i, name) in classes.iter().enumerate() {
        let fits = (1..=NAME_BYTES).contains(&name.len()) && !name.contains('\0');
        legal(&format!("class name {i}"), format!("{name:?}"), fits, "1 to 24 bytes without a zero")?;
    }
    Ok(())
}

impl QuantizedNetwork {
    /// Holds every field to the format's range.
    pub(super) fn check(&self) -> Result<(), ModelFileError> {
        let p = &self.preprocessing;
        let c = self.channels();
        legal(
            "radar",
            format!("{:?}", p.radar),
            p.radar.is_valid(),
            "a configuration that the radar module takes",
        )?;
        within("first_kept", p.first_kept, 0, p.radar.range_samples)?;
        within("last_kept", p.last_kept, p.first_kept.max(1), 8)?;
        within("window_len", p.window_len, 2, 256)?;
        within("hop", p.hop, 1, p.window_len)?;
        legal("bins_per_row", p.bins_per_row, matches!(p.bins_per_row, 1 | 2 | 4), "1, 2 or 4")?;
        legal("stem_stride", self.stem_stride, matches!(self.stem_stride, 1 | 2), "1 or 2")?;
        within("range", p.range, 1, 4095)?;
        let beta = p.kaiser_beta;
        legal("kaiser_beta", beta, (0.0..=40.0).contains(&beta), "0 to 40")?;
        let pooled = p.frames().div_ceil(u16::from(self.stem_stride)) / 2;
        let room = "enough for two columns behind the stem";
        legal("sensing_slots", p.sensing_slots, pooled >= 1, room)?;
        within("sensing_slots", usize::from(p.sensing_slots), 2, GRAM_SLOTS)?;
        within("channels", c, 4, 32)?;
        legal("channels", c, c.is_multiple_of(4), "a multiple of 4")?;
        within("blocks", self.blocks.len(), 1, 8)?;
        within("classes", self.classes.len(), 2, 16)?;
        names(&self.classes)?;
        for (name, kind, inputs, layer) in self.weighted() {
            let outputs = if kind == KIND_HEAD { self.classes.len() } else { c };
            layer.check(&name, outputs, inputs)?;
        }
        for (b, block) in self.blocks.iter().enumerate() {
            let (add, name) = (&block.add, format!("block {b} add"));
            check_rescale(&name, &add.multipliers, &add.shifts)?;
            check_scales(&name, &[add.in1_scale, add.in2_scale, add.out_scale])?;
            within(&format!("{name} act_min"), add.act_min, i8::MIN, add.act_max)?;
        }
        Ok(())
    }
}

impl QuantizedLayer {
    fn check(&self, name: &str, outputs: usize, inputs: usize) -> Result<(), ModelFileError> {
        let lengths = [
            ("multipliers", self.multipliers.len(), outputs),
            ("biases", self.biases.len(), outputs),
            ("shifts", self.shifts.len(), outputs),
            ("weights", self.weights.len(), outputs * inputs),
        ];
        for (field, have, want) in lengths {
            legal(&format!("number of {name} {field}"), have, have == want, &want.to_string())?;
        }
        within(&format!("{name} act_min"), self.act_min, i8::MIN, self.act_max)?;
        check_scales(name, &[self.in_scale, self.out_scale])?;
        check_rescale(name, &self.multipliers, &self.shifts)
    }
}

fn legal(field: &str, value: impl Display, good: bool, legal: &str) -> Result<(), ModelFileError> {
    Ok(Invalid::unless(good, field, value, legal).map_err(|invalid| invalid.at("model"))?)
}

fn within<T: PartialOrd + Display>(field: &str, value: T, low: T, high: T) -> Result<(), ModelFileError> {
    let range = format!("{low} to {high}");
    legal(field, &value, low <= value && value <= high, &range)
}

fn check_scales(name: &str, scales: &[f32]) -> Result<(), ModelFileError> {
    for &scale in scales {
        legal(&format!("{name} scale"), scale, scale.is_finite() && scale > 0.0, "finite and above 0")?;
    }
    Ok(())
}

fn check_rescale(name: &str, multipliers: &[i32], shifts: &[i8]) -> Result<(), ModelFileError> {
    for &m in multipliers {
        legal(&format!("{name} multiplier"), m, m == 0 || m >= 1 << 30, "0 or 2^30 to 2^31-1")?;
    }
    for &s in shifts {
        within(&format!("{name} shift"), s, -31, 7)?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::super::tests::network;
    use super::*;
    use sdp3_core::config::RadarConfig;

    #[test]
    fn errors_name_field_value_and_range() {
        let corrupted = |change: fn(&mut QuantizedNetwork)| {
            let mut n = network();
            change(&mut n);
            n.to_bytes().unwrap_err().to_string()
        };
        assert_eq!(corrupted(|n| n.preprocessing.hop = 129), "model: hop is 129, must be 1 to 128");
        assert_eq!(corrupted(|n| n.stem_stride = 3), "model: stem_stride is 3, must be 1 or 2");
        assert_eq!(
            corrupted(|n| n.blocks[1].conv2.shifts[0] = 8),
            "model: block 1 conv2 shift is 8, must be -31 to 7"
        );
        assert_eq!(
            corrupted(|n| n.head.weights.truncate(11)),
            "model: number of head weights is 11, must be 12"
        );
        assert!(corrupted(|n| n.classes[0] = "x".repeat(25)).contains("class name 0"));
        assert!(corrupted(|n| n.blocks[0].add.multipliers[1] = 5).contains("multiplier is 5"));
        assert!(corrupted(|n| n.preprocessing.sensing_slots = 127).contains("sensing_slots is 127"));
        assert!(corrupted(|n| n.preprocessing.sensing_slots = 4001).contains("must be 2 to 4000"));
        let one = corrupted(|n| {
            (n.preprocessing.radar, n.preprocessing.first_kept) = (RadarConfig::DOPPLER, 2);
        });
        assert_eq!(one, "model: first_kept is 2, must be 0 to 1");
    }
}
