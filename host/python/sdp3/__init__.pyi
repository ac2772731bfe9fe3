from collections.abc import Sequence
from os import PathLike
from typing import Any, Final, Literal, TypedDict

import numpy as np
from numpy.typing import NDArray

__version__: Final[str]
CLASSES: Final[list[str]]

class Recordings(TypedDict, total=False):
    beat: NDArray[np.int32]
    image: NDArray[np.int8]
    label: NDArray[np.uint8]
    raw: NDArray[np.int16]

class Recording(TypedDict):
    samples: NDArray[Any]
    rate_hz: float
    carrier_hz: float
    power_db: float
    about: dict[str, Any]

class Trained(TypedDict):
    method: str
    classes: list[str]
    recordings: list[dict[str, Any]]
    networks: list[dict[str, Any]]
    models: dict[int, bytes]

def scenario(text: str = "") -> str:
    """The scenario, TOML or a built-in one's name, resolved: every field with its value, as TOML. ValueError names a field that is not legal."""

def simulate(
    scenario: str = "",
    *,
    per_class: int = 1,
    seed: int = 1,
    classes: Sequence[str] | None = None,
    rho: float | None = None,
    raw: bool = False,
) -> Recordings:
    """What ``sdp3 simulate`` stores, recordings of each class in turn.

    ``beat`` [recording, slow time, range, 2] int32; ``image`` [recording, 64, frame] int8, intensities - 128;
    ``label`` [recording] uint8; with ``raw`` also ``raw`` [recording, slow time, samples, 2] int16, LSB, without the
    last axis for a radar of real samples.
    """

def calibrate(
    signal: NDArray[Any],
    rate_hz: float,
    carrier_hz: float,
    *,
    motion: str = "adult-walking",
    scenario: str = "",
    seed: int = 1,
) -> dict[str, Any]:
    """rho of the room that a measured signal, real or complex, shows, with the KL curve: the answer of ``sdp3 calibrate --json``."""

def fit(points: Sequence[Sequence[float]], *, seed: int = 1) -> dict[str, Any]:
    """The seven learning curves through (sensing slots, accuracy[, tested]): the answer of ``sdp3 predict --json``."""

def optimize(
    points: Sequence[Sequence[float]],
    scenario: str = "",
    *,
    accuracy: float | None = None,
    throughput: float | None = None,
    weight: float | None = None,
    seed: int = 1,
) -> dict[str, Any]:
    """Region, zones and operating point under at most one rule: the answer of ``sdp3 optimize --json``."""

def dechirp(slots: NDArray[np.int16], scenario: str = "") -> NDArray[np.int32]:
    """Raw slots [slow time, samples, 2] or [slow time, samples] of the scenario's radar to its range samples [slow time, 8, 2], by the
    radar module's code."""

def read(
    file: str | PathLike[str],
    *,
    carrier_hz: float | None = None,
    rate_hz: float | None = None,
    gain_db: float | None = None,
    dataset: str | None = None,
    antenna: int | None = None,
    chirp: int | None = None,
) -> Recording:
    """A recording of any format that ``sdp3 inspect`` reads.

    ``samples``: [time] float64 or complex128 of one channel; of a radar module [slot, value] int16, LSB, I and Q in turn of a complex
    converter. ``rate_hz`` is of the samples, or of the slots; ``about`` has format, axes, shape and sensor of the file.
    """

