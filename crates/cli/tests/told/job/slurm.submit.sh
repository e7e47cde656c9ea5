#!/bin/bash
# Submits the job; options are those of sbatch, such as --partition=night.
set -euo pipefail
cd -- "$(dirname -- "${BASH_SOURCE[0]}")"
mkdir -p logs
render=$(sbatch --parsable "$@" job.sh)
echo "Submitted batch job ${render%%;*}"
sbatch --dependency="afterok:${render%%;*}" --kill-on-invalid-dep=yes "$@" join.sh
