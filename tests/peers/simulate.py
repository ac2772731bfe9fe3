"""The data set of `sdp3 simulate` as plain vectorised numpy: what its speed is measured against.

Five motions in the room of the scenario `as-printed`, with its radar and statistics: `beat` int32 `[recording, slot, 8, 2]`,
`image` int8 `[recording, 64, 110]` and `label` uint8 in `dataset.npz`, which sdp3 also compresses. A block of fast time
is its centre's value plus its share of the thermal and the rounding noise: a short cut that sdp3 does not take. With
`--raw` all 1000 samples of every slot are made with their noise, rounded to 16 bits and dechirped, as sdp3 does; `--keep`
also keeps them in `raw.npy`, int16 `[recording, slot, 1000, 2]`.

    pip install numpy==2.4.6 scipy==1.17.1
    python simulate.py --per-class 20 --out out
"""

import os

os.environ.update(dict.fromkeys(["OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"], "1"))

import argparse
import time
from pathlib import Path

import numpy as np
from scipy.interpolate import BarycentricInterpolator, PchipInterpolator
from scipy.signal import lfilter

LIGHT = 299_792_458.0
RADAR = np.array([1.5, 1.0, 1.0])
START = np.array([2.7, 4.2])
CARRIER, GAIN, NOISE_FIGURE, HEADROOM = 3.5e9, 10 ** 2.5, 10.0, 10 ** 1.2
WAVELENGTH = LIGHT / CARRIER
SLOTS, INTERVAL, RHO = 1000, 1e-3, 0.997
BLOCKS, BLOCK, RATE, SLOPE = 8, 125, 10e6, 1e11
CHILD, ADULT = (0.9, 1.2), (1.6, 1.9)
# speed over height in 1/s
CLASSES = [("standing", None, 0.0), ("child-walking", CHILD, 0.5), ("child-pacing", CHILD, 0.25),
           ("adult-walking", ADULT, 0.5), ("adult-pacing", ADULT, 0.25)]

# path length in m and reflections of the 17 paths by the image method
ROOM = [(4.0, 1), (3.0, 1), (3.0, 1), (2.0, 1), (7.0, 1), (5.0, 2), (5.0, 2), (20**0.5, 2), (65**0.5, 2), (13**0.5, 2),
        (58**0.5, 2), (13**0.5, 2), (58**0.5, 2), (6.0, 2), (6.0, 2), (9.0, 2), (9.0, 2)]
LOSS_DB = {1: -10.0, 2: -16.0}
ROOM_POWER = GAIN**2 * sum((WAVELENGTH / (4 * np.pi * d))**2 * 10 ** (LOSS_DB[k] / 10) for d, k in ROOM)
LSB = np.sqrt(ROOM_POWER * HEADROOM) / 32767
NOISE_POWER = 1.380649e-23 * 290 * RATE * 10 ** (NOISE_FIGURE / 10)

# TGn model B
CLUSTERS = np.full((2, 9), -np.inf)
CLUSTERS[0, :5] = [0.0, -5.4, -10.8, -16.2, -21.7]
CLUSTERS[1, 2:] = [-3.2, -6.3, -9.4, -12.5, -15.6, -18.7, -21.8]
TAP_POWER = np.sum(10 ** (CLUSTERS / 10), axis=0)
TAP_POWER /= TAP_POWER.sum()
TAP_DELAY = 2.0 / LIGHT + 10e-9 * np.arange(9)

# fast time in s: the blocks' centres, all samples, and as many of them as carry the smooth beat
CENTRES = (np.arange(BLOCKS) * BLOCK + (BLOCK + 1) / 2) / RATE
SAMPLES = np.arange(1, BLOCKS * BLOCK + 1) / RATE
NODES = np.linspace(SAMPLES[0], SAMPLES[-1], 16)
CHIRP = np.exp(1j * np.pi * SLOPE * SAMPLES**2)
SPREAD = BarycentricInterpolator(NODES, np.eye(NODES.size))(SAMPLES).T
# slots of which the samples are made together: they stay in the cache
TOGETHER = 50
WINDOW = np.kaiser(128, 10.0)


def periodic(points, phase):
    t, y = np.array(points).T
    return PchipInterpolator(np.concatenate([t - 1, t, t + 1]), np.tile(y, 3))(phase)


def swing(angle, length):
    """A hanging limb, forward and up."""
    return np.stack([length * np.sin(angle), -length * np.cos(angle)])


