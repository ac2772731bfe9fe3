//! Which models a firmware with a key takes: one file as it is, then bits flipped in its memory, then the same with a corrected
//! checksum.
//!
//! Arguments: the model file; `oldest=N`, the oldest revision that is taken; `flips=N`, how many of each. The key is
//! `sdp3_testkit::models::PUBLIC_KEY`. Exit code 0 if no altered model was taken, 1 if one was.
#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(not(target_os = "none"))]
fn main() {
    eprintln!("this is firmware: build it with firmware-sim/build");
}

#[cfg(target_os = "none")]
mod firmware {
    use rand_core::{Rng, SeedableRng};
    use sdp3_core::dsn::model::{KEY_LEN, crc32};
    use sdp3_core::dsn::{Model, ModelError};
    use sdp3_firmware_sim::rt::Single;
    use sdp3_firmware_sim::semihosting::{File, arguments, exit, println};

    static KEY: &[u8; KEY_LEN] = sdp3_testkit::models::PUBLIC_KEY;
    static MODEL: Single<[u8; 1 << 16]> = Single::new([0; 1 << 16]);

    fn fail(text: &str) -> ! {
        println(format_args!("{text}"));
        exit(2)
    }

    /// The file's bytes.
    fn load<'b>(path: &str, memory: &'b mut [u8]) -> Option<&'b mut [u8]> {
        let mut file = File::open(path)?;
        let whole = memory.get_mut(..file.length()?)?;
        file.read(whole).then_some(whole)
    }

    /// Flips one seeded bit a time, corrects the checksum if wanted, and counts what is refused as `wanted` and what is taken.
    fn alter(model: &mut [u8], times: u32, correct: bool) -> (u32, u32) {
        let mut rng = rand_xoshiro::Xoshiro128PlusPlus::seed_from_u64(u64::from(times));
        let content = model.len().saturating_sub(4);
        let Some(checksum) = model.last_chunk::<4>().copied() else { return (0, 0) };
        let (mut refused, mut taken) = (0, 0);
        for _ in 0..times {
            let draw = rng.next_u32();
            let at = ((u64::from(draw >> 3) * content as u64) >> 29) as usize;
            let flip =
                |model: &mut [u8]| model.iter_mut().skip(at).take(1).for_each(|b| *b ^= 1 << (draw & 7));
            flip(model);
            if correct {
                let checksum = crc32(model.get(..content).unwrap_or_default()).to_le_bytes();
                model.iter_mut().skip(content).zip(checksum).for_each(|(to, from)| *to = from);
            }
            match Model::parse_signed(model, KEY, 0) {
                Ok(_) => taken += 1,
                Err(ModelError::Signature) => refused += 1,
                // magic, version, lengths and the flag of the signature are looked at before the signature
                Err(_) => refused += u32::from(!correct || at < 64),
            }
            flip(model);
            model.iter_mut().skip(content).zip(checksum).for_each(|(to, from)| *to = from);
        }
        (refused, taken)
    }

    #[allow(unsafe_code)] // the symbol that start-up calls
    #[unsafe(no_mangle)]
    extern "C" fn firmware_main() -> ! {
        let mut text = [0; 1024];
        let mut words = arguments(&mut text).split_ascii_whitespace();
        let Some(path) = words.next() else { fail("no model file given") };
        let (mut oldest, mut flips) = (0_u32, 0_u32);
        for word in words {
            match word.split_once('=').map(|(name, value)| (name, value.parse())) {
                Some(("oldest", Ok(number))) => oldest = number,
                Some(("flips", Ok(number))) => flips = number,
                _ => fail("an argument is neither oldest=N nor flips=N"),
            }
        }
        let Some(memory) = MODEL.take() else { fail("no memory") };
        let Some(model) = load(path, memory) else { fail("no such file, or larger than 64 KiB") };
        match Model::parse_signed(model, KEY, oldest) {
            Ok(taken) => println(format_args!("accepted: revision {}", taken.revision())),
            Err(error) => println(format_args!("refused: {error}")),
        }
        let mut altered = 0;
        for (what, correct, times) in
            [("flipped", false, flips), ("flipped, checksum corrected", true, flips / 10)]
        {
            let (refused, taken) = alter(model, times, correct);
            println(format_args!("{what}: {times} models, {refused} refused, {taken} accepted"));
            altered += taken + (times - refused - taken);
        }
        exit(usize::from(altered != 0))
    }
}
