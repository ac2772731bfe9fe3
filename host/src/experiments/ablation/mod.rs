//! What each effect of the simulation, of the processing and of the training does to the accuracy: one at a time, at both carriers.
//!
//! For every effect ([`effects`]) networks are trained and tested with it and without it, all else and all seeds equal. Both answer to
//! recordings of the same coordinates, so differences are paired ([`super::paired`]).

pub mod effects;
#[cfg(feature = "train")]
pub(crate) mod study;

use super::Request;
use super::paired::{COVERAGE, DRAWS, Difference};
use crate::formats::table;
use crate::results::Spread;
use effects::EFFECTS;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// An effect at a carrier and N_s.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Row {
    /// The effect.
    pub effect: String,
    /// Carrier in Hz.
    pub carrier_hz: f64,
    /// N_s.
    pub sensing_slots: u32,
    /// int8 accuracy with the effect.
    pub with: Spread,
    /// int8 accuracy without it.
    pub without: Spread,
    /// With less without, on the same recordings.
    pub difference: Difference,
}

/// The fields that make an effect.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub struct Fields {
    /// The effect.
    pub effect: String,
    /// Fields with it.
    pub with: Vec<String>,
    /// Fields without it.
    pub without: Vec<String>,
}

/// The study's result.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Ablation {
    /// Test recordings of a seed.
    pub tested: u32,
    /// Redrawn differences of an interval.
    pub draws: u32,
    /// Share of them within the interval.
    pub coverage: f64,
    /// What makes the effects.
    pub effects: Vec<Fields>,
    /// Effect by effect, carrier by carrier, by N_s.
    pub rows: Vec<Row>,
}

impl Ablation {
    /// Of rows.
    pub fn of(tested: u32, rows: Vec<Row>) -> Self {
        let words = |fields: &[&str]| fields.iter().map(|&field| field.to_owned()).collect();
        let fields = |e: &effects::Effect| Fields {
            effect: e.name.into(),
            with: words(e.with),
            without: words(e.without),
        };
        Ablation {
            tested,
            draws: DRAWS,
            coverage: COVERAGE,
            effects: EFFECTS.iter().map(fields).collect(),
            rows,
        }
    }

    /// A row a line.
    pub fn csv(&self) -> String {
        let header = [
            "effect",
            "carrier_hz",
            "sensing_slots",
            "with",
            "without",
            "difference",
            "low",
            "high",
            "seeds",
            "tested",
        ];
        let row = |r: &Row| {
            let d = r.difference;
            let mut cells = vec![r.effect.clone(), r.carrier_hz.to_string(), r.sensing_slots.to_string()];
            cells.extend([r.with.mean, r.without.mean, d.mean, d.low, d.high].map(|x| x.to_string()));
            cells.extend([r.with.seeds, self.tested].map(|n| n.to_string()));
            cells
        };
        table::csv(&header, self.rows.iter().map(row))
    }
}

/// The result in words.
pub fn table(request: &Request, found: &Ablation) -> String {
    let l = &request.scenario.learning;
    let mut text = format!(
        "# One effect at a time\n\n{} recordings per class to train, {} test recordings a seed, {}, {} epochs, C = {}, stem stride {}. \
         int8 accuracy. The difference is with less without, in points, on the same recordings; in brackets its {:.0} % interval by \
         {} bootstrap draws of seeds and recordings.\n\n| effect | GHz | N_s | with | without | difference |\n|---|---|---|---|---|---|\n",
        l.train_per_class,
        found.tested,
        request.seeds_label(),
        l.epochs,
        l.channels,
        l.stem_stride,
        100.0 * found.coverage,
        found.draws
    );
    for row in &found.rows {
        text += &format!(
            "| {} | {} | {} | {} | {} | {} |\n",
            row.effect,
            row.carrier_hz / 1e9,
            row.sensing_slots,
            row.with,
            row.without,
            row.difference
        );
    }
    text += "\n| effect | with | without |\n|---|---|---|\n";
    let code =
        |fields: &[String]| fields.iter().map(|field| format!("`{field}`")).collect::<Vec<_>>().join(", ");
    for fields in &found.effects {
        text += &format!("| {} | {} | {} |\n", fields.effect, code(&fields.with), code(&fields.without));
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scenario::Scenario;

    #[test]
    fn table_and_csv_say_the_same() {
        let row = Row {
            effect: EFFECTS[0].name.into(),
            carrier_hz: 60e9,
            sensing_slots: 800,
            with: Spread::of(&[0.8, 0.82]),
            without: Spread::of(&[0.79, 0.8]),
            difference: Difference { mean: 0.015, low: -0.004, high: 0.031 },
        };
        let found = Ablation::of(500, vec![row]);
        let request = Request {
            study: "ablation".into(),
            seed: crate::experiments::seeds::DEVELOPMENT_SEED,
            seeds: 2,
            scenario: Scenario::default(),
        };
        let text = table(&request, &found);
        for words in ["| 60 | 800 | 0.810 ± 0.014 | 0.795 ± 0.007 | +1.5 [-0.4, +3.1] |", "2 seeds from 101"]
        {
            assert!(text.contains(words), "{words} is not in: {text}");
        }
        assert_eq!(text.matches("`channel.mode=paper`").count(), 1);
        let csv = found.csv();
        let line = csv.lines().nth(1).unwrap();
        assert!(line.ends_with(",60000000000,800,0.81,0.795,0.015,-0.004,0.031,2,500"), "{line}");
    }
}
