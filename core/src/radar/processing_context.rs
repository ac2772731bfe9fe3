//! The task: takes sensing slots out of their queue, recognises, plans, and checks the models, one bounded step a call.

use super::memory::{Made, ProcessingEnds};
use super::{Filled, Report, Totals};
use crate::areas::{Area, range};
use crate::crc32::{Crc32, crc32};
use crate::dsn::{Classification, ModelError};
use crate::early_exit::EXITS;
use crate::error::Error;
use crate::scheduler::{Changes, PeriodCounts, PeriodReport, Planner, SensingLayout};
use crate::signal::stft::{NativeStft, Stft};
use crate::supervision::retained::Message;
use crate::supervision::{Fault, sample_health};
use core::ops::Range;
use core::sync::atomic::Ordering;
use heapless::Vec;
use rand_core::Rng;

/// Bytes of a model that one step checks.
pub(super) const CHECK_BYTES: usize = 1024;

/// What happened.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Event {
    /// A recording was classified.
    Classification {
        /// Number of the period that it belongs to.
        period: u32,
        /// The class and how sure it is.
        classification: Classification,
    },
    /// Something went wrong. Reported once.
    Fault(Fault),
    /// A period began.
    Period(PeriodReport),
}

/// What a call of [`ProcessingContext::poll`] did.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Progress {
    /// Nothing: there is nothing to do until the next interrupt.
    Idle,
    /// One step of something; there may be more.
    Busy,
    /// Something to report.
    Event(Event),
}

/// A model's check after a recognition.
#[derive(Debug)]
struct Check {
    period: u32,
    classification: Classification,
    crc: Crc32,
    done: usize,
}

/// The task's side of a radar module.
pub struct ProcessingContext<const VALUES: usize, T: Stft + 'static = NativeStft> {
    ends: ProcessingEnds<VALUES>,
    pipeline: &'static mut Made<T>,
    planner: Planner,
    /// Losses that no plan gives back yet.
    counts: PeriodCounts,
    plan_due: bool,
    /// Why the plan that is on its way differs from the running one.
    changes: Changes,
    period: u32,
    next_index: u32,
    /// Whether the period's further slots serve nothing.
    unused: bool,
    /// CRC-32 of each model as it was when it was accepted.
    checksums: Vec<u32, EXITS>,
    /// Of those, which had changed when they were checked last, one bit each.
    damaged: u16,
    check: Option<Check>,
}

impl<const VALUES: usize, T: Stft> ProcessingContext<VALUES, T> {
    pub(super) fn new(
        pipeline: &'static mut Made<T>,
        planner: Planner,
        ends: ProcessingEnds<VALUES>,
    ) -> Self {
        let mut checksums = Vec::new();
        for exit in pipeline.exits() {
            let _ = checksums.push(crc32(exit.model.bytes())); // as many places as exits
        }
        ProcessingContext {
            ends,
            pipeline,
            planner,
            counts: PeriodCounts::default(),
            plan_due: false,
            changes: Changes::default(),
            period: 0,
            next_index: 0,
            unused: false,
            checksums,
            damaged: 0,
            check: None,
        }
    }

    /// One bounded step of what is most urgent: reports, samples, plans, a model's check, a recognition.
    pub fn poll(&mut self) -> Progress {
        if let Some(report) = self.ends.reports.dequeue() {
            return self.take_report(report);
        }
        if let Some(progress) = self.take_slot() {
            return progress;
        }
        if (self.plan_due || self.planner.has_changes()) && self.ends.plans.ready() {
            self.plan();
            return Progress::Busy;
        }
        if self.check.is_some() {
            return self.check_model();
        }
        if !self.pipeline.is_busy() {
            return Progress::Idle;
        }
        let period = self.pipeline.recognition_period();
        if let Some(classification) = self.pipeline.step(&mut ()) {
            self.check = Some(Check { period, classification, crc: Crc32::new(), done: 0 });
        }
        Progress::Busy
    }

    /// The planner, to be looked at.
    pub fn planner(&self) -> &Planner {
        &self.planner
    }

    /// Bits a slot carries to a user, 0 if it is absent. Takes effect at the first period that begins after the plan was made.
    pub fn set_rate(&mut self, user: usize, rate: u32) {
        self.planner.set_rate(user, rate);
    }

    /// N, N_m and N_s, likewise. With fewer sensing slots than the first exit needs nothing is recognised: the users get them.
    ///
    /// # Errors
    ///
    /// [`Error::Deadline`], and nothing changes, if a recognition would be late, as [`RadarModule::new`](super::RadarModule::new) finds.
    pub fn set_layout(&mut self, layout: SensingLayout) -> Result<(), Error> {
        super::in_time(self.pipeline, layout)?;
        self.planner.set_layout(layout);
        Ok(())
    }

    /// [`ProcessingContext::set_layout`] with N_s alone.
    ///
    /// # Errors
    ///
    /// As there, and [`PlanError::Spacing`](crate::scheduler::PlanError::Spacing) if they do not fit the period.
    pub fn set_sensing_slots(&mut self, slots: u32) -> Result<(), Error> {
        let layout = self.planner.target();
        self.set_layout(SensingLayout::new(layout.period(), layout.spacing(), slots)?)
    }

    /// Confidence that ends a period's sensing early, from the next classification on.
    pub fn set_threshold(&mut self, threshold: f32) {
        self.pipeline.set_threshold(threshold);
    }

    /// The signal chain's self test, at power-on, before the first slot:
    /// [`Pipeline::test_signal_chain`](crate::pipeline::Pipeline::test_signal_chain).
    pub fn test_signal_chain(&mut self, rng: &mut impl Rng) -> [u64; 2] {
        self.pipeline.test_signal_chain(rng)
    }

