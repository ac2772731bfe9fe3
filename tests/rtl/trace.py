"""Counts a program's instructions by class and stage from QEMU's log of executed blocks (`-d in_asm,exec,nochain`), read from stdin.

trace.py PROGRAM > COUNTS    a line `count <mark> <class> <number>` each

A stage begins at mark 31 or 63 and ends at its own (firmware-sim/src/bin/cycles.rs). report.py has what the classes cost.
"""
import collections
import re
import struct
import sys


def symbol(elf, wanted):
    """A symbol's address."""
    first, (size, count) = struct.unpack_from("<I", elf, 32)[0], struct.unpack_from("<HH", elf, 46)
    sections = [struct.unpack_from("<10I", elf, first + k * size) for k in range(count)]
    for _, kind, _, _, at, length, link, *_ in sections:
        for entry in range(at, at + length, 16) if kind == 2 else []:
            name, value = struct.unpack_from("<II", elf, entry)
            if elf.startswith(wanted + b"\0", sections[link][4] + name):
                return value
    sys.exit(f"no symbol {wanted.decode()}")


ELF = open(sys.argv[1], "rb").read()
MARKS = symbol(ELF, b"firmware_marks") & ~1
RISCV = ELF[18] == 243
ENTRIES = {MARKS + 4 * k: k for k in range(64)}
BEGIN = (31, 63)


def riscv(code, _text):
    """The class of an instruction."""
    word = int(code, 16)
    opcode, function, seven, quarter = word & 0x7F, word >> 12 & 7, word >> 25, word & 3
    if quarter == 3:
        if opcode == 0x33 and seven == 1:
            return "multiply" if function == 0 else "multiply-high" if function < 4 else "divide"
        return {0x03: "load", 0x23: "store", 0x63: "branch", 0x6F: "jump", 0x67: "jump"}.get(opcode, "alu")
    function = word >> 13
    if quarter == 1:
        return "jump" if function in (1, 5) else "branch" if function in (6, 7) else "alu"
    if function in (2, 6):
        return "load" if function == 2 else "store"
    if quarter == 2 and function == 4 and not word >> 2 & 31 and word >> 7 & 31:
        return "jump"
    return "alu"


# The first that matches the mnemonic.
ARM = [(re.compile(pattern), name) for pattern, name in [
    (r"it[te]*$", "it"),
    (r"(tbb|tbh)", "table-branch"),
    (r"v(ldm|stm|push|pop)|(ldm|stm|push|pop|ldrd|strd)", "multiple"),
    (r"vldr", "fp-load"),
    (r"vstr", "fp-store"),
    (r"v(fma|fms|fnma|fnms|mla|mls|nmla|nmls)", "fp-multiply-add"),
    (r"v(div|sqrt)", "fp-divide"),
    (r"vmov", "fp-move"),
    (r"v", "fp"),
    (r"(ldr)", "load"),
    (r"(str)(?!ex)", "store"),
    (r"(sdiv|udiv)", "divide"),
    (r"(mul|mla|mls|smul|smla|smm|smu|sml|umul|umla|uma)", "multiply"),
    (r"(b|bl|bx|blx|cbz|cbnz)(eq|ne|hs|lo|mi|pl|vs|vc|hi|ls|ge|lt|gt|le)?(\.w)?$", "branch"),
    (r"", "alu"),
]]


def arm(_code, text):
    name, _, operands = text.partition(" ")
    kind = next(kind for pattern, kind in ARM if pattern.match(name))
    if kind == "fp-move" and not re.search(r"\b(r\d+|lr|sb|sl|fp|ip)\b", operands):
        return "fp"
    if kind in ("fp-load", "fp-store") and operands.lstrip().startswith("d"):
        return kind + "-double"
    return kind


