"""Tables and checks of tests/cycles, from the files of its folder.

report.py FOLDER ACCEPTED [--accept]

FOLDER/rtl/<core>.<wait states> and FOLDER/qemu/<machine> are what the program printed, FOLDER/counts/<machine> the output of trace.py.
"""
import collections
import pathlib
import sys

folder, accepted = pathlib.Path(sys.argv[1]), pathlib.Path(sys.argv[2])
CORES = {"ibex": "Ibex", "ibex-fast": "Ibex-fast", "vexriscv": "VexRiscv"}
# A ratio may differ by so much from the accepted one: the order of functions changes alignments and what meets in a cache.
RATIO = 0.05
# A predicted stage may differ by so much from what was measured.
PREDICTION = 0.10
# Cycles of Ibex with its fast multiplier and memory without wait states, by the table "Multi- and Single-Cycle Instructions" of its
# documentation (pipeline_details): one and the stalls. What a taken branch adds is apart; so is the second fetch for an instruction of
# four bytes that a jump leads to and that is not aligned, which the table does not name: its cost is fitted.
IBEX = {"alu": 1, "load": 2, "store": 2, "multiply": 3, "multiply-high": 4, "divide": 38, "jump": 2, "branch": 1, "taken": 2}
FITTED = "split-target"
# Least and most cycles of the Cortex-M4F with memory without wait states, by its technical reference manual r0p1 (ARM 100166): table
# 3-1 and the load and store timings behind it, table 7-1 for the FPU. A pipeline refill takes 1 to 3, a division 2 to 12; a load behind
# a load may take 1, and a store does where the buffer has room; IT may be folded; what it skips takes 1. An address that the instruction
# before computes, a load from beside the program, and a result of the FPU that the next instruction uses may add one.
CORTEX_M4F = {
    "alu": (1, 1), "multiply": (1, 1), "divide": (2, 12), "it": (0, 1), "branch": (1, 1), "table-branch": (2, 3), "refill": (1, 3),
    "load": (2, 2), "load-after": (1, 2), "store": (1, 2), "multiple": (1, 1), "register": (1, 1), "fp": (1, 1), "fp-move": (1, 2),
    "fp-multiply-add": (3, 3), "fp-divide": (14, 14), "fp-load": (2, 2), "fp-load-double": (3, 3), "fp-store": (2, 2),
    "fp-store-double": (3, 3), "address-after": (0, 1), "literal": (0, 1), "fp-after": (0, 1),
}
failed = []


def fail(text):
    failed.append(text)
    print(f"FAILED: {text}")


def stages(path):
    """`{(slots, stage): (instructions, cycles)}`, a recognition of all stages among them."""
    found = {}
    for line in path.read_text().splitlines():
        words = line.split()
        if words[:1] == ["stage"] and words[2] != "nothing":
            found[int(words[1]), words[2]] = (int(words[4]), int(words[5]))
    for slots in {slots for slots, _ in found}:
        parts = [value for (n, stage), value in found.items() if n == slots and stage != "decision"]
        found[slots, "recognition"] = tuple(map(sum, zip(*parts)))
    return found


def digests(path):
    text = path.read_text().splitlines()
    return [line for line in text if line.split()[:1] == ["digest"] or line in ("self test passed", "done")]


def counts(path):
    """`{(slots, stage): {class: number}}`, by the names of the program's marks."""
    names = {}
    for line in (folder / "qemu" / path.name).read_text().splitlines():
        words = line.split()
        if words[:1] == ["mark"] and words[3] != "nothing":
            names[words[1]] = (int(words[2]), words[3])
    found = {name: collections.Counter() for name in names.values()}
    for line in path.read_text().splitlines():
        _, mark, name, number = line.split()
        if mark in names:
            found[names[mark]][name] = int(number)
    for slots in {slots for slots, _ in found}:
        found[slots, "recognition"] = sum(
            (part for (n, stage), part in found.items() if n == slots and stage != "decision"), collections.Counter())
    return found


