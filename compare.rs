
#[cfg(test)]
mod tests {
    use super::*;
    use crate::conformance::reference::oracle;
    use crate::conformance::suite::{ScheduleCase, stimuli};

    /// The networks LiteRT computed, on every stimulus: the core reads a model file it did not write.
    fn suite() -> Suite {
        let golden = oracle::read("network.json");
        let models = golden["networks"].as_array().unwrap().iter().map(|n| oracle::bytes(&n["model"]));
        let cases = models.flat_map(|model| stimuli(&model, network::header(&model).sensing_slots, 7)).collect();
        Suite { cases, schedule: ScheduleCase { period: 400, spacing: 3, sensing: 100, shares: vec![70, 150, 80] } }
    }

    #[test]
    fn core_agrees_with_the_reference_on_every_stimulus() {
        let verdict = verify_host(&suite()).unwrap();
        for stage in &verdict.stages { eprintln!("{stage:?}"); }
        assert_eq!((verdict.mismatches, verdict.detail), (0, None));
    }
}
