"""check_shard_files.py SCREE_BAKE SCREE_INFO WORK

Recipes of shards that name files beside them: meshes, height maps, recipes of hoodoos and stacks of images are read, and what is
wrong with one is said in one line that names the key and the file. Packs have the UVs of meshes. Prints what does not hold and exits
with 1; with 77 where all but the UVs was looked at, for want of python3-xxhash.
"""

import json
import os
import shutil
import struct
import subprocess
import sys
import zlib

from uv_cube import PLACES, SIDES, on_side

try:
    import pack_reader
except SystemExit:
    pack_reader = None

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


# The sides of the cube lie in an atlas of 3 x 2, each with a border, so that every edge is a seam.
def atlas(side, s, t, parts=None):
    """u and v, which runs down, at s, t of a side; of a file whose numbers count `parts` of 1."""
    ends = (side % 3 + 0.1) / 3, (side % 3 + 0.9) / 3, (side // 3 + 0.2) / 2, (side // 3 + 0.9) / 2
    left, right, top, bottom = (round(x * parts) / parts for x in ends) if parts else ends
    return left + (right - left) * s, top + (bottom - top) * t


CORNERS = ((0, 0), (1, 0), (1, 1), (0, 1))
UVS = [atlas(side, s, t) for side in range(6) for s, t in CORNERS]


def obj_cube(face, more=""):
    """face(vertex, vt) writes a corner; both count from 1."""
    lines = [f"v {x} {y} {z}" for x, y, z in PLACES] + [f"vt {u!r} {1 - v!r}" for u, v in UVS]
    lines += ["f " + " ".join(face(v + 1, 4 * side + k + 1) for k, v in enumerate(SIDES[side])) for side in range(6)]
    return "\n".join(lines) + "\n" + more


def glb_cube(component, numbers, form, **keys):
    """Vertices are not shared between sides. numbers: of TEXCOORD_0, packed by `form`."""
    parts = [struct.pack("<72f", *(x for side in SIDES for v in side for x in PLACES[v])), struct.pack(form, *numbers),
             struct.pack("<36H", *(4 * side + k for side in range(6) for k in (0, 1, 2, 0, 2, 3)))]
    accessors = [{"bufferView": 0, "componentType": 5126, "count": 24, "type": "VEC3", "min": [0, 0, 0], "max": [2, 2, 2]},
                 {"bufferView": 1, "componentType": component, "count": 24, "type": "VEC2", **keys},
                 {"bufferView": 2, "componentType": 5123, "count": 36, "type": "SCALAR"}]
    views = [{"buffer": 0, "byteOffset": sum(map(len, parts[:i])), "byteLength": len(part)} for i, part in enumerate(parts)]
    primitive = {"attributes": {"POSITION": 0, "TEXCOORD_0": 1}, "indices": 2}
    data = b"".join(parts)
    text = json.dumps({"asset": {"version": "2.0"}, "buffers": [{"byteLength": len(data)}], "bufferViews": views,
                       "accessors": accessors, "meshes": [{"primitives": [primitive]}], "nodes": [{"mesh": 0}],
                       "scenes": [{"nodes": [0]}], "scene": 0}).encode()
    text += b" " * (-len(text) % 4)
    body = struct.pack("<I4s", len(text), b"JSON") + text + struct.pack("<I4s", len(data), b"BIN\0") + data
    return struct.pack("<4sII", b"glTF", 2, 12 + len(body)) + body


def outside_of(pack, number):
    """Per triangle of an asset that is no cut: metres and UVs of its corners."""
    places, surface, uvs, triangles = pack.coarsest_of(number)
    ranges = list(zip(pack.uv_min, pack.uv_max))
    for triangle in triangles:
        cuts = [surface[v][0] % 16 == 2 for v in triangle]
        expect(all(cuts) or not any(cuts), f"asset {number}: a triangle is half a cut")
        if not any(cuts):
            yield [([x / pack.lattice_per_cell for x in places[v]],
                    [low + (high - low) * t / 65535 for t, (low, high) in zip(uvs[v], ranges)]) for v in triangle]


def expect_uvs(name, file, clip="mesh", parts=None):
    """What stands has the UVs of the file to within a step of the pack. Cut by mesh, it has the file's own triangles until something
    falls."""
    pack = pack_of(name, {"clip": clip, **mesh(file)})
    if pack is None:
        return
    step = max(high - low for low, high in zip(pack.uv_min, pack.uv_max)) / 65535
    found = []
    for time in range(2):
        # Places that are not of the file are rounded to the lattice.
        close = step + (1 / 4096 if time > 0 or clip != "mesh" else 0)
        sides = [0] * 6
        for corners in outside_of(pack, time):
            # The middle of the cube is at x = z = 0.
            places = [(x + 1, y, z + 1) for (x, y, z), _ in corners]
            side = next((i for i, quad in enumerate(SIDES) if all(on_side(quad, p)[2] < 1e-9 for p in places)), None)
            expect(side is not None, f"{name}: a triangle that is on no side")
            if side is None:
                continue
            sides[side] += 1
            for place, (_, uv) in zip(places, corners):
                want = atlas(side, *on_side(SIDES[side], place)[:2], parts)
                expect(max(abs(a - b) for a, b in zip(uv, want)) <= close, f"{name}: at {time}, {place}: {uv}, not {want}")
        found.append(sides)
    expect(clip != "mesh" or found[0] == [2] * 6, f"{name}: triangles of sides {found[0]}")
    expect(min(found[0]) >= 2 and found[1] != found[0] and sum(found[1]) > 12, f"{name}: nothing fell: {found[1]}")


def expect_no_uvs(name, members):
    pack = pack_of(name, members)
    for corners in outside_of(pack, 0) if pack else []:
        expect(all(uv == corners[0][1] for _, uv in corners), f"{name}: UVs out of nowhere")


def pack_of(name, members):
    """None without the second reader."""
    if pack_reader is None:
        return None
    run = bake(name, {"lod_levels": 1, "seeds": {"count": 60}, "paths": [0, 3000], "lattice_per_metre": 1024, **members})
    expect(run.returncode == 0, f"{name}: {run.stderr!r}")
    if run.returncode != 0:
        return None
    with open(os.path.join(WORK, name + ".scree"), "rb") as stream:
        return pack_reader.Pack(stream.read())


def mesh(file, **keys):
    return {"input": {"shape": "mesh", "file": file, **keys}}


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
expect_refused("a mesh too small", {"input": {"shape": "mesh", "file": "shapes/pyramid.obj", "scale": 1e-6}}, "input:", "too small", "lattice")
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

write("cube.obj", obj_cube("{}/{}".format))
write("back.obj", obj_cube(lambda v, t: f"{v - 9}/{t - 25}/1"))
write("partly.obj", obj_cube(lambda v, t: f"{v}/{t}" if t != 24 else f"{v}"))
flat = [x for uv in UVS for x in uv]
write("cube.glb", glb_cube(5126, flat, "<48f"))
write("shorts.glb", glb_cube(5123, [round(x * 65535) for x in flat], "<48H", normalized=True))
write("bytes.glb", glb_cube(5121, [round(x * 255) for x in flat], "<48B", normalized=True))
for clip in ("auto", "walls", "mesh"):
    expect_uvs("uvs_of_obj_" + clip, "cube.obj", clip)
expect_uvs("uvs_from_the_end", "back.obj")
expect_uvs("uvs_of_glb", "cube.glb")
expect_uvs("uvs_of_shorts", "shorts.glb", parts=65535)
expect_uvs("uvs_of_bytes", "bytes.glb", parts=255)
expect_no_uvs("uvs_in_part", mesh("partly.obj"))
expect_no_uvs("uvs_remeshed", mesh("cube.obj", resolution=16))

write("beyond.obj", obj_cube(lambda v, t: f"{v}/{t + 1}"))
write("not_a_number.obj", obj_cube("{}/{}".format, "vt 0 nan\n"))
write("too_large.obj", obj_cube("{}/{}".format, "vt 1e39 0\n"))
write("huge.obj", obj_cube("{}/{}".format).replace("vt ", "vt 1e", 1).replace("vt 1e0.0", "vt 1e30 0 #", 1))
write("short.glb", glb_cube(5126, flat[2:], "<46f"))
write("not_a_number.glb", glb_cube(5126, [*flat[:-1], float("nan")], "<48f"))
write("not_normal.glb", glb_cube(5121, [1] * 48, "<48B"))
expect_refused("a vt that is not there", mesh("beyond.obj"), "input.file", "beyond.obj: line 38", "vt")
expect_refused("a vt that is no number", mesh("not_a_number.obj"), "input.file", "not_a_number.obj: line 39", "number")
expect_refused("a vt too large for a float", mesh("too_large.obj"), "input.file", "too_large.obj: line 39", "number")
expect_refused("a vt too large for a pack", mesh("huge.obj"), "input:", "huge.obj", "triangle 0", "1e+30")
expect_refused("too few UVs", mesh("short.glb"), "input.file", "short.glb", "accessor")
expect_refused("a UV that is no number", mesh("not_a_number.glb"), "input.file", "not_a_number.glb", "TEXCOORD_0")
expect_refused("UVs that are whole numbers", mesh("not_normal.glb"), "input.file", "not_normal.glb", "TEXCOORD_0")
run = bake("huge_made_anew", mesh("huge.obj", resolution=16))
expect(run.returncode == 0, f"UVs that remeshing drops: {run.stderr!r}")

run = bake("idle", {"states": [{"where": "base"}, {"where": "box", "min": [0, 900, 0], "max": [1, 901, 1]}]})
expect(run.returncode == 0 and "idle.json: warning: states[1]: no shard lies there" in run.stderr and run.stderr.count("\n") == 1,
       f"a region without shards: {run.stderr!r}")

run = subprocess.run([BAKE, os.path.join(WORK, "mesh.json"), "--print-recipe", "--set", "seeds.count=7"], capture_output=True,
                     text=True, check=False)
expect(run.returncode == 0 and json.loads(run.stdout)["seeds"]["count"] == 7, f"--set: {run.stderr!r}")

for fault in faults:
    print(fault)
if pack_reader is None and not faults:
    print("skipped: UVs of packs, for want of python3-xxhash")
    sys.exit(77)
sys.exit(1 if faults else 0)
