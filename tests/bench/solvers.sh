#!/usr/bin/env bash
# Writes the table of solvers in docs/results.md anew, from solver_bench of a release build.
#   tests/bench/solvers.sh [BUILD]
set -euo pipefail
root=$(cd "$(dirname "$0")/../.." && pwd)
build=${1:-$root/build/release}
table=$(mktemp) page=$(mktemp)
trap 'rm -f "$table" "$page"' EXIT
cmake --build "$build" --target solver_bench >&2
"$build/tests/solver_bench" markdown >"$table"
awk -v table="$table" '
  /^<!-- end of solver_bench -->$/ { skip = 0 }
  !skip { print }
  /^<!-- solver_bench -->$/ { while ((getline line < table) > 0) print line; skip = 1 }
' "$root/docs/results.md" >"$page"
cp "$page" "$root/docs/results.md"
