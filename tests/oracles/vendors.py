"""Reads the recordings that vendors and users of their modules publish, and compares what sdp3 makes of them with known facts.

Usage: vendors.py SDP3 FOLDER. Nothing of these files is in this repository. Each is downloaded from a fixed commit into FOLDER, and its
SHA-256 is compared before it is decoded. After a download without an answer there are no others: what is missing counts as not run.

EXAMPLES=DIRECTORY names a directory of files that were downloaded before, each named by its SHA-256. They are used without a network, and
new downloads are kept there.

The shapes and the SHA-256 of the samples are those of h5py 3.16, SciPy 1.17 and NumPy 2.4, not of sdp3. Samples are of the first antenna
and the first chirp; of an A121 session, of the cell of largest variance of the mean sweep.
"""

import hashlib
import http.client
import json
import os
import pathlib
import subprocess
import sys
import threading
import urllib.error
import urllib.parse
import urllib.request

program, work = sys.argv[1], pathlib.Path(sys.argv[2]) / "vendors"
kept = os.environ.get("EXAMPLES")
# Seconds for the first download, which shows whether there is a network, and for every other one.
FIRST, OTHER = 6, 60

ACCONEER = ("acconeer/acconeer-python-exploration", "e29f30d521a185ecc3220c5e9455c4361dd11015", "tests/processing/")
A121 = "a121/data_files/recorded_data/"
BGT60 = ("zharfanw/bgt60tr13c_processing", "28ee0cca1085f8387b075a71e0d4285d43dfd33c",
         ".dataset/BGT60TR13C_record_napaszhar_220260106-151615/RadarIfxAvian_00/")
BGT60_MAT = ("zharfanw/convert_radar_bgt60", "ae86903dc99b7e06b1774706c02bdc29b2940698", "")
BGT60_BEAM = ("ssalehi152431/Beamforming-with-Infineon-BGT60TR13C", "c6235ef6b555acf583466b747135a076725a50cb",
              "Beamforming/beamforming_data/2_reflectors20251027-150925/RadarIfxAvian_00/")
# Infineon's own example of its 24 GHz tools, in the history of a project that used them.
S2GLP = ("kmkim036/Radar-STFT-DeepLearning", "4099f5535625dc6e05783fca61a503f922fb867b",
         "src/reference/IFX/S2GLP/Examples/ParseRawDataFile/")
IWR6843 = ("code-rookie-wr/mmWave-radar-vital-sign", "b17e2d340f34cb662b734f58f9f575162392a4a6", "vital_sign/")
# TI's test vectors of its tracker, in a project that wraps it.
GTRACK = ("gaoweifan/pyRadar", "849ff652301dd15e5f33fb048c455b386b329203", "gtrack/test/vectors/usecases/people_counting/")
SIGMF = ("sigmf/SigMF", "209b18697d96c193cf2102b4c59dcb86e644d639", "logo/")

# The project's MATLAB scripts state 100 samples of 4 antennas at 4 MHz, two lanes, 60.36 GHz, 60 MHz/us, 50 us, frames of 50 ms. Its file
# has two chirps a frame then. The time between chirps and the transmit antennas are not stated; nothing below depends on them.
IWR6843_CFG = """channelCfg 15 1 0
adcCfg 2 1
adcbufCfg -1 0 0 1 1
profileCfg 0 60.36 7 0 50 0 0 60 1 100 4000 0 0 30
chirpCfg 0 1 0 0 0 0 0 1
frameCfg 0 1 1 0 50 1 0
"""


def decoded(about, project, files, options=(), **facts):
    return {"about": about, "project": project, "files": files, "options": options, "facts": facts}


def refused(about, project, files, *words, options=()):
    return {"about": about, "project": project, "files": files, "options": options, "words": words}


