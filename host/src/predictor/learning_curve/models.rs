//! The seven learning curves of Table II.
//!
//! Each is linear or nearly so in some parameters: `shape` parameters are searched, the rest follow by least squares.

use crate::results::Parameters;

/// A parametric learning curve.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Model {
    /// exp(alpha + beta / N).
    VaporPressure,
    /// gamma - alpha N^-beta.
    Pow3,
    /// alpha / (1 + (N / e^beta)^gamma).
    LogPower,
    /// epsilon - exp(-alpha N^gamma + beta): exponent gamma and ceiling epsilon as in the paper's Table III.
    Exp4,
    /// ln(alpha ln N + beta).
    LogLogLinear,
    /// beta - alpha / ln N.
    Ilog2,
    /// gamma - (alpha N + beta)^-epsilon.
    Pow4,
}

impl Model {
    /// All models, in the paper's order.
    pub const ALL: [Model; 7] = [
        Model::VaporPressure,
        Model::Pow3,
        Model::LogPower,
        Model::Exp4,
        Model::LogLogLinear,
        Model::Ilog2,
        Model::Pow4,
    ];

    /// Name in files and on pages.
    pub fn name(self) -> &'static str {
        match self {
            Model::VaporPressure => "vapor_pressure",
            Model::Pow3 => "pow3",
            Model::LogPower => "log_power",
            Model::Exp4 => "exp4",
            Model::LogLogLinear => "log_log_linear",
            Model::Ilog2 => "ilog2",
            Model::Pow4 => "pow4",
        }
    }

    /// The model of that name.
    pub fn by_name(name: &str) -> Option<Model> {
        Model::ALL.into_iter().find(|model| model.name() == name)
    }

    /// Number of parameters.
    pub fn count(self) -> usize {
        match self {
            Model::VaporPressure | Model::LogLogLinear | Model::Ilog2 => 2,
            Model::Pow3 | Model::LogPower => 3,
            Model::Exp4 | Model::Pow4 => 4,
        }
    }

    /// Packs numbers in the order alpha, beta, gamma, epsilon.
    pub fn parameters(self, p: &[f64]) -> Parameters {
        let get = |i: usize| (i < self.count()).then(|| p.get(i).copied().unwrap_or(0.0));
        Parameters {
            alpha: get(0).unwrap_or(0.0),
            beta: get(1).unwrap_or(0.0),
            gamma: get(2),
            epsilon: get(3),
        }
    }

    /// A(N), not clamped; NaN outside the model's domain.
    pub fn at(self, p: &Parameters, n: f64) -> f64 {
        let (a, b) = (p.alpha, p.beta);
        let (g, e) = (p.gamma.unwrap_or(0.0), p.epsilon.unwrap_or(0.0));
        match self {
            Model::VaporPressure => libm::exp(a + b / n),
            Model::Pow3 => g - a * libm::pow(n, -b),
            Model::LogPower => a / (1.0 + libm::pow(n / libm::exp(b), g)),
            Model::Exp4 => e - libm::exp(-a * libm::pow(n, g) + b),
            Model::LogLogLinear => libm::log(a * libm::log(n) + b),
            Model::Ilog2 => b - a / libm::log(n),
            Model::Pow4 => g - libm::pow(a * n + b, -e),
        }
    }

    /// Starting points of the local search for accuracies between `low` (at `n_low`) and `high`.
    pub fn starts(self, n_low: f64, low: f64, high: f64) -> Vec<Vec<f64>> {
        let ceilings = [0.002, 0.01, 0.03, 0.1].map(|over| (high + over).min(1.0));
        let rises = [0.3, 0.6, 1.0, 1.5, 2.0, 2.5, 3.5];
        let gap = |ceiling: f64| (ceiling - low).max(1e-4);
        let mut starts = Vec::new();
        match self {
            Model::VaporPressure => {
                starts.push(vec![
                    libm::log(high.max(1e-3)),
                    -n_low * libm::log((high / low.max(1e-3)).max(1.001)),
                ]);
            }
            Model::LogLogLinear => {
                starts.extend([0.05, 0.2, 0.5].map(|a| vec![a, libm::exp(low) - a * libm::log(n_low)]));
            }
            Model::Ilog2 => starts.extend([0.5, 2.0, 4.0].map(|a| vec![a, low + a / libm::log(n_low)])),
            Model::Pow3 | Model::LogPower | Model::Exp4 | Model::Pow4 => {
                for ceiling in ceilings {
                    for rise in rises {
                        starts.push(match self {
                            Model::Pow3 => vec![gap(ceiling) * libm::pow(n_low, rise), rise, ceiling],
                            Model::LogPower => {
                                let odds = (ceiling / low.max(1e-3) - 1.0).max(1e-3);
                                vec![ceiling, libm::log(n_low) + libm::log(odds) / rise, -rise]
                            }
                            Model::Exp4 => {
                                let exponent = 0.15 * rise;
                                let alpha = rise / libm::pow(n_low, exponent) / exponent;
                                vec![
                                    alpha,
                                    libm::log(gap(ceiling)) + alpha * libm::pow(n_low, exponent),
                                    exponent,
                                    ceiling,
                                ]
                            }
                            _ => {
                                // (alpha N + beta)^-epsilon through the lowest point
                                let base = libm::pow(gap(ceiling), -1.0 / rise);
                                vec![base / n_low, 0.0, ceiling, rise]
                            }
                        });
                    }
                }
            }
        }
        starts
    }
}