def registers(operands):
    """How many registers a list names, two without a list; one of 64 bits counts as two."""
    if "{" not in operands:
        return 2
    count = 0
    for part in operands[operands.index("{") + 1:operands.index("}")].split(","):
        first, _, last = part.strip().partition("-")
        number = int(last[1:]) - int(first[1:]) + 1 if last else 1
        count += number * (2 if first.startswith("d") else 1)
    return count


def stalls(before, text):
    """What an instruction adds where it uses the result of the one before it, or lies beside the program."""
    name, _, operands = text.partition(" ")
    kind, result = arm("", before), before.partition(" ")[2].split(",")[0].strip()
    memory = re.search(r"\[([^\]]*)\]", operands)
    used = memory[1] if memory else operands.split("{")[0] if name.startswith(("ldm", "stm", "vldm", "vstm")) else ""
    found = {}
    if kind in ("alu", "multiply", "divide") and result and re.search(rf"\b{result}\b", used):
        found["address-after"] = 1
    if kind in ("fp", "fp-multiply-add", "fp-divide") and result and re.search(rf"\b{result}\b", operands):
        found["fp-after"] = 1
    if name.startswith("ldr") and used.startswith("pc"):
        found["literal"] = 1
    return found


def classes(block):
    """Counts of a block, without what follows from the address after it."""
    counts = collections.Counter()
    conditional, before, line = 0, "", ""
    for _, code, text in block:
        kind, prefix = (riscv if RISCV else arm)(code, text), ""
        if not RISCV:
            counts.update(stalls(line, text))
        if conditional:
            conditional -= 1
            if kind not in ("alu", "fp", "multiply", "branch"):
                prefix = "conditional-"
        elif not RISCV and kind == "load" and before in ("load", "load-after"):
            kind = "load-after"
        if kind == "it":
            conditional = len(text.split()[0]) - 1
        if kind == "multiple":
            counts[prefix + "register"] += registers(text)
        counts[prefix + kind] += 1
        before, line = kind, text
    return counts


def transition(block, after, target):
    """What the address after a block adds."""
    at, code, text = block[-1]
    through = at + len(code) // 2
    if not RISCV:
        return {} if after == through else {"refill": 1}
    if after == through:
        return {}
    split = {"split-target": 1} if after % 4 and len(target[0][1]) == 8 else {}
    return split if riscv(code, text) == "jump" else {"taken": 1, **split}


def main():
    blocks, block = {}, []
    stages = collections.defaultdict(collections.Counter)
    events = collections.Counter()
    edges, before = None, None
    for line in sys.stdin:
        if line.startswith("Trace"):
            at = int(line.split("/", 2)[1], 16)
            number = ENTRIES.get(at)
            if edges is not None:
                edges[before, at] += 1
            if number is not None:
                if number in BEGIN:
                    edges = collections.Counter()
                elif edges is not None:
                    stages[number].update(edges)
                    events[number] += 1
                    edges = None
            before = at
        elif line.startswith("0x"):
            address, _, rest = line.partition(":")
            code, text = re.match(r"\s*((?:[0-9a-f]{4} )*[0-9a-f]{4,8})\s+(.*)", rest).groups()
            block.append((int(address, 16), code.replace(" ", ""), text.strip()))
            blocks[block[0][0]] = block
        else:
            block = []
    totals = {}
    for number, edges in sorted(stages.items()):
        totals[number] = counts = collections.Counter()
        for (at, after), times in edges.items():
            if at in ENTRIES:
                continue
            found = classes(blocks[at]) + collections.Counter(transition(blocks[at], after, blocks[after]))
            for name, count in found.items():
                counts[name] += times * count
            counts["instructions"] += times * len(blocks[at])
    for number, counts in totals.items():
        # what measuring itself needs
        for name, count in totals[number // 32 * 32].items() if number % 32 else []:
            counts[name] -= count * events[number] // events[number // 32 * 32]
        for name, count in sorted(counts.items()):
            print("count", number, name, count)


if __name__ == "__main__":
    main()