# A file is its name, size and SHA-256. The first one is inspected, or the folder where the options say so.
RECORDINGS = [
    # the smallest file is the first, since it shows whether there is a network
    decoded("Infineon BGT60TR13C, radar SDK", BGT60, [
        ("config.json", 736, "0e105f0d11342bf578732e1fd9993594f19ed7b560d8c0d0257000b131d414b2"),
        ("radar.npy", 787456, "c7f8b50d1cd9137987396da097c81b5d6ea76ad7de262af41ee46bc0374a879b")],
        format="Infineon radar SDK", shape=[256, 8, 3, 64], rate_hz=12.941826, carrier_hz=58e9,
        samples_sha256="a5868b2f0fc040e091fda8f912ce8ade2a2b8256663eb0172f845a17c3ef2f75"),
    decoded("Infineon BGT60TR13C, radar SDK, two reflectors", BGT60_BEAM, [
        ("config.json", 763, "4fab40d66bf658e8722933bfd37034155bf705101b5d1e667c58e172ed5a3295"),
        ("radar.npy", 3146752, "72c936c64b295511be17119ac753ec0bd1b2e593ea18ba02e53573e83988657a")],
        format="Infineon radar SDK", shape=[128, 64, 3, 64], rate_hz=12.941826, carrier_hz=58e9,
        samples_sha256="671208eb9cac259d79828b636f94e4d235c4551bbea2df1ac8ce0ebaebf60c06"),
    refused("Infineon S2GLP, raw data as text", S2GLP, [
        ("data_S2GLP.raw.txt", 1033346, "d91a3bc4f82261a8d56b8f0f873d5d85cbe892bf3ea58ee819684ffcc649e9c6")],
        "Frame_Period_sec is 0.15, must be 0.064", "frames with a pause"),
    refused("Infineon S2GLP, raw data in binary", S2GLP, [
        ("data_S2GLP.raw.bin", 357136, "2f39f521985706469fe21002e7bb194641ab257dafda2b5988091204129e7333")],
        "Frame_Period_sec is 0.14999999, must be 0.064", "frames with a pause"),
    decoded("MATLAB 5, compressed, of a BGT60TR13C", BGT60_MAT, [
        ("datanya.mat", 50190, "ac03d38f9ba55c17c17c66918d7b66c956f36f0d703b1a806741770099593e3e")],
        ("--dataset", "breathe", "--rate", "20", "--carrier", "60e9"), format="MATLAB 5", shape=[2511],
        samples_sha256="248bca9be8c6babe46557c70f37121043cfa7e34b58b2d166afec8a49a143c41"),
    decoded("TI IWR6843, DCA1000", IWR6843, [
        ("demo.bin", 1280000, "8d4d1efe3c04cc8bd33dfa40c2272c77a7c5e87ec8dace489b37a072cf38fc9a")],
        ("--config", "demo.cfg"), format="TI DCA1000", shape=[400, 2, 4, 100], rate_hz=20, carrier_hz=60.36e9,
        samples_sha256="c5775c454bcc7b5eebc8d09fa67d2870c094a16c78bd214886618c1c5dde6600"),
    refused("TI tracker's test vectors, MATLAB structures", GTRACK, [
        ("fHistScene4_0001.mat", 475954, "2ba0308d46406afc6a66f39cbc4795d9769e649813f0d248239257f2d75ba8fb")],
        "no array of numbers", options=("--rate", "20", "--carrier", "60e9")),
    decoded("Acconeer A121, breathing", ACCONEER, [
        (A121 + "breathing-sitting-no-presence.h5", 743382, "39a0cdd41b7250518ff352bd5c096e9ecbd63454bea7dd16905b1a6ef9342762")],
        format="Acconeer A121 (HDF5)", shape=[667, 16, 21], rate_hz=20, carrier_hz=60.5e9,
        samples_sha256="f52e2ade83f649cbe70353fc835eb477bd32ad20224596fb008f7f9ebb679f53"),
    decoded("Acconeer A121, hand motion", ACCONEER, [
        (A121 + "hand-motion-no-presence.h5", 101985, "250b7a51475e22ece4720f86554041c0e9b0cfe954135fe88cbe36e5da6a239e")],
        format="Acconeer A121 (HDF5)", shape=[130, 64, 3], rate_hz=10, carrier_hz=60.5e9,
        samples_sha256="b2a6a097317d81c3e7e0d7c160e744fb2fcb902270c185de212a1d37870eeb29"),
    decoded("Acconeer A121, surface velocity, rate by the ticks of 1 ms", ACCONEER, [
        (A121 + "surface_velocity_1_dist.h5", 47788, "137f91bb0a477d878139d223eaf7c464e272cc6bcf7de0345b191ae96dc1542f")],
        format="Acconeer A121 (HDF5)", shape=[27, 128, 1], rate_hz=23.402340, carrier_hz=60.5e9,
        samples_sha256="4cec2430fa0a54028621665ef33dbd307662f4a5e7b5cffafe42097359a101b9"),
    decoded("Acconeer A121, touchless button, rate by the ticks of 1 us", ACCONEER, [
        (A121 + "touchless_button_default.h5", 48827, "69285210d87318bb10cc2f5ff42498ec4e713756b6a26a38a456173512e97546")],
        format="Acconeer A121 (HDF5)", shape=[89, 16, 3], rate_hz=19.997, carrier_hz=60.5e9,
        samples_sha256="926c060a93926a142ce1b326c69de9b0b98416f6a604ad3494d75543feeb7326"),
    decoded("Acconeer A121, an older file, rate by the ticks", ACCONEER, [
        (A121 + "input.h5", 129792, "6b91d8f8b1723c41609ac42ee27e548889422de8a41d828c983573c68b4f8950")],
        format="Acconeer A121 (HDF5)", shape=[10, 1, 160], rate_hz=363.607, carrier_hz=60.5e9,
        samples_sha256="bff1b609c9b44c5d0631b4b802a01c984cdabbe0476d1497c9861cd6b8293762"),
    decoded("Acconeer A121, an older file", ACCONEER, [
        (A121 + "fr10Hz-spf4.h5", 375552, "8bcb8efeb4fa89083f87ee6cb0c528d7a948457957f6cbd7611184a9071b3f4f")],
        format="Acconeer A121 (HDF5)", shape=[10, 4, 160], rate_hz=10, carrier_hz=60.5e9,
        samples_sha256="f13dd9aead6ddff6aa63e5bcdd72c4da3fae7762131578cc816530bbd84c63da"),
    refused("Acconeer A121, 0.7 frames a second", ACCONEER, [
        (A121 + "presence-low_power.h5", 35768, "4091919b7a77178ef90c83918358866c6c7a54c882382c07d4f7d97cca4959f1")],
        "rate (Hz) is 0.7, must be 10 to 400000 Hz"),
    refused("Acconeer A111, IQ", ACCONEER, [
        ("a111/sleep_breathing/input.h5", 436781, "782afb04812e9c2f271a218cecb75dbf881859dba50371e4cd3c03bc7460c253")],
        "a session of Acconeer's A111", "--dataset data"),
    decoded("Acconeer A111, IQ, stated by the user", ACCONEER, [
        ("a111/sleep_breathing/input.h5", 436781, "782afb04812e9c2f271a218cecb75dbf881859dba50371e4cd3c03bc7460c253")],
        ("--dataset", "data", "--rate", "10", "--carrier", "60.5e9"), format="HDF5", shape=[331, 1, 827],
        samples_sha256="07a39ae6f79c98150387ab3771fc3ba250ee052526c4ccd93c7552951bc7f4bf"),
    refused("Acconeer A111, amplitudes", ACCONEER, [
        ("a111/presence_detection_sparse/input.h5", 199587, "a1f0ed989da483aeb56c2f5d93c7d78357d480976848412debd4df5b7206069b")],
        "shape is [100, 1, 64, 17]", options=("--dataset", "data", "--rate", "35", "--carrier", "60.5e9")),
    refused("SigMF, the project's logo, two channels", SIGMF, [
        ("sigmf_logo.sigmf-meta", 1409, "e33dea79466bb69386ecc121c9a755381c17f83516ab5003557b9a4eb5ac64e8")],
        "core:num_channels is 2, must be 1", options=("--carrier", "24e9")),
]


