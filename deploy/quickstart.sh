#!/usr/bin/env bash
# From a fresh clone to a picture: installs the packages, builds, starts a coordinator and two workers
# on this machine, solves the Cornell box, renders it and reports what it took. Leaves
# out/cornell_box.ply, out/cornell_box.png and out/cornell_box.html; everything it started is stopped at the end, however it ends.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

deploy/install-deps.sh
cmake --preset release
cmake --build --preset release --target isolux-server isolux-worker isolux

program() {  # where the build put a program
  local found
  found=$(find build/release -type f -name "$1" -perm -u+x -print -quit)
  if [[ -z $found ]]; then
    echo "quickstart: $1 was not built" >&2
    exit 1
  fi
  echo "$found"
}
server=$(program isolux-server)
worker=$(program isolux-worker)
isolux=$(program isolux)

data=$(mktemp -d "${TMPDIR:-/tmp}/isolux-quickstart.XXXXXX")
started=()
stop_all() {
  for ((i = ${#started[@]} - 1; i >= 0; --i)); do kill "${started[i]}" 2>/dev/null || true; done
  for pid in "${started[@]}"; do wait "$pid" 2>/dev/null || true; done
  rm -rf "$data"
}
trap stop_all EXIT
trap 'exit 130' INT
trap 'exit 143' TERM

"$server" --listen 127.0.0.1:0 --port-file "$data/port" --data-dir "$data/jobs" \
  >"$data/server.log" 2>&1 &
started+=($!)
for _ in $(seq 300); do
  [[ -s $data/port ]] && break
  kill -0 "${started[0]}" 2>/dev/null || break
  sleep 0.1
done
if [[ ! -s $data/port ]]; then
  echo "quickstart: the coordinator did not start:" >&2
  cat "$data/server.log" >&2
  exit 1
fi
address=127.0.0.1:$(<"$data/port")
echo "quickstart: coordinator at $address"
for n in 1 2; do
  "$worker" --server "$address" --threads 1 >"$data/worker$n.log" 2>&1 &
  started+=($!)
done

mkdir -p out
if ! "$isolux" submit scenes/cornell_box/cornell_box.obj --unit mm --accuracy 0.05 --wait \
  -o out/cornell_box.ply --server "$address"; then
  echo "quickstart: the solve failed; the logs end with:" >&2
  tail -n 20 "$data"/*.log >&2
  exit 1
fi
"$isolux" render out/cornell_box.ply --camera scenes/cornell_box/camera.json -o out/cornell_box.png
"$isolux" report 1 --camera scenes/cornell_box/camera.json -o out/cornell_box.html --server "$address"
echo "quickstart: see out/cornell_box.png, and out/cornell_box.html in a browser; out/cornell_box.ply opens in any mesh viewer"
