#!/usr/bin/env bash
# One frame as 16 tiles under GNU parallel on this machine or, with parallel's --sshlogin, on others; then the merge.
# After a failure, a second run renders only the missing tiles.
#
#   bash farm/parallel.sh capsid.pdb capsid --assembly 1 --size 2048x2048
set -euo pipefail
scene="$1" out="$2"
shift 2
mkdir -p "$out"
halfline="${HALFLINE:-halfline}"
parallel --jobs "${JOBS:-2}" --joblog "$out/joblog" --retries 2 --halt now,fail=1 --termseq TERM,5000,KILL \
    "$halfline" render "$scene" "$@" --tile {}/16 -o "$out/tile.{}.png" --resume ::: $(seq 16)
exec "$halfline" merge "$out"/tile.*.png -o "$out/full.png"
