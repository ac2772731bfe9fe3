//! The radar module on a sensor, or on recorded slots; after 10 000 slots it prints what it has seen, and goes on.
#![no_std]
#![no_main]

use cortex_m_rt::entry;
use sdp3_board_support::async_station::{self, STATION, Slots};
use sdp3_board_support::slots::{self, SLOT_US, TimeDriver};
use sdp3_rp2350::{Board, Radar, board, executor};

#[embassy_executor::task]
async fn slot_task(slots: Slots, radar: Radar) {
    slots::run(slots, TimeDriver::<SLOT_US>::new(), radar, &STATION.run).await
}

#[entry]
fn main() -> ! {
    if let Some(Board { mut uart, radar }) = board() {
        let start = |slots| {
            if let Ok(task) = slot_task(slots, radar) {
                executor::start().spawn(task);
            }
        };
        async_station::run(&mut uart, start, cortex_m::asm::wfe);
    }
    loop {
        cortex_m::asm::wfe();
    }
}
