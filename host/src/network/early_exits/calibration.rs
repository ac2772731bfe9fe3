//! Weights of evidence: what makes an exit's confidence the share of its answers that are right.
//!
//! Log loss of softmax(sum over exits so far of w_j logits_j), w_j >= 0, on recordings no network was trained on. Convex; Newton's
//! method coordinate by coordinate. One exit alone is temperature scaling (Guo, Pleiss, Sun and Weinberger, 2017).

use crate::network::evaluation::ExitLogits;
use sdp3_core::early_exit::{EVIDENCE_BITS, MAX_WEIGHT};

/// Sweeps over the coordinates.
const SWEEPS: u32 = 60;

/// Strength of the pull towards 0, in units of one recording: keeps weights finite where the recordings are separable.
const RIDGE: f64 = 0.5;

/// Integer weights of every exit, `[exit][exit so far]`, in 2^-16 nat per logit step.
pub fn weights(exit_logits: &ExitLogits) -> Vec<Vec<i32>> {
    (0..exit_logits.slots.len()).map(|exit| fit(exit_logits, exit)).collect()
}

fn fit(exit_logits: &ExitLogits, exit: usize) -> Vec<i32> {
    let mut w = vec![0.0; exit + 1];
    w[exit] = 1.0;
    // evidence in nat, [recording][class]
    let nat =
        |j: usize, logits: &[Vec<i8>], class: usize| exit_logits.scales[j] * f64::from(logits[j][class]);
    let classes = exit_logits.logits.first().map_or(0, |l| l[exit].len());
    let mut evidence: Vec<Vec<f64>> =
        exit_logits.logits.iter().map(|l| (0..classes).map(|c| nat(exit, l, c)).collect()).collect();
    for _ in 0..SWEEPS {
        for j in 0..=exit {
            let (mut gradient, mut curvature) = (RIDGE * w[j], RIDGE);
            for ((e, l), &truth) in evidence.iter().zip(&exit_logits.logits).zip(&exit_logits.truth) {
                let most = e.iter().copied().fold(f64::NEG_INFINITY, f64::max);
                let (mut sum, mut first, mut second) = (0.0, 0.0, 0.0);
                for (class, value) in e.iter().enumerate() {
                    let (p, x) = (libm::exp(value - most), nat(j, l, class));
                    sum += p;
                    first += p * x;
                    second += p * x * x;
                }
                let mean = first / sum;
                gradient += mean - nat(j, l, usize::from(truth));
                curvature += second / sum - mean * mean;
            }
            let step = (w[j] - 0.7 * gradient / curvature).max(0.0) - w[j];
            w[j] += step;
            for (e, l) in evidence.iter_mut().zip(&exit_logits.logits) {
                e.iter_mut().enumerate().for_each(|(class, value)| *value += step * nat(j, l, class));
            }
        }
    }
    let scale = f64::from(1_u32 << EVIDENCE_BITS);
    let whole = |(w, s): (f64, &f64)| (w * s * scale).round().clamp(0.0, f64::from(MAX_WEIGHT)) as i32;
    let mut weights: Vec<i32> = w.into_iter().zip(&exit_logits.scales).map(whole).collect();
    // an uninformative network: its class at the least confidence, as the core refuses an own weight of 0
    weights[exit] = weights[exit].max(1);
    weights
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numerics::random::Random;

    #[test]
    fn an_overconfident_exit_is_cooled_and_a_worthless_one_ignored() {
        // classes drawn from the softmax of half the logits: the right weight of exit 1 is 1/2; exit 0 is noise
        let mut random = Random::new(9, 0, 0, 0);
        let mut exit_logits = ExitLogits {
            slots: vec![200, 400],
            scales: vec![0.1, 0.1],
            truth: Vec::new(),
            logits: Vec::new(),
        };
        for _ in 0..6000 {
            let mut draw = || -> Vec<i8> {
                (0..5).map(|_| (25.0 * random.gaussian()).clamp(-127.0, 127.0) as i8).collect()
            };
            let (noise, logits) = (draw(), draw());
            let p: Vec<f64> = logits.iter().map(|&l| libm::exp(0.05 * f64::from(l))).collect();
            let mut left = random.uniform() * p.iter().sum::<f64>();
            let truth = p.iter().position(|p| {
                left -= p;
                left < 0.0
            });
            exit_logits.truth.push(truth.unwrap_or(4) as u8);
            exit_logits.logits.push(vec![noise, logits]);
        }
        let w = weights(&exit_logits);
        let nat = |w: i32| f64::from(w) / 65536.0;
        assert!(w[0][0] >= 1 && nat(w[0][0]) < 0.004, "{w:?}");
        assert!(nat(w[1][0]) < 0.004 && (nat(w[1][1]) - 0.05).abs() < 0.003, "{w:?}");
    }
}
