#!/usr/bin/env bash
# One tile per task of a Slurm array; then the merge, which waits for all of them:
#
#   tiles=$(sbatch --parsable --array=1-16 farm/slurm.sh capsid.pdb capsid --assembly 1 --size 4096x4096)
#   sbatch --dependency=afterok:$tiles --wrap 'halfline merge capsid/tile.*.png -o capsid/full.png'
#
#SBATCH --job-name=halfline
#SBATCH --requeue
#SBATCH --signal=TERM@60
# A requeued task skips its finished tiles (--resume). SIGTERM, a minute before the kill, leaves no partial file.
set -euo pipefail
scene="$1" out="$2"
shift 2
mkdir -p "$out"
exec halfline render "$scene" "$@" --tile "$SLURM_ARRAY_TASK_ID/$SLURM_ARRAY_TASK_COUNT" \
    -o "$out/tile.$SLURM_ARRAY_TASK_ID.png" --resume
