//! The station with the default network and the paper's largest recording, N_s = 1000: the program of `docs/porting.md`.
#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(not(target_os = "none"))]
fn main() {
    eprintln!("this is firmware: build it with firmware-sim/build");
}

#[cfg(target_os = "none")]
#[path = "../porting.rs"]
mod porting;
#[cfg(target_os = "none")]
use sdp3_firmware_sim::static_cell;

#[cfg(target_os = "none")]
mod board {
    pub use sdp3_firmware_sim::station::*;
    pub use sdp3_testkit::models::DSN_1000 as MODEL;

    #[allow(unsafe_code)] // the symbol that the timer's interrupt calls
    #[unsafe(no_mangle)]
    extern "C" fn firmware_tick() {
        slot_interrupt(crate::porting::slot);
    }

    #[allow(unsafe_code)] // the symbol that start-up calls
    #[unsafe(no_mangle)]
    extern "C" fn firmware_main() -> ! {
        power_on();
        run()
    }

    #[inline(never)] // its frame does not lie under the self test's
    fn run() -> ! {
        match crate::porting::run() {
            Ok(()) => fail("the idle loop ended"),
            Err(error) => fail(error),
        }
    }
}
