rule connect_nodes:
    input:
        modes=lambda w: layout.modes_of_case(study, w.case, w.modes),
        preload=lambda w: layout.preload_of_case(study, w.case),
    output:
        joint="results/cases/{case}/{modes}/node-to-node/joint.nc",
    log:
        "results/logs/connect_nodes/{case}_{modes}.log",
    conda:
        "../envs/boltjoint.yaml"
    params:
        library=library("connect_nodes.py"),
        contact=lambda w: case_of(w).contact.model_dump(exclude={"law"}),
    script:
        "../scripts/connect_nodes.py"


rule partition_regions:
    input:
        joint="results/cases/{case}/{modes}/node-to-node/joint.nc",
        preload=lambda w: layout.preload_of_case(study, w.case),
    output:
        joint="results/cases/{case}/{modes}/{regions}/joint.nc",
    log:
        "results/logs/partition_regions/{case}_{modes}_{regions}.log",
    conda:
        "../envs/boltjoint.yaml"
    params:
        library=library("partition_regions.py"),
        regions=lambda w: case_of(w).partition(w.regions),
    script:
        "../scripts/partition_regions.py"


rule fit_reduced_joint:
    input:
        joint="results/cases/{case}/{modes}/{regions}/joint.nc",
    output:
        joint="results/cases/{case}/{modes}/{regions}/{fit}/joint.nc",
        timing="results/cases/{case}/{modes}/{regions}/{fit}/fit_timing.csv",
    log:
        "results/logs/fit_reduced_joint/{case}_{modes}_{regions}_{fit}.log",
    benchmark:
        "results/benchmarks/fit_reduced_joint/{case}_{modes}_{regions}_{fit}.tsv"
    conda:
        "../envs/boltjoint.yaml"
    params:
        library=library("fit_reduced_joint.py"),
        fit=lambda w: study.fitting.fit(f"{w.regions}/{w.fit}"),
    script:
        "../scripts/fit_reduced_joint.py"


rule tabulate_joint:
    input:
        joint="results/cases/{case}/{modes}/{regions}/joint.nc",
    output:
        joint="results/cases/{case}/{modes}/{regions}/table/joint.nc",
    log:
        "results/logs/tabulate_joint/{case}_{modes}_{regions}.log",
    conda:
        "../envs/boltjoint.yaml"
    params:
        library=library("tabulate_joint.py"),
    script:
        "../scripts/tabulate_joint.py"
