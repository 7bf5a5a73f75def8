#!/usr/bin/python3
"""A second reader of edits, written from docs/edits_format.md and from nothing else.

usage: edits_reader.py FILE                prints one line a layer and one line an edit, or the rule that does not hold
       edits_reader.py --cases FOLDER      FOLDER/good.bin must read as good.txt says; each case of cases.bin must end with the code
                                           before it (written by test_edits_delta)

Needs python3-xxhash."""

import pathlib
import struct
import sys

try:
    import xxhash
except ImportError:
    print("skipped: python3-xxhash is not installed")
    sys.exit(77)

MAGIC = bytes([0x89, 0x53, 0x45, 0x44, 0x0D, 0x0A, 0x1A, 0x0A])


class Bad(Exception):
    pass


def check(condition, code):
    if not condition:
        raise Bad(code)


def read(data):
    check(data[:8] == MAGIC[:len(data)], "NOT_A_PACK")
    check(len(data) >= 24, "TRUNCATED")
    version, layers, edits = struct.unpack_from("<IIQ", data, 8)
    check(version == 1, "VERSION")
    check(layers <= 65536 and edits < 2**59, "CORRUPT")
    end = 24 + 64 * layers + 16 * edits
    check(len(data) >= end + 8, "TRUNCATED")
    check(len(data) == end + 8, "CORRUPT")
    check(struct.unpack_from("<Q", data, end)[0] == xxhash.xxh3_64_intdigest(data[:end]), "DIGEST")

    result = []
    at = 24 + 64 * layers
    key_before = -1
    for layer in range(layers):
        start = 24 + 64 * layer
        key, zeros, count, pack, seed = struct.unpack_from("<H6sQQQ", data, start)
        cell_size, *origin = struct.unpack_from("<4d", data, start + 32)
        check(key > key_before and zeros == bytes(6) and count >= 1, "CORRUPT")
        key_before = key
        check(count <= (end - at) // 16, "CORRUPT")
        before = None
        found = []
        for _ in range(count):
            x, y, z, local, state, zero = struct.unpack_from("<3iHBB", data, at)
            at += 16
            check(state in (1, 2) and zero == 0, "CORRUPT")
            place = (z, y, x, local)
            check(before is None or before < place, "CORRUPT")
            before = place
            found.append((x, y, z, local, state))
        result.append((key, pack, seed, cell_size, origin, found))
    check(at == end, "CORRUPT")
    return result


def bits(value):
    return struct.pack(">d", value).hex()


def text(data):
    lines = []
    for key, pack, seed, cell_size, origin, edits in read(data):
        lines.append(f"layer {key} {pack:016x} {seed:016x} {bits(cell_size)} " + " ".join(map(bits, origin)))
        lines += ["edit " + " ".join(map(str, edit)) for edit in edits]
    return "".join(line + "\n" for line in lines)


def check_cases(folder):
    if text((folder / "good.bin").read_bytes()) != (folder / "good.txt").read_text():
        print("good.bin does not read as good.txt says")
        return 1
    data = (folder / "cases.bin").read_bytes()
    at = count = 0
    seen = {}
    while at < len(data):
        line = data.index(b"\n", at)
        code, size = data[at:line].decode().split()
        at = line + 1
        try:
            read(data[at:at + int(size)])
            found = "OK"
        except Bad as bad:
            found = str(bad)
        if found != code:
            print(f"case {count}: {found}, but the library says {code}")
            return 1
        seen[code] = seen.get(code, 0) + 1
        at += int(size)
        count += 1
    print(f"{count} cases:", seen)
    return 0 if len(seen) == 6 else 1


def main():
    if sys.argv[1] == "--cases":
        return check_cases(pathlib.Path(sys.argv[2]))
    with open(sys.argv[1], "rb") as file:
        data = file.read()
    try:
        print(text(data), end="")
    except Bad as bad:
        print(bad)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
