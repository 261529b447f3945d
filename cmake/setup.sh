#!/usr/bin/env bash
# Gets this machine ready and builds: installs the packages of cmake/packages.txt that are missing,
# configures the release preset and builds with all cores. Quick when there is nothing to do.
#
#   bash cmake/setup.sh [TARGET...]        (default: everything)
set -euo pipefail

root="$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)"
build="$root/build/release"

fail() {
  printf 'setup: %s\n' "$1" >&2
  exit 1
}

list_packages() {
  sed -e 's/#.*//' -e 's/[[:space:]]//g' -e '/^$/d' "$root/cmake/packages.txt"
}

list_missing_packages() {
  local package
  for package in $(list_packages); do
    dpkg-query --show --showformat='${db:Status-Status}\n' "$package" 2>/dev/null |
      grep -qx installed || printf '%s\n' "$package"
  done
}

# Tools and libraries that are there count, however they got there; only the packages' names are
# Debian's.
install_packages() {
  if ! command -v dpkg-query >/dev/null || ! command -v apt-get >/dev/null; then
    printf 'setup: not a Debian or Ubuntu system, so nothing is installed; needed are:\n%s\n' \
      "$(list_packages | sed 's/^/  /')" >&2
    return
  fi
  local missing
  missing="$(list_missing_packages | tr '\n' ' ')"
  [[ -n "${missing// /}" ]] || return 0

  local as_root=()
  if [[ "$(id -u)" -ne 0 ]]; then
    command -v sudo >/dev/null ||
      fail "packages are missing; have them installed by an administrator: apt-get install $missing"
    as_root=(sudo)
  fi
  printf 'Installing: %s\n' "$missing"
  local apt=("${as_root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get -q -y
    -o DPkg::Lock::Timeout=300)
  "${apt[@]}" update || printf 'setup: the package lists could not be renewed\n' >&2
  # shellcheck disable=SC2086  # one word per package
  "${apt[@]}" install --no-install-recommends $missing ||
    fail "the packages could not be installed: $missing"
}

# Once configured, the build itself notices when it has to be configured again. A tree that was
# moved or copied has to start afresh.
configure() {
  local cache="$build/CMakeCache.txt"
  if [[ -f "$build/build.ninja" ]] && grep -qxF "CMAKE_HOME_DIRECTORY:INTERNAL=$root" "$cache"; then
    return
  fi
  local options=()
  [[ ! -f "$cache" ]] || options=(--fresh)
  (cd "$root" && cmake --preset release "${options[@]}" --log-level=WARNING)
}

compile() {
  local targets=()
  [[ $# -eq 0 ]] || targets=(--target "$@")
  cmake --build "$build" --parallel "$(nproc)" "${targets[@]}"
}

install_packages
configure
compile "$@"
