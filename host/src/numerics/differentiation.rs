//! Derivatives of the polynomial through points (Berrut and Trefethen, Barycentric Lagrange Interpolation, 2004, section 9.3).

/// `matrix[i][j]`: weight of the value at point j in the derivative at point i.
pub fn matrix(points: &[f64]) -> Vec<Vec<f64>> {
    let others = |i: usize| (0..points.len()).filter(move |&j| j != i);
    // one over the barycentric weights
    let products: Vec<f64> =
        (0..points.len()).map(|i| others(i).map(|j| points[i] - points[j]).product()).collect();
    let row = |i: usize| {
        let mut row = vec![0.0; points.len()];
        others(i).for_each(|j| row[j] = products[i] / products[j] / (points[i] - points[j]));
        row[i] = -row.iter().sum::<f64>();
        row
    };
    (0..points.len()).map(row).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn polynomials_of_the_points_degree_are_exact() {
        let points = [-1.0, -0.3, 0.1, 0.5, 1.2];
        let matrix = matrix(&points);
        for (row, x) in matrix.iter().zip(points) {
            for degree in 0..5_i32 {
                let found: f64 = row.iter().zip(points).map(|(w, x)| w * x.powi(degree)).sum();
                let exact = if degree == 0 { 0.0 } else { f64::from(degree) * x.powi(degree - 1) };
                assert!((found - exact).abs() < 1e-12, "{degree} at {x}: {found} {exact}");
            }
        }
    }
}
