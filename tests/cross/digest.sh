#!/bin/sh
# digest.sh WORK GOLDEN INPUTS COMPILER LEVEL [RUNNER]
# Compiles digest_small with one compiler and optimisation level, runs it (RUNNER: an emulator for another CPU), and compares what
# it prints with the golden file. INPUTS is made by CMake: `flag F`, `include DIR`, `source FILE`, one a line.
set -eu
work=$1 golden=$2 inputs=$3 compiler=$4 level=$5 runner=${6:-}

rm -rf "$work"
mkdir -p "$work/include"
# xxHash is one header; a cross compiler must not see the rest of /usr/include.
cp /usr/include/xxhash.h "$work/include/"

flags="-std=c11 -I$work/include $(sed -n 's/^flag //p; s/^include /-I/p' "$inputs" | tr '\n' ' ')"
wide=
case $("$compiler" -dumpmachine) in
  x86_64*) wide=yes flags="$flags -DSCREE_WIDE_KERNELS" ;;
esac
link=
[ -z "$runner" ] || link=-static

sed -n 's/^source //p' "$inputs" | while IFS= read -r source; do
  extra=
  case $source in
    *_avx2.c)
      [ -n "$wide" ] || continue
      extra=-mavx2
      ;;
  esac
  # shellcheck disable=SC2086 # flags are words
  "$compiler" $flags $level $extra -c "$source" -o "$work/$(basename "$source").o"
done
# shellcheck disable=SC2086
"$compiler" $link "$work"/*.o -lm -o "$work/digest_small"

# shellcheck disable=SC2086
$runner "$work/digest_small" >"$work/digests.txt"
if ! cmp -s "$golden" "$work/digests.txt"; then
  echo "$compiler $level $runner: the digests are not those of $golden"
  diff "$golden" "$work/digests.txt" || true
  echo "if the bits were meant to change, the file is now:"
  cat "$work/digests.txt"
  exit 1
fi
