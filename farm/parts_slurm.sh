#!/usr/bin/env bash
# One file of a simulation per task of a Slurm array, each sifted where it lies; then the frame of all, which waits for them:
#
#   parts=$(sbatch --parsable --array=1-1000 farm/parts_slurm.sh files.txt parts --eye 0,0,900 --at 0,0,0 --size 1920x1080)
#   sbatch --dependency=afterok:$parts --wrap 'halfline render --visible parts/*.npz -o frame.png'
#
# files.txt has a line for each task: the file and the id of its first sphere. Options of a camera belong to all tasks.
#
#SBATCH --job-name=halfline-parts
#SBATCH --requeue
# A part is written completely or not at all; a task that is repeated writes the same bytes.
set -euo pipefail
list="$1" out="$2"
shift 2
mkdir -p "$out"
read -r file first < <(sed -n "${SLURM_ARRAY_TASK_ID}p" "$list")
exec halfline sift "$file" --first-id "$first" "$@" -o "$out/part.$SLURM_ARRAY_TASK_ID.npz"
