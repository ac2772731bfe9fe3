//! What quantisation cost: range, error and clipped share of every activation.
//!
//! Float and int8 networks run side by side on the calibration images; int8 is fake-quantised in floating point.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::fmt::Write as _;

use crate::network::calibration::{ActivationQuant, QuantParams, Rule, assemble, position};
use crate::network::float_network::{Activation, FloatNetwork};
use crate::network::parameters::Images;

/// What int8 did to one activation.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct LayerReport {
    /// The activation, in words.
    pub name: String,
    /// Smallest number its grid holds.
    pub low: f64,
    /// Largest number its grid holds.
    pub high: f64,
    /// Its grid.
    pub grid: QuantParams,
    /// Power of the float activation over the power of its error, all earlier layers in int8 too, in dB.
    pub sqnr_db: f64,
    /// Share of its values beyond the grid's ends, 0 to 1.
    pub clipped: f64,
}

/// What quantisation did.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct QuantizationReport {
    /// Images the ranges come from.
    pub images: usize,
    /// The rule that was kept.
    pub rule: Rule,
    /// Cross entropy of the float network on them, in nats.
    pub float_loss: f64,
    /// Cross entropy of the fake-quantised int8 network under each rule, in nats.
    pub int8_loss: Vec<(Rule, f64)>,
    /// Where the network was tuned: the better of these losses before.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub loss_before_qat: Option<f64>,
    /// Every activation under the rule that was kept.
    pub layers: Vec<LayerReport>,
}

impl QuantizationReport {
    /// Cross entropy of int8 under the rule that was kept, in nats.
    pub fn least_loss(&self) -> f64 {
        self.int8_loss.iter().map(|&(_, loss)| loss).fold(f64::INFINITY, f64::min)
    }

    /// What int8 adds to the float network's cross entropy, in nats.
    pub fn cost(&self) -> f64 {
        self.least_loss() - self.float_loss
    }

    /// The activation_quant that were kept.
    pub fn activation_quant(&self) -> ActivationQuant {
        let activation_quant: Vec<QuantParams> = self.layers.iter().map(|layer| layer.grid).collect();
        assemble(&activation_quant, (activation_quant.len() - 4) / 4)
    }

    /// The report as a table: range, step, error and clipped share of every activation.
    pub fn table(&self) -> String {
        let mut text = format!(
            "{:<16}{:>11}{:>11}{:>12}{:>9}{:>10}",
            "activation", "low", "high", "step", "SQNR dB", "clipped"
        );
        for l in &self.layers {
            let _ = write!(
                text,
                "\n{:<16}{:>11.4}{:>11.4}{:>12.3e}{:>9.1}{:>9.3}%",
                l.name,
                l.low,
                l.high,
                l.grid.scale,
                l.sqnr_db,
                100.0 * l.clipped
            );
        }
        text
    }
}

/// Float and fake-quantised activations side by side.
pub(super) fn compare(
    float: &FloatNetwork,
    fake_quantised: &FloatNetwork,
    activation_quant: &ActivationQuant,
    images: &Images,
) -> Vec<LayerReport> {
    let blocks = float.architecture.blocks;
    let count = position(Activation::Logits, blocks) + 1;
    let mut tallies = vec![Tally::default(); count];
    let mut order = Vec::with_capacity(count);
    for i in 0..images.len() {
        let mut exact: Vec<Vec<f32>> = Vec::with_capacity(count);
        order.clear();
        float.forward(images.image(i), images.rows, &mut |activation, values| {
            order.push(activation);
            exact.push(values.to_vec());
        });
        fake_quantised.forward(images.image(i), images.rows, &mut |activation, values| {
            let at = position(activation, blocks);
            tallies[at].round(activation_quant.of(activation), values, &exact[at]);
        });
    }
    order.iter().zip(tallies).map(|(&activation, tally)| tally.report(activation, activation_quant)).collect()
}

/// Sums over all values of an activation.
#[derive(Clone, Default)]
struct Tally {
    signal: f64,
    error: f64,
    beyond: u64,
    values: u64,
}

impl Tally {
    /// Rounds int8's values to their grid and compares them with the float ones.
    fn round(&mut self, grid: QuantParams, values: &mut [f32], exact: &[f32]) {
        let (low, high) = grid.range();
        let half = 0.5 * grid.scale;
        for (v, &e) in values.iter_mut().zip(exact) {
            self.beyond += u64::from(*v < low - half || *v > high + half);
            *v = grid.round(*v);
            self.signal += f64::from(e).powi(2);
            self.error += f64::from(e - *v).powi(2);
        }
        self.values += values.len() as u64;
    }

    fn report(&self, activation: Activation, activation_quant: &ActivationQuant) -> LayerReport {
        let grid = activation_quant.of(activation);
        let (low, high) = grid.range();
        // An activation without error counts as one with the error of a double's last bit.
        let signal = self.signal.max(f64::MIN_POSITIVE);
        let error = self.error.max(signal * f64::EPSILON * f64::EPSILON);
        LayerReport {
            name: in_words(activation),
            low: f64::from(low),
            high: f64::from(high),
            grid,
            sqnr_db: 10.0 * libm::log10(signal / error),
            clipped: self.beyond as f64 / self.values.max(1) as f64,
        }
    }
}

fn in_words(activation: Activation) -> String {
    match activation {
        Activation::Input => "input".into(),
        Activation::Stem => "stem".into(),
        Activation::BatchNorm(b) => format!("block {b} batch norm"),
        Activation::Conv1(b) => format!("block {b} conv1"),
        Activation::Conv2(b) => format!("block {b} conv2"),
        Activation::Add(b) => format!("block {b} add"),
        Activation::Mean => "mean".into(),
        Activation::Logits => "logits".into(),
    }
}
