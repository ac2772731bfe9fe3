"""Point targets of `sdp3 targets` against what they must equal.

Usage: targets.py recording FOLDER DATA INDEX    in NumPy: velocities, and the recordings of `sdp3 simulate` without their room
       targets.py sionna FOLDER CLASS            Sionna RT's direct echoes
       targets.py radarsimpy FOLDER CLASS        RadarSimPy's baseband
"""
import json
import pathlib
import sys
import tomllib

import numpy as np

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent.parent / "docs/examples"))
import point_targets  # noqa: E402

failed = 0


def below(what, value, bound):
    global failed
    holds = value < bound
    failed += not holds
    print(f"== {what}: {value:.3g}, must be below {bound:g}{'' if holds else ': FAILED'}")


def difference(found, expected):
    """Norm of the difference over that of `expected`."""
    return np.linalg.norm(found - expected) / np.linalg.norm(expected)


def fitted(found, expected):
    """`expected` times the complex number that brings it nearest to `found`."""
    return expected * np.vdot(expected, found) / np.vdot(expected, expected)


def sweep_blocks(targets, radar):
    """Range samples of the paper's radar: the sum of the delayed sweeps times the conjugate of the sent one, the mean of each of eight
    blocks, [slot, block]."""
    delay = 2 * point_targets.distance_m(targets) / point_targets.SPEED_OF_LIGHT
    amplitude = point_targets.echoes(targets, radar["carrier_hz"])
    samples, rate = radar["samples"], radar["bandwidth_hz"] / radar["sweep_s"]
    time = np.arange(1, samples + 1) / radar["sample_rate_hz"]
    blocks = np.zeros((len(targets.time_s), samples), complex)
    for k in range(len(targets.parts)):
        tau = delay[:, k, None]
        blocks += amplitude[:, k, None] * np.exp(1j * np.pi * rate * (tau**2 - 2 * tau * time))
    return blocks.reshape(len(blocks), 8, -1).mean(axis=2)


def moving(signal):
    """Without the mean over the slots, which has the room."""
    return signal - signal.mean(axis=0)


def recording(folder, data, index):
    data = pathlib.Path(data)
    radar = tomllib.loads((data / "scenario.toml").read_text())["radar"]
    manifest = json.loads((data / "manifest.json").read_text())
    beats = np.load(data / "part-00000.npz")["beat"]
    about = json.loads((pathlib.Path(folder) / "targets.json").read_text())
    assert about["index"] == int(index) and len(about["files"]) == len(manifest["classes"])
    worst = dict.fromkeys(["velocity", "samples", "doppler", "centre"], 0.0)
    fastest = 0.0
    for label, name in enumerate(manifest["classes"]):
        targets = point_targets.read(folder, name)
        truth = [truth for truth in manifest["truth"] if truth["label"] == label][int(index)]
        person = about["files"][label]["person"]
        assert all(truth[field] == value for field, value in person.items()), (truth, person)

        secants = (targets.position_m[2:] - targets.position_m[:-2]) / (2 * targets.every_s)
        error = np.linalg.norm(secants - targets.velocity_m_s[1:-1], axis=-1).max()
        worst["velocity"] = max(worst["velocity"], error)
        fastest = max(fastest, np.linalg.norm(targets.velocity_m_s, axis=-1).max())

        found = moving(beats[truth["index"]].astype(float) @ [1, 1j])
        expected = moving(sweep_blocks(targets, radar))
        expected = fitted(found, expected)
        worst["samples"] = max(worst["samples"], difference(found, expected))
        # Doppler over time: with the whole sweep, and as one frequency
        power = [10 ** (point_targets.spectrogram(s.mean(axis=1), 1 / targets.every_s)[1] / 10) for s in (found, expected)]
        worst["doppler"] = max(worst["doppler"], difference(*power))
        centre = moving(point_targets.echoes(targets, targets.centre_hz).sum(axis=1))
        worst["centre"] = max(worst["centre"], difference(found.mean(axis=1), fitted(found.mean(axis=1), centre)))
    print(f"== {len(manifest['classes'])} classes, {len(targets.time_s)} instants, parts move at up to {fastest:.2f} m/s")
    below("velocities against differences of positions over 2 ms, in m/s", worst["velocity"], 0.02)
    below("range samples against the recordings, share of the amplitude", worst["samples"], 2e-3)
    below("Doppler over time against the recordings, share of the power", worst["doppler"], 5e-4)
    below("slow time at the sweep's middle against the recordings, share of the amplitude", worst["centre"], 2e-2)
    assert fastest > 2, "nobody moves"


def sionna(folder, name):
    import sionna_targets

    targets = point_targets.read(folder, name)
    coefficient, delay, doppler = sionna_targets.echoes(targets)
    expected = point_targets.doppler_hz(targets, targets.carrier_hz)
    print(f"== {len(coefficient)} instants, {len(targets.parts)} parts at {targets.carrier_hz / 1e9:g} GHz, Doppler shifts "
          f"{expected.min():.1f} to {expected.max():.1f} Hz")
    echoes = point_targets.echoes(targets, targets.carrier_hz)
    below("coefficients against the radar equation, largest over the largest", abs(coefficient - echoes).max() / abs(echoes).max(), 2e-3)
    below("distances by the delays, in m", abs(delay * point_targets.SPEED_OF_LIGHT / 2 - point_targets.distance_m(targets)).max(), 1e-5)
    below("Doppler shifts against the velocities, in Hz", abs(doppler - expected).max(), 1e-3)


def radarsimpy(folder, name):
    import radarsimpy_targets

    targets = point_targets.read(folder, name)
    found = radarsimpy_targets.slow_time(targets)
    expected = fitted(found, point_targets.echoes(targets, targets.centre_hz).sum(axis=1))
    print(f"== {len(found)} pulses at {targets.centre_hz / 1e9:g} GHz")
    below("baseband against the radar equation, share of the amplitude", difference(found, expected), 1e-3)


{"recording": recording, "sionna": sionna, "radarsimpy": radarsimpy}[sys.argv[1]](*sys.argv[2:])
sys.exit(failed != 0)
