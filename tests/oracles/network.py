"""Golden int8 networks: LiteRT's reference kernels on graphs assembled by hand.

Each network is written twice, as a .tflite flatbuffer run by ai-edge-litert with the BUILTIN_REF resolver (the
portable reference kernels, no delegate), and as a model file of this project. `network.json` holds the model file,
one input image and every tensor LiteRT computed. Two networks: one with random scales; one with scales that are powers
of two, so that ties of the rounding are everywhere, with a channel that has a multiplier above one and one that
saturates.

A second opinion inside: every tensor is computed again by a few lines of numpy (double rounding), and the values
for which a single rounding would have answered differently are counted, so that a LiteRT build with the other
rounding cannot pass unnoticed.

    pip install ai-edge-litert==2.3.0 numpy==2.4.6 flatbuffers==25.12.19
    python network.py
"""

import base64
import binascii
import json
import math
import struct
from importlib.metadata import version
from pathlib import Path

import flatbuffers
import numpy as np
from ai_edge_litert import schema_py_generated as tfl
from ai_edge_litert.interpreter import Interpreter, OpResolverType

ROWS = 64


def quantize(real):
    """Multiplier and shift of a positive ratio, as TFLite's QuantizeMultiplier."""
    fraction, shift = math.frexp(real)
    fixed = math.floor(fraction * 2**31 + 0.5)
    if fixed == 2**31:
        fixed, shift = fixed // 2, shift + 1
    assert -31 <= shift <= 7
    return fixed, shift


