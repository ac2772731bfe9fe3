"""The networks of MLPerf Tiny, and one of odd shapes, made int8 by TensorFlow's own converter: somebody else's files.

    pip install tensorflow-cpu==2.21.0
    python networks_build.py FOLDER [SEED]

Writes resnet8.tflite (image classification, 32x32x3, 10 classes), ds-cnn.tflite (keyword spotting, 49x10x1, 12 classes),
small.tflite and radar.tflite. The first two have the published topology; nothing is trained: weights are drawn (SEED, 1 if missing),
and the statistics of the batch normalisation are those of drawn images, so that every layer has a sane range. The third
has what the two lack: no padding, kernels and strides that are not square, a depthwise layer with a stride and two
channels out of each, poolings with padding, ReLU6, a wide dense layer, and no softmax. The fourth takes the radar's image of 200
sensing slots, 64x10x1, 5 classes, in another topology than the paper's.
"""

import os
import sys
from contextlib import redirect_stdout
from pathlib import Path

os.environ.setdefault("CUDA_VISIBLE_DEVICES", "-1")
os.environ.setdefault("TF_CPP_MIN_LOG_LEVEL", "2")

import numpy as np
import tensorflow as tf
from tensorflow.lite.python import schema_py_generated as tfl

layers = tf.keras.layers
OPERATORS = {"CONV_2D", "DEPTHWISE_CONV_2D", "ADD", "AVERAGE_POOL_2D", "MAX_POOL_2D", "FULLY_CONNECTED", "RESHAPE",
             "SOFTMAX"}


def normalised(x, activation=None):
    """Batch normalisation; without momentum a single pass in training mode sets its statistics."""
    x = layers.BatchNormalization(momentum=0.0)(x)
    return layers.Activation(activation)(x) if activation else x


def conv(x, filters, size, stride=1, padding="same"):
    return layers.Conv2D(filters, size, strides=stride, padding=padding, kernel_initializer="he_normal")(x)


def depthwise(x, stride=1, multiplier=1):
    return layers.DepthwiseConv2D(3, strides=stride, padding="same", depth_multiplier=multiplier,
                                  depthwise_initializer="he_normal")(x)


def residual(x, filters, stride):
    """Two convolutions beside an identity, or beside a 1x1 convolution where the size changes."""
    y = normalised(conv(x, filters, 3, stride), "relu")
    y = normalised(conv(y, filters, 3))
    if stride != 1:
        x = conv(x, filters, 1, stride)
    return layers.Activation("relu")(layers.Add()([x, y]))


def resnet8(x):
    x = normalised(conv(x, 16, 3), "relu")
    for filters, stride in ((16, 1), (32, 2), (64, 2)):
        x = residual(x, filters, stride)
    x = layers.Flatten()(layers.AveragePooling2D(8)(x))
    return layers.Dense(10, activation="softmax", kernel_initializer="he_normal")(x)


def ds_cnn(x):
    x = normalised(conv(x, 64, (10, 4), 2), "relu")
    for _ in range(4):
        x = normalised(depthwise(x), "relu")
        x = normalised(conv(x, 64, 1), "relu")
    x = layers.Flatten()(layers.AveragePooling2D((25, 5))(x))
    return layers.Dense(12, activation="softmax", kernel_initializer="he_normal")(x)


def small(x):
    x = normalised(conv(x, 6, (5, 3), (2, 1), "valid"), "relu6")
    x = normalised(depthwise(x, stride=2, multiplier=2), "relu6")
    x = layers.MaxPooling2D((3, 2), strides=2, padding="same")(x)
    x = layers.AveragePooling2D(3, strides=1, padding="same")(x)
    x = layers.Activation("relu")(layers.Add()([x, normalised(conv(x, 12, 3))]))
    x = layers.Dense(9, activation="relu", kernel_initializer="he_normal")(layers.Flatten()(x))
    return layers.Dense(7)(x)


def radar(x):
    for filters in (8, 12):
        x = layers.MaxPooling2D((2, 1))(normalised(conv(x, filters, (5, 3)), "relu"))
        x = normalised(depthwise(x), "relu")
    x = layers.Flatten()(layers.AveragePooling2D((16, 10))(x))
    return layers.Dense(5)(x)


NETWORKS = {
    "resnet8": (resnet8, (32, 32, 3), 255),
    "ds-cnn": (ds_cnn, (49, 10, 1), 1),
    "small": (small, (33, 21, 2), 1),
    "radar": (radar, (64, 10, 1), 255),
}


def images(rng, shape, count, scale):
    """Blocks of four by four with a contrast of their own, and noise."""
    rows, columns, channels = shape
    coarse = rng.normal(0, 1, (count, -(-rows // 4), -(-columns // 4), channels))
    fine = np.kron(coarse, np.ones((1, 4, 4, 1)))[:, :rows, :columns] + rng.normal(0, 0.3, (count, *shape))
    centre, contrast = rng.uniform(0.3, 0.7, (count, 1, 1, channels)), rng.uniform(0.05, 0.4, (count, 1, 1, channels))
    return (np.clip(centre + contrast * fine, 0, 1) * scale).astype(np.float32)


def draw(network, rng):
    """Biases and batch normalisations away from their initial zeros and ones."""
    for weights in network.trainable_variables:
        kind = weights.path.rsplit("/", 1)[-1]
        if kind in ("bias", "beta"):
            weights.assign(rng.normal(0, 0.2, weights.shape))
        elif kind == "gamma":
            weights.assign(rng.uniform(0.6, 1.4, weights.shape))


def build(topology, shape, scale, seed):
    tf.keras.utils.set_random_seed(seed)
    rng = np.random.default_rng(seed)
    samples = images(rng, shape, 64, scale)
    image = tf.keras.Input(shape)
    network = tf.keras.Model(image, topology(image))
    draw(network, rng)
    network(samples, training=True)
    single = tf.keras.Input(shape, batch_size=1)
    fixed = tf.keras.Model(single, topology(single))
    fixed.set_weights(network.get_weights())
    converter = tf.lite.TFLiteConverter.from_keras_model(fixed)
    converter.optimizations = [tf.lite.Optimize.DEFAULT]
    converter.representative_dataset = lambda: ([samples[k : k + 1]] for k in range(len(samples)))
    converter.target_spec.supported_ops = [tf.lite.OpsSet.TFLITE_BUILTINS_INT8]
    converter.inference_input_type = converter.inference_output_type = tf.int8
    return converter.convert()


def operators(content):
    """Names of the operators, in order."""
    names = {code: name for name, code in vars(tfl.BuiltinOperator).items() if isinstance(code, int)}
    model = tfl.ModelT.InitFromPackedBuf(content, 0)
    return [names[model.operatorCodes[o.opcodeIndex].builtinCode] for o in model.subgraphs[0].operators]


def main(folder, seed):
    folder.mkdir(parents=True, exist_ok=True)
    for name, (topology, shape, scale) in NETWORKS.items():
        with redirect_stdout(sys.stderr):
            content = build(topology, shape, scale, seed)
        kinds = operators(content)
        if others := set(kinds) - OPERATORS:
            sys.exit(f"{name}: the converter made {', '.join(sorted(others))}")
        (folder / f"{name}.tflite").write_bytes(content)
        print(f"{name}.tflite: {len(content)} bytes, {len(kinds)} operators")


if __name__ == "__main__":
    if len(sys.argv) not in (2, 3):
        sys.exit(__doc__)
    main(Path(sys.argv[1]), int(sys.argv[2]) if len(sys.argv) == 3 else 1)
