//! The trainings of the ablation study, cell by cell: a carrier, a seed and a scenario with or without an effect.

use super::effects::{CARRIERS, EFFECTS, at};
use super::{Ablation, Row, table};
use crate::error::Failure;
use crate::experiments::cells::Cells;
use crate::experiments::paired::{difference, spread};
use crate::experiments::trained::{Marked, marked, marks};
use crate::experiments::{Request, RunContext};
use crate::scenario::Scenario;
use crate::store::digest::sha256;

/// The cell of a scenario; its name has the scenario's digest, so that a changed effect is another cell.
fn name(label: &str, scenario: &Scenario, carrier_hz: f64, seed: u64) -> String {
    let digest = sha256([scenario.to_toml().as_bytes()]);
    format!("seed-{seed}-{}ghz-{label}-{}", carrier_hz / 1e9, &digest[..12])
}

/// Runs or goes on. The scenario that an effect leaves as it is, is trained once for all effects.
///
/// # Errors
///
/// Whatever a training, an effect's scenario or the folder says.
pub fn study(request: &Request, cells: &Cells, context: RunContext) -> Result<Ablation, Failure> {
    let bases = CARRIERS.map(|carrier_hz| (carrier_hz, at(&request.scenario, carrier_hz)));
    for (carrier_hz, base) in &bases {
        base.check(&format!("ablation, {} GHz", carrier_hz / 1e9))?;
    }
    // `[effect][carrier][arm][seed]`
    let mut kept: Vec<Vec<[Vec<Marked>; 2]>> = vec![vec![Default::default(); CARRIERS.len()]; EFFECTS.len()];
    for seed in request.each_seed() {
        for (effect, of_effect) in EFFECTS.iter().zip(&mut kept) {
            for ((carrier_hz, base), found) in bases.iter().zip(of_effect) {
                for ((arm, word), found) in effect.arms(base)?.iter().zip(["with", "without"]).zip(found) {
                    let label = match arm == base {
                        true => "default".to_owned(),
                        false => format!("{}-{word}", effect.key()),
                    };
                    let name = name(&label, arm, *carrier_hz, seed);
                    found.push(cells.get(&name, || marked(arm, seed, context))?);
                }
            }
        }
    }
    let mut rows = Vec::new();
    for (effect, of_effect) in EFFECTS.iter().zip(&kept) {
        for ((carrier_hz, base), arms) in bases.iter().zip(of_effect) {
            for (n, &sensing_slots) in base.frame.sensing_slots.iter().enumerate() {
                let [with, without] = arms.each_ref().map(|arm| marks(arm, n));
                rows.push(Row {
                    effect: effect.name.into(),
                    carrier_hz: *carrier_hz,
                    sensing_slots,
                    with: spread(&with),
                    without: spread(&without),
                    difference: difference(&with, &without, request.seed),
                });
            }
        }
    }
    let tested = kept[0][0][0].first().and_then(|slots| slots.first()).map_or(0, String::len) as u32;
    let found = Ablation::of(tested, rows);
    cells.output.write_result("ablation.json", &found)?;
    cells.output.write("ablation.csv", found.csv().as_bytes())?;
    cells.output.write("ablation.md", table(request, &found).as_bytes())?;
    Ok(found)
}
