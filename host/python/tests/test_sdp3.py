"""Arrays and answers equal what the command line writes and prints, bit for bit."""

import _thread
import ast
import functools
import hashlib
import json
import os
import re
import subprocess
import threading
import time
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
        sdp3.classify(ROOT / "tests/testkit/models/dsn-200.sdp3", folder / "real.npy", carrier_hz=3.5e9, rate_hz=rate)


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


LEARN = SMALL + """[learning]
channels = 4
blocks = 1
train_per_class = 4
"""
THREE = ["adult-walking", "standing", "child-walking"]


@pytest.fixture(scope="module")
def labelled(folder):
    """Twelve recordings of three classes, annotated with their class in SigMF: files, arrays, class names, rate and carrier in Hz."""
    out = folder / "labelled"
    words = ["simulate", "-q", "--scenario", "small.toml", "--set", "frame.sensing_slots=[160]", "--per-class", 4, "--raw", "--sigmf"]
    run(*words, "--classes", ",".join(THREE), "--out", out, cwd=folder)
    (folder / "learn.toml").write_text(LEARN)
    files = sorted(out.glob("*.sigmf-meta"))
    names = [json.loads(file.read_text())["annotations"][0]["core:label"] for file in files]
    found = [sdp3.read(file) for file in files]
    return files, [one["samples"] for one in found], names, found[0]["rate_hz"], found[0]["carrier_hz"]


def trained(folder, out, *words, sensing_slots=(64,)):
    """The answer of `sdp3 train --recordings` with two epochs, without the names of files, and the models."""
    words = ["train", "-q", "--json", "--scenario", "learn.toml", "--set", "learning.epochs=2", "--out", out, *words]
    found = json.loads(run(*words, cwd=folder))
    models = {n: (folder / out / f"models/dsn-{n}.sdp3").read_bytes() for n in sensing_slots}
    return unnamed({**found, "models": models})


def unnamed(found):
    return {**found, "recordings": [{**one, "file": ""} for one in found["recordings"]]}


@pytest.mark.parametrize("options", [{}, {"hold_out_classes": True, "folds": 3, "seed": 7}, {"method": "fine-tuning", "preset": "paper"}])
def test_networks_are_those_of_the_command(folder, labelled, options):
    files, arrays, names, _, _ = labelled
    words = [[flag] if value is True else [flag, value] for name, value in options.items() for flag in ["--" + name.replace("_", "-")]]
    expected = trained(folder, f"learned-{len(options)}-{len(words)}-{options.get('method')}", "--recordings", files[0].parent, *sum(words, []))
    found = sdp3.train(arrays, names, LEARN, epochs=2, **options)
    assert unnamed(found) == expected
    assert [one["file"] for one in found["recordings"]][::11] == ["recordings[00]", "recordings[11]"]
    of_files = sdp3.train(files, names, LEARN, epochs=2, **options)
    assert unnamed(of_files) == expected and of_files["recordings"][3]["file"] == str(files[3])
    assert sdp3.Model(found["models"][64]).classes == found["classes"]
    assert found["classes"] == (sdp3.CLASSES[:5] if "method" in options else sorted(THREE))


def test_persons_are_those_of_the_table(folder, labelled):
    _, arrays, names, rate, carrier = labelled
    out = folder / "table"
    out.mkdir()
    persons = [None if n == 5 else f"person {n % 4}" for n in range(12)]
    rows = [f"recordings-{n:02}.npy,{name},{person or ''}" for n, (name, person) in enumerate(zip(names, persons))]
    (out / "labels.csv").write_text("\n".join(["file,class,person", *rows]) + "\n")
    for n, array in enumerate(arrays):
        np.save(out / f"recordings-{n:02}.npy", array)
    words = ["--recordings", out, "--rate", rate, "--carrier", carrier, "--set", "frame.sensing_slots=[56,64]"]
    expected = trained(folder, "learned-table", *words, sensing_slots=(56, 64))
    pairs = [array.reshape(160, -1, 2) for array in arrays]
    found = sdp3.train(pairs, names, LEARN, persons=persons, epochs=2, sensing_slots=[56, 64])
    assert unnamed(found) == expected
    folds = {person: {one["fold"] for one in found["recordings"] if one["person"] == person} for person in set(persons) - {None}}
    assert all(len(of) == 1 for of in folds.values()) and len(folds) == 4


def test_a_model_in_memory_classifies_as_its_file(folder, labelled):
    _, arrays, names, _, _ = labelled
    found = sdp3.train(arrays, names, LEARN, epochs=1, folds=2)
    file = folder / "in-memory.sdp3"
    file.write_bytes(found["models"][64])
    assert sdp3.classify(found["models"][64], arrays[0], step=20) == sdp3.classify(file, arrays[0], step=20)
    with pytest.raises(ValueError, match="model"):
        sdp3.classify(b"SDP3", arrays[0])


def test_a_training_that_is_interrupted_goes_on(folder, labelled):
    _, arrays, names, _, _ = labelled
    # Ctrl-C while the first part is trained
    ctrl_c = threading.Timer(1.0, _thread.interrupt_main)
    ctrl_c.start()
    begun = time.monotonic()
    with pytest.raises(KeyboardInterrupt):
        sdp3.train(arrays, names, LEARN, epochs=10000, out=folder / "stopped")
    assert time.monotonic() - begun < 30 and (folder / "stopped/folds/1/dsn-64.checkpoint.json").exists()
    whole = sdp3.train(arrays, names, LEARN, epochs=3, out=folder / "resumed")
    (folder / "resumed/models/dsn-64.checkpoint.json").unlink()
    assert sdp3.train(arrays, names, LEARN, epochs=3, out=folder / "resumed", resume=True) == whole
    with pytest.raises(ValueError, match="learning.epochs|settings"):
        sdp3.train(arrays, names, LEARN, epochs=4, out=folder / "resumed", resume=True)


