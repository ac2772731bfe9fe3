//! The radar module on a sensor, or on recorded slots; after 10 000 slots it prints what it has seen, and goes on.
#![no_std]
#![no_main]

use cortex_m_rt::entry;
use sdp3_board_support::async_station::{self, STATION, Slots};
use sdp3_board_support::slots;
use sdp3_nrf5340::{Board, Radar, SlotTimer, board, executor};

#[embassy_executor::task]
async fn slot_task(slots: Slots, timer: SlotTimer, radar: Radar) {
    slots::run(slots, timer, radar, &STATION.run).await
}

#[entry]
fn main() -> ! {
    if let Some(Board { mut uart, radar, slots: timer }) = board() {
        let start = |slots| {
            if let Ok(task) = slot_task(slots, timer, radar) {
                executor::start().spawn(task);
            }
        };
        async_station::run(&mut uart, start, cortex_m::asm::wfe);
    }
    loop {
        cortex_m::asm::wfe();
    }
}
