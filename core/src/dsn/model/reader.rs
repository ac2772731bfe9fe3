//! Reads a model's fields and layers one after the other and holds each to its legal range.

use super::ModelError;
use crate::dsn::add::Add;
use crate::dsn::per_channel::{PerChannelQuant, read_i32};

/// Reads fields one after the other; running out is an error, never a panic.
pub(super) struct Reader<'m> {
    pub(super) bytes: &'m [u8],
    pub(super) total: usize,
}

impl<'m> Reader<'m> {
    pub(super) fn take(&mut self, length: usize) -> Result<&'m [u8], ModelError> {
        let at = self.total - self.bytes.len();
        let have = self.total;
        let (head, tail) =
            self.bytes.split_at_checked(length).ok_or(ModelError::Layers { need: at + length, have })?;
        self.bytes = tail;
        Ok(head)
    }

    pub(super) fn array<const N: usize>(&mut self) -> Result<[u8; N], ModelError> {
        let have = self.total;
        self.take(N)?.first_chunk::<N>().copied().ok_or(ModelError::Layers { need: N, have })
    }

    pub(super) fn u8(&mut self) -> Result<u8, ModelError> {
        Ok(u8::from_le_bytes(self.array()?))
    }

    pub(super) fn i8(&mut self) -> Result<i8, ModelError> {
        Ok(i8::from_le_bytes(self.array()?))
    }

    pub(super) fn u16(&mut self) -> Result<u16, ModelError> {
        Ok(u16::from_le_bytes(self.array()?))
    }

    pub(super) fn u32(&mut self) -> Result<u32, ModelError> {
        Ok(u32::from_le_bytes(self.array()?))
    }

    fn i32(&mut self) -> Result<i32, ModelError> {
        Ok(i32::from_le_bytes(self.array()?))
    }

    pub(super) fn scale(&mut self, name: &'static str) -> Result<f32, ModelError> {
        let scale = f32::from_le_bytes(self.array()?);
        if scale.is_finite() && scale > 0.0 {
            Ok(scale)
        } else {
            Err(ModelError::Field { name, value: i64::from(scale.to_bits()) })
        }
    }

    /// Zero points and activation range that begin every layer: `[in, out, min, max, in2]`.
    pub(super) fn layer(&mut self, kind: u8) -> Result<[i8; 5], ModelError> {
        let found = self.u8()?;
        check("layer.kind", i64::from(found), found == kind)?;
        let values = [self.i8()?, self.i8()?, self.i8()?, self.i8()?, self.i8()?];
        let [_, _, low, high, _] = values;
        check("layer.act_min", i64::from(low), low <= high)?;
        let reserved = self.u16()?;
        check("layer.reserved", i64::from(reserved), reserved == 0)?;
        Ok(values)
    }

    /// The body of a layer with per-channel quantisation and `taps` weights per channel; also its output scale.
    pub(super) fn channelwise(
        &mut self,
        kind: u8,
        channels: usize,
        taps: usize,
    ) -> Result<(PerChannelQuant<'m>, f32), ModelError> {
        let [in_zp, out_zp, act_min, act_max, _] = self.layer(kind)?;
        self.scale("layer.in_scale")?;
        let scale = self.scale("layer.out_scale")?;
        let multipliers = self.take(4 * channels)?;
        let biases = self.take(4 * channels)?;
        let shifts = self.take(channels.next_multiple_of(4))?;
        let weights = self.take((channels * taps).next_multiple_of(4))?;
        let weights = weights.get(..channels * taps).unwrap_or(weights);
        for o in 0..channels {
            multiplier("layer.multiplier", read_i32(multipliers, o))?;
        }
        for &s in shifts {
            shift("layer.shift", s as i8)?;
        }
        let layer = PerChannelQuant {
            in_zp,
            out_zp,
            act_min,
            act_max,
            channels,
            multipliers,
            biases,
            shifts,
            weights,
        };
        Ok((layer, scale))
    }

    /// The addition that closes a block.
    pub(super) fn add(&mut self) -> Result<Add, ModelError> {
        let [in_zp, out_zp, act_min, act_max, in2_zp] = self.layer(3)?;
        self.scale("add.in1_scale")?;
        self.scale("add.in2_scale")?;
        self.scale("add.out_scale")?;
        let add = Add {
            in_zp: [in_zp, in2_zp],
            out_zp,
            act_min,
            act_max,
            multiplier: [self.i32()?, self.i32()?],
            out_multiplier: self.i32()?,
            shift: [self.i8()?, self.i8()?],
            out_shift: self.i8()?,
        };
        let reserved = self.u8()?;
        check("add.reserved", i64::from(reserved), reserved == 0)?;
        for value in add.multiplier.into_iter().chain([add.out_multiplier]) {
            multiplier("add.multiplier", value)?;
        }
        for value in add.shift.into_iter().chain([add.out_shift]) {
            shift("add.shift", value)?;
        }
        Ok(add)
    }
}

pub(super) fn check(name: &'static str, value: i64, legal: bool) -> Result<(), ModelError> {
    if legal { Ok(()) } else { Err(ModelError::Field { name, value }) }
}

fn multiplier(name: &'static str, value: i32) -> Result<(), ModelError> {
    check(name, i64::from(value), value == 0 || value >= 1 << 30)
}

fn shift(name: &'static str, value: i8) -> Result<(), ModelError> {
    check(name, i64::from(value), (-31..=7).contains(&value))
}
