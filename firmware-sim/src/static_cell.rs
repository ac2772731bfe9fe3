//! The interface of the crate `static_cell`, which needs an atomic exchange and has a panic path.

use crate::rt::Single;
use crate::semihosting::exit;

/// A value that the compiler makes in a static, and that is taken once.
pub struct ConstStaticCell<T>(Single<T>);

impl<T> ConstStaticCell<T> {
    /// A static value.
    pub const fn new(value: T) -> Self {
        ConstStaticCell(Single::new(value))
    }

    /// The value; a second call ends the run.
    pub fn take(&'static self) -> &'static mut T {
        match self.0.take() {
            Some(value) => value,
            None => exit(2),
        }
    }
}
