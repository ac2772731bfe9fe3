"""Golden .tflite files with every tensor LiteRT's reference kernels compute of one image.

Three kinds: files the host exported (FOLDER of oracle-tflite); files built by flatbuffers' own library from LiteRT's
schema: the networks of network.py; and one of TensorFlow's own converter (tflite_keras.py). `tflite.json` holds file,
image and tensors.

    pip install ai-edge-litert==2.3.0 numpy==2.4.6 flatbuffers==25.12.19
    oracle-tflite FOLDER 1 1 && python tflite_vectors.py FOLDER KERAS.tflite
"""

import base64
import json
import sys
from importlib.metadata import version
from pathlib import Path

import numpy as np
from ai_edge_litert.interpreter import Interpreter, OpResolverType

import network
from tflite import litert

# small, of both widths and strides
EXPORTED = ["07-width4-blocks1-stride1-frames17", "05-width8-blocks2-stride2-frames23", "10-width16-blocks1-stride1-frames8"]


class Kept(network.Graph):
    """A graph that keeps its last file."""

    last = b""

    def flatbuffer(self):
        Kept.last = super().flatbuffer()
        return Kept.last


def base(data):
    return base64.b64encode(data).decode()


def exported(folder, name):
    content = (folder / f"{name}.tflite").read_bytes()
    run, _, shape = litert(content)
    image = np.fromfile(folder / f"{name}.images", np.int8)[: int(np.prod(shape))]
    tensors = [{"layer": layer, "values": base(values.astype(np.int8).tobytes())} for layer, values in run(image)]
    return {"name": name, "exported": True, "file": base(content), "image": base(image.tobytes()), "tensors": tensors}


def foreign(*arguments):
    network.Graph = Kept
    made = network.build(*arguments)
    # without the stem before its pooling
    tensors = [{"layer": t["layer"], "values": t["values"]} for t in made["tensors"][1:]]
    return {"name": made["name"], "exported": False, "file": base(Kept.last), "image": made["image"], "tensors": tensors}


def converted(path):
    """Outputs of the operators that the core has too, in their order."""
    content = path.read_bytes()
    engine = Interpreter(model_content=content, experimental_preserve_all_tensors=True,
                         experimental_op_resolver_type=OpResolverType.BUILTIN_REF)
    engine.allocate_tensors()
    entry = engine.get_input_details()[0]
    image = np.random.default_rng(5).integers(-128, 128, entry["shape"]).astype(np.int8)
    engine.set_tensor(entry["index"], image)
    engine.invoke()
    operators = [o for o in engine._get_ops_details() if o["op_name"] not in ("RESHAPE", "SOFTMAX", "DELEGATE")]
    tensors = [{"layer": o["op_name"], "values": base(engine.get_tensor(o["outputs"][0]).tobytes())} for o in operators]
    # without the stem before its pooling
    return {"name": "keras", "exported": False, "file": base(content), "image": base(image.tobytes()), "tensors": tensors[1:]}


if __name__ == "__main__":
    here = Path(sys.argv[1])
    networks = [exported(here, name) for name in EXPORTED]
    networks += [foreign("random scales", 1, 68, 32, 4, 8, 2, 5, 1, False),
                 foreign("powers of two", 2, 80, 32, 4, 4, 1, 3, 2, True)]
    networks.append(converted(Path(sys.argv[2])))
    source = f"ai-edge-litert {version('ai-edge-litert')}, OpResolverType.BUILTIN_REF"
    path = Path(__file__).with_name("tflite.json")
    path.write_text(json.dumps({"source": source, "networks": networks}, indent=1) + "\n")
    print(f"{path.name}: {path.stat().st_size} bytes")
