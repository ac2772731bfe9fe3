//! How a training takes its steps: the optimiser and its learning rate.

use burn::optim::momentum::MomentumConfig;
use burn::optim::{AdamConfig, AdamWConfig, ModuleOptimizer, SgdConfig};

use crate::scenario::{Learning, Optimizer, Schedule};

/// Share of the steps in which the learning rate rises.
const WARM_UP: f64 = 0.3;
/// Peak over the first learning rate.
const START_DIVISOR: f64 = 25.0;
/// Peak over the last learning rate.
const END_DIVISOR: f64 = 1e4;

/// The optimiser of these settings, at its beginning.
pub fn optimizer(settings: &Learning) -> ModuleOptimizer {
    match settings.optimizer {
        Optimizer::Adamw => {
            AdamWConfig::new().with_epsilon(1e-8).with_weight_decay(settings.weight_decay as f32).init()
        }
        Optimizer::Adam => AdamConfig::new().with_epsilon(1e-8).init(),
        Optimizer::Momentum => {
            // burn's own default dampens by 0.1
            let momentum = MomentumConfig::new().with_momentum(0.9).with_dampening(0.0);
            SgdConfig::new().with_momentum(Some(momentum)).init()
        }
    }
}

/// Learning rate of the `step`-th of `steps` steps.
pub fn rate(settings: &Learning, step: usize, steps: usize) -> f64 {
    match settings.schedule {
        Schedule::Constant => settings.learning_rate,
        Schedule::OneCycle => one_cycle(step, steps, settings.learning_rate),
    }
}

/// Learning rate of a step: a rising half cosine, then a falling one.
pub fn one_cycle(step: usize, steps: usize, peak: f64) -> f64 {
    let half_cosine = |from: f64, to: f64, share: f64| {
        to + (from - to) * (1.0 + libm::cos(std::f64::consts::PI * share)) / 2.0
    };
    let position = (step as f64 + 0.5) / steps as f64;
    if position < WARM_UP {
        half_cosine(peak / START_DIVISOR, peak, position / WARM_UP)
    } else {
        half_cosine(peak, peak / END_DIVISOR, (position - WARM_UP) / (1.0 - WARM_UP))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_learning_rate_rises_to_its_peak_and_falls_to_nothing() {
        let rates: Vec<f64> = (0..1000).map(|s| one_cycle(s, 1000, 5e-3)).collect();
        assert!((rates[0] - 5e-3 / 25.0).abs() < 1e-7);
        assert!(rates[..300].is_sorted() && rates[300..].iter().rev().is_sorted());
        assert!((rates[300] - 5e-3).abs() < 1e-7 && (rates[999] - 5e-7).abs() < 1e-7);
    }
}
