//! Tests of `values`.

use sdp3_core::dims::Complex;
use sdp3_core::probe::Probe;
use sdp3_core::signal::clutter::Gram;
use sdp3_core::values::*;

/// Counts values, and holds each to the width its stage states.
struct Counts([usize; Stage::ALL.len()]);

impl Sink for Counts {
    fn value<const N: usize>(&mut self, stage: Stage, _bytes: [u8; N]) {
        assert_eq!(N, stage.width(), "{}", stage.name());
        self.0[stage as usize] += 1;
    }
}

#[test]
fn stages_are_found_by_their_names() {
    for (number, stage) in Stage::ALL.into_iter().enumerate() {
        assert_eq!((stage as usize, Stage::named(stage.name())), (number, Some(stage)));
    }
    assert_eq!(Stage::named("picture"), None);
}

#[test]
fn every_value_is_handed_on_in_its_width() {
    let z = Complex::new(1, 2);
    let mut values = Values(Counts([0; Stage::ALL.len()]));
    values.beat(&[z; 8]);
    values.gram(&Gram::new());
    values.projection(&[z; 8]);
    values.slow_time(&[z; 5]);
    values.frame(0, &[Complex::new(0.0, 0.0); 256]);
    values.fixed_frame(0, &[z; 256]);
    values.image(&[1; 64]);
    values.layer(0, &[1; 7]);
    values.logits(&[1; 3]);
    values.class(0);
    values.confidence(0.5);
    assert_eq!(values.0.0, [16, 72, 16, 10, 1024, 64, 7, 3, 1, 1]);
}
