//! What hyper-parameters are chosen on: candidates beside the scenario, at the paper's carriers and every N_s, on development seeds.
//!
//! A candidate is the scenario with a few fields changed ([`CANDIDATES`]). Its networks are trained with the same seeds and tested with
//! the same recordings, none of them learned from, so that differences are paired ([`super::paired`]). `docs/protocol.md` says
//! what was chosen.

use super::carriers::{CARRIERS_HZ, at_carrier};
use super::cells::Cells;
use super::paired::{Difference, difference, mean_difference, spread};
use super::trained::{Marked, marked, marks};
use super::{Request, RunContext, changed};
use crate::error::Failure;
use crate::formats::table;
use crate::results::Spread;
use crate::store::digest::sha256;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Name and fields of every candidate; the first is the scenario itself.
pub const CANDIDATES: &[(&str, &[&str])] = &[
    ("the scenario", &[]),
    ("range of 50 dB", &["spectrogram.range_db=50"]),
    ("range of 30 dB", &["spectrogram.range_db=30"]),
    ("window of 96 samples", &["spectrogram.window=96"]),
    ("beta = 10 (the paper)", &["spectrogram.beta=10"]),
    ("up to 12 masked rows", &["learning.mask_rows=12"]),
    ("one window a recording (the paper)", &["learning.windows=1"]),
    ("16 windows, 10 epochs", &["learning.windows=16", "learning.epochs=10"]),
    ("recordings twice as long", &["learning.recording_slots=2000"]),
    ("int8 tuned above 0.005 nats", &["learning.qat_above=0.005"]),
];

/// A candidate at a carrier and N_s.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Row {
    /// The candidate.
    pub candidate: String,
    /// Carrier in Hz.
    pub carrier_hz: f64,
    /// N_s.
    pub sensing_slots: u32,
    /// int8 accuracy.
    pub accuracy: Spread,
    /// The candidate less the scenario, on the same recordings.
    pub difference: Difference,
}

/// A candidate over N_s.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Candidate {
    /// Its name.
    pub name: String,
    /// The fields that it changes.
    pub fields: Vec<String>,
    /// Over all carriers and N_s.
    pub mean: Mean,
    /// Over all N_s of each carrier.
    pub carriers: Vec<Mean>,
}

/// A mean over N_s.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Mean {
    /// int8 accuracy.
    pub accuracy: f64,
    /// The candidate less the scenario; recordings are redrawn with all of their N_s.
    pub difference: Difference,
}

/// The study's result.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Selection {
    /// Recordings of a seed and carrier that were tested with.
    pub tested: u32,
    /// Candidate by candidate.
    pub candidates: Vec<Candidate>,
    /// Candidate by candidate, carrier by carrier, by N_s.
    pub rows: Vec<Row>,
}

/// Runs or goes on.
///
/// # Errors
///
/// Whatever a training, a candidate's scenario or the folder says.
pub fn study(request: &Request, cells: &Cells, context: RunContext) -> Result<Selection, Failure> {
    // `[candidate][carrier][seed]`
    let mut kept: Vec<[Vec<Marked>; CARRIERS_HZ.len()]> = vec![Default::default(); CANDIDATES.len()];
    for seed in request.each_seed() {
        for (c, carrier_hz) in CARRIERS_HZ.into_iter().enumerate() {
            let base = at_carrier(&request.scenario, carrier_hz);
            for ((_, fields), kept) in CANDIDATES.iter().zip(&mut kept) {
                let one = changed(&base, fields, "selection")?;
                let digest = &sha256([one.to_toml().as_bytes()])[..12];
                let name = format!("seed-{seed}-{}ghz-{digest}", carrier_hz / 1e9);
                kept[c].extend(cells.get(&name, || marked(&[one], seed, context))?);
            }
        }
    }
    let found = Selection::of(&request.scenario.frame.sensing_slots, &kept, request.seed);
    cells.output.write_result("selection.json", &found)?;
    cells.output.write("selection.csv", found.csv().as_bytes())?;
    cells.output.write("selection.md", table(request, &found).as_bytes())?;
    Ok(found)
}

/// For every seed, of all recordings at all carriers, the share of the N_s at which it was recognised.
fn scores(carriers: &[Vec<Marked>]) -> Vec<Vec<f64>> {
    let seeds = carriers.first().map_or(0, Vec::len);
    let share = |marks: &Marked, recording: usize| {
        let right = marks.iter().filter(|of_slots| of_slots.as_bytes()[recording] == b'1').count();
        right as f64 / marks.len() as f64
    };
    let of_seed = |seed: usize| {
        let each = carriers.iter().map(|seeds| &seeds[seed]);
        each.flat_map(|marks| (0..marks.first().map_or(0, String::len)).map(move |n| share(marks, n)))
            .collect()
    };
    (0..seeds).map(of_seed).collect()
}

impl Mean {
    /// Of marks and those of the scenario, `[carrier][seed]`.
    fn of(carriers: &[Vec<Marked>], base: &[Vec<Marked>], seed: u64) -> Self {
        let [found, base] = [carriers, base].map(scores);
        let all = found.iter().flatten();
        Mean {
            accuracy: all.clone().sum::<f64>() / all.count().max(1) as f64,
            difference: mean_difference(&found, &base, seed),
        }
    }
}

