#!/usr/bin/env bash
# Run by Snakemake in the new environment, from the folder of the study: in a checkout its library is
# installed, elsewhere the release that this workflow belongs to.
set -euo pipefail
if grep --quiet '^name = "boltjoint"$' pyproject.toml 2>/dev/null; then
  python -m pip install --no-deps --editable .
else
  python -m pip install --no-deps boltjoint==1.0.0
fi
