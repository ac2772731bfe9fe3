"""Golden walk: the global walking model of Boulic, Magnenat-Thalmann and Thalmann (1990) with scipy's PCHIP.

- `translation` (unit: thigh + shank) and `joints` (m, from the pelvis centre, before that translation) at phases of
  the cycle away from the splines' knots: base, neck, head, then left and right shoulder, elbow, hand, hip, knee, ankle,
  toe.
- `velocities`: their derivatives by phase, five-point stencil of step 1e-4, for the adult (lengths scale with height).
- `cross_sections` (m^2): head, torso, then left and right shoulder, upper arm, lower arm, hip, thigh, shank, foot, seen
  from `radar`.

A table made from public implementations with their known mistakes undone (and one checked against NIST's joints) is
asserted to 1e-4 m first.

    pip install numpy==2.4.6 scipy==1.17.1
    python kinematics.py
"""

import json
from importlib.metadata import version
from pathlib import Path

import numpy as np
from scipy.interpolate import PchipInterpolator

SPEEDS = (0.2, 0.45, 0.5, 0.8, 1.0, 1.29, 1.3, 1.6, 2.2, 3.0)
HEIGHTS = (1.0, 1.75)
RADAR = np.array([3.0, 0.5, 0.2])
STEP = 1e-4

# fractions of the height
HEAD, SHOULDER, TORSO, HIP = 0.130, 0.1295, 0.288, 0.0955
THIGH, SHANK, FOOT, UPPER, LOWER = 0.245, 0.246, 0.143, 0.188, 0.152


def sine(x):
    return np.sin(2 * np.pi * x)


def cosine(x):
    return np.cos(2 * np.pi * x)


def support(rv):
    """Share of the cycle a foot stands."""
    cycle = 1.346 / np.sqrt(rv)
    return (0.752 * cycle - 0.143) / cycle


def controls(rv):
    """Control points (phase, degrees) of the spline-controlled angles."""
    p, q, ds = (rv - 0.5) / 0.8, (rv - 1.3) / 1.7, support(rv)
    thorax = [(0.1, 4 * rv / 3), (0.4, -4.5 * rv / 3), (0.6, -4 * rv / 3), (0.9, 4.5 * rv / 3)]
    if rv < 0.5:
        hip = [(-0.1, 50 * rv), (0.5, -30 * rv)]
        knee = [(0.17, 3), (0.4, 3), (0.75, 140 * rv), (1, 3)]
        ankle = [(0, -3), (0.08, -30 * rv - 3), (0.5, 22 * rv - 3), (ds, -34 * rv - 3), (0.85, -3)]
        elbow = [(0.05, 6 * rv + 3), (0.5, 34 * rv + 3), (0.9, 10 * rv + 3)]
    elif rv < 1.3:
        hip = [(-0.1, 25), (0.5, -15)]
        knee = [(0.17, 3), (0.4, 3), (0.75, 70), (1, 3)]
        ankle = [(0, -3), (0.08, -18), (0.5, 8), (ds, -20), (0.85, -3)]
        elbow = [(0.05, 6 + 8 * p), (0.5 + 0.01 * p, 20 + 24 * p), (0.9, 8 + 9 * p)]
    else:
        hip = [(-0.1 + 0.2 * q, 25 + 5 * q), (0.5, -15), (0.9, 25 + 6 * q)]
        knee = [(0.17 - 0.05 * q, 3 + 22 * q), (0.4, 3), (0.75 - 0.05 * q, 70 - 5 * q), (1 - 0.03 * q, 3 + 3 * q)]
        ankle = [(0, -3 + 5 * q), (0.08, -18 + 4 * q), (0.5 - 0.1 * q, 8 - 3 * q), (ds, -20 - 8 * q),
                 (0.85, -3 + 5 * q)]
        elbow = [(0.05, 14 - 6 * q), (0.51 + 0.04 * q, 44 + 26 * q), (0.9 - 0.1 * q, 17 - 6 * q)]
    return {"hip": hip, "knee": knee, "ankle": ankle, "elbow": elbow, "thorax": thorax}