class Graph:
    """A .tflite graph and a model file, grown side by side."""

    def __init__(self, frames, in_scale, in_zp):
        self.tensors, self.buffers, self.ops, self.codes = [], [tfl.BufferT()], [], []
        self.layers, self.frames = b"", frames
        self.watched = []
        self.x = self.tensor([1, ROWS, frames, 1], tfl.TensorType.INT8, in_scale, in_zp)
        self.input = self.x

    def tensor(self, shape, kind, scale, zp, data=None, axis=0):
        t, q = tfl.TensorT(), tfl.QuantizationParametersT()
        scale = np.atleast_1d(np.asarray(scale, np.float32))
        q.scale, q.zeroPoint = scale, np.full(len(scale), zp, np.int64)
        q.quantizedDimension = axis
        t.shape, t.type, t.quantization, t.name = list(shape), kind, q, f"t{len(self.tensors)}"
        t.buffer = 0
        if data is not None:
            b = tfl.BufferT()
            b.data = np.frombuffer(data.tobytes(), np.uint8)
            self.buffers.append(b)
            t.buffer = len(self.buffers) - 1
        self.tensors.append(t)
        return len(self.tensors) - 1

    def op(self, code, inputs, output, options, kind):
        if code not in self.codes:
            self.codes.append(code)
        o = tfl.OperatorT()
        o.opcodeIndex, o.inputs, o.outputs = self.codes.index(code), inputs, [output]
        o.builtinOptions, o.builtinOptionsType = options, kind
        self.ops.append(o)

    def params(self, index):
        q = self.tensors[index].quantization
        return np.float32(q.scale[0]), int(q.zeroPoint[0])

    def head(self, kind, in_zp, out_zp, act, in2_zp=0):
        return struct.pack("<B5b2x", kind, in_zp, out_zp, act[0], act[1], in2_zp)

    def conv(self, name, w, w_scale, bias, out_scale, out_zp, relu, stride=1, depthwise=False):
        s_in, z_in = self.params(self.x)
        w_scale, out_scale = np.asarray(w_scale, np.float32), np.float32(out_scale)
        _, h, wd, _ = self.tensors[self.x].shape
        out_c = len(bias)
        shape = [1, -(-h // stride), -(-wd // stride), out_c]
        axis = 3 if depthwise else 0
        filt = self.tensor(w.shape, tfl.TensorType.INT8, w_scale, 0, w.astype(np.int8), axis)
        b = self.tensor([out_c], tfl.TensorType.INT32, s_in * w_scale, 0, bias.astype(np.int32))
        y = self.tensor(shape, tfl.TensorType.INT8, out_scale, out_zp)
        o = tfl.DepthwiseConv2DOptionsT() if depthwise else tfl.Conv2DOptionsT()
        o.padding, o.strideH, o.strideW = tfl.Padding.SAME, stride, stride
        o.dilationHFactor = o.dilationWFactor = 1
        o.fusedActivationFunction = tfl.ActivationFunctionType.RELU if relu else tfl.ActivationFunctionType.NONE
        code, kind = tfl.BuiltinOperator.CONV_2D, tfl.BuiltinOptions.Conv2DOptions
        if depthwise:
            o.depthMultiplier = 1
            code, kind = tfl.BuiltinOperator.DEPTHWISE_CONV_2D, tfl.BuiltinOptions.DepthwiseConv2DOptions
        self.op(code, [self.x, filt, b], y, o, kind)

        pairs = [quantize(float(s_in) * float(s) / float(out_scale)) for s in w_scale]
        act = (out_zp if relu else -128, 127)
        layer_kind = {"head": 4}.get(name, 2 if depthwise else 1)
        body = self.head(layer_kind, z_in, out_zp, act) + struct.pack("<2f", s_in, out_scale)
        body += struct.pack(f"<{out_c}i", *[m for m, _ in pairs]) + bias.astype("<i4").tobytes()
        body += pad(struct.pack(f"<{out_c}b", *[s for _, s in pairs])) + pad(w.astype(np.int8).tobytes())
        self.layers += body
        check = dict(op="conv", x=self.x, w=w, bias=bias, pairs=pairs, z=(z_in, out_zp), act=act, stride=stride,
                     depthwise=depthwise)
        self.x = y
        self.watched.append((name, y, check))

    def max_pool(self):
        _, h, w, c = self.tensors[self.x].shape
        y = self.tensor([1, h // 2, w // 2, c], tfl.TensorType.INT8, *self.params(self.x))
        o = tfl.Pool2DOptionsT()
        o.padding, o.strideH, o.strideW, o.filterHeight, o.filterWidth = tfl.Padding.VALID, 2, 2, 2, 2
        self.op(tfl.BuiltinOperator.MAX_POOL_2D, [self.x], y, o, tfl.BuiltinOptions.Pool2DOptions)
        self.watched.append(("max-pool", y, dict(op="max", x=self.x)))
        self.x = y

    def add(self, skip, out_scale, out_zp):
        (s1, z1), (s2, z2), so = self.params(skip), self.params(self.x), np.float32(out_scale)
        y = self.tensor(self.tensors[self.x].shape, tfl.TensorType.INT8, so, out_zp)
        o = tfl.AddOptionsT()
        self.op(tfl.BuiltinOperator.ADD, [skip, self.x], y, o, tfl.BuiltinOptions.AddOptions)
        twice = 2 * max(float(s1), float(s2))
        pairs = [quantize(float(s1) / twice), quantize(float(s2) / twice), quantize(twice / (2**20 * float(so)))]
        (m1, e1), (m2, e2), (mo, eo) = pairs
        self.layers += self.head(3, z1, out_zp, (-128, 127), z2) + struct.pack("<3f", s1, s2, so)
        self.layers += struct.pack("<3i3bx", m1, m2, mo, e1, e2, eo)
        self.watched.append(("add", y, dict(op="add", a=skip, b=self.x, pairs=pairs, z=(z1, z2, out_zp))))
        self.x = y

    def average_pool(self):
        _, h, w, c = self.tensors[self.x].shape
        y = self.tensor([1, 1, 1, c], tfl.TensorType.INT8, *self.params(self.x))
        o = tfl.Pool2DOptionsT()
        o.padding, o.strideH, o.strideW, o.filterHeight, o.filterWidth = tfl.Padding.VALID, h, w, h, w
        self.op(tfl.BuiltinOperator.AVERAGE_POOL_2D, [self.x], y, o, tfl.BuiltinOptions.Pool2DOptions)
        self.watched.append(("average-pool", y, dict(op="mean", x=self.x)))
        self.x = y

    def flatbuffer(self):
        g = tfl.SubGraphT()
        g.tensors, g.operators, g.inputs, g.outputs, g.name = self.tensors, self.ops, [self.input], [self.x], "main"
        m = tfl.ModelT()
        m.version, m.subgraphs, m.buffers, m.description = 3, [g], self.buffers, ""
        m.operatorCodes = []
        for code in self.codes:
            c = tfl.OperatorCodeT()
            c.builtinCode, c.deprecatedBuiltinCode, c.version = code, code, 3 if code != tfl.BuiltinOperator.ADD else 2
            m.operatorCodes.append(c)
        builder = flatbuffers.Builder(1024)
        builder.Finish(m.Pack(builder), b"TFL3")
        return bytes(builder.Output())


def pad(data):
    return data + bytes(-len(data) % 4)


def model_file(graph, slots, window, hop, channels, blocks, classes, stem_stride):
    names = b"".join(f"class {k}".encode().ljust(24, b"\0") for k in range(classes))
    total = 64 + len(names) + len(graph.layers) + 4
    head = struct.pack("<4sHHIHBBHHHBBHHf4BII20x", b"SDP3", 1, 64, total, slots, 2, 8, window, hop, ROWS, 1,
                       stem_stride, 1063, graph.frames, 10.0, channels, blocks, classes, 0, 3_500_000, 1000)
    assert len(head) == 64
    body = head + names + graph.layers
    return body + struct.pack("<I", binascii.crc32(body))


def srdhm(a, b):
    ab = a.astype(object) * b
    nudge = np.where(ab >= 0, 2**30, 1 - 2**30).astype(object)
    return np.vectorize(lambda v: abs(v) // 2**31 * (1 if v >= 0 else -1), otypes=[object])(ab + nudge)


def requantize(acc, m, s):
    """gemmlowp's double rounding."""
    x = srdhm(acc * 2 ** max(s, 0), m)
    e = max(-s, 0)
    mask = 2**e - 1
    return np.vectorize(lambda v: (v >> e) + ((v & mask) > (mask >> 1) + (v < 0)), otypes=[object])(x)


def requantize_once(acc, m, s):
    """The other rounding TFLite can be built with."""
    return np.vectorize(lambda v: (v * m + (1 << (30 - s))) >> (31 - s), otypes=[object])(acc.astype(object))


def again(check, values, rounding):
    """A layer in numpy with a given rounding."""
    if check["op"] == "max":
        x = values[check["x"]][0]
        h, w, c = x.shape
        return x[: h // 2 * 2, : w // 2 * 2].reshape(h // 2, 2, w // 2, 2, c).max(axis=(1, 3))
    if check["op"] == "mean":
        x = values[check["x"]][0].astype(np.int64)
        n = x.shape[0] * x.shape[1]
        total = x.sum(axis=(0, 1))
        return np.array([[[(t + n // 2) // n if t > 0 else -((n // 2 - t) // n) for t in total]]])
    if check["op"] == "add":
        (z1, z2, zo), (p1, p2, po) = check["z"], check["pairs"]
        a = rounding((values[check["a"]][0].astype(np.int64) - z1) * 2**20, *p1)
        b = rounding((values[check["b"]][0].astype(np.int64) - z2) * 2**20, *p2)
        return np.clip(rounding(a + b, *po) + zo, -128, 127)
    x, w, stride, (zi, zo) = values[check["x"]][0].astype(np.int64), check["w"], check["stride"], check["z"]
    h, wd, _ = x.shape
    k = w.shape[1]
    out_h, out_w = -(-h // stride), -(-wd // stride)
    before = [max((o - 1) * stride + k - i, 0) // 2 for o, i in ((out_h, h), (out_w, wd))]
    padded = np.zeros((h + 2 * k, wd + 2 * k, x.shape[2]), np.int64)
    padded[before[0] : before[0] + h, before[1] : before[1] + wd] = x - zi
    out = np.empty((out_h, out_w, len(check["bias"])), object)
    for c, (m, s) in enumerate(check["pairs"]):
        acc = np.full((out_h, out_w), int(check["bias"][c]), np.int64)
        for ky in range(k):
            for kx in range(k):
                tile = padded[ky : ky + out_h * stride : stride, kx : kx + out_w * stride : stride]
                acc += tile[:, :, c] * int(w[0, 0, 0, c]) if check["depthwise"] else tile @ w[c, ky, kx].astype(np.int64)
        out[:, :, c] = rounding(acc, m, s) + zo
    return np.clip(out, *check["act"])


def build(name, seed, slots, window, hop, channels, blocks, classes, stem_stride, powers_of_two):
    rng = np.random.default_rng(seed)
    frames = (slots - window) // hop + 1
    graph = Graph(frames, np.float32(1 / 255), -128)

    def scale(low, high):
        value = np.exp(rng.uniform(np.log(low), np.log(high)))
        return 2.0 ** round(math.log2(value)) if powers_of_two else value

    def conv(layer, out_c, in_c, k, relu, stride=1):
        w = rng.integers(-127, 128, (out_c, k, k, in_c))
        s_in, z_in = graph.params(graph.x)
        # scales that let a typical sum fill the output: sqrt(taps) products of two numbers of about 60
        typical = math.sqrt(k * k * in_c) * 60 * 60
        out_scale = scale(0.02, 0.08)
        w_scale = [scale(0.3, 3.0) * 40 * out_scale / (typical * float(s_in)) for _ in range(out_c)]
        if powers_of_two:
            w_scale = [2.0 ** round(math.log2(s)) for s in w_scale]
        if layer == "conv2":
            w_scale[-1] *= 16  # saturates
        bias = rng.integers(-int(typical), int(typical) + 1, out_c)
        graph.conv(layer, w, w_scale, bias, out_scale, int(rng.integers(-30, 31)), relu, stride)

    conv("stem", channels, 1, 3, True, stem_stride)
    graph.max_pool()
    for _ in range(blocks):
        skip = graph.x
        w = rng.integers(-127, 128, (1, 1, 1, channels))
        s_in = float(graph.params(graph.x)[0])
        out_scale = scale(0.02, 0.08)
        ratios = [scale(0.005, 0.03) for _ in range(channels)]
        w[0, 0, 0, 0], ratios[0] = 3, 2.0 if powers_of_two else 1.7  # a multiplier above one
        w_scale = [r * out_scale / s_in for r in ratios]
        graph.conv("affine", w, w_scale, rng.integers(-4000, 4001, channels) * (np.array(ratios) < 1), out_scale,
                   int(rng.integers(-128, 0)), True, depthwise=True)
        conv("conv1", channels, channels, 3, True)
        conv("conv2", channels, channels, 3, False)
        graph.add(skip, scale(0.04, 0.16), int(rng.integers(-30, 31)))
    graph.average_pool()
    conv("head", classes, channels, 1, False)

    image = rng.integers(-128, 128, (1, ROWS, frames, 1)).astype(np.int8)
    image[:, :, ::3] = -128
    engine = Interpreter(model_content=graph.flatbuffer(), experimental_preserve_all_tensors=True,
                         experimental_op_resolver_type=OpResolverType.BUILTIN_REF)
    engine.allocate_tensors()
    engine.set_tensor(engine.get_input_details()[0]["index"], image)
    engine.invoke()
    values = {graph.input: image} | {t: engine.get_tensor(t) for _, t, _ in graph.watched}

    tensors, single = [], 0
    for layer, t, check in graph.watched:
        assert np.array_equal(values[t][0], again(check, values, requantize).astype(int)), (name, layer)
        single += int((values[t][0] != again(check, values, requantize_once).astype(int)).sum())
        tensors.append({"layer": layer, "shape": list(values[t].shape[1:]), "values": text(values[t])})
    at_limit = float(np.mean(np.concatenate([np.abs(values[t].ravel() + 0.5) > 127 for _, t, _ in graph.watched])))
    count = sum(values[t].size for _, t, _ in graph.watched)
    print(f"{name}: {count} values, {single} would differ under a single rounding, {at_limit:.3f} at a limit")
    model = model_file(graph, slots, window, hop, channels, blocks, classes, stem_stride)
    return {"name": name, "single_rounding_differs": single, "model": base64.b64encode(model).decode(),
            "image": text(image), "tensors": tensors}


def text(values):
    return base64.b64encode(values.astype(np.int8).tobytes()).decode()


if __name__ == "__main__":
    networks = [
        build("random scales", 1, 68, 32, 4, 8, 2, 5, 1, False),
        build("powers of two", 2, 80, 32, 4, 4, 1, 3, 2, True),
    ]
    source = f"ai-edge-litert {version('ai-edge-litert')}, OpResolverType.BUILTIN_REF"
    path = Path(__file__).with_name("network.json")
    path.write_text(json.dumps({"source": source, "networks": networks}, indent=1) + "\n")
