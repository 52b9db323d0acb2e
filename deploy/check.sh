#!/usr/bin/env bash
# What can be said about a change without running it:
#   format     clang-format finds nothing to change
#   includes   libraries include only what lies below them
#   headers    every header compiles by itself
#   citations  every key in a comment stands in docs/references.md
#   tidy       clang-tidy, over the files changed since the main branch (all of them with --all)
#
#   deploy/check.sh [--all] [format] [includes] [headers] [citations] [tidy]
# shellcheck disable=SC2317  # the checks are called by name
set -uo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.." || exit 1

all=false checks=()
for argument in "$@"; do
  case $argument in
    --all) all=true ;;
    format | includes | headers | citations | tidy) checks+=("$argument") ;;
    *)
      echo "usage: deploy/check.sh [--all] [format] [includes] [headers] [citations] [tidy]" >&2
      exit 2
      ;;
  esac
done
((${#checks[@]})) || checks=(format includes headers citations tidy)
jobs=$(nproc)

sources() { git ls-files -- '*.h' '*.cc'; }

changed() {  # since the branch left main; everything where there is no such point
  local base
  base=$(git merge-base HEAD origin/main 2>/dev/null || git merge-base HEAD main 2>/dev/null) || base=
  if $all || [[ -z $base || $base == "$(git rev-parse HEAD)" && -z $(git status --porcelain) ]]; then
    sources
  else
    { git diff --name-only --diff-filter=d "$base" -- '*.h' '*.cc'
      git ls-files --others --exclude-standard -- '*.h' '*.cc'; } | sort -u
  fi
}

check_format() { sources | xargs -r clang-format --dry-run -Werror; }

# FOLDER: folders whose headers it may include. Arrows point down only.
check_includes() {
  local rules=(
    'common/util: common/util isolux_build_id.h'
    'common/vec.h:'
    'common/scene: common/util common/vec.h common/scene'
    'common/hierarchy: common/util common/vec.h common/scene common/hierarchy'
    'common/rpc: common proto isolux'
    'worker/coupling: common/util common/vec.h common/scene worker/coupling'
    'worker/visibility: common/util common/vec.h common/scene common/hierarchy worker/coupling worker/visibility'
    'worker/factors: common/util common/vec.h common/scene common/hierarchy worker/coupling worker/visibility worker/factors'
    'worker/radiosity: common/util common/vec.h common/scene common/hierarchy worker/coupling worker/visibility worker/radiosity'
    'worker/shard: common/util common/vec.h common/scene common/hierarchy worker/coupling worker/radiosity worker/shard'
    'worker: common worker isolux'
    'server: common server isolux'
    'client/import: common/util common/vec.h common/scene common/hierarchy client/import'
    'client/output: common/util common/vec.h common/scene common/hierarchy client/output'
    'client/web: common/util client/web'
    'client/report: common/util common/vec.h common/scene client/output client/web client/report'
    'client/commands/factors: common client worker/factors isolux'
    'client: common client isolux'
    'tests: common worker server client tests isolux'
  )
  local failed=0 file folder allowed included rule
  while read -r file; do
    for rule in "${rules[@]}"; do  # the first that fits holds
      folder=${rule%%:*}
      [[ $file == "$folder"* ]] || continue
      allowed=${rule#*:}
      while read -r included; do
        local fine=0 prefix
        for prefix in $allowed; do [[ $included == "$prefix"* ]] && fine=1; done
        if ((!fine)); then
          echo "$file: must not include \"$included\"; $folder may include:$allowed"
          failed=1
        fi
      done < <(sed -n 's/^#include "\(.*\)"$/\1/p' "$file")
      break
    done
  done < <(sources)
  return "$failed"
}

# Flags of all files and the generated headers.
configure_tidy() {
  cmake --preset tidy >/dev/null &&
    cmake --build build/tidy --target isolux_services isolux_build_id >/dev/null
}

# All include paths and definitions together serve every header.
check_headers() {
  configure_tidy || return 1
  local flags
  flags=$(grep -ohE -- ' (-I[^ ]+|-isystem [^ ]+|-D[A-Za-z0-9_]+(=[A-Za-z0-9_]+)?)' \
    build/tidy/compile_commands.json | sort -u | tr '\n' ' ')
  # shellcheck disable=SC2016,SC2086
  git ls-files -- '*.h' | xargs -r -P "$jobs" -I{} sh -c '
    header=$1
    shift
    echo "#include \"$header\"" |
      g++ -std=c++20 -march=x86-64-v3 -Wall -Wextra -Wno-psabi -Werror -fsyntax-only "$@" -x c++ - ||
      { echo "$header: does not compile by itself"; exit 1; }' sh {} $flags
}

check_citations() {
  local failed=0 key
  [[ -f docs/references.md ]] || return 0
  while read -r key; do
    grep -qF "$key" docs/references.md || { echo "$key is not in docs/references.md"; failed=1; }
  done < <(sources | xargs -r grep -ohE '\[[A-Z][A-Za-z]+[0-9]{2}[a-z]?\]' | sort -u)
  return "$failed"
}

check_tidy() {
  configure_tidy || return 1
  changed | grep '\.cc$' | xargs -r -P "$jobs" -n 1 clang-tidy --quiet -p build/tidy
}

status=0
for check in "${checks[@]}"; do
  started=$SECONDS
  if "check_$check"; then
    echo "check: $check: fine ($((SECONDS - started)) s)"
  else
    echo "check: $check: FAILED ($((SECONDS - started)) s)" >&2
    status=1
  fi
done
exit $status
