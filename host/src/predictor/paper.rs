//! The paper's own learning curve: its points (read back from its figure) and Table III.

use super::models::Model;

/// Accuracy at 200, 300, 400, 500, 600 and 1000 slots; the printed parameters give the printed errors on these.
pub const POINTS: [(u32, f64); 6] =
    [(200, 0.7885), (300, 0.9016), (400, 0.9142), (500, 0.9309), (600, 0.9292), (1000, 0.9554)];

/// A row of Table III.
#[derive(Debug, Clone, Copy)]
pub struct Printed {
    /// Model.
    pub model: Model,
    /// Parameters in the order alpha, beta, gamma, epsilon; exp4's exponent and ceiling are swapped back, pow4's exponent has
    /// Table II's sign.
    pub parameters: &'static [f64],
    /// Printed error: a sum of squares, though the table calls it a mean.
    pub sse: f64,
    /// Whether the printed parameters give the printed error on [`POINTS`]; pow4's do not.
    pub consistent: bool,
}

/// Table III, best first as printed.
pub const TABLE_III: [Printed; 7] = [
    Printed { model: Model::Pow3, parameters: &[6.1906e4, 2.4297, 0.9499], sse: 3.383e-4, consistent: true },
    Printed {
        model: Model::LogPower,
        parameters: &[0.9460, 4.7438, -2.9235],
        sse: 3.7018e-4,
        consistent: true,
    },
    Printed {
        model: Model::Exp4,
        parameters: &[2.9129, 6.9568, 0.2082, 0.9576],
        sse: 5.4693e-4,
        consistent: true,
    },
    Printed { model: Model::VaporPressure, parameters: &[0.0117, -44.5180], sse: 0.0017, consistent: true },
    Printed { model: Model::Ilog2, parameters: &[3.5228, 1.4863], sse: 0.003, consistent: true },
    Printed { model: Model::LogLogLinear, parameters: &[0.2347, 1.0423], sse: 0.0038, consistent: true },
    Printed {
        model: Model::Pow4,
        parameters: &[98.4911, -9.5892e3, 1.2176, 0.1117],
        sse: 0.0065,
        consistent: false,
    },
];

/// The printed row of a model.
pub fn printed(model: Model) -> Option<&'static Printed> {
    TABLE_III.iter().find(|row| row.model == model)
}
