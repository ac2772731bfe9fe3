"""Point targets of `sdp3 targets` as the ideal point targets of RadarSimPy: location, speed, rcs and phase.

radarsimpy_targets.py FOLDER CLASS      writes radarsimpy-CLASS.npy: slow time of a Doppler radar, one pulse for every instant

RadarSimPy's baseband has the conjugate phase: +4 pi D / lambda, so that Doppler is positive away from the radar. The targets have
the opposite phase here, and the baseband is conjugated. The unlicensed module takes two targets at most, these are sixteen.
"""
import sys

import numpy as np
from radarsimpy import Radar, Receiver, Transmitter
from radarsimpy.simulator import sim_radar

import point_targets

# Length of a pulse in s, and the rate of the converter in Hz: two samples of a pulse.
PULSE_S, RATE_HZ = 20e-6, 100e3
# An isotropic antenna at the origin; without patterns RadarSimPy has no gain at negative x.
ANTENNA = {
    "location": (0, 0, 0),
    "azimuth_angle": [-180, 180],
    "azimuth_pattern": [0, 0],
    "elevation_angle": [-90, 90],
    "elevation_pattern": [0, 0],
}


def of_instant(targets, instant):
    """The targets of a short frame that begins at an instant: location in m, speed in m/s, rcs in dBsm, phase in degrees."""
    return [
        {
            "location": targets.position_m[instant, k] - targets.radar_m,
            "speed": targets.velocity_m_s[instant, k],
            "rcs": targets.rcs_dbsm[instant, k],
            "phase": -targets.phase_deg[k],
        }
        for k in range(len(targets.parts))
    ]


def over_time(targets, timestamp):
    """The targets of a long frame: location and rcs at every time stamp of a radar; the speed is in the locations."""
    position, rcs = point_targets.at(targets, timestamp.ravel())
    position, rcs = (position - targets.radar_m).reshape(*timestamp.shape, -1, 3), rcs.reshape(*timestamp.shape, -1)
    return [
        {
            "location": tuple(position[..., k, axis] for axis in range(3)),
            "speed": (0, 0, 0),
            "rcs": rcs[..., k],
            "phase": -targets.phase_deg[k],
        }
        for k in range(len(targets.parts))
    ]


def doppler_radar(frequency_hz, every_s, pulses):
    """A radar that sends pulses of one frequency."""
    transmitter = Transmitter(f=frequency_hz, t=PULSE_S, tx_power=30, prp=every_s, pulses=pulses, channels=[ANTENNA])
    receiver = Receiver(fs=RATE_HZ, rf_gain=0, load_resistor=1, baseband_gain=0, channels=[ANTENNA])
    return Radar(transmitter=transmitter, receiver=receiver)


def slow_time(targets):
    """The first sample of every pulse."""
    radar = doppler_radar(targets.centre_hz, targets.every_s, len(targets.time_s))
    baseband = sim_radar(radar, over_time(targets, radar.time_prop["timestamp"]))["baseband"]
    return np.conj(baseband[0, :, 0])


def main(folder, name):
    targets = point_targets.read(folder, name)
    signal = slow_time(targets)
    np.save(f"radarsimpy-{name}.npy", signal)
    print(f"radarsimpy-{name}.npy: {len(signal)} pulses")


if __name__ == "__main__":
    main(*sys.argv[1:])
