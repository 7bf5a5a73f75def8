#!/bin/sh
# digest_program.sh SCREE_BAKE RECIPE GOLDEN NAME WORK THREADS
# The program, with Draco and several threads, gives the digest that digest_small gives without either.
set -eu
bake=$1 recipe=$2 golden=$3 name=$4 work=$5 threads=$6
mkdir -p "$work"
"$bake" "$recipe" -o "$work/$name-$threads.scree" --threads "$threads" --quiet --report "$work/$name-$threads.json"
digest=$(sed -n 's/.*"digest": "\([0-9a-f]*\)".*/\1/p' "$work/$name-$threads.json")
if ! grep -qx "$name $digest" "$golden"; then
  echo "with $threads threads the digest is $digest; $golden says: $(grep "^$name" "$golden")"
  exit 1
fi
