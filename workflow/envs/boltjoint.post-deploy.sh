#!/usr/bin/env bash
# Run by Snakemake in the new environment, from the folder of the study.
set -euo pipefail
python -m pip install --no-deps --editable .
