"""check_shard_files.py SCREE_BAKE SCREE_INFO WORK

Recipes of shards that name files beside them: meshes, height maps, recipes of hoodoos and stacks of images are read, and what is
wrong with one is said in one line that names the key and the file. Prints what does not hold and exits with 1.
"""

import json
import os
import shutil
import struct
import subprocess
import sys
import zlib

BAKE, INFO, WORK = sys.argv[1:4]
faults = []


def expect(condition, what):
    if not condition:
        faults.append(what)


def write(name, data):
    with open(os.path.join(WORK, name), "wb") as file:
        file.write(data if isinstance(data, bytes) else data.encode())


def png(rows, bits):
    """A grey picture of 8 or 16 bits a pixel."""

    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    head = struct.pack(">IIBBBBB", len(rows[0]), len(rows), bits, 0, 0, 0, 0)
    form = ">H" if bits == 16 else ">B"
    pixels = zlib.compress(b"".join(b"\0" + b"".join(struct.pack(form, value) for value in row) for row in rows))
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", head) + chunk(b"IDAT", pixels) + chunk(b"IEND", b"")


def bake(name, members):
    recipe = {"kind": "shards", "name": name, "seeds": {"count": 40}, "paths": [0, 300], "lod_levels": 2}
    recipe.update(members)
    write(name + ".json", json.dumps(recipe))
    # From another folder, so that files are looked for beside the recipe.
    return subprocess.run(
        [BAKE, os.path.join(WORK, name + ".json"), "-o", os.path.join(WORK, name + ".scree"), "-q", "--report", "-"],
        capture_output=True, text=True, cwd="/", check=False
    )


def expect_baked(name, members, volume, tolerance):
    run = bake(name, members)
    expect(run.returncode == 0, f"{name}: {run.stderr!r}")
    if run.returncode != 0:
        return
    report = json.loads(run.stdout)
    expect(report["recipe"] == name and report["times"] == 2 and report["paths"] == 300, f"{name}: report {report}")
    expect(report["assets"] == report["times"] + report["blocks"], f"{name}: assets {report}")
    info = subprocess.run([INFO, "--json", os.path.join(WORK, name + ".scree")], capture_output=True, text=True, check=True)
    found = json.loads(info.stdout)
    expect(found["digest"] == report["digest"], f"{name}: digest")
    largest = found["volume"]["greatest"]
    expect(abs(largest - volume) <= tolerance, f"{name}: volume {largest} instead of {volume}")


def expect_refused(what, members, *said):
    run = bake("refused", members)
    expect(run.returncode == 2, f"{what}: exit status {run.returncode}")
    expect(run.stderr.count("\n") == 1 and all(word in run.stderr for word in said), f"{what}: {run.stderr!r}")
    expect(not os.path.exists(os.path.join(WORK, "refused.scree")), f"{what}: a pack was written")


shutil.rmtree(WORK, ignore_errors=True)
os.makedirs(os.path.join(WORK, "shapes"))
corners = "v -1 0 -1\nv 1 0 -1\nv 1 0 1\nv -1 0 1\nv 0 1.5 0\n"
sides = "f 1 2 3 4\nf 1 5 2\nf 2 5 3\nf 3 5 4\nf 4 5 1\n"
write("shapes/pyramid.obj", corners + sides)
write("open.obj", corners + sides[:-len("f 4 5 1\n")])
write("crossing.obj", corners + sides + corners.replace("v 0 1.5 0", "v 0.3 0.7 0.1").replace("v 1 0 1", "v 1.4 0.2 1.3") +
      sides.translate(str.maketrans("12345", "67890")).replace("0", "10"))
write("text.png", "no picture")
write("heights.png", png([[0, 0, 0], [0, 65535, 0], [0, 0, 0]], 16))
write("slices.png", png([[0, 255], [255, 0], [9, 9], [200, 100]], 8))
write("goblin.json", json.dumps({"kind": "hoodoo", "size": [40, 32, 40], "start": {"radius": 11}, "variants": 2, "ages": [0.8]}))
write("bad.json", json.dumps({"kind": "hoodoo", "sise": [40, 32, 40]}))

expect_baked("mesh", {"input": {"shape": "mesh", "file": "shapes/pyramid.obj", "scale": 2}}, 16, 0.1)
terrain = {"shape": "terrain", "file": "heights.png", "spacing": 2, "low": 0, "high": 3, "base": -1}
expect_baked("terrain", {"input": terrain}, 16 + 3 * 4, 4.1)
expect_baked("hoodoo", {"input": {"shape": "hoodoo", "file": "goblin.json", "variant": 1, "age": 0, "lod": 1}}, 0.9, 0.8)
images = {"images": {"file": "slices.png", "slices": 2}, "resistance": {"kind": "images"}}
expect_baked("images", {"input": {"shape": "box", "size": [2, 3, 4]}, **images}, 24, 0.1)

expect_refused("a missing mesh", {"input": {"shape": "mesh", "file": "nowhere.obj"}}, "input.file", "nowhere.obj")
expect_refused("a mesh of no kind", {"input": {"shape": "mesh", "file": "text.png"}}, "input.file", "text.png")
expect_refused("an open mesh", {"input": {"shape": "mesh", "file": "open.obj"}}, "input:")
expect_refused("a mesh that crosses itself", {"input": {"shape": "mesh", "file": "crossing.obj"}}, "input:")
expect_refused("a missing height map", {"input": {**terrain, "file": "nowhere.png"}}, "input.file", "nowhere.png")
expect_refused("text for a height map", {"input": {**terrain, "file": "text.png"}}, "input.file", "text.png")
expect_refused("a height map of 8 bits", {"input": {**terrain, "file": "slices.png"}}, "input.file", "slices.png")
expect_refused("a crop outside", {"input": {**terrain, "crop": [2, 2, 5, 5]}}, "input.file", "heights.png", "crop")
expect_refused("a base above the ground", {"input": {**terrain, "base": 1}}, "input:", "base")
expect_refused("a missing recipe", {"input": {"shape": "hoodoo", "file": "nowhere.json"}}, "input.file", "nowhere.json")
expect_refused("a wrong recipe", {"input": {"shape": "hoodoo", "file": "bad.json"}}, "input.file", "bad.json", "sise")
expect_refused("an age too many", {"input": {"shape": "hoodoo", "file": "goblin.json", "age": 1}}, "input:", "age 1")
expect_refused("missing images", {"images": {"file": "nowhere.png"}}, "images.file", "nowhere.png")
expect_refused("images that do not fit", {"images": {"file": "slices.png", "slices": 3}}, "images.slices", "slices.png")
expect_refused("a support", {"input": {"shape": "support"}}, "input.shape", "support")
expect_refused("a share out of reach", {"paths": [0], "shares": [0.5]}, "shares", "not both")

run = subprocess.run([BAKE, os.path.join(WORK, "mesh.json"), "--print-recipe", "--set", "seeds.count=7"], capture_output=True,
                     text=True, check=False)
expect(run.returncode == 0 and json.loads(run.stdout)["seeds"]["count"] == 7, f"--set: {run.stderr!r}")

for fault in faults:
    print(fault)
sys.exit(1 if faults else 0)
