"""Writes a recording in every format that sdp3 reads, and compares what sdp3 makes of it.

Usage: recordings.py SDP3 FOLDER. FOLDER holds what tests/recordings simulated: a walk of the scenarios bgt60 and iwr in SigMF, and
a model of each. Layouts: Infineon's radar SDK (radar.npy, config.json) and raw data (IFRT, IFRB), TI SWRA581 for the DCA1000, SciPy for MATLAB 5, h5py for MATLAB 7.3
and Acconeer's A121, NumPy, SigMF, the module wave, and plain text.
"""

import hashlib
import json
import pathlib
import shutil
import subprocess
import sys
import wave

import h5py
import numpy as np
import scipy.io

program, work = sys.argv[1], pathlib.Path(sys.argv[2])
failed = 0
checked = 0


def check(holds, what):
    global failed, checked
    checked += 1
    if not holds:
        failed += 1
        print(f"FAILED: {what}")


# Runs a program and prints its exit code, seconds and MB. A child is charged for the memory of the process that it was forked from, and
# that of this one is large.
TIMED = """import resource, subprocess, sys, time
began = time.monotonic()
code = subprocess.run(sys.argv[2:], stdin=sys.stdin).returncode
used = resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss / 1024
open(sys.argv[1], "w").write(f"{code} {time.monotonic() - began} {used}")
"""


def call(*arguments, stdin=subprocess.DEVNULL):
    """Exit code, standard output, standard error, seconds and MB of the largest resident set."""
    figures = work / "figures"
    timed = [sys.executable, "-S", "-c", TIMED, str(figures), program, *map(str, arguments)]
    done = subprocess.run(timed, stdin=stdin, capture_output=True, text=True)
    code, took, megabytes = figures.read_text().split()
    return int(code), done.stdout, done.stderr, float(took), float(megabytes)


def inspected(path, *options):
    code, out, err, _, _ = call("inspect", path, *options, "--json", "--out", work / "out", "-q")
    check(code == 0, f"inspect {path}: {err}")
    return json.loads(out) if code == 0 else {}


def digest(array):
    return hashlib.sha256(np.ascontiguousarray(array).tobytes()).hexdigest()


def sigmf_walk(radar):
    (meta,) = (work / radar).rglob("*.sigmf-meta")
    values = np.fromfile(meta.with_suffix(".sigmf-data"), "<i2")
    described = json.loads(meta.read_text())
    samples = described["global"]["sdp3:slot_samples"]
    shape = (-1, samples, 2) if described["global"]["core:datatype"].startswith("c") else (-1, samples)
    return meta, values.reshape(shape), described


def logits(radar, path, *options):
    model = work / f"{radar}-model" / "models" / "dsn-800.sdp3"
    code, out, err, _, _ = call("classify", model, path, *options, "--json", "-q")
    check(code == 0, f"classify {path}: {err}")
    if code != 0:
        return None
    (recording,) = json.loads(out)["recordings"]
    return [(w["first_slot"], w["class"], w["confidence"], w["logits"]) for w in recording["windows"]]


def same(radar, walk, expected, path, *options):
    """The file's samples are the walk's, and its logits those of the SigMF recording."""
    found = inspected(path, *options)
    check(found.get("samples_sha256") == digest(walk), f"{path.name}: other samples")
    check(logits(radar, path, *options) == expected, f"{path.name}: other logits")
    return found


formats = work / "formats"
formats.mkdir()