def periodic(points):
    """PCHIP through the points and their copies one period before and after, as a function of any phase."""
    one = {}
    for phase, value in points:
        # at RV = 1.3 the hip's first and last points are the same modulo 1
        one.setdefault(round(phase % 1, 9), (phase % 1, value))
    t, y = np.array(sorted(one.values())).T
    spline = PchipInterpolator(np.concatenate([t - 1, t, t + 1]), np.tile(y, 3))
    return lambda phase: spline(np.mod(phase, 1))


def roll(rv, t):
    """Pelvis roll in degrees."""
    a, t = 1.66 * rv, np.mod(t, 1)
    return np.select(
        [t < 0.15, t < 0.5, t < 0.65],
        [-a + a * cosine(10 * t / 3), -a - a * cosine(10 * (t - 0.15) / 7), a - a * cosine(10 * (t - 0.5) / 3)],
        a + a * cosine(10 * (t - 0.65) / 7))


def translation(rv, t):
    slow = rv - rv**2 if rv < 0.5 else 0.25
    x = 0.084 * slow * sine(2 * t + 2 * (0.625 - support(rv)))
    y = 0.128 * slow * sine(t - 0.1)
    z = 0.015 * rv * (sine(2 * t - 0.35) - 1)
    if rv >= 0.5:
        x, y = -x, -y
    return np.stack([x, y, z], axis=-1)


def rotate_x(angle, v):
    c, s = np.cos(angle), np.sin(angle)
    return np.stack([v[..., 0], c * v[..., 1] + s * v[..., 2], -s * v[..., 1] + c * v[..., 2]], axis=-1)


def rotate_y(angle, v):
    c, s = np.cos(angle), np.sin(angle)
    return np.stack([c * v[..., 0] - s * v[..., 2], v[..., 1] + 0 * c, s * v[..., 0] + c * v[..., 2]], axis=-1)


def rotate_z(angle, v):
    c, s = np.cos(angle), np.sin(angle)
    return np.stack([c * v[..., 0] + s * v[..., 1], -s * v[..., 0] + c * v[..., 1], v[..., 2] + 0 * c], axis=-1)


def pose(rv, height, t):
    """Joints `[..., 17, 3]` at the phases `t`."""
    t = np.asarray(t, dtype=float)
    spline = {name: periodic(points) for name, points in controls(rv).items()}
    slow = 4 * (rv - rv**2) if rv < 0.5 else 1
    bend = np.radians(2 * slow * (sine(2 * t - 0.1) - 1))
    twist = np.radians(spline["thorax"](t))
    yaw, tilt = np.radians(-4 * rv * cosine(t)), np.radians(roll(rv, t))
    vector = lambda x, y, z: np.array([x, y, z]) * height

    upper = lambda v: rotate_z(twist, rotate_y(bend, v + np.zeros((*t.shape, 3))))
    lower = lambda v: rotate_z(yaw, rotate_x(-tilt, v + np.zeros((*t.shape, 3))))
    joints = [np.zeros((*t.shape, 3)), upper(vector(0, 0, TORSO)), upper(vector(0, 0, TORSO + HEAD))]
    arms, legs = [], []
    for sign in (1, -1):
        own = t + 0.5 if sign == 1 else t
        swing = np.radians(3 - 9.88 * rv / 2 - 9.88 * rv * cosine(own))
        elbow = np.radians(spline["elbow"](own))
        origin = vector(0, sign * SHOULDER, TORSO)
        forearm = rotate_y(elbow, vector(0, 0, -LOWER)) + vector(0, 0, -UPPER)
        arms.append([upper(origin), upper(origin + rotate_y(swing, vector(0, 0, -UPPER))),
                     upper(origin + rotate_y(swing, forearm))])
        hip, knee, ankle = (np.radians(spline[name](own)) for name in ("hip", "knee", "ankle"))
        origin = vector(0, sign * HIP, 0)
        thigh, shank = vector(0, 0, -THIGH), vector(0, 0, -SHANK)
        foot = rotate_y(ankle, vector(FOOT, 0, 0))
        legs.append([lower(origin), lower(origin + rotate_y(hip, thigh)),
                     lower(origin + rotate_y(hip, thigh + rotate_y(-knee, shank))),
                     lower(origin + rotate_y(hip, thigh + rotate_y(-knee, shank + foot)))])
    for pair in (arms, legs):
        for left, right in zip(*pair):
            joints += [left, right]
    return np.stack(joints, axis=-2)


