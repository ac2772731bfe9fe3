//! From an item's name to its tasks, its file here, and its verdict.

use super::made::Made;
use super::work::{Task, Work};
use super::{
    Item, accuracy_over_epochs, channel_models, intensities, kl_divergence, learning_curve,
    learning_curve_models, region, spectrograms, training,
};
use crate::error::Failure;
use crate::experiments::seeds::seed_set;
use crate::report::panels::grid;
use crate::report::paper::draw;
use crate::results::{Reproduction, Verdict};

impl Item {
    /// What has to be computed for it.
    fn tasks(self, seeds: &[u64]) -> Vec<Task> {
        match self {
            Item::ChannelModels => channel_models::tasks(seeds),
            Item::Spectrograms => Vec::new(),
            Item::KlDivergence | Item::Intensities => kl_divergence::tasks(seeds),
            Item::AccuracyOverEpochs => accuracy_over_epochs::tasks(seeds),
            Item::Training | Item::LearningCurveModels | Item::Region => training::tasks(seeds),
            Item::LearningCurve => learning_curve::tasks(seeds),
        }
    }

    /// Makes it, with what is kept of earlier runs.
    ///
    /// # Errors
    ///
    /// Whatever a simulation, a training or the folder says.
    pub fn make(self, work: &Work<'_>) -> Result<Reproduction, Failure> {
        let made = match self {
            Item::ChannelModels => channel_models::make(work),
            Item::Spectrograms => spectrograms::make(work),
            Item::KlDivergence => kl_divergence::make(work),
            Item::Intensities => intensities::make(work),
            Item::AccuracyOverEpochs => accuracy_over_epochs::make(work),
            Item::Training => training::make(work),
            Item::LearningCurve => learning_curve::make(work),
            Item::LearningCurveModels => learning_curve_models::make(work),
            Item::Region => region::make(work),
        }?;
        work.finish(self, made)
    }
}

/// The tasks of items, each once.
pub fn tasks(items: &[Item], seeds: &[u64]) -> Vec<Task> {
    let mut all: Vec<Task> = Vec::new();
    for task in items.iter().flat_map(|item| item.tasks(seeds)) {
        if !all.contains(&task) {
            all.push(task);
        }
    }
    all
}

impl Work<'_> {
    /// Judges an item and writes its result and its figure.
    fn finish(&self, item: Item, made: Made) -> Result<Reproduction, Failure> {
        let name = item.name();
        let figures = if made.panels.is_empty() { Vec::new() } else { vec![name.clone()] };
        if !made.panels.is_empty() {
            draw(self.cells.output, &name, &grid(made.caption, made.columns, &made.panels))?;
        }
        let found = Reproduction {
            item: name.clone(),
            caption: made.caption.to_owned(),
            size: self.size.name().to_owned(),
            seed_set: seed_set(&self.seeds)?.to_owned(),
            seeds: self.seeds.clone(),
            verdict_as_printed: Verdict::NotTestable,
            verdict: Verdict::NotTestable,
            numbers: made.numbers,
            statements: made.statements,
            notes: made.notes,
            figures,
        }
        .judged();
        self.cells.output.write_result(&format!("{name}.json"), &found)?;
        Ok(found)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::ValueEnum;

    #[test]
    fn every_item_has_a_name_of_its_own_and_tasks_are_not_repeated() {
        let items = Item::value_variants();
        let names: std::collections::BTreeSet<String> = items.iter().map(|item| item.name()).collect();
        assert_eq!(names.len(), items.len());
        let all = tasks(items, &[101, 102]);
        for (k, task) in all.iter().enumerate() {
            assert!(!all[k + 1..].contains(task), "{task:?}");
        }
        assert_eq!(all.len(), 2 * tasks(items, &[101]).len());
    }
}
