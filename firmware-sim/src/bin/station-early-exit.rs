//! The station with two early exits, at 200 and at 1000 sensing slots. The threshold lets both networks run.
#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(not(target_os = "none"))]
fn main() {
    eprintln!("this is firmware: build it with firmware-sim/build");
}

#[cfg(target_os = "none")]
mod firmware {
    use sdp3_core::dsn::Model;
    use sdp3_core::early_exit::EarlyExit;
    use sdp3_core::{Error, RadarModule, Retained, Shape, radar_memory};
    use sdp3_firmware_sim::static_cell::ConstStaticCell;
    use sdp3_firmware_sim::station::{Module, power_on, serve, settings, slot, slot_interrupt};
    use sdp3_testkit::models::{DSN_200, DSN_1000};

    /// The largest model's.
    const SHAPE: Shape = Shape::of(DSN_1000).expect("a model");
    static MEMORY: ConstStaticCell<radar_memory!(SHAPE)> =
        ConstStaticCell::new(<radar_memory!(SHAPE)>::new());
    #[allow(unsafe_code)] // a section that start-up leaves alone; the module checks what it finds
    #[unsafe(link_section = ".uninit.retained")]
    static RETAINED: Retained = Retained::new();

    fn module() -> Result<Module, Error> {
        let first = EarlyExit::single(Model::parse(DSN_200)?);
        let mut last = EarlyExit::single(Model::parse(DSN_1000)?);
        last.weights.swap(0, 1); // its own logits alone
        RadarModule::new(&[first, last], settings()?, MEMORY.take(), &RETAINED)
    }

    #[inline(never)] // its frame does not lie under the self test's
    fn run() -> ! {
        serve(module())
    }

    #[allow(unsafe_code)] // the symbol that the timer's interrupt calls
    #[unsafe(no_mangle)]
    extern "C" fn firmware_tick() {
        slot_interrupt(slot);
    }

    #[allow(unsafe_code)] // the symbol that start-up calls
    #[unsafe(no_mangle)]
    extern "C" fn firmware_main() -> ! {
        power_on();
        run()
    }
}