NAMES = ["base", "neck", "head"] + [
    f"{side} {part}" for part in ("shoulder", "elbow", "hand", "hip", "knee", "ankle", "toe") for side in "LR"]


def cross_sections(joints, height, radar):
    """Ellipsoids of revolution at high frequency, `[..., 16]`."""
    at = {name: joints[..., k, :] for k, name in enumerate(NAMES)}
    middle = lambda a, b: (at[a] + at[b]) / 2
    # centre, axis, girth in m at 1.75 m, length as a fraction of the height
    parts = [(at["head"], at["head"] - at["neck"], 0.10, HEAD),
             (middle("neck", "base"), at["neck"] - at["base"], 0.15, TORSO)]
    both = [
        lambda s: (at[f"{s} shoulder"], at[f"{s} shoulder"] - at["neck"], 0.06, SHOULDER),
        lambda s: (middle(f"{s} shoulder", f"{s} elbow"), at[f"{s} shoulder"] - at[f"{s} elbow"], 0.06, UPPER),
        lambda s: (at[f"{s} hand"], at[f"{s} elbow"] - at[f"{s} hand"], 0.05, LOWER),
        lambda s: (at[f"{s} hip"], at[f"{s} hip"] - at["base"], 0.07, HIP),
        lambda s: (middle(f"{s} hip", f"{s} knee"), at[f"{s} knee"] - at[f"{s} hip"], 0.07, THIGH),
        lambda s: (middle(f"{s} knee", f"{s} ankle"), at[f"{s} ankle"] - at[f"{s} knee"], 0.06, SHANK),
        lambda s: (at[f"{s} toe"], at[f"{s} ankle"] - at[f"{s} toe"], 0.05, FOOT),
    ]
    parts += [part(side) for part in both for side in "LR"]
    found = []
    for centre, axis, girth, length in parts:
        a, c = girth * height / 1.75, length * height / 2
        sight = radar - centre
        # the angle between them from both products, exact at any angle
        across, along = np.linalg.norm(np.cross(sight, axis), axis=-1), np.sum(sight * axis, axis=-1)
        angle = np.arctan2(across, along)
        found.append(np.pi * a**4 * c**2 / (a**2 * np.sin(angle)**2 + c**2 * np.cos(angle)**2)**2)
    return np.stack(found, axis=-1)


