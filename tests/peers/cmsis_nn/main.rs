//! The peer of the program `graph`: the same network on the same input by CMSIS-NN's public functions, in the same words.
//!
//! Linked with a library that its user has built (`tests/networks --cmsis-nn`). Sums that CMSIS-NN takes of constant weights (Helium)
//! are not counted, as it takes them once.
#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(not(target_os = "none"))]
fn main() {
    eprintln!("this is firmware: build it with firmware-sim/build");
}

#[cfg(target_os = "none")]
mod functions;

#[cfg(target_os = "none")]
mod firmware {
    use crate::functions::*;
    use sdp3_core::crc32::Crc32;
    use sdp3_core::dsn::add::Add;
    use sdp3_core::graph::{Kind, Node};
    use sdp3_firmware_sim::graph_files::{fail, load};
    use sdp3_firmware_sim::rt::{Single, instructions, start_counter};
    use sdp3_firmware_sim::semihosting::{exit, println};

    /// Most output channels of an operator.
    const CHANNELS: usize = 1 << 10;

    static NETWORK: Single<[u8; 1 << 18]> = Single::new([0; 1 << 18]);
    static INPUT: Single<[u8; 1 << 16]> = Single::new([0; 1 << 16]);
    static ARENA: Single<[i8; 1 << 17]> = Single::new([0; 1 << 17]);
    static SCRATCH: Single<[u64; 1 << 13]> = Single::new([0; 1 << 13]);
    static SCALES: Single<Scales> = Single::new(Scales::ZERO);

    /// Biases, multipliers and shifts of an operator's output channels.
    struct Scales {
        biases: [i32; CHANNELS],
        multipliers: [i32; CHANNELS],
        shifts: [i32; CHANNELS],
    }

    impl Scales {
        const ZERO: Scales =
            Scales { biases: [0; CHANNELS], multipliers: [0; CHANNELS], shifts: [0; CHANNELS] };

        fn set(&mut self, channel: usize, bias: i32, (multiplier, shift): (i32, i32)) {
            let places = [&mut self.biases, &mut self.multipliers, &mut self.shifts];
            for (place, value) in places.into_iter().zip([bias, multiplier, shift]) {
                match place.get_mut(channel) {
                    Some(to) => *to = value,
                    None => fail("an operator has too many channels"),
                }
            }
        }

        fn read(&mut self, node: &Node<'_>) {
            if node.kind == Some(Kind::FullyConnected) {
                let dense = node.dense();
                for (o, (ratio, bias)) in dense.ratios.iter().zip(dense.biases).enumerate() {
                    self.set(o, i32::from_le_bytes(*bias), fixed_point(f64::from_le_bytes(*ratio)));
                }
            } else {
                let quant = node.quantization();
                for o in 0..quant.channels {
                    let (multiplier, shift) = quant.scale(o);
                    self.set(o, quant.bias(o), (multiplier, i32::from(shift)));
                }
            }
        }

        fn per_channel(&self) -> PerChannel {
            PerChannel { multiplier: self.multipliers.as_ptr(), shift: self.shifts.as_ptr() }
        }
    }

    /// A positive normal number as a Q0.31 multiplier in 2^30..2^31 and a shift to the left.
    fn fixed_point(ratio: f64) -> (i32, i32) {
        let bits = ratio.to_bits();
        let exponent = (bits >> 52) as i32 - 1022;
        let mantissa = (bits & ((1 << 52) - 1)) | 1 << 52;
        let multiplier = (mantissa + (1 << 21)) >> 22;
        if multiplier == 1 << 31 { (1 << 30, exponent + 1) } else { (multiplier as i32, exponent) }
    }

