//! The trainings of the ablation study, cell by cell: a carrier, a seed and a scenario with or without an effect.

use super::effects::{EFFECTS, at};
use super::{Ablation, Row, table};
use crate::error::Failure;
use crate::experiments::carriers::CARRIERS_HZ;
use crate::experiments::cells::Cells;
use crate::experiments::paired::{difference, spread};
use crate::experiments::trained::{Marked, marked, marks};
use crate::experiments::{Request, RunContext};
use crate::scenario::Scenario;
use crate::store::digest::sha256;

/// Scenarios that differ in `spectrogram` alone: their recordings are the same, and they are one cell.
type Group = Vec<Scenario>;

/// The scenarios of all effects, each once.
fn groups<'a>(arms: impl Iterator<Item = &'a Scenario>) -> Vec<Group> {
    let mut groups: Vec<Group> = Vec::new();
    for arm in arms {
        let same = |one: &Scenario| Scenario { spectrogram: arm.spectrogram.clone(), ..one.clone() } == *arm;
        match groups.iter_mut().find(|group| same(&group[0])) {
            Some(group) if group.contains(arm) => (),
            Some(group) => group.push(arm.clone()),
            None => groups.push(vec![arm.clone()]),
        }
    }
    groups
}

/// The cell of a group; its name has the scenarios' digest, so that a changed effect is another cell.
fn name(group: &Group, carrier_hz: f64, seed: u64) -> String {
    let texts: Vec<String> = group.iter().map(Scenario::to_toml).collect();
    format!("seed-{seed}-{}ghz-{}", carrier_hz / 1e9, &sha256(texts.iter().map(String::as_bytes))[..12])
}

/// Runs or goes on. The scenario that an effect leaves as it is, is trained once for all effects.
///
/// # Errors
///
/// Whatever a training, an effect's scenario or the folder says.
pub fn study(request: &Request, cells: &Cells, context: RunContext) -> Result<Ablation, Failure> {
    let mut bases = Vec::new();
    for carrier_hz in CARRIERS_HZ {
        let base = at(&request.scenario, carrier_hz);
        base.check(&format!("ablation, {} GHz", carrier_hz / 1e9))?;
        let arms = EFFECTS.iter().map(|effect| effect.arms(&base)).collect::<Result<Vec<_>, _>>()?;
        bases.push((carrier_hz, base, arms));
    }
    // `[effect][carrier][arm][seed]`
    let mut kept: Vec<Vec<[Vec<Marked>; 2]>> =
        vec![vec![Default::default(); CARRIERS_HZ.len()]; EFFECTS.len()];
    for seed in request.each_seed() {
        for (c, (carrier_hz, _, arms)) in bases.iter().enumerate() {
            for group in groups(arms.iter().flatten()) {
                let found = cells.get(&name(&group, *carrier_hz, seed), || marked(&group, seed, context))?;
                for (arms, of_effect) in arms.iter().zip(&mut kept) {
                    for (arm, kept) in arms.iter().zip(&mut of_effect[c]) {
                        let place = group.iter().position(|scenario| scenario == arm);
                        kept.extend(place.and_then(|place| found.get(place)).cloned());
                    }
                }
            }
        }
    }
    let mut rows = Vec::new();
    for (effect, of_effect) in EFFECTS.iter().zip(&kept) {
        for ((carrier_hz, base, _), arms) in bases.iter().zip(of_effect) {
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