def joints(rv, height, t):
    """The Boulic-Thalmann walk `[17, 3, slot]` with the pelvis' translation."""
    p, q = (rv - 0.5) / 0.8, (rv - 1.3) / 1.7
    cycle = 1.346 / np.sqrt(rv)
    ds = (0.752 * cycle - 0.143) / cycle
    thorax = [(0.1, 4 * rv / 3), (0.4, -4.5 * rv / 3), (0.6, -4 * rv / 3), (0.9, 4.5 * rv / 3)]
    if rv < 0.5:
        hip = [(0.5, -30 * rv), (0.9, 50 * rv)]
        knee = [(0.17, 3), (0.4, 3), (0.75, 140 * rv), (1, 3)]
        ankle = [(0, -3), (0.08, -30 * rv - 3), (0.5, 22 * rv - 3), (ds, -34 * rv - 3), (0.85, -3)]
        elbow = [(0.05, 6 * rv + 3), (0.5, 34 * rv + 3), (0.9, 10 * rv + 3)]
    elif rv < 1.3:
        hip = [(0.5, -15), (0.9, 25)]
        knee = [(0.17, 3), (0.4, 3), (0.75, 70), (1, 3)]
        ankle = [(0, -3), (0.08, -18), (0.5, 8), (ds, -20), (0.85, -3)]
        elbow = [(0.05, 6 + 8 * p), (0.5 + 0.01 * p, 20 + 24 * p), (0.9, 8 + 9 * p)]
    else:
        hip = [(-0.1 + 0.2 * q, 25 + 5 * q), (0.5, -15), (0.9, 25 + 6 * q)][q <= 0:]
        knee = [(0.17 - 0.05 * q, 3 + 22 * q), (0.4, 3), (0.75 - 0.05 * q, 70 - 5 * q), (1 - 0.03 * q, 3 + 3 * q)]
        ankle = [(0, -3 + 5 * q), (0.08, -18 + 4 * q), (0.5 - 0.1 * q, 8 - 3 * q), (ds, -20 - 8 * q),
                 (0.85, -3 + 5 * q)]
        elbow = [(0.05, 14 - 6 * q), (0.51 + 0.04 * q, 44 + 26 * q), (0.9 - 0.1 * q, 17 - 6 * q)]

    t = t % 1
    # [side, slot]: the left side half a cycle later
    both = np.stack([(t + 0.5) % 1, t])
    hip, knee, ankle, elbow = (np.radians(periodic(points, both)) for points in (hip, knee, ankle, elbow))
    shoulder = np.radians(3 - 9.88 * rv * (0.5 + np.cos(2 * np.pi * both)))
    sign = np.array([[1.0], [-1.0]])

    # limbs in their vertical plane, [joint, side, slot] forward and up
    arm = np.zeros((2, 3, 2, t.size))
    arm[1] = 0.288 * height
    arm[:, 1] = arm[:, 0] + swing(shoulder, 0.188 * height)
    arm[:, 2] = arm[:, 1] + swing(shoulder + elbow, 0.152 * height)
    leg = np.zeros((2, 4, 2, t.size))
    leg[:, 1] = swing(hip, 0.245 * height)
    leg[:, 2] = leg[:, 1] + swing(hip - knee, 0.246 * height)
    leg[:, 3] = leg[:, 2] + swing(hip - knee + ankle + np.pi / 2, 0.143 * height)

    slow = 4 * (rv - rv**2) if rv < 0.5 else 1.0
    bend = np.radians(2 * slow * (np.sin(2 * np.pi * (2 * t - 0.1)) - 1))
    twist = np.radians(periodic(thorax, t))
    yaw = np.radians(-4 * rv * np.cos(2 * np.pi * t))
    a, c = 1.66 * rv, lambda x: np.cos(2 * np.pi * x)
    roll = np.radians(np.select(
        [t < 0.15, t < 0.5, t < 0.65],
        [-a + a * c(10 * t / 3), -a - a * c(10 * (t - 0.15) / 7), a - a * c(10 * (t - 0.5) / 3)],
        a + a * c(10 * (t - 0.65) / 7)))

    # [joint, axis, slot]
    upper = np.empty((9, 3, t.size))
    upper[:3, :2] = 0
    upper[:3, 2] = np.array([[0.0], [0.288], [0.418]]) * height
    upper[3:, 0], upper[3:, 1], upper[3:, 2] = (
        arm[0].reshape(6, -1), np.tile(0.1295 * height * sign, (3, 1)), arm[1].reshape(6, -1))
    x, y, z = upper[:, 0], upper[:, 1], upper[:, 2]
    x, z = np.cos(bend) * x - np.sin(bend) * z, np.sin(bend) * x + np.cos(bend) * z
    top = np.stack([np.cos(twist) * x + np.sin(twist) * y, np.cos(twist) * y - np.sin(twist) * x, z], axis=1)
    x, y, z = leg[0].reshape(8, -1), np.tile(0.0955 * height * sign, (4, 1)), leg[1].reshape(8, -1)
    y, z = np.cos(roll) * y - np.sin(roll) * z, np.sin(roll) * y + np.cos(roll) * z
    bottom = np.stack([np.cos(yaw) * x + np.sin(yaw) * y, np.cos(yaw) * y - np.sin(yaw) * x, z], axis=1)

    side = -1.0 if rv >= 0.5 else 1.0
    amount = rv - rv**2 if rv < 0.5 else 0.25
    shift = 0.491 * height * np.stack([
        side * 0.084 * amount * np.sin(2 * np.pi * (2 * t + 2 * (0.625 - ds))),
        side * 0.128 * amount * np.sin(2 * np.pi * (t - 0.1)),
        0.015 * rv * (np.sin(2 * np.pi * (2 * t - 0.35)) - 1)])
    return np.concatenate([top, bottom]), shift