def measured():
    """Every core's figures: compared with the accepted ones, or written."""
    reference = digests(folder / "qemu/riscv32imac")
    if len(reference) < 10:
        fail("the program printed no digests")
    runs = {path.name: path for part in ("qemu", "rtl") for path in sorted((folder / part).iterdir())}
    for name, path in runs.items():
        if digests(path) != reference:
            fail(f"{name}: digests differ from those under QEMU")
    if not failed:
        print(f"{len(reference)} lines of digests are equal on {', '.join(runs)}")
    lines, table = [], {}
    for path in sorted((folder / "rtl").iterdir()):
        core, waits = path.name.rsplit(".", 1)
        for (slots, stage), (instructions, cycles) in stages(path).items():
            table[core, waits, slots, stage] = instructions, cycles
            lines.append(f"{core:<10} {waits} {slots:>5} {stage:<14} {instructions:>10} {cycles:>10} {cycles / instructions:6.3f}")
    head = f"{'core':<10} w {'N_s':>5} {'stage':<14} {'instructions':>10} {'cycles':>8} {'ratio':>6}"
    print("\n".join([head, *lines]))
    if sys.argv[3:] == ["--accept"]:
        accepted.write_text("\n".join([head, *lines, ""]))
    before = {}
    for line in accepted.read_text().splitlines()[1:]:
        core, waits, slots, stage, _, _, ratio = line.split()
        before[core, waits, int(slots), stage] = float(ratio)
    for key in before.keys() | table.keys():
        name = " ".join(map(str, key))
        if key not in before or key not in table:
            fail(f"{name}: {'not measured' if key in before else 'new'}")
        elif abs((ratio := table[key][1] / table[key][0]) / before[key] - 1) > RATIO:
            fail(f"{name}: {ratio:.3f} cycles an instruction; {before[key]} before")
    return table


def predicted(table):
    """Ibex from its published costs: the one cost that is not published is fitted at N_s = 200 and tried at N_s = 1000."""
    found = counts(folder / "counts/riscv32imac")
    published = {key: sum(number * IBEX.get(name, 0) for name, number in part.items()) for key, part in found.items()}
    unknown = {name for part in found.values() for name in part} - IBEX.keys() - {FITTED, "instructions"}
    if unknown:
        fail(f"classes without a cost: {unknown}")
    fit = [(part[FITTED] / table["ibex", "0", *key][1], 1 - published[key] / table["ibex", "0", *key][1])
           for key, part in found.items() if key[0] == 200 and key[1] != "recognition"]
    cost = max(sum(x * y for x, y in fit) / sum(x * x for x, _ in fit), 0)
    print(f"\nIbex by its published costs, and {cost:.2f} cycles for a jump to an unaligned instruction of four bytes, fitted at N_s = 200:")
    print("| stage, N_s = 1000 | counted instructions | measured cycles | predicted | error |")
    worst = 0
    for key, part in found.items():
        if key[0] == 1000:
            cycles = table["ibex", "0", *key][1]
            guess = published[key] + cost * part[FITTED]
            error = guess / cycles - 1
            worst = max(worst, abs(error))
            print(f"| {key[1]} | {part['instructions']} | {cycles} | {guess:.0f} | {100 * error:+.1f} % |")
            if abs(part["instructions"] / table["ibex", "0", *key][0] - 1) > 0.01:
                fail(f"{key}: {part['instructions']} instructions under QEMU, {table['ibex', '0', *key][0]} on Ibex")
    print(f"largest error {100 * worst:.1f} %; {100 * PREDICTION:.0f} % are allowed")
    if worst > PREDICTION:
        fail("the prediction")


def bounded():
    """`{(slots, stage): (instructions, least cycles, most cycles)}` of the Cortex-M4F."""
    def cycles(part, bound):
        sum_ = 0
        for name, number in part.items():
            plain = name.removeprefix("conditional-")
            if plain not in CORTEX_M4F:
                if name != "instructions":
                    fail(f"no cost of {name}")
            elif plain == name or bound:
                sum_ += number * CORTEX_M4F[plain][bound]
            elif plain != "register":
                sum_ += number
        return sum_

    return {key: (part["instructions"], cycles(part, 0), cycles(part, 1)) for key, part in counts(folder / "counts/cortex-m4f").items()}


def summary(table, bounds):
    """The table of docs/benchmarks.md."""
    columns = [(core, waits) for core in CORES for waits in "01"]
    heads = [f"{name}, {waits}" for name in CORES.values() for waits in ("0 wait states", "1 wait state")]
    print(f"\nCycles an instruction\n| stage | instructions | {' | '.join(heads)} | Cortex-M4F, instructions | by its manual |")
    for (core, waits, slots, stage), (instructions, _) in table.items():
        if (core, waits) == ("ibex", "0"):
            ratios = [cycles / count for count, cycles in (table[*column, slots, stage] for column in columns)]
            count, low, high = bounds[slots, stage]
            print(f"| N_s = {slots}, {stage} | {instructions} | " + " | ".join(f"{ratio:.2f}" for ratio in ratios)
                  + f" | {count} | {low / count:.2f} to {high / count:.2f} |")


table = measured()
predicted(table)
summary(table, bounded())
print(f"\n{len(failed)} checks failed" if failed else "\nall checks passed")
sys.exit(1 if failed else 0)
