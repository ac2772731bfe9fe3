"""Golden allocations: 200 random instances of water-filling, of the weighted sum, and of the whole problem in whole slots.

- `water_filling`: scipy's SLSQP maximises sum log2(1 + p gamma) on the simplex; polished by brentq on the water level.
- `weighted`: scipy's minimize_scalar (bounded, from every grid cell) of w_A Theta(n) + w_R (N - n) / sum 1/r, and linprog for
  the inner problem max R, n_k r_k >= R, sum n_k = N - n.
- `integer`: every N_s and every division of the rest among K receivers, by trying all (small N).

    pip install numpy==2.4.6 scipy==1.17.1
    python allocation.py
"""

import itertools
import json
from importlib.metadata import version
from pathlib import Path

import numpy as np
from scipy.optimize import brentq, linprog, minimize, minimize_scalar


def short(x):
    """Four digits: the instances are random, the file need not be long."""
    return np.vectorize(lambda v: float(f"{v:.4g}"))(x)


def water_filling(rng):
    m = int(rng.integers(2, 25))
    gamma = short(np.exp(rng.normal(1.0, 2.5, size=m)))
    gamma[rng.random(m) < 0.05] = 0.0
    gamma[int(rng.integers(m))] = 3.0
    rate = lambda p: np.sum(np.log2(1 + p * gamma))
    found = minimize(lambda p: -rate(p), np.full(m, 1 / m), method="SLSQP", bounds=[(0, 1)] * m,
                     jac=lambda p: -gamma / (1 + p * gamma) / np.log(2),
                     constraints={"type": "eq", "fun": lambda p: p.sum() - 1, "jac": lambda p: np.ones(m)},
                     options={"maxiter": 2000, "ftol": 1e-15})
    active = gamma[gamma > 0]
    used = lambda level: np.sum(np.maximum(level - 1 / active, 0)) - 1
    level = brentq(used, 0, 1 + np.max(1 / active) + 1, xtol=1e-15, rtol=1e-15)
    p = np.where(gamma > 0, np.maximum(level - 1 / np.where(gamma > 0, gamma, 1), 0), 0)
    # the general solver and the water level agree to the solver's precision; the sharper one is kept
    assert abs(rate(p) - -found.fun) < 1e-6 * max(1, rate(p)), (rate(p), -found.fun)
    return {"gamma": gamma.tolist(), "rate": float(rate(p))}


def curve(rng):
    ceiling, at200, power = short([rng.uniform(0.85, 0.99), rng.uniform(0.3, 0.8), rng.uniform(0.6, 3.0)]).tolist()
    alpha = float(short((ceiling - at200) * 200.0**power))
    return {"alpha": alpha, "beta": power, "gamma": ceiling}


def theta(c, n):
    return np.clip(c["gamma"] - c["alpha"] * n ** -c["beta"], 0, 1)


def weighted(rng):
    c = curve(rng)
    period, spacing = int(rng.integers(1500, 8000)), int(rng.integers(0, 4))
    bits = short(np.exp(rng.uniform(np.log(100), np.log(10000), size=int(rng.integers(1, 7)))))
    low, high = 128.0, float(period // (spacing + 1))
    inner = lambda n: (period - n) / np.sum(1 / bits)
    # the inner linear programme at one n
    n0 = rng.uniform(low, high)
    k = len(bits)
    lp = linprog(np.r_[np.zeros(k), -1.0], A_ub=np.c_[-np.diag(bits), np.ones(k)], b_ub=np.zeros(k),
                 A_eq=[np.r_[np.ones(k), 0.0]], b_eq=[period - n0], method="highs")
    assert abs(-lp.fun / inner(n0) - 1) < 1e-9
    weight_a = 1.0
    weight_r = float(np.exp(rng.uniform(np.log(0.02), np.log(5)))) / inner(low)
    f = lambda n: -(weight_a * theta(c, n) + weight_r * inner(n))
    grid = np.linspace(low, high, 65)
    best = min(((f(n), n) for n in grid), key=lambda x: x[0])
    for a, b in itertools.pairwise(grid):
        r = minimize_scalar(f, bounds=(a, b), method="bounded", options={"xatol": 1e-9})
        best = min(best, (float(r.fun), float(r.x)), key=lambda x: x[0])
    return {"curve": c, "period": period, "spacing": spacing, "bits": bits.tolist(), "range": [low, high],
            "weights": [weight_a, weight_r], "value": -best[0], "linear": {"n": n0, "throughput": -float(lp.fun)}}


def integer(rng):
    k = int(rng.integers(1, 5))
    period = int(rng.integers(8, {1: 120, 2: 70, 3: 36, 4: 20}[k]))
    spacing = int(rng.integers(0, 3))
    window = int(rng.integers(1, max(2, period // (spacing + 1) // 2)))
    bits = short(np.exp(rng.uniform(np.log(1), np.log(200), size=k)))
    c = {name: float(short(rng.uniform(*span))) for name, span in
         {"alpha": (0.3, 2.0), "beta": (0.3, 1.5), "gamma": (0.8, 1.0)}.items()}
    weight_r = float(np.exp(rng.uniform(np.log(0.05), np.log(3)))) * np.sum(1 / bits) / period
    best = {}
    for n in range(window, period // (spacing + 1) + 1):
        rest = period - n
        most = 0.0
        for shares in itertools.product(range(rest + 1), repeat=k - 1):
            last = rest - sum(shares)
            if last >= 0:
                most = max(most, min(s * b for s, b in zip((*shares, last), bits)))
        best[n] = most
    value = max(float(theta(c, n)) + weight_r * r for n, r in best.items())
    # the products of few digits, without the last one's noise
    throughput = {str(n): float(f"{r:.12g}") for n, r in best.items()}
    return {"curve": c, "period": period, "spacing": spacing, "window": window, "bits": bits.tolist(),
            "weights": [1.0, float(weight_r)], "throughput": throughput, "value": value}


if __name__ == "__main__":
    rng = np.random.default_rng(7)
    golden = {
        "source": f"numpy {np.__version__}, scipy {version('scipy')}",
        "water_filling": [water_filling(rng) for _ in range(200)],
        "weighted": [weighted(rng) for _ in range(200)],
        "integer": [integer(rng) for _ in range(200)],
    }
    path = Path(__file__).with_name("allocation.json")
    path.write_text(json.dumps(golden, separators=(",", ":")) + "\n")
    print(golden["source"], path.stat().st_size)
