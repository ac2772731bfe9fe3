"""Golden front end: chirp table, clutter removal, window, STFT and logarithm from mpmath, numpy and scipy.

- `chirp`: 32767 cos and sin of pi n^2 / 1000 at 60 digits (mpmath), rounded half away from zero.
- `clutter`: a small random recording of beats; numpy's SVD, components outside first..=last struck out, column sums.
- `stft`: scipy's Kaiser window and ShortTimeFFT (no phase shift, two-sided, 256 bins) of random slow time.
- `log2`: the smallest 24-bit mantissa M with 64 log2(M / 2^23) >= k, k = 0..63, from mpmath at 60 digits.

    pip install numpy==2.4.6 scipy==1.17.1 mpmath==1.4.1
    python front_end.py
"""

import json
from importlib.metadata import version
from pathlib import Path

import mpmath
import numpy as np
from scipy.signal import ShortTimeFFT
from scipy.signal.windows import kaiser

mpmath.mp.dps = 60


def half_away(x):
    return int(mpmath.sign(x) * mpmath.floor(abs(x) + mpmath.mpf(1) / 2))


def chirp():
    phases = [mpmath.pi * n * n / 1000 for n in range(1, 1001)]
    return {"cos": [half_away(32767 * mpmath.cos(p)) for p in phases],
            "sin": [half_away(32767 * mpmath.sin(p)) for p in phases]}


def clutter(rng, slots):
    """Beats with a strong constant part, a weaker moving one and noise, as a room gives."""
    wall = rng.normal(size=(8, 1, 2)) * 3e5
    beats = np.rint(wall + rng.normal(size=(8, slots, 2)) * [[[9e3]]]).astype(int)
    beats += np.rint(np.linspace(-4e4, 4e4, 8)[:, None, None] * rng.normal(size=(1, slots, 2))).astype(int)
    x = beats[:, :, 0] + 1j * beats[:, :, 1]
    u, s, vh = np.linalg.svd(x, full_matrices=False)
    cuts = []
    for first, last in [(1, 8), (2, 8), (3, 8), (2, 7), (3, 5)]:
        keep = np.array([first <= k + 1 <= last for k in range(8)])
        y = np.sum((u * (s * keep)) @ vh, axis=0)
        cuts.append({"first": first, "last": last, "y": [[z.real, z.imag] for z in y]})
    return {"beats": beats.transpose(1, 0, 2).tolist(), "singular_values": s.tolist(), "cuts": cuts}


def stft(rng, length, hop, beta, frames):
    slow_time = rng.integers(-(2**23), 2**23 + 1, size=((frames - 1) * hop + length, 2))
    window = kaiser(length, beta, sym=True)
    engine = ShortTimeFFT(window, hop, fs=1.0, fft_mode="twosided", mfft=256, phase_shift=None)
    # slice p starts at p hop - length / 2: the first one inside the signal is p0
    p0 = (length // 2) // hop
    assert p0 * hop == engine.m_num_mid == length // 2
    spectrum = engine.stft(slow_time[:, 0] + 1j * slow_time[:, 1], p0=p0, p1=p0 + frames)
    return {"window_len": length, "hop": hop, "beta": beta, "window": window.tolist(),
            "slow_time": slow_time.tolist(),
            "frames": [[[round(z.real, 3), round(z.imag, 3)] for z in spectrum[:, k]] for k in range(frames)]}


def log2():
    exact = [mpmath.power(2, 23 + mpmath.mpf(k) / 64) for k in range(64)]
    return [int(mpmath.ceil(x)) for x in exact]


if __name__ == "__main__":
    rng = np.random.default_rng(3)
    golden = {
        "source": f"numpy {np.__version__}, scipy {version('scipy')}, mpmath {mpmath.__version__}",
        "chirp": chirp(),
        "clutter": clutter(rng, 12),
        "stft": [stft(rng, 128, 8, 10.0, 2), stft(rng, 64, 16, 6.0, 2)],
        "log2": log2(),
    }
    path = Path(__file__).with_name("front_end.json")
    path.write_text(json.dumps(golden, separators=(",", ":")) + "\n")
    print(golden["source"], path.stat().st_size, golden["clutter"]["singular_values"])
