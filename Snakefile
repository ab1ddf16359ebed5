from snakemake.utils import min_version

min_version("9.0")


report: "workflow/report/workflow.rst"


include: "workflow/rules/study.smk"
include: "workflow/rules/structure.smk"
include: "workflow/rules/joints.smk"
include: "workflow/rules/responses.smk"
include: "workflow/rules/sweeps.smk"
include: "workflow/rules/tables.smk"
include: "workflow/rules/figures.smk"
include: "workflow/rules/report.smk"
include: "workflow/rules/verify.smk"


rule all:
    default_target: True
    input:
        contents.files(),


rule tables:
    input:
        contents.files(form="table"),


rule figures:
    input:
        contents.files(form="figure"),


rule pages:
    input:
        contents.files(form="page"),


onstart:
    logger.info(estimate.summary(needed, memory, cores))
    # Every job that has finished would make Snakemake ask once a second, until the end, whether the
    # limit of jobs a second allows another one (its issue 2967): after hundreds of jobs it does
    # little else. Here cores are the limit.
    workflow.scheduler.job_rate_limiter = None
