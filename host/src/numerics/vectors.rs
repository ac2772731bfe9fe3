//! Loops in the widest vector instructions that the processor has, with the same bits on every one: no multiply-add is fused.

use pulp::{Arch, NullaryFnOnce};

struct Work<F>(F);

impl<R, F: FnMut() -> R> NullaryFnOnce for Work<F> {
    type Output = R;

    #[inline(always)]
    fn call(mut self) -> R {
        (self.0)()
    }
}

/// Calls `work`, compiled for the processor at hand: an `#[inline(always)]` closure, as everything that it calls must be.
///
/// It is called as an [`FnMut`]: where a closure is called as an [`FnOnce`] the compiler puts a function in between, which is not inlined.
#[inline(always)]
pub fn vectorised<R>(work: impl FnMut() -> R) -> R {
    Arch::new().dispatch(Work(work))
}
