#!/usr/bin/env bash
# Solves every scene below a folder with two workers and prints a table in Markdown: what went in, what
# came out, how long it took, how much memory each process took at most.
#
#   tests/bench/scenes.sh FOLDER [ACCURACY [MAX_SECONDS]] > table.md
#
# FOLDER holds one folder a scene, NAME/NAME.obj; a NAME/SOURCE.md that says that emitters radiate from
# both sides asks for --emit both. Needs the release build (deploy/quickstart.sh makes it). A scene
# that is refused, or ends by its budget, says so in the last column.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/../.."

folder=${1:?the folder of scenes}
accuracy=${2:-0.1}
max_seconds=${3:-300}
bin=build/release/bin
work=$(mktemp -d "${TMPDIR:-/tmp}/isolux-scenes.XXXXXX")
pids=()
stop() {
  ((${#pids[@]} == 0)) || kill "${pids[@]}" 2>/dev/null || true
  wait 2>/dev/null || true
  pids=()
}
trap 'stop; rm -rf "$work"' EXIT

peak_mb() { awk '/VmHWM/ {printf "%d", $2 / 1024}' "/proc/$1/status" 2>/dev/null || true; }
value() { sed -n "s/.*\"$1\":\(\"[^\"]*\"\|[-0-9.e+]*\).*/\1/p" "$2" | tr -d '"' | head -n 1; }

echo "| scene | polygons | surfaces | elements | links | rounds | estimated error | energy imbalance | seconds | coordinator MB | workers MB | client MB | ended by |"
echo "|---|---|---|---|---|---|---|---|---|---|---|---|---|"
for scene in "$folder"/*/; do
  name=$(basename "$scene")
  file=$scene/$name.obj
  [[ -f $file ]] || continue
  emit=front
  if [[ -f $scene/SOURCE.md ]] && grep -q 'both sides' "$scene/SOURCE.md"; then emit=both; fi
  if ! "$bin/isolux" inspect "$file" --emit $emit --json >"$work/inspect.json" 2>"$work/inspect.log"; then
    echo "| $name | | | | | | | | | | | | refused: $(tail -n 1 "$work/inspect.log" | tr '|' '/') |"
    continue
  fi
  rm -rf "$work/data" "$work/port"
  "$bin/isolux-server" --listen 127.0.0.1:0 --port-file "$work/port" --data-dir "$work/data" \
    >"$work/server.log" 2>&1 &
  pids=($!)
  until [[ -s $work/port ]]; do sleep 0.1; done
  address=127.0.0.1:$(<"$work/port")
  for n in 1 2; do
    "$bin/isolux-worker" --server "$address" --threads 1 >"$work/worker$n.log" 2>&1 &
    pids+=($!)
  done
  "$bin/isolux" submit "$file" --emit $emit --accuracy "$accuracy" --max-seconds "$max_seconds" --wait \
    --json --server "$address" -o "$work/out.ply" >"$work/result.json" 2>"$work/client.log" &
  client=$!
  client_mb=0
  while kill -0 $client 2>/dev/null; do
    now=$(peak_mb $client)
    client_mb=${now:-$client_mb}
    sleep 0.2
  done
  code=0
  wait $client || code=$?
  if ((code == 0)); then
    echo "| $name | $(value polygons "$work/inspect.json") | $(value surfaces "$work/inspect.json")" \
      "| $(value elements "$work/result.json") | $(value links "$work/result.json")" \
      "| $(value rounds "$work/result.json") | $(value error_estimate "$work/result.json")" \
      "| $(value energy_imbalance "$work/result.json") | $(value seconds "$work/result.json")" \
      "| $(peak_mb "${pids[0]}") | $(peak_mb "${pids[1]}"), $(peak_mb "${pids[2]}") | $client_mb" \
      "| $(value end_reason "$work/result.json") |" |
      sed -E 's/([0-9]+\.[0-9]{3})[0-9]+/\1/g'
  else
    outcome=failed
    ((code == 2)) && outcome=refused
    reason=$(tail -n 1 "$work/client.log" | tr '|' '/')
    echo "| $name | | | | | | | | | | | | $outcome: ${reason#*"$name.obj": } |"
  fi
  stop
done
