"""Point targets of `sdp3 targets` in NumPy: reader, slow-time signal and Doppler over time.

point_targets.py FOLDER CLASS [PICTURE.png]     draws Doppler over time

The radar is monostatic. A point of cross section sigma at the distance D echoes with the amplitude
lambda sqrt(sigma) / ((4 pi)^1.5 D^2) and the phase -4 pi D / lambda, between isotropic antennas.
"""
import csv
import json
import pathlib
import struct
import sys
import types
import zlib

import numpy as np

SPEED_OF_LIGHT = 299_792_458.0


def read(folder, name):
    """The targets of a class: arrays over [instant], [part] or [instant, part], vectors with a last axis x, y, z."""
    folder = pathlib.Path(folder)
    about = json.loads((folder / "targets.json").read_text())
    with open(folder / f"targets-{name}.csv", newline="") as file:
        rows = list(csv.DictReader(file))
    count = len(about["parts"])
    if [row["part"] for row in rows] != about["parts"] * about["instants"]:
        raise ValueError(f"targets-{name}.csv does not have the parts and instants of targets.json")

    def column(*names):
        return np.array([[float(row[name]) for name in names] for row in rows]).reshape(-1, count, len(names))

    return types.SimpleNamespace(
        parts=about["parts"],
        radar_m=np.array(about["radar_m"]),
        carrier_hz=about["carrier_hz"],
        centre_hz=about["centre_hz"],
        every_s=about["every_s"],
        time_s=column("time_s")[:, 0, 0],
        position_m=column("x_m", "y_m", "z_m"),
        velocity_m_s=column("vx_m_s", "vy_m_s", "vz_m_s"),
        rcs_dbsm=column("rcs_dbsm")[..., 0],
        phase_deg=column("phase_deg")[0, :, 0],
    )


def distance_m(targets):
    """Distance of every part to the radar in m, [instant, part]."""
    return np.linalg.norm(targets.position_m - targets.radar_m, axis=-1)


def doppler_hz(targets, frequency_hz):
    """Doppler shift of every part in Hz by its velocity, [instant, part]; positive towards the radar."""
    sight = (targets.position_m - targets.radar_m) / distance_m(targets)[..., None]
    return -2 * frequency_hz / SPEED_OF_LIGHT * np.sum(sight * targets.velocity_m_s, axis=-1)


def at(targets, time_s):
    """Positions in m and cross sections in dBsm at other times, [time, part]: cubic by position and velocity, and linear."""
    last = len(targets.time_s) - 2
    k = np.clip(np.floor(np.asarray(time_s) / targets.every_s).astype(int), 0, last)
    u = (time_s / targets.every_s - k)[:, None, None]
    a, b = targets.position_m[k], targets.position_m[k + 1]
    va, vb = targets.velocity_m_s[k] * targets.every_s, targets.velocity_m_s[k + 1] * targets.every_s
    position = a + u**2 * (3 - 2 * u) * (b - a) + u * (1 - u) * ((1 - u) * va - u * vb)
    rcs = targets.rcs_dbsm[k] * (1 - u[..., 0]) + targets.rcs_dbsm[k + 1] * u[..., 0]
    return position, rcs


def echoes(targets, frequency_hz):
    """Amplitude ratio of every part's echo at a frequency, [instant, part], complex."""
    wavelength, distance = SPEED_OF_LIGHT / frequency_hz, distance_m(targets)
    amplitude = wavelength * 10 ** (targets.rcs_dbsm / 20) / ((4 * np.pi) ** 1.5 * distance**2)
    return amplitude * np.exp(1j * (np.radians(targets.phase_deg) - 4 * np.pi * distance / wavelength))


def spectrogram(signal, rate_hz, window=128, hop=8):
    """Frequencies in Hz, ascending, and the power in dB over [frequency, frame] of a slow-time signal."""
    window = min(window, len(signal))
    frames = np.lib.stride_tricks.sliding_window_view(signal, window)[::hop]
    power = np.abs(np.fft.fftshift(np.fft.fft(frames * np.kaiser(window, 4.0)), axes=1)).T ** 2
    frequencies = np.fft.fftshift(np.fft.fftfreq(window, 1 / rate_hz))
    return frequencies, 10 * np.log10(power + 1e-300)


def write_png(file, power_db, range_db=40, scale=4):
    """Draws a spectrogram: the highest frequency at the top, the strongest point white, `range_db` below it black."""
    grey = np.clip(1 + (power_db - power_db.max()) / range_db, 0, 1)[::-1]
    grey = np.kron((255 * grey).astype(np.uint8), np.ones((scale, scale), np.uint8))
    height, width = grey.shape
    lines = b"".join(b"\0" + line.tobytes() for line in grey)

    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    header = struct.pack(">IIBBBBB", width, height, 8, 0, 0, 0, 0)
    parts = [(b"IHDR", header), (b"IDAT", zlib.compress(lines)), (b"IEND", b"")]
    pathlib.Path(file).write_bytes(b"\x89PNG\r\n\x1a\n" + b"".join(chunk(*part) for part in parts))


def main(folder, name, picture="doppler.png"):
    targets = read(folder, name)
    signal = echoes(targets, targets.centre_hz).sum(axis=1)
    frequencies, power_db = spectrogram(signal, 1 / targets.every_s)
    write_png(picture, power_db)
    shift = doppler_hz(targets, targets.centre_hz)
    part = targets.parts[np.abs(shift).max(axis=0).argmax()]
    print(f"{picture}: {frequencies[0]:.0f} to {frequencies[-1]:.0f} Hz, {power_db.shape[1]} frames; "
          f"by their velocities {shift.min():.1f} to {shift.max():.1f} Hz, the fastest part is {part}")


if __name__ == "__main__":
    main(*sys.argv[1:])
