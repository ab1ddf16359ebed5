"""Record the machine and the packages that a study ran with."""

import json
from pathlib import Path

from boltjoint.workflow import logs

logs.write_to(snakemake.log[0])
record = dict(snakemake.params.record)
Path(snakemake.output[0]).write_text(json.dumps(record, indent=2) + "\n")