    /// Whether the networks' kernels work, at power-on, before the first slot: [`Pipeline::self_test`](crate::pipeline::Pipeline::self_test).
    pub fn self_test(&mut self, rng: &mut impl Rng) -> bool {
        self.pipeline.self_test(rng)
    }

    /// Name of a class.
    pub fn class_name(&self, class: u8) -> &'static str {
        self.pipeline.exits().first().map_or("", |exit| exit.model.class_name(usize::from(class)))
    }

    /// Where some of its data lie, for a debugger and for tests that change them; empty where there are none at this moment.
    pub fn area(&self, area: Area) -> Range<*const u8> {
        match (area, self.ends.filled.peek()) {
            (Area::WaitingSlot(number), Some(Filled { period, index, left, .. })) => match number {
                0 => range(core::slice::from_ref(period)),
                1 => range(core::slice::from_ref(index)),
                _ => range(core::slice::from_ref(left)),
            },
            _ => self.pipeline.area(area),
        }
    }

    fn take_report(&mut self, report: Report) -> Progress {
        match report {
            Report::Fault(fault) => Progress::Event(Event::Fault(fault)),
            Report::Period { period, replanned, counts } => {
                self.counts.add(&counts);
                // the plan that has begun leaves its queue one slot later
                self.plan_due = true;
                let Changes { lost, sensing_lost, released, .. } = counts.changes();
                let because = if replanned { core::mem::take(&mut self.changes) } else { Changes::default() };
                let changes = Changes { lost, sensing_lost, released, ..because };
                Progress::Event(Event::Period(PeriodReport { period, replanned, changes }))
            }
            Report::Released { period, rest, served } => {
                let totals = self.planner.totals(rest, &served);
                let _ = self.ends.totals.enqueue(Totals { period, totals }); // those of an earlier period are late anyway
                Progress::Busy
            }
            Report::PlanNeeded => {
                let _ = self.ends.plans.enqueue(Message::new(self.planner.first_plan())); // if one waits, it serves as well
                Progress::Busy
            }
        }
    }

    /// Makes the next plan, if it is another one.
    fn plan(&mut self) {
        self.plan_due = false;
        let (plan, changes) = self.planner.next_plan(&core::mem::take(&mut self.counts));
        if let Some(plan) = plan {
            self.changes = changes;
            let _ = self.ends.plans.enqueue(Message::new(plan)); // the caller has asked whether there is room
        }
    }

    /// Takes the oldest slot out of its queue; `None` if there is none, or it has to wait for a recognition.
    fn take_slot(&mut self) -> Option<Progress> {
        let &Filled { period, index, left, .. } = self.ends.filled.peek()?;
        if period != self.period {
            (self.period, self.next_index, self.unused) = (period, 0, false);
            self.pipeline.begin_recording(period);
        }
        if index != self.next_index && !self.unused && !self.pipeline.stopped() {
            // a recording with a gap is no recording
            self.pipeline.begin_recording(period);
            self.next_index = index;
        }
        let enough = self.pipeline.taken() > 0 || left as usize + 1 >= self.pipeline.first_exit_slots();
        if !enough && !self.unused {
            self.end_sensing(period);
        }
        let used = !self.unused && !self.pipeline.stopped();
        if used && !self.pipeline.has_room() {
            return None;
        }
        let Filled { buffer, .. } = self.ends.filled.dequeue()?;
        let mut fault = None;
        if used {
            self.next_index = index.wrapping_add(1);
            fault = sample_health::check(&buffer.0, self.pipeline.config()).err();
            match fault {
                Some(_) => self.pipeline.begin_recording(period),
                None => match self.pipeline.push(&buffer.0, &mut ()) {
                    Ok(()) | Err(Error::Full) => (),
                    // there was room, and the length is the configuration's
                    Err(_) => self.pipeline.begin_recording(period),
                },
            }
        }
        let _ = self.ends.free.enqueue(buffer); // there are as many places as buffers
        Some(match fault {
            Some(fault) => Progress::Event(Event::Fault(Fault::Samples(fault))),
            None => Progress::Busy,
        })
    }

    /// The rest of this period's sensing slots go to the users; nothing happens if it is over.
    fn end_sensing(&mut self, period: u32) {
        if period == self.period {
            self.ends.release.store(period, Ordering::Release);
            self.unused = true;
        }
    }

    /// Checks another piece of the model that was used; after the last the classification is given, or its damage.
    fn check_model(&mut self) -> Progress {
        let Some(check) = &mut self.check else { return Progress::Idle };
        let exit = usize::from(check.classification.exit);
        let content = self.pipeline.exits().get(exit).map_or(&[][..], |exit| exit.model.bytes());
        if let Some(rest) = content.get(check.done..).filter(|rest| !rest.is_empty()) {
            let piece = rest.get(..CHECK_BYTES).unwrap_or(rest);
            check.crc = check.crc.update(piece);
            check.done += piece.len();
            return Progress::Busy;
        }
        let computed = check.crc.finish();
        let (period, stop) = (check.period, check.classification.stop);
        let stated = self.checksums.get(exit).copied().unwrap_or(!computed);
        let Some(Check { classification, .. }) = self.check.take() else { return Progress::Idle };
        let bit = 1 << (exit % EXITS);
        if computed != stated {
            self.end_sensing(period);
            let known = self.damaged & bit != 0;
            self.damaged |= bit;
            if known {
                return Progress::Busy;
            }
            return Progress::Event(Event::Fault(Fault::Model(ModelError::Checksum { stated, computed })));
        }
        self.damaged &= !bit;
        // a later period's release stays
        if stop && period == self.period {
            self.ends.release.store(period, Ordering::Release);
        }
        Progress::Event(Event::Classification { period, classification })
    }
}
