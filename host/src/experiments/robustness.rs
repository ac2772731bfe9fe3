//! Accuracy under changed conditions: one property of the room, the radar or the person at a time.
//!
//! For every condition two answers at the largest N_s: of the network trained in the default room (transfer), and of one trained
//! under that very condition (matched). People of unseen height and speed exist for the first only.

use super::cells::Cells;
use super::trained::{Trained, images, train};
use super::{Request, RunContext, Spread};
use crate::error::Failure;
use crate::network::spectrograms::Part;
use crate::scenario::Scenario;
use crate::simulator::calibration::rho_of;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A condition.
pub struct Condition {
    /// What is changed.
    pub factor: &'static str,
    /// To which value.
    pub value: String,
    /// Whether a network is trained under it as well.
    pub matched: bool,
    change: Box<dyn Fn(&mut Scenario)>,
}

impl Condition {
    /// Its name as part of a file's.
    fn key(&self) -> String {
        let text = format!("{} {}", self.factor, self.value).to_lowercase();
        let words =
            text.split(|c: char| !c.is_ascii_alphanumeric() && c != '.').filter(|word| !word.is_empty());
        words.collect::<Vec<_>>().join("-")
    }
}

/// Every condition of a radar with so many range samples, factor by factor.
pub fn conditions(range_samples: u8) -> Vec<Condition> {
    let mut all = Vec::new();
    let mut add = |factor, value: String, matched, change: Box<dyn Fn(&mut Scenario)>| {
        all.push(Condition { factor, value, matched, change });
    };
    for degrees in [0.0, 15.0, 45.0, 90.0, 180.0] {
        let change = move |s: &mut Scenario| {
            s.target.heading_spread_deg = degrees;
            // sideways walks are stopped by walls
            s.target.turns |= degrees > 45.0;
        };
        add("heading (degrees)", format!("{degrees}"), true, Box::new(change));
    }
    for rho in [1.0, 0.999, 0.998, 0.997, 0.995, 0.99, 0.98] {
        add("rho", format!("{rho}"), true, Box::new(move |s| s.channel.rho = Some(rho)));
    }
    // a person's echo is about 100 dB above the noise at 1 W
    for db in [0.0, 60.0, 80.0, 100.0, 120.0] {
        let change = move |s: &mut Scenario| s.radar.power_w *= libm::pow(10.0, -db / 10.0);
        add("transmit power (dB)", format!("{}", 0.0 - db), true, Box::new(change));
    }
    // there are as many components as range samples
    for first in 0..=range_samples.min(3) {
        let change = move |s: &mut Scenario| s.spectrogram.first_kept = first;
        let value = if first == 0 { "adaptive".into() } else { format!("{first}") };
        add("first component kept, d", value, true, Box::new(change));
    }
    for (value, child, adult) in [
        ("children 1.2 to 1.4 m, adults 1.5 to 1.6 m", [1.2, 1.4], [1.5, 1.6]),
        ("children 0.8 to 0.9 m, adults 1.9 to 2.1 m", [0.8, 0.9], [1.9, 2.1]),
    ] {
        let change = move |s: &mut Scenario| {
            s.target.child_height_m = child;
            s.target.adult_height_m = adult;
        };
        add("unseen heights", value.into(), false, Box::new(change));
    }
    for jitter in [0.1, 0.2] {
        let change = move |s: &mut Scenario| {
            s.target.speed_jitter = jitter;
            s.target.turns = true;
        };
        add("spread of the speed", format!("{jitter}"), false, Box::new(change));
    }
    add("second person", "walking".into(), true, Box::new(|s| s.channel.interferer = true));
    for spacing in [0_u32, 3] {
        let change = move |s: &mut Scenario| {
            s.radar.carrier_hz = 60e9;
            s.frame.spacing_slots = spacing;
            s.spectrogram.bins_per_row = 4;
        };
        add("60 GHz, N_m", format!("{spacing}"), true, Box::new(change));
    }
    all
}

/// A condition's result.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Row {
    /// What is changed.
    pub factor: String,
    /// To which value.
    pub value: String,
    /// int8 accuracy of the network trained in the default room.
    pub transfer: Spread,
    /// int8 accuracy of the network trained under the condition.
    pub matched: Option<Spread>,
}

