//! Compares kernels with processor instructions with their portable reference, bit for bit, on extreme and random inputs.
#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(not(target_os = "none"))]
fn main() {
    eprintln!("this is firmware: build it with firmware-sim/build");
}

#[cfg(target_os = "none")]
mod firmware {
    use rand_core::{Rng, SeedableRng};
    use rand_xoshiro::Xoshiro128PlusPlus;
    use sdp3_core::signal::dechirp::CHIRP;
    use sdp3_core::simd::NativeDualMac;
    use sdp3_core::simd::depthwise_products::{self, DepthwiseWindow};
    use sdp3_core::simd::dual_mac::{
        BLOCK_COLUMNS, BLOCK_ROWS, DualMac, I16x8, POINTS, plain_outputs, plain_products,
    };
    use sdp3_core::simd::patch_products::{self, Fours, PIXELS};
    use sdp3_core::simd::{
        conj_mac, mulh, native_conj_mac, native_depthwise_products, native_eight_blocks,
        native_largest_of_pairs, native_patch_products, native_widen, patch_pairs,
    };
    use sdp3_firmware_sim::semihosting::{exit, println};

    /// Inputs of each kernel.
    const ROUNDS: usize = 200;

    /// The first rounds are extreme, the others random with ever fewer bits.
    fn draw(random: &mut impl Rng, round: usize) -> i32 {
        let bits = random.next_u32();
        match round {
            0 => i32::MIN,
            1 => i32::MAX,
            2 => [i32::MIN, i32::MAX][(bits & 1) as usize],
            3 => -1,
            4 => 0,
            _ => bits as i32 >> (round % 32),
        }
    }

    fn half(random: &mut impl Rng, round: usize) -> i16 {
        (draw(random, round) >> 16) as i16
    }

    fn same<T: PartialEq>(kernel: &str, round: usize, found: T, expected: T) {
        if found != expected {
            println(format_args!("error: {kernel} differs from its portable reference in round {round}"));
            exit(1);
        }
    }

    /// Products of `GROUPS` groups of four channels.
    fn products<const GROUPS: usize>(random: &mut impl Rng) {
        for round in 0..ROUNDS {
            let mut draw = |tile: &mut [[I16x8; GROUPS]; POINTS]| {
                tile.as_flattened_mut().as_flattened_mut().iter_mut().for_each(|pair| {
                    *pair = i32::from(half(random, round)) & 0xffff | i32::from(half(random, round)) << 16;
                });
            };
            let (mut inputs, mut weights) = ([[[0; 4]; GROUPS]; POINTS], [[[0; 4]; GROUPS]; POINTS]);
            draw(&mut inputs);
            draw(&mut weights);
            let (mut found, mut expected) = ([[[1; 4]; 4]; 5], [[[2; 4]; 4]; 5]);
            NativeDualMac::default().products(&inputs, &weights, &mut found);
            plain_products::<NativeDualMac, GROUPS>(&inputs, &weights, &mut expected);
            same("products", round, found, expected);
        }
    }

    /// Outputs of two of `4 GROUPS` channels, in lines of three pixels and of more.
    fn outputs<const GROUPS: usize>(random: &mut impl Rng) {
        for round in 0..ROUNDS {
            let sums = [[[0; 4]; 4]; 5].map(|column| column.map(|row| row.map(|_: i32| draw(random, round))));
            let constants = [0; 2].map(|_: i32| {
                let [start, multiplier, offset] = [0; 3].map(|_: i32| draw(random, round));
                [start, multiplier & i32::MAX, offset, 4 + (draw(random, 5) & 15)]
            });
            let channel = round % (2 * GROUPS) * 2;
            for row in [BLOCK_COLUMNS, 5].map(|pixels| pixels * 4 * GROUPS) {
                let (mut found, mut expected) = ([[1; 64]; 5 * BLOCK_ROWS], [[1; 64]; 5 * BLOCK_ROWS]);
                let [found_values, values] = [&mut found, &mut expected].map(|all| {
                    &mut all.as_flattened_mut()[..(BLOCK_ROWS - 1) * row + BLOCK_COLUMNS * 4 * GROUPS]
                });
                plain_outputs::<GROUPS>(&sums, &constants, values, row, channel);
                NativeDualMac::default().outputs::<GROUPS>(
                    &mut sums.clone(),
                    &constants,
                    found_values,
                    row,
                    channel,
                );
                same("outputs", round, found, expected);
            }
        }
    }

    /// At a word's address, where the instructions load from.
    #[repr(align(4))]
    struct WordAligned<T>(T);

    /// The paper's eight blocks of 125 samples, and blocks of other lengths.
    fn dechirping(random: &mut impl Rng) {
        for round in 0..ROUNDS {
            let slot = WordAligned(core::array::from_fn::<_, 1000, _>(|_| {
                [half(random, round), half(random, round)]
            }));
            let reference = WordAligned(CHIRP);
            for (block, samples) in [(125, 1000), (128, 1000), (250, 1000), (64, 256), (63, 900)] {
                let (slot, reference) = (&slot.0[..samples], &reference.0[..samples]);
                let (mut found, mut expected) = ([[0; 2]; 8], [[0; 2]; 8]);
                native_conj_mac(slot, reference, block, &mut found);
                conj_mac::portable(slot, reference, block, &mut expected);
                same("dechirp", round, found, expected);
            }
            let expected = conj_mac::eight_blocks(&slot.0, &reference.0);
            same(
                "dechirp of the paper's blocks",
                round,
                native_eight_blocks(&slot.0, &reference.0),
                expected,
            );
        }
    }

