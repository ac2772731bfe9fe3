"""One int8 inference by sdp3, LiteRT with XNNPACK and ONNX Runtime: the same network, one thread, in turn.

FOLDER holds NAME.sdp3, NAME.tflite and NAME.images; CLOCK is the program `bench-infer`. The ONNX graph is made here from
NAME.sdp3: quantise-dequantise pairs, weights int8 per channel, activations int8 or uint8, which ONNX Runtime fuses into
its QLinear kernels. Per instruction set of sdp3 and per peer: least and median time of a single inference, and how far
the logits are from sdp3's, in steps of the output.

Where the processor has AMX, XNNPACK takes it, and its tiles do not suit 16 channels. So LiteRT also runs as on a processor
without: in a process in which the kernel refuses requests to use AMX (seccomp), XNNPACK has AVX-512 VNNI at most. It also runs held
to AVX-VNNI and to AVX2, where the processor has more: in those processes changed instructions of the library's detection find an
operating system that keeps no state of AVX-512, and a processor without AVX-VNNI.

    pip install numpy==2.4.6 onnx==1.23.2 onnxruntime==1.31.1 ai-edge-litert==2.3.0
    python infer.py FOLDER CLOCK --rounds 20
"""

import argparse
import ctypes
import os
import re
import struct
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import onnx
import onnxruntime
from ai_edge_litert.interpreter import Interpreter
from onnx import TensorProto, helper, numpy_helper

WARM, COUNT = 20, 50
# Least ratios of the peers' medians (LiteRT without AMX, the better ONNX Runtime) to that of sdp3's fastest instruction set:
# with AVX-512 the goals, else the least that was found (docs/benchmarks.md) less a sixth, which is how far runs on a
# loaded machine differ.
LEAST = {"avx512-vnni": (1.5, 3.0), "avx-vnni": (0.7, 1.25), "avx2": (0.6, 1.05)}
# Least ratio where both are held to the same instructions.
LEAST_HELD = {"avx-vnni": 1.1, "avx2": 1.5}
# Instructions of XNNPACK's detection (cpuinfo in ai-edge-litert 2.3.0) and what stands there instead.
WITHOUT_AVX512 = (rb"\x0f\x01\xd0", b"\x6a\x07\x58")  # xgetbv; push 7, pop rax: x87, SSE and AVX alone
WITHOUT_AVX_VNNI = (rb"(?<=\xb8\x07\0\0\0\xb9\x01\0\0\0...)\x0f\xa2", b"\x31\xc0")  # cpuid of leaf 7, 1; xor eax, eax
HELD = {"avx-vnni": [WITHOUT_AVX512], "avx2": [WITHOUT_AVX512, WITHOUT_AVX_VNNI]}


