#!/usr/bin/env bash
# Which effects the scenes below a folder call for, and what neglecting each truly costs, as two tables
# in Markdown.
#
#   tests/bench/effects.sh FOLDER [ACCURACY [MAX_SECONDS [SCENE...]]] > tables.md
#
# FOLDER holds one folder a scene, NAME/NAME.obj; a NAME/SOURCE.md that says that emitters radiate from
# both sides asks for --emit both. Of grey_white_room, in which nothing emits, a copy is solved whose
# lampshade does. Needs the release build and its target `neglect`.
#
# The first table: a row a scene, a column an effect that is present somewhere, with the decision once
# the first round has measured, and the bound and what was measured, where there are such.
# The second: a row an effect with a bound, with the true cost: how far the solution is off when the
# effect is switched the other way, thresholds of the rounds the same; and by path tracing, of effects
# that paths know of, with its standard error. Effects that only add or only take light are off by the
# difference of the means, in which coarse solutions differ less for other reasons.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/../.."

folder=$(realpath "${1:?the folder of scenes}")
accuracy=${2:-0.1}
max_seconds=${3:-120}
chosen=("${@:4}")
isolux=build/release/bin/isolux
neglect=$(find build/release -name neglect -type f -perm -u+x | head -n 1)
: "${neglect:?build the target neglect first}"
work=$(mktemp -d "${TMPDIR:-/tmp}/isolux-effects.XXXXXX")
trap 'rm -rf "$work"' EXIT
((${#chosen[@]})) || for scene in "$folder"/*/; do chosen+=("$(basename "$scene")"); done

# comments PLY KEY: what the patch file says of it.
comments() { LC_ALL=C sed -n "/^end_header/q; s/^comment isolux $2 //p" "$1" | tr -d '\r'; }
# word ROW NAME: what follows the name in a row of the table.
word() { sed -n "s/.* $2 \([^ ]*\).*/\1/p" <<<"${1%% evidence *}"; }
# percent X
percent() { awk -v x="$1" 'BEGIN { printf "%.2g %%", 100 * (x < 0 ? -x : x) }'; }
# solve FILE OUT FLAGS...
solve() {
  "$isolux" solve "$1" --workers 2 --threads 1 --accuracy "$accuracy" "${@:3}" -o "$2" \
    >/dev/null 2>"$work/log"
}

# By a solution in which the effect is switched the other way.
by_solutions() {  # FILE EMIT EFFECT DECISION
  local sign=- without=$work/other.ply with=$work/first.ply key=mean
  if [[ $4 == off ]]; then sign=+ without=$work/first.ply with=$work/other.ply; fi
  if [[ $3 == colour || $3 == textures ]]; then key=l1; fi
  solve "$1" "$work/other.ply" --emit "$2" --effects="auto,$sign$3" \
    --epsilons "$(comments "$work/first.ply" epsilons | tr ' ' ',')" || return 0
  "$neglect" solved "$without" "$with" | sed -n "s/^$key,//p"
}

# The folder of a copy of a scene, in which a material emits 1 W/(m² sr).
lit() {  # NAME MATERIAL
  mkdir -p "$work/lit"
  cp -rs "$folder/$1" "$work/lit/"
  chmod -R u+w "$work/lit/$1"
  rm "$work/lit/$1/$1.mtl"
  sed "s/^newmtl $2\r\?$/&\nKe 1 1 1/" "$folder/$1/$1.mtl" >"$work/lit/$1/$1.mtl"
  echo "$work/lit"
}

true_costs() {  # NAME FILE EMIT
  local row effect decision bound measured other paths found line
  while read -r row; do
    effect=${row%% *}
    decision=$(cut -d ' ' -f 2 <<<"$row")
    bound=$(word "$row" bound)
    measured=$(word "$row" measured)
    [[ $row == *" present yes "* && "$bound$measured" != "-" ]] || continue
    other=
    if [[ $decision != not-simulated ]]; then other=$(by_solutions "$2" "$3" "$effect" "$decision"); fi
    paths=
    if [[ $effect == mirrors || $effect == clear-glass || $effect == gloss ]]; then
      paths=$("$neglect" paths "$2" "$effect" --emit "$3" --points 800)
    fi
    found=
    while IFS=, read -r line mean noise; do
      [[ -z $line ]] || found+="${found:+; }${line/all/}${line:+ }$(percent "$mean") ± $(percent "$noise")"
    done <<<"$paths"
    awk -v name="$1" -v effect="$effect" -v decision="${decision/-/ }" -v bound="$bound" \
      -v measured="$measured" -v other="$other" -v paths="$paths" -v found="${found# }" '
      function of(x) { return x == "" || x == "-" ? "" : sprintf("%.3g %%", 100 * (x < 0 ? -x : x)) }
      BEGIN {
        least = bound == "-" || measured != "" && measured + 0 < bound + 0 ? measured : bound
        most = other < 0 ? -other : other + 0
        split(paths, lines, "\n")
        for (i in lines) { split(lines[i], part, ","); if (part[2] + 0 > most) most = part[2] + 0 }
        printf "| %s | %s | %s | %s | %s | %s | %s | %s |\n", name, effect, decision, of(bound),
          of(measured), of(other), found, most < least + 0 ? "yes" : "**no**"
      }'
  done < <(comments "$work/first.ply" effect)
}

for name in "${chosen[@]}"; do
  from=$folder
  if [[ $name == grey_white_room ]]; then from=$(lit "$name" Transluscent); fi
  file=$from/$name/$name.obj
  [[ -f $file ]] || continue
  emit=front
  if [[ -f $folder/$name/SOURCE.md ]] && grep -q 'both sides' "$folder/$name/SOURCE.md"; then emit=both; fi
  if ! solve "$file" "$work/first.ply" --emit $emit --max-seconds "$max_seconds"; then
    # Nothing is solved: what the scene alone tells.
    "$isolux" inspect "$file" --emit $emit --accuracy "$accuracy" 2>/dev/null |
      awk -v scene="$name" '/^effect / { t = 1; next }
        t && NF { d = $4 == "not" ? "not-simulated" : $4; print scene, $1, d, "present", $2, "bound", $3 }' \
        >>"$work/rows"
    echo "| $name | | | | | | | $(sed -n 's/.*\(nothing emits light\).*/\1/p' "$work/log" | head -n 1) |" \
      >>"$work/costs"
    continue
  fi
  comments "$work/first.ply" effect | sed "s/ evidence .*//; s/^/$name /" >>"$work/rows"
  true_costs "$name" "$file" $emit >>"$work/costs"
done

awk '
  !($1 in seen) { seen[$1] = 1; scenes[++rows] = $1 }
  !($2 in known) { known[$2] = 1; effects[++columns] = $2 }
  $5 == "yes" {
    present[$2] = 1
    known_costs = $7 == "-" ? "" : $7
    if ($8 == "measured") known_costs = known_costs (known_costs == "" ? "" : ", ") "measured " $9
    sub("not-simulated", "not simulated", $3)
    cell[$1, $2] = $3 (known_costs == "" ? "" : " (" known_costs ")")
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
  }' "$work/rows"
echo
echo "| scene | effect | decision | bound | measured | true cost, by solutions | by paths | below |"
echo "|---|---|---|---|---|---|---|---|"
cat "$work/costs"