# --- a real converter of 12 bits: Infineon
meta, walk, described = sigmf_walk("bgt60")
rate, carrier = described["global"]["sdp3:slot_rate"], described["captures"][0]["core:frequency"]
expected = logits("bgt60", meta)
check(len(expected) == len(walk) // 800, f"{len(expected)} windows of {len(walk)} slots")
found = inspected(meta, "--scenario", "bgt60")
check(found.get("samples_sha256") == digest(walk) and found["figures"] == ["doppler-time"], f"SigMF: {found}")
found = inspected(meta)
check(found["figures"] == [] and "values a slot is 128, must be 2000" in found["scenario_problem"], f"another radar: {found}")
stated = ("--rate", rate, "--carrier", carrier)

expected_real = expected
np.save(formats / "walk.npy", walk)
same("bgt60", walk, expected, formats / "walk.npy", *stated)
np.save(formats / "big-endian.npy", walk.astype(">i2"))
same("bgt60", walk, expected, formats / "big-endian.npy", *stated)
np.savez_compressed(formats / "walk.npz", walk=walk, other=np.zeros(3))
same("bgt60", walk, expected, formats / "walk.npz", *stated, "--dataset", "walk")
for name, compressed in (("plain.mat", False), ("compressed.mat", True)):
    scipy.io.savemat(formats / name, {"walk": walk, "rate_hz": rate, "carrier_hz": carrier, "note": "a walk"}, do_compression=compressed)
    same("bgt60", walk, expected, formats / name)
shutil.copy(formats / "walk.npy", formats / "misnamed.wav")
same("bgt60", walk, expected, formats / "misnamed.wav", *stated)

random = np.random.default_rng(1)
antennas, chirps = 3, 2
cube = random.integers(0, 4096, (len(walk), antennas, chirps, 128))
cube[:, 1, 0] = walk.astype(int) + 2048
shape = {
    "rx_antennas": [1, 2, 3], "tx_antennas": [1], "tx_power_level": 31, "if_gain_dB": 33,
    "num_chirps_per_frame": chirps, "num_samples_per_chirp": 128, "chirp_repetition_time_s": 1.25e-4,
    "frame_repetition_time_s": 1 / rate, "sample_rate_Hz": 2000000, "mimo_mode": "off",
}
for name, data, ends in (
    ("counts", cube.astype("<u2"), ("start_frequency_Hz", "end_frequency_Hz")),
    ("shares", (cube / 4095).astype("<f4"), ("lower_frequency_Hz", "upper_frequency_Hz")),
):
    folder = formats / name / "RadarIfxAvian_00"
    folder.mkdir(parents=True)
    np.save(folder / "radar.npy", data)
    config = {"device_config": {"fmcw_single_shape": {**shape, ends[0]: carrier, ends[1]: carrier + 1e9}}}
    (folder / "config.json").write_text(json.dumps(config))
    found = same("bgt60", walk, expected, folder, "--antenna", 2, "--chirp", 1)
    check(found.get("shape") == [len(walk), chirps, antennas, 128], f"{name}: shape {found.get('shape')}")
    check(found.get("carrier_hz") == carrier and abs(found["rate_hz"] - rate) < 1e-6 * rate, f"{name}: {found}")
    same("bgt60", walk, expected, folder.parent, "--antenna", 2, "--chirp", 1)
    same("bgt60", walk, expected, folder / "radar.npy", "--antenna", 2, "--chirp", 1)
    toml = work / f"{name}.toml"
    toml.write_text(found.get("scenario") or "")
    code, _, err, _, _ = call("scenario", "check", toml)
    check(code == 0, f"the scenario that matches: {err}")
# every chirp is slow time where frames leave no pause
found = inspected(folder, "--antenna", 2, "--chirp", "all")
both = (cube[:, 1] - 2048).astype("<i2").reshape(-1, 128)
check(found.get("samples_sha256") == digest(both), "--chirp all: other samples")
check(abs(found.get("rate_hz", 0) - 2 * rate) < 1e-6 * rate, f"--chirp all: {found.get('rate_hz')} Hz")
infineon = folder

# --- the same module's raw data: text with shares of full scale, antenna by antenna; binary with counts, antennas interleaved
HEADER = [
    "Version", "Header_Size", "Num_Tx_Antennas", "Num_Rx_Antennas", "Mask_Tx_Antennas", "Mask_Rx_Antennas", "Are_Rx_Antennas_Interleaved",
    "Modulation_Type_Enum", "Chirp_Shape_Enum", "Lower_RF_Frequency_kHz", "Upper_RF_Frequency_kHz", "Sampling_Frequency_kHz",
    "ADC_Resolution_Bits", "Are_ADC_Samples_Normalized", "Data_Format_Enum", "Chirps_per_Frame", "Samples_per_Chirp", "Samples_per_Frame",
    "Chirp_Time_sec", "Pulse_Repetition_Time_sec", "Frame_Period_sec"]
FLOATS = {"Version", "Lower_RF_Frequency_kHz", "Upper_RF_Frequency_kHz", "Sampling_Frequency_kHz", "Chirp_Time_sec", "Pulse_Repetition_Time_sec",
          "Frame_Period_sec"}


def raw_header(antennas, chirps, samples, bits, carrier, bandwidth, rate, **changed):
    header = dict.fromkeys(HEADER, 0) | {
        "Version": 1.0, "Num_Tx_Antennas": 1, "Num_Rx_Antennas": antennas, "Mask_Tx_Antennas": 1, "Mask_Rx_Antennas": 2**antennas - 1,
        "Modulation_Type_Enum": 1, "Lower_RF_Frequency_kHz": carrier / 1e3, "Upper_RF_Frequency_kHz": (carrier + bandwidth) / 1e3,
        "Sampling_Frequency_kHz": 2000.0, "ADC_Resolution_Bits": bits, "Chirps_per_Frame": chirps, "Samples_per_Chirp": samples,
        "Samples_per_Frame": antennas * chirps * samples, "Pulse_Repetition_Time_sec": 1.25e-4, "Frame_Period_sec": 1 / rate}
    return header | changed


def raw_text(path, header, frames, first=33):
    lines = ["IFRT", "### Header must not be changed.", "## Modulation_Type_Enum_Def = {DOPPLER = 0, FMCW = 1}"]
    lines += [f"# {name} = {header[name]!r}" for name in HEADER if name != "Header_Size"] + [""]
    for number, frame in enumerate(frames, first):
        lines += [f"# Frame_Number = {number}", *map(repr, frame.ravel().tolist())]
    path.write_text("\n".join(lines) + "\n")
    return path


def raw_binary(path, header, frames):
    words = b"".join(np.array(header[name], ">f4" if name in FLOATS else ">i4").tobytes() for name in HEADER)
    data = b"".join(np.array(n, ">i4").tobytes() + frame.astype(">f4").tobytes() for n, frame in enumerate(frames))
    path.write_bytes(b"IFRB" + words + data)
    return path


by_chirp = cube.swapaxes(1, 2)  # [frame, chirp, antenna, sample]
text_file = raw_text(formats / "walk.raw.txt", raw_header(3, 2, 128, 12, carrier, 1e9, rate, Are_ADC_Samples_Normalized=1), by_chirp / 4095)
found = same("bgt60", walk, expected, text_file, "--antenna", 2, "--chirp", 1)
check(found.get("shape") == [len(walk), chirps, antennas, 128] and found.get("carrier_hz") == carrier, f"raw text: {found}")
binary_file = raw_binary(
    formats / "walk.raw.bin", raw_header(3, 2, 128, 12, carrier, 1e9, rate, Are_Rx_Antennas_Interleaved=1), by_chirp.swapaxes(2, 3))
found = same("bgt60", walk, expected, binary_file, "--antenna", 2, "--chirp", 1)
check(found.get("carrier_hz") == carrier and abs(found["rate_hz"] - rate) < 1e-6 * rate, f"raw binary: {found}")
# a module for Doppler alone: I and Q of two channels, first of one, then of the other
counts = random.integers(0, 4096, (60, 2, 2, 128))  # [frame, antenna, I and Q, sample]
header = raw_header(2, 1, 128, 12, 24.05e9, 0.2e9, 1, Modulation_Type_Enum=0, Data_Format_Enum=1, Sampling_Frequency_kHz=2.0, Frame_Period_sec=0.064)
found = inspected(raw_text(formats / "doppler.raw.txt", header, counts), "--antenna", 2)
second = (counts[:, 1] - 2048.0).swapaxes(1, 2).reshape(-1, 2)
check(found.get("samples_sha256") == digest(second), "raw text of a Doppler module: other samples")
check((found.get("rate_hz"), found.get("carrier_hz")) == (2000.0, 24.15e9), f"raw text of a Doppler module: {found}")
check("samples = 1\n" in (found.get("scenario") or ""), f"raw text of a Doppler module: {found}")

# --- a complex converter of 16 bits: TI's DCA1000
meta, walk, described = sigmf_walk("iwr")
rate, carrier = described["global"]["sdp3:slot_rate"], described["captures"][0]["core:frequency"]
expected = logits("iwr", meta)
samples = walk.shape[1]
carrier_iwr = ("--carrier", carrier)
transmitters = 2
# [frame, chirp, antenna, sample, I and Q]; the walk is on the third receive antenna and the second chirp
cube = random.integers(-2000, 2000, (len(walk), transmitters, 4, samples, 2)).astype("<i2")
cube[:, 1, 2] = walk
options = ("--antenna", 3, "--chirp", 2)
start_us = 5
slope = 4e9 / (samples / 5e6) / 1e12
profile = dict(start=carrier / 1e9 - slope * start_us / 1e3, idle=7, adc=start_us, ramp=60, slope=slope)


def commands(receivers=15, swap=0, interleave=1):
    return f"""% a sensor's commands
sensorStop
channelCfg {receivers} 3 0
adcCfg 2 1
adcbufCfg -1 0 {swap} {interleave} 1
profileCfg 0 {profile['start']!r} {profile['idle']} {profile['adc']} {profile['ramp']} 0 0 {profile['slope']!r} 1 {samples} 5000 0 0 30
chirpCfg 0 0 0 0 0 0 0 1
chirpCfg 1 1 0 0 0 0 0 2
frameCfg 0 1 1 0 {1e3 / rate!r} 1 0
sensorStart
"""


def studio(interleave):
    return json.dumps({"mmWaveDevices": [{
        "rfConfig": {
            "rlChanCfg_t": {"rxChannelEn": "0xF", "txChannelEn": "0x3"},
            "rlAdcOutCfg_t": {"fmt": {"b2AdcBits": 2, "b2AdcOutFmt": 1}},
            "rlProfiles": [{"rlProfileCfg_t": {
                "startFreqConst_GHz": profile["start"], "idleTimeConst_usec": 7.0, "adcStartTimeConst_usec": float(start_us),
                "rampEndTime_usec": 60.0, "freqSlopeConst_MHz_usec": slope, "numAdcSamples": samples, "digOutSampleRate": 5000}}],
            "rlChirps": [{"rlChirpCfg_t": {"chirpStartIdx": n, "chirpEndIdx": n, "txEnable": f"0x{n + 1}"}} for n in range(2)],
            "rlFrameCfg_t": {"chirpStartIdx": 0, "chirpEndIdx": 1, "numLoops": 1, "numFrames": 0, "framePeriodicity_msec": 1e3 / rate}},
        "rawDataCaptureConfig": {
            "rlDevDataFmtCfg_t": {"iqSwapSel": 0, "chInterleave": interleave}, "rlDevLaneEnable_t": {"laneEn": "0xF"}}}]})


def two_lanes(cube):
    """Antenna by antenna, two samples at a time: I, I, Q, Q."""
    pairs = cube.reshape(*cube.shape[:3], samples // 2, 2, 2)
    return pairs.swapaxes(-1, -2)


def four_lanes(cube):
    """Sample by sample: I of every antenna, then Q of every antenna."""
    return cube.transpose(0, 1, 3, 4, 2)


def capture(name, data, description, extension):
    file = formats / f"{name}.bin"
    np.ascontiguousarray(data).astype("<i2").tofile(file)
    file.with_suffix(extension).write_text(description)
    return file


dca = capture("two-lanes", two_lanes(cube), commands(), ".cfg")
found = same("iwr", walk, expected, dca, *options)
check(found.get("shape") == [len(walk), transmitters, 4, samples], f"DCA1000: shape {found.get('shape')}")
check(abs(found.get("carrier_hz", 0) - carrier) < 1e3 and abs(found["rate_hz"] - rate) < 1e-6 * rate, f"DCA1000: {found}")
check(found.get("sensor", {}).get("transmitters") == [1, 2], f"DCA1000: {found.get('sensor')}")
swapped = capture("swapped", two_lanes(cube[..., ::-1]), commands(swap=1), ".cfg")
same("iwr", walk, expected, swapped, *options)
some = capture("two-antennas", two_lanes(cube[:, :, [0, 2]]), commands(receivers=5), ".cfg")
same("iwr", walk, expected, some, "--antenna", 2, "--chirp", 2)
four = capture("four-lanes", four_lanes(cube), studio(0), ".mmwave.json")
same("iwr", walk, expected, four, *options)
same("iwr", walk, expected, capture("studio", two_lanes(cube), studio(1), ".mmwave.json"), *options)
off = cube.copy()
off[:, :, [1, 3]] = 0
same("iwr", walk, expected, capture("lanes-off", four_lanes(off), commands(receivers=5, interleave=0), ".cfg"), "--antenna", 2, "--chirp", 2)
# the same in Infineon's raw data: I and Q apart, and alternating
unsigned = cube.astype(int) + 32768
header = raw_header(4, transmitters, samples, 16, carrier, 4e9, rate, Pulse_Repetition_Time_sec=1e-4, Sampling_Frequency_kHz=5000.0)
apart = raw_binary(formats / "apart.raw.bin", header | {"Data_Format_Enum": 1}, unsigned.swapaxes(3, 4))
same("iwr", walk, expected, apart, *options)
some_frames = raw_text(formats / "alternating.raw.txt", header | {"Data_Format_Enum": 2}, unsigned[:200])
check(inspected(some_frames, *options)["samples_sha256"] == digest(walk[:200]), "raw text, alternating: other samples")
scipy.io.savemat(formats / "complex.mat", {"walk": walk})
same("iwr", walk, expected, formats / "complex.mat", "--rate", rate, "--carrier", carrier)

# --- live: the same windows as of the file
model = work / "iwr-model" / "models" / "dsn-800.sdp3"
raw = formats / "live.raw"
walk.tofile(raw)
with open(raw, "rb") as stream:
    code, out, err, _, _ = call("classify", model, "-", "--json", "-q", stdin=stream)
live = [json.loads(line) for line in out.splitlines()]
check(code == 0 and [(w["first_slot"], w["class"], w["confidence"], w["logits"]) for w in live] == expected, f"live: {err}")
overlapping = logits("iwr", dca, *options, "--step", 400)
check(overlapping[::2] == expected and len(overlapping) == 2 * len(expected) - 1, "--step: other windows")
unsure = logits("iwr", dca, *options, "--least-confidence", 1)
below = [w[1] for w in unsure if w[2] < 1]
check(below and set(below) == {"unknown"}, f"--least-confidence 1: {unsure}")

# --- one number a time
tone = np.sin(np.arange(4000) * 0.3) * np.linspace(0.2, 0.9, 4000)
with wave.open(str(formats / "tone.wav"), "wb") as file:
    file.setnchannels(1), file.setsampwidth(2), file.setframerate(1000)
    file.writeframes((tone * 32767).astype("<i2").tobytes())
read = (tone * 32767).astype("<i2") / 32768.0
check(inspected(formats / "tone.wav", "--carrier", 24e9)["samples_sha256"] == digest(read), "WAV: other samples")
carrier = ("--carrier", 24e9)
np.savetxt(formats / "tone.csv", read, fmt="%.17g")
check(inspected(formats / "tone.csv", *carrier, "--rate", 1000)["samples_sha256"] == digest(read), "CSV: other samples")
table = np.column_stack((np.arange(4000) / 1000, read, read[::-1]))
np.savetxt(formats / "timed.csv", table, fmt="%.17g", delimiter=",", header="time_s,i,q", comments="")
found = inspected(formats / "timed.csv", *carrier)
check(found["samples_sha256"] == digest(table[:, 1:]) and abs(found["rate_hz"] - 1000) < 1e-6, f"CSV with times: {found}")
scipy.io.savemat(formats / "tone.mat", {"tone": read + 1j * read[::-1]})
check(inspected(formats / "tone.mat", *carrier, "--rate", 1000)["samples_sha256"] == digest(table[:, 1:]), "MATLAB, complex: other samples")
for picture in ("doppler-time.svg", "doppler-time.png", "range-time.svg"):
    check((work / "out" / picture).stat().st_size > 1000, f"{picture} is empty")


# --- HDF5: MATLAB 7.3, with axes stored the other way round behind 512 bytes, and Acconeer's A121
def matlab_7_3(path, compression=None, **variables):
    with h5py.File(path, "w", userblock_size=512) as file:
        for name, (value, kind) in variables.items():
            dataset = file.create_dataset(name, data=np.ascontiguousarray(np.atleast_2d(value).T), compression=compression)
            dataset.attrs["MATLAB_class"] = np.bytes_(kind)
    with open(path, "r+b") as file:
        file.write(b"MATLAB 7.3 MAT-file, Platform: GLNXA64, HDF5 schema 1.00 .".ljust(124) + b"\0\x02IM")
    return path


def compound(values, part):
    pairs = np.empty(values.shape[:-1], [("real", part), ("imag", part)])
    pairs["real"], pairs["imag"] = values[..., 0], values[..., 1]
    return pairs


note = np.frombuffer("a walk".encode("utf-16-le"), "<u2")
real_walk = np.load(formats / "walk.npy")
for compression in (None, "gzip"):
    mat = matlab_7_3(formats / f"v73-{compression}.mat", compression, walk=(real_walk, "int16"), note=(note, "char"), **{
        "rate_hz": (stated[1], "double"), "carrier_hz": (stated[3], "double")})
    same("bgt60", real_walk, expected_real, mat)
mat = matlab_7_3(formats / "v73-complex.mat", walk=(compound(walk, "<i2"), "int16"))
same("iwr", walk, expected, mat, "--rate", rate, *carrier_iwr)
mat = matlab_7_3(formats / "v73-tone.mat", tone=(compound(table[:, 1:], "<f8"), "double"))
check(inspected(mat, *carrier, "--rate", 1000)["samples_sha256"] == digest(table[:, 1:]), "MATLAB 7.3, complex: other samples")
frames = random.integers(-2000, 2000, (200, 4, 7, 2))
frames[:, :, 4] += random.integers(-4000, 4000, (200, 1, 2))
a121 = formats / "walk.h5"
with h5py.File(a121, "w") as file:
    file["generation"] = "a121"
    session = file.create_group("sessions/session_0")
    session["session_config"] = json.dumps({"groups": [{"1": {"frame_rate": 50.0, "sweeps_per_frame": 4}}], "extended": False})
    session["group_0/entry_0/result/frame"] = compound(frames, "<i2")
found = inspected(a121)
check((found.get("rate_hz"), found.get("carrier_hz"), found.get("shape")) == (50.0, 60.5e9, [200, 4, 7]), f"A121: {found}")
means = frames.sum(axis=1) / 4
cell = np.argmax(means.var(axis=0).sum(axis=-1))
check(found.get("samples_sha256") == digest(means[:, cell]), "A121: other samples")


# --- what cannot be read
def refused(path, *options, words):
    code, out, err, took, megabytes = call("inspect", path, *options, "--json", "--out", work / "out")
    what = f"{path.name} {options}: exit code {code}, {took:.2f} s, {megabytes:.0f} MB: {err.strip()}"
    check(code == 2 and out == "" and took < 1 and megabytes < 100 and path.name in err, what)
    check(all(word in err for word in words), f"{what}; missing {words}")


def changed(path, name, change):
    copy = formats / name
    copy.write_bytes(change(path.read_bytes()))
    return copy


classified = call("classify", model, infineon, "--antenna", 1, "--chirp", 1)
check(classified[0] == 2 and "values a slot is 128, must be 512" in classified[2], f"another radar: {classified[2]}")
code, _, err, _, _ = call("inspect", formats / "tone.wav", *carrier, "--antenna", 1)
check(code == 2 and "--antenna" in err, err)
code, _, err, _, _ = call("classify", work / "bgt60-model" / "models" / "dsn-800.sdp3", infineon, "--antenna", 4)
check(code == 2 and "--antenna is 4, must be 1 to 3" in err, err)
code, _, err, _, _ = call("classify", work / "bgt60-model" / "models" / "dsn-800.sdp3", infineon)
check(code == 2 and "--antenna is not given, must be 1 to 3" in err, err)

refused(changed(dca, "cut.bin", lambda b: b[:-100]), "--config", dca.with_suffix(".cfg"), words=["size (bytes)", "a multiple of"])
lonely = formats / "lonely"
lonely.mkdir()
shutil.copy(dca, lonely / "lonely.bin")
refused(lonely / "lonely.bin", words=["--config"])
(lonely / "lonely.cfg").write_text(commands().replace("profileCfg", "profile"))
code, _, err, _, _ = call("inspect", lonely / "lonely.bin")
check(code == 2 and "lonely.cfg: profileCfg is missing" in err, err)
huge = formats / "huge.bin"
with open(huge, "wb") as file:
    file.truncate(10 << 30)
refused(huge, "--config", dca.with_suffix(".cfg"), words=["10737418240"])
for name in ("huge.npy", "huge.mat", "huge.csv", "huge.wav"):
    shutil.move(huge, formats / name)
    huge = formats / name
    refused(huge, *carrier, words=["10737418240"])
huge.unlink()
refused(changed(formats / "walk.npy", "cut.npy", lambda b: b[:-100]), *stated, words=["NPY"])
refused(changed(formats / "compressed.mat", "cut.mat", lambda b: b[:-100]), words=["MATLAB"])
refused(changed(formats / "plain.mat", "short.mat", lambda b: b[:4000]), words=["MATLAB"])
lost = [line for line in (formats / "doppler.raw.txt").read_text().splitlines() if line != "# Frame_Number = 40"]
(formats / "lost.raw.txt").write_text("\n".join(lost))
refused(formats / "lost.raw.txt", "--antenna", 1, words=["Frame_Number, line", "must be 40: a frame is missing"])
refused(changed(text_file, "cut.raw.txt", lambda b: b[:5000]), "--antenna", 1, "--chirp", 1, words=["number of values", "a multiple of 768"])
refused(changed(binary_file, "cut.raw.bin", lambda b: b[:-101]), words=["size (bytes)", "a whole number of words"])
pause = raw_text(formats / "pause.raw.txt", raw_header(1, 1, 128, 12, 24e9, 0.2e9, 1, Modulation_Type_Enum=0, Sampling_Frequency_kHz=2.0), counts[:2, :1, 0])
refused(pause, words=["Frame_Period_sec is 1, must be 0.064"])
for name, value in (("Chirp_Shape_Enum", 2), ("ADC_Resolution_Bits", 17), ("Samples_per_Chirp", 0)):
    wrong = raw_text(formats / "wrong.raw.txt", raw_header(1, 1, 128, 12, 24e9, 0.2e9, 1, **{name: value}), counts[:2, :1, 0])
    refused(wrong, words=[f"{name} is {value}, must be"])
for name in ("v73-gzip.mat", "walk.h5"):
    refused(changed(formats / name, f"cut-{name}", lambda b: b[: len(b) // 2]), words=["MATLAB 7.3" if "mat" in name else "HDF5"])
refused(changed(formats / "plain.mat", "order.mat", lambda b: b[:126] + b"XX" + b[128:]), words=["endian indicator"])
refused(changed(formats / "tone.csv", "word.csv", lambda b: b.replace(b"\n", b"\nnone\n", 1)), *carrier, "--rate", 1000, words=["line 2"])
refused(changed(formats / "timed.csv", "uneven.csv", lambda b: b.replace(b"\n0.002,", b"\n0.0025,")), *carrier, words=["step 1 of time"])
config = infineon / "config.json"
text = config.read_text()
config.write_text(text.replace('"num_chirps_per_frame": 2', '"num_chirps_per_frame": 4'))
code, _, err, _, _ = call("inspect", infineon)
check(code == 2 and "radar.npy: shape is" in err and "as config.json says" in err, err)
config.write_text(text.replace('"sample_rate_Hz": 2000000', '"sample_rate_Hz": 0'))
code, _, err, _, _ = call("inspect", infineon)
check(code == 2 and "config.json: sample_rate_Hz is 0" in err, err)
config.write_text("{")
code, _, err, _, _ = call("inspect", infineon)
check(code == 2 and "config.json" in err, err)

print(f"{checked} checks, {failed} failed")
sys.exit(1 if failed else 0)
