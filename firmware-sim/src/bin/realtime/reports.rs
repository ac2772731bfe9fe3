//! Every report of a fault must be of one that was injected, and every injected fault must be reported in time.

use super::injection::{Expected, Report};
use super::shared::INTERRUPTS;
use core::sync::atomic::Ordering::Relaxed;
use heapless::Vec;
use sdp3_core::digest::Digest;
use sdp3_core::radar::Event;
use sdp3_core::supervision::Fault;
use sdp3_firmware_sim::semihosting::println;

/// What was injected and is not yet reported, and what was reported.
pub struct Reports {
    pub open: Vec<Expected, 32>,
    /// Lost slots that the end of the period must report.
    pub losses: u32,
    pub reported: u32,
    pub wrong: u32,
    pub missed: u32,
    /// Sensing slots lost that nobody injected.
    pub lost: u32,
    pub periods: u32,
    pub replanned: u32,
    pub classified: [u32; 2],
    pub stopped: u32,
    pub results: Digest,
}

impl Reports {
    /// Removes the expected report that fits.
    fn take(&mut self, fits: impl Fn(Report) -> bool) -> bool {
        let at = self.open.iter().position(|entry| fits(entry.report));
        at.map(|at| self.open.remove(at)).is_some()
    }

    pub fn check(&mut self, event: &Event) {
        match event {
            Event::Fault(fault) => {
                if self.take(|report| report.fits(fault)) {
                    self.reported += 1;
                } else {
                    self.wrong += 1;
                    self.lost += u32::from(matches!(fault, Fault::Overrun | Fault::MissingSamples));
                    let now = INTERRUPTS.load(Relaxed);
                    println(format_args!("not injected: {fault:?} in slot {now}"));
                }
                match fault {
                    Fault::SlotsSkipped { slots, .. } => self.losses += slots,
                    Fault::MissingSamples | Fault::Overrun => self.losses += 1,
                    Fault::StateLost => {
                        self.losses = 0;
                        while self.take(|report| report == Report::Lost) {}
                    }
                    _ => (),
                }
            }
            Event::Period(report) => {
                self.periods += 1;
                self.replanned += u32::from(report.replanned);
                let mut losses = core::mem::take(&mut self.losses);
                while self.take(|report| report == Report::Lost) {
                    losses += 1;
                    self.reported += 1;
                }
                let found = report.changes.lost + report.changes.sensing_lost;
                if found != losses {
                    self.wrong += 1;
                    let now = INTERRUPTS.load(Relaxed);
                    println(format_args!("{losses} slots lost, {found} reported, in slot {now}"));
                }
            }
            Event::Classification { period, classification } => {
                let exit = usize::from(classification.exit);
                if let Some(count) = self.classified.get_mut(exit) {
                    *count += 1;
                }
                self.stopped += u32::from(classification.stop && exit == 0);
                self.results.value(period.to_le_bytes());
                self.results.value([classification.class, classification.exit]);
                classification.logits.iter().for_each(|logit| self.results.value(logit.to_le_bytes()));
            }
        }
    }

    /// Entries that have waited too long are of faults that were not reported.
    pub fn age(&mut self, waited: u32) {
        let now = INTERRUPTS.load(Relaxed);
        // a loss is reported at the end of the period
        let old = |entry: &Expected| entry.report != Report::Lost && now - entry.since >= waited;
        while let Some(at) = self.open.iter().position(old) {
            let entry = self.open.remove(at);
            self.missed += 1;
            println(format_args!("not reported: {:?} of slot {}", entry.report, entry.since));
        }
    }
}
