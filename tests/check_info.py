#!/usr/bin/python3
"""scree-info as a program: its output against the second reader, its exit status and messages for bad input, and its .glb.

usage: check_info.py SCREE-INFO SCREE-BAKE RECIPE WORK-FOLDER WRITE-PACK

Leaves WORK-FOLDER/info.glb for the glTF validator. Prints what does not hold and exits with 1."""

import json
import os
import shutil
import struct
import subprocess
import sys

INFO, BAKE, RECIPE, WORK, WRITE_PACK = sys.argv[1:6]
READER = os.path.join(os.path.dirname(os.path.abspath(__file__)), "pack_reader.py")
faults = []


def expect(condition, what):
    if not condition:
        faults.append(what)


def info(*arguments):
    return subprocess.run([INFO, *arguments], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)


def expect_refused(what, named, *arguments):
    result = info(*arguments)
    expect(result.returncode == 2, f"{what}: exit status {result.returncode} instead of 2")
    expect(result.stdout == "", f"{what}: something was printed")
    expect(result.stderr.count("\n") == 1 and named in result.stderr, f"{what}: not one line naming {named}: {result.stderr!r}")


def write(name, data):
    path = os.path.join(WORK, name)
    with open(path, "wb") as file:
        file.write(data)
    return path


shutil.rmtree(WORK, ignore_errors=True)
os.makedirs(WORK)
pack = os.path.join(WORK, "small.scree")
subprocess.run([BAKE, RECIPE, "-o", pack, "--quiet"], check=True)
with open(pack, "rb") as file:
    good = file.read()

# What it says is what the second reader reads.
result = info(pack)
expect(result.returncode == 0 and result.stderr == "", f"a good pack: {result.returncode} {result.stderr!r}")
expect("all digests are right" in result.stdout, "a good pack: the digests are not said to be right")
reader = subprocess.run(["/usr/bin/python3", READER, pack, "--info", INFO], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
if reader.returncode == 77:
    print(reader.stdout)
    sys.exit(77)
expect(reader.returncode == 0, f"the second reader: {reader.stdout}")

# Models, too.
models = os.path.join(WORK, "hoodoo.scree")
subprocess.run([BAKE, os.path.join(os.path.dirname(RECIPE), "small_hoodoo.json"), "-o", models, "--quiet"], check=True)
result = info(models)
expect(result.returncode == 0 and result.stderr == "", f"models: {result.returncode} {result.stderr!r}")
expect("4 models: 2 variants" in result.stdout and "footprint" in result.stdout, "models: variants and footprints are not shown")
reader = subprocess.run(["/usr/bin/python3", READER, models, "--info", INFO], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
expect(reader.returncode == 0, f"the second reader of models: {reader.stdout}")
result = info(models, "--glb", os.path.join(WORK, "models.glb"), "--assets", "0-3", "--lod", "1")
expect(result.returncode == 0, f"--glb of models: {result.stderr!r}")
os.remove(os.path.join(WORK, "models.glb"))

# A cliff, too.
cliff = os.path.join(WORK, "cliff.scree")
subprocess.run([WRITE_PACK, cliff, "cliff"], check=True)
result = info(cliff)
expect(result.returncode == 0 and result.stderr == "", f"a cliff: {result.returncode} {result.stderr!r}")
expect("a cliff at 2 times, 3 blocks that fell, 20 placements" in result.stdout, "a cliff: times, blocks and placements are not shown")
expect("3 blocks of" in result.stdout and "UVs of -1 .. 1, 0 .. 2" in result.stdout, "a cliff: sizes and UVs are not shown")
expect("all digests are right" in result.stdout, "a cliff: the digests are not said to be right")
reader = subprocess.run(["/usr/bin/python3", READER, cliff, "--info", INFO], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
expect(reader.returncode == 0, f"the second reader of a cliff: {reader.stdout}")
with open(cliff, "rb") as file:
    bytes_of_cliff = file.read()
for place in (20, len(bytes_of_cliff) - 5, len(bytes_of_cliff) // 2):
    name = f"cliff-{place}.scree"
    expect_refused(f"byte {place} of a cliff changed", name,
                   write(name, bytes_of_cliff[:place] + bytes([bytes_of_cliff[place] ^ 4]) + bytes_of_cliff[place + 1 :]))

# Bad packs. The blobs are the last section, so the end of the file is in a mesh.
expect_refused("a missing file", "nowhere.scree", os.path.join(WORK, "nowhere.scree"))
expect_refused("a folder", WORK, WORK)
expect_refused("an empty file", "empty.scree", write("empty.scree", b""))
expect_refused("another file", "other.scree", write("other.scree", b"glTF" * 100))
expect_refused("half a pack", "half.scree", write("half.scree", good[: len(good) // 2]))
expect_refused("another version", "version.scree", write("version.scree", good[:8] + struct.pack("<I", 1) + good[12:]))
for place in (20, 100, len(good) // 3, len(good) - 5):
    name = f"changed-{place}.scree"
    expect_refused(f"byte {place} changed", name, write(name, good[:place] + bytes([good[place] ^ 4]) + good[place + 1 :]))

# Bad arguments leave nothing behind.
glb = os.path.join(WORK, "info.glb")
expect_refused("no pack", "pack is missing")
expect_refused("an unknown option", "--frobnicate", pack, "--frobnicate")
expect_refused("assets that are not there", "--assets", pack, "--glb", glb, "--assets", "0-99999999")
expect_refused("assets in reverse", "--assets", pack, "--glb", glb, "--assets", "5-2")
expect_refused("no range of assets", "--assets", pack, "--glb", glb, "--assets", "some")
expect_refused("a level that is not there", "--lod", pack, "--glb", glb, "--lod", "9")
expect_refused("assets without --glb", "--glb", pack, "--assets", "0-1")
expect_refused("a .glb in no folder", "no/such.glb", pack, "--glb", os.path.join(WORK, "no/such.glb"))
expect(not os.path.exists(glb), "a refused command wrote a file")

# A good .glb, of other assets at another level; and only that file is new.
before = set(os.listdir(WORK))
result = info(pack, "--json", "--glb", glb, "--assets", "10-18", "--lod", "1")
expect(result.returncode == 0, f"--glb: {result.stderr!r}")
expect(set(os.listdir(WORK)) - before == {"info.glb"}, "--glb left something else behind")
with open(glb, "rb") as file:
    head = struct.unpack("<4sII", file.read(12))
    length, kind = struct.unpack("<I4s", file.read(8))
    tree = json.loads(file.read(length))
expect(head == (b"glTF", 2, os.path.getsize(glb)) and kind == b"JSON", "--glb: not a .glb")
expect(sum("mesh" in node for node in tree["nodes"]) == 9, "--glb: not one node for each rock")
expect("extensionsRequired" not in tree, "--glb: requires an extension")
expect(all("NORMAL" in p["attributes"] for mesh in tree["meshes"] for p in mesh["primitives"]), "--glb: no normals")

expect(info("--version").stdout.startswith("scree-info "), "--version")
expect("usage: scree-info" in info("--help").stdout, "--help")

for fault in faults:
    print(fault)
sys.exit(1 if faults else 0)
