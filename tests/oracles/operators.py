"""Golden .tflite files of one operator or a few: LiteRT's reference kernels on every operator an import knows.

The graphs are put together by hand from LiteRT's schema and run by ai-edge-litert with the BUILTIN_REF resolver (the
portable reference kernels, no delegate). `operators.json` holds the files, some inputs and what LiteRT computed of
them: for each input the outputs of all operators but RESHAPE, in the order of the file. After them come files that must
be refused, with a part of the message; LiteRT runs some of those, refuses others and aborts on a few.

A second opinion inside: every output is computed again by a few lines of numpy. Where a rounding or a formula could be
another, the values that would tell are counted, so that a LiteRT build with the other one cannot pass unnoticed.

    pip install ai-edge-litert==2.3.0 numpy==2.4.6 flatbuffers==25.12.19
    python operators.py
"""

import base64
import binascii
import json
import math
from collections import Counter
from importlib.metadata import version
from itertools import product
from pathlib import Path

import flatbuffers
import numpy as np
from ai_edge_litert import schema_py_generated as tfl

import network
import networks
from network import quantize, requantize, requantize_once

INT8, INT16, INT32, FLOAT32 = (getattr(tfl.TensorType, name) for name in ("INT8", "INT16", "INT32", "FLOAT32"))
SAME, VALID = tfl.Padding.SAME, tfl.Padding.VALID
NONE, RELU, RELU6 = (getattr(tfl.ActivationFunctionType, name) for name in ("NONE", "RELU", "RELU6"))
UNIT = tfl.ActivationFunctionType.RELU_N1_TO_1
# first version of an operator that knows int8, where it is not 2
VERSIONS = {"CONV_2D": 3, "DEPTHWISE_CONV_2D": 3, "FULLY_CONNECTED": 4, "RESHAPE": 1}
# a scale at which 6 / scale rounds up in float32 and down in float64
RELU6_SCALE = 0.11428571492433548


