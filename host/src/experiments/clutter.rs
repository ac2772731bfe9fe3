//! Clutter removal that adapts to each recording against every fixed d, over the ratio of clutter to target.
//!
//! For every ratio networks are trained and tested with `spectrogram.first_kept` = 0 (adaptive) and = 1, 2, 3, all else and all seeds
//! equal. The room's gain makes the ratio ([`clutter_to_target_db`]); the person stays as it is.

use super::cells::Cells;
use super::paired::{Difference, difference, spread};
use super::trained::{Marked, marked, marks};
use super::{Request, RunContext};
use crate::error::{Failure, Invalid};
use crate::formats::table;
use crate::results::Spread;
use crate::scenario::{ArMode, Model, Scenario};
use crate::simulator::clutter_to_target::clutter_to_target_db;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Clutter to target in dB.
pub const RATIOS_DB: [f64; 7] = [-20.0, -10.0, 0.0, 10.0, 20.0, 30.0, 40.0];

/// `spectrogram.first_kept`: adaptive, and the fixed ones.
pub const FIRST_KEPT: [u8; 4] = [0, 1, 2, 3];

/// A ratio and N_s.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Row {
    /// Clutter to target in dB.
    pub clutter_to_target_db: f64,
    /// N_s.
    pub sensing_slots: u32,
    /// int8 accuracy where the core decides.
    pub adaptive: Spread,
    /// int8 accuracy with d = 1, 2, 3.
    pub fixed: Vec<Spread>,
    /// The d with the highest mean accuracy.
    pub best_d: u8,
    /// Adaptive less the best d, on the same recordings.
    pub difference: Difference,
}

/// The study's result.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Clutter {
    /// Test recordings of a seed.
    pub tested: u32,
    /// Ratio by ratio, by N_s.
    pub rows: Vec<Row>,
}

/// The scenario at a ratio: the room's gain for it.
fn with_ratio(scenario: &Scenario, ratio_db: f64) -> Scenario {
    let mut found = scenario.clone();
    // to a tenth of a dB, as a person would state it
    let gain = ratio_db - clutter_to_target_db(scenario) + scenario.channel.clutter_gain_db;
    found.channel.clutter_gain_db = (10.0 * gain).round() / 10.0;
    found
}

/// Runs or goes on.
///
/// # Errors
///
/// Whatever a training or the folder says.
pub fn study(request: &Request, cells: &Cells, context: RunContext) -> Result<Clutter, Failure> {
    let channel = &request.scenario.channel;
    if channel.model != Model::Dahc || channel.mode != ArMode::Rician {
        let legal = "dahc with channel.mode = rician: this study sets the power of a room that has a mean";
        return Err(Invalid::new("channel.model", channel.model.name(), legal).into());
    }
    let (count, legal) =
        (request.scenario.radar.range_samples, "at least 3: components from d = 1, 2, 3 on are kept");
    Invalid::unless(count >= 3, "radar.range_samples", count, legal)?;
    let mut conditions = Vec::new();
    for ratio_db in RATIOS_DB {
        let scenario = with_ratio(&request.scenario, ratio_db);
        scenario.check(&format!("clutter, {ratio_db} dB"))?;
        conditions.push((ratio_db, scenario));
    }
    // `[condition][first kept][seed]`
    let mut kept: Vec<[Vec<Marked>; FIRST_KEPT.len()]> = vec![Default::default(); conditions.len()];
    for seed in request.each_seed() {
        for ((ratio_db, scenario), found) in conditions.iter().zip(&mut kept) {
            let arms = FIRST_KEPT.map(|first_kept| {
                let mut scenario = scenario.clone();
                scenario.spectrogram.first_kept = first_kept;
                scenario
            });
            let marks = cells.get(&format!("seed-{seed}-{ratio_db}db"), || marked(&arms, seed, context))?;
            found.iter_mut().zip(marks).for_each(|(found, marks)| found.push(marks));
        }
    }
    let mut rows = Vec::new();
    for ((ratio_db, scenario), arms) in conditions.iter().zip(&kept) {
        for (n, &sensing_slots) in scenario.frame.sensing_slots.iter().enumerate() {
            let [adaptive, fixed @ ..] = arms.each_ref().map(|arm| marks(arm, n));
            let accuracy = fixed.each_ref().map(|marks| spread(marks));
            let best = (0..fixed.len())
                .rev()
                .max_by(|&a, &b| accuracy[a].mean.total_cmp(&accuracy[b].mean))
                .unwrap_or(0);
            rows.push(Row {
                clutter_to_target_db: *ratio_db,
                sensing_slots,
                adaptive: spread(&adaptive),
                fixed: accuracy.to_vec(),
                best_d: FIRST_KEPT[best + 1],
                difference: difference(&adaptive, &fixed[best], request.seed),
            });
        }
    }
    let tested = kept.first().and_then(|arms| arms[0].first()).and_then(|n| n.first()).map_or(0, String::len);
    let found = Clutter { tested: tested as u32, rows };
    cells.output.write_result("clutter.json", &found)?;
    cells.output.write("clutter.csv", csv(&found).as_bytes())?;
    cells.output.write("clutter.md", table(request, &found).as_bytes())?;
    Ok(found)
}

/// A row a line.
fn csv(found: &Clutter) -> String {
    let header = [
        "clutter_to_target_db",
        "sensing_slots",
        "adaptive",
        "d1",
        "d2",
        "d3",
        "best_d",
        "difference",
        "low",
        "high",
    ];
    let row = |r: &Row| {
        let mut cells = vec![r.clutter_to_target_db.to_string(), r.sensing_slots.to_string()];
        cells.push(r.adaptive.mean.to_string());
        cells.extend(r.fixed.iter().map(|spread| spread.mean.to_string()));
        cells.push(r.best_d.to_string());
        cells.extend([r.difference.mean, r.difference.low, r.difference.high].map(|x| x.to_string()));
        cells
    };
    table::csv(&header, found.rows.iter().map(row))
}

/// The result in words.
pub fn table(request: &Request, found: &Clutter) -> String {
    let l = &request.scenario.learning;
    let mut text = format!(
        "# Clutter removal: adaptive or fixed\n\n{} GHz, {} recordings per class to train, {} test recordings a seed, {}, {} epochs, \
         C = {}. int8 accuracy. The difference is adaptive less the best fixed d, in points, on the same recordings; in brackets its 95 % \
         interval by bootstrap draws of seeds and recordings.\n\n| clutter to target (dB) | N_s | adaptive | d = 1 | d = 2 | d = 3 \
         | difference |\n|---|---|---|---|---|---|---|\n",
        request.scenario.radar.carrier_hz / 1e9,
        l.train_per_class,
        found.tested,
        request.seeds_label(),
        l.epochs,
        l.channels,
    );
    for row in &found.rows {
        let fixed: Vec<String> = row.fixed.iter().map(Spread::to_string).collect();
        text += &format!(
            "| {} | {} | {} | {} | {} |\n",
            row.clutter_to_target_db,
            row.sensing_slots,
            row.adaptive,
            fixed.join(" | "),
            row.difference,
        );
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scenario::builtin::named;

    #[test]
    fn the_rooms_gain_makes_the_ratio() {
        for name in ["conference-room", "radar-60ghz"] {
            let base = named(name.as_ref()).unwrap().scenario();
            for ratio_db in RATIOS_DB {
                let scenario = with_ratio(&base, ratio_db);
                scenario.check("test").unwrap();
                assert!((clutter_to_target_db(&scenario) - ratio_db).abs() < 0.06, "{ratio_db}");
            }
        }
    }
}
