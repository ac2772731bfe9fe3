//! The core against results that nobody here computed: LiteRT's reference kernels, numpy, scipy, mpmath.
//!
//! The vectors and the Python programs that made them lie in `tests/oracles`.

use sdp3_core::dims::{Beat, Complex};
use sdp3_core::signal::clutter::{PROJECTION_BITS, SvdRange, UNIT_PROJECTION, clutter_projection};
use sdp3_core::signal::dechirp::CHIRP;
use sdp3_core::signal::stft::{FloatStft, Stft, ZERO_SPECTRUM};
use sdp3_tests::networks::layers;
use sdp3_tests::vectors::{bytes, list, signed};
use serde_json::Value;

fn pair(value: &Value) -> (f64, f64) {
    let number = |k: usize| value[k].as_f64().expect("a number");
    (number(0), number(1))
}

#[test]
fn every_layer_has_the_bits_of_tflites_reference_kernels() {
    let vectors: Value = serde_json::from_str(include_str!("oracles/network.json")).expect("JSON");
    let mut compared = 0;
    for network in list(&vectors["networks"]) {
        let (file, image) = (bytes(&network["model"]), signed(&network["image"]));
        let layers = layers(&file, &image);
        // the oracle also keeps the stem before its pooling, which the core never holds as a whole
        let expected = &list(&network["tensors"])[1..];
        assert_eq!(layers.len(), expected.len());
        for (found, expected) in layers.iter().zip(expected) {
            let values = signed(&expected["values"]);
            assert_eq!(found, &values, "{} {}", network["name"], expected["layer"]);
            compared += values.len();
        }
    }
    assert!(compared > 5_000, "{compared}");
}

fn front_end() -> Value {
    serde_json::from_str(include_str!("oracles/front_end.json")).expect("JSON")
}

#[test]
fn the_chirp_table_is_exact() {
    let vectors = front_end();
    for (n, sample) in CHIRP.iter().enumerate() {
        let at = |name: &str| vectors["chirp"][name][n].as_i64().expect("an integer");
        assert_eq!((i64::from(sample[0]), i64::from(sample[1])), (at("cos"), at("sin")), "sample {}", n + 1);
    }
}

#[test]
fn slow_time_is_numpys_truncated_svd() {
    let vectors = front_end();
    let beats: Vec<Beat> = list(&vectors["clutter"]["beats"])
        .iter()
        .map(|slot| {
            std::array::from_fn(|m| {
                let (re, im) = pair(&slot[m]);
                Complex::new(re as i32, im as i32)
            })
        })
        .collect();
    let project = |w: &Beat, beat: &Beat| {
        let scale = f64::from(1 << PROJECTION_BITS);
        w.iter().zip(beat).fold((0.0, 0.0), |sum, (w, b)| {
            let (wr, wi) = (f64::from(w.re) / scale, f64::from(w.im) / scale);
            let (br, bi) = (f64::from(b.re), f64::from(b.im));
            (sum.0 + wr * br + wi * bi, sum.1 + wr * bi - wi * br)
        })
    };
    let strongest = vectors["clutter"]["singular_values"][0].as_f64().expect("a number");
    for cut in list(&vectors["clutter"]["cuts"]) {
        let bound = |name: &str| cut[name].as_u64().expect("an integer") as u8;
        let w = clutter_projection(&beats, SvdRange { first: bound("first"), last: bound("last") });
        if (bound("first"), bound("last")) == (1, 8) {
            assert_eq!(w, UNIT_PROJECTION);
        }
        for (beat, expected) in beats.iter().zip(list(&cut["y"])) {
            let (found, expected) = (project(&w, beat), pair(expected));
            let error = (found.0 - expected.0).hypot(found.1 - expected.1) / strongest;
            assert!(error < 3e-3, "cut {} to {}: {error}", cut["first"], cut["last"]);
        }
    }
}

#[test]
fn frames_are_scipys() {
    let vectors = front_end();
    for case in list(&vectors["stft"]) {
        let number = |name: &str| case[name].as_f64().expect("a number");
        let stft = FloatStft::new(number("window_len") as u16, number("beta") as f32, number("hop") as u16);
        for (found, expected) in stft.window().iter().zip(list(&case["window"])) {
            assert!((f64::from(*found) - expected.as_f64().expect("a number")).abs() < 2e-6);
        }
        let signal: Vec<Complex<i32>> = list(&case["slow_time"])
            .iter()
            .map(|z| {
                let (re, im) = pair(z);
                Complex::new(re as i32, im as i32)
            })
            .collect();
        let frames = list(&case["frames"]);
        assert_eq!(frames.len(), stft.frames(signal.len()));
        let mut spectrum = ZERO_SPECTRUM;
        for (k, frame) in frames.iter().enumerate() {
            stft.frame(&signal, k, 1, &mut spectrum);
            let total: f64 = signal.iter().map(|z| f64::from(z.re).hypot(f64::from(z.im))).sum();
            for (found, expected) in spectrum.iter().zip(list(frame)) {
                let (re, im) = pair(expected);
                let error = (f64::from(found.re) - re).hypot(f64::from(found.im) - im);
                assert!(error < total / 262_144.0, "frame {k}: {error}");
            }
        }
    }
}
