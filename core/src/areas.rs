//! Parts of a module's memory that no checksum covers: for a debugger, and for tests that change them.

use core::ops::Range;

/// Data of a module in which any bits are a value. Where a variant is a sequence, the whole of it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Area {
    /// Period, number and rest of the oldest slot in its queue: 0, 1, 2.
    WaitingSlot(u8),
    /// Range samples of the recording.
    Beats,
    /// Their running Gram matrix.
    Gram,
    /// Slow time, or the first range samples of the next recording; while an image is in the making.
    SlowTime,
    /// Log magnitudes and the image they become; likewise.
    LogMagnitudes,
    /// The image, then the network's activations; while no image is in the making.
    Activations,
    /// Weights of the convolution that is packed, and its tiles.
    PackedWeights,
    /// Constants and tables of the operator that runs.
    OperatorWords,
    /// Weights of an early exit.
    Weights(u8),
    /// The confidence that ends a period's sensing.
    Threshold,
    /// Logits of the first exit that the recording has passed.
    Logits,
}

/// Where these values lie.
pub(crate) fn range<T>(values: &[T]) -> Range<*const u8> {
    let Range { start, end } = values.as_ptr_range();
    start.cast()..end.cast()
}
