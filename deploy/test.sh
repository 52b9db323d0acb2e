#!/usr/bin/env bash
# Everything that must hold before a change is taken:
#   release   build and all tests but the long ones
#   asan      address and undefined behaviour, tests of the libraries without gRPC (label "core")
#   tsan      data races, of these the tests in which threads meet
# With --all, also: asan over all tests, tsan over all of "core", and the tests labelled "long".
#
#   deploy/test.sh [--all] [--no-install] [release] [asan] [tsan]     (parts: those named only)
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

all=false install=true parts=()
for argument in "$@"; do
  case $argument in
    --all) all=true ;;
    --no-install) install=false ;;
    release | asan | tsan) parts+=("$argument") ;;
    *)
      echo "usage: deploy/test.sh [--all] [--no-install] [release] [asan] [tsan]" >&2
      exit 2
      ;;
  esac
done
((${#parts[@]})) || parts=(release asan tsan)
$install && deploy/install-deps.sh

jobs=$(nproc)
results=()
export UBSAN_OPTIONS=print_stacktrace=1:halt_on_error=1
export ASAN_OPTIONS=detect_stack_use_after_return=1:strict_string_checks=1
export LSAN_OPTIONS=suppressions=$PWD/deploy/lsan.supp:print_suppressions=0
export TSAN_OPTIONS=suppressions=$PWD/deploy/tsan.supp:halt_on_error=1:second_deadlock_stack=1

# The thread sanitizer cannot live with every address layout; without randomisation it always can.
launcher=(env)
if setarch "$(uname -m)" -R true 2>/dev/null; then launcher=(setarch "$(uname -m)" -R); fi

# Runs ctest in build/PRESET and keeps its closing lines for the end.
run_tests() {
  local preset=$1 started=$SECONDS log
  shift
  log=build/$preset/ctest.log
  if ! "${launcher[@]}" ctest --test-dir "build/$preset" -j "$jobs" --output-on-failure --no-tests=error \
    --timeout 600 "$@" | tee "$log"; then
    echo "test: $preset: tests failed" >&2
    grep -E 'tests passed|tests failed' "$log" >&2 || true
    exit 1
  fi
  results+=("$preset ($*): $(grep -E 'tests passed' "$log"), $((SECONDS - started)) s")
}

for part in "${parts[@]}"; do
  echo "== $part: build"
  cmake --preset "$part"
  case $part in
    release)
      cmake --build --preset release
      run_tests release -LE long
      $all && run_tests release -L long
      ;;
    asan)
      if $all; then
        cmake --build --preset asan
        run_tests asan -LE long
      else
        cmake --build --preset asan --target core_tests
        run_tests asan -L '^core$'
      fi
      ;;
    tsan)
      # Tests that are not built have no label.
      "${launcher[@]}" cmake --build --preset tsan --target "$($all && echo core_tests || echo thread_tests)"
      run_tests tsan -L '^core$'
      ;;
  esac
done

echo
printf 'test: %s\n' "${results[@]}"
