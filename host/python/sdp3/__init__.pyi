from collections.abc import Sequence
from os import PathLike
from typing import Any, Final, TypedDict

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

def scenario(text: str = "") -> str:
    """The scenario resolved: every field with its value, as TOML. ValueError names a field that is not legal."""

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

def classify(
    model: str | PathLike[str],
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

    Of an array of slots, [slot, value] or [slot, sample, 2], ``windows``, ``early_exits`` and ``supervision``.
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