def check():
    """The golden table, H = 1.75 at phases 0, 1/4, 1/2, 3/4."""
    golden = {
        (1.0, "head"): [(.0405, -.0010, .7304), (.0105, 0, .7314), (.0405, .0010, .7304), (.0105, 0, .7314)],
        (1.0, "neck"): [(.0279, -.0007, .5032), (.0073, 0, .5039), (.0279, .0007, .5032), (.0073, 0, .5039)],
        (1.0, "R shoulder"): [(.0222, -.2273, .5032), (.0078, -.2266, .5039), (.0337, -.2258, .5032),
                              (.0067, -.2266, .5039)],
        (1.0, "R elbow"): [(-.0629, -.2251, .1854), (-.0081, -.2266, .1753), (.0610, -.2252, .1754),
                           (-.0092, -.2266, .1753)],
        (1.0, "R hand"): [(-.0796, -.2247, -.0800), (.0742, -.2264, -.0776), (.2310, -.2208, -.0291),
                          (.0784, -.2268, -.0758)],
        (1.0, "R hip"): [(.0117, -.1667, 0), (0, -.1669, .0079), (-.0117, -.1667, 0), (0, -.1669, -.0079)],
        (1.0, "R knee"): [(.1721, -.1555, -.3974), (.0003, -.1871, -.4204), (-.1224, -.1590, -.4141),
                          (.0917, -.1472, -.4262)],
        (1.0, "R ankle"): [(.3122, -.1457, -.8044), (-.0218, -.2073, -.8499), (-.3454, -.1434, -.7821),
                           (-.2721, -.1364, -.6563)],
        (1.0, "R toe"): [(.5521, -.1289, -.7352), (.2233, -.2097, -.9002), (-.1160, -.1594, -.8810),
                         (-.1819, -.1254, -.8895)],
        (1.0, None): [(.00542, .01881, -.02714), (-.00542, -.02589, -.00286), (.00542, -.01881, -.02714),
                      (-.00542, .02589, -.00286)],
        (0.4, "R knee"): [(.1345, -.1634, -.4086), (.0003, -.1752, -.4255), (-.0938, -.1646, -.4194),
                          (.0735, -.1591, -.4255)],
        (0.4, "R toe"): [(.4882, -.1536, -.7747), (.2241, -.1841, -.9010), (-.0436, -.1660, -.8923),
                         (-.1043, -.1495, -.9361)],
        (0.4, None): [(-.01376, -.01806, -.01085), (.01376, .02485, -.00115), (-.01376, .01806, -.01085),
                      (.01376, -.02485, -.00115)],
        (1.6, "R knee"): [(.1920, -.1466, -.3916), (.0111, -.1989, -.4148), (-.1289, -.1537, -.4141),
                          (.0969, -.1353, -.4290)],
        (1.6, "R toe"): [(.5777, -.1034, -.7161), (.2245, -.2351, -.8946), (-.1295, -.1536, -.8884),
                         (-.1557, -.0999, -.8974)],
        (1.6, "R hand"): [(-.1633, -.2202, -.0591), (.0716, -.2264, -.0714), (.3021, -.2145, .0292),
                          (.0708, -.2269, -.0710)],
    }
    quarters, worst = np.arange(4) / 4, 0
    for (rv, name), expected in golden.items():
        found = translation(rv, quarters) if name is None else pose(rv, 1.75, quarters)[:, NAMES.index(name)]
        error = np.abs(found - expected).max()
        assert error < 1e-4, (rv, name, error, found)
        worst = max(worst, error)
    for rv in SPEEDS:
        a, b = pose(rv, 1.75, 0.1 + quarters), pose(rv, 1.75, 0.6 + quarters)
        for part in range(7):
            for this, other in ((0, 1), (1, 0)):
                mirrored = b[:, 3 + 2 * part + other] * [1, -1, 1]
                assert np.abs(a[:, 3 + 2 * part + this] - mirrored).max() < 1e-12, (rv, part)
    return worst


def phases():
    """Twelve phases at least 2e-3 from every knot of every speed, for both legs."""
    knots = [0, 0.15, 0.5, 0.65]
    for rv in SPEEDS:
        for points in controls(rv).values():
            knots += [phase + half for phase, _ in points for half in (0, 0.5)]
    far = lambda t: min(abs((t - knot + 0.5) % 1 - 0.5) for knot in knots) > 2e-3
    found = []
    for k in range(12):
        found.append(next(t for t in np.round(k / 12 + 0.0137 + np.arange(60) * 1e-3, 9) if far(t)))
    assert 0 <= found[0] and found[-1] < 1 and np.all(np.diff(found) > 0.02)
    return np.array(found)


def derivative(function, t):
    at = lambda k: function(t + k * STEP)
    return (at(-2) - 8 * at(-1) + 8 * at(1) - at(2)) / (12 * STEP)


def plain(values, digits=9):
    """Nested lists, rounded, whole numbers without their point."""
    if isinstance(values, (list, np.ndarray)):
        return [plain(v, digits) for v in values]
    value = round(float(values), digits)
    return int(value) if value == int(value) else value


if __name__ == "__main__":
    worst = check()
    t = phases()
    cases = []
    for rv in SPEEDS:
        for height in HEIGHTS:
            joints = pose(rv, height, t)
            sections = cross_sections(joints, height, RADAR)
            # ten significant digits and more
            case = {"rv": rv, "height": height, "joints": plain(joints),
                    "cross_sections": [[float(f"{s:.11g}") for s in row] for row in sections]}
            if height == HEIGHTS[-1]:
                case["translation"] = plain(translation(rv, t))
                case["velocities"] = plain(derivative(lambda x: pose(rv, height, x), t), 6)
                case["translation_velocity"] = plain(derivative(lambda x: translation(rv, x), t), 6)
            cases.append(case)
    golden = {"source": f"numpy {np.__version__}, scipy {version('scipy')}", "radar": RADAR.tolist(),
              "phases": t.tolist(), "cases": cases}
    path = Path(__file__).with_name("kinematics.json")
    path.write_text(json.dumps(golden, separators=(",", ":")) + "\n")
    print(golden["source"], path.stat().st_size, f"golden table within {worst:.1e} m")