/// The study's result.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Robustness {
    /// N_s of every network.
    pub sensing_slots: u32,
    /// Conditions in their order.
    pub rows: Vec<Row>,
}

/// Transfer and matched accuracy of a seed.
type Cell = (f64, Option<f64>);

/// Runs or goes on.
///
/// # Errors
///
/// Whatever a training, a condition's scenario or the folder says.
pub fn study(request: &Request, cells: &Cells, context: RunContext) -> Result<Robustness, Failure> {
    let mut usual = request.scenario.clone();
    let sensing_slots = usual.largest_sensing_slots();
    usual.frame.sensing_slots = vec![sensing_slots];
    let learn =
        |s: &Scenario, seed: u64| train(s, seed, &images(s, rho_of(s), seed, Part::Train, context), context);
    // a rho that is stated where it would be taken anyway changes nothing
    let unchanged = |s: &Scenario| {
        let mut stated = s.clone();
        stated.channel.rho = usual.channel.rho;
        stated == usual && rho_of(s) == rho_of(&usual)
    };
    let conditions = conditions(usual.radar.range_samples);
    let mut found: Vec<Vec<Cell>> = vec![Vec::new(); conditions.len()];
    for seed in request.each_seed() {
        // trained when the first cell needs it
        let mut network: Option<Trained> = None;
        for (k, condition) in conditions.iter().enumerate() {
            let mut s = usual.clone();
            (condition.change)(&mut s);
            s.check(&format!("robustness, {} {}", condition.factor, condition.value))?;
            let cell = cells.get(&format!("seed-{seed}-{}", condition.key()), || {
                let test = images(&s, rho_of(&s), seed, Part::Test, context);
                let transfer = match &network {
                    Some(network) => network.test(&s, &test)?,
                    None => network.insert(learn(&usual, seed)?).test(&s, &test)?,
                };
                let matched = match condition.matched && !unchanged(&s) {
                    true => Some(learn(&s, seed)?.test(&s, &test)?[0].int8),
                    false => None,
                };
                Ok((transfer[0].int8, matched))
            })?;
            found[k].push(cell);
        }
    }
    let row = |(condition, cells): (&Condition, &Vec<Cell>)| {
        let matched: Vec<f64> = cells.iter().filter_map(|c| c.1).collect();
        Row {
            factor: condition.factor.into(),
            value: condition.value.clone(),
            transfer: Spread::of(&cells.iter().map(|c| c.0).collect::<Vec<_>>()),
            matched: (!matched.is_empty()).then(|| Spread::of(&matched)),
        }
    };
    let found = Robustness { sensing_slots, rows: conditions.iter().zip(&found).map(row).collect() };
    cells.output.write_result("robustness.json", &found)?;
    cells.output.write("robustness.md", table(request, &found).as_bytes())?;
    Ok(found)
}

/// The result in words.
pub fn table(request: &Request, found: &Robustness) -> String {
    let l = &request.scenario.learning;
    let mut text = format!(
        "# Accuracy under changed conditions\n\nN_s = {}, {} recordings per class to train, {} to test, {}. Transfer: trained in the \
         default room (heading within {} degrees); matched: trained under the condition.\n\n| changed | to | transfer | matched |\n\
         |---|---|---|---|\n",
        found.sensing_slots,
        l.train_per_class,
        l.test_per_class,
        request.seeds_label(),
        request.scenario.target.heading_spread_deg
    );
    for row in &found.rows {
        let matched = row.matched.map_or_else(|| "–".into(), |m| m.to_string());
        text += &format!("| {} | {} | {} | {matched} |\n", row.factor, row.value, row.transfer);
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;

    #[test]
    fn every_condition_is_a_legal_scenario_of_its_own_name() {
        assert_eq!(conditions(1).len() + 2, conditions(8).len());
        let conditions = conditions(8);
        let keys: BTreeSet<String> = conditions.iter().map(Condition::key).collect();
        assert_eq!(keys.len(), conditions.len());
        assert!(keys.contains("rho-0.98") && keys.contains("60-ghz-n-m-3"), "{keys:?}");
        for condition in conditions {
            let mut scenario = Scenario::default();
            scenario.frame.sensing_slots = vec![scenario.largest_sensing_slots()];
            (condition.change)(&mut scenario);
            scenario.check(condition.factor).unwrap();
        }
    }
}