class NotRun(Exception):
    """The file cannot be had here."""


class Differs(Exception):
    """It is not what it must be."""


offline = None
timeout = FIRST


def download(url, size):
    """The bytes at an address, no more than one above size. A thread, since looking up a name knows no time limit."""
    global offline, timeout
    if offline:
        raise NotRun(offline)
    found = []

    def fetch():
        try:
            with urllib.request.urlopen(url, timeout=timeout) as answer:
                found.append(answer.read(size + 1))
        except (OSError, http.client.HTTPException) as error:
            found.append(error)

    thread = threading.Thread(target=fetch, daemon=True)
    thread.start()
    thread.join(timeout)
    timeout = OTHER
    result = found[0] if found else TimeoutError("no answer in time")
    if isinstance(result, bytes):
        return result
    if not isinstance(result, urllib.error.HTTPError):
        offline = str(result)
    raise NotRun(str(result))


def file_of(project, file, folder):
    """The file in the folder, from EXAMPLES or its address, if it has its size and SHA-256."""
    (name, commit, under), (path, size, sha256) = project, file
    store = pathlib.Path(kept, sha256) if kept else None
    stored = bool(store and store.is_file())
    url = f"https://raw.githubusercontent.com/{name}/{commit}/{urllib.parse.quote(under + path)}"
    data = store.read_bytes() if stored else download(url, size)
    if len(data) != size or hashlib.sha256(data).hexdigest() != sha256:
        raise Differs(f"{store if stored else url} has another size or SHA-256")
    if store and not stored:
        store.parent.mkdir(parents=True, exist_ok=True)
        store.write_bytes(data)
    target = folder / path.rsplit("/", 1)[-1]
    target.write_bytes(data)
    return target


