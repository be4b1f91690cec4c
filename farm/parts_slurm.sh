#!/usr/bin/env bash
# One file of a simulation per task of a Slurm array, each sifted where it lies; then the frame of all, which waits for them:
#
#   parts=$(sbatch --parsable --array=1-1000 farm/parts_slurm.sh files.txt parts --eye 0,0,900 --at 0,0,0 --size 1920x1080)
#   sbatch --dependency=afterok:$parts --wrap 'halfline render --visible parts/*.npz -o frame.png'
#
# files.txt has a line for each task: the file, a blank, and the id of its first sphere. Options of a camera belong to all tasks.
#
#SBATCH --job-name=halfline-parts
#SBATCH --requeue
#SBATCH --signal=B:TERM@60
# A part is written completely or not at all; a task that is repeated writes the same bytes.
set -euo pipefail
list="$1" out="$2"
shift 2
line="$(sed -n "${SLURM_ARRAY_TASK_ID}p" "$list")"
line="${line%$'\r'}"
file="${line% *}" first="${line##* }"
if [[ ! $line =~ ^.+\ [0-9]+$ ]]; then
    echo "$list: line $SLURM_ARRAY_TASK_ID is '$line'; write a file and the id of its first sphere" >&2
    exit 2
fi
mkdir -p "$out"
exec halfline sift "$file" --first-id "$first" "$@" -o "$out/part.$SLURM_ARRAY_TASK_ID.npz"
