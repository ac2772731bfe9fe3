//! Early exits one after the other: what each says, when the pipeline stops, which exits do not go together, and that recordings
//! may overlap.

mod support;

use sdp3_core::config::RadarConfig;
use sdp3_core::dsn::{Classification, Model, Portable, Shape};
use sdp3_core::early_exit::{EXITS, EarlyExit, MAX_WEIGHT, add_evidence, decide};
use sdp3_core::pipeline::Pipeline;
use sdp3_core::signal::front_end::Clutter;
use sdp3_core::signal::stft::FixedStft;
use sdp3_core::{Error, pipeline_memory};
use support::{CHANNELS, Memory, SHORTER, VALUES, altered, noise_slots, random_model};

const SLOTS: [u16; 3] = [144, 200, 264];

fn files() -> [Vec<u8>; 3] {
    SLOTS.map(|slots| random_model(slots, u64::from(slots)))
}

fn parse(file: &[u8]) -> Model<'_> {
    Model::parse(file).expect("a model")
}

/// An exit with these weights of its own and of the earlier logits.
fn exit<'m>(model: Model<'m>, first: &[i32]) -> EarlyExit<'m> {
    let mut weights = [0; EXITS];
    weights[..first.len()].copy_from_slice(first);
    EarlyExit { model, weights }
}

type Plain<'m, 'b> = Pipeline<'m, 'b, Portable>;

fn plain<'m, 'b>(
    exits: impl IntoIterator<Item = EarlyExit<'m>>,
    memory: &'b mut Memory,
) -> Result<Plain<'m, 'b>, Error> {
    Pipeline::with_kernels(exits, 2.0, memory.view(), Portable)
}

/// Takes slots until a classification, finishing every recognition at once; how many it took.
fn until_classified(pipeline: &mut Plain<'_, '_>, slots: &[[i16; VALUES]]) -> (usize, Classification) {
    for (n, slot) in slots.iter().enumerate() {
        pipeline.push(slot, &mut ()).expect("room");
        if let Some(classification) = pipeline.classify(&mut ()) {
            return (n + 1, classification);
        }
    }
    panic!("no classification")
}

#[test]
fn every_exit_sums_the_logits_so_far() {
    let files = files();
    let weights: [&[i32]; 3] = [&[4000], &[-3000, 9000], &[1000, 2000, 30_000]];
    let slots = noise_slots(300, 2);
    // each network by itself
    let alone = files.each_ref().map(|file| {
        let mut memory = Memory::of(&parse(file));
        let mut pipeline = plain([exit(parse(file), &[1])], &mut memory).expect("enough memory");
        until_classified(&mut pipeline, &slots).1
    });
    assert_ne!(alone[0].logits, alone[1].logits);

    let mut memory = Memory::of(&parse(&files[2]));
    let exits = files.iter().zip(weights).map(|(file, weights)| exit(parse(file), weights));
    let mut pipeline = plain(exits, &mut memory).expect("enough memory");
    let mut taken = 0;
    let mut found = Vec::new();
    for (number, weights) in weights.iter().enumerate() {
        let (more, classification) = until_classified(&mut pipeline, &slots[taken..]);
        taken += more;
        assert_eq!((taken, usize::from(classification.exit)), (usize::from(SLOTS[number]), number));
        assert_eq!((classification.stop, pipeline.stopped()), (number == 2, number == 2));
        assert_eq!(classification.logits, alone[number].logits);
        let mut evidence = [0; 3];
        for (single, &weight) in alone.iter().zip(*weights) {
            add_evidence(&mut evidence, &single.logits, weight);
        }
        assert_eq!((classification.class, classification.confidence), decide(&evidence));
        found.push(classification);
    }
    assert_eq!(pipeline.push(&slots[0], &mut ()), Err(Error::Full));

    // as sure as wanted is sure enough; nothing is taken after that; the next recording begins with the first exit
    pipeline.set_threshold(found[0].confidence);
    for _ in 0..2 {
        pipeline.reset();
        assert!(!pipeline.stopped());
        let (taken, only) = until_classified(&mut pipeline, &slots);
        assert!(only.stop && pipeline.stopped() && taken == 144);
        assert_eq!((only.exit, only.class, only.confidence), (0, found[0].class, found[0].confidence));
        assert_eq!(pipeline.push(&slots[taken], &mut ()), Err(Error::Full));
    }
}

