//! Periodic monotone cubic interpolation of the gait's control points.
//!
//! Fritsch-Carlson slopes (weighted harmonic mean), the points repeated one period before and after.

/// Cells of the look-up from a phase to its piece; control points lie further apart than a cell is wide.
const CELLS: usize = 64;

/// One cubic piece: from where it begins, a0 + a1 s + a2 s^2 + a3 s^3.
#[derive(Debug, Clone, Copy)]
pub struct Piece {
    /// From where on it holds.
    pub start: f64,
    /// a0 to a3.
    pub a: [f64; 4],
}

/// A curve of period 1 through control points.
#[derive(Debug, Clone)]
pub struct Periodic {
    pieces: Vec<Piece>,
    /// Piece at the beginning of each cell.
    cells: [u8; CELLS],
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
        let piece = |i: usize| {
            let (h, m) = (widths[i], secants[i]);
            let (d0, d1) = (slopes[i], slopes[i + 1]);
            let a = [values[i], d0, (3.0 * m - 2.0 * d0 - d1) / h, (d0 + d1 - 2.0 * m) / (h * h)];
            Piece { start: times[i], a }
        };
        // the pieces that reach into 0..1
        let first = times.partition_point(|&t| t <= 0.0).max(1) - 1;
        let last = times.partition_point(|&t| t < 1.0);
        let pieces: Vec<Piece> = (first..last).map(piece).collect();
        let at = |t: f64| pieces.iter().rposition(|p| p.start <= t).unwrap_or(0) as u8;
        let cells = std::array::from_fn(|cell| at(cell as f64 / CELLS as f64));
        Periodic { pieces, cells }
    }

    /// The piece at phase `t`, 0..1, and the phase where the next one begins.
    #[inline]
    pub fn piece(&self, t: f64) -> (Piece, f64) {
        let mut i = usize::from(self.cells[((t * CELLS as f64) as usize).min(CELLS - 1)]);
        loop {
            match self.pieces.get(i + 1) {
                Some(next) if next.start <= t => i += 1,
                next => return (self.pieces[i], next.map_or(f64::INFINITY, |next| next.start)),
            }
        }
    }

    /// Value and slope at phase `t`, any real number.
    #[inline]
    pub fn at(&self, t: f64) -> (f64, f64) {
        let t = t - t.floor();
        let Piece { start, a } = self.piece(t).0;
        let s = t - start;
        let value = a[0] + s * (a[1] + s * (a[2] + s * a[3]));
        (value, a[1] + s * (2.0 * a[2] + 3.0 * s * a[3]))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn curves_pass_their_points_without_overshoot_and_close() {
        let points = [(0.17, 3.0), (0.4, 3.0), (0.75, 70.0), (1.0, 3.0)];
        let curve = Periodic::new(&points);
        for (t, v) in points {
            assert!((curve.at(t).0 - v).abs() < 1e-12 && (curve.at(t - 3.0).0 - v).abs() < 1e-9);
        }
        for step in 0..10_000 {
            let t = f64::from(step) / 10_000.0;
            let (value, slope) = curve.at(t);
            assert!((3.0 - 1e-12..=70.0 + 1e-12).contains(&value), "{t}: {value}");
            let h = 1e-6;
            let secant = (curve.at(t + h).0 - curve.at(t - h).0) / (2.0 * h);
            assert!((slope - secant).abs() < 0.02, "{t}: {slope} {secant}");
        }
    }
}
