#!/usr/bin/env bash
# How fast links are made, rays cast and points gathered, as a table in Markdown: one solve a scene with
# one worker of two threads, by the programs of a release build. Links kept over the seconds of all
# rounds' refinement; rays of links and of the output over the seconds of both; points of the output over
# the gather's CPU.
#
#   tests/bench/rates.sh FOLDER ACCURACY NAME... > table.md
#
# FOLDER holds the scenes, one folder each, NAME/NAME.obj; both sides of lamps shine where NAME/SOURCE.md
# says so.
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
folder=${1:?the folder of scenes}
accuracy=${2:?an accuracy}
shift 2
work=$(mktemp -d "${TMPDIR:-/tmp}/isolux-rates.XXXXXX")
trap 'rm -rf "$work"' EXIT

echo "| scene | polygons | links | M links/s and core | settled by proof | M rays/s and core | points gathered, thousands/s and core |"
echo "|---|---|---|---|---|---|---|"
for name in "$@"; do
  emit=front
  if grep -qs "both sides" "$folder/$name/SOURCE.md"; then emit=both; fi
  "$root/build/release/bin/isolux" solve "$folder/$name/$name.obj" --emit $emit --accuracy "$accuracy" \
    --workers 1 --threads 2 -o "$work/out.ply" >"$work/log" 2>&1 || {
    cat "$work/log" >&2
    exit 1
  }
  polygons=$("$root/build/release/bin/isolux" inspect "$folder/$name/$name.obj" --emit $emit --json |
    grep -o '"polygons": *[0-9]*' | head -n 1 | grep -o '[0-9]*')
  sed '/^end_header/q' "$work/out.ply" | grep -a '^comment isolux' | awk -v name="$name" -v polygons="$polygons" '
    $3 == "round" {
      for (i = 5; i < NF; i += 2) of[$i] = $(i + 1)
      refine += of["refine_s"]; evaluations += of["evaluations"]; rays += of["rays"]
      proved += of["proved_visible"] + of["proved_hidden"]
    }
    $3 == "rays" { all_rays = $4 }
    $3 == "gather_cpu_s" { for (i = 4; i <= NF; ++i) cpu += $i }
    END {
      printf "| %s | %d | %d | %.3f | %.0f %% | %.2f | %.0f |\n", name, polygons, of["links"],
        of["links"] / refine / 2e6, 100 * proved / evaluations, all_rays / (2 * refine + cpu) / 1e6,
        of["output_points"] / cpu / 1e3
    }'
done
