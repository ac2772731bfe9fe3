//! Everything an object remembers, word by word: to seal it, to keep it through a reset, to bring it back.

/// An object whose state is a fixed number of words.
pub trait State {
    /// Visits every word in a fixed order; what the visitor leaves in a word becomes the state.
    fn words(&mut self, visit: &mut impl FnMut(&mut u32));
}

/// Visits a flag as 0 or 1; any other word is 1.
pub fn flag(flag: &mut bool, visit: &mut impl FnMut(&mut u32)) {
    let mut word = u32::from(*flag);
    visit(&mut word);
    *flag = word != 0;
}

/// Visits a byte; a word's upper bytes are dropped.
pub fn byte(byte: &mut u8, visit: &mut impl FnMut(&mut u32)) {
    let mut word = u32::from(*byte);
    visit(&mut word);
    *byte = word as u8;
}

/// The seal of a state.
///
/// Every step maps the seal so far, for one word, and the word, for one seal so far, one to one (an odd factor, an xor with the
/// own upper half): a change within one word always changes the seal; of changes in more than one word 2^-32 do not.
pub fn seal(state: &mut impl State) -> u32 {
    let mut seal = 0x9e37_79b9_u32;
    state.words(&mut |word| {
        seal = (seal ^ *word).wrapping_mul(0x85eb_ca6b);
        seal ^= seal >> 16;
    });
    seal
}

#[cfg(test)]
mod tests {
    use super::*;

    struct Words([u32; 5]);

    impl State for Words {
        fn words(&mut self, visit: &mut impl FnMut(&mut u32)) {
            self.0.iter_mut().for_each(visit);
        }
    }

    #[test]
    fn every_change_within_a_word_breaks_the_seal() {
        let mut words = Words([0, 1, u32::MAX, 0x8000_0000, 7]);
        let whole = seal(&mut words);
        for at in 0..5 {
            for mask in (0..32).map(|bit| 1 << bit).chain([0xff, 0xffff_0000, u32::MAX]) {
                words.0[at] ^= mask;
                assert_ne!(seal(&mut words), whole, "word {at}, {mask:#x}");
                words.0[at] ^= mask;
            }
        }
        words.0.swap(0, 1);
        assert_ne!(seal(&mut words), whole);
    }

    #[test]
    fn the_seal_is_the_one_described() {
        // worked out by hand, in integers without an end: ((s ^ w) * 0x85ebca6b mod 2^32, then s ^ (s >> 16)) for every word
        assert_eq!(seal(&mut Words([0, 1, u32::MAX, 0x8000_0000, 7])), 0xc973_d8f2);
    }

    #[test]
    fn flags_and_bytes_are_words_and_come_back() {
        for (word, on) in [(0, false), (1, true), (2, true), (u32::MAX, true)] {
            let mut state = !on;
            flag(&mut state, &mut |seen| {
                assert_eq!(*seen, u32::from(!on));
                *seen = word;
            });
            assert_eq!(state, on);
        }
        let mut state = 0xa5;
        byte(&mut state, &mut |seen| {
            assert_eq!(*seen, 0xa5);
            *seen = 0x1234_5678;
        });
        assert_eq!(state, 0x78);
    }
}
