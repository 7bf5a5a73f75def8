#!/usr/bin/env bash
# scree-example under Xvfb: it fills the lower half of its picture with rock, and makes no mistake that OpenGL sees.
#   test_example.sh BIN RECIPE WORK
# Ends with status 77 when the machine lacks what it needs.
set -euo pipefail
bin=$1 recipe=$2 work=$3
lines=$(wc -l <"$(dirname "${BASH_SOURCE[0]}")/../demo/example_stream.c")
((lines <= 150)) || { echo "example_stream.c has $lines lines, not at most 150" && exit 1; }
command -v xvfb-run >/dev/null || exit 77
rm -rf "$work" && mkdir -p "$work" && cd "$work"

"$bin/scree-bake" "$recipe" -q -o small.scree
xvfb-run -a "$bin/scree-example" small.scree 24 picture.ppm || {
  [[ $? == 1 ]] && xvfb-run -a "$bin/scree-example" small.scree 1 picture.ppm 2>&1 | grep -q 'no window with OpenGL 4.5' && exit 77
  exit 1
}
/usr/bin/python3 - <<'PYTHON'
header, pixels = open("picture.ppm", "rb").read().split(b"\n", 1)
_, width, height, _ = header.split()
width, height = int(width), int(height)
assert len(pixels) == 3 * width * height, len(pixels)
rows = [pixels[3 * width * y : 3 * width * (y + 1)] for y in range(height)]
sky = rows[0][:3]
stone = [sum(row[3 * x : 3 * x + 3] != sky for x in range(width)) / width for row in rows]
upper, lower = sum(stone[: height // 4]) / (height // 4), sum(stone[-height // 4 :]) / (height // 4)
colours = {row[3 * x : 3 * x + 3] for row in rows[::4] for x in range(0, width, 4)}
print(f"stone: {upper:.0%} of the uppermost quarter, {lower:.0%} of the lowest; {len(colours)} colours")
assert upper < 0.05 and lower > 0.9 and len(colours) > 1000
PYTHON
if "$bin/scree-example" 2>/dev/null; then exit 1; fi # without a pack
