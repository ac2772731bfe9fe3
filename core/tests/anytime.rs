//! Exits one after the other: what each says, when the receiver stops, and which exits do not go together.

mod support;

use sdp3_core::dsn::{Model, Portable};
use sdp3_core::early_exit::{Anytime, EXITS, Evidence, Exit, MAX_WEIGHT, add_evidence, decide};
use sdp3_core::pipeline::{Receiver, ReceiverError};
use sdp3_core::signal::stft::NativeStft;
use support::{CHANNELS, Memory, SHORTER, altered, noise_slots, random_model};

const SLOTS: [u16; 3] = [144, 200, 264];

fn files() -> [Vec<u8>; 3] {
    SLOTS.map(|slots| random_model(slots, u64::from(slots)))
}

fn parse(file: &[u8]) -> Model<'_> {
    Model::parse(file).expect("a model")
}

/// An exit whose own and earlier logits weigh this much.
fn exit<'m>(model: Model<'m>, first: &[i32]) -> Exit<'m, Portable> {
    let mut weights = [0; EXITS];
    weights[..first.len()].copy_from_slice(first);
    Exit { model, kernels: Portable, weights }
}

type Plain<'m, 'b> = Anytime<'m, 'b, Portable>;

fn made<'m>(
    exits: impl IntoIterator<Item = Exit<'m, Portable>>,
    memory: &mut Memory,
) -> Option<ReceiverError> {
    Plain::new(exits, 0.5, memory.view()).err()
}

#[test]
fn every_exit_sums_the_logits_so_far() {
    let files = files();
    let weights: [&[i32]; 3] = [&[4000], &[-3000, 9000], &[1000, 2000, 30_000]];
    let slots = noise_slots(300, 2);
    // each network by itself
    let alone = files.each_ref().map(|file| {
        let model = parse(file);
        let (count, mut memory) = (model.sensing_slots(), Memory::of(&model));
        let mut receiver: Receiver<_, NativeStft> =
            Receiver::with_kernels(model, memory.view(), Portable).expect("enough memory");
        slots[..count].iter().for_each(|slot| assert!(receiver.push(slot, &mut ()).is_ok()));
        receiver.classify(&mut ()).expect("complete")
    });
    assert_ne!(alone[0].logits, alone[1].logits);

    let mut memory = Memory::of(&parse(&files[2]));
    let exits = files.iter().zip(weights).map(|(file, weights)| exit(parse(file), weights));
    let mut receiver = Plain::new(exits, 2.0, memory.view()).expect("enough memory");
    let mut verdicts = Vec::new();
    for (n, slot) in slots.iter().enumerate() {
        if let Some(verdict) = receiver.push(slot, &mut ()) {
            assert_eq!(n + 1, usize::from(SLOTS[verdicts.len()]));
            assert_eq!(receiver.stopped(), verdict.stop);
            verdicts.push(verdict);
        }
    }
    assert_eq!(verdicts.iter().map(|verdict| verdict.stop).collect::<Vec<_>>(), [false, false, true]);
    for (number, (verdict, weights)) in verdicts.iter().zip(weights).enumerate() {
        assert_eq!((usize::from(verdict.exit), &verdict.answer), (number, &alone[number]));
        let mut evidence = Evidence::from_slice(&[0; 3]).expect("three classes");
        for (answer, &weight) in alone.iter().zip(weights) {
            add_evidence(&mut evidence, &answer.logits, weight);
        }
        assert_eq!((verdict.class, verdict.confidence), decide(&evidence));
    }

    // as sure as wanted is sure enough; nothing is said after that; the next recording begins with the first exit
    receiver.set_threshold(verdicts[0].confidence);
    for _ in 0..2 {
        receiver.reset();
        assert!(!receiver.stopped());
        let said: Vec<_> = slots.iter().filter_map(|slot| receiver.push(slot, &mut ())).collect();
        let [only] = said.as_slice() else { panic!("{said:?}") };
        assert!(only.stop && receiver.stopped());
        assert_eq!((only.exit, only.class, only.confidence), (0, verdicts[0].class, verdicts[0].confidence));
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
        let alone = Exit::alone(model, Portable);
        assert_eq!(alone.weights, core::array::from_fn(|k| if k == 0 { weight } else { 0 }));
    }
    let file = altered(&file, scale_at, &0.02_f32.to_le_bytes());
    let mut memory = Memory::of(&parse(&file));
    let mut receiver =
        Plain::new([Exit::alone(parse(&file), Portable)], 2.0, memory.view()).expect("one exit");
    let verdict =
        noise_slots(144, 3).iter().find_map(|slot| receiver.push(slot, &mut ())).expect("a verdict");
    assert!(verdict.answer.confidence < 0.99);
    assert!((verdict.confidence - verdict.answer.confidence).abs() < 0.01, "{verdict:?}");
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
    let [first, second, third] = files.each_ref().map(|file| exit(parse(file), &[1]));
    let mut memory = Memory::of(&third.model);
    let refused = Some(ReceiverError::Exits);
    assert_eq!(made([first.clone(), second.clone(), third.clone()], &mut memory), None);
    assert_eq!(made([], &mut memory), refused);
    assert_eq!(made([second.clone(), first.clone()], &mut memory), refused, "descending");
    assert_eq!(made([first.clone(), first.clone()], &mut memory), refused, "equal");
    assert_eq!(
        made([first.clone(), third.clone(), second.clone()], &mut memory),
        refused,
        "not all ascending"
    );
    for slots in [EXITS, EXITS + 1] {
        let files: Vec<_> = (0..slots).map(|k| random_model(144 + 8 * k as u16, 1)).collect();
        let exits = files.iter().map(|file| exit(parse(file), &[1]));
        assert_eq!(made(exits, &mut memory), (slots > EXITS).then_some(ReceiverError::Exits));
    }

    for (weight, wanted) in
        [(MAX_WEIGHT, None), (-MAX_WEIGHT, None), (MAX_WEIGHT + 1, refused), (-MAX_WEIGHT - 1, refused)]
    {
        assert_eq!(made([first.clone(), exit(second.model.clone(), &[1, weight])], &mut memory), wanted);
    }

    let other_range = altered(&files[1], 24, &1062_u16.to_le_bytes());
    assert_eq!(made([first.clone(), exit(parse(&other_range), &[1])], &mut memory), refused, "preprocessing");
    let five = sdp3_testkit::models::DSN_200;
    let five_model = parse(five);
    let as_five = random_model_like(&five_model);
    let three = exit(parse(&as_five), &[1]);
    assert_eq!(three.model.preprocessing(), five_model.preprocessing());
    let mut roomy = Memory::of(&five_model);
    assert_eq!(made([three, exit(five_model, &[1])], &mut roomy), refused, "classes");
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
    let exits = || files.iter().map(|file| exit(parse(file), &[1]));
    let exact = Memory::of(&parse(&files[2]));
    assert_eq!(made(exits(), &mut exact.clone()), None);
    for (wanted, shorten) in SHORTER.into_iter().take(5) {
        let mut memory = exact.clone();
        shorten(&mut memory);
        match made(exits(), &mut memory) {
            Some(ReceiverError::Memory { buffer, need, have }) => {
                assert_eq!((buffer, need), (wanted, have + 1))
            }
            other => panic!("{wanted}: {other:?}"),
        }
    }
}
