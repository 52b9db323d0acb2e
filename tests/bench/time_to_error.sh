#!/usr/bin/env bash
# Prints what true errors cost in time as a table in Markdown: sweeps over published scenes, one worker
# of two threads, from submission to patch file, measured at points whose irradiance is known by path
# tracing, by the programs of a release build.
#
#   tests/bench/time_to_error.sh FOLDER POINTS [BUILD] > table.md
#
# FOLDER holds the scenes, one folder each, NAME/NAME.obj. POINTS keeps the known points, NAME.csv; what
# it lacks is traced, which takes from one to half an hour a scene.
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
folder=${1:?the folder of scenes}
points=${2:?a folder for points with known irradiance}
build=${3:-$root/build/release}
cmake --build "$build" --target isolux isolux-server isolux-worker truth >&2
mkdir -p "$points"

# row NAME SECONDS ACCURACIES [import flags]: SECONDS of path tracing at most
row() {
  local name=$1 seconds=$2 accuracies=$3 scene=$folder/$1/$1.obj
  shift 3
  [[ -s $points/$name.csv ]] ||
    "$build/tests/truth" make "$scene" "$points/$name.csv" --points 400 --error 0.004 --seconds "$seconds" "$@" >&2
  "$build/bin/isolux" sweep "$scene" "$@" --accuracies "$accuracies" --workers 1 --threads 2 \
    --reference "$points/$name.csv" 2>/dev/null |
    awk -F, -v name="$name" '
      NR == 1 { for (i = 1; i <= NF; ++i) at[$i] = i; next }
      { printf "| %s | %g %% | %.2f %% | %.2f %% | %.2f | %d |\n", NR == 2 ? name : "",
          100 * $at["accuracy"], 100 * $at["error_estimate"], 100 * $at["error_true"],
          $at["seconds"], $at["links"] }'
}

echo "| scene | asked | estimated | true error | seconds | links |"
echo "|---|---|---|---|---|---|"
row cornell_box 60 0.1,0.05,0.02,0.01
row rp_cube 60 0.2,0.1,0.05,0.02 --emit both
row simple_office 1500 0.2,0.1,0.05,0.03,0.02,0.01 --emit both
row ward_office 250 0.2,0.1 --emit both
