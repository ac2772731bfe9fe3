//! The station with the default network and the paper's largest recording, N_s = 1000.
#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(not(target_os = "none"))]
fn main() {
    eprintln!("this is firmware: build it with firmware-sim/build");
}

#[cfg(target_os = "none")]
mod firmware {
    use sdp3_core::dsn::Model;
    use sdp3_core::pipeline::StandardMemory;
    use sdp3_firmware_sim::rt::Single;
    use sdp3_firmware_sim::semihosting::exit;
    use sdp3_firmware_sim::station::{run, slot_interrupt};

    static MODEL: &[u8] = sdp3_testkit::models::DSN_1000;
    static MEMORY: Single<StandardMemory> = Single::new(StandardMemory::new());

    // 48 KiB are left for the stack and everything else
    const _: () = assert!(StandardMemory::BYTES <= 144 * 1024);

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
