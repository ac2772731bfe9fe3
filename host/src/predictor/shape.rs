//! What of a curve has to be searched, and where: one or two shape parameters in a box; the rest follows by least squares.
//!
//! Every model is u + v phi(N) with phi increasing, 0 at the least N_s for those with a ceiling. The shapes are written so that
//! the box holds exactly the curves that section IV-B of the paper admits: increasing (property i), with a slope that falls
//! from the first point on (property ii), without a pole from [`LEAST`] on.

use super::models::Model;

/// The fewest sensing slots a curve is asked about: one window of the spectrogram.
pub const LEAST: f64 = 128.0;

/// How u and v are tied to the model.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Ties {
    /// Both free, v >= 0.
    Free,
    /// u = 0.
    Proportional,
    /// v = 1.
    Offset,
}

/// A curve's shape: a model anchored at its least N_s with its searched parameters.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Shape {
    model: Model,
    /// Least N_s of the points.
    low: f64,
    /// First parameter: the power, slope, or decay at `low`.
    r: f64,
    q: f64,
}

fn between(low: f64, high: f64, t: f64) -> f64 {
    libm::exp(libm::log(low) + (libm::log(high) - libm::log(low)) * t)
}

impl Shape {
    /// Number of searched parameters.
    pub fn dimensions(model: Model) -> usize {
        match model {
            Model::Ilog2 => 0,
            Model::VaporPressure | Model::Pow3 | Model::LogLogLinear => 1,
            Model::LogPower | Model::Exp4 | Model::Pow4 => 2,
        }
    }

    pub fn model(self) -> Model {
        self.model
    }

    /// How u and v are tied.
    pub fn ties(self) -> Ties {
        match self.model {
            Model::VaporPressure | Model::LogPower => Ties::Proportional,
            Model::LogLogLinear => Ties::Offset,
            _ => Ties::Free,
        }
    }

    /// The shape at `t`, each 0 to 1, in the box of a curve from N_s = `low` on.
    pub fn at(model: Model, low: f64, t: [f64; 2]) -> Self {
        let [s, t] = t.map(|t| t.clamp(0.0, 1.0));
        let least = low.min(LEAST);
        let (r, q) = match model {
            Model::Ilog2 => (0.0, 0.0),
            // exp(-r low / N): concave from low on if r <= 2
            Model::VaporPressure => (between(1e-6, 2.0, s), 0.0),
            Model::Pow3 => (between(1e-3, 40.0, s), 0.0),
            // slope 1 / (ln N + b) in ln N; b keeps the logarithm's argument positive down to `least`
            Model::LogLogLinear => {
                let most = if least < low { 0.999 / libm::log(low / least) } else { 1e3 };
                (between(1e-6, most, s), 0.0)
            }
            // odds q at low: concave from low on if q <= (r + 1) / (r - 1)
            Model::LogPower => {
                let r = between(1e-2, 40.0, s);
                let most = if r > 1.0 { (r + 1.0) / (r - 1.0) } else { 1e6 };
                (r, between(1e-6, most.min(1e6), t))
            }
            // power r at low, exponent q: concave from low on if q <= r + 1
            Model::Exp4 => {
                let r = between(1e-3, 40.0, s);
                (r, between(1e-4, r + 1.0, t))
            }
            // power r at low; q = low / (low + b), the pole stays below `least`
            Model::Pow4 => {
                let r = between(1e-3, 40.0, s);
                let most = if least < low { 0.999 * low / (low - least) } else { 1e3 };
                (r, between(1e-4, most.min(100.0 * r), t))
            }
        };
        Shape { model, low, r, q }
    }

    pub fn basis(self, n: f64) -> f64 {
        let (r, q, x) = (self.r, self.q, n / self.low);
        match self.model {
            Model::Ilog2 => -1.0 / libm::log(n),
            Model::VaporPressure => libm::exp(-r / x),
            Model::Pow3 => -libm::expm1(-r * libm::log(x)),
            Model::LogLogLinear => libm::log1p(r * libm::log(x)) - libm::log(r),
            Model::LogPower => 1.0 / (1.0 + q * libm::pow(x, -r)),
            Model::Exp4 => -libm::expm1(-r * libm::expm1(q * libm::log(x)) / q),
            Model::Pow4 => -libm::expm1(-r / q * libm::log1p(q * (x - 1.0))),
        }
    }

    /// The model's own parameters, in the order alpha, beta, gamma, epsilon.
    pub fn parameters(self, u: f64, v: f64) -> Vec<f64> {
        let (r, q, low) = (self.r, self.q, self.low);
        match self.model {
            Model::Ilog2 => vec![v, u],
            Model::VaporPressure => vec![libm::log(v), -r * low],
            Model::Pow3 => vec![v * libm::pow(low, r), r, u + v],
            // u + ln(ln N + b) with b = 1 / r - ln low
            Model::LogLogLinear => {
                let alpha = libm::exp(u);
                vec![alpha, alpha * (1.0 / r - libm::log(low))]
            }
            Model::LogPower => vec![v, libm::log(low) + libm::log(q) / r, -r],
            Model::Exp4 => vec![r / q / libm::pow(low, q), libm::log(v) + r / q, q, u + v],
            Model::Pow4 => {
                let scale = libm::pow(v, -q / r);
                vec![scale * q / low, scale * (1.0 - q), u + v, r / q]
            }
        }
    }

    /// The flattest shape that keeps its parameters finite, for points without any rise.
    pub fn flat(model: Model, low: f64) -> Self {
        let (r, q) = match model {
            Model::VaporPressure | Model::LogLogLinear => (1e-6, 0.0),
            Model::LogPower => (1.0, 1e-6),
            _ => (1.0, 1.0),
        };
        Shape { model, low, r, q }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shapes_and_parameters_are_the_same_curve() {
        for model in Model::ALL {
            for (s, t) in [(0.3, 0.2), (0.6, 0.7), (0.8, 0.99)] {
                let shape = Shape::at(model, 200.0, [s, t]);
                let (u, v) = match shape.ties() {
                    Ties::Free => (0.4, 0.5),
                    Ties::Proportional => (0.0, 0.9),
                    Ties::Offset => (0.2, 1.0),
                };
                let p = model.parameters(&shape.parameters(u, v));
                for n in [128.0, 200.0, 450.0, 1000.0] {
                    let (here, there) = (u + v * shape.basis(n), model.at(&p, n));
                    assert!((here - there).abs() < 1e-9, "{} {s} {t} {n}: {here} {there}", model.name());
                }
            }
        }
    }

    #[test]
    fn the_box_holds_increasing_concave_curves_without_a_pole() {
        for model in Model::ALL {
            for k in 0..=20 {
                for l in 0..=20 {
                    let shape = Shape::at(model, 200.0, [f64::from(k) / 20.0, f64::from(l) / 20.0]);
                    let values: Vec<f64> =
                        (0..=80).map(|i| shape.basis(200.0 + 10.0 * f64::from(i))).collect();
                    assert!(shape.basis(LEAST).is_finite());
                    for w in values.windows(3) {
                        assert!(w[1] >= w[0] && w[2] - w[1] <= w[1] - w[0] + 1e-12, "{shape:?}");
                    }
                }
            }
        }
    }
}
