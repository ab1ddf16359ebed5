# A rule for each job of figures: which there are, and what they read, is declared with the figures.
for job in DISPLAYS.jobs(contents, "figure"):

    rule:
        name:
            f"draw_{job.name}"
        input:
            job.inputs,
            published=published if job.is_compared else [],
        output:
            [each.path for each in job.artefacts],
        log:
            f"results/logs/draw/{job.name}.log",
        conda:
            "../envs/boltjoint.yaml"
        resources:
            **resources_of(job.stage, job.subject),
        params:
            library=library("draw_figures.py", job.modules),
            artefacts=job.artefacts,
            options=job.options,
            counterparts=job.counterparts,
        script:
            "../scripts/draw_figures.py"
