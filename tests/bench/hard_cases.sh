#!/usr/bin/env bash
# Makes docs/hard-cases.md: runs the hard cases of a release build and writes what was found. Rooms of 10^4 and
# 10^5 polygons, the cases with an L, are a program of their own that the suite leaves to nights (label "long").
#   tests/bench/hard_cases.sh [BUILD]
set -euo pipefail
root=$(cd "$(dirname "$0")/../.." && pwd)
build=${1:-$root/build/release}
rows=$(mktemp)
trap 'rm -f "$rows"' EXIT
export ISOLUX_HARD_CASES=$rows
ctest --test-dir "$build" -R "^hard_" -LE long --output-on-failure >&2
ctest --test-dir "$build" -R "^hard_rooms_large_test.*(TiledWall|Lamp|Dust|Slats|RandomClosedRooms)" \
  --output-on-failure >&2
{
  echo "# Hard cases"
  echo
  echo "Made by \`tests/bench/hard_cases.sh\` from a run of \`tests/hard_cases/\`. Each case states a"
  echo "property; the violation is the worst over everything the case measured, in the property's own"
  echo "unit, and must not exceed the bound. A test fails otherwise. Cases with an L are large rooms of the"
  echo "long program \`hard_rooms_large_test\`, those of the same number without it a smaller one that the suite runs."
  echo
  echo "| case | situation | property | measured | worst violation | bound |"
  echo "|---|---|---|---|---|---|"
  # By number, then by letters.
  sed -E 's/^\| ([0-9]+)([A-Za-z]*) /\1|\2|&/' "$rows" | LC_ALL=C sort -t'|' -k1,1n -k2,2f -s | cut -d'|' -f3-
} >"$root/docs/hard-cases.md"
