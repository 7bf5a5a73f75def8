#!/bin/sh
# check_symbols.sh LIBRARY...: every global symbol of the static runtime begins with scree_, so that none can clash with a game's own.
set -eu
strays=$(nm --defined-only -g "$@" | awk '$2 ~ /^[TDBRCV]$/ && $3 !~ /^(scree_|_Z|DW\.ref\.)/ { print $3 }' | sort -u)
[ -z "$strays" ] || {
  printf 'symbols without the prefix scree_:\n%s\n' "$strays"
  exit 1
}
