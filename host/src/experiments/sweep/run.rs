//! Running a shard: cell after cell, each kept as soon as it is known, none made twice.

use super::cell::measure;
use super::plan::Sweep;
use super::store::Store;
use crate::dataset::Shard;
use crate::error::Failure;
use crate::experiments::RunContext;
use crate::results::{Cell, Swept};
use crate::scenario::Scenario;
use crate::store::output::Output;
use crate::store::record::Fault;
use std::sync::Arc;

/// Makes what is missing of a shard's cells. A damaged cell is made again; a foreign one is refused before anything is made.
///
/// # Errors
///
/// A folder or a cell of another sweep; whatever a cell says; files that cannot be written.
pub fn run(sweep: &Sweep, shard: Shard, output: &Output, context: RunContext) -> Result<Swept, Failure> {
    sweep.open(output)?;
    let store = Store::of(sweep, output.folder());
    let (mut made, mut kept) = (0, 0);
    for (cell, _) in mine(sweep, shard) {
        if let Err(fault @ Fault::Foreign(_)) = store.read(cell)? {
            return Err(fault.refusal(&store.path(cell), "use another --out, or remove this file").into());
        }
    }
    let total = mine(sweep, shard).count();
    for (number, (cell, scenario)) in mine(sweep, shard).enumerate() {
        match store.read(cell)? {
            Ok(_) => {
                kept += 1;
                continue;
            }
            Err(Fault::Missing) => (),
            Err(fault) => {
                let text = format!("{} is made again: {fault}", store.path(cell).display());
                context.progress.note("sweep", &text);
            }
        }
        let text = format!(
            "cell {} of {total} of shard {shard}: {}, {:.3} GHz, rho = {}, N_s = {}, seed {}",
            number + 1,
            cell.scenario,
            cell.carrier_hz / 1e9,
            cell.rho,
            cell.sensing_slots,
            cell.seed
        );
        context.progress.note("sweep", &text);
        store.keep(output, &measure(cell, scenario, context)?)?;
        made += 1;
    }
    let mut missing = 0;
    for (cell, _) in &sweep.cells {
        missing += u32::from(!store.path(cell).exists());
    }
    let cells = sweep.cells.len() as u32;
    Ok(Swept { plan: sweep.digest.clone(), shard: shard.to_string(), cells, made, kept, missing })
}

fn mine(sweep: &Sweep, shard: Shard) -> impl Iterator<Item = &(Cell, Arc<Scenario>)> {
    sweep.cells.iter().filter(move |(cell, _)| shard.has(cell.index))
}
