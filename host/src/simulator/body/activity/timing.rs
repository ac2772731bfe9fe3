//! How far a movement has come at a time: smooth, dropped, repeated, or through given points.
//!
//! All have a continuous first derivative, so that no joint's velocity jumps.

use super::super::number::Real;

/// From 0 at `from` to 1 at `to` s with the least jerk, and at rest before and after: 10 u^3 - 15 u^4 + 6 u^5.
///
/// Flash and Hogan, "The coordination of arm movements" (1985).
pub fn ease<R: Real>(t: R, from: f64, to: f64) -> R {
    let [progress] = t.lift(|t| {
        let span = to - from;
        let u = ((t - from) / span).clamp(0.0, 1.0);
        let rest = 1.0 - u;
        ([u * u * u * (10.0 + u * (6.0 * u - 15.0))], [30.0 * u * u * rest * rest / span])
    });
    progress
}

/// Time in which what falls comes to rest, as a share of the fall's duration.
const STOP: f64 = 0.08;

/// Rate of [`dropped`] at the impact, times the fall's duration.
const IMPACT_RATE: f64 = 2.0 / (1.0 + STOP);

/// From 0 to 1: at a constant acceleration for `duration` s before the `impact`, then at rest within a twelfth of that time.
pub fn dropped<R: Real>(t: R, impact: f64, duration: f64) -> R {
    let [progress] = t.lift(|t| {
        let u = ((t - impact) / duration + 1.0).clamp(0.0, 1.0 + STOP);
        let rest = 1.0 + STOP - u;
        match u < 1.0 {
            true => ([u * u / (1.0 + STOP)], [IMPACT_RATE * u / duration]),
            false => ([1.0 - rest * rest / (STOP * (1.0 + STOP))], [IMPACT_RATE * rest / (STOP * duration)]),
        }
    });
    progress
}

/// Time since the last repetition began; one begins at `start` and then every `period` s, before and after.
pub fn repeated<R: Real>(t: R, start: f64, period: f64) -> R {
    let [since] = t.lift(|t| ([t - start - ((t - start) / period).floor() * period], [1.0]));
    since
}

/// A curve through (time in s, value, slope): cubic in between, constant before the first and after the last.
#[derive(Debug, Clone)]
pub struct Curve(pub Vec<[f64; 3]>);

impl Curve {
    pub fn at<R: Real>(&self, t: R) -> R {
        let [value] = t.lift(|t| {
            let next = self.0.partition_point(|knot| knot[0] <= t);
            let (Some([a, p, v]), Some([b, q, w])) = (self.0.get(next.wrapping_sub(1)), self.0.get(next))
            else {
                let end = self.0.get(next.min(self.0.len().saturating_sub(1)));
                return ([end.map_or(0.0, |knot| knot[1])], [0.0]);
            };
            let (span, u) = (b - a, (t - a) / (b - a));
            // Newton's form: the value and slope at a, then what is missing at b
            let (second, third) = (q - p - v * span, (w + v) * span - 2.0 * (q - p));
            let value = p + u * (v * span + u * (second + (u - 1.0) * third));
            let slope = v * span + u * (2.0 * second + (3.0 * u - 2.0) * third);
            ([value], [slope / span])
        });
        value
    }
}

#[cfg(test)]
mod tests {
    use super::super::super::number::Dual;
    use super::*;

    fn smooth(f: impl Fn(Dual) -> Dual) {
        let h = 1e-6;
        for step in -500..3500 {
            let t = f64::from(step) * 1e-3 + 3e-4;
            let [before, now, after] = [t - h, t, t + h].map(|t| f(Dual::variable(t)));
            assert!((after.value - before.value - 2.0 * h * now.rate).abs() < 1e-9, "{t}");
            assert!((after.rate - before.rate).abs() < 2e-3, "{t}: {before:?} {after:?}");
        }
    }

    #[test]
    fn rates_are_derivatives_and_do_not_jump() {
        smooth(|t| ease(t, 0.4, 1.9));
        smooth(|t| dropped(t, 1.1, 0.8));
        smooth(|t| ease(repeated(t, -0.3, 1.5), 0.2, 0.9) - ease(repeated(t, -0.3, 1.5), 1.0, 1.5));
        let knots = vec![[0.1, 1.0, 0.0], [0.6, -0.5, 2.0], [0.9, 0.4, -1.0], [2.0, 0.0, 0.0]];
        let curve = Curve(knots.clone());
        smooth(|t| curve.at(t));
        for [t, value, slope] in knots {
            let found = curve.at(Dual::variable(t + 1e-12));
            assert!((found.value - value).abs() < 1e-9 && (found.rate - slope).abs() < 1e-9, "{found:?}");
        }
        assert_eq!([curve.at(-1.0), curve.at(5.0)], [1.0, 0.0]);
    }

    #[test]
    fn movements_go_from_nothing_to_all() {
        for f in [|t| ease(t, 0.2, 1.2), |t| dropped(t, 1.1, 0.9)] {
            assert_eq!([f(0.0), f(0.199)], [0.0, 0.0]);
            assert!((f(1.21) - 1.0).abs() < 1e-12);
        }
        // the impact comes at the greatest speed
        let rate = |t: f64| dropped(Dual::variable(t), 1.1, 0.9).rate;
        assert!(
            (rate(1.1) - IMPACT_RATE / 0.9).abs() < 1e-9 && rate(1.0) < rate(1.1) && rate(1.12) < rate(1.1)
        );
    }
}
