#!/bin/bash
#SBATCH --job-name=trochoid.a
#SBATCH --array=0-23
#SBATCH --ntasks=1
#SBATCH --cpus-per-task=4
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

chunks=(
    1-2
    3
)
frames=${chunks[task % 2]}
regions=(
    '0,0,5,4'
    '5,0,5,4'
    '10,0,6,4'
    '0,4,5,4'
    '5,4,5,4'
    '10,4,6,4'
)
tile=$((task / 2 % 6))
region=${regions[tile]}
number=$(printf %04d "$tile")
values=(
    'mix.b=#fff'
    'mix.b=#f00'
)
value=${values[task / 12]}
folders=(
    'mix.b=_fff'
    'mix.b=_f00'
)
out=out/${folders[task / 12]}

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
run "$trochoid" render \
    graph/a.json \
    --frames "$frames" \
    '--set=mix.a=#012' \
    --set="$value" \
    --out "$out"/'tiles/{output}.####.t'"$number".exr \
    --region "$region" \
    --threads 4 --memory 256MiB --resume
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
