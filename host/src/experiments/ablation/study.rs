//! The trainings of the ablation study, cell by cell: a carrier, a seed and a scenario with or without an effect.

use super::effects::{CARRIERS, EFFECTS, at};
use super::paired::difference;
use super::{Ablation, Row, table};
use crate::error::Failure;
use crate::experiments::cells::Cells;
use crate::experiments::trained::{images, train};
use crate::experiments::{Request, RunContext};
use crate::network::evaluation::test;
use crate::network::spectrograms::Part;
use crate::results::Spread;
use crate::scenario::Scenario;
use crate::simulator::calibration::rho_of;
use crate::store::digest::sha256;

/// For every N_s a character a test recording: 1 if its class was recognised.
type Kept = Vec<String>;

/// Recognised or not, `[sensing_slots][recording]`.
fn answers(scenario: &Scenario, seed: u64, context: RunContext) -> Result<Kept, Failure> {
    let rho = rho_of(scenario);
    let trained = train(scenario, seed, &images(scenario, rho, seed, Part::Train, context), context)?;
    let shown = images(scenario, rho, seed, Part::Test, context);
    let slots = &scenario.frame.sensing_slots;
    let tested = test(&trained.parameters, &trained.models, slots, &shown.images)?;
    let each = tested.iter().zip(&shown.images);
    let marks = each.map(|(tested, images)| {
        let pairs = tested.int8.iter().zip(&images.labels);
        pairs.map(|(answer, label)| if answer == label { '1' } else { '0' }).collect()
    });
    Ok(marks.collect())
}

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
    let mut kept: Vec<Vec<[Vec<Kept>; 2]>> = vec![vec![Default::default(); CARRIERS.len()]; EFFECTS.len()];
    for seed in request.each_seed() {
        for (effect, of_effect) in EFFECTS.iter().zip(&mut kept) {
            for ((carrier_hz, base), found) in bases.iter().zip(of_effect) {
                for ((arm, word), found) in effect.arms(base)?.iter().zip(["with", "without"]).zip(found) {
                    let label = match arm == base {
                        true => "default".to_owned(),
                        false => format!("{}-{word}", effect.key()),
                    };
                    let name = name(&label, arm, *carrier_hz, seed);
                    found.push(cells.get(&name, || answers(arm, seed, context))?);
                }
            }
        }
    }
    let mut rows = Vec::new();
    for (effect, of_effect) in EFFECTS.iter().zip(&kept) {
        for ((carrier_hz, base), arms) in bases.iter().zip(of_effect) {
            for (n, &sensing_slots) in base.frame.sensing_slots.iter().enumerate() {
                let marks = |arm: &[Kept]| -> Vec<Vec<bool>> {
                    arm.iter().map(|kept| kept[n].chars().map(|mark| mark == '1').collect()).collect()
                };
                let [with, without] = [marks(&arms[0]), marks(&arms[1])];
                let share = |marks: &Vec<bool>| {
                    marks.iter().filter(|mark| **mark).count() as f64 / marks.len().max(1) as f64
                };
                let spread = |marks: &[Vec<bool>]| Spread::of(&marks.iter().map(share).collect::<Vec<_>>());
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
