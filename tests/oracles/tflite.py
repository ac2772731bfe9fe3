"""Every layer of exported networks in LiteRT and tflite-micro against the core's bits.

    python tflite.py FOLDER

FOLDER holds NAME.tflite, NAME.images and NAME.layers of oracle-tflite (tflite.rs). LiteRT runs with the BUILTIN_REF
resolver (the portable reference kernels, no delegate) and keeps all tensors; so does tflite-micro. Prints one line per
network and runtime, and exits with 1 on any mismatch. The stem before its pooling is not compared, for the core never
holds it as a whole; the pooled one is. Constants of the file are passed over.
"""

import sys
from importlib.metadata import version
from pathlib import Path

import numpy as np
from ai_edge_litert.interpreter import Interpreter, OpResolverType

from tflite_micro.python.tflite_micro import runtime as micro


def litert(content):
    """Runs an image, returns every activation by name in the order of the file."""
    engine = Interpreter(model_content=content, experimental_preserve_all_tensors=True,
                         experimental_op_resolver_type=OpResolverType.BUILTIN_REF)
    engine.allocate_tensors()
    entry = engine.get_input_details()[0]
    outputs = [d for d in engine.get_tensor_details() if compared(d["name"])]

    def run(image):
        engine.set_tensor(entry["index"], image.reshape(entry["shape"]))
        engine.invoke()
        return [(d["name"], engine.get_tensor(d["index"]).ravel()) for d in outputs]

    return run, [(d["name"], d["index"]) for d in outputs], entry["shape"]


def tflite_micro(content, outputs, shape):
    """As litert, for tflite-micro; the places of the tensors are known from there."""
    config = micro.InterpreterConfig.kPreserveAllTensors
    engine = micro.Interpreter.from_bytes(content, intrepreter_config=config, arena_size=64 << 20)

    def run(image):
        engine.set_input(image.reshape(shape), 0)
        engine.invoke()
        return [(name, np.asarray(engine.GetTensor(index, 0)["tensor_data"], np.int8).ravel()) for name, index in outputs]

    return run


def compared(name):
    return name not in ("image", "stem") and not name.endswith((" weights", " bias"))


def compare(run, images, expected):
    """Values compared, mismatches, and where the first one is."""
    count = wrong = 0
    first = None
    for number, (image, layers) in enumerate(zip(images, expected)):
        at = 0
        for name, values in run(image):
            core = layers[at : at + values.size]
            differs = np.flatnonzero(core != values) if core.size == values.size else np.arange(values.size)
            if differs.size and first is None:
                first = f"image {number}, {name}, value {differs[0]}"
            at, count, wrong = at + values.size, count + values.size, wrong + differs.size
        if at != layers.size:
            wrong, first = wrong + 1, first or f"image {number}: {at} values, the core has {layers.size}"
    return count, wrong, first


def main(folder):
    total = {}
    for path in sorted(folder.glob("*.tflite")):
        content = path.read_bytes()
        run, outputs, shape = litert(content)
        images = np.fromfile(path.with_suffix(".images"), np.int8).reshape(-1, int(np.prod(shape)))
        expected = np.fromfile(path.with_suffix(".layers"), np.int8).reshape(len(images), -1)
        runs = {f"LiteRT {version('ai-edge-litert')} BUILTIN_REF": run,
                f"tflite-micro {version('tflite-micro')}": tflite_micro(content, outputs, shape)}
        for runtime, run in runs.items():
            count, wrong, first = compare(run, images, expected)
            so_far = total.setdefault(runtime, [0, 0])
            so_far[0], so_far[1] = so_far[0] + count, so_far[1] + wrong
            where = f", first: {first}" if first else ""
            print(f"{path.stem}: {runtime}: {len(images)} images, {count} values, {wrong} mismatches{where}", flush=True)
    for runtime, (count, wrong) in total.items():
        print(f"== {runtime}: {count} values compared, {wrong} mismatches")
    return 0 if total and not any(wrong for _, wrong in total.values()) else 1


if __name__ == "__main__":
    sys.exit(main(Path(sys.argv[1])))