def person(rng, label):
    """Joints in the room `[17, 3, slot]` and the height."""
    _, range_m, pace = CLASSES[label]
    if range_m is None:
        range_m = (CHILD, ADULT)[rng.integers(2)]
    height = rng.uniform(*range_m)
    speed = pace * height * (1 + 0.05 * np.clip(rng.normal(), -3, 3))
    heading = np.arctan2(*(RADAR[:2] - START)[::-1]) + np.radians(rng.uniform(-15, 15))
    t = INTERVAL * np.arange(SLOTS)
    if speed > 0:
        rv = speed / (0.491 * height)
        body, shift = joints(rv, height, rng.uniform() + t * np.sqrt(rv) / 1.346)
        shift[0] += speed * t
    else:
        body, _ = joints(1e-3, height, np.full(SLOTS, 0.25))
        wave = lambda low, high: np.sin(2 * np.pi * (rng.uniform(low, high) * t + rng.uniform()))
        body[[1, 3, 4], 0] += 0.0025 * wave(0.2, 0.35)
        shift = np.stack([0.003 * wave(0.15, 0.4), 0.003 * wave(0.4, 0.9), np.zeros(SLOTS)])
    x, y, z = (body + shift).transpose(1, 0, 2)
    c, s = np.cos(heading), np.sin(heading)
    return np.stack([START[0] + c * x - s * y, START[1] + s * x + c * y, 0.53 * height + z], axis=1), height


# per primitive: ends of its axis, then weight of the first one in its centre, girth at 1.75 m, length over height
PARTS = [(2, 1, 1.0, 0.10, 0.130), (1, 0, 0.5, 0.15, 0.288)]
for part in [(3, None, 1.0, 0.06, 0.1295), (3, 5, 0.5, 0.06, 0.188), (7, 5, 1.0, 0.05, 0.152),
             (9, 0, 1.0, 0.07, 0.0955), (9, 11, 0.5, 0.07, 0.245), (11, 13, 0.5, 0.06, 0.246),
             (15, 13, 1.0, 0.05, 0.143)]:
    for right in (0, 1):
        other = 1 if part[1] is None else part[1] and part[1] + right
        PARTS.append((part[0] + right, other, *part[2:]))
FIRST, SECOND = (np.array([part[k] for part in PARTS]) for k in (0, 1))
WEIGHT, GIRTH, LENGTH = (np.array([part[k] for part in PARTS])[:, None] for k in (2, 3, 4))


def echoes(rng, body, height, times):
    """Beat of the sixteen primitives `[time, slot]` in sqrt W; the times are equidistant."""
    first, second = body[FIRST], body[SECOND]
    sight = RADAR[:, None] - (WEIGHT[..., None] * first + (1 - WEIGHT[..., None]) * second)
    axis = first - second
    distance2 = np.sum(sight**2, axis=1)
    cos2 = np.sum(sight * axis, axis=1)**2 / (distance2 * np.sum(axis**2, axis=1))
    a2, c2 = (GIRTH * height / 1.75)**2, (LENGTH * height / 2)**2
    root_section = np.sqrt(np.pi * c2) * a2 / (a2 * (1 - cos2) + c2 * cos2)
    distance = np.sqrt(distance2)
    delay = 2 * distance / LIGHT
    amplitude = GAIN * WAVELENGTH / (4 * np.pi)**1.5 * root_section / distance2
    phase = 2 * np.pi * (rng.uniform(size=(16, 1)) - CARRIER * delay + SLOPE * delay * (delay / 2 - times[0]))
    tone = amplitude * np.exp(1j * phase)
    step = np.exp(-2j * np.pi * SLOPE * (times[1] - times[0]) * delay)
    beat = np.empty((times.size, SLOTS), dtype=complex)
    for row in beat:
        row[:] = tone.sum(axis=0)
        tone *= step
    return beat


