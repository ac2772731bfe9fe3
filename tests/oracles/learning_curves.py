"""Golden learning curves: 200 random sets of points, fitted by scipy with the bounds the predictor states.

Every set is drawn from one of the seven families (or from none: a smooth rise of random form), at random N_s, with binomial
noise of a random count. For every family the least squares fit is sought with scipy's differential_evolution over a wide box
and its curve_fit (trust region) from the best member and from several starts; the smallest error of a legal curve counts.
Legal (section IV-B of the paper): over the points 0 <= A <= 1, increasing, slope falling; no pole from 128 slots on.

    pip install numpy==2.4.6 scipy==1.17.1
    python learning_curves.py
"""

import json
import warnings
from importlib.metadata import version
from pathlib import Path

import numpy as np
from scipy.optimize import curve_fit, differential_evolution

warnings.filterwarnings("ignore")
LEAST = 128.0

# name: function, box of the global search
MODELS = {
    "vapor_pressure": (lambda n, a, b: np.exp(a + b / n), [(-3, 0.5), (-800, 0)]),
    "pow3": (lambda n, la, b, g: g - np.exp(la) * n**-b, [(-8, 60), (0.01, 8), (0, 4)]),
    "log_power": (lambda n, a, b, g: a / (1 + (n / np.exp(b)) ** g), [(0, 5), (-10, 12), (-8, -0.01)]),
    "exp4": (lambda n, la, b, lg, e: e - np.exp(-np.exp(la) * n ** np.exp(lg) + b),
             [(-12, 6), (-10, 60), (-5, 1), (0, 3)]),
    "log_log_linear": (lambda n, a, b: np.log(a * np.log(n) + b), [(0, 1.5), (-6, 3)]),
    "ilog2": (lambda n, a, b: b - a / np.log(n), [(0, 30), (-1, 6)]),
    "pow4": (lambda n, la, b, g, e: g - (np.exp(la) * n + b) ** -e, [(-12, 6), (-300, 300), (0, 4), (0.02, 8)]),
}


def legal(f, p, low, high):
    grid = np.linspace(low, high, 129)
    a = f(grid, *p)
    below = f(np.linspace(min(low, LEAST), low, 9), *p)
    steps = np.diff(a)
    return bool(np.all(np.isfinite(a)) and np.all(np.isfinite(below)) and a[0] >= -1e-9 and a[-1] <= 1 + 1e-9
                and np.all(steps >= -1e-12) and np.all(np.diff(steps) <= 1e-9))


def fit(name, n, a, rng):
    f, box = MODELS[name]
    low, high = n.min(), n.max()
    best = np.inf

    def error(p):
        r = f(n[:, None], *p) - a[:, None]
        e = np.sum(r * r, axis=0)
        g = np.linspace(low, high, 17)[:, None]
        c = f(g, *p)
        s = np.diff(c, axis=0)
        pole = f(np.array([[min(low, LEAST)]]), *p)
        bad = (np.maximum(-c[0], 0) + np.maximum(c[-1] - 1, 0) + np.maximum(-s, 0).sum(axis=0)
               + np.maximum(np.diff(s, axis=0), 0).sum(axis=0))
        e = e + 10 * bad
        return np.where(np.isfinite(e) & np.isfinite(pole[0]), e, 1e3)

    def consider(p):
        nonlocal best
        if np.all(np.isfinite(p)) and legal(f, p, low, high):
            best = min(best, float(np.sum((f(n, *p) - a) ** 2)))

    found = differential_evolution(error, box, vectorized=True, updating="deferred", seed=rng, popsize=20, maxiter=300,
                                   tol=1e-10, polish=False)
    consider(found.x)
    starts = [found.x] + [np.array([rng.uniform(*b) for b in box]) for _ in range(3)]
    for start in starts:
        for extra in ({"method": "trf"}, {"method": "lm"}):
            try:
                p, _ = curve_fit(f, n, a, p0=start, maxfev=4000, **extra)
                consider(p)
            except (RuntimeError, ValueError):
                pass
    return best


def draw(rng):
    count = int(rng.integers(6, 11))
    n = np.sort(rng.choice(np.arange(100, 1001, 20 if count > 8 else 50), size=count, replace=False)).astype(float)
    ceiling, start = rng.uniform(0.8, 0.99), rng.uniform(0.3, 0.75)
    rise = rng.uniform(0.5, 3.0)
    form = rng.integers(4)
    x = n / n[0]
    if form == 0:
        a = ceiling - (ceiling - start) * x**-rise
    elif form == 1:
        a = ceiling - (ceiling - start) * np.exp(-rise * (x - 1) / 2)
    elif form == 2:
        a = start + (ceiling - start) * np.log(x) / np.log(x[-1])
    else:
        a = ceiling * np.exp(-rise * 0.3 / x)
    tested = int(rng.choice([100, 300, 500, 2000, 10000]))
    return n, rng.binomial(tested, np.clip(a, 0, 1)) / tested, tested


if __name__ == "__main__":
    rng = np.random.default_rng(6)
    curves = []
    for index in range(200):
        n, a, tested = draw(rng)
        errors = {name: fit(name, n, a, rng) for name in MODELS}
        assert all(np.isfinite(list(errors.values()))), (index, errors)
        curves.append({"sensing_slots": n.tolist(), "accuracy": a.tolist(), "tested": tested,
                       "sse": {k: float(f"{v:.9e}") for k, v in errors.items()}})
        print(index, flush=True)
    golden = {"source": f"numpy {np.__version__}, scipy {version('scipy')}", "curves": curves}
    path = Path(__file__).with_name("learning_curves.json")
    path.write_text(json.dumps(golden, separators=(",", ":")) + "\n")
    print(golden["source"], path.stat().st_size)
