#!/bin/bash
#SBATCH --job-name=join.a
#SBATCH --array=0-5
#SBATCH --ntasks=1
#SBATCH --cpus-per-task=1
#SBATCH --mem=512M
#SBATCH --time=90
#SBATCH --signal=B:TERM@30
#SBATCH --requeue
#SBATCH --open-mode=append
#SBATCH --output=logs/%x.%A_%a.log
# Submitted by submit.sh, in this folder, which all machines must reach.
set -u
trochoid=${TROCHOID:-trochoid}
task=$SLURM_ARRAY_TASK_ID

frames=(
    1
    2
    3
)
frame=${frames[task % 3]}
folders=(
    'mix.b=_fff'
    'mix.b=_f00'
)
out=out/${folders[task / 3]}

run() {
    local stopped=
    "$@" &
    trap 'stopped=1; kill -TERM "$!" 2> /dev/null' TERM
    wait "$!"
    code=$?
    # The signal ended the wait; the command has yet to end.
    if [ -n "$stopped" ]; then
        wait "$!"
        code=$?
    fi
    return "$code"
}
digits=${frame#-}
sign=${frame%"$digits"}

# Joins the tiles of a picture, whose name is given without its ending.
join() {
    local tiles=() tile
    for ((tile = 0; tile < 6; tile++)); do
        tiles+=("$out/tiles/$1.t$(printf %04d "$tile").exr")
    done
    run "$trochoid" join "${tiles[@]}" -o "$out/$1.exr"
}

join beauty."$sign$(printf %04d "$digits")" &&
join mask."$sign$(printf %04d "$digits")"
case $code in
    0) exit 0 ;;
    126 | 127) echo "$trochoid cannot be run on $(hostname): export TROCHOID=/PATH/OF/trochoid and submit again" >&2 ;;
    1 | 129 | 13[1-9] | 14[0-24-9] | 1[5-9]?)
        if [ "${SLURM_RESTART_COUNT:-0}" -lt 3 ]; then
            echo "ended with code $code: trying again" >&2
            scontrol requeue "${SLURM_ARRAY_JOB_ID}_$SLURM_ARRAY_TASK_ID"
        fi
        ;;
esac
exit "$code"