#[test]
fn slots_of_the_next_recording_may_come_before_a_recognition_is_over() {
    let file = random_model(144, 1);
    let slots = noise_slots(288, 5);
    let mut memory = Memory::of(&parse(&file));
    let mut alone = plain([exit(parse(&file), &[1])], &mut memory).expect("enough memory");
    let (_, first) = until_classified(&mut alone, &slots[..144]);
    alone.reset();
    let (_, second) = until_classified(&mut alone, &slots[144..]);
    // the next recording begins behind every step up to the slow time's last, and two more
    for before in 0..40 {
        let mut memory = Memory::of(&parse(&file));
        let mut overlapped = plain([exit(parse(&file), &[1])], &mut memory).expect("enough memory");
        slots[..144].iter().for_each(|slot| assert_eq!(overlapped.push(slot, &mut ()), Ok(())));
        (0..before).for_each(|_| assert_eq!(overlapped.step(&mut ()), None));
        overlapped.reset();
        let mut waiting = slots[144..].iter().peekable();
        let mut found = Vec::new();
        if before == 0 {
            // one in eight before the first step
            waiting.by_ref().take(18).for_each(|slot| assert_eq!(overlapped.push(slot, &mut ()), Ok(())));
            assert_eq!(overlapped.push(&slots[162], &mut ()), Err(Error::Busy));
        }
        while found.len() < 2 {
            while waiting.peek().is_some_and(|slot| overlapped.push(*slot, &mut ()).is_ok()) {
                waiting.next();
            }
            found.extend(overlapped.step(&mut ()));
        }
        assert_eq!(found, [first.clone(), second.clone()], "{before} steps");
    }
}

#[test]
fn the_only_exit_has_its_networks_confidence() {
    let file = random_model(144, 1);
    // the head's scales, before its numbers: multipliers, biases, shifts and weights of three classes, and a checksum
    let scale_at = file.len() - 4 - 3 * CHANNELS - 4 - 12 - 12 - 4;
    for (scale, weight) in
        [(1.0_f32, 65536), (0.043, 2818), (7.9, 517_734), (8.0, MAX_WEIGHT), (9.0, MAX_WEIGHT)]
    {
        let file = altered(&file, scale_at, &scale.to_le_bytes());
        let model = parse(&file);
        assert_eq!(model.logit_scale(), scale);
        assert_eq!(
            EarlyExit::single(model).weights,
            core::array::from_fn(|k| if k == 0 { weight } else { 0 })
        );
    }
    // a step worth nothing as evidence: the only exit needs no evidence, one of two is refused
    let nothing = altered(&file, scale_at, &1e-6_f32.to_le_bytes());
    let (first, later) = (EarlyExit::single(parse(&nothing)), random_model(200, 2));
    let mut memory = Memory::of(&parse(&later));
    assert_eq!(plain([first], &mut memory).err(), None);
    assert_eq!(plain([first, exit(parse(&later), &[1, 1])], &mut memory).err(), Some(Error::Exits));
}

#[test]
fn far_below_the_best_counts_nothing() {
    let nat = |x: i32| x << 16;
    assert_eq!(decide(&[]), (0, 0.0));
    assert_eq!(decide(&[nat(-17), nat(-17), nat(-17), nat(-17), nat(-17), 0]), (5, 1.0));
    let (class, confidence) = decide(&[nat(-16), nat(-16), nat(-16), nat(-16), nat(-16), 0]);
    assert!(class == 5 && confidence < 1.0);
}

