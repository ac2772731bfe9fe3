"""Arrays and answers equal what the command line writes and prints, bit for bit."""

import hashlib
import json
import os
import subprocess
from pathlib import Path

import numpy as np
import pytest

import sdp3

SDP3 = os.environ["SDP3"]
ROOT = Path(__file__).parents[3]
SMALL = """name = "small"
[frame]
sensing_slots = [64]
[spectrogram]
window = 32
hop = 8
"""
POINTS = [(200, 0.7885, 500), (300, 0.9016, 500), (400, 0.9142, 500), (500, 0.9309, 500), (600, 0.9292, 500), (1000, 0.9554, 500)]


def run(*words, cwd):
    done = subprocess.run([SDP3, *map(str, words)], cwd=cwd, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return done.stdout


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("sdp3")
    (folder / "small.toml").write_text(SMALL)
    rows = "".join(f"{n},{a},{t}\n" for n, a, t in POINTS)
    (folder / "points.csv").write_text("sensing_slots,accuracy,tested\n" + rows)
    return folder


@pytest.mark.parametrize("raw", [False, True])
def test_recordings_are_those_of_the_dataset(folder, raw):
    out = folder / f"data-{raw}"
    run("simulate", "-q", "--scenario", "small.toml", "--per-class", 3, "--seed", 7, "--out", out, *["--raw"] * raw, cwd=folder)
    stored = np.load(out / "part-00000.npz")
    made = sdp3.simulate(SMALL, per_class=3, seed=7, raw=raw)
    assert set(made) == set(stored.files)
    for name in stored.files:
        assert made[name].dtype == stored[name].dtype and np.array_equal(made[name], stored[name]), name
    if raw:
        assert np.array_equal(sdp3.dechirp(made["raw"][4]), made["beat"][4])


@pytest.fixture(scope="module")
def described(folder):
    """A recording of 450 slots in SigMF."""
    out = folder / "recordings"
    run("simulate", "-q", "--set", "frame.sensing_slots=[450]", "--per-class", 1, "--raw", "--sigmf", "--out", out, cwd=folder)
    return out / "recording-00003.sigmf-meta"


@pytest.mark.parametrize("options", [{}, {"step": 50, "least_confidence": 0.6, "guard": True}])
def test_windows_are_those_of_the_command(folder, described, options):
    file = ROOT / "tests/testkit/models/dsn-200.sdp3"
    words = [["--guard"] if name == "guard" else ["--" + name.replace("_", "-"), value] for name, value in options.items()]
    printed = json.loads(run("classify", file, described, "--json", *sum(words, []), cwd=folder))
    found = sdp3.classify(file, described, **options)
    assert found == printed and len(found["recordings"][0]["windows"]) == (6 if options else 2)
    slots = sdp3.read(described)["samples"]
    of_array = sdp3.classify(file, slots, **options)
    assert of_array["windows"] == printed["recordings"][0]["windows"]
    assert of_array["supervision"] == printed["recordings"][0].get("supervision")
    assert sdp3.classify(file, slots.reshape(450, -1, 2), **options) == of_array


def test_a_recording_is_read_as_the_command_reads_it(folder, described):
    recording = sdp3.read(described)
    found = json.loads(run("inspect", described, "--json", "--out", "inspected", cwd=folder))
    assert recording["samples"].dtype == np.int16 and recording["samples"].shape == (450, 2000)
    assert hashlib.sha256(recording["samples"].tobytes()).hexdigest() == found["samples_sha256"]
    for name in ["rate_hz", "carrier_hz", "power_db"]:
        assert recording[name] == found[name]
    assert recording["about"].items() <= found.items()


def test_numbers_of_one_channel_are_read(folder):
    rate, tone = 2000.0, np.exp(2j * np.pi * 40 / 2000 * np.arange(4000))
    for name, signal in [("complex", tone), ("real", tone.real)]:
        np.save(folder / f"{name}.npy", signal)
        found = sdp3.read(folder / f"{name}.npy", carrier_hz=24e9, rate_hz=rate)
        assert np.array_equal(found["samples"], signal) and (found["rate_hz"], found["carrier_hz"]) == (rate, 24e9)
    with pytest.raises(ValueError, match="carrier"):
        sdp3.read(folder / "real.npy", rate_hz=rate)
    with pytest.raises(ValueError, match="raw slots"):
        sdp3.classify(ROOT / "tests/testkit/models/dsn-200.sdp3", folder / "real.npy", carrier_hz=24e9, rate_hz=rate)


def test_the_model_says_what_the_command_line_says(folder):
    file = ROOT / "tests/testkit/models/dsn-200.sdp3"
    model = sdp3.Model(file.read_bytes())
    summary = json.loads(run("model", "show", file, "--json", cwd=folder))
    assert (model.revision, model.signed) == (summary["revision"], summary["signed"])
    assert (model.sensing_slots, len(model.classes)) == (200, 5)
    # what makes the model's spectrograms, which is not the default
    spectrogram = "[spectrogram]\nrange_db = 50\nfirst_kept = 2"
    made = sdp3.simulate(f"[frame]\nsensing_slots = [200]\n{spectrogram}", per_class=4, raw=True)
    logits = model.logits(made["image"])
    assert logits.shape == (20, 5)
    for n, slots in enumerate(made["raw"]):
        image = model.image(slots)
        assert np.array_equal(image, made["image"][n])
        assert np.array_equal(model.logits(image), logits[n])
        name, confidence = model.classify(slots)
        assert name == model.classes[logits[n].argmax()] and 0.2 <= confidence <= 1.0
    assert (logits.argmax(1) == made["label"]).mean() > 0.4


def test_fits_and_plans_are_the_commands(folder):
    assert sdp3.fit(POINTS) == json.loads(run("predict", "--points", "points.csv", "--json", cwd=folder))
    for rule in [{}, {"accuracy": 0.93}, {"throughput": 1e7}, {"weight": 0.3}]:
        flags = [word for name, value in rule.items() for word in (f"--{name}", value)]
        printed = run("optimize", "--points", "points.csv", "--json", "-q", *flags, cwd=folder)
        assert sdp3.optimize(POINTS, **rule) == json.loads(printed), rule


def test_a_signal_in_memory_is_a_signal_in_a_file(folder):
    walk = sdp3.simulate("[frame]\nsensing_slots = [400]\nspacing_slots = 3", per_class=1, seed=3)["beat"][3]
    signal = np.tile(walk[:, 0, 0] + 1j * walk[:, 0, 1], 5)
    np.save(folder / "walk.npy", signal)
    words = ["calibrate", "--measured", "walk.npy", "--rate", 1000, "--carrier", 3.5e9, "--json", "-q"]
    printed = json.loads(run(*words, cwd=folder))
    found = sdp3.calibrate(signal, 1000.0, 3.5e9)
    assert (found["rho"], found["kl"], found["curve"]) == (printed["rho"], printed["kl"], printed["curve"])


def test_the_schedule_is_the_paper_s():
    plan = sdp3.Scheduler(period=4000, spacing=3, sensing=309, rates=[4, 3, 3])
    slots = plan.play(4000)
    sensing = np.flatnonzero(slots == -1)
    assert np.array_equal(sensing, 4 * np.arange(309))
    assert [int((slots == k).sum()) for k in range(3)] == plan.shares[:3] and plan.position == 0
    assert plan.shares[0] * 4 - plan.shares[1] * 3 in range(-4, 5)
    plan.set_rate(2, 0)
    plan.set_sensing_slots(100)
    again = plan.play(4000)
    assert (again == -1).sum() == 100 and (again == 2).sum() == 0


@pytest.mark.parametrize(
    "wrong, words",
    [
        (lambda: sdp3.scenario("[frame]\nperiod_slots = 0"), "period_slots"),
        (lambda: sdp3.scenario("[frame]\nslots = 1"), "slots"),
        (lambda: sdp3.simulate(per_class=0), "per_class"),
        (lambda: sdp3.simulate(classes=["nobody"]), "nobody"),
        (lambda: sdp3.fit([]), "point"),
        (lambda: sdp3.fit([(200, 1.5), (300, 0.9), (400, 0.9)]), "1.5"),
        (lambda: sdp3.fit([(200,)]), "must be 2 or 3"),
        (lambda: sdp3.optimize(POINTS, accuracy=2), "accuracy is 2"),
        (lambda: sdp3.optimize(POINTS, accuracy=0.9, weight=0.5), "at most one"),
        (lambda: sdp3.calibrate(np.zeros(5000), 1000.0, 3.5e9), "mean power"),
        (lambda: sdp3.calibrate(np.full(5000, np.nan), 1000.0, 3.5e9), "sample 0"),
        (lambda: sdp3.Scheduler(10, 3, 5, [1]), "10"),
        (lambda: sdp3.Scheduler(10, 3, 1, [1] * 9), "users is 9"),
        (lambda: sdp3.Model(b"SDP3"), "truncated"),
        (lambda: sdp3.dechirp(np.zeros((2, 999, 2), np.int16)), "999"),
    ],
)
def test_bad_input_is_a_value_error_with_the_command_s_words(wrong, words):
    with pytest.raises(ValueError, match=words):
        wrong()
