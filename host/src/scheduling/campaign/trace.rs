//! A trace for Perfetto: Chrome's trace event format, JSON.
//!
//! Slots of the first periods as slices on one track per use, boundaries and lost slots as instants, throughput per period as
//! counters. Times in microseconds of simulated time. Of longer campaigns the first [`PERIODS`] periods are kept: what a viewer opens.
//! Every event goes to the file as it happens.

use crate::scenario::Frame;
use sdp3_core::scheduler::{PeriodReport, Plan, SlotUse, USERS};
use std::fmt::Arguments;
use std::io::{Result, Write};

/// A trace being written.
#[derive(Debug)]
pub struct Trace<W: Write> {
    file: W,
    /// What the file said first; nothing is written after it.
    written: Result<()>,
    slot_us: f64,
    period_slots: u32,
    /// Track, first slot and number of slots of the slice not yet written.
    open: Option<(u32, u64, u64)>,
}

/// Most periods in a trace.
pub const PERIODS: u32 = 10_000;
/// Most slots in a trace: of 60 to 90 bytes each, as much as a viewer opens.
pub const SLOTS: u32 = 10_000_000;

/// Track of sensing slots; users' follow, then idle slots'.
const SENSING: u32 = 1;

impl<W: Write> Trace<W> {
    pub fn new(file: W, frame: &Frame) -> Self {
        let mut trace = Trace {
            file,
            written: Ok(()),
            slot_us: frame.slot_s * 1e6,
            period_slots: frame.period_slots,
            open: None,
        };
        let name = |track: u32| match track {
            0 => "plan".to_owned(),
            SENSING => "sensing".to_owned(),
            k if k as usize <= USERS + 1 => format!("user {}", k - SENSING),
            _ => "idle".to_owned(),
        };
        trace.write(format_args!("{{\"displayTimeUnit\":\"ms\",\"traceEvents\":[\n"));
        trace.write(format_args!("{{\"name\":\"process_name\",\"ph\":\"M\",\"pid\":1,\"tid\":0,\"args\":{{\"name\":\"base station\"}}}}"));
        for track in 0..=USERS as u32 + 2 {
            trace.write(format_args!(
                ",\n{{\"name\":\"thread_name\",\"ph\":\"M\",\"pid\":1,\"tid\":{track},\"args\":{{\"name\":\"{}\"}}}}",
                name(track)
            ));
        }
        trace
    }

    fn time(&self, period: u32, position: u32) -> u64 {
        u64::from(period) * u64::from(self.period_slots) + u64::from(position) - 1
    }

    /// A slot, from 1 within its period.
    pub fn slot(&mut self, period: u32, position: u32, slot: SlotUse, lost: bool) {
        let at = self.time(period, position);
        let track = match slot {
            SlotUse::Sensing => SENSING,
            SlotUse::Communication(k) => SENSING + 1 + u32::from(k),
            SlotUse::Idle => USERS as u32 + 2,
        };
        match &mut self.open {
            Some((open, first, slots)) if *open == track && *first + *slots == at => *slots += 1,
            _ => {
                self.close();
                self.open = Some((track, at, 1));
            }
        }
        if lost {
            let ts = at as f64 * self.slot_us;
            self.write(format_args!(
                ",\n{{\"name\":\"lost\",\"ph\":\"i\",\"s\":\"t\",\"pid\":1,\"tid\":{track},\"ts\":{ts}}}"
            ));
        }
    }

    fn close(&mut self) {
        let Some((track, first, slots)) = self.open.take() else { return };
        let (ts, dur) = (first as f64 * self.slot_us, slots as f64 * self.slot_us);
        let name = if track == SENSING { "sense" } else { "send" };
        let name = if track as usize == USERS + 2 { "idle" } else { name };
        self.write(format_args!(
            ",\n{{\"name\":\"{name}\",\"ph\":\"X\",\"pid\":1,\"tid\":{track},\"ts\":{ts},\"dur\":{dur}}}"
        ));
    }

    pub fn boundary(&mut self, period: u32, boundary: PeriodReport, plan: &Plan) {
        if !boundary.replanned || period >= PERIODS {
            return;
        }
        self.close();
        let ts = self.time(period, 1) as f64 * self.slot_us;
        let c = boundary.changes;
        self.write(format_args!(
                ",\n{{\"name\":\"plan\",\"ph\":\"i\",\"s\":\"p\",\"pid\":1,\"tid\":0,\"ts\":{ts},\"args\":{{\"sensing\":{},\"shares\":{:?},\
             \"joined\":{},\"left\":{},\"rates\":{},\"lost\":{},\"lost_sensing\":{},\"released\":{}}}}}",
            plan.sensing(),
            plan.shares(),
            c.joined.count_ones(),
            c.left.count_ones(),
            c.rates.count_ones(),
            c.lost,
            c.sensing_lost,
            c.released
            ));
    }

    /// A period ends, having delivered so many bits to each user.
    pub fn period(&mut self, period: u32, delivered_bit: &[f64; USERS]) {
        if period >= PERIODS {
            return;
        }
        self.close();
        let ts = self.time(period, 1) as f64 * self.slot_us;
        let values: Vec<String> = delivered_bit
            .iter()
            .enumerate()
            .map(|(k, bit)| format!("\"{}\":{}", k + 1, bit.round()))
            .collect();
        self.write(format_args!(
            ",\n{{\"name\":\"bits delivered\",\"ph\":\"C\",\"pid\":1,\"tid\":0,\"ts\":{ts},\"args\":{{{}}}}}",
            values.join(",")
        ));
    }

    /// The end of the file.
    ///
    /// # Errors
    ///
    /// What the file said first.
    pub fn finish(mut self) -> Result<()> {
        self.close();
        self.write(format_args!("\n]}}\n"));
        self.written
    }

    fn write(&mut self, event: Arguments) {
        if self.written.is_ok() {
            self.written = self.file.write_fmt(event);
        }
    }
}