    fn upper_words(random: &mut impl Rng) {
        for round in 0..16 * ROUNDS {
            let [a, b, sum] = [0; 3].map(|_: i32| draw(random, round / 16));
            same("upper word", round, mulh::mulh(a, b), mulh::plain(a, b));
            let expected = sum.wrapping_add(mulh::plain(a, b));
            same("sum of upper words", round, mulh::mla_h(sum, a, b), expected);
        }
    }

    /// Sums of pairs for up to 16 channels.
    fn pairs(random: &mut impl Rng) {
        for round in 0..ROUNDS {
            let pairs = [[0; 5]; 4].map(|pairs| pairs.map(|_: i32| draw(random, round)));
            let channels = [[0; patch_pairs::WORDS]; 16].map(|words| {
                let mut words = words.map(|_: i32| draw(random, round));
                let [.., multiplier, _, shift] = &mut words;
                (*multiplier, *shift) = (*multiplier & i32::MAX, *shift & 31);
                words
            });
            let (mut found, mut expected) = ([1; 16], [1; 16]);
            let count = round % 17;
            native_largest_of_pairs(&pairs, &channels, &mut found[..count]);
            patch_pairs::portable(&pairs, &channels, &mut expected[..count]);
            same("sums of pairs", round, found, expected);
        }
    }

    /// Windows of up to 23 fours of values, and their products with as many weights and with fewer.
    fn patches(random: &mut impl Rng) {
        for round in 0..ROUNDS {
            let fours = round % 23 + 1;
            let (mut patch, mut expected) = ([Fours::ZERO; 23], [Fours::ZERO; 23]);
            let zero = draw(random, round) as i8;
            for pixel in 0..PIXELS {
                let values: [[i8; 4]; 23] =
                    [[0; 4]; 23].map(|four| four.map(|_: i8| draw(random, round) as i8));
                native_widen(&values[..fours], zero, &mut patch, pixel);
                patch_products::widen(&values[..fours], zero, &mut expected, pixel);
            }
            same("windows", round, patch, expected);
            let weights: [[u8; 4]; 23] = [[0; 4]; 23].map(|four| four.map(|_: u8| draw(random, round) as u8));
            for weights in [&weights[..fours], &weights[..fours / 2]] {
                let mut found = [0; PIXELS].map(|_: i32| draw(random, round));
                let mut expected = found;
                native_patch_products(&patch[..fours], weights, &mut found);
                patch_products::portable(&patch[..fours], weights, &mut expected);
                same("products of windows", round, found, expected);
            }
        }
    }

    /// Windows of up to three rows and columns; those that reach beyond the values add nothing.
    fn depthwise(random: &mut impl Rng) {
        for round in 0..ROUNDS {
            let input: [i8; 120] = [0; 120].map(|_: i8| draw(random, round) as i8);
            let weights: [u8; 60] = [0; 60].map(|_: u8| draw(random, round) as u8);
            let [rows, columns, channels] = [round % 4, round / 4 % 4, 4 + round % 3];
            let window = DepthwiseWindow {
                rows,
                columns,
                channels,
                input_row: 5 * channels,
                weight_row: 3 * channels,
            };
            let zero = draw(random, round) as i8;
            let mut found = [0; 4].map(|_: i32| draw(random, round));
            let mut expected = found;
            native_depthwise_products(&input[1..], &weights, &window, zero, &mut found);
            depthwise_products::portable(&input[1..], &weights, &window, zero, &mut expected);
            same("depthwise products", round, found, expected);
            let before = found;
            let [input_reach, weight_reach] = window.reach();
            native_depthwise_products(&input[..input_reach - 1], &weights, &window, zero, &mut found);
            native_depthwise_products(&input, &weights[..weight_reach - 1], &window, zero, &mut found);
            same("windows out of reach", round, found, before);
        }
    }

    #[allow(unsafe_code)] // the symbol that start-up calls
    #[unsafe(no_mangle)]
    extern "C" fn firmware_main() -> ! {
        let mut random = Xoshiro128PlusPlus::seed_from_u64(9);
        products::<1>(&mut random);
        products::<2>(&mut random);
        products::<4>(&mut random);
        products::<8>(&mut random);
        products::<16>(&mut random);
        outputs::<2>(&mut random);
        outputs::<4>(&mut random);
        outputs::<8>(&mut random);
        outputs::<16>(&mut random);
        pairs(&mut random);
        patches(&mut random);
        depthwise(&mut random);
        dechirping(&mut random);
        upper_words(&mut random);
        println(format_args!("kernels agree"));
        exit(0)
    }
}