def infineon(folder, samples, rate, carrier):
    """Slots of a module's one antenna, as Infineon's radar SDK writes them."""
    folder.mkdir(parents=True)
    shape = {
        "rx_antennas": [1], "start_frequency_Hz": carrier, "end_frequency_Hz": carrier + 1e9, "num_chirps_per_frame": 1,
        "num_samples_per_chirp": samples.shape[1], "chirp_repetition_time_s": 1 / rate, "frame_repetition_time_s": 1 / rate,
        "sample_rate_Hz": 2000000,
    }
    np.save(folder / "radar.npy", (samples.astype(int) + 2048).astype("<u2")[:, None, None])
    (folder / "config.json").write_text(json.dumps({"device_config": {"fmcw_single_shape": shape}}))


def test_from_an_infineon_folder_to_a_class(folder, monkeypatch, capsys):
    """The block of README.md, on simulated modules, with two epochs."""
    block = re.search(r"## From an Infineon folder to a class\n.*?```python\n(.*?)```", (ROOT / "host/python/README.md").read_text(), re.S)[1]
    assert len([line for line in block.splitlines() if line]) <= 10
    out = folder / "modules"
    words = ["simulate", "-q", "--scenario", "bgt60", "--set", "frame.sensing_slots=[1000]", "--per-class", 3, "--raw", "--sigmf"]
    run(*words, "--classes", "adult-walking,standing", "--out", out, cwd=folder)
    for n, file in enumerate(sorted(out.glob("*.sigmf-meta"))):
        name = json.loads(file.read_text())["annotations"][0]["core:label"]
        found = sdp3.read(file)
        infineon(out / "recordings" / name / f"RadarIfxAvian_{n:02}", found["samples"], found["rate_hz"], found["carrier_hz"])
    infineon(out / "new", found["samples"], found["rate_hz"], found["carrier_hz"])
    assert np.array_equal(sdp3.read(out / "new")["samples"], found["samples"])
    monkeypatch.chdir(out)
    monkeypatch.setattr(sdp3, "train", functools.partial(sdp3.train, epochs=2))
    exec(compile(block, "README.md", "exec"), {})
    balanced, classes = map(ast.literal_eval, capsys.readouterr().out.splitlines())
    assert 0 <= balanced["low"] <= balanced["mean"] <= balanced["high"] <= 1
    assert len(classes) == 1 and classes[0] in ["adult-walking", "standing"]


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


SLOTS = np.random.default_rng(1).integers(-1000, 1000, (70, 2000), np.int16)


def learn(recordings=(SLOTS, SLOTS), labels=("sit", "fall"), **options):
    return sdp3.train(recordings, labels, LEARN, **options)


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
        (lambda: sdp3.simulate("bgt59"), "scenario"),
        (lambda: learn(labels=["sit"]), "number of labels is 1, must be 2"),
        (lambda: learn(labels=["sit", ""]), r"labels\[1\] is \"\", must be not empty"),
        (lambda: learn(labels=["sit", "sit"]), "recordings: classes is 1, must be 2 to 16"),
        (lambda: learn(), "class sit is 1 recording or person, must be at least 2"),
        (lambda: learn(persons=["Ada"]), "number of persons is 1, must be 2"),
        (lambda: learn(folds=1), "folds is 1, must be 2 to 1000"),
        (lambda: learn(method="guessing"), "method is guessing, must be one of recordings, with-simulation, fine-tuning"),
        (lambda: learn(preset="slow"), "preset is slow, must be one of quick, paper"),
        (lambda: learn(epochs=0), "learning.epochs is 0, must be"),
        (lambda: learn(sensing_slots=[]), "frame.sensing_slots"),
        (lambda: learn([np.zeros((70, 2000))] * 2), r"recordings\[0\]: type is float64, must be a path, or an array of int16"),
        (lambda: learn([[1, 2]] * 2), "type is <class 'list'>"),
        (lambda: learn([np.zeros((70, 2000, 3), np.int16)] * 2), r"shape is \[70, 2000, 3\], must be \[slot, value\]"),
        (lambda: learn([SLOTS[:, :1000]] * 4, ["sit", "fall"] * 2), r"recordings\[0\]: values a slot is 1000, must be 2000"),
        (lambda: learn([SLOTS[:60]] * 4, ["sit", "fall"] * 2), "slots is 60, must be at least 64"),
        (lambda: learn([0 * SLOTS] * 4, ["sit", "fall"] * 2), r"recordings\[0\]: mean power is 0"),
        (lambda: learn([SLOTS] * 4, ["sit", "fall"] * 2, rate_hz=1.5e3), "slot interval"),
        (lambda: learn(["nowhere.npy"] * 2, ["sit", "fall"], persons=["Ada", "Bo"]), "class sit is 1"),
        (lambda: learn(["nowhere.npy", "no.npy"] * 2, ["sit", "fall", "fall", "sit"]), "nowhere.npy"),
    ],
)
def test_bad_input_is_a_value_error_with_the_command_s_words(wrong, words):
    with pytest.raises(ValueError, match=words):
        wrong()
