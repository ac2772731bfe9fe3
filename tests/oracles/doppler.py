"""A Doppler sensor's recordings through `sdp3 train` and `sdp3 classify`: `doppler.py SDP3 FOLDER [MEASURED]` (called by tests/classify).

Simulated recordings of a 24 GHz sensor are written as WAV. What the radar module's slots are is computed here a second time. MEASURED is
a folder of recordings of a 24.125 GHz sensor with the motion in their names.
"""

import array
import json
import math
import sys
import wave
from pathlib import Path

import checks
from checks import WORK, check, run

RATE, CARRIER, CORNER = 2000, 24.125e9, 20.0
CLASSES = ["adult-walking", "standing"]


def write(path, samples, rate):
    with wave.open(str(path), "wb") as file:
        file.setnchannels(1), file.setsampwidth(2), file.setframerate(rate)
        file.writeframes(array.array("h", samples).tobytes())


def slots(samples):
    """AC coupling by two sections of first order, settled to the first sample; then a root of the mean power of 1024 LSB."""
    keep = math.exp(-2 * math.pi * CORNER / RATE)
    signal = [x / 32768 for x in samples]
    for _ in range(2):
        before, state = signal[0], 0.0
        for n, x in enumerate(signal):
            state, before = (state + x - before) * keep, x
            signal[n] = state
    power = sum(y * y for y in signal) / len(signal)
    scaled = [y * 1024 / math.sqrt(power) for y in signal]
    return array.array("h", [max(-32768, min(32767, int(math.floor(abs(y) + 0.5) * (1 if y > 0 else -1)))) for y in scaled])


def windows(found):
    [recording] = json.loads(found)["recordings"]
    return recording["windows"]


# simulated recordings: their slots are the sensor's samples
folder = WORK / "doppler"
for name in CLASSES:
    made = WORK / f"doppler-{name}"
    run("simulate", "-q", "--sigmf", "--scenario", "doppler-24ghz", "--per-class", 8, "--classes", name,
        "--set", "frame.sensing_slots=[2000]", "--out", made)
    (folder / name).mkdir(parents=True)
    for data in sorted(made.glob("*.sigmf-data")):
        samples = array.array("h", data.read_bytes())
        check(len(samples) == 2000, f"{data}: {len(samples)} samples, a slot is one")
        write(folder / name / f"{data.stem}.wav", samples, RATE)
small = ["--set", "frame.sensing_slots=[500]", "--set", "learning.channels=8", "--set", "learning.blocks=2", "--set", "learning.epochs=30"]
out = WORK / "doppler-learned"
found = json.loads(run("train", "-q", "--scenario", "doppler-24ghz", "--recordings", folder, "--carrier", CARRIER, *small, "--json", "--out", out))
[network] = found["networks"]
print(f"  Doppler sensor       N_s  500  int8 {network['int8']:.3f}  balanced {network['balanced']['mean']:.3f}")
check(found["classes"] == CLASSES and network["int8"] > 0.7, network)

# a file's windows are those of the slots that this script makes of it
model = out / "models/dsn-500.sdp3"
for name in CLASSES:
    path = sorted((folder / name).glob("*.wav"))[0]
    of_file = windows(run("classify", model, path, "--carrier", CARRIER, "--json"))
    with wave.open(str(path)) as file:
        samples = array.array("h", file.readframes(2000))
    live = [json.loads(line) for line in run("classify", model, "-", "--json", stdin=slots(samples).tobytes()).splitlines()]
    check(len(of_file) == 4 and live == of_file, f"{path}: file {of_file}, slots made here {live}")
    # a faster recording of the same signal: every sample held four times
    fast = WORK / f"fast-{name}.wav"
    write(fast, [x for x in samples for _ in range(4)], 4 * RATE)
    of_fast = windows(run("classify", model, fast, "--carrier", CARRIER, "--json"))
    check([w["class"] for w in of_fast] == [w["class"] for w in of_file], f"{of_fast}, at the slots' rate {of_file}")
    run("classify", model, path, "--carrier", CARRIER, "--picture", WORK / f"doppler-{name}.svg")
slow = WORK / "slow.wav"
write(slow, samples, RATE // 2)
for arguments, field in [
    ([slow, "--carrier", CARRIER], "rate (Hz) is 1000, must be at least 2000"),
    ([path, "--carrier", 10e9], "carrier (Hz)"),
    ([path], "--carrier"),
]:
    said = run("classify", model, *arguments, legal=(2,))
    check(field in said, said)

# measured recordings: what the study counts is what `sdp3 classify` says with the study's model
if len(sys.argv) > 3:
    study = WORK / "sim-to-real"
    answer = json.loads(run("study", "sim-to-real", "-q", "--json", "--seeds", 1, "--seed", 1, "--measured", sys.argv[3], "--carrier", CARRIER, "--out", study))
    for score in answer["scores"]:
        print(f"  measured, {score['method']:52} balanced {score['balanced']['mean']:.3f}")
    int8 = answer["scores"][0]
    [model] = (study / "models").glob("motions-*.sdp3")
    for recording, share in zip(answer["recordings"], int8["recordings"], strict=True):
        of_file = windows(run("classify", model, Path(sys.argv[3]) / recording["name"], "--carrier", CARRIER, "--json"))
        right = sum(w["class"] == recording["motion"] for w in of_file)
        print(f"  {recording['name']}: {right} of {len(of_file)} seconds are {recording['motion']}")
        check(len(of_file) == recording["seconds"] and abs(right / len(of_file) - share) < 1e-12, f"{recording}: {right}, {share}")
else:
    print("  measured recordings: not run; tests/classify --measured FOLDER has some")
print(f"{checks.count} checks of a Doppler sensor passed")
