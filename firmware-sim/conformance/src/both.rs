//! Two probes as one.

use sdp3_core::digest::DigestProbe;
use sdp3_core::dims::{Beat, Complex, FFT_LEN};
use sdp3_core::probe::Probe;
use sdp3_core::signal::clutter::Gram;

/// Digests, and another probe.
pub struct Both<'a, P>(pub &'a mut DigestProbe, pub &'a mut P);

/// The methods of [`Probe`], each for both.
macro_rules! both {
    ($($method:ident($($name:ident: $type:ty),*);)*) => {
        impl<P: Probe> Probe for Both<'_, P> {
            $(fn $method(&mut self, $($name: $type),*) {
                self.0.$method($($name),*);
                self.1.$method($($name),*);
            })*
        }
    };
}

both! {
    beat(beat: &Beat);
    gram(gram: &Gram);
    projection(projection: &Beat);
    slow_time(slow_time: &[Complex<i32>]);
    frame(k: usize, spectrum: &[Complex<f32>; FFT_LEN]);
    fixed_frame(k: usize, spectrum: &[Complex<i32>; FFT_LEN]);
    image(image: &[i8]);
    layer(index: usize, activations: &[i8]);
    logits(logits: &[i8]);
    class(class: u8);
    confidence(confidence: f32);
}
