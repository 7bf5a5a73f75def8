"""check_hoodoo_files.py SCREE_BAKE SCREE_INFO WORK

Recipes of hoodoos that name files beside them: pictures of joints and closed meshes are read, and what is wrong with one is said in
one line that names the key and the file. Prints what does not hold and exits with 1.
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


def png(rows):
    """A grey picture of 8 bits a pixel."""

    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    head = struct.pack(">IIBBBBB", len(rows[0]), len(rows), 8, 0, 0, 0, 0)
    pixels = zlib.compress(b"".join(b"\0" + bytes(row) for row in rows))
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", head) + chunk(b"IDAT", pixels) + chunk(b"IEND", b"")


def bake(name, start):
    recipe = {"kind": "hoodoo", "name": name, "voxel": 0.1, "size": [30, 20, 30], "start": start, "variants": 1, "ages": [1]}
    recipe.update({"durability": [[0, 1]], "lod_levels": 2})
    write(name + ".json", json.dumps(recipe))
    # From another folder, so that the file is looked for beside the recipe.
    return subprocess.run(
        [BAKE, os.path.join(WORK, name + ".json"), "-o", os.path.join(WORK, name + ".scree"), "-q"],
        capture_output=True, text=True, cwd="/", check=False
    )


def model(name):
    run = subprocess.run([INFO, "--json", os.path.join(WORK, name + ".scree")], capture_output=True, text=True, check=True)
    return json.loads(run.stdout)


def expect_refused(what, start, *said):
    run = bake("refused", start)
    expect(run.returncode == 2, f"{what}: exit status {run.returncode}")
    expect(run.stderr.count("\n") == 1 and all(word in run.stderr for word in ("start.file", *said)), f"{what}: {run.stderr!r}")
    expect(not os.path.exists(os.path.join(WORK, "refused.scree")), f"{what}: a pack was written")


shutil.rmtree(WORK, ignore_errors=True)
os.makedirs(os.path.join(WORK, "shapes"))

# A third of the ground carries rock of full height, a third half as high, a third none.
write("joints.png", png([[255, 128, 0]] * 2))
run = bake("map", {"shape": "joint_map", "file": "joints.png"})
expect(run.returncode == 0, f"a joint map: {run.stderr!r}")
if run.returncode == 0:
    found = model("map")
    volume, example = found["volume"]["mean"], found["examples"][0]
    expect(abs(volume - 3 * (1 * 2 + 1 * 1)) < 0.6, f"a joint map: volume {volume}")
    expect(abs(example["bounds_min"][0] + 1.5) < 0.1 and abs(example["bounds_max"][0] - 0.5) < 0.1, "a joint map: its sides")
    expect(abs(found["models"][0]["height"] - 2) < 0.1, f"a joint map: height {found['models'][0]['height']}")

corners = "v -1 0 -1\nv 1 0 -1\nv 1 0 1\nv -1 0 1\nv 0 1.5 0\n"
sides = "f 1 2 3 4\nf 1 5 2\nf 2 5 3\nf 3 5 4\nf 4 5 1\n"
write("shapes/pyramid.obj", corners + sides)
run = bake("mesh", {"shape": "mesh", "file": "shapes/pyramid.obj"})
expect(run.returncode == 0, f"a mesh: {run.stderr!r}")
if run.returncode == 0:
    found = model("mesh")
    expect(abs(found["volume"]["mean"] - 2) < 0.3, f"a mesh: volume {found['volume']['mean']}")
    expect(abs(found["models"][0]["footprint"] - 2**0.5) < 0.2, f"a mesh: footprint {found['models'][0]['footprint']}")

write("open.obj", corners + sides[:-len("f 4 5 1\n")])
write("text.png", "no picture")
write("black.png", png([[0, 0]]))
write("half.png", png([[255] * 40] * 40)[:60])
expect_refused("a missing picture", {"shape": "joint_map", "file": "nowhere.png"}, "nowhere.png")
expect_refused("text for a picture", {"shape": "joint_map", "file": "text.png"}, "text.png", "PNG")
expect_refused("half a picture", {"shape": "joint_map", "file": "half.png"}, "half.png")
expect_refused("a missing mesh", {"shape": "mesh", "file": "nowhere.obj"}, "nowhere.obj")
expect_refused("an open mesh", {"shape": "mesh", "file": "open.obj"}, "open.obj")
expect_refused("a mesh of no kind", {"shape": "mesh", "file": "text.png"}, "text.png")
run = bake("black", {"shape": "joint_map", "file": "black.png"})
expect(run.returncode == 2 and run.stderr.count("\n") == 1, f"a black picture: {run.returncode} {run.stderr!r}")

for fault in faults:
    print(fault)
sys.exit(1 if faults else 0)
