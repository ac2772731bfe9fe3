"""Answers of scikit-learn's support vector classifier (libsvm): makes svm.json.

    pip install numpy scikit-learn; python3 tests/oracles/svm.py

Images of four classes that overlap, described by mean, deviation, largest and smallest level of every row, scaled; every
candidate of C and gamma trained on all training images and cross-validated in three runs of every class.
"""

import base64
import json
import pathlib

import numpy as np
from sklearn.model_selection import PredefinedSplit, cross_val_predict
from sklearn.pipeline import make_pipeline
from sklearn.preprocessing import StandardScaler
from sklearn.svm import SVC

ROWS, FRAMES, CLASSES, FOLDS = 12, 9, 4, 3
PENALTIES, WIDTHS = (4.0, 64.0, 1024.0, 16384.0), (0.25, 0.0625, 0.015625, 0.00390625)


def draw(random, per_class):
    labels = np.tile(np.arange(CLASSES), per_class)
    rows, frames = np.arange(ROWS)[None, :, None], np.arange(FRAMES)[None, None, :]
    label = labels[:, None, None]
    centre = 4 + 0.4 * label + (0.8 + 0.25 * label) * np.sin(frames + random.uniform(0, 6, (len(labels), 1, 1)))
    level = 140 * np.exp(-((rows - centre) ** 2) / 4) + random.normal(60, 60, (len(labels), ROWS, FRAMES))
    return (np.clip(level, 0, 255) - 128).astype(np.int8), labels.astype(np.uint8)


def features(images):
    level = (images.astype(float) + 128) / 255
    each = [level.mean(2), level.std(2), level.max(2), level.min(2)]
    return np.stack(each, axis=2).reshape(len(images), -1)


def runs(labels):
    fold = np.zeros(len(labels), int)
    for label in np.unique(labels):
        here = np.flatnonzero(labels == label)
        fold[here] = np.arange(len(here)) * FOLDS // len(here)
    return PredefinedSplit(fold)


def text(array):
    return base64.b64encode(array.tobytes()).decode()


def main():
    random = np.random.default_rng(7)
    (train, labels), (test, truth) = draw(random, 30), draw(random, 60)
    machines = []
    for c in PENALTIES:
        for width in WIDTHS:
            gamma = width / (4 * ROWS)
            machine = make_pipeline(StandardScaler(), SVC(C=c, gamma=gamma))
            answers = machine.fit(features(train), labels).predict(features(test))
            validated = cross_val_predict(machine, features(train), labels, cv=runs(labels))
            print(c, gamma, (answers == truth).mean(), (validated == labels).mean())
            machines.append(
                {
                    "c": c,
                    "gamma": gamma,
                    "answers": text(answers.astype(np.uint8)),
                    "cross_validated": int((validated == labels).sum()),
                }
            )
    vectors = {
        "rows": ROWS,
        "frames": FRAMES,
        "train": {"pixels": text(train), "labels": text(labels)},
        "test": {"pixels": text(test), "labels": text(truth)},
        "machines": machines,
    }
    path = pathlib.Path(__file__).with_suffix(".json")
    path.write_text(json.dumps(vectors, indent=1) + "\n")


if __name__ == "__main__":
    main()
