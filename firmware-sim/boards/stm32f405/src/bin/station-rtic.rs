//! The station as an RTIC application: the slot interrupt is a hardware task, the processing is its idle task.
#![no_std]
#![no_main]

mod retained {
    #![allow(unsafe_code)] // the section
    use sdp3_core::Retained;

    #[unsafe(link_section = ".uninit.retained")] // RAM that start-up does not write
    pub static RETAINED: Retained = Retained::new();
}

#[rtic::app(device = stm32f4xx_hal::pac)]
mod app {
    use crate::retained::RETAINED;
    use sdp3_board_support::interrupt_station::SlotTimer;
    use sdp3_board_support::line::print;
    use sdp3_board_support::linked::data;
    use sdp3_board_support::station::{BITS, Station};
    use sdp3_core::radar::{ProcessingContext, SlotContext};
    use sdp3_core::{Progress, RadarModule, SensingLayout, Settings, Shape, SlotAction, radar_memory};
    use sdp3_stm32f405::{Board, SysTick as Timer, Uart, set_up};
    use sdp3_testkit::models::DSN_200 as MODEL;

    const SHAPE: Shape = Shape::of(MODEL).expect("a model");
    const VALUES: usize = SHAPE.slot_values();
    type Memory = radar_memory!(SHAPE);
    type Contexts = (SlotContext<VALUES>, ProcessingContext<VALUES>);

    static STATION: Station = Station::new(data);

    #[shared]
    struct Shared {}

    #[local]
    struct Local {
        slots: SlotContext<VALUES>,
        task: ProcessingContext<VALUES>,
        uart: Uart,
        timer: Timer,
    }

    #[init(local = [memory: Memory = Memory::new()])]
    fn init(context: init::Context) -> (Shared, Local) {
        let Some(Board { mut uart, mut timer, .. }) = set_up(context.device, context.core) else { stop() };
        let Some((slots, task)) = contexts(context.local.memory, &mut uart) else { stop() };
        timer.start();
        (Shared {}, Local { slots, task, uart, timer })
    }

    /// The module's two contexts, tested; says what went wrong.
    fn contexts(memory: &'static mut Memory, uart: &mut Uart) -> Option<Contexts> {
        if !STATION.test_signal_chain(|line| print(uart, line)) {
            return None;
        }
        let made = SensingLayout::new(4000, 3, 1000).map_err(Into::into).and_then(|layout| {
            let settings = Settings { layout, rates: BITS, threshold: 2.0 };
            RadarModule::single(MODEL, settings, memory, &RETAINED)
        });
        match made.map(RadarModule::split) {
            Ok((slots, mut task)) => {
                STATION.test_networks(&mut task, |line| print(uart, line)).then_some((slots, task))
            }
            Err(error) => {
                print(uart, format_args!("error: {error}"));
                None
            }
        }
    }

    fn stop() -> ! {
        loop {
            cortex_m::asm::wfi();
        }
    }

    #[task(binds = SysTick, local = [slots, timer])]
    fn slot(context: slot::Context) {
        let slots = context.local.slots;
        match slots.begin(STATION.run.begin()) {
            SlotAction::Sense(buffer) => STATION.start_transfer(&mut buffer.0),
            // the radio, which is not part of this program
            SlotAction::Serve(_) | SlotAction::Idle => {}
        }
        if STATION.run.transferred() {
            slots.samples_ready();
        }
        if context.local.timer.late() {
            STATION.run.late();
        }
    }

    #[idle(local = [task, uart])]
    fn idle(context: idle::Context) -> ! {
        let idle::LocalResources { task, uart, .. } = context.local;
        loop {
            match task.poll() {
                Progress::Event(event) => STATION.report(task, &event, |line| print(uart, line)),
                Progress::Busy => {}
                Progress::Idle => {
                    STATION.counts(|line| print(uart, line));
                    cortex_m::asm::wfi();
                }
            }
        }
    }
}
