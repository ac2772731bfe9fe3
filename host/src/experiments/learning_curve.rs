//! Accuracy over sensing slots, several seeds, and the curves of Table III fitted to it.
//!
//! Section IV-B of the paper. Every seed draws its own recordings, weights and shuffling.

use super::cells::Cells;
use super::trained::{images, train};
use super::{Request, RunContext, Spread};
use crate::error::Failure;
use crate::network::spectrograms::Part;
use crate::predictor::{fit_all, paper};
use crate::results::{Accuracy, CurvePoint, Prediction};
use crate::simulator::calibration::rho_of;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// One N_s.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Row {
    /// N_s.
    pub sensing_slots: u32,
    /// Float accuracy over the seeds.
    pub float: Spread,
    /// int8 accuracy over the seeds.
    pub int8: Spread,
    /// Every seed's int8 accuracy.
    pub each: Vec<f64>,
    /// Test recordings of a seed.
    pub tested: u32,
}

/// The study's result.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct LearningCurve {
    /// AR(1) coefficient rho of the room channel.
    pub rho: f64,
    /// Rows by N_s.
    pub rows: Vec<Row>,
    /// The curves of Table II, fitted to the means.
    pub prediction: Option<Prediction>,
}

/// Runs or goes on.
///
/// # Errors
///
/// Whatever a training or the folder says.
pub fn study(request: &Request, cells: &Cells, context: RunContext) -> Result<LearningCurve, Failure> {
    let s = &request.scenario;
    let rho = rho_of(s);
    let mut seeds: Vec<Vec<Accuracy>> = Vec::new();
    for seed in request.each_seed() {
        seeds.push(cells.get(&format!("seed-{seed}"), || {
            let networks = train(s, seed, &images(s, rho, seed, Part::Train, context), context)?;
            networks.test(s, &images(s, rho, seed, Part::Test, context))
        })?);
    }
    let row = |(k, &sensing_slots): (usize, &u32)| {
        let each = |of: fn(&Accuracy) -> f64| seeds.iter().map(|rows| of(&rows[k])).collect::<Vec<_>>();
        let int8 = each(|a| a.int8);
        let tested = seeds.first().map_or(0, |rows| rows[k].tested);
        Row {
            sensing_slots,
            float: Spread::of(&each(|a| a.float)),
            int8: Spread::of(&int8),
            each: int8,
            tested,
        }
    };
    let rows: Vec<Row> = s.frame.sensing_slots.iter().enumerate().map(row).collect();
    let points: Vec<CurvePoint> = rows
        .iter()
        .map(|r| CurvePoint {
            sensing_slots: f64::from(r.sensing_slots),
            accuracy: r.int8.mean,
            tested: Some(f64::from(r.tested) * f64::from(request.seeds)),
            std: r.int8.standard_error(),
        })
        .collect();
    // too few numbers of slots for a curve are no failure of the study
    let found = LearningCurve { rho, rows, prediction: fit_all(&points).ok() };
    cells.output.write_result("learning-curve.json", &found)?;
    cells.output.write("learning-curve.md", table(request, &found).as_bytes())?;
    Ok(found)
}

/// The result in words.
pub fn table(request: &Request, found: &LearningCurve) -> String {
    let l = &request.scenario.learning;
    let mut text = format!(
        "# Accuracy over sensing slots\n\n{:.3} GHz, rho = {}, heading within {} degrees, {} recordings per class to train, {} new \
         ones to test, {}, {} epochs, C = {}, stem stride {}.\n\n| N_s | int8 | float | the paper |\n\
         |---|---|---|---|\n",
        request.scenario.radar.carrier_hz / 1e9,
        found.rho,
        request.scenario.target.heading_spread_deg,
        l.train_per_class,
        l.test_per_class,
        request.seeds_label(),
        l.epochs,
        l.channels,
        l.stem_stride
    );
    for row in &found.rows {
        let paper = paper::POINTS.iter().find(|(n, _)| *n == row.sensing_slots);
        let paper = paper.map_or_else(String::new, |(_, a)| format!("{a:.4}"));
        text += &format!("| {} | {} | {} | {paper} |\n", row.sensing_slots, row.int8, row.float);
    }
    if let Some(prediction) = &found.prediction {
        text += "\n| curve | sum of squared errors | AICc | leave-one-out |\n|---|---|---|---|\n";
        for m in &prediction.models {
            let aicc = m.aicc.map_or_else(|| "–".into(), |a| format!("{a:.1}"));
            let loo = m.loo.map_or_else(|| "–".into(), |l| format!("{l:.4}"));
            text += &format!("| {} | {:.3e} | {aicc} | {loo} |\n", m.name, m.sse);
        }
    }
    text
}
