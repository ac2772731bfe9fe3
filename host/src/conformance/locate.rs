//! Where two processors part: the first value of a stage that differs, by slot and index.
//!
//! Digests say that a stage differs; here both sides give all its values.

use super::compare::{CaseError, run_core};
use super::suite::Case;
use sdp3_core::dims::{BEATS, FFT_LEN};
use sdp3_core::values::{Sink, Stage, Values};

/// Keeps one stage's values.
struct Dump {
    stage: Stage,
    bytes: Vec<u8>,
}

impl Sink for Dump {
    fn value<const N: usize>(&mut self, stage: Stage, bytes: [u8; N]) {
        if stage == self.stage {
            self.bytes.extend(bytes);
        }
    }
}

/// All values of a stage on this machine.
///
/// # Errors
///
/// [`CaseError`] if the case cannot be run.
pub fn values(case: &Case, stage: Stage) -> Result<Vec<u8>, CaseError> {
    let mut probe = Values(Dump { stage, bytes: Vec::new() });
    run_core(case, &mut probe)?;
    Ok(probe.0.bytes)
}

/// Number of the first value that differs, where it stands, and both values.
pub fn first_difference(stage: Stage, expected: &[u8], found: &[u8]) -> Option<String> {
    let width = stage.width();
    let (ours, theirs) = (expected.chunks(width), found.chunks(width));
    let at = ours.clone().zip(theirs.clone()).position(|(a, b)| a != b);
    let at = at.or_else(|| (ours.len() != theirs.len()).then(|| ours.len().min(theirs.len())))?;
    let value =
        |bytes: &[u8]| bytes.chunks(width).nth(at).map_or("nothing".into(), |bytes| number(stage, bytes));
    Some(format!("{}: expected {}, found {}", place(stage, at), value(expected), value(found)))
}

/// Slot or frame and index of value number `at`.
fn place(stage: Stage, at: usize) -> String {
    let part = if at.is_multiple_of(2) { "re" } else { "im" };
    match stage {
        Stage::Beat => format!("slot {}, index {} {part}", at / (2 * BEATS), at % (2 * BEATS) / 2),
        Stage::Frame => format!("frame {}, index {} {part}", at / (2 * FFT_LEN), at % (2 * FFT_LEN) / 2),
        Stage::SlowTime => format!("slot {}, {part}", at / 2),
        Stage::Gram | Stage::Projection => format!("index {} {part}", at / 2),
        Stage::Image | Stage::Layer | Stage::Logits | Stage::Class | Stage::Confidence => {
            format!("index {at}")
        }
    }
}

fn number(stage: Stage, bytes: &[u8]) -> String {
    match (stage, bytes) {
        (Stage::Frame | Stage::Confidence, &[a, b, c, d]) => {
            let value = f32::from_le_bytes([a, b, c, d]);
            format!("{value:e} ({:08x})", value.to_bits())
        }
        (_, &[a, b, c, d]) => i32::from_le_bytes([a, b, c, d]).to_string(),
        (_, &[a, b, c, d, e, f, g, h]) => i64::from_le_bytes([a, b, c, d, e, f, g, h]).to_string(),
        (_, &[a]) if stage == Stage::Class => a.to_string(),
        (_, &[a]) => (a as i8).to_string(),
        _ => format!("{bytes:02x?}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_difference_is_named_by_slot_and_index() {
        let beats: Vec<u8> = (0..64_i32).flat_map(i32::to_le_bytes).collect();
        let mut other = beats.clone();
        other[4 * 37] ^= 2;
        other[4 * 50] ^= 1;
        assert_eq!(first_difference(Stage::Beat, &beats, &beats), None);
        assert_eq!(
            first_difference(Stage::Beat, &beats, &other).as_deref(),
            Some("slot 2, index 2 im: expected 37, found 39")
        );
        assert_eq!(
            first_difference(Stage::Layer, &[5, 255], &[5]).as_deref(),
            Some("index 1: expected -1, found nothing")
        );
    }
}
