"""A small network trained in Keras and made int8 by TensorFlow's own converter: a file from somebody else's tools.

    pip install tensorflow-cpu==2.21.0
    python tflite_keras.py FILE.tflite

The topology is the radar module's, with the affine layer as a depthwise 1x1 convolution; the answer ends in Flatten and
Softmax, which become RESHAPE and SOFTMAX. Weights are random, then trained for a few steps on random labels.
"""

import sys
from pathlib import Path

import numpy as np
import tensorflow as tf

CHANNELS, FRAMES, BLOCKS, CLASSES = 8, 21, 1, 5

if __name__ == "__main__":
    layers = tf.keras.layers
    tf.keras.utils.set_random_seed(3)
    image = tf.keras.Input((64, FRAMES, 1), batch_size=1)
    x = layers.Conv2D(CHANNELS, 3, strides=2, padding="same")(image)
    x = layers.MaxPool2D(2)(x)
    for _ in range(BLOCKS):
        t = layers.DepthwiseConv2D(1, activation="relu")(x)
        t = layers.Conv2D(CHANNELS, 3, padding="same", activation="relu6")(t)
        t = layers.Conv2D(CHANNELS, 3, padding="same")(t)
        x = layers.Add()([x, t])
    x = layers.AveragePooling2D((x.shape[1], x.shape[2]))(x)
    x = layers.Flatten()(layers.Conv2D(CLASSES, 1)(x))
    network = tf.keras.Model(image, layers.Softmax()(x))
    rng = np.random.default_rng(1)
    for weights in network.trainable_variables:
        if "bias" in weights.path:
            weights.assign(rng.normal(0, 0.1, weights.shape))
    images, labels = rng.random((64, 64, FRAMES, 1), np.float32), rng.integers(0, CLASSES, 64)
    network.compile("adam", "sparse_categorical_crossentropy")
    for k in range(len(images)):
        network.train_on_batch(images[k : k + 1], labels[k : k + 1])
    converter = tf.lite.TFLiteConverter.from_keras_model(network)
    converter.optimizations = [tf.lite.Optimize.DEFAULT]
    converter.representative_dataset = lambda: ([images[k : k + 1]] for k in range(32))
    converter.target_spec.supported_ops = [tf.lite.OpsSet.TFLITE_BUILTINS_INT8]
    converter.inference_input_type = converter.inference_output_type = tf.int8
    Path(sys.argv[1]).write_bytes(converter.convert())
