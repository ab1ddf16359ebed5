"""March the solutions of a joint in time: do they hold?"""

from boltjoint import dataset
from boltjoint.verification import residual_in_time
from boltjoint.workflow import logs

logs.write_to(snakemake.log[0])
check = residual_in_time.check_solutions(
    dataset.load(snakemake.input.joint), dataset.load(snakemake.input.response)
)
check.to_csv(snakemake.output.check, index=False)
