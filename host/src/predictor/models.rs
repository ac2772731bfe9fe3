//! The seven learning curves of Table II, their values and their slopes.

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

    /// dA/dN, not clamped; NaN outside the model's domain.
    pub fn slope(self, p: &Parameters, n: f64) -> f64 {
        let (a, b) = (p.alpha, p.beta);
        let (g, e) = (p.gamma.unwrap_or(0.0), p.epsilon.unwrap_or(0.0));
        match self {
            Model::VaporPressure => -b / (n * n) * libm::exp(a + b / n),
            Model::Pow3 => a * b * libm::pow(n, -b - 1.0),
            Model::LogPower => {
                let y = libm::pow(n / libm::exp(b), g);
                // a y / (1 + y)^2, safe for large y
                -a * g / n / (1.0 + y) / (1.0 + 1.0 / y)
            }
            Model::Exp4 => a * g * libm::pow(n, g - 1.0) * libm::exp(-a * libm::pow(n, g) + b),
            Model::LogLogLinear => a / n / (a * libm::log(n) + b),
            Model::Ilog2 => a / n / (libm::log(n) * libm::log(n)),
            Model::Pow4 => a * e * libm::pow(a * n + b, -e - 1.0),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slopes_are_the_derivatives() {
        let cases: [(Model, &[f64]); 7] = [
            (Model::VaporPressure, &[0.0117, -44.5180]),
            (Model::Pow3, &[6.1906e4, 2.4297, 0.9499]),
            (Model::LogPower, &[0.9460, 4.7438, -2.9235]),
            (Model::Exp4, &[2.9129, 6.9568, 0.2082, 0.9576]),
            (Model::LogLogLinear, &[0.2347, 1.0423]),
            (Model::Ilog2, &[3.5228, 1.4863]),
            (Model::Pow4, &[0.03, -2.0, 1.0, 0.9]),
        ];
        for (model, p) in cases {
            let p = model.parameters(p);
            for n in [130.0, 200.0, 555.0, 1000.0] {
                let numerical = (model.at(&p, n + 0.01) - model.at(&p, n - 0.01)) / 0.02;
                assert!((model.slope(&p, n) / numerical - 1.0).abs() < 1e-6, "{} {n}", model.name());
            }
        }
    }
}