impl Selection {
    /// Of marks, `[candidate][carrier][seed]`.
    fn of(slots: &[u32], kept: &[[Vec<Marked>; CARRIERS_HZ.len()]], seed: u64) -> Self {
        let tested = kept[0][0].first().and_then(|slots| slots.first()).map_or(0, String::len) as u32;
        let (mut candidates, mut rows) = (Vec::new(), Vec::new());
        for ((name, fields), carriers) in CANDIDATES.iter().zip(kept) {
            candidates.push(Candidate {
                name: (*name).to_owned(),
                fields: fields.iter().map(|&field| field.to_owned()).collect(),
                mean: Mean::of(carriers, &kept[0], seed),
                carriers: (0..CARRIERS_HZ.len())
                    .map(|c| Mean::of(&carriers[c..=c], &kept[0][c..=c], seed))
                    .collect(),
            });
            for ((carrier_hz, found), base) in CARRIERS_HZ.into_iter().zip(carriers).zip(&kept[0]) {
                for (n, &sensing_slots) in slots.iter().enumerate() {
                    let [found, base] = [found, base].map(|seeds| marks(seeds, n));
                    rows.push(Row {
                        candidate: (*name).to_owned(),
                        carrier_hz,
                        sensing_slots,
                        accuracy: spread(&found),
                        difference: difference(&found, &base, seed),
                    });
                }
            }
        }
        Selection { tested, candidates, rows }
    }

    /// A row a line.
    fn csv(&self) -> String {
        let header = [
            "candidate",
            "carrier_hz",
            "sensing_slots",
            "accuracy",
            "difference",
            "low",
            "high",
            "seeds",
            "tested",
        ];
        let row = |r: &Row| {
            let mut cells = vec![r.candidate.clone(), r.carrier_hz.to_string(), r.sensing_slots.to_string()];
            let d = r.difference;
            cells.extend([r.accuracy.mean, d.mean, d.low, d.high].map(|x| x.to_string()));
            cells.extend([r.accuracy.seeds, self.tested].map(|n| n.to_string()));
            cells
        };
        table::csv(&header, self.rows.iter().map(row))
    }
}

/// The result in words.
pub fn table(request: &Request, found: &Selection) -> String {
    let l = &request.scenario.learning;
    let slots = &request.scenario.frame.sensing_slots;
    let mut text = format!(
        "# Candidates for the hyper-parameters\n\n{} recordings per class to train, {} recordings a seed and carrier to choose on, {}, {} \
         epochs, C = {}, stem stride {}. int8 accuracy. Differences are from the scenario, in points, on the same recordings, with their \
         95 % interval; the mean is over the N_s.\n\n| candidate | both carriers | difference | 3.5 GHz | difference | 60 GHz | difference |\n|---|{}\n",
        l.train_per_class,
        found.tested,
        request.seeds_label(),
        l.epochs,
        l.channels,
        l.stem_stride,
        "---|".repeat(6)
    );
    for one in &found.candidates {
        text += &format!("| {} |", one.name);
        for mean in std::iter::once(&one.mean).chain(&one.carriers) {
            text += &format!(" {:.4} | {:.2} |", mean.accuracy, mean.difference);
        }
        text += "\n";
    }
    for carrier_hz in CARRIERS_HZ {
        let names: Vec<String> = slots.iter().map(u32::to_string).collect();
        let rule = "---|".repeat(slots.len());
        text += &format!("\n| {} GHz, N_s | {} |\n|---|{rule}\n", carrier_hz / 1e9, names.join(" | "));
        for (name, _) in CANDIDATES {
            let of = |row: &&Row| row.candidate == *name && row.carrier_hz == carrier_hz;
            let cells: Vec<String> =
                found.rows.iter().filter(of).map(|row| format!("{:.3}", row.accuracy.mean)).collect();
            text += &format!("| {name} | {} |\n", cells.join(" | "));
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scenario::{Override, Scenario};

    #[test]
    fn every_candidate_is_legal_and_unlike_the_scenario_at_both_carriers() {
        for carrier_hz in CARRIERS_HZ {
            let base = at_carrier(&Scenario::default(), carrier_hz);
            let mut seen = Vec::new();
            for (name, fields) in CANDIDATES {
                assert!(fields.iter().all(|field| field.parse::<Override>().is_ok()), "{name}");
                let found = changed(&base, fields, "selection").unwrap();
                assert!(!seen.contains(&found), "{name} at {carrier_hz}");
                seen.push(found);
            }
            assert_eq!(seen[0], base);
        }
    }

    #[test]
    fn the_mean_is_over_carriers_slots_and_recordings() {
        let marked = |texts: [&str; 2]| vec![texts.map(str::to_owned).to_vec()];
        let base = [marked(["1100", "1110"]), marked(["1111", "1111"])];
        let better = [marked(["1110", "1110"]), marked(["1111", "0111"])];
        let mut kept = vec![base.clone(); CANDIDATES.len()];
        kept[1] = better;
        let found = Selection::of(&[200, 300], &kept, 101);
        assert_eq!(found.tested, 4);
        let [base, better] = [0, 1].map(|n| &found.candidates[n]);
        assert_eq!((base.mean.accuracy, better.mean.accuracy), (13.0 / 16.0, 13.0 / 16.0));
        assert_eq!([0, 1].map(|c| better.carriers[c].difference.mean), [0.125, -0.125]);
        let Difference { mean, low, high } = better.mean.difference;
        assert!(mean == 0.0 && low < 0.0 && high > 0.0);
        assert_eq!(found.candidates[2].mean.difference, Difference { mean: 0.0, low: 0.0, high: 0.0 });
        let row = &found.rows[4];
        assert_eq!((row.carrier_hz, row.sensing_slots, row.difference.mean), (CARRIERS_HZ[0], 200, 0.25));
        let request =
            Request { study: "selection".into(), seed: 101, seeds: 1, scenario: Scenario::default() };
        let text = table(&request, &found);
        let line = format!("| {} | 0.8125 | +0.00 [", CANDIDATES[1].0);
        assert!(text.contains(&line) && text.contains(" | 0.7500 | +12.50 ["), "{text}");
        assert_eq!(found.csv().lines().count(), 1 + CANDIDATES.len() * 4);
    }
}
