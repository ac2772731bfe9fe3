//! Any bytes are parsed or refused; what is parsed runs, and its sizes are those its header states.
#![no_main]

use libfuzzer_sys::fuzz_target;
use sdp3_core::dims::ROWS;
use sdp3_core::dsn::{Model, Portable, Shape, infer};
use sdp3_fuzz::set_checksum;

fn judge(file: &[u8], image: &[u8]) {
    let Ok(model) = Model::parse(file) else { return };
    let shape = Shape::of(file).expect("a model has a shape");
    assert_eq!(shape, model.shape());
    (0..model.classes()).for_each(|class| assert!(!model.class_name(class).is_empty()));
    if shape.frames > 64 {
        return; // sound, but slow
    }
    let classes = model.classes();
    let mut scratch = vec![0; shape.scratch_bytes()];
    let pixels: Vec<i8> =
        (0..ROWS * shape.frames).map(|k| image.get(k % image.len().max(1)).map_or(0, |&b| b as i8)).collect();
    let answer = infer(&model, &pixels, &mut scratch, &mut Portable, &mut ());
    assert!(usize::from(answer.class) < classes && (0.0..=1.01).contains(&answer.confidence));
}

fuzz_target!(|data: &[u8]| {
    judge(data, data);
    // the same content behind an envelope that is whole
    if data.len() >= 64 {
        let mut file = data[..data.len() - 4].to_vec();
        if file.len() >= 64 {
            file[..8].copy_from_slice(&[b'S', b'D', b'P', b'3', 1, 0, 64, 0]);
            set_checksum(&mut file);
            judge(&file, data);
        }
    }
});
