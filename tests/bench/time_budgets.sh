#!/usr/bin/env bash
# How well time budgets are kept: solves the project's scenes under budgets of seconds, several times
# each, and prints a table in Markdown with the medians: from the start of the job to the patch file, and
# what error that bought. Needs the release build and a machine with nothing else to do.
#
#   tests/bench/time_budgets.sh [RUNS [SECONDS...]] > table.md
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/../.."

runs=${1:-5}
shift || true
budgets=("$@")
((${#budgets[@]})) || budgets=(2 5 10 30)
bin=build/release/bin
work=$(mktemp -d "${TMPDIR:-/tmp}/isolux-budgets.XXXXXX")
trap 'rm -rf "$work"' EXIT

value() { sed -n "s/.*\"$1\":\([-0-9.e+]*\).*/\1/p" "$2" | head -n 1; }
median() { sort -g | awk '{v[NR] = $1} END {print v[int((NR + 1) / 2)]}'; }

echo "| scene | budget, s | median, s | largest, s | used | median estimated error |"
echo "|---|---|---|---|---|---|"
for scene in room cornell_box/cornell_box furnace_cube; do
  unit=m
  if [[ $scene == cornell_box/* ]]; then unit=mm; fi
  for budget in "${budgets[@]}"; do
    : >"$work/seconds"
    : >"$work/errors"
    for ((run = 0; run < runs; ++run)); do
      "$bin/isolux" solve "scenes/$scene.obj" --unit $unit --workers 2 --accuracy 0.001 \
        --max-seconds "$budget" -o "$work/out.ply" --json >"$work/run.json" 2>"$work/run.log"
      value seconds "$work/run.json" >>"$work/seconds"
      value error_estimate "$work/run.json" >>"$work/errors"
    done
    middle=$(median <"$work/seconds")
    printf '| %s | %s | %.2f | %.2f | %.0f %% | %.2f %% |\n' "$(basename "$scene")" "$budget" "$middle" \
      "$(sort -g "$work/seconds" | tail -n 1)" "$(awk "BEGIN {print 100 * $middle / $budget}")" \
      "$(awk "BEGIN {print 100 * $(median <"$work/errors")}")"
  done
done
