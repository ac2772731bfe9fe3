"""Point targets of `sdp3 targets` in Sionna RT 2.2: one sensing target for every part, moved from instant to instant.

sionna_targets.py FOLDER CLASS      writes sionna-CLASS.npz: coefficients, delays and Doppler shifts, [instant, part]

There is free space around the radar. `scene_of` takes the file of a scene too; then RCSSolver with a `max_depth` above 1 also finds
paths by its surfaces, several for each part.
"""
import sys

import mitsuba as mi
import numpy as np
from sionna.rt import PlanarArray, Receiver, Transmitter, load_scene
from sionna.rt.rcs import ConstantRCSSensingTarget, RCSSolver

import point_targets

# Edge of the cubes that stand for parts in m: so small that none hides another.
EDGE_M = 1e-3


def scene_of(targets, file=None):
    """A scene with the radar and the parts of a person."""
    scene = load_scene(file)
    scene.frequency = targets.carrier_hz
    scene.tx_array = scene.rx_array = PlanarArray(num_rows=1, num_cols=1, pattern="iso", polarization="V")
    radar = mi.Point3f(*targets.radar_m.tolist())
    scene.add(Transmitter(name="tx", position=radar))
    scene.add(Receiver(name="rx", position=radar))
    edges = {"length": EDGE_M, "width": EDGE_M, "height": EDGE_M}
    scene.edit(add=[ConstantRCSSensingTarget(name=part, **edges) for part in targets.parts])
    return scene


def move(scene, targets, instant):
    """Gives every part its position, velocity and cross section of an instant."""
    for k, part in enumerate(targets.parts):
        target = scene.get(part)
        target.position = mi.Point3f(*targets.position_m[instant, k].tolist())
        target.velocity = mi.Vector3f(*targets.velocity_m_s[instant, k].tolist())
        target.sigma = float(10 ** (targets.rcs_dbsm[instant, k] / 10))


def direct_echoes(scene, targets, solver):
    """Coefficient with the carrier's phase, delay in s and Doppler shift in Hz of every part's direct echo."""
    paths = solver(scene, max_depth=1, samples_per_sp=1, buffer_size_per_sp=100, specular_reflection=False, refraction=False, seed=1)
    part = np.array(paths.objects).reshape(-1)
    order = np.argsort(part)
    if len(part) != len(targets.parts):
        raise ValueError(f"{len(part)} direct echoes of {len(targets.parts)} parts")
    real, imaginary = (np.array(a).reshape(-1)[order].astype(float) for a in paths.a)
    delay, doppler = (np.array(a).reshape(-1)[order].astype(float) for a in (paths.tau, paths.doppler))
    phase = np.radians(targets.phase_deg) - 2 * np.pi * targets.carrier_hz * delay
    return (real + 1j * imaginary) * np.exp(1j * phase), delay, doppler


def echoes(targets):
    """Coefficients, delays in s and Doppler shifts in Hz over [instant, part], in free space."""
    scene, solver, found = scene_of(targets), RCSSolver(), []
    for instant in range(len(targets.time_s)):
        move(scene, targets, instant)
        found.append(direct_echoes(scene, targets, solver))
    return (np.array(one) for one in zip(*found))


def main(folder, name):
    coefficient, delay, doppler = echoes(point_targets.read(folder, name))
    np.savez(f"sionna-{name}.npz", coefficient=coefficient, delay_s=delay, doppler_hz=doppler)
    print(f"sionna-{name}.npz: {coefficient.shape[0]} instants, {coefficient.shape[1]} parts, "
          f"Doppler shifts {doppler.min():.1f} to {doppler.max():.1f} Hz")


if __name__ == "__main__":
    main(*sys.argv[1:])
