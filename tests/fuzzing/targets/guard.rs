//! Whatever numbers a radio gives and whatever happens to the memory, a watched schedule answers, tells once, and recovers.
#![no_main]

use libfuzzer_sys::fuzz_target;
use sdp3_core::supervision::watch::{Fault, WORDS, Watch};
use sdp3_core::scheduler::{USERS, Sensing};
use sdp3_core::state::State;
use sdp3_fuzz::Bytes;

fn sensing(bytes: &mut Bytes<'_>) -> Sensing {
    let (period, spacing) = (1 + u32::from(bytes.u8()), u32::from(bytes.u8()) % 6);
    let slots = u32::from(bytes.u8()) % (period / (spacing + 1) + 1);
    Sensing::new(period, spacing, slots).expect("it fits")
}

fuzz_target!(|data: &[u8]| {
    let mut bytes = Bytes(data);
    let mut number = bytes.u32();
    let mut watch = Watch::new(sensing(&mut bytes), std::array::from_fn(|_| u32::from(bytes.u8())), number);
    let mut memory = [0; WORDS];
    while !bytes.is_empty() {
        match bytes.u8() {
            0..16 => _ = watch.set_rate(usize::from(bytes.u8()) % (USERS + 1), bytes.u32()),
            16..32 => _ = watch.set_sensing(sensing(&mut bytes)),
            32..48 => _ = watch.lose(),
            48..56 => _ = watch.end_sensing(),
            56..72 => number = number.wrapping_add(u32::from(bytes.u8())),
            72..80 => number = bytes.u32(),
            80..88 => watch.save(&mut memory),
            88..96 => watch = Watch::restore(&memory).unwrap_or(watch),
            96..104 => {
                let at = usize::from(bytes.u8()) % WORDS;
                memory[at] ^= bytes.u32();
            }
            104..120 => {
                let (at, mask, mut n) = (usize::from(bytes.u8()) % WORDS, bytes.u32(), 0);
                watch.words(&mut |word| {
                    *word ^= if n == at { mask } else { 0 };
                    n += 1;
                });
            }
            120..124 => watch.configure(sensing(&mut bytes), std::array::from_fn(|_| u32::from(bytes.u8()))),
            count => {
                for _ in 0..count - 100 {
                    let step = watch.next(number);
                    number = number.wrapping_add(1);
                    let skipped = if let Some(Fault::Skipped { slots, .. }) = step.fault { slots } else { 0 };
                    assert!(!step.begins || watch.scheduler().position() <= 1 + skipped);
                    if step.fault == Some(Fault::Forgotten) {
                        watch.configure(sensing(&mut bytes), [1; USERS]);
                    }
                }
                // after three slots in order nothing is told any more, but what lay in wait for the next period
                for _ in 0..3 {
                    watch.next(number);
                    number = number.wrapping_add(1);
                }
                let fault = watch.next(number).fault;
                number = number.wrapping_add(1);
                assert!(matches!(fault, None | Some(Fault::Spare)), "{fault:?}");
            }
        }
    }
});
