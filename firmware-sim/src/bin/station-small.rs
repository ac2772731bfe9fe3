//! The station with a short recording, N_s = 200, and eight channels, its memory sized by the model at compile time.
#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(not(target_os = "none"))]
fn main() {
    eprintln!("this is firmware: build it with firmware-sim/build");
}

#[cfg(target_os = "none")]
mod firmware {
    use sdp3_core::dsn::{Model, Shape};
    use sdp3_core::memory_for;
    use sdp3_firmware_sim::rt::Single;
    use sdp3_firmware_sim::semihosting::exit;
    use sdp3_firmware_sim::station::{run, slot_interrupt};

    static MODEL: &[u8] = sdp3_testkit::models::DSN_200;
    const SHAPE: Shape = match Shape::of(MODEL) {
        Some(shape) => shape,
        None => panic!("dsn-200.sdp3 is no model"),
    };
    type Small = memory_for!(SHAPE);
    static MEMORY: Single<Small> = Single::new(Small::new());

    // 40 KiB are left for the stack and everything else
    const _: () = assert!(Small::BYTES <= 24 * 1024 && Small::BYTES == SHAPE.required_bytes());

    #[allow(unsafe_code)] // the symbol that the timer's interrupt calls
    #[unsafe(no_mangle)]
    extern "C" fn firmware_tick() {
        slot_interrupt();
    }

    #[allow(unsafe_code)] // the symbol that start-up calls
    #[unsafe(no_mangle)]
    extern "C" fn firmware_main() -> ! {
        match (Model::parse(MODEL), MEMORY.take()) {
            (Ok(model), Some(memory)) => run(model, memory.view()),
            _ => exit(2),
        }
    }
}
