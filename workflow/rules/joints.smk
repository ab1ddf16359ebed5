rule connect_nodes:
    input:
        modes=lambda w: layout.modes_of_case(study, w.case, w.modes),
        preload=lambda w: layout.preload_of_case(study, w.case),
        library=library("connect_nodes.py"),
    output:
        joint="results/cases/{case}/{modes}/node-to-node/joint.nc",
    log:
        "results/logs/connect_nodes/{case}_{modes}.log",
    conda:
        "../envs/boltjoint.yaml"
    params:
        contact=lambda w: case_of(w).contact.model_dump(exclude={"law"}),
    script:
        "../scripts/connect_nodes.py"


rule partition_regions:
    input:
        joint="results/cases/{case}/{modes}/node-to-node/joint.nc",
        preload=lambda w: layout.preload_of_case(study, w.case),
        library=library("partition_regions.py"),
    output:
        joint="results/cases/{case}/{modes}/regions={n}/joint.nc",
    log:
        "results/logs/partition_regions/{case}_{modes}_{n}.log",
    conda:
        "../envs/boltjoint.yaml"
    params:
        regions=lambda w: int(w.n),
        division=lambda w: case_of(w).regions.division,
    script:
        "../scripts/partition_regions.py"


rule fit_reduced_joint:
    input:
        joint="results/cases/{case}/{modes}/regions={n}/joint.nc",
        library=library("fit_reduced_joint.py"),
    output:
        joint="results/cases/{case}/{modes}/regions={n}/elements={m}/joint.nc",
    log:
        "results/logs/fit_reduced_joint/{case}_{modes}_{n}_{m}.log",
    benchmark:
        "results/benchmarks/fit_reduced_joint/{case}_{modes}_{n}_{m}.tsv"
    conda:
        "../envs/boltjoint.yaml"
    params:
        elements=lambda w: int(w.m),
        fitting=study.fitting.model_dump(),
    script:
        "../scripts/fit_reduced_joint.py"