class Graph(network.Graph):
    """A .tflite graph that grows by operators; `x` is the tensor that the next one reads."""

    def __init__(self, name, shape, scale=0.02, zero=-3, count=4):
        self.name, self.count, self.rng = name, count, np.random.default_rng(binascii.crc32(name.encode()))
        self.tensors, self.buffers, self.ops, self.codes = [], [tfl.BufferT()], [], []
        self.given, self.subgraphs = None, 1
        self.x = self.tensor([1, *shape], INT8, scale, zero)
        self.inputs, self.outputs = [self.x], None

    def shape(self):
        return self.tensors[self.x].shape[1:]

    def operator(self, name, inputs, shape, grid, options=None, **fields):
        """Adds an operator with a new output, [1, shape]."""
        table = getattr(tfl, options + "T")() if options else None
        for field, value in fields.items():
            assert hasattr(table, field), field
            setattr(table, field, value)
        output = self.tensor([1, *shape], INT8, *grid)
        self.op(getattr(tfl.BuiltinOperator, name), inputs, output, table, getattr(tfl.BuiltinOptions, options or "NONE"))
        self.x = output
        return self

    def weighted(self, shape, outputs, taps, grid, ratios, most, per_channel, bias, axis=0):
        """Inputs of an operator with weights up to `most`; their sums fill the output, or are scaled by `ratios`.

        `bias`: True, "ties" for sums next to a tie, False for two inputs, or None for the index -1."""
        s_in, z_in = self.params(self.x)
        spread = math.sqrt(taps * (most * (most + 1) / 3) * (74**2 + z_in**2))
        if ratios is None:
            ratios = np.exp(self.rng.uniform(-0.7, 0.7, outputs if per_channel else 1)) * 45 / spread
        scales = np.float32(np.asarray(ratios) * np.float32(grid[0]) / float(s_in))
        data = self.rng.integers(-most, most + 1, shape).astype(np.int8)
        inputs = [self.x, self.tensor(shape, INT8, scales, 0, data, axis)]
        biases = self.rng.integers(-int(spread), int(spread) + 1, outputs).astype(np.int32)
        if bias == "ties":
            ratios = float(s_in) * scales.astype(float) / float(np.float32(grid[0]))
            biases = np.round((self.rng.integers(-90, 90, outputs) + 0.5) / ratios).astype(np.int32)
        if bias:
            inputs.append(self.tensor([outputs], INT32, s_in * scales, 0, biases))
        return inputs if bias is not None else [*inputs, -1]

    def conv(self, outputs, window, stride=(1, 1), padding=SAME, activation=NONE, grid=(0.05, -10), ratios=None, most=127,
             per_channel=True, bias=True, depthwise=False):
        h, w, c = self.shape()
        shape = [1, *window, outputs] if depthwise else [outputs, *window, c]
        taps = math.prod(window) * (1 if depthwise else c)
        inputs = self.weighted(shape, outputs, taps, grid, ratios, most, per_channel, bias, 3 if depthwise else 0)
        places = [len(list(places_of(*axis, padding == SAME))) for axis in zip((h, w), window, stride)]
        name, options = ("DEPTHWISE_CONV_2D", "DepthwiseConv2DOptions") if depthwise else ("CONV_2D", "Conv2DOptions")
        more = {"depthMultiplier": outputs // c} if depthwise else {}
        return self.operator(name, inputs, [*places, outputs], grid, options, padding=padding, strideH=stride[0],
                             strideW=stride[1], fusedActivationFunction=activation, **more)

    def depthwise(self, multiplier, window, *arguments, **more):
        return self.conv(self.shape()[2] * multiplier, window, *arguments, **more, depthwise=True)

    def dense(self, units, activation=NONE, grid=(0.05, -10), ratios=None, most=1, per_channel=True, bias=True, keep=False):
        """Weights are small by default, so that there are few accumulators between two outputs."""
        taps = math.prod(self.shape())
        inputs = self.weighted([units, taps], units, taps, grid, ratios, most, per_channel, bias)
        shape = [*self.shape()[:-1], units] if keep else [units]
        return self.operator("FULLY_CONNECTED", inputs, shape, grid, "FullyConnectedOptions", keepNumDims=keep,
                             fusedActivationFunction=activation)

    def pool(self, name, window, stride=None, padding=VALID, activation=NONE):
        h, w, c = self.shape()
        stride = stride or window
        places = [len(list(places_of(*axis, padding == SAME))) for axis in zip((h, w), window, stride)]
        return self.operator(name, [self.x], [*places, c], self.params(self.x), "Pool2DOptions", padding=padding,
                             strideH=stride[0], strideW=stride[1], filterHeight=window[0], filterWidth=window[1],
                             fusedActivationFunction=activation)

    def plus(self, first, second, grid=(0.05, -10), activation=NONE):
        return self.operator("ADD", [first, second], self.shape(), grid, "AddOptions", fusedActivationFunction=activation)

    def reshape(self, *shape, stated=None, tensor=True):
        """`stated`: the shape the file asks for; in a tensor of its own, or in the options."""
        stated, grid = [1, *shape] if stated is None else stated, self.params(self.x)
        inputs = [self.x]
        if tensor:
            inputs.append(self.tensor([len(stated)], INT32, 1, 0, np.array(stated, np.int32)))
            self.tensors[-1].quantization = None
        return self.operator("RESHAPE", inputs, shape, grid, "ReshapeOptions", newShape=stated)

    def softmax(self, beta=1.0):
        return self.operator("SOFTMAX", [self.x], self.shape(), (1 / 256, -128), "SoftmaxOptions", beta=beta)

    def back(self, tensor):
        self.x = tensor
        return self

    def flatbuffer(self):
        g, m = tfl.SubGraphT(), tfl.ModelT()
        g.tensors, g.operators, g.inputs, g.outputs = self.tensors, self.ops, self.inputs, self.outputs or [self.x]
        m.version, m.subgraphs, m.buffers, m.operatorCodes = 3, [g] * self.subgraphs, self.buffers, []
        names = {code: name for name, code in vars(tfl.BuiltinOperator).items() if isinstance(code, int)}
        for code in self.codes:
            c = tfl.OperatorCodeT()
            c.builtinCode, c.deprecatedBuiltinCode, c.version = code, code, VERSIONS.get(names[code], 2)
            m.operatorCodes.append(c)
        builder = flatbuffers.Builder(1024)
        builder.Finish(m.Pack(builder), b"TFL3")
        return bytes(builder.Output())

    def around(self):
        """Inputs within one of the zero point."""
        self.given = self.params(0)[1] + self.rng.integers(-1, 2, (4, *self.tensors[0].shape))
        return self

    def tall(self):
        """Inputs with sums beyond 16 bits, with peaks in the last rows."""
        shape = self.tensors[0].shape
        low, high = self.rng.integers(-128, -100, shape), self.rng.integers(105, 125, shape)
        low[0, -1], high[0, -44] = np.array([[-20, 9], [125, 127]]).reshape(2, *shape[2:])
        self.given = [low, high]
        return self

    def images(self):
        """Noise, the limits, values near the zero point, noise, the least and the greatest."""
        shape, zero, rng = self.tensors[0].shape, self.params(0)[1], self.rng
        near = np.clip(zero + rng.integers(-9, 10, shape), -128, 127)
        made = [rng.integers(-128, 128, shape), rng.choice([-128, 127], shape), near, rng.integers(-128, 128, shape),
                np.full(shape, -128), np.full(shape, 127)]
        return np.array(self.given if self.given is not None else made[: self.count]).astype(np.int8)


# The numpy of it. An operator takes its table, the file and its inputs, and answers before the activation's limits.


def places_of(length, window, stride, same):
    """Of every place of a window along an axis: the part of the axis, and the part of the window on it."""
    count = -(-length // stride) if same else (length - window) // stride + 1
    before = max((count - 1) * stride + window - length, 0) // 2 if same else 0
    for first in range(-before, count * stride - before, stride):
        yield slice(max(first, 0), min(first + window, length)), slice(max(-first, 0), min(window, length - first))


def windows(shape, window, o):
    """Number, part of the map and part of the window, row by row."""
    strides = o.builtinOptions.strideH, o.builtinOptions.strideW
    axes = [list(places_of(*axis, o.builtinOptions.padding == SAME)) for axis in zip(shape[1:3], window, strides)]
    parts = [((row, column), (in_row, in_column)) for (row, in_row), (column, in_column) in product(*axes)]
    return [len(axis) for axis in axes], parts


def away(value):
    """Rounds halves away from zero."""
    whole = np.trunc(value)
    return (whole + np.sign(value) * (np.abs(value - whole) >= 0.5)).astype(np.int64)


def twice(acc, ratio):
    """Fixed point with gemmlowp's two roundings: everything but FULLY_CONNECTED."""
    return requantize(acc, *quantize(ratio))


def once(acc, ratio):
    """Fixed point with one rounding, which TFLite can be built with."""
    return requantize_once(acc, *quantize(ratio))


def double(acc, ratio):
    """Double arithmetic: FULLY_CONNECTED."""
    return away(acc.astype(np.float64) * ratio)


class File:
    """What is read of a file to compute it again."""

    def __init__(self, content):
        # of an input's scale and a weight's
        self.product = np.float64
        self.model = tfl.ModelT.InitFromPackedBuf(content, 0)
        self.tensors = self.model.subgraphs[0].tensors
        kinds = networks.operators(content)
        self.operators = [(o, kind, output) for o, (kind, (output,)) in zip(self.model.subgraphs[0].operators, kinds)]

    def scale(self, tensor):
        return float(self.tensors[tensor].quantization.scale[0])

    def zero(self, tensor):
        return int(self.tensors[tensor].quantization.zeroPoint[0])

    def constant(self, tensor):
        t = self.tensors[tensor]
        data = np.asarray(self.model.buffers[t.buffer].data, np.uint8).tobytes()
        return np.frombuffer(data, np.int8 if t.type == INT8 else "<i4").reshape(t.shape).astype(np.int64)

    def requantized(self, o, acc, rounding):
        """Sums [..., channels] of an operator with weights, with its biases, in steps of the output."""
        if len(o.inputs) == 3 and o.inputs[2] != -1:
            acc = acc + self.constant(o.inputs[2])
        scales = [float(scale) for scale in self.tensors[o.inputs[1]].quantization.scale]
        scales = scales * (acc.shape[-1] // len(scales))
        products = [float(self.product(self.scale(o.inputs[0])) * self.product(scale)) for scale in scales]
        ratios = [product / self.scale(o.outputs[0]) for product in products]
        return np.stack([rounding(acc[..., c], ratio) for c, ratio in enumerate(ratios)], -1) + self.zero(o.outputs[0])

    def range(self, o, kind, real=np.float32):
        """Limits of an operator's activation; the division is that of float32."""
        act, (scale, zero) = o.builtinOptions.fusedActivationFunction, (self.scale(o.outputs[0]), self.zero(o.outputs[0]))
        least, greatest = {NONE: (None, None), RELU: (0, None), RELU6: (0, 6), UNIT: (-1, 1)}[act]
        low = -128 if least is None else zero + int(away(real(least) / real(scale)))
        high = 127 if greatest is None else zero + int(away(real(greatest) / real(scale)))
        return max(-128, low), min(127, high)


def convolution(o, file, x, rounding=twice):
    weights, x = file.constant(o.inputs[1]), x[0] - file.zero(o.inputs[0])
    places, parts = windows((1, *x.shape), weights.shape[1:3], o)
    sums = [np.einsum("hwc,ohwc->o", x[part], weights[:, *inside]) for part, inside in parts]
    return file.requantized(o, np.array(sums).reshape(*places, -1), rounding)


def depthwise(o, file, x, rounding=twice):
    weights, x = file.constant(o.inputs[1])[0], x[0] - file.zero(o.inputs[0])
    x = np.repeat(x, weights.shape[2] // x.shape[2], axis=2)
    places, parts = windows((1, *x.shape), weights.shape[:2], o)
    sums = [(x[part] * weights[inside]).sum(axis=(0, 1)) for part, inside in parts]
    return file.requantized(o, np.array(sums).reshape(*places, -1), rounding)


def dense(o, file, x, rounding=double):
    weights = file.constant(o.inputs[1])
    sums = (x.reshape(-1, weights.shape[1]) - file.zero(o.inputs[0])) @ weights.T
    return file.requantized(o, sums, rounding)


def addition(o, file, a, b, rounding=twice):
    (sa, za), (sb, zb), (so, zo) = ((file.scale(t), file.zero(t)) for t in (*o.inputs, *o.outputs))
    unit = 2 * max(sa, sb)
    total = rounding((a - za) * 2**20, sa / unit) + rounding((b - zb) * 2**20, sb / unit)
    return rounding(total, unit / (2**20 * so)) + zo


def max_pool(o, _, x):
    _, parts = windows(x.shape, (o.builtinOptions.filterHeight, o.builtinOptions.filterWidth), o)
    return np.array([x[0][part].max(axis=(0, 1)) for part, _ in parts])


def average_pool(o, _, x, half=lambda total, n: np.sign(total) * ((np.abs(total) + n // 2) // n)):
    """Of the values on the map alone; halves away from zero."""
    _, parts = windows(x.shape, (o.builtinOptions.filterHeight, o.builtinOptions.filterWidth), o)
    tiles = [x[0][part].reshape(-1, x.shape[3]) for part, _ in parts]
    return np.array([half(tile.sum(axis=0), len(tile)) for tile in tiles])


def high_mul(a, b):
    """gemmlowp's rounding doubling high half of a product of int32s."""
    total = a * b + (2**30 if a * b >= 0 else 1 - 2**30)
    return total // 2**31 if total >= 0 else -(-total // 2**31)


def divided(x, bits):
    """x / 2^bits, halves away from zero."""
    return (abs(x) + (1 << bits >> 1) >> bits) * (1 if x >= 0 else -1)


def exponential(a):
    """e^a, a <= 0: Q5.26 to Q0.31."""
    if a == 0:
        return 2**31 - 1
    below_quarter = a % 2**24 - 2**24
    x = below_quarter * 32 + 2**28
    x2 = high_mul(x, x)
    cubic = high_mul(divided(high_mul(x2, x2), 2) + high_mul(x2, x), 715827883) + x2
    result = 1895147668 + high_mul(1895147668, x + divided(cubic, 1))
    factors = [1672461947, 1302514674, 790015084, 290630308, 39332535, 720401, 242]
    for bit, factor in enumerate(factors, 24):
        result = high_mul(result, factor) if below_quarter - a & 1 << bit else result
    return result


def softmax_scale(file, o):
    """Multiplier, shift and least difference of a softmax."""
    fraction, shift = math.frexp(min(o.builtinOptions.beta * file.scale(o.inputs[0]) * 2**26, 2**31 - 1))
    multiplier = math.floor(fraction * 2**31 + 0.5)
    assert multiplier < 2**31 and 0 <= shift <= 31
    return multiplier, shift, -math.floor(31 * 2**26 / 2**shift)


def row_of_softmax(row, multiplier, shift, least):
    top = max(row)
    e = [exponential(high_mul(v - top << shift, multiplier)) if v - top >= least else None for v in row]
    total = sum(divided(v, 12) for v in e if v is not None)
    headroom = 32 - total.bit_length()
    half = total << headroom >> 1
    x = 1515870810 + high_mul(half, -1010580540)
    for _ in range(3):
        x += high_mul(x, 2**29 - high_mul(half, x)) * 4
    inverse = min(2 * x, 2**31 - 1)
    return [-128 if v is None else min(divided(high_mul(inverse, v), 35 - headroom) - 128, 127) for v in e]


def softmax(o, file, x):
    rows = x.reshape(-1, x.shape[-1]).tolist()
    return np.array([row_of_softmax(row, *softmax_scale(file, o)) for row in rows])


def table_softmax(o, file, x):
    """TFLite's other softmax: floats out of a table."""
    step = np.float32(o.builtinOptions.beta) * np.float32(file.scale(o.inputs[0]))
    x = x.reshape(-1, x.shape[-1])
    e = np.exp(((x - x.max(axis=1, keepdims=True)).astype(np.float32) * step).astype(np.float32))
    totals = np.array([[np.add.accumulate(row, dtype=np.float32)[-1]] for row in e])
    return np.minimum(np.rint(e * (np.float32(1) / (totals * np.float32(1 / 256)))) - 128, 127)


AGAIN = {"CONV_2D": convolution, "DEPTHWISE_CONV_2D": depthwise, "FULLY_CONNECTED": dense, "ADD": addition,
         "MAX_POOL_2D": max_pool, "AVERAGE_POOL_2D": average_pool, "SOFTMAX": softmax}


def limited(file, o, kind, values, real=np.float32):
    return np.clip(values, *file.range(o, kind, real) if kind != "SOFTMAX" else (-128, 127)).astype(np.int64).ravel()


def check(name, file, values):
    """Every operator of LiteRT's inputs again; how many values would differ under other arithmetic."""
    counts = Counter()
    for o, kind, output in file.operators:
        found = values[output].astype(np.int64).ravel()
        x = [values[t].astype(np.int64) for t in (o.inputs if kind == "ADD" else o.inputs[:1])]
        if kind == "RESHAPE":
            assert np.array_equal(found, x[0].ravel()), name
            continue
        answer = limited(file, o, kind, AGAIN[kind](o, file, *x))
        assert np.array_equal(found, answer), (name, kind, found, answer)
        counts["values"] += found.size
        counts["at the limits of int8"] += int((np.abs(found + 0.5) > 127).sum())
        if kind in ("CONV_2D", "DEPTHWISE_CONV_2D", "FULLY_CONNECTED"):
            file.product = np.float32
            counts["unlike a product in float32"] += int((found != limited(file, o, kind, AGAIN[kind](o, file, *x))).sum())
            file.product = np.float64
        if kind == "FULLY_CONNECTED":
            fixed = limited(file, o, kind, dense(o, file, *x, rounding=twice))
            counts["unlike fixed point"] += int((found != fixed).sum())
        elif kind in ("CONV_2D", "DEPTHWISE_CONV_2D", "ADD"):
            for other, what in ((once, "unlike one rounding"), (double, "unlike double arithmetic")):
                counts[what] += int((found != limited(file, o, kind, AGAIN[kind](o, file, *x, rounding=other))).sum())
        elif kind == "AVERAGE_POOL_2D":
            upwards = average_pool(o, file, *x, half=lambda total, n: (2 * total + n) // (2 * n))
            counts["unlike halves upwards"] += int((found != limited(file, o, kind, upwards)).sum())
        elif kind == "SOFTMAX":
            counts["unlike a table"] += int((found != table_softmax(o, file, *x).ravel()).sum())
            differences = x[0] - x[0].max(axis=-1, keepdims=True)
            counts["too small for an exponential"] += int((differences < softmax_scale(file, o)[2]).sum())
        if kind != "SOFTMAX":
            wide = limited(file, o, kind, AGAIN[kind](o, file, *x), np.float64)
            counts["unlike limits of float64"] += int((found != wide).sum())
            low, high = file.range(o, kind)
            at_limit = (found == low) & (low > -128) | (found == high) & (high < 127)
            counts["at a limit of ReLU inside int8"] += int(at_limit.sum())
    return counts


# The cases.


def convolutions():
    yield Graph("CONV_2D 1x1 SAME, per channel", [4, 3, 3]).conv(5, (1, 1))
    yield Graph("CONV_2D 1x1 VALID, strides 2 and 3", [5, 7, 2], zero=-128).conv(9, (1, 1), (2, 3), VALID)
    yield Graph("CONV_2D 3x3 SAME, per tensor, RELU", [5, 6, 2]).conv(3, (3, 3), activation=RELU, per_channel=False)
    yield Graph("CONV_2D 3x3 SAME, strides 2 and 1", [6, 5, 3], zero=127).conv(2, (3, 3), (2, 1))
    yield Graph("CONV_2D 3x3 VALID, strides 2 and 1, RELU6", [7, 4, 2]).conv(3, (3, 3), (2, 1), VALID, RELU6, (0.09, -20))
    yield Graph("CONV_2D 5x3 SAME, higher than the map", [3, 4, 2]).conv(3, (5, 3))
    yield Graph("CONV_2D 5x3 VALID, strides 2 and 3", [9, 8, 1]).conv(3, (5, 3), (2, 3), VALID)
    yield Graph("CONV_2D 2x4 SAME, strides 2 and 3", [5, 8, 2]).conv(3, (2, 4), (2, 3))
    yield Graph("CONV_2D 2x4 VALID, RELU_N1_TO_1", [4, 6, 2]).conv(2, (2, 4), (1, 1), VALID, UNIT, (0.04, 5))
    yield Graph("CONV_2D 4x5 VALID, the whole map", [4, 5, 2]).conv(6, (4, 5), (4, 5), VALID)
    yield Graph("CONV_2D 5x1 VALID, all rows", [5, 6, 1]).conv(2, (5, 1), (1, 2), VALID)
    yield Graph("CONV_2D 1x1, multipliers above one", [3, 5, 2], zero=7).conv(
        4, (1, 1), ratios=[1.7, 1, 6.3, 100], most=1)
    yield Graph("CONV_2D 1x1, RELU6 at a limit of float32", [3, 4, 2]).conv(
        3, (1, 1), activation=RELU6, grid=(RELU6_SCALE, -30))
    powers = {"scale": 1 / 64, "zero": 4, "count": 6}
    yield Graph("CONV_2D 1x1, powers of two", [4, 5, 3], **powers).conv(
        4, (1, 1), grid=(1 / 16, 3), ratios=[1 / 2, 1 / 4, 1 / 8, 1 / 16], most=2)
    yield Graph("CONV_2D 3x3, one power of two, RELU", [4, 4, 2], **powers).conv(
        3, (3, 3), (2, 1), activation=RELU, grid=(1 / 16, -9), ratios=[1 / 8], most=2, per_channel=False)
    yield Graph("CONV_2D 1x1, ties of large sums", [3, 3, 1]).conv(
        12, (1, 1), ratios=np.geomspace(1e-6, 4e-6, 12), most=1, bias="ties").around()


def depthwise_convolutions():
    yield Graph("DEPTHWISE_CONV_2D 3x3 SAME, per channel", [4, 5, 3]).depthwise(1, (3, 3))
    yield Graph("DEPTHWISE_CONV_2D 3x3 VALID, stride 2, two out of each, per tensor, RELU", [7, 5, 2]).depthwise(
        2, (3, 3), (2, 2), VALID, RELU, per_channel=False)
    yield Graph("DEPTHWISE_CONV_2D 2x4 SAME, stride 2, three out of each, RELU6", [5, 6, 2]).depthwise(
        3, (2, 4), (2, 2), activation=RELU6, grid=(0.1, -25))
    yield Graph("DEPTHWISE_CONV_2D 5x3 VALID, no bias", [7, 5, 2]).depthwise(1, (5, 3), padding=VALID, bias=False)
    yield Graph("DEPTHWISE_CONV_2D 1x1 SAME, stride 2, two out of each, no bias", [5, 4, 2], zero=-128).depthwise(
        2, (1, 1), (2, 2), bias=False)
    yield Graph("DEPTHWISE_CONV_2D 3x3 SAME, strides 2 and 3, higher than the map", [2, 7, 2]).depthwise(1, (3, 3), (2, 3))
    yield Graph("DEPTHWISE_CONV_2D 3x4 VALID, the whole map, three out of one", [3, 4, 1]).depthwise(3, (3, 4), padding=VALID)
    yield Graph("DEPTHWISE_CONV_2D 2x2, powers of two, a multiplier above one", [4, 4, 4], 1 / 64, 4).depthwise(
        1, (2, 2), grid=(1 / 16, 3), ratios=[1 / 2, 1 / 4, 1 / 8, 2], most=2)
    yield Graph("DEPTHWISE_CONV_2D 1x1, ties of large sums", [2, 2, 6]).depthwise(
        1, (1, 1), ratios=np.geomspace(1e-6, 4e-6, 6), most=1, bias="ties").around()
    g = Graph("DEPTHWISE_CONV_2D 1x1, two out of each, one by the option", [2, 2, 2]).depthwise(2, (1, 1))
    g.ops[0].builtinOptions.depthMultiplier = 1
    yield g


def fully_connected():
    """The count of values that fixed point would answer differently is put into the name."""
    yield Graph("FULLY_CONNECTED per channel, of height, width and channels", [3, 2, 4], count=6).dense(16)
    yield Graph("FULLY_CONNECTED per tensor, RELU, of height, width and channels", [2, 3, 3], count=6).dense(
        14, RELU, per_channel=False)
    yield Graph("FULLY_CONNECTED per channel, of a RESHAPE", [3, 4, 2], count=6).reshape(24).dense(12, grid=(0.05, 100))
    yield Graph("FULLY_CONNECTED per tensor, no bias, of a RESHAPE by its options", [3, 1, 5], count=6).reshape(
        15, stated=[-1, 15], tensor=False).dense(16, bias=False, per_channel=False)
    yield Graph("FULLY_CONNECTED per channel, bias -1, RELU6", [20], count=6).dense(16, RELU6, (0.07, -15), bias=None)
    powers = {"scale": 1 / 64, "zero": 4, "count": 6}
    yield Graph("FULLY_CONNECTED keeps its axes, halves everywhere, RELU_N1_TO_1", [1, 1, 12], **powers).dense(
        12, UNIT, (1 / 64, 3), [2.0 ** -(1 + k % 5) for k in range(12)], most=1, keep=True)
    yield Graph("FULLY_CONNECTED ratios above one", [2], count=6).dense(8, ratios=np.linspace(0.3, 1.5, 8), most=1)
    yield Graph("FULLY_CONNECTED ties of large sums", [2]).dense(
        24, ratios=np.geomspace(1e-6, 4e-6, 24), bias="ties").around()


def additions():
    g = Graph("ADD of different scales", [3, 4, 2], 0.03, 20).depthwise(1, (1, 1), grid=(0.011, -40))
    yield g.plus(0, g.x, (0.035, 7))
    g = Graph("ADD the larger scale first, RELU", [3, 4, 2], 0.01, -70).depthwise(1, (1, 1), grid=(0.045, 3))
    yield g.plus(g.x, 0, (0.04, -20), RELU)
    g = Graph("ADD RELU6", [3, 4, 2], 0.05, 0).depthwise(1, (1, 1), grid=(0.05, -10))
    yield g.plus(0, g.x, (0.07, -12), RELU6)
    yield Graph("ADD of a tensor to itself", [3, 4, 2], 0.02, -17).plus(0, 0, (0.033, 11))
    yield Graph("ADD RELU_N1_TO_1 on two axes", [9], 0.02, -17).plus(0, 0, (0.021, -5), UNIT)
    g = Graph("ADD twice with the same skip", [3, 3, 3], 0.02, 5).conv(3, (3, 3), grid=(0.03, -8))
    skip = g.x
    g.conv(3, (1, 1), activation=RELU, grid=(0.02, -128)).plus(skip, g.x, (0.04, 0))
    yield g.depthwise(1, (3, 3), grid=(0.05, 9)).plus(g.x, skip, (0.06, -3))
    g = Graph("ADD powers of two", [3, 4, 2], 1 / 64, 3, count=6).depthwise(
        1, (1, 1), grid=(1 / 128, -4), ratios=[1 / 2, 1 / 4], most=2)
    yield g.plus(0, g.x, (1 / 32, 2))


def poolings():
    for name in ("MAX_POOL_2D", "AVERAGE_POOL_2D"):
        yield Graph(f"{name} 3x3 SAME, stride 2, parts", [5, 6, 2]).pool(name, (3, 3), (2, 2), SAME)
        yield Graph(f"{name} 2x2 SAME, stride 1, parts", [4, 5, 2]).pool(name, (2, 2), (1, 1), SAME)
        yield Graph(f"{name} 5x4 SAME, larger than the map", [3, 2, 3]).pool(name, (5, 4), (1, 1), SAME)
        yield Graph(f"{name} 2x2 VALID, the last column left out", [4, 7, 2]).pool(name, (2, 2))
        yield Graph(f"{name} 2x4 VALID, strides 1 and 3, RELU", [4, 7, 2], zero=99).pool(name, (2, 4), (1, 3), activation=RELU)
        yield Graph(f"{name} 1x2 SAME, strides 2 and 1, RELU6", [5, 4, 2], 0.2, -8).pool(name, (1, 2), (2, 1), SAME, RELU6)
        yield Graph(f"{name} 300x1 VALID, global", [300, 1, 2]).pool(name, (300, 1)).tall()
    yield Graph("MAX_POOL_2D 300x1 VALID, all rows, strides 1", [300, 2, 1]).pool("MAX_POOL_2D", (300, 1), (1, 1)).tall()
    yield Graph("AVERAGE_POOL_2D 1x2 VALID after RESHAPE, and a branch that nobody reads", [24]).reshape(3, 4, 2).pool(
        "MAX_POOL_2D", (2, 2)).back(2).pool("AVERAGE_POOL_2D", (1, 2)).reshape(12)


def softmaxes():
    yield Graph("SOFTMAX of 1", [2, 1, 1], 0.1).softmax()
    yield Graph("SOFTMAX of 2", [2, 3, 2], 0.03).softmax()
    yield Graph("SOFTMAX of 10, some too small", [10], 0.5, count=6).softmax()
    yield Graph("SOFTMAX of 10, rows", [3, 2, 10], 0.06).softmax()
    yield Graph("SOFTMAX of 9, three axes, beta 0.3", [4, 9], 0.2, 0).softmax(0.3)
    yield Graph("SOFTMAX of 10, beta 2.5", [2, 2, 10], 0.05).softmax(2.5)
    yield Graph("SOFTMAX of 4, all but the greatest too small", [3, 2, 4], 60.0).softmax()
    yield Graph("SOFTMAX of 4, a tiny scale", [3, 1, 4], 1e-5).softmax()
    yield Graph("SOFTMAX of 200", [200], 0.02).softmax()
    yield Graph("SOFTMAX of 511, the longest", [511], 0.02, count=2).softmax()
    # found by search: TFLite's softmax with a table of floats answers differently
    g = Graph("SOFTMAX of 3, unlike a table", [2, 1, 3], 0.0949760228395462).softmax()
    g.given = np.reshape([[-48, -26, -58], [-63, -31, -53], [-13, 19, -3], [67, 45, 35], [8, -24, -14], [-1, -11, 21]],
                         (3, 1, 2, 1, 3))
    yield g
    g = Graph("SOFTMAX of 10, unlike a table", [1, 2, 10], 0.011846414767205715).softmax()
    g.given = np.reshape([[-37, 36, 38, -128, -128, -61, -128, -128, 47, -116], [-128, -128, 6, -34, 29, -128, 41, -19, 38, 45],
                          [-128, -12, -128, -109, 10, -128, -107, -40, -128, -88], [32, -128, -128, -95, -125, -128, -128, -128,
                          -1, -78]], (2, 1, 1, 2, 10))
    yield g


def chains():
    g = Graph("chain", [9, 7, 2], 1 / 255, -128, count=3).conv(4, (3, 3), (2, 1), activation=RELU, grid=(0.02, -128))
    g.depthwise(2, (3, 3), activation=RELU6, grid=(0.03, -128)).pool("MAX_POOL_2D", (2, 2), padding=SAME)
    skip = g.x
    g.conv(8, (1, 1), grid=(0.05, 4)).plus(skip, g.x, (0.06, -100), RELU)
    g.pool("AVERAGE_POOL_2D", (3, 2), (1, 2)).reshape(16).dense(10, grid=(0.1, 12)).softmax()
    # as converters write it: a batch of any size
    g.tensors[0].shapeSignature = [-1, 9, 7, 2]
    yield g
    g = Graph("chain of an addition around a RESHAPE", [2, 3, 2]).conv(2, (1, 1)).reshape(12)
    flat = g.x
    yield g.reshape(3, 2, 2).pool("MAX_POOL_2D", (1, 1)).reshape(12).plus(flat, g.x).softmax()


# The refused.


def pooled(shape=(2, 2, 1)):
    return Graph("", shape).pool("MAX_POOL_2D", (2, 2))


def refusals():
    """Name, graph and a part of the message."""
    g = Graph("", [2, 2, 1])
    axes = g.tensor([2], INT32, 1, 0, np.array([1, 2], np.int32))
    yield "MEAN", g.operator("MEAN", [0, axes], [1], (0.02, -3), "ReducerOptions", keepDims=False), "MEAN"
    g = Graph("", [2, 2, 1])
    pads = g.tensor([4, 2], INT32, 1, 0, np.array([0, 0, 1, 1, 1, 1, 0, 0], np.int32))
    yield "PAD", g.operator("PAD", [0, pads], [4, 4, 1], (0.02, -3), "PadOptions"), "PAD"
    yield "LOGISTIC", Graph("", [2, 2, 1]).operator("LOGISTIC", [0], [2, 2, 1], (1 / 256, -128)), "LOGISTIC"
    for name, separate in (("CONV_2D", False), ("DEPTHWISE_CONV_2D", True)):
        g = Graph("", [3, 3, 1]).conv(1, (2, 2), depthwise=separate)
        g.ops[0].builtinOptions.dilationHFactor = 2
        yield f"{name}, dilation 2", g, "dilation"
    for name, kind in (("FLOAT32", FLOAT32), ("INT16", INT16)):
        g = pooled()
        for tensor in g.tensors:
            tensor.type = kind
        yield f"{name} input", g, name
    g = Graph("", [2, 2, 1]).conv(1, (1, 1))
    g.tensors[1].quantization.zeroPoint = np.array([1])
    yield "weights with a zero point", g, "zero point"
    g = pooled()
    for tensor in g.tensors:
        tensor.shape[0] = 2
    yield "batch of two", g, "shape"
    g = Graph("", [2, 2, 1])
    g.inputs.append(g.tensor([1, 2, 2, 1], INT8, 0.02, 0))
    yield "two inputs", g.plus(0, 1), "number of inputs"
    g = pooled()
    g.outputs = [0, 1]
    yield "two outputs", g, "number of inputs and outputs"
    g = Graph("", [2, 2, 2])
    yield "ADD of a constant", g.plus(0, g.tensor([2], INT8, 0.02, 0, np.array([1, 2], np.int8))), "ADD"
    yield "ADD of axes that differ", pooled((4, 4, 1)).pool("MAX_POOL_2D", (2, 2)).plus(1, 2), "axes"
    yield "ADD into a scale far too small", Graph("", [2]).plus(0, 0, (1e-9, 0)), "ratio of scales"
    yield "SOFTMAX of 600", Graph("", [600]).softmax(), "values of a row"
    yield "SOFTMAX, beta 0", Graph("", [2]).softmax(0.0), "beta"
    g = Graph("", [2]).softmax()
    g.tensors[1].quantization.scale = np.array([1 / 128], np.float32)
    yield "SOFTMAX into another scale", g, "scale"
    g = Graph("", [2, 2, 1]).conv(4, (1, 1))
    g.buffers[1].data = g.buffers[1].data[:3]
    yield "weights shorter than their shape", g, "bytes"
    g = Graph("", [2, 2, 1]).conv(4, (1, 1))
    g.buffers[2].data = g.buffers[2].data[:12]
    yield "biases too short", g, "bias"
    g = pooled()
    g.ops[0].inputs = [g.tensor([1, 2, 2, 1], INT8, 0.02, 0)]
    yield "a tensor nobody wrote", g, "input"
    g = pooled((4, 4, 1)).pool("MAX_POOL_2D", (2, 2))
    g.ops.reverse()
    yield "operators out of order", g, "input"
    g = pooled((4, 4, 1)).pool("MAX_POOL_2D", (2, 2))
    g.outputs = [1]
    yield "output not the last operator's", g, "output"
    g = pooled()
    g.ops[0].outputs = [7]
    yield "a tensor that is not there", g, "tensor"
    g = pooled()
    g.tensors[1].quantization.scale = np.array([0.03], np.float32)
    yield "MAX_POOL_2D into another scale", g, "scale"
    g = pooled()
    g.ops[0].builtinOptions.filterWidth = 3
    yield "VALID window wider than the map", g, "window"
    g = pooled((4, 4, 1))
    g.ops[0].builtinOptions.strideH = 0
    yield "stride 0", g, "stride"
    g = pooled()
    g.ops[0].builtinOptions.fusedActivationFunction = tfl.ActivationFunctionType.TANH
    yield "TANH", g, "activation"
    g = Graph("", [2, 2, 2]).conv(2, (1, 1))
    g.tensors[1].shape, g.buffers[1].data = [2, 1, 1, 1], g.buffers[1].data[:2]
    yield "CONV_2D of groups", g, "shape of the weights"
    g = Graph("", [2, 2, 2]).conv(2, (1, 1))
    g.tensors[1].quantization.quantizedDimension = 3
    yield "scales along another axis", g, "dimension"
    g = Graph("", [3, 2]).reshape(6).dense(2)
    g.ops[1].inputs[0] = 0
    g.tensors[3].shape, g.buffers[2].data = [2, 2], g.buffers[2].data[:4]
    yield "FULLY_CONNECTED of rows", g, "shape of the weights"
    yield "RESHAPE to fewer values", Graph("", [2, 2, 1]).reshape(3).softmax(), "values"
    g = pooled()
    g.subgraphs = 2
    yield "two subgraphs", g, "subgraphs"
    g = pooled()
    g.ops = []
    yield "no operator", g, "output"


def text(data):
    return base64.b64encode(data).decode()


def case(graph):
    content, images = graph.flatbuffer(), graph.images()
    engine, entry = networks.engine_of(content)
    file, layers, counts = File(content), [], Counter()
    for image in images:
        engine.set_tensor(entry["index"], image)
        engine.invoke()
        values = {entry["index"]: image} | {output: engine.get_tensor(output) for _, _, output in file.operators}
        counts += check(graph.name, file, values)
        layers += [values[output].tobytes() for _, kind, output in file.operators if kind != "RESHAPE"]
    name, unlike = graph.name, counts["unlike fixed point"]
    if name.startswith("FULLY_CONNECTED"):
        assert unlike, name
        name += f", {unlike} of {counts['values']} values unlike fixed point"
    wanted = {"RELU": "at a limit of ReLU inside int8", "limit of float32": "unlike limits of float64",
              "powers of two": "unlike one rounding", "one power of two": "unlike one rounding",
              "ties": "unlike a product in float32",
              "too small": "too small for an exponential", "unlike a table": "unlike a table"}
    for part, what in wanted.items():
        assert part not in name or counts[what], (name, what)
    return {"name": name, "file": text(content), "inputs": text(images.tobytes()), "count": len(images),
            "layers": text(b"".join(layers))}, counts


if __name__ == "__main__":
    groups = convolutions, depthwise_convolutions, fully_connected, additions, poolings, softmaxes, chains
    made = [case(graph) for group in groups for graph in group()]
    total = sum((counts for _, counts in made), Counter())
    refused = [{"name": name, "file": text(g.flatbuffer()), "message": part} for name, g, part in refusals()]
    source = f"ai-edge-litert {version('ai-edge-litert')}, OpResolverType.BUILTIN_REF"
    path = Path(__file__).with_name("operators.json")
    content = {"source": source, "cases": [case for case, _ in made], "refused": refused}
    path.write_text(json.dumps(content, indent=1) + "\n")
    print(f"{path.name}: {len(made)} cases, {len(refused)} refused, {path.stat().st_size} bytes")
    for what, count in total.items():
        print(f"{count:>7} {what}")
