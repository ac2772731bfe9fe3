"""image.py ELF: the program's words at their addresses from 0x40000000 on, in the format of $readmemh."""
import struct
import sys

BASE, BYTES = 0x40000000, 1 << 24
elf = open(sys.argv[1], "rb").read()
memory = bytearray(BYTES)
end = 0
offset, (size, count) = struct.unpack_from("<I", elf, 28)[0], struct.unpack_from("<HH", elf, 42)
for k in range(count):
    kind, at, _, load, length = struct.unpack_from("<5I", elf, offset + k * size)
    if kind == 1 and length:
        begin = load - BASE
        assert 0 <= begin and begin + length <= BYTES, f"{load:#x}"
        memory[begin:begin + length] = elf[at:at + length]
        end = max(end, begin + length)
print("\n".join(f"{word:08x}" for (word,) in struct.iter_unpack("<I", memory[:(end + 3) // 4 * 4])))
