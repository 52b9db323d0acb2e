#!/usr/bin/env bash
# Writes the tables of docs/results.md and the plot of it and docs/accuracy.md anew: sweeps over five published scenes and the
# project's room, with two workers of one thread, by the programs of a release build.
#   tests/bench/accuracy.sh FOLDER [BUILD]
# FOLDER holds the scenes, one folder each, NAME/NAME.obj. Takes some minutes of a quiet machine.
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
folder=${1:?the folder of scenes}
build=${2:-$root/build/release}
work=$(mktemp -d "${TMPDIR:-/tmp}/isolux-accuracy.XXXXXX")
trap 'rm -rf "$work"' EXIT
cmake --build "$build" --target isolux isolux-server isolux-worker >&2

# sweep NAME FILE ACCURACIES [import flags]
names=()
sweep() {
  local name=$1 file=$2 accuracies=$3
  shift 3
  "$build/bin/isolux" sweep "$file" "$@" --accuracies "$accuracies" --workers 2 --threads 1 \
    -o "$work/$name.csv" 2>"$work/$name.log" || { cat "$work/$name.log" >&2; exit 1; }
  echo "$name is measured" >&2
  names+=("$name")
}
sweep room "$root/scenes/room.obj" 0.2,0.1,0.05
sweep cornell_box "$folder/cornell_box/cornell_box.obj" 0.2,0.1,0.05,0.02,0.01,0.005 --unit mm
sweep rp_cube "$folder/rp_cube/rp_cube.obj" 0.2,0.1,0.05 --emit both
sweep rp_corridor "$folder/rp_corridor/rp_corridor.obj" 0.2,0.1,0.05 --emit both
sweep simple_office "$folder/simple_office/simple_office.obj" 0.2,0.1,0.05 --emit both
sweep modern_hall "$folder/modern_hall/modern_hall.obj" 0.2,0.1

{
  echo "| scene | asked | estimated | true | estimated/true | true RMS | 95 % of points within | links | rays, thousands | seconds |"
  echo "|---|---|---|---|---|---|---|---|---|---|"
  for name in "${names[@]}"; do
    awk -F, -v name="$name" '
      NR == 1 { for (i = 1; i <= NF; ++i) at[$i] = i; next }
      { printf "| %s | %g %% | %.2f %% | %.2f %% | %.2f | %.1f %% | %.1f %% | %d | %d | %.2f |\n",
          NR == 2 ? name : "", 100 * $at["accuracy"], 100 * $at["error_estimate"],
          100 * $at["error_true"], $at["ratio"], 100 * $at["error_rms"], 100 * $at["error_p95"],
          $at["links"], $at["rays"] / 1000, $at["seconds"] }' "$work/$name.csv"
  done
  echo
  echo "| scene | true error falls with | measured against |"
  echo "|---|---|---|"
  for name in "${names[@]}"; do
    slopes=$(sed -n 's/^default: true error ∝ //p' "$work/$name.log")
    reference=$(sed -n 's/^.*true error at .* points against //p' "$work/$name.log" | head -n 1)
    echo "| $name | $slopes | $reference |"
  done
} >"$work/tables.md"

# Error over links, both logarithmic: full dots true, rings estimated, a colour a scene.
cd "$work"
awk -F, '
  function x(links) { return 60 + 560 * (log(links) / log(10) - 2) / 4 }
  function y(error) { return 340 - 310 * (log(error) / log(10) + 3) / 2.5 }
  BEGIN {
    split("#2a78d6 #d6592a #2a9d5c #8a4fc4 #b08a12 #555555", colour, " ")
    print "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 640 390\" font-family=\"sans-serif\" font-size=\"12\">"
    print "<rect width=\"640\" height=\"390\" fill=\"white\"/>"
    for (p = 2; p <= 6; ++p)
      printf "<line x1=\"%g\" x2=\"%g\" y1=\"30\" y2=\"340\" stroke=\"#ddd\"/><text x=\"%g\" y=\"358\" text-anchor=\"middle\">1e%d</text>\n", x(10^p), x(10^p), x(10^p), p
    split("0.001 0.003 0.01 0.03 0.1 0.3", e, " ")
    for (i = 1; i <= 6; ++i)
      printf "<line x1=\"60\" x2=\"620\" y1=\"%g\" y2=\"%g\" stroke=\"#ddd\"/><text x=\"54\" y=\"%g\" text-anchor=\"end\">%g %%</text>\n", y(e[i]), y(e[i]), y(e[i]) + 4, 100 * e[i]
    print "<text x=\"340\" y=\"380\" text-anchor=\"middle\">links; full dots: true error, rings: estimated</text>"
  }
  FNR == 1 {
    for (i = 1; i <= NF; ++i) at[$i] = i
    name = FILENAME; sub(/\.csv$/, "", name); ++n; before = ""
    printf "<text x=\"%g\" y=\"20\" fill=\"%s\">%s</text>\n", 60 + 97 * (n - 1), colour[n], name
    next
  }
  {
    px = x($at["links"]); py = y($at["error_true"])
    if (before != "") printf "<line %s x2=\"%g\" y2=\"%g\" stroke=\"%s\"/>\n", before, px, py, colour[n]
    before = sprintf("x1=\"%g\" y1=\"%g\"", px, py)
    printf "<circle cx=\"%g\" cy=\"%g\" r=\"4\" fill=\"%s\"/>\n", px, py, colour[n]
    printf "<circle cx=\"%g\" cy=\"%g\" r=\"4\" fill=\"none\" stroke=\"%s\"/>\n", px, y($at["error_estimate"]), colour[n]
  }
  END { print "</svg>" }' "${names[@]/%/.csv}" >"$work/plot.svg"
cp "$work/plot.svg" "$root/docs/accuracy.svg"

awk -v table="$work/tables.md" '
  /^<!-- end of sweeps -->$/ { skip = 0 }
  !skip { print }
  /^<!-- sweeps -->$/ { while ((getline line < table) > 0) print line; skip = 1 }
' "$root/docs/results.md" >"$work/page.md"
cp "$work/page.md" "$root/docs/results.md"
