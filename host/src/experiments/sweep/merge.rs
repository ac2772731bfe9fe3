//! Merging: every cell is there, whole and of this plan, or nothing is written; a partial merge takes the cells that are there.
//!
//! `merged.csv` has a row a cell, in the plan's order, with the throughput of every placement. `merged.json`, written last, has the cells with all placements, and of every scenario, carrier and rho what the seeds say together: the learning curve
//! through their int8 means, the zones, and the operating point by the scenario's weight.

use super::plan::{PLAN, Sweep};
use super::store::Store;
use crate::PROGRAM;
use crate::error::Failure;
use crate::formats::table;
use crate::optimizer::{Rule, cases};
use crate::predictor::{best_curve, fit_all};
use crate::results::{
    Cell, CurvePoint, Group, GroupPoint, Measurement, Merged, PointThroughput, Spread, Throughput,
};
use crate::scenario::{Class, Scenario};
use crate::store::output::Output;
use crate::store::record::Fault;
use std::fmt::Write;
use std::path::{Path, PathBuf};

/// The table of cells.
pub const CSV: &str = "merged.csv";
pub const JSON: &str = "merged.json";
/// The same of a partial merge.
pub const PARTIAL: [&str; 2] = ["partial.csv", "partial.json"];

/// Cells named in a refusal, of each kind.
const NAMED: usize = 8;

/// Why a sweep cannot be merged.
#[derive(Debug, thiserror::Error)]
pub enum MergeError {
    /// The folder holds no sweep.
    #[error("{folder}: no sweep: {PLAN} is missing; `sdp3 sweep PLAN.toml --out {folder}` makes it")]
    None { folder: PathBuf },
    /// Cells are missing, damaged or foreign.
    #[error(
        "{folder}: {faulty} of {cells} cells cannot be used:{list}\n  `sdp3 sweep {folder}/{PLAN} --out {folder}` makes what is missing or \
         damaged; remove what is foreign; --partial joins the others"
    )]
    Cells {
        folder: PathBuf,
        /// Files that cannot be used.
        faulty: usize,
        /// Cells of the plan.
        cells: usize,
        /// Each with its reason, a line each.
        list: String,
    },
}

/// Checks every cell of a folder and puts them together, and writes both files. A `partial` merge does without missing and damaged
/// cells.
///
/// # Errors
///
/// [`MergeError`], naming what is wrong; a folder that cannot be written. Then neither file is written.
pub fn merge(folder: &Path, partial: bool) -> Result<Merged, Failure> {
    let plan = folder.join(PLAN);
    if !plan.exists() {
        return Err(MergeError::None { folder: folder.to_owned() }.into());
    }
    // a resolved plan leaves nothing out that another seed could fill in
    let sweep = Sweep::load(&plan, None, None)?;
    let (cells, missing) = read(&sweep, folder, partial)?;
    let output = Output::create(folder)?;
    let groups = groups(&sweep, &cells)?;
    let merged = Merged {
        name: sweep.plan.name.clone(),
        program: PROGRAM.into(),
        plan: sweep.digest.clone(),
        chance: 1.0 / Class::ALL.len() as f64,
        cells,
        missing,
        groups,
    };
    let [csv, json] = if partial { PARTIAL } else { [CSV, JSON] };
    output.write(csv, rows(&merged, &sweep).as_bytes())?;
    output.write_result(json, &merged)?;
    Ok(merged)
}

/// The cells that can be used, and those that a partial merge does without.
fn read(sweep: &Sweep, folder: &Path, partial: bool) -> Result<(Vec<Measurement>, Vec<Cell>), Failure> {
    let store = Store::of(sweep, folder);
    let (mut found, mut missing) = (Vec::new(), Vec::new());
    let (mut list, mut faulty) = (String::new(), 0);
    let mut name = |line: String| {
        faulty += 1;
        if faulty <= NAMED {
            let _ = write!(list, "\n  {line}");
        }
    };
    for (cell, _) in &sweep.cells {
        match store.read(cell)? {
            Ok(measurement) => found.push(measurement),
            Err(Fault::Missing | Fault::Damaged(_)) if partial => missing.push(cell.clone()),
            Err(fault) => name(format!("{}: {fault} ({})", store.path(cell).display(), words(cell))),
        }
    }
    for file in store.unexpected_files()? {
        let path = folder.join(super::store::CELLS).join(file);
        name(format!("{}: foreign: the plan has the cells 0 to {}", path.display(), sweep.cells.len() - 1));
    }
    if partial && faulty == 0 && found.is_empty() {
        return Err(format!("{}: no cell is there", folder.display()).into());
    }
    if faulty == 0 {
        return Ok((found, missing));
    }
    if faulty > NAMED {
        let _ = write!(list, "\n  and {} more", faulty - NAMED);
    }
    Err(MergeError::Cells { folder: folder.to_owned(), faulty, cells: sweep.cells.len(), list }.into())
}

