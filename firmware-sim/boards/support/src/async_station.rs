//! The station on an asynchronous executor: memory, settings, self tests, the loop of the task. The program of `docs/porting.md`.
#![allow(unsafe_code)] // the section

use crate::line::{Serial, print};
use crate::linked::data;
use crate::recording::Recording;
use crate::station::{BITS, Station};
use core::fmt::Arguments;
use sdp3_core::radar::{ProcessingContext, SlotContext};
use sdp3_core::{Error, Progress, RadarModule, Retained, SensingLayout, Settings, Shape, radar_memory};
use static_cell::ConstStaticCell;

/// The model file: of `SDP3_MODEL`, else one of the paper's radar.
#[cfg(sdp3_model)]
pub static MODEL: &[u8] = include_bytes!(concat!(env!("OUT_DIR"), "/model.sdp3"));
#[cfg(not(sdp3_model))]
pub use sdp3_testkit::models::DSN_200 as MODEL;

/// What is written to the registers of the sensor: of `SDP3_BGT60_REGISTERS`.
#[cfg(feature = "bgt60")]
pub static REGISTERS: &[u32] = include!(concat!(env!("OUT_DIR"), "/registers.rs"));

const SHAPE: Shape = Shape::of(MODEL).expect("a model");
/// Values of a slot.
pub const VALUES: usize = SHAPE.slot_values();
/// The slot task's side.
pub type Slots = SlotContext<VALUES>;
/// The loop's side.
type Task = ProcessingContext<VALUES>;

#[cfg(feature = "bgt60")]
const _: () = assert!(
    u64::from_le_bytes(SHAPE.radar.to_bytes())
        == u64::from_le_bytes(sdp3_core::config::RadarConfig::BGT60.to_bytes())
        && VALUES == crate::bgt60::SAMPLES,
    "SDP3_MODEL is not a model of the scenario bgt60"
);

/// Slots of a period, data slots behind each sensing slot, sensing slots. The sensor senses in every slot until it has enough.
const LAYOUT: [u32; 3] =
    if cfg!(feature = "bgt60") { [8000, 0, SHAPE.sensing_slots as u32] } else { [4000, 3, 1000] };

static MEMORY: ConstStaticCell<radar_memory!(SHAPE)> = ConstStaticCell::new(<radar_memory!(SHAPE)>::new());
#[unsafe(link_section = ".uninit.retained")] // RAM that start-up leaves as it is
static RETAINED: Retained = Retained::new();

/// Its self tests and counts.
pub static STATION: Station = Station::new(data);

/// The recording in flash that is played where there is no sensor.
pub const fn recording() -> Recording {
    Recording::new(data, SHAPE.sensing_slots)
}

fn make() -> Result<(Slots, Task), Error> {
    let [period, spacing, slots] = LAYOUT;
    let settings =
        Settings { layout: SensingLayout::new(period, spacing, slots)?, rates: BITS, threshold: 2.0 };
    Ok(RadarModule::single(MODEL, settings, MEMORY.take(), &RETAINED)?.split())
}

/// Tests the signal chain and the network, gives the slots to their task, and processes what they bring.
///
/// `sleep` waits for an interrupt. Returns if a test failed or the model does not fit, having said so.
pub fn run(serial: &mut impl Serial, start: impl FnOnce(Slots), sleep: impl Fn()) {
    let mut say = |line: Arguments<'_>| print(serial, line);
    if !STATION.test_signal_chain(&mut say) {
        return;
    }
    let (slots, mut task) = match make() {
        Ok(both) => both,
        Err(error) => return say(format_args!("error: {error}")),
    };
    if !STATION.test_networks(&mut task, &mut say) {
        return;
    }
    start(slots);
    loop {
        match task.poll() {
            Progress::Event(event) => STATION.report(&task, &event, &mut say),
            Progress::Busy => {}
            Progress::Idle => {
                STATION.counts(&mut say);
                sleep();
            }
        }
    }
}
