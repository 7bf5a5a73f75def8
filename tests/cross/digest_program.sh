#!/bin/sh
# digest_program.sh SCREE_BAKE RECIPE GOLDEN WORK THREADS
# The program, with Draco and several threads, gives the digest that digest_small gives without either.
set -eu
bake=$1 recipe=$2 golden=$3 work=$4 threads=$5
mkdir -p "$work"
"$bake" "$recipe" -o "$work/small-$threads.scree" --threads "$threads" --quiet --report "$work/small-$threads.json"
digest=$(sed -n 's/.*"digest": "\([0-9a-f]*\)".*/\1/p' "$work/small-$threads.json")
if ! grep -qx "pack $digest" "$golden"; then
  echo "with $threads threads the digest is $digest; $golden says: $(grep '^pack' "$golden")"
  exit 1
fi