class File:
    """A model file's fields, one after the other."""

    def __init__(self, data):
        self.data, self.at = data, 0

    def take(self, form, count=None):
        values = struct.unpack_from("<" + form, self.data, self.at)
        self.at += struct.calcsize("<" + form)
        return values[0] if len(values) == 1 else values

    def array(self, kind, count):
        values = np.frombuffer(self.data, kind, count, self.at)
        self.at += -(-count * values.itemsize // 4) * 4
        return values

    def layer(self, channels, taps):
        """Zero points and scales of a layer with weights, in real numbers."""
        _, in_zero, out_zero, low, high, _, _ = self.take("BbbbbbH")
        in_scale, out_scale = self.take("ff")
        multipliers, biases = self.array("<i4", channels), self.array("<i4", channels)
        shifts, weights = self.array("i1", channels), self.array("i1", channels * taps)
        assert low in (-128, out_zero) and high == 127, "an activation range that saturation does not give"
        scales = multipliers * 2.0 ** (shifts.astype(float) - 31) * out_scale / in_scale
        return dict(x=(in_scale, in_zero), y=(out_scale, out_zero), relu=low == out_zero != -128,
                    scales=scales.astype(np.float32), biases=biases, weights=weights.reshape(channels, taps))


class Graph:
    """An ONNX graph of quantised tensors."""

    def __init__(self, unsigned):
        self.kind, self.offset = (np.uint8, 128) if unsigned else (np.int8, 0)
        self.nodes, self.constants, self.count = [], [], 0

    def constant(self, value):
        self.count += 1
        self.constants.append(numpy_helper.from_array(np.asarray(value), f"c{self.count}"))
        return f"c{self.count}"

    def node(self, kind, *inputs, **attributes):
        self.count += 1
        self.nodes.append(helper.make_node(kind, inputs, [f"t{self.count}"], **attributes))
        return f"t{self.count}"

    def grid(self, grid):
        scale, zero = grid
        return self.constant(np.float32(scale)), self.constant(self.kind(zero + self.offset))

    def real(self, tensor, grid):
        return self.node("DequantizeLinear", tensor, *self.grid(grid))

    def quantised(self, tensor, grid):
        return self.node("QuantizeLinear", tensor, *self.grid(grid))

    def conv(self, tensor, layer, shape, **attributes):
        weights = layer["weights"].reshape(shape)
        if weights.ndim == 4:
            weights = weights.transpose(0, 3, 1, 2)
        channels, scales = len(weights), layer["scales"]
        w = self.node("DequantizeLinear", self.constant(np.ascontiguousarray(weights)), self.constant(scales),
                      self.constant(np.zeros(channels, np.int8)), axis=0)
        b = self.node("DequantizeLinear", self.constant(layer["biases"]),
                      self.constant(np.float32(layer["x"][0]) * scales), self.constant(np.zeros(channels, np.int32)), axis=0)
        y = self.node("Conv", self.real(tensor, layer["x"]), w, b, **attributes)
        if layer["relu"]:
            y = self.node("Relu", y)
        return self.quantised(y, layer["y"])


def onnx_model(data, unsigned):
    """The ONNX model of a model file."""
    file, g = File(data), Graph(unsigned)
    stride, frames = data[23], struct.unpack_from("<H", data, 26)[0]
    channels, blocks, classes = data[32:35]
    file.at = 64 + 24 * classes
    before = [(max((-(-n // stride) - 1) * stride + 3 - n, 0)) for n in (64, frames)]
    pads = [p // 2 for p in before] + [p - p // 2 for p in before]
    stem = file.layer(channels, 9)
    x = g.conv("image", stem, (channels, 3, 3, 1), kernel_shape=[3, 3], strides=[stride] * 2, pads=pads)
    pooled = g.node("MaxPool", g.real(x, stem["y"]), kernel_shape=[2, 2], strides=[2, 2])
    x, grid = g.quantised(pooled, stem["y"]), stem["y"]
    for _ in range(blocks):
        affine = file.layer(channels, 1)
        t = g.conv(x, affine, (channels, 1, 1, 1), kernel_shape=[1, 1], group=channels)
        for _ in range(2):
            layer = file.layer(channels, 9 * channels)
            t = g.conv(t, layer, (channels, 3, 3, channels), kernel_shape=[3, 3], pads=[1] * 4)
        _, zero, out_zero, _, _, second_zero, _ = file.take("BbbbbbH")
        scale, second, out = file.take("fff")
        file.take("3i3bB")
        assert (scale, zero, second, second_zero) == (*grid, *layer["y"])
        grid = (out, out_zero)
        x = g.quantised(g.node("Add", g.real(x, (scale, zero)), g.real(t, (second, second_zero))), grid)
    x = g.quantised(g.node("GlobalAveragePool", g.real(x, grid)), grid)
    head = file.layer(classes, channels)
    x = g.conv(x, head, (classes, 1, 1, channels), kernel_shape=[1, 1])
    g.nodes[-1].output[0] = "logits"
    kind = TensorProto.UINT8 if unsigned else TensorProto.INT8
    graph = helper.make_graph(g.nodes, "network", [helper.make_tensor_value_info("image", kind, [1, 1, 64, frames])],
                              [helper.make_tensor_value_info("logits", kind, [1, classes, 1, 1])], g.constants)
    model = helper.make_model(graph, opset_imports=[helper.make_opsetid("", 17)], ir_version=8)
    onnx.checker.check_model(model)
    return model.SerializeToString()


def own_clock(run):
    """Calls `run(image)` per image, timing each call alone."""
    def clock(images, count):
        nanoseconds = []
        for k in range(count):
            run.set(images[k % len(images)])
            started = time.perf_counter_ns()
            run.once()
            nanoseconds.append(time.perf_counter_ns() - started)
        return nanoseconds, run.logits()
    return clock


class OnnxRuntime:
    def __init__(self, data, unsigned):
        options = onnxruntime.SessionOptions()
        options.intra_op_num_threads = options.inter_op_num_threads = 1
        options.graph_optimization_level = onnxruntime.GraphOptimizationLevel.ORT_ENABLE_ALL
        self.session = onnxruntime.InferenceSession(onnx_model(data, unsigned), options, ["CPUExecutionProvider"])
        self.kind, self.offset = (np.uint8, 128) if unsigned else (np.int8, 0)
        self.shape = self.session.get_inputs()[0].shape
        self.bound = self.session.io_binding()
        self.bound.bind_output("logits")

    def set(self, image):
        image = (image.astype(np.int16) + self.offset).astype(self.kind).reshape(self.shape)
        self.bound.bind_ortvalue_input("image", onnxruntime.OrtValue.ortvalue_from_numpy(image))

    def once(self):
        self.session.run_with_iobinding(self.bound)

    def logits(self):
        return self.bound.copy_outputs_to_cpu()[0].ravel().astype(int) - self.offset


class LiteRt:
    def __init__(self, path):
        self.interpreter = Interpreter(model_path=str(path), num_threads=1)
        self.interpreter.allocate_tensors()
        self.input, self.output = self.interpreter.get_input_details()[0], self.interpreter.get_output_details()[0]

    def set(self, image):
        self.interpreter.set_tensor(self.input["index"], image.reshape(self.input["shape"]))

    def once(self):
        self.interpreter.invoke()

    def logits(self):
        return self.interpreter.get_tensor(self.output["index"]).ravel().astype(int)


def refuse_amx():
    """Lets arch_prctl(ARCH_REQ_XCOMP_PERM, ..) fail with EPERM in this process (x86-64 Linux)."""
    load, equal, answer, allow, refuse = 0x20, 0x15, 0x06, 0x7FFF0000, 0x00050001
    program = [(load, 0, 0, 0), (equal, 0, 3, 158), (load, 0, 0, 16), (equal, 0, 1, 0x1023),
               (answer, 0, 0, refuse), (answer, 0, 0, allow)]
    code = ctypes.create_string_buffer(b"".join(struct.pack("<HBBI", *line) for line in program))
    filter_ = ctypes.create_string_buffer(struct.pack("<HxxxxxxQ", len(program), ctypes.addressof(code)))
    libc = ctypes.CDLL(None, use_errno=True)
    if libc.prctl(38, 1, 0, 0, 0) or libc.prctl(22, 2, ctypes.c_void_p(ctypes.addressof(filter_)), 0, 0):
        raise OSError(ctypes.get_errno(), "seccomp")


def hold(changes):
    """Changes instructions of the loaded LiteRT library, before its first interpreter."""
    libc = ctypes.CDLL(None, use_errno=True)
    counts = [0] * len(changes)
    for line in Path("/proc/self/maps").read_text().splitlines():
        if "r-xp" not in line or not line.endswith("libpywrap_litert_common.so"):
            continue
        begin, end = (int(address, 16) for address in line.split()[0].split("-"))
        place = ctypes.c_void_p(begin), ctypes.c_size_t(end - begin)
        code = ctypes.string_at(begin, end - begin)
        if libc.mprotect(*place, 7):
            raise OSError(ctypes.get_errno(), "mprotect")
        for k, (pattern, instead) in enumerate(changes):
            for found in re.finditer(pattern, code, re.DOTALL):
                ctypes.memmove(begin + found.start(), instead, len(instead))
                counts[k] += 1
        if libc.mprotect(*place, 5):
            raise OSError(ctypes.get_errno(), "mprotect")
    assert all(counts), f"instructions of the detection that were found: {counts}"


def serve_litert(path, most):
    """LiteRT behind the same lines as `bench-infer clock`, with `most` of the processor's instructions."""
    if most != "all":
        refuse_amx()
    hold(HELD.get(most, []))
    clock = own_clock(LiteRt(path))
    images = np.fromfile(path.with_suffix(".images"), np.int8)
    images = images.reshape(-1, 64 * (images.size // 1024))
    print("LiteRT", flush=True)
    for line in sys.stdin:
        found, logits = clock(images, int(line.split()[1]))
        print(*found, list(map(int, logits)), flush=True)


def behind_lines(process, isa):
    def clock(_, count):
        process.stdin.write(f"{isa} {count}\n")
        process.stdin.flush()
        times, logits = process.stdout.readline().strip("]\n").split("[")
        return [int(t) for t in times.split()], np.array([int(v) for v in logits.split(",")])
    return clock


def compare(folder, name, program, rounds, only):
    data = (folder / f"{name}.sdp3").read_bytes()
    images = np.fromfile(folder / f"{name}.images", np.int8).reshape(-1, 64 * struct.unpack_from("<H", data, 26)[0])
    processes = []

    def start(*command):
        processes.append(subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True))
        return processes[-1]

    ours = start(program, "clock", folder / f"{name}.sdp3", folder / f"{name}.images")
    sets = [s for s in ours.stdout.readline().split() if not only or s in only]
    clocks = {f"sdp3 {isa}": behind_lines(ours, isa) for isa in sets}
    amx = "amx_int8" in Path("/proc/cpuinfo").read_text()
    peers = [("LiteRT XNNPACK", "no-amx" if amx else "all")]
    peers += [("LiteRT XNNPACK, AMX", "all")] if amx else []
    # what the processor has beyond is what they are held from
    held = [isa for isa in HELD if isa in sets and sets[-1] != isa] if not only else []
    for key, most in peers + [(f"LiteRT held to {isa}", isa) for isa in held]:
        process = start(sys.executable, __file__, folder / f"{name}.tflite", "--serve", most)
        process.stdout.readline()
        clocks[key] = behind_lines(process, "litert")
    clocks["ONNX Runtime s8s8"] = own_clock(OnnxRuntime(data, False))
    clocks["ONNX Runtime u8s8"] = own_clock(OnnxRuntime(data, True))
    times, logits = {key: [] for key in clocks}, {}
    for turn in range(-1, rounds):
        for key, clock in clocks.items():
            few = key.split()[-1] in ("scalar", "arrays")
            found, logits[key] = clock(images, WARM if turn < 0 else COUNT // 10 if few else COUNT)
            times[key] += found if turn >= 0 else []
            if turn < 0:
                assert len(found) == WARM
                first = logits.setdefault("first", logits[key])
                times.setdefault("far", {})[key] = np.abs(logits[key] - first).max()
    for process in processes:
        process.stdin.close()
        process.wait()
    far = times.pop("far")
    row = lambda key: (np.min(times[key]) / 1e6, np.median(times[key]) / 1e6)
    onnx_best = min((row(k)[1], row(k)) for k in times if k.startswith("ONNX"))[1]
    print(f"\n{name}: {rounds} rounds\n{'':24}{'min ms':>9}{'median ms':>11}{'LiteRT /':>10}{'ONNX /':>8}{'logits off':>12}")
    for key in times:
        least, median = row(key)
        print(f"{key:24}{least:9.4f}{median:11.4f}{row('LiteRT XNNPACK')[1] / median:10.2f}{onnx_best[1] / median:8.2f}"
              f"{far[key]:12}")
    failed = [f"{key}: logits differ from the first by {f}" for key, f in far.items() if key.startswith("sdp3") and f != 0]
    if only:
        return failed
    fastest = min((row(key)[1], key.split()[1]) for key in times if key.startswith("sdp3"))[1]
    if fastest not in LEAST:
        return [*failed, f"sdp3 {fastest} is the fastest of sdp3: no threshold is stated for it"]
    for isa in held:
        ratio = row(f"LiteRT held to {isa}")[1] / row(f"sdp3 {isa}")[1]
        print(f"both held to {isa}: LiteRT / sdp3 {ratio:.2f}, at least {LEAST_HELD[isa]}")
        if ratio < LEAST_HELD[isa]:
            failed.append(f"both held to {isa}: LiteRT / sdp3 = {ratio:.2f}, at least {LEAST_HELD[isa]} must be")
    ours = row(f"sdp3 {fastest}")[1]
    for peer, theirs, least in zip(("LiteRT", "ONNX Runtime"), (row("LiteRT XNNPACK")[1], onnx_best[1]), LEAST[fastest]):
        print(f"{peer} / sdp3 {fastest}: {theirs / ours:.2f}, at least {least}")
        if theirs / ours < least:
            failed.append(f"{peer} / sdp3 {fastest} = {theirs / ours:.2f}, at least {least} must be")
    return failed


def main():
    if sys.argv[2:] and sys.argv[2] == "--serve":
        return serve_litert(Path(sys.argv[1]), sys.argv[3])
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("folder", type=Path)
    parser.add_argument("clock")
    parser.add_argument("--rounds", type=int, default=20)
    parser.add_argument("--isa", action="append", help="only this instruction set of sdp3's")
    arguments = parser.parse_args()
    print(f"load average before: {os.getloadavg()[0]:.1f}; ratios are peer's median / median, the better ONNX Runtime")
    files = sorted(arguments.folder.glob("*.sdp3"))
    failed = [] if files else [f"{arguments.folder}: no network"]
    for file in files:
        found = compare(arguments.folder, file.stem, arguments.clock, arguments.rounds, arguments.isa)
        failed += [f"{file.stem}: {line}" for line in found]
    print(f"\nload average after: {os.getloadavg()[0]:.1f}")
    for line in failed:
        print(f"FAILED: {line}")
    return 1 if failed else 0


sys.exit(main())