def compared(case, folder):
    """What to say of a recording that is decoded or refused as it must be."""
    first, *_ = [file_of(case["project"], file, folder) for file in case["files"]]
    (folder / "demo.cfg").write_text(IWR6843_CFG)
    options = [str(folder / option) if option == "demo.cfg" else option for option in case["options"]]
    command = [program, "inspect", first, *options, "--json", "-q", "--out", folder / "out"]
    done = subprocess.run(command, stdin=subprocess.DEVNULL, capture_output=True, text=True)
    if "words" in case:
        if done.returncode != 2 or done.stdout or not all(word in done.stderr for word in case["words"]):
            raise Differs(f"exit code {done.returncode}, {done.stderr.strip()!r} must be 2 and say {case['words']}")
        return "refused: " + done.stderr.strip().split(": ", 2)[-1][:90]
    if done.returncode != 0:
        raise Differs(done.stderr.strip())
    found = json.loads(done.stdout)
    for name, known in case["facts"].items():
        same = abs(found[name] - known) <= 1e-4 * known if isinstance(known, (int, float)) else found[name] == known
        if not same:
            raise Differs(f"{name} is {found[name]}, must be {known}")
    shape = " x ".join(map(str, found["shape"]))
    return f"decoded: {found['format']}, {shape}, {found['rate_hz']:.6g} Hz, {found['carrier_hz'] / 1e9:g} GHz"


counts = {"decoded": 0, "refused": 0, "not run": 0, "FAILED": 0}
for number, case in enumerate(RECORDINGS):
    folder = work / str(number)
    folder.mkdir(parents=True)
    try:
        said = compared(case, folder)
    except NotRun as reason:
        said = f"not run: {reason}"
    except Differs as reason:
        said = f"FAILED: {reason}"
    counts[said.split(":")[0]] += 1
    print(f"{case['about']} ({case['project'][0]}): {said}", flush=True)
failed = f", {counts['FAILED']} FAILED" if counts["FAILED"] else ""
print(f"{counts['decoded']} decoded, {counts['refused']} refused as they must be, {counts['not run']} not run{failed}")
sys.exit(1 if counts["FAILED"] else 0)