def train(
    recordings: Sequence[NDArray[np.int16] | str | PathLike[str]],
    labels: Sequence[str],
    scenario: str = "",
    *,
    persons: Sequence[str | None] | None = None,
    method: Literal["recordings", "with-simulation", "fine-tuning"] = "recordings",
    folds: int = 5,
    hold_out_classes: bool = False,
    sensing_slots: Sequence[int] | None = None,
    epochs: int | None = None,
    preset: Literal["quick", "paper"] = "quick",
    seed: int = 1,
    out: str | PathLike[str] | None = None,
    resume: bool = False,
    progress: bool = False,
    carrier_hz: float | None = None,
    rate_hz: float | None = None,
    dataset: str | None = None,
    antenna: int | None = None,
    chirp: int | None = None,
) -> Trained:
    """Networks from labelled recordings: what ``sdp3 train --recordings`` does, with the same bits.

    ``recordings``: int16 raw slots of the scenario's radar, LSB, [slot, value] or [slot, sample, 2], as long as the largest N_s or longer,
    or paths of what ``read`` reads. ``labels``: the class of each, 2 to 16 classes. ``persons``: who is in each, None where it is not
    known. A person, else a recording, is either learned from or tested with, in 2 to 1000 ``folds`` at most; every class needs two.

    ``sensing_slots``: slots of a window in radar slots, a network for each; ``epochs`` keeps a number of epochs, which few recordings
    would raise. Where one is None the scenario, or else the ``preset``, says. Arrays are of the scenario's carrier and slot rate in Hz;
    ``carrier_hz``, ``rate_hz``, ``dataset``, ``antenna`` and ``chirp`` say of files what these do not.

    ``out`` keeps checkpoints and results, with which ``resume`` goes on; otherwise they are in a folder that is removed. Ctrl-C ends the
    training after the epochs that are under way. ``progress`` is shown on stderr.

    The answer of ``sdp3 train --recordings --json``, with shares of 0 to 1, lengths in s, and ``confusion`` [class][answer]; and
    ``models``: for every N_s the model file of a network that learned from all recordings, for ``Model`` and ``classify``. ValueError
    names a field, its value and the legal ones.
    """

def classify(
    model: str | PathLike[str] | bytes,
    recording: str | PathLike[str] | NDArray[np.int16],
    *,
    step: int | None = None,
    least_confidence: float = 0.0,
    early_exits: str | PathLike[str] | None = None,
    threshold: float | None = None,
    guard: bool = False,
    carrier_hz: float | None = None,
    rate_hz: float | None = None,
    dataset: str | None = None,
    antenna: int | None = None,
    chirp: int | None = None,
) -> dict[str, Any]:
    """The windows of a recording, each with class, confidence and logits: the answer of ``sdp3 classify --json``.

    ``model`` is a model file's path or its bytes. Of an array of slots, [slot, value] or [slot, sample, 2], ``windows``, ``early_exits`` and ``supervision``.
    """

class Scheduler:
    """The radar module's scheduler. Slots are -1 for sensing, -2 for idle, else the user's number."""

    def __init__(self, period: int, spacing: int, sensing: int, rates: Sequence[int]) -> None: ...
    def next(self) -> int: ...
    def play(self, slots: int) -> NDArray[np.int8]: ...
    def lose(self) -> None: ...
    def end_sensing(self) -> None: ...
    def set_rate(self, user: int, rate: int) -> None: ...
    def set_sensing_slots(self, slots: int) -> None: ...
    @property
    def position(self) -> int: ...
    @property
    def shares(self) -> list[int]: ...
    @property
    def longest_waits(self) -> list[int | None]: ...

class Model:
    """A model file, run by the radar module's code: the same bits as on every other processor."""

    def __init__(self, file: bytes) -> None: ...
    @property
    def classes(self) -> list[str]: ...
    @property
    def sensing_slots(self) -> int: ...
    @property
    def frames(self) -> int: ...
    @property
    def revision(self) -> int: ...
    @property
    def signed(self) -> bool: ...
    def image(self, slots: NDArray[np.int16]) -> NDArray[np.int8]:
        """Raw slots of the model's radar to the network's image, [64, frames]."""

    def logits(self, image: NDArray[np.int8]) -> NDArray[np.int8]:
        """[64, frames] or [recording, 64, frames] to [classes] or [recording, classes]."""

    def classify(self, slots: NDArray[np.int16]) -> tuple[str, float]:
        """Raw slots to a class and its confidence, as the base station does it."""
