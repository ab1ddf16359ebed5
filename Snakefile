# `snakemake` in this folder. The workflow lies where it is sought as a module and by snakedeploy.
include: "workflow/Snakefile"


rule study:
    default_target: True
    input:
        lambda w: contents.files(),
