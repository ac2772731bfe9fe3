"""Checks `sdp3 train --recordings` and what `sdp3 classify` prints and draws: `classify.py SDP3 FOLDER` (called by tests/classify).

FOLDER/recordings has simulated SigMF recordings with annotations; their labels are the truth.
"""

import array
import csv
import io
import json
import math
import random
import re
import shutil
import xml.etree.ElementTree as ET
from collections import defaultdict
from pathlib import Path

import checks
from checks import WORK, check, run

RECORDINGS = WORK / "recordings"
SMALL = [
    "--set", "frame.sensing_slots=[200,400]", "--set", "learning.channels=8", "--set", "learning.blocks=2",
    "--set", "learning.train_per_class=40", "--set", "learning.windows=2", "--set", "learning.epochs=60",
]


def train(name, folder, *options):
    found = json.loads(run("train", "-q", "--recordings", folder, *SMALL, *options, "--json", "--out", WORK / name))
    folds = {}
    for r in found["recordings"]:
        group = r["person"] or r["file"]
        check(folds.setdefault(group, r["fold"]) == r["fold"], f"{name}: {group} is in two folds")
    for n in found["networks"]:
        correct = sum(n["confusion"][k][k] for k in range(len(n["confusion"])))
        total = sum(map(sum, n["confusion"]))
        check(total == n["windows"] > 0 and abs(correct / total - n["int8"]) < 1e-12, f"{name}: {n}")
        print(f"  {name:20} N_s {n['sensing_slots']:4}  int8 {n['int8']:.3f}  balanced {n['balanced']['mean']:.3f}")
    return found


# the same labels three ways: annotations, folders, a table
truth = {}
for meta in sorted(RECORDINGS.glob("*.sigmf-meta")):
    [annotation] = json.loads(meta.read_text())["annotations"]
    truth[meta.stem] = annotation["core:label"]
annotated = train("annotations", RECORDINGS)
folders = WORK / "folders"
for stem, label in truth.items():
    (folders / label).mkdir(parents=True, exist_ok=True)
    meta = json.loads((RECORDINGS / f"{stem}.sigmf-meta").read_text())
    meta["annotations"] = []
    (folders / label / f"{stem}.sigmf-meta").write_text(json.dumps(meta))
    shutil.copy(RECORDINGS / f"{stem}.sigmf-data", folders / label)
(RECORDINGS / "labels.csv").write_text(
    "file,class\n" + "".join(f"{stem}.sigmf-meta,{label}\n" for stem, label in truth.items())
)
table = train("table", RECORDINGS)
check(table["networks"] == annotated["networks"], "a table and annotations of the same labels differ")
by_folder = train("folders", folders)
check(by_folder["classes"] == annotated["classes"] and len(by_folder["recordings"]) == 16, "folders")
for method in ["with-simulation", "fine-tuning"]:
    found = train(method, RECORDINGS, "--method", method)
    check(len(found["classes"]) == 5, f"{method}: the classes are the simulator's")
    check(min(n["int8"] for n in found["networks"]) > 0.7, f"{method}: {found['networks']}")
check(min(n["int8"] for n in annotated["networks"]) > 0.7, f"recordings alone: {annotated['networks']}")

# interrupted and resumed: the same networks
shutil.copytree(WORK / "table", WORK / "resumed")
for made in ["points.csv", "recordings.json", "folds/2/dsn-200.checkpoint.json"]:
    (WORK / "resumed" / made).unlink()
check(train("resumed", RECORDINGS, "--resume") == table, "a resumed training differs")

# nothing leaks: four parts of each recording, one person, with a label drawn for the person, are not recognised above chance; were one
# part learned from while another is tested with, they would be
random.seed(1)
drawn = [label for label in sorted(set(truth.values())) for _ in range(8)]
random.shuffle(drawn)
parts = [(0.2 * k, 0.2 * k + 0.2) for k in range(4)]
lines = [
    f"{stem}.sigmf-meta,{label},{stem},{a:.1f},{b:.1f}\n" for stem, label in zip(truth, drawn) for a, b in parts
]
(RECORDINGS / "labels.csv").write_text("file,class,person,from_s,to_s\n" + "".join(lines))
small = ["--set", "frame.sensing_slots=[200]"]
null = train("drawn labels", RECORDINGS, *small)
low = null["networks"][0]["balanced"]["low"]
check(low < 0.5 and null["networks"][0]["int8"] < 0.75, f"drawn labels are recognised: {null['networks']}")
leaking = [line.replace(f",{stem},", f",{stem}-{n % 4},") for n, (line, stem) in
           enumerate((line, line.split(",")[2]) for line in lines)]
