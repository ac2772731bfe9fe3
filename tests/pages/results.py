"""The run's results as JSON, and how the page should write their numbers."""

import json
import struct
from decimal import ROUND_HALF_UP, Decimal


class Results:
    """`run.json` and `figures.json` of an output folder."""

    def __init__(self, folder):
        self.run = json.loads((folder / "run.json").read_text())
        self.figures = json.loads((folder / "figures.json").read_text())

    def boundary(self, case):
        """Points of a user placement, N_s ascending."""
        return [point for point in self.run["region"] if point["case"] == case]

    def cases(self):
        return list(dict.fromkeys(point["case"] for point in self.run["region"]))

    def plan(self, point):
        same = lambda plan: (plan["case"], plan["sensing_slots"]) == (point["case"], point["sensing_slots"])
        return next(filter(same, self.figures["plans"]))

    def say_region(self, point):
        """The readout of a region's point."""
        return {
            "case": str(point["case"]),
            "N_s": str(point["sensing_slots"]),
            "N_c": " + ".join(map(str, point["communication_slots"])),
            "accuracy": digits(point["accuracy"], 4),
            "95 % band": f"{digits(point['accuracy_low'], 3)}–{digits(point['accuracy_high'], 3)}",
            "throughput": f"{digits(point['throughput_bit'] / 1e6, 3)} Mbit per period",
            "rate": f"{digits(point['throughput_bit'] / self.run['operating_point']['period_s'] / 1e6, 3)} Mbit/s",
            "curve": "extrapolated" if point["extrapolated"] else "measured range",
            "zone": point["zone"].replace("-", " "),
        }

    def slots(self):
        """The played period, slot by slot."""
        return [code for code, count in self.run["schedule"]["timeline"] for _ in range(count)]


def digits(x, n):
    """A number with n decimals, halves away from zero, as a browser writes it."""
    return str(Decimal(x).quantize(Decimal(1).scaleb(-n), ROUND_HALF_UP))


def percent(x):
    return f"{digits(100 * x, 1)} %"


def grouped(n):
    return f"{n:,}".replace(",", "\u202f")


def use_name(code):
    return {-2: "idle", -1: "sensing"}.get(code, f"user {code + 1}")


def use_colour(code):
    return {-2: "#e6e6e6", -1: "var(--ink)"}.get(code, f"var(--series-{code})" if code < 7 else "#f0e442")


def stop_of(recording, threshold, most):
    """The exit at which a recording stops; confidences are compared in 32 bits, as the core does."""
    short = struct.unpack("f", struct.pack("f", threshold))[0]
    exits = recording["exits"]
    last = next(k for k, exit in enumerate(exits) if exit["sensing_slots"] == most)
    return next((exit for exit in exits[:last] if exit["confidence"] >= short), exits[last])
