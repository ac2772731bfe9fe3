"""How many slots must be spent on radar to recognise how a person moves, and what does that cost in throughput?

Arrays are numpy's; scenarios are TOML text as the command line reads it, or the name of a built-in one, empty for the paper's room;
answers are those of the commands' ``--json``.
"""

from ._sdp3 import (
    CLASSES,
    Model,
    Scheduler,
    calibrate,
    classify,
    dechirp,
    fit,
    optimize,
    read,
    scenario,
    simulate,
    train,
    __version__,
)

__all__ = [
    "CLASSES",
    "Model",
    "Scheduler",
    "calibrate",
    "classify",
    "dechirp",
    "fit",
    "optimize",
    "read",
    "scenario",
    "simulate",
    "train",
    "__version__",
]
