"""Every layer of any int8 .tflite file in LiteRT's reference kernels against the core's bits.

    pip install ai-edge-litert==2.3.0 numpy==2.4.6
    python networks.py inputs FILE.tflite COUNT SEED INPUTS.npy
    python networks.py check FILE.tflite INPUTS.npy LAYERS.npy
    python networks.py first OPERATORS.json INPUTS.npy LAYERS.npy FOLDER

`inputs` writes COUNT inputs, int8 [COUNT, ...]: of four, two are noise over the whole range, one is smooth and near
the zero point, and one is at the limits (all -128, all 127, then mixtures of both).

`check` runs the file on each of them with the BUILTIN_REF resolver (the portable reference kernels, no delegate) and
keeps all tensors. LAYERS.npy holds what the core computed (`sdp3 infer --layers`): for each input the outputs of all operators
but RESHAPE, in the order of the file, one int8 after the other. Order, kinds and outputs of the operators are read from the file
itself. `first` writes the first input (FOLDER/input.bin) and the CRC-32 of every operator's output of it, a line each
(FOLDER/checksums), of the operators that `sdp3 model show --json` lists. `check` prints one line; exit code 0: no mismatch, 1: a mismatch, a wrong length or no input, 2: usage.
"""

import json
import sys
import zlib
from importlib.metadata import version
from pathlib import Path

import numpy as np
from ai_edge_litert import schema_py_generated as tfl
from ai_edge_litert.interpreter import Interpreter, OpResolverType


def operators(content):
    """Kind and output tensors of every operator of the file, in order."""
    names = {code: name for name, code in vars(tfl.BuiltinOperator).items() if isinstance(code, int)}
    model = tfl.ModelT.InitFromPackedBuf(content, 0)
    codes = [max(c.builtinCode, c.deprecatedBuiltinCode) for c in model.operatorCodes]
    return [(names[codes[o.opcodeIndex]], list(o.outputs)) for o in model.subgraphs[0].operators]


def engine_of(content):
    """The interpreter, and its one input."""
    engine = Interpreter(model_content=content, experimental_preserve_all_tensors=True,
                         experimental_op_resolver_type=OpResolverType.BUILTIN_REF)
    engine.allocate_tensors()
    (entry,) = engine.get_input_details()
    assert entry["dtype"] == np.int8, "the input is not int8"
    return engine, entry


def smooth(rng, shape, zero):
    """A plane wave of low amplitude around the zero point, with a little noise."""
    phase = rng.uniform(0, 7) + sum(rng.normal(0, 0.4) * place for place in np.indices(shape))
    wave = zero + rng.uniform(1, 40) * np.sin(phase) + rng.normal(0, 1.5, shape)
    return np.clip(np.round(wave), -128, 127)


def extreme(rng, shape, number):
    """All -128, all 127, then every value one of the two."""
    share = number if number < 2 else rng.uniform(0, 1)
    return np.where(rng.uniform(0, 1, shape) < share, 127, -128)


def make_inputs(path, count, seed):
    _, entry = engine_of(path.read_bytes())
    shape, zero = tuple(entry["shape"]), entry["quantization"][1]
    rng = np.random.default_rng(seed)
    kinds = [lambda k: rng.integers(-128, 128, shape), lambda k: smooth(rng, shape, zero),
             lambda k: rng.integers(-128, 128, shape), lambda k: extreme(rng, shape, k // 4)]
    return np.concatenate([kinds[k % 4](k) for k in range(count)]).astype(np.int8)


def check(path, inputs, layers):
    content = path.read_bytes()
    engine, entry = engine_of(content)
    watched = [(k, kind, output) for k, (kind, outputs) in enumerate(operators(content)) if kind != "RESHAPE"
               for output in outputs]
    size, count, wrong, at, first = int(np.prod(entry["shape"])), 0, 0, 0, ""
    for number, image in enumerate(inputs[: len(inputs) // size * size].reshape(-1, *entry["shape"])):
        engine.set_tensor(entry["index"], image)
        engine.invoke()
        for k, kind, output in watched:
            values = engine.get_tensor(output).ravel()
            assert values.dtype == np.int8, f"operator {k} {kind} answers {values.dtype}"
            core = layers[at : at + values.size]
            differs = np.flatnonzero(core != values[: core.size])
            if differs.size and not first:
                first = f", first: input {number}, operator {k} {kind}, value {differs[0]}"
            at, count, wrong = at + values.size, count + core.size, wrong + differs.size
    images, runtime = len(inputs) // size, f"LiteRT {version('ai-edge-litert')} BUILTIN_REF"
    print(f"{path.stem}: {runtime}: {images} inputs, {count} values, {wrong} mismatches{first}")
    if not images or len(inputs) % size:
        return f"{len(inputs)} bytes of inputs, one input has {size}"
    if at != len(layers):
        return f"the layers have {len(layers)} values, LiteRT {at}"
    return 1 if wrong else 0


def write_first(operators, inputs, layers, folder):
    inputs[0].tofile(folder / "input.bin")
    sizes = [int(np.prod(operator["output"])) for operator in json.loads(operators.read_text())["operators"]]
    outputs = np.split(layers[0], np.cumsum(sizes))
    assert outputs.pop().size == 0
    (folder / "checksums").write_text("".join(f"{zlib.crc32(values.tobytes()):08x}\n" for values in outputs))


def main(arguments):
    match arguments:
        case ["inputs", path, count, seed, out]:
            np.save(out, make_inputs(Path(path), int(count), int(seed)))
        case ["check", path, inputs, layers]:
            return check(Path(path), np.load(inputs).ravel(), np.load(layers).ravel())
        case ["first", operators, inputs, layers, folder]:
            write_first(Path(operators), np.load(inputs), np.load(layers), Path(folder))
        case _:
            print(__doc__, file=sys.stderr)
            return 2


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