(RECORDINGS / "labels.csv").write_text("file,class,person,from_s,to_s\n" + "".join(leaking))
leaked = train("leaking labels", RECORDINGS, *small)
check(leaked["networks"][0]["int8"] > null["networks"][0]["int8"], "parts of a recording do not help each other")
(RECORDINGS / "labels.csv").unlink()

# classify: text, CSV, JSON and annotations agree, and annotations are labels again
model, one = WORK / "table/models/dsn-200.sdp3", next(iter(truth))
file = RECORDINGS / f"{one}.sigmf-meta"
windows = json.loads(run("classify", model, file, "--json"))["recordings"][0]["windows"]
check(len(windows) == 4, f"{len(windows)} windows of 200 slots in 800")
rows = list(csv.DictReader(io.StringIO(run("classify", model, file, "--format", "csv"))))
for window, row in zip(windows, rows, strict=True):
    check(row["file"] == str(file) and row["class"] == window["class"], f"{row}, {window}")
    check([int(v) for v in row["logits"].split()] == window["logits"], f"{row}, {window}")
    check(float(row["confidence"]) == window["confidence"] and int(row["first_slot"]) == window["first_slot"], row)
text = run("classify", model, file).splitlines()[1:]
check([line.split()[2] for line in text] == [w["class"] for w in windows], text)
check({w["slots_used"] for w in windows} == {200}, f"without early exits: {windows}")
annotations = json.loads(run("classify", model, file, "--format", "sigmf"))["annotations"]
check([a["core:label"] for a in annotations] == [w["class"] for w in windows], annotations)
check([a["core:sample_start"] for a in annotations] == [1000 * w["first_slot"] for w in windows], annotations)
counts = defaultdict(list)
for stem, label in truth.items():
    [found] = json.loads(run("classify", model, RECORDINGS / f"{stem}.sigmf-meta", "--json"))["recordings"]
    counts[label] += [w["class"] == label for w in found["windows"]]
share = sum(sum(c) / len(c) for c in counts.values()) / len(counts)
print(f"  of what it learned from, the model recognises {share:.3f} through classify")
check(share > 0.8, f"learned recordings: {share}")

# a class held out: the threshold is stated, and classify takes it
for file_of_third in (WORK / "running").glob("*"):
    (folders / "adult-running").mkdir(exist_ok=True)
    shutil.copy(file_of_third, folders / "adult-running")
