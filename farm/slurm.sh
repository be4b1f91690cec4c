#!/usr/bin/env bash
# One tile per task of a Slurm array; then the merge, which waits for all of them:
#
#   tiles=$(sbatch --parsable --array=1-16 farm/slurm.sh capsid.pdb capsid --assembly 1 --size 4096x4096)
#   sbatch --dependency=afterok:$tiles --wrap 'halfline merge capsid/tile.*.png -o capsid/full.png'
#
# An array of some tiles only, such as --array=7, is told their number: sbatch --export=ALL,TILES=16 --array=7 farm/slurm.sh ...
#
#SBATCH --job-name=halfline
#SBATCH --requeue
#SBATCH --signal=B:TERM@60
# A requeued task skips its finished tiles (--resume). SIGTERM, a minute before the kill, leaves no partial file; without B: Slurm
# sends it to the steps of srun alone, and there are none.
set -euo pipefail
scene="$1" out="$2"
shift 2
tiles="${TILES:-$SLURM_ARRAY_TASK_COUNT}"
if [[ -z ${TILES:-} && $SLURM_ARRAY_TASK_MIN-$SLURM_ARRAY_TASK_MAX != "1-$SLURM_ARRAY_TASK_COUNT" ]]; then
    echo "the array is not 1-N; add --export=ALL,TILES=N, the number of all tiles" >&2
    exit 2
fi
mkdir -p "$out"
exec halfline render "$scene" "$@" --tile "$SLURM_ARRAY_TASK_ID/$tiles" -o "$out/tile.$SLURM_ARRAY_TASK_ID.png" --resume
