//! The station that takes signed models only: `sdp3_testkit::models::PUBLIC_KEY` is the key it was built with.
#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(not(target_os = "none"))]
fn main() {
    eprintln!("this is firmware: build it with firmware-sim/build");
}

#[cfg(target_os = "none")]
mod firmware {
    use sdp3_core::dsn::{Model, format::KEY_LEN};
    use sdp3_core::early_exit::EarlyExit;
    use sdp3_core::{Error, RadarModule, Retained, Shape, radar_memory};
    use sdp3_firmware_sim::static_cell::ConstStaticCell;
    use sdp3_firmware_sim::station::{Module, power_on, serve, settings, slot, slot_interrupt};

    static MODEL: &[u8] = sdp3_testkit::models::DSN_200_SIGNED;
    static KEY: &[u8; KEY_LEN] = sdp3_testkit::models::PUBLIC_KEY;
    /// Oldest revision that runs: a station in the field keeps it where no update can lower it.
    const OLDEST: u32 = 0;
    const SHAPE: Shape = Shape::of(MODEL).expect("a model");
    static MEMORY: ConstStaticCell<radar_memory!(SHAPE)> =
        ConstStaticCell::new(<radar_memory!(SHAPE)>::new());
    #[allow(unsafe_code)] // a section that start-up leaves alone; the module checks what it finds
    #[unsafe(link_section = ".uninit.retained")]
    static RETAINED: Retained = Retained::new();

    fn module() -> Result<Module, Error> {
        let exit = EarlyExit::single(Model::parse_signed(MODEL, KEY, OLDEST)?);
        RadarModule::new(&[exit], settings()?, MEMORY.take(), &RETAINED)
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