three = train("held out", folders, "--hold-out-classes", "--set", "frame.sensing_slots=[400]")
[network] = three["networks"]
unknown = network["unknown"]
print(f"  unknown: {unknown}")
check(0 <= unknown["auroc"] <= 1 and unknown["known_kept"] + unknown["unknown_refused"] >= 1, unknown)
model_of_three, files = WORK / "held out/models/dsn-400.sdp3", sorted((WORK / "running").glob("*.sigmf-meta"))
plain = json.loads(run("classify", model_of_three, *files, "--json"))["recordings"]
confidences = sorted(w["confidence"] for r in plain for w in r["windows"])
threshold = confidences[len(confidences) // 2]
sure = json.loads(run("classify", model_of_three, *files, "--json", "--least-confidence", threshold))["recordings"]
for a, b in zip(plain, sure, strict=True):
    for before, after in zip(a["windows"], b["windows"], strict=True):
        expected = before["class"] if before["confidence"] >= threshold else "unknown"
        check(after["class"] == expected, f"{before}, {after}")

# early exits: what a model for each exit says alone, put together here, is what they say together
WEIGHTS = {}


def windows_of(network, path, *options):
    [found] = json.loads(run("classify", network, path, "--json", *options))["recordings"]
    return found["windows"]


def evidence(folder, exit_, logits):
    """Class and confidence of an exit, 0 or 1, by the logits so far; of a folder without weights by its own alone."""
    weights = WEIGHTS[folder][exit_]
    sums = [sum(w * l for w, l in zip(weights, column)) for column in zip(*logits)]
    most = max(sums)
    return sums.index(most), 1 / sum(math.exp(s - most) for s in sums)


def expected_windows(folder, path, step, threshold):
    """The windows of 400 slots, `step` apart, that end after 200 of them where the first exit reaches the threshold."""
    first, last = (windows_of(folder / f"models/dsn-{n}.sdp3", path, "--step", step) for n in (200, 400))
    for n, early in enumerate(first):
        class_, confidence = evidence(folder, 0, [early["logits"]])
        check(abs(confidence - threshold) > 0.01, f"{path}: the test's threshold is too near to {confidence}")
        if confidence >= threshold:
            yield n * step, 200, class_, confidence, early["logits"]
        elif n < len(last):
            yield n * step, 400, *evidence(folder, 1, [early["logits"], last[n]["logits"]]), last[n]["logits"]


def with_exits(folder, path, step, *options):
    arguments = ["classify", folder / "models/dsn-400.sdp3", path, "--early-exits", folder, "--step", step, *options]
    return json.loads(run(*arguments, "--json"))


def drawn(path, found, step):
    """A picture's windows are those found: class by the line, start and slots by the place, confidence by the height."""
    svg = "{http://www.w3.org/2000/svg}"
    root = ET.parse(path).getroot()
    check(root.tag == f"{svg}svg" and "dB" in [t.text for t in root.iter(f"{svg}text")], f"{path}: {root.tag}")
    recordings = [g for g in root.iter(f"{svg}g") if g.get("class") == "recording"]
    check(len(recordings) == len(found["recordings"]), f"{path}: {len(recordings)} recordings")
    labels = {t.text for t in root.iter(f"{svg}text")}
    check({"time (s)", "Doppler (Hz)", "radial speed (m/s)", "class", "confidence"} <= labels, f"{path}: {labels}")
    for recording, group in zip(found["recordings"], recordings):
        names = {t.text: float(t.get("y")) for t in group.iter(f"{svg}text") if t.get("class") == "class"}
        marks = [g for g in group.iter(f"{svg}g") if g.get("class") == "window"]
        check(len(marks) == len(recording["windows"]), f"{path}: {len(marks)} marks of {len(recording['windows'])} windows")
        left = min(float(g[1].get("x")) for g in marks)
        unit = None
        for window, mark in zip(recording["windows"], marks):
            title, lane, bar = mark
            near = min(names, key=lambda name: abs(names[name] - float(lane.get("y")) - 8.2))
            check(near == window["class"] and near in title.text, f"{path}: {near}, {window}")
            check(abs(float(bar.get("height")) / 60 - window["confidence"]) < 1e-3, f"{path}: {window}")
            grey = mark.get("fill") == "#999"
            check(grey == (window["class"] == "unknown"), f"{path}: {window['class']} is {mark.get('fill')}")
            start = float(bar.get("x")) - left
            if window["first_slot"]:
                unit = unit or start / window["first_slot"]
                check(abs(start - unit * window["first_slot"]) < 0.05, f"{path}: {window} starts at {start}")
                slots = window["slots_used"] if window is recording["windows"][-1] else min(window["slots_used"], step)
                wide = float(bar.get("width")) + 0.6
                check(abs(wide - unit * slots) < 0.05, f"{path}: {window} is {wide} wide")
        check(set(found["classes"]) <= set(names), f"{path}: {names}")


simulated = WORK / "with-simulation"
fitted = json.loads(run("early-exits", "-q", "--json", "--calibrate-per-class", 20, "--set", "learning.test_per_class=5", "--out", simulated))
check([exit_["sensing_slots"] for exit_ in fitted["exits"]] == [200, 400], fitted["exits"])
WEIGHTS[simulated] = [[w / 65536 for w in exit_["weights"]] for exit_ in fitted["exits"]]
shown = [json.loads(run("model", "show", WORK / f"table/models/dsn-{n}.sdp3", "--json"))["network"] for n in (200, 400)]
scales = [float(re.search(r"head: .* output step ([\d.]+)", text)[1]) for text in shown]
WEIGHTS[WORK / "table"] = [[scales[0]], [0, scales[1]]]
used = defaultdict(int)
for folder in WEIGHTS:
    for path in sorted(RECORDINGS.glob("*.sigmf-meta"))[::5]:
        for step in [200, 400]:
            early = sorted(evidence(folder, 0, [w["logits"]])[1] for w in windows_of(folder / "models/dsn-200.sdp3", path, "--step", step))
            middle = max(zip(early, early[1:]), key=lambda pair: pair[1] - pair[0])
            # between two confidences, below all and above all
            for threshold in [sum(middle) / 2, 0, 2]:
                if threshold and middle[1] - middle[0] < 0.021 and threshold < 1:
                    continue
                found = with_exits(folder, path, step, "--threshold", threshold)
                [recording] = found["recordings"]
                expected = list(expected_windows(folder, path, step, threshold))
                check(len(expected) == len(recording["windows"]), f"{folder}, {path}, {threshold}: {recording['windows']}")
                for (first, slots, class_, confidence, logits), window in zip(expected, recording["windows"]):
                    said = [window[field] for field in ("first_slot", "slots_used", "logits")]
                    check(said == [first, slots, logits], f"{said}, expected {first, slots, logits}")
                    check(window["class"] == found["classes"][class_], f"{window}, expected {class_}")
                    check(abs(window["confidence"] / confidence - 1) < 0.012, f"{window}, expected {confidence}")
                    used[threshold if threshold in (0, 2) else "between", slots] += 1
                slots = [w["slots_used"] for w in recording["windows"]]
                check(found["early_exits"]["mean_slots_used"] == sum(slots) / len(slots), found["early_exits"])
                check(found["early_exits"]["fitted"] == (folder == simulated), found["early_exits"])
print(f"  windows by threshold and slots used: {dict(used)}")
check(set(used) == {(0, 200), (2, 400), ("between", 200), ("between", 400)}, used)

# the same as text, CSV, JSON, annotations and live, with the fitted threshold and with one between the confidences
deep, slots_file = simulated / "models/dsn-400.sdp3", RECORDINGS / f"{one}.sigmf-data"
early = sorted(evidence(simulated, 0, [w["logits"]])[1] for w in windows_of(simulated / "models/dsn-200.sdp3", file, "--step", 100))
for options in [[], ["--threshold", (early[0] + early[-1]) / 2]]:
    exits = ["--early-exits", simulated, *options, "--step", 100]
    found = json.loads(run("classify", deep, file, *exits, "--json"))
    [recording] = found["recordings"]
    windows = recording["windows"]
    lines = run("classify", deep, file, *exits).splitlines()
    check([int(line.split()[-2]) for line in lines[1:-1]] == [w["slots_used"] for w in windows], lines)
    check(lines[-1].startswith(f"mean slots used: {found['early_exits']['mean_slots_used']:.1f};"), lines[-1])
    table = run("classify", deep, file, *exits, "--format", "csv")
    rows = list(csv.DictReader(io.StringIO(table)))
    check([int(row["slots_used"]) for row in rows] == [w["slots_used"] for w in windows], rows)
    check([row["class"] for row in rows] == [w["class"] for w in windows], rows)
    annotations = json.loads(run("classify", deep, file, *exits, "--format", "sigmf"))["annotations"]
    check([a["core:sample_count"] for a in annotations] == [1000 * w["slots_used"] for w in windows], annotations)
    stream = slots_file.read_bytes()
    live = [json.loads(line) for line in run("classify", deep, "-", *exits, "--json", stdin=stream).splitlines()]
    check(live == windows, f"live {live}, file {windows}")
    check(run("classify", deep, "-", *exits, stdin=stream).splitlines() == lines[1:], "live text is not the file's")
    live_table = run("classify", deep, "-", *exits, "--format", "csv", stdin=stream)
    check(live_table.replace("standard input", str(file)) == table, "a live table is not the file's")

# the picture: a mark for each window, at its time, in its class's line, as high as its confidence
for ending, begins in [("svg", b"<svg"), ("png", b"\x89PNG"), ("pdf", b"%PDF")]:
    picture = WORK / f"pictures/a.{ending}"
    run("classify", deep, file, "--early-exits", simulated, "--picture", picture)
    check(picture.read_bytes().startswith(begins), f"{picture} does not begin with {begins}")
several = [RECORDINGS / f"{stem}.sigmf-meta" for stem in list(truth)[::5]]
exits = ["--step", 200, "--early-exits", simulated]
confidences = sorted(w["confidence"] for r in json.loads(run("classify", deep, *several, *exits, "--json"))["recordings"] for w in r["windows"])
least = confidences[len(confidences) // 2]
found = json.loads(run("classify", deep, *several, *exits, "--least-confidence", least, "--picture", WORK / "pictures/b.svg", "--json"))
classes = {w["class"] for r in found["recordings"] for w in r["windows"]}
check("unknown" in classes and len(classes) > 1, f"the picture needs sure windows and unsure ones: {classes}")
drawn(WORK / "pictures/b.svg", found, 200)
run("classify", model, file, "--picture", WORK / "pictures/c.svg")
drawn(WORK / "pictures/c.svg", json.loads(run("classify", model, file, "--json")), 200)

# the supervision of samples: slots made silent, saturated, offset and stuck are found, and what is classified stays the same
samples = array.array("h", slots_file.read_bytes())


def set_slots(first, count, value):
    for n in range(first * 2000, (first + count) * 2000):
        samples[n] = value(n)


set_slots(100, 3, lambda n: 7)
set_slots(300, 1, lambda n: 32767 if n // 2 % 2 else -32768)
set_slots(500, 1, lambda n: round(random.gauss(4000, 3000)))
set_slots(600, 1, lambda n: samples[n] & ~1)
damaged = WORK / "damaged"
damaged.mkdir()
(damaged / "a.sigmf-data").write_bytes(samples.tobytes())
meta = json.loads(file.read_text())
meta["global"].pop("core:sha512", None)
(damaged / "a.sigmf-meta").write_text(json.dumps(meta))
plain = windows_of(model, damaged / "a.sigmf-meta")
[recording] = json.loads(run("classify", model, damaged / "a.sigmf-meta", "--guard", "--json"))["recordings"]
said = [(f["fault"], f["slots"], f["first_slot"]) for f in recording["supervision"]["faults"]]
check(said == [("silent", 3, 100), ("saturated", 1, 300), ("offset", 1, 500), ("stuck", 1, 600)], said)
check([w["faulty_slots"] for w in recording["windows"]] == [3, 1, 1, 1] and recording["supervision"]["faulty_slots"] == 6, recording)
check([{**w, "faulty_slots": None} for w in recording["windows"]] == plain, f"{recording['windows']}, without --guard {plain}")
lines = run("classify", model, damaged / "a.sigmf-meta", "--guard").splitlines()
check([line.split()[-2:] for line in lines[1:5]] == [[str(n), "faulty"] for n in (3, 1, 1, 1)] and "silent: 3 slots" in lines[5], lines)
check(run("classify", model, "-", "--guard", stdin=samples.tobytes()).splitlines() == lines[1:], "live faults are not the file's")
whole = json.loads(run("classify", model, *several, "--guard", "--json"))["recordings"]
check({r["supervision"]["faulty_slots"] for r in whole} == {0}, f"faults of simulated recordings: {[r['supervision'] for r in whole]}")

# refusals name the field
for change, field in [
    (["--set", "frame.sensing_slots=[1000]"], "slots is 800"),
    (["--set", "radar.carrier_hz=24e9"], "carrier (Hz)"),
    (["--method", "with-simulation", "--folds", "1"], "--folds"),
    (["--hold-out-classes"], "2 classes"),
]:
    said = run("train", "-q", "--recordings", RECORDINGS, *change, "--out", WORK / "refused", legal=(2,))
    check(field in said, said)
shutil.rmtree(folders / "standing")
shutil.rmtree(folders / "adult-running")
said = run("train", "-q", "--recordings", folders, "--out", WORK / "refused", legal=(2,))
check("classes is 1, must be 2 to 16" in said, said)
said = run("early-exits", "-q", "--out", WORK / "table", legal=(2,))
check("dsn-200.sdp3: classes is adult-walking, standing" in said, said)
said = run("classify", model, RECORDINGS / f"{one}.sigmf-meta", file, "--format", "sigmf", legal=(2,))
check("--format" in said, said)
for arguments, field in [
    ([model, file, "--early-exits", WORK / "table", "--threshold", 0.9], "--early-exits"),
    ([WORK / "table/models/dsn-400.sdp3", file, "--early-exits", WORK / "table"], "--threshold is missing"),
    ([deep, file, "--early-exits", simulated, "--threshold", 3], "--threshold is 3, must be 0 to 2"),
    ([deep, file, "--early-exits", WORK / "table", "--threshold", 0.9], "dsn-200.sdp3 or models/dsn-400.sdp3 of"),
    ([deep, file, "--early-exits", WORK / "absent", "--threshold", 0.9], "absent/scenario.toml"),
    ([deep, file, "--picture", WORK / "refused.gif"], "--picture"),
    ([deep, *[file] * 9, "--picture", WORK / "refused.svg"], "--picture is of 9 recordings"),
    ([deep, file, file, "--format", "sigmf", "--picture", WORK / "refused.svg"], "--format"),
    ([deep, "-", "--picture", WORK / "refused.svg"], "--picture"),
]:
    said = run("classify", *arguments, legal=(2,))
    check(field in said, said)
check(not list(WORK.glob("refused.*")), "a picture of a refused command")
print(f"{checks.count} checks passed")