def gaussian(rng, *shape):
    """Complex, of unit power."""
    return rng.normal(scale=0.5**0.5, size=(*shape, 2)).view(complex)[..., 0]


def room(rng, times):
    """Beat of the room with memory, `[time, slot]`."""
    taps = np.sqrt(ROOM_POWER * TAP_POWER) * np.exp(
        1j * np.pi * SLOPE * TAP_DELAY * (TAP_DELAY - 2 * times[:, None]))
    draws = gaussian(rng, 9, SLOTS)
    state, _ = lfilter([1 - RHO], [1, -RHO], draws, zi=RHO * draws[:, :1])
    return taps @ state


def spectrogram(beat):
    """Intensities `[64, frame]`, -128 is black."""
    u, s, vh = np.linalg.svd(beat, full_matrices=False)
    slow_time = (u.sum(axis=0) * s)[1:] @ vh[1:]
    frames = np.lib.stride_tricks.sliding_window_view(slow_time, 128)[::8] * WINDOW
    spectrum = np.fft.fft(frames, 256)
    rows = np.concatenate([spectrum[:, -32:], spectrum[:, :32]], axis=1).T
    power = rows.real**2 + rows.imag**2
    level = 10 * np.log10(np.maximum(power / power.max(), 1e-30))
    return np.rint(255 * np.clip(1 + level / 50, 0, 1) - 128).astype(np.int8)


def blocks(rng, channel):
    """Sums over blocks of fast time in LSB `[8, slot]`, with the noise of samples and of their rounding."""
    noise = np.sqrt(NOISE_POWER / LSB**2 + 1 / 6)
    return channel(CENTRES) * (BLOCK / LSB) + noise * BLOCK**0.5 * gaussian(rng, BLOCKS, SLOTS), None


def raw_blocks(rng, channel):
    """The same from 16-bit samples, and the samples, int16 `[slot, sample, 2]`."""
    nodes = channel(NODES).T / LSB
    noise = np.sqrt(NOISE_POWER / 2) / LSB
    raw = np.empty((SLOTS, SAMPLES.size, 2), dtype=np.int16)
    sums = np.empty((BLOCKS, SLOTS), dtype=complex)
    received = np.empty((TOGETHER, SAMPLES.size), dtype=complex)
    values = received.view(float)
    for slots in (slice(first, first + TOGETHER) for first in range(0, SLOTS, TOGETHER)):
        received.real = nodes.real[slots] @ SPREAD
        received.imag = nodes.imag[slots] @ SPREAD
        received *= CHIRP
        values += noise * rng.standard_normal(values.shape)
        np.clip(np.rint(values, out=values), -32768, 32767, out=values)
        raw[slots] = values.reshape(raw[slots].shape)
        received *= CHIRP.conj()
        sums[:, slots] = received.reshape(TOGETHER, BLOCKS, BLOCK).sum(axis=2).T
    return sums, raw


def recording(rng, label, converter):
    body, height = person(rng, label)
    sums, raw = converter(rng, lambda times: echoes(rng, body, height, times) + room(rng, times))
    rounded = np.rint(8 * sums)
    beat = np.stack([rounded.T.real, rounded.T.imag], axis=-1).astype(np.int32)
    return spectrogram(rounded), beat, raw


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--per-class", type=int, default=20, help="recordings of each class")
    parser.add_argument("--out", type=Path, default=Path("out"), help="folder for dataset.npz")
    parser.add_argument("--seed", type=int, default=1, help="seed of everything random")
    parser.add_argument("--raw", action="store_true", help="make, round and dechirp every sample")
    parser.add_argument("--keep", action="store_true", help="with --raw: keep every sample")
    arguments = parser.parse_args()
    converter = raw_blocks if arguments.raw else blocks
    started = time.perf_counter()
    count = len(CLASSES) * arguments.per_class
    image = np.empty((count, 64, 110), dtype=np.int8)
    beat = np.empty((count, SLOTS, BLOCKS, 2), dtype=np.int32)
    label = (np.arange(count) % len(CLASSES)).astype(np.uint8)
    arguments.out.mkdir(parents=True, exist_ok=True)
    with open(arguments.out / "raw.npy" if arguments.keep else os.devnull, "wb") as file:
        shape = (count, SLOTS, SAMPLES.size, 2)
        np.lib.format.write_array_header_1_0(file, {"descr": "<i2", "fortran_order": False, "shape": shape})
        for index in range(count):
            rng = np.random.default_rng([arguments.seed, index])
            image[index], beat[index], raw = recording(rng, label[index], converter)
            if arguments.keep:
                raw.tofile(file)
    np.savez(arguments.out / "dataset.npz", image=image, beat=beat, label=label)
    print(f"{(time.perf_counter() - started) / count:.6f} s per recording")


if __name__ == "__main__":
    main()
