"""March the solutions of a joint in time: do they hold?"""

from boltjoint import dataset, logs, march

logs.write_to(snakemake.log[0])
check = march.check_solutions(
    dataset.load(snakemake.input.joint), dataset.load(snakemake.input.response)
)
check.to_csv(snakemake.output.check, index=False)
