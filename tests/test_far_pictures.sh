#!/usr/bin/env bash
# The far field looks like the rocks that it stands for, within the limits of far_pictures.c.
#   test_far_pictures.sh BIN RECIPE WORK
# Ends with status 77 when the machine lacks what it needs.
set -euo pipefail
bin=$1 recipe=$2 work=$3
rm -rf "$work" && mkdir -p "$work" && cd "$work"
"$bin/scree-bake" "$recipe" -q -o small.scree
"$bin/far_pictures" small.scree -s 200 112 -t
