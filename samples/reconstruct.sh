#!/usr/bin/env bash
# From a video of a face to its muscle contractions and the animated face, in one go. Installs what
# is missing, builds, runs.
#
#   bash samples/reconstruct.sh [VIDEO] [options of `zygoma run`...]
#
# Without VIDEO: the performer in this folder, whose true contractions are known, so that the result
# can be compared with them. Results go to build/reconstruction/<name of the video>, or to the
# folder given with -o.
set -euo pipefail

root="$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)"

video=
if [[ $# -gt 0 && "$1" != -* ]]; then
  video="$1"
  shift
fi
options=("$@")

if [[ -z "$video" ]]; then
  video="$root/samples/performer.mp4"
  options=(--truth "$root/samples/performer.contractions.csv"
    --truth-contours "$root/samples/performer.contours.csv" "${options[@]}")
fi

output=
asks_for_help=false
for ((i = 0; i < ${#options[@]}; ++i)); do
  case "${options[i]}" in
    -o | --output) output="${options[i + 1]:-}" ;;
    --output=*) output="${options[i]#--output=}" ;;
    -o?*) output="${options[i]#-o}" ;;
    -h | --help) asks_for_help=true ;;
  esac
done
if [[ -z "$output" ]]; then
  stem="$(basename -- "$video")"
  output="$root/build/reconstruction/${stem%.*}"
  options+=(-o "$output")
fi

if ! $asks_for_help && [[ ! -e "$video" ]]; then
  printf 'reconstruct: %s: no such file, expected a video of a face\n' "$video" >&2
  exit 2
fi

bash "$root/cmake/setup.sh" zygoma >&2
if $asks_for_help; then
  sed -n '2,/^set/{/^set/d;s/^# \{0,1\}//p}' "${BASH_SOURCE[0]}"
  exec "$root/build/release/zygoma" run --help
fi

status=0
"$root/build/release/zygoma" run "$video" "${options[@]}" || status=$?
if [[ "$status" -eq 0 || "$status" -eq 130 ]]; then
  printf 'Results in %s:\n' "$output"
  for file in "$output"/*; do printf '  %s\n' "${file##*/}"; done
fi
exit "$status"
