"""Record the machine and the packages that a study ran with."""

import json

from boltjoint import checksums
from boltjoint.provenance import logs

logs.write_to(snakemake.log[0])
record = dict(snakemake.params.record)
checksums.write_text(snakemake.output.environment, json.dumps(record, indent=2) + "\n")