#[test]
fn exits_that_do_not_go_together_are_refused() {
    let files = files();
    let [first, second, third] = files.each_ref().map(|file| exit(parse(file), &[1, 1, 1]));
    let mut memory = Memory::of(&third.model);
    let mut made = |exits: &[EarlyExit<'_>]| plain(exits.iter().copied(), &mut memory).err();
    let refused = Some(Error::Exits);
    assert_eq!(made(&[first, second, third]), None);
    assert_eq!(made(&[]), refused);
    assert_eq!(made(&[second, first]), refused, "descending");
    assert_eq!(made(&[first, first]), refused, "equal");
    assert_eq!(made(&[first, third, second]), refused, "not all ascending");
    for slots in [EXITS, EXITS + 1] {
        let files: Vec<_> = (0..slots).map(|k| random_model(144 + 8 * k as u16, 1)).collect();
        let exits: Vec<_> = files.iter().map(|file| exit(parse(file), &[1; EXITS])).collect();
        assert_eq!(made(&exits), (slots > EXITS).then_some(Error::Exits));
    }
    for (weight, wanted) in [
        (MAX_WEIGHT, None),
        (-MAX_WEIGHT, None),
        (MAX_WEIGHT + 1, refused),
        (-MAX_WEIGHT - 1, refused),
        (0, refused),
    ] {
        assert_eq!(made(&[first, exit(second.model, &[1, weight])]), wanted, "{weight}");
    }
    let other_range = altered(&files[1], 24, &1062_u16.to_le_bytes());
    assert_eq!(made(&[first, exit(parse(&other_range), &[1, 1])]), refused, "preprocessing");
    // a sensor of 500 samples in eight blocks of 62 is none; of 504 it is another one
    let other_radar = altered(&files[1], 48, &[0xf8, 1, 8, 16, 0, 0, 0, 0]);
    assert_eq!(made(&[first, exit(parse(&other_radar), &[1, 1])]), refused, "radar");
    let five_model = parse(sdp3_testkit::models::DSN_200);
    let as_five = random_model_like(&five_model);
    let three = exit(parse(&as_five), &[1]);
    assert_eq!(three.model.preprocessing(), five_model.preprocessing());
    let mut roomy = Memory::of(&five_model);
    assert_eq!(plain([three, exit(five_model, &[1, 1])], &mut roomy).err(), refused, "classes");
}

/// A random network of fewer slots with another's preprocessing.
fn random_model_like(other: &Model<'_>) -> Vec<u8> {
    let file = random_model(144, 1);
    let p = other.preprocessing();
    assert_eq!((p.window, p.hop, p.bins_per_row), (128, 8, 1), "what random_model draws");
    let file = altered(&file, 14, &[p.kept.first, p.kept.last]);
    let file = altered(&file, 24, &p.range.to_le_bytes());
    altered(&file, 28, &p.beta.to_le_bytes())
}

#[test]
fn memory_is_asked_for_to_the_element() {
    let files = files();
    let exits = || files.iter().map(|file| exit(parse(file), &[1, 1, 1]));
    let exact = Memory::of(&parse(&files[2]));
    let made = |memory: &mut Memory| Pipeline::<_, FixedStft>::new(exits(), 2.0, memory.view()).err();
    assert_eq!(made(&mut exact.clone()), None);
    for (wanted, shorten) in SHORTER {
        let mut memory = exact.clone();
        shorten(&mut memory);
        match made(&mut memory) {
            Some(Error::Memory { buffer, need, have }) => assert_eq!((buffer, need), (wanted, have + 1)),
            other => panic!("{wanted}: {other:?}"),
        }
    }
}

/// Bytes of the memory type for a shape, and those that the shape states.
macro_rules! bytes {
    ($slots:expr, $frames:expr, $channels:expr, $stride:expr, $radar:ident) => {{
        const SHAPE: Shape = Shape {
            sensing_slots: $slots,
            frames: $frames,
            channels: $channels,
            stem_stride: $stride,
            arena: 0,
            radar: RadarConfig::$radar,
        };
        (<pipeline_memory!(SHAPE)>::BYTES, SHAPE.required_bytes())
    }};
}

#[test]
fn a_shape_states_the_bytes_of_its_memory() {
    for (bytes, stated) in [
        bytes!(200, 10, 8, 1, PAPER),
        bytes!(201, 10, 8, 1, PAPER),
        bytes!(1000, 110, 16, 2, PAPER),
        bytes!(264, 18, 12, 2, PAPER),
        bytes!(300, 22, 32, 1, BGT60),
        bytes!(1000, 110, 16, 2, IWR),
    ] {
        assert_eq!(bytes, stated);
    }
    // weights, constants; range samples of 200 slots; slow time, 512 complex words for the spectrum
    // and ten frames of log magnitudes, more than three maps of 32 x 5 x 8 and two tiles; whole vectors
    let kernels = 16 * 240 + 4 * 32;
    let all = kernels + 200 * (64 + 8) + 4096 + 64 * 10 * 2 + size_of::<Clutter>();
    assert_eq!(bytes!(200, 10, 8, 1, PAPER).1, (all as usize).next_multiple_of(16));
}
