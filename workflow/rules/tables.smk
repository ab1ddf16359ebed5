# A rule for each job of tables: which there are, and what they read, is declared with the tables.
for job in DISPLAYS.jobs(contents, "table"):

    rule:
        name:
            f"tabulate_{job.name}"
        input:
            job.inputs,
            published=published if job.is_compared else [],
        output:
            reported(job.artefacts),
            [path for each in job.artefacts for path in each.paths[1:]],
        log:
            f"results/logs/tabulate/{job.name}.log",
        benchmark:
            f"results/benchmarks/tabulate/{job.name}.tsv"
        conda:
            "../envs/boltjoint.yaml"
        resources:
            **resources_of(job.stage, job.subject),
        params:
            library=library("tabulate.py", job.modules),
            artefacts=job.artefacts,
            options=job.options,
            counterparts=job.counterparts,
        script:
            "../scripts/tabulate.py"
