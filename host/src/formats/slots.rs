//! Raw slots: what a converter delivered, sweep after sweep.

use sdp3_core::config::RadarConfig;
use sdp3_core::dims::Beat;
use sdp3_core::signal::fast_time::FastTime;

/// Slots of equal length, one after the other: I and Q in turn of a complex converter, plain values of a real one.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Slots {
    /// All values, slot after slot.
    pub values: Vec<i16>,
    /// Values of a slot, above 0.
    pub per_slot: usize,
}

impl Slots {
    /// No slots yet, room for `count`.
    pub fn with_capacity(per_slot: usize, count: usize) -> Self {
        Self::in_memory(Vec::new(), per_slot, count)
    }

    /// The same in memory that was that of other slots.
    pub fn in_memory(mut values: Vec<i16>, per_slot: usize, count: usize) -> Self {
        values.clear();
        values.reserve_exact(per_slot * count);
        Slots { values, per_slot: per_slot.max(1) }
    }

    /// Every slot in order.
    pub fn iter(&self) -> std::slice::ChunksExact<'_, i16> {
        self.values.chunks_exact(self.per_slot)
    }

    /// How many there are.
    pub fn len(&self) -> usize {
        self.values.len() / self.per_slot
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The first `count` of them, or all.
    pub fn first(&self, count: usize) -> &[i16] {
        &self.values[..self.values.len().min(count * self.per_slot)]
    }

    /// What the radar module makes of every slot; `None` if the slots are not of this configuration.
    pub fn beats(&self, config: RadarConfig) -> Option<Vec<Beat>> {
        let mut reference = vec![[0; 2]; config.reference_len()];
        let fast_time = FastTime::new(config, &mut reference)?;
        self.iter().map(|slot| fast_time.beat(slot)).collect()
    }

    /// The values as bytes, little-endian.
    pub fn to_le_bytes(&self) -> Vec<u8> {
        to_le_bytes(&self.values)
    }
}

/// Values as bytes, little-endian.
pub fn to_le_bytes(values: &[i16]) -> Vec<u8> {
    values.iter().map(|value| value.to_le_bytes()).collect::<Vec<_>>().into_flattened()
}

impl<'a> IntoIterator for &'a Slots {
    type Item = &'a [i16];
    type IntoIter = std::slice::ChunksExact<'a, i16>;

    fn into_iter(self) -> Self::IntoIter {
        self.iter()
    }
}

impl std::ops::Index<usize> for Slots {
    type Output = [i16];

    fn index(&self, slot: usize) -> &[i16] {
        &self.values[slot * self.per_slot..][..self.per_slot]
    }
}