    /// Computes an operator; returns its instructions and the bytes of memory that it needs beside the arena.
    #[allow(unsafe_code)] // CMSIS-NN's functions: every buffer is as long as its dimensions say
    fn compute(
        node: &Node<'_>,
        arena: &mut [i8],
        scratch: &mut [u64],
        scales: &mut Scales,
    ) -> Option<(u64, i32)> {
        let tile = |[h, w]: [u8; 2]| Tile { w: i32::from(w), h: i32::from(h) };
        let (stride, padding) = (tile(node.window.stride), tile(node.window.padding));
        let dilation = Tile { w: 1, h: 1 };
        let [min, max] = node.activation.map(i32::from);
        let activation = Activation { min, max };
        let [zero, out_zero, _] = node.zero_points.map(i32::from);
        let offsets = [-zero, out_zero];
        let dims =
            |n: usize, [h, w, c]: [usize; 3]| Dims { n: n as i32, h: h as i32, w: w as i32, c: c as i32 };
        let [_, _, inputs] = node.input.shape();
        let [_, _, outputs] = node.output.shape();
        let [h, w] = node.window_size();
        let (from, to, bias) =
            (dims(1, node.input.shape()), dims(1, node.output.shape()), dims(1, [1, 1, outputs]));
        let context = |bytes: i32, scratch: &mut [u64]| {
            if bytes as usize > size_of_val(scratch) {
                fail("the memory of the kernels is too small")
            }
            Context { buffer: scratch.as_mut_ptr(), size: bytes }
        };
        let base = arena.as_mut_ptr();
        let [input, second, output] =
            [node.input.at, node.second, node.output.at].map(|at| base.wrapping_add(at as usize));
        let (status, count, bytes);
        match node.kind? {
            Kind::Convolution => {
                scales.read(node);
                let (filter, weights) = (dims(outputs, [h, w, inputs]), node.quantization().weights.as_ptr());
                let parameters = Convolution { offsets, stride, padding, dilation, activation };
                // SAFETY: shapes alone
                bytes = unsafe { arm_convolve_wrapper_s8_get_buffer_size(&parameters, &from, &filter, &to) };
                let (context, quant) = (context(bytes, scratch), scales.per_channel());
                let before = instructions();
                // SAFETY: see above
                status = unsafe {
                    arm_convolve_wrapper_s8(
                        &context,
                        &parameters,
                        &quant,
                        &from,
                        input,
                        &filter,
                        weights,
                        &bias,
                        scales.biases.as_ptr(),
                        &to,
                        output,
                    )
                };
                count = instructions() - before;
            }
            Kind::DepthwiseConvolution => {
                scales.read(node);
                let (filter, weights) = (dims(1, [h, w, outputs]), node.quantization().weights.as_ptr());
                let multiplier = (outputs / inputs.max(1)) as i32;
                let parameters = Depthwise { offsets, multiplier, stride, padding, dilation, activation };
                // SAFETY: shapes alone
                bytes = unsafe {
                    arm_depthwise_conv_wrapper_s8_get_buffer_size(&parameters, &from, &filter, &to)
                };
                let (context, quant) = (context(bytes, scratch), scales.per_channel());
                let before = instructions();
                // SAFETY: see above
                status = unsafe {
                    arm_depthwise_conv_wrapper_s8(
                        &context,
                        &parameters,
                        &quant,
                        &from,
                        input,
                        &filter,
                        weights,
                        &bias,
                        scales.biases.as_ptr(),
                        &to,
                        output,
                    )
                };
                count = instructions() - before;
            }
            Kind::FullyConnected => {
                scales.read(node);
                let (taps, weights) = (node.taps(), node.dense().weights.as_ptr());
                let (from, filter) = (dims(1, [1, 1, taps]), dims(taps, [1, 1, outputs]));
                let parameters =
                    Dense { input_offset: -zero, filter_offset: 0, output_offset: out_zero, activation };
                // SAFETY: shapes alone
                bytes = unsafe { arm_fully_connected_s8_get_buffer_size(&filter) };
                let context = context(bytes, scratch);
                if bytes > 0 {
                    // SAFETY: the buffer is as long as the function before says
                    unsafe {
                        arm_vector_sum_s8(
                            context.buffer,
                            taps as i32,
                            outputs as i32,
                            weights,
                            -zero,
                            0,
                            scales.biases.as_ptr(),
                        )
                    };
                }
                let PerChannel { multiplier, shift } = scales.per_channel();
                let quant = Quantization { multiplier, shift, per_channel: 1 };
                let before = instructions();
                // SAFETY: see above
                status = unsafe {
                    arm_fully_connected_wrapper_s8(
                        &context,
                        &parameters,
                        &quant,
                        &from,
                        input,
                        &filter,
                        weights,
                        &bias,
                        scales.biases.as_ptr(),
                        &to,
                        output,
                    )
                };
                count = instructions() - before;
            }
            Kind::Add => {
                let Add { in_zp, out_zp, multiplier, out_multiplier, shift, out_shift, .. } = node.addition();
                let ([a, b], [shift_a, shift_b]) = (in_zp.map(|zero| -i32::from(zero)), shift.map(i32::from));
                bytes = 0;
                let before = instructions();
                // SAFETY: see above
                status = unsafe {
                    arm_elementwise_add_s8(
                        input,
                        second,
                        a,
                        multiplier[0],
                        shift_a,
                        b,
                        multiplier[1],
                        shift_b,
                        20,
                        output,
                        i32::from(out_zp),
                        out_multiplier,
                        i32::from(out_shift),
                        min,
                        max,
                        node.output.bytes() as i32,
                    )
                };
                count = instructions() - before;
            }
            kind @ (Kind::AveragePool | Kind::MaxPool) => {
                let (parameters, filter) = (Pooling { stride, padding, activation }, dims(1, [h, w, 1]));
                // SAFETY: shapes alone
                bytes = unsafe { arm_avgpool_s8_get_buffer_size(to.w, to.c) };
                let context = context(bytes, scratch);
                let pool = if kind == Kind::MaxPool { arm_max_pool_s8 } else { arm_avgpool_s8 };
                let before = instructions();
                // SAFETY: see above
                status = unsafe { pool(&context, &parameters, &from, input, &filter, &to, output) };
                count = instructions() - before;
            }
            Kind::Softmax => {
                let scale = node.softmax();
                let rows = (node.output.bytes() / outputs.max(1)) as i32;
                (status, bytes) = (0, 0);
                let before = instructions();
                // SAFETY: see above
                unsafe {
                    arm_softmax_s8(
                        input,
                        rows,
                        outputs as i32,
                        scale.multiplier,
                        scale.shift,
                        scale.least_difference,
                        output,
                    );
                }
                count = instructions() - before;
            }
        }
        (status == 0).then_some((count, bytes))
    }

    #[allow(unsafe_code)] // the symbol that start-up calls
    #[unsafe(no_mangle)]
    extern "C" fn firmware_main() -> ! {
        start_counter();
        let memory = (NETWORK.take(), INPUT.take(), ARENA.take(), SCRATCH.take(), SCALES.take());
        let (Some(network), Some(input), Some(arena), Some(scratch), Some(scales)) = memory else {
            fail("memory is taken")
        };
        let graph = load(network, input, arena);
        let (mut all, mut most) = (0, 0);
        for (operator, node) in graph.nodes().enumerate() {
            let Some((count, bytes)) = compute(&node, arena, scratch, scales) else {
                fail("CMSIS-NN refuses an operator")
            };
            let values = arena.get(node.output.range()).unwrap_or(&[]);
            let checksum =
                values.iter().fold(Crc32::new(), |sum, &value| sum.update(&[value as u8])).finish();
            let kind = node.kind.map_or("", Kind::name);
            println(format_args!("work {operator}-{kind} {checksum:08x} {count}"));
            (all, most) = (all + count, most.max(bytes));
        }
        println(format_args!("all {all} memory {}", graph.arena() + most as usize));
        exit(0)
    }
}
