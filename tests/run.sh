#!/usr/bin/env bash
# Everything that has to hold before a change goes in: installs what is missing, builds, checks that
# every header compiles alone and that the sources are formatted, runs all tests.
#
#   bash tests/run.sh [options of ctest, such as -R NAME]
set -euo pipefail

root="$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)"
build="$root/build/release"
failed=()

headers_compile_alone() {
  cmake --build "$build" --parallel "$(nproc)" --target all_verify_interface_header_sets
}

# Each release of clang-format has its own idea; ours is 14.
sources_are_formatted() {
  local tool
  for tool in clang-format-14 clang-format; do
    if ! command -v "$tool" >/dev/null || ! "$tool" --version | grep -q 'version 14\.'; then
      continue
    fi
    (cd "$root" &&
      find src tracker retarget face tests samples -name '*.h' -print0 -o -name '*.cpp' -print0 |
      xargs -0 -P "$(nproc)" -n 16 "$tool" --dry-run -Werror)
    return
  done
  printf 'clang-format 14 is not installed: format not checked\n'
}

all_tests_pass() {
  ctest --test-dir "$build" --parallel "$(nproc)" --output-on-failure --no-tests=error "$@"
}

step() {
  local name="$1" started="$SECONDS"
  shift
  printf '\n== %s\n' "$name"
  if "$@"; then
    printf '== %s: good (%d s)\n' "$name" "$((SECONDS - started))"
  else
    printf '== %s: FAILED (%d s)\n' "$name" "$((SECONDS - started))"
    failed+=("$name")
  fi
}

step 'build' bash "$root/cmake/setup.sh"
if [[ ${#failed[@]} -eq 0 ]]; then
  step 'headers compile alone' headers_compile_alone
  step 'sources are formatted' sources_are_formatted
  step 'tests' all_tests_pass "$@"
fi

if [[ ${#failed[@]} -gt 0 ]]; then
  printf '\nFAILED:'
  printf ' [%s]' "${failed[@]}"
  printf '\n'
  exit 1
fi
printf '\nAll good.\n'
