//! How a run ends that should not: a panic by exit code 101, an exception of the processor by 102.

use crate::semihosting::{exit, print, println};

/// Where the start-up code of every family sends an exception.
#[allow(unsafe_code)]
#[unsafe(no_mangle)]
extern "C" fn firmware_fault() -> ! {
    print("fault: the processor raised an exception\n");
    exit(102)
}

#[panic_handler]
fn panic(info: &core::panic::PanicInfo) -> ! {
    println(format_args!("{info}"));
    exit(101)
}
