//! CMSIS-NN's functions and their parameters: what arm_nn_types.h and arm_nnfunctions.h declare.

#[repr(C)]
pub struct Context {
    pub buffer: *mut u64,
    pub size: i32,
}

#[repr(C)]
pub struct Dims {
    pub n: i32,
    pub h: i32,
    pub w: i32,
    pub c: i32,
}

#[repr(C)]
#[derive(Clone, Copy)]
pub struct Tile {
    pub w: i32,
    pub h: i32,
}

#[repr(C)]
#[derive(Clone, Copy)]
pub struct Activation {
    pub min: i32,
    pub max: i32,
}

#[repr(C)]
pub struct Convolution {
    pub offsets: [i32; 2],
    pub stride: Tile,
    pub padding: Tile,
    pub dilation: Tile,
    pub activation: Activation,
}

#[repr(C)]
pub struct Depthwise {
    pub offsets: [i32; 2],
    pub multiplier: i32,
    pub stride: Tile,
    pub padding: Tile,
    pub dilation: Tile,
    pub activation: Activation,
}

#[repr(C)]
pub struct Pooling {
    pub stride: Tile,
    pub padding: Tile,
    pub activation: Activation,
}

#[repr(C)]
pub struct Dense {
    pub input_offset: i32,
    pub filter_offset: i32,
    pub output_offset: i32,
    pub activation: Activation,
}

#[repr(C)]
pub struct PerChannel {
    pub multiplier: *const i32,
    pub shift: *const i32,
}

#[repr(C)]
pub struct Quantization {
    pub multiplier: *const i32,
    pub shift: *const i32,
    pub per_channel: i32,
}

#[allow(unsafe_code)]
unsafe extern "C" {
    pub fn arm_convolve_wrapper_s8_get_buffer_size(
        parameters: *const Convolution,
        input: *const Dims,
        filter: *const Dims,
        output: *const Dims,
    ) -> i32;
    pub fn arm_convolve_wrapper_s8(
        context: *const Context,
        parameters: *const Convolution,
        quantization: *const PerChannel,
        input: *const Dims,
        input_data: *const i8,
        filter: *const Dims,
        filter_data: *const u8,
        bias: *const Dims,
        bias_data: *const i32,
        output: *const Dims,
        output_data: *mut i8,
    ) -> i32;
    pub fn arm_depthwise_conv_wrapper_s8_get_buffer_size(
        parameters: *const Depthwise,
        input: *const Dims,
        filter: *const Dims,
        output: *const Dims,
    ) -> i32;
    pub fn arm_depthwise_conv_wrapper_s8(
        context: *const Context,
        parameters: *const Depthwise,
        quantization: *const PerChannel,
        input: *const Dims,
        input_data: *const i8,
        filter: *const Dims,
        filter_data: *const u8,
        bias: *const Dims,
        bias_data: *const i32,
        output: *const Dims,
        output_data: *mut i8,
    ) -> i32;
    pub fn arm_fully_connected_s8_get_buffer_size(filter: *const Dims) -> i32;
    pub fn arm_vector_sum_s8(
        sums: *mut u64,
        columns: i32,
        rows: i32,
        weights: *const u8,
        input_offset: i32,
        filter_offset: i32,
        bias: *const i32,
    ) -> i32;
    pub fn arm_fully_connected_wrapper_s8(
        context: *const Context,
        parameters: *const Dense,
        quantization: *const Quantization,
        input: *const Dims,
        input_data: *const i8,
        filter: *const Dims,
        filter_data: *const u8,
        bias: *const Dims,
        bias_data: *const i32,
        output: *const Dims,
        output_data: *mut i8,
    ) -> i32;
    pub fn arm_elementwise_add_s8(
        first: *const i8,
        second: *const i8,
        first_offset: i32,
        first_multiplier: i32,
        first_shift: i32,
        second_offset: i32,
        second_multiplier: i32,
        second_shift: i32,
        left_shift: i32,
        output: *mut i8,
        out_offset: i32,
        out_multiplier: i32,
        out_shift: i32,
        min: i32,
        max: i32,
        values: i32,
    ) -> i32;
    pub fn arm_avgpool_s8_get_buffer_size(columns: i32, channels: i32) -> i32;
    pub fn arm_avgpool_s8(
        context: *const Context,
        parameters: *const Pooling,
        input: *const Dims,
        input_data: *const i8,
        filter: *const Dims,
        output: *const Dims,
        output_data: *mut i8,
    ) -> i32;
    pub fn arm_max_pool_s8(
        context: *const Context,
        parameters: *const Pooling,
        input: *const Dims,
        input_data: *const i8,
        filter: *const Dims,
        output: *const Dims,
        output_data: *mut i8,
    ) -> i32;
    pub fn arm_softmax_s8(
        input: *const i8,
        rows: i32,
        values: i32,
        multiplier: i32,
        shift: i32,
        least_difference: i32,
        output: *mut i8,
    );
}
