//! Periodic monotone cubic interpolation of the gait's control points.
//!
//! Fritsch-Carlson slopes (weighted harmonic mean), the points repeated one period before and after.

/// A curve of period 1 through control points.
#[derive(Debug, Clone)]
pub struct Periodic {
    times: Vec<f64>,
    values: Vec<f64>,
    slopes: Vec<f64>,
}

impl Periodic {
    /// Through `(time, value)` points with ascending times inside one period.
    pub fn new(points: &[(f64, f64)]) -> Self {
        let repeated = [-2.0, -1.0, 0.0, 1.0, 2.0];
        let shifted = repeated.iter().flat_map(|shift| points.iter().map(move |&(t, v)| (t + shift, v)));
        let (times, values): (Vec<f64>, Vec<f64>) = shifted.unzip();
        let widths: Vec<f64> = times.windows(2).map(|t| t[1] - t[0]).collect();
        let secants: Vec<f64> = values.windows(2).zip(&widths).map(|(v, h)| (v[1] - v[0]) / h).collect();
        let mut slopes = vec![0.0; times.len()];
        for i in 1..times.len() - 1 {
            let (left, right) = (secants[i - 1], secants[i]);
            if left * right > 0.0 {
                let (w1, w2) = (2.0 * widths[i] + widths[i - 1], widths[i] + 2.0 * widths[i - 1]);
                slopes[i] = (w1 + w2) / (w1 / left + w2 / right);
            }
        }
        Periodic { times, values, slopes }
    }

    /// Value at phase `t`, any real number.
    pub fn at(&self, t: f64) -> f64 {
        let t = t - t.floor();
        let i = self.times.partition_point(|&knot| knot <= t).clamp(1, self.times.len() - 1) - 1;
        let h = self.times[i + 1] - self.times[i];
        let s = (t - self.times[i]) / h;
        let (s2, s3) = (s * s, s * s * s);
        (2.0 * s3 - 3.0 * s2 + 1.0) * self.values[i]
            + (s3 - 2.0 * s2 + s) * h * self.slopes[i]
            + (3.0 * s2 - 2.0 * s3) * self.values[i + 1]
            + (s3 - s2) * h * self.slopes[i + 1]
    }
}
