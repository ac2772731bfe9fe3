//! How long a sweep will take, said before it begins.

use super::budget;
use super::expected::{Work, say, seconds, slot};
use crate::dataset::Shard;
use crate::error::Invalid;
use crate::experiments::RunContext;
use crate::experiments::sweep::plan::Sweep;
use crate::results::Cell;
use crate::scenario::Scenario;
use crate::scenario::budget::Need;
use std::sync::Arc;

/// Notes the time that the cells of a shard will take, as if none were there yet, and refuses what is beyond the budget.
///
/// # Errors
///
/// More memory or time than the budget has.
pub(super) fn check(sweep: &Sweep, shard: Shard, context: RunContext) -> Result<(), Invalid> {
    let cells: Vec<&(Cell, Arc<Scenario>)> =
        sweep.cells.iter().filter(|(cell, _)| shard.has(cell.index)).collect();
    let Some((first, scenario)) = cells.first() else { return Ok(()) };
    for (_, scenario) in &cells {
        let tested = scenario.learning.test_per_class;
        context.budget.check_memory(&budget::training(scenario, tested, context.workers))?;
    }
    let slot = slot(scenario, first.rho, first.seed);
    let one = |(_, scenario): &(Cell, Arc<Scenario>)| {
        seconds(scenario, Work::Study(1), slot, context.workers) + budget::links_s(scenario)
    };
    let what = format!("{} cells, a training each", cells.len());
    let seconds = cells.iter().copied().map(one).sum();
    say(context.progress, seconds, context.workers, &what);
    context.budget.check_time(&[Need::new("cells of the shard", cells.len(), seconds)])
}