fn words(cell: &Cell) -> String {
    let Cell { scenario, carrier_hz, rho, sensing_slots, seed, .. } = cell;
    format!("{scenario}, carrier_hz = {carrier_hz}, rho = {rho}, N_s = {sensing_slots}, seed {seed}")
}

/// A row for every cell.
fn rows(merged: &Merged, sweep: &Sweep) -> String {
    let cases = merged.cells.iter().map(|m| m.throughput.len()).max().unwrap_or(0);
    let cell = ["cell", "scenario", "carrier_hz", "rho", "sensing_slots", "seed"];
    let per_case = |what: &'static str| (1..=cases).map(move |case| format!("{what}_{case}"));
    let throughputs: Vec<String> = per_case("throughput_bit").chain(per_case("throughput_mbit_s")).collect();
    let header = cell.into_iter().chain(["float", "int8", "tested", "chance"]);
    let header: Vec<&str> = header.chain(throughputs.iter().map(String::as_str)).collect();
    let row = |Measurement { cell, accuracy, throughput }: &Measurement| {
        let Cell { index, scenario, carrier_hz, rho, sensing_slots, seed } = cell;
        let of_case = |case: usize, over: f64| {
            throughput
                .get(case)
                .map_or_else(String::new, |t: &Throughput| (t.throughput_bit / over).to_string())
        };
        let second = 1e6 * sweep.cells[*index as usize].1.period_s();
        let rates = [1.0, second].into_iter().flat_map(|over| (0..cases).map(move |case| (case, over)));
        let numbers = [carrier_hz.to_string(), rho.to_string(), sensing_slots.to_string(), seed.to_string()];
        let found =
            [accuracy.float, accuracy.int8, f64::from(accuracy.tested), merged.chance].map(|x| x.to_string());
        let named = [index.to_string(), scenario.clone()];
        named
            .into_iter()
            .chain(numbers)
            .chain(found)
            .chain(rates.map(|(case, over)| of_case(case, over)))
            .collect()
    };
    table::csv(&header, merged.cells.iter().map(row))
}

/// What the seeds say together, scenario by carrier by rho.
fn groups(sweep: &Sweep, cells: &[Measurement]) -> Result<Vec<Group>, Failure> {
    let key = |cell: &Cell| (cell.scenario.clone(), cell.carrier_hz.to_bits(), cell.rho.to_bits());
    let mut groups = Vec::new();
    for members in cells.chunk_by(|a, b| key(&a.cell) == key(&b.cell)) {
        let first = &members[0].cell;
        let scenario = &sweep.cells[first.index as usize].1;
        let by_slots = members.chunk_by(|a, b| a.cell.sensing_slots == b.cell.sensing_slots);
        let points: Vec<GroupPoint> = by_slots.map(|seeds| point(seeds, scenario)).collect();
        let mut fitted: Vec<CurvePoint> = points.iter().map(GroupPoint::curve_point).collect();
        fitted.sort_by(|a, b| a.sensing_slots.total_cmp(&b.sensing_slots));
        // too few N_s for a curve are no fault of the sweep
        let curve = fit_all(&fitted).ok().map(|prediction| best_curve(&prediction));
        let cases = match &curve {
            Some(curve) => cases(
                curve,
                &fitted,
                scenario,
                Rule::Weighted(scenario.optimizer.accuracy_weight),
                first.seed,
            )?,
            None => Vec::new(),
        };
        let (carrier_hz, rho) = (first.carrier_hz, first.rho);
        let channels = scenario.communication.channels().to_owned();
        groups.push(Group {
            scenario: first.scenario.clone(),
            carrier_hz,
            rho,
            spacing_slots: scenario.frame.spacing_slots,
            points,
            curve,
            cases,
            channels,
        });
    }
    Ok(groups)
}

/// The seeds of one N_s.
fn point(seeds: &[Measurement], scenario: &Scenario) -> GroupPoint {
    let spread = |of: fn(&Measurement) -> f64| Spread::of(&seeds.iter().map(of).collect::<Vec<_>>());
    let throughput = |case: usize| {
        let bits = |m: &Measurement| m.throughput.get(case).map_or(0.0, |t| t.throughput_bit);
        let throughput_bit = seeds.iter().map(bits).sum::<f64>() / seeds.len() as f64;
        let period_s = f64::from(scenario.frame.period_slots) * scenario.frame.slot_s;
        PointThroughput {
            case: seeds[0].throughput[case].case,
            throughput_bit,
            throughput_bit_s: throughput_bit / period_s,
        }
    };
    GroupPoint {
        sensing_slots: seeds[0].cell.sensing_slots,
        float: spread(|m| m.accuracy.float),
        int8: spread(|m| m.accuracy.int8),
        seeds: seeds.len() as u32,
        tested: seeds.iter().map(|m| m.accuracy.tested).sum(),
        throughput: (0..seeds[0].throughput.len()).map(throughput).collect(),
    }
}
