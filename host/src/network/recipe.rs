//! Ways to train, by name: optimiser, learning rate, batch and augmentation as one choice.

use crate::scenario::{Learning, Optimizer, Schedule};
use serde::{Deserialize, Serialize};

/// A way to train.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Recipe {
    /// AdamW, peak 5e-3, one cycle, batch 50: what learns best here.
    AdamwOneCycle,
    /// The paper's first: Adam, 0.01, batch 500.
    PaperAdam,
    /// The paper's second: momentum 0.9, 0.06, batch 300.
    PaperMomentum,
}

impl Recipe {
    /// Sets what the recipe says and leaves the rest.
    pub fn apply(self, settings: &mut Learning) {
        let (optimizer, schedule, learning_rate, batch, weight_decay) = match self {
            Recipe::AdamwOneCycle => (Optimizer::Adamw, Schedule::OneCycle, 5e-3, 50, 1e-2),
            Recipe::PaperAdam => (Optimizer::Adam, Schedule::Constant, 0.01, 500, 0.0),
            Recipe::PaperMomentum => (Optimizer::Momentum, Schedule::Constant, 0.06, 300, 0.0),
        };
        let rest = settings.clone();
        *settings = Learning {
            optimizer,
            schedule,
            learning_rate,
            batch,
            weight_decay,
            mixup: 0.0,
            mask_rows: 0,
            ..rest
        };
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_default_is_a_recipe_and_the_others_are_the_papers() {
        let mut settings = Learning::default();
        Recipe::AdamwOneCycle.apply(&mut settings);
        assert_eq!(settings, Learning::default());
        Recipe::PaperMomentum.apply(&mut settings);
        assert_eq!((settings.learning_rate, settings.batch), (0.06, 300));
        assert_eq!((settings.mixup, settings.mask_rows), (0.0, 0));
        Recipe::PaperAdam.apply(&mut settings);
        assert_eq!((settings.learning_rate, settings.batch), (0.01, 500));
    }
}
