//! A natural cubic spline through the joints: twice continuously differentiable, zero second derivative at both ends.

use super::super::Vec3;
use super::super::gait::JOINTS;

type Frame = [Vec3; JOINTS];

/// One spline for each coordinate of each joint over common times.
#[derive(Debug, Clone)]
pub(super) struct Spline {
    times: Vec<f64>,
    values: Vec<Frame>,
    /// Second derivatives at the times.
    bends: Vec<Frame>,
}

/// Each coordinate from its counterparts.
fn combine<const N: usize>(frames: [&Frame; N], f: impl Fn([f64; N]) -> f64) -> Frame {
    std::array::from_fn(|j| std::array::from_fn(|axis| f(frames.map(|frame| frame[j][axis]))))
}

impl Spline {
    /// Through at least two `values` at strictly ascending `times`.
    pub(super) fn new(times: Vec<f64>, values: Vec<Frame>) -> Self {
        let n = times.len();
        let mut bends = vec![[[0.0; 3]; JOINTS]; n];
        // Thomas' elimination; at row i the row's super-diagonal over its pivot is upper[i]
        let mut upper = vec![0.0; n];
        for i in 1..n - 1 {
            let (left, right) = (times[i] - times[i - 1], times[i + 1] - times[i]);
            let pivot = 2.0 * (left + right) - left * upper[i - 1];
            upper[i] = right / pivot;
            let around = [&values[i - 1], &values[i], &values[i + 1], &bends[i - 1]];
            bends[i] = combine(around, |[a, b, c, before]| {
                (6.0 * ((c - b) / right - (b - a) / left) - left * before) / pivot
            });
        }
        for i in (1..n - 1).rev() {
            bends[i] = combine([&bends[i], &bends[i + 1]], |[own, after]| own - upper[i] * after);
        }
        Spline { times, values, bends }
    }

    pub(super) fn end(&self) -> f64 {
        self.times[self.times.len() - 1]
    }

    pub(super) fn frames(&self) -> usize {
        self.times.len()
    }

    /// Values and first derivatives at `t` between the first and the last time.
    pub(super) fn at(&self, t: f64) -> (Frame, Frame) {
        let i = self.times.partition_point(|&knot| knot <= t).clamp(1, self.times.len() - 1) - 1;
        let h = self.times[i + 1] - self.times[i];
        let b = (t - self.times[i]) / h;
        let a = 1.0 - b;
        let (a3, b3) = ((a * a * a - a) * h * h / 6.0, (b * b * b - b) * h * h / 6.0);
        let (da, db) = ((1.0 - 3.0 * a * a) * h / 6.0, (3.0 * b * b - 1.0) * h / 6.0);
        let around = [&self.values[i], &self.values[i + 1], &self.bends[i], &self.bends[i + 1]];
        (
            combine(around, |[y0, y1, m0, m1]| a * y0 + b * y1 + a3 * m0 + b3 * m1),
            combine(around, |[y0, y1, m0, m1]| (y1 - y0) / h + da * m0 + db * m1),
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::PI;

    /// Of a sine of 1 m and 1 Hz at uneven times of 10 ms on average, one second long and beginning at `phase` turns:
    /// largest errors of position and velocity.
    fn errors(phase: f64) -> (f64, f64) {
        let w = 2.0 * PI;
        let times: Vec<f64> =
            (0..=100).map(|k| 0.01 * (f64::from(k) + if k % 3 == 2 { 0.2 } else { 0.0 })).collect();
        let at = |t: f64| libm::sin(w * (t + phase));
        let spline = Spline::new(times.clone(), times.iter().map(|&t| [[at(t); 3]; JOINTS]).collect());
        let mut worst = (0.0_f64, 0.0_f64);
        for k in 0..=1000 {
            let t = spline.end() * f64::from(k) / 1000.0;
            let (value, slope) = spline.at(t);
            assert_eq!(value[0][0], value[16][2]);
            worst.0 = worst.0.max((value[5][1] - at(t)).abs());
            worst.1 = worst.1.max((slope[5][1] - w * libm::cos(w * (t + phase))).abs());
        }
        worst
    }

    #[test]
    fn velocity_is_that_of_a_smooth_motion() {
        let (w, h) = (2.0 * PI, 0.012_f64);
        // where the second derivative is zero at the ends: the bounds of Hall and Meyer, h^4 w^4 5/384 and h^3 w^4 / 24
        // (both for complete splines), doubled
        let (value, slope) = errors(0.0);
        assert!(value < 2.0 * h.powi(4) * w.powi(4) * 5.0 / 384.0, "{value}");
        assert!(slope < 2.0 * h.powi(3) * w.powi(4) / 24.0, "{slope}");
        // where it is not, the end is off by the natural condition: at most h^2 w^2 / 8 and h w^2 / 3
        let (value, slope) = errors(0.25);
        assert!(value < h * h * w * w / 8.0, "{value}");
        assert!(slope < h * w * w / 3.0, "{slope}");
    }

    #[test]
    fn velocity_is_the_derivative_of_position() {
        let times = vec![0.0, 0.3, 0.4, 1.0, 1.1];
        let values = [0.0, 1.0, -1.0, 0.5, 2.0].map(|v| [[v, 2.0 * v, -v]; JOINTS]).to_vec();
        let spline = Spline::new(times, values);
        let e = 1e-6;
        for k in 1..110 {
            let t = 0.01 * f64::from(k);
            let (value, slope) = spline.at(t);
            let difference = (spline.at(t + e).0[3][0] - spline.at(t - e).0[3][0]) / (2.0 * e);
            assert!((difference - slope[3][0]).abs() < 1e-3, "{t} {difference} {}", slope[3][0]);
            assert!((value[3][1] - 2.0 * value[3][0]).abs() < 1e-12 && value[3][2] == -value[3][0]);
        }
    }
}
