#!/usr/bin/env bash
# Which effects the scenes below a folder call for, as a table in Markdown: a row a scene, a column an
# effect that is present somewhere, with the decision and the bound it rests on.
#
#   tests/bench/effects.sh FOLDER [ACCURACY] > table.md
#
# FOLDER holds one folder a scene, NAME/NAME.obj; a NAME/SOURCE.md that says that emitters radiate from
# both sides asks for --emit both. Needs the release build. Nothing is solved.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/../.."

folder=${1:?the folder of scenes}
accuracy=${2:-0.02}
{
  for scene in "$folder"/*/; do
    name=$(basename "$scene")
    file=$scene/$name.obj
    [[ -f $file ]] || continue
    emit=front
    if [[ -f $scene/SOURCE.md ]] && grep -q 'both sides' "$scene/SOURCE.md"; then emit=both; fi
    build/release/bin/isolux inspect "$file" --emit $emit --accuracy "$accuracy" 2>/dev/null |
      awk -v scene="$name" '/^effect / { table = 1; next } table && NF { print scene, $0 }'
  done
} | awk '
  !($1 in seen) { seen[$1] = 1; scenes[++rows] = $1 }
  !($2 in known) { known[$2] = 1; effects[++columns] = $2 }
  $3 == "yes" {
    present[$2] = 1
    decision = $5 == "not" ? "not simulated" : $5
    cell[$1, $2] = decision ($4 == "-" ? "" : " (" $4 ")")
  }
  END {
    printf "| scene |"
    for (c = 1; c <= columns; ++c) if (effects[c] in present) printf " %s |", effects[c]
    printf "\n|---|"
    for (c = 1; c <= columns; ++c) if (effects[c] in present) printf "---|"
    for (r = 1; r <= rows; ++r) {
      printf "\n| %s |", scenes[r]
      for (c = 1; c <= columns; ++c)
        if (effects[c] in present) printf " %s |", cell[scenes[r], effects[c]]
    }
    printf "\n"
  }'
