//! What the module's supervision of samples says of a recording, slot by slot.

use crate::results::{SampleFaults, SampleSupervision};
use sdp3_core::config::RadarConfig;
use sdp3_core::supervision::{SampleFault, sample_health};

/// Looks at slots in order.
pub(super) struct Supervisor {
    config: RadarConfig,
    slots: u32,
    found: SampleSupervision,
}

impl Supervisor {
    pub(super) fn new(config: RadarConfig) -> Self {
        Supervisor { config, slots: 0, found: SampleSupervision::default() }
    }

    /// Whether the module would not use the next slot.
    pub(super) fn is_faulty(&mut self, slot: &[i16]) -> bool {
        let (number, fault) = (self.slots, sample_health::check(slot, &self.config).err());
        self.slots += 1;
        let Some(fault) = fault else { return false };
        self.found.faulty_slots += 1;
        let name = name(&fault);
        match self.found.faults.iter_mut().find(|known| known.fault == name) {
            Some(known) => known.slots += 1,
            None => self.found.faults.push(SampleFaults {
                fault: name.into(),
                slots: 1,
                first_slot: number,
                first: fault.to_string(),
            }),
        }
        true
    }

    /// What was found.
    pub(super) fn found(self) -> SampleSupervision {
        self.found
    }
}

fn name(fault: &SampleFault) -> &'static str {
    match fault {
        SampleFault::Silent => "silent",
        SampleFault::Stuck { .. } => "stuck",
        SampleFault::Saturated { .. } => "saturated",
        SampleFault::Offset { .. } => "offset",
        _ => "other",
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn faults_are_counted_by_kind_from_their_first_slot_on() {
        let config = RadarConfig::PAPER;
        let chirp = |amplitude: f64, at: i16| -> Vec<i16> {
            let value = |n: usize| (amplitude * libm::sin(0.7 * n as f64)) as i16;
            (0..config.values_per_slot()).map(|n| value(n).saturating_add(at)).collect()
        };
        let mut supervisor = Supervisor::new(config);
        let slots = [chirp(900.0, 0), chirp(0.0, 5), chirp(900.0, 0), chirp(1e6, 0), chirp(0.0, 0)];
        let faulty: Vec<bool> = slots.iter().map(|slot| supervisor.is_faulty(slot)).collect();
        assert_eq!(faulty, [false, true, false, true, true]);
        let found = supervisor.found();
        assert_eq!(found.faulty_slots, 3);
        let said: Vec<_> = found.faults.iter().map(|f| (f.fault.as_str(), f.slots, f.first_slot)).collect();
        assert_eq!(said, [("silent", 2, 1), ("saturated", 1, 3)]);
        assert!(found.faults[1].first.ends_with("at an end of the range"), "{}", found.faults[1].first);
    }
}
