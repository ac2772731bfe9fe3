//! Augmentation: an image is a little else every time it is learned from.
//!
//! A band of rows goes dark (the frequency mask of SpecAugment, Park et al. 2019), then every image of a batch is mixed with its
//! neighbour, pixels and class alike (mixup, Zhang et al. 2018). Two passes over the batch; nothing is drawn where both are off.

use super::batches::Batch;
use crate::numerics::random::Random;
use crate::scenario::Learning;

/// The stream of an epoch's batch.
pub fn stream(seed: u64, epoch: usize, batch: usize) -> Random {
    Random::new(seed, 0x6175_676d, epoch as u64, batch as u64)
}

/// Masks and mixes a batch as the settings say.
pub fn augment(batch: &mut Batch, settings: &Learning, random: &mut Random) {
    let widest = (settings.mask_rows as usize).min(batch.rows);
    if widest > 0 {
        let (rows, frames) = (batch.rows, batch.frames);
        for image in batch.pixels.chunks_exact_mut(rows * frames) {
            let width = up_to(random, widest);
            let first = up_to(random, rows - width);
            image[first * frames..(first + width) * frames].fill(0.0);
        }
    }
    if settings.mixup > 0.0 {
        let x = symmetric_beta(random, settings.mixup);
        // the larger share stays with the image's own label
        let own = x.max(1.0 - x) as f32;
        mix(&mut batch.pixels, batch.rows * batch.frames, own);
        mix(&mut batch.truth, batch.classes, own);
    }
}

/// Uniform in 0 to most.
fn up_to(random: &mut Random, most: usize) -> usize {
    ((most + 1) as f64 * random.uniform()) as usize
}

/// Beta(a, a), 0 < a <= 1, by Joehnk's method: two powers of uniforms, kept where their sum is at most 1.
fn symmetric_beta(random: &mut Random, a: f64) -> f64 {
    loop {
        let [x, y] = [random.uniform(), random.uniform()].map(|u| libm::pow(u, 1.0 / a));
        if x + y <= 1.0 && x + y > 0.0 {
            return x / (x + y);
        }
    }
}

/// Every piece keeps the share `own` and takes the rest from the next, the last from the first.
fn mix(values: &mut [f32], size: usize, own: f32) {
    let first = values[..size].to_vec();
    for at in 0..values.len() {
        let next = values.get(at + size).copied().unwrap_or_else(|| first[at % size]);
        values[at] = own * values[at] + (1.0 - own) * next;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::network::synthetic::stripes;

    fn augmented(mask_rows: u32, mixup: f64, epoch: usize) -> Batch {
        let images = stripes(24, 4, 1);
        let mut batch = Batch::of(&images, &[3, 0, 8, 15, 1], 5);
        let settings = Learning { mask_rows, mixup, ..Learning::default() };
        augment(&mut batch, &settings, &mut stream(7, epoch, 2));
        batch
    }

    #[test]
    fn nothing_changes_where_both_are_off() {
        assert_eq!(augmented(0, 0.0, 0), Batch::of(&stripes(24, 4, 1), &[3, 0, 8, 15, 1], 5));
    }

    #[test]
    fn a_mask_darkens_one_band_of_whole_rows() {
        let plain = augmented(0, 0.0, 0);
        let mut widths = Vec::new();
        for epoch in 0..40 {
            let masked = augmented(12, 0.0, epoch);
            assert_eq!(masked.truth, plain.truth);
            let images = |b: &Batch| -> Vec<Vec<f32>> { b.pixels.chunks(24).map(<[f32]>::to_vec).collect() };
            for (masked, plain) in images(&masked).chunks(plain.rows).zip(images(&plain).chunks(plain.rows)) {
                let changed: Vec<usize> = (0..masked.len()).filter(|&r| masked[r] != plain[r]).collect();
                let Some((first, last)) = changed.first().zip(changed.last()) else { continue };
                assert!(masked[*first..=*last].iter().flatten().all(|p| *p == 0.0));
                widths.push(last - first + 1);
            }
        }
        assert_eq!(widths.iter().max(), Some(&12));
    }

    #[test]
    fn mixed_images_and_classes_have_the_same_shares() {
        let plain = augmented(0, 0.0, 0);
        let mut shares = Vec::new();
        for epoch in 0..200 {
            let mixed = augmented(0, 0.4, epoch);
            for row in mixed.truth.chunks(5) {
                assert!((row.iter().sum::<f32>() - 1.0).abs() < 1e-6);
            }
            // images 3 and 0 have labels 3 and 0
            let own = mixed.truth[3];
            assert!((mixed.truth[0] - (1.0 - own)).abs() < 1e-6 && own >= 0.5);
            let size = plain.rows * plain.frames;
            for at in 0..size {
                let expected = own * plain.pixels[at] + (1.0 - own) * plain.pixels[size + at];
                assert!((mixed.pixels[at] - expected).abs() < 1e-6);
            }
            shares.push(f64::from(own));
        }
        // E max(x, 1 - x) of Beta(a, a): 1/2 + Gamma(2a) / (Gamma(a)^2 2^(2a) a), 0.8301 for a = 0.4
        let a = 0.4;
        let gamma = libm::tgamma;
        let expected = 0.5 + gamma(2.0 * a) / (gamma(a) * gamma(a) * libm::pow(4.0, a) * a);
        let mean = shares.iter().sum::<f64>() / shares.len() as f64;
        assert!((mean - expected).abs() < 0.03, "{mean} {expected}");
    }

    #[test]
    fn the_same_batch_of_the_same_epoch_is_the_same_again() {
        assert_eq!(augmented(12, 0.4, 3), augmented(12, 0.4, 3));
        assert_ne!(augmented(12, 0.4, 3), augmented(12, 0.4, 4));
    }
}
