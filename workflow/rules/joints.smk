rule connect_nodes:
    input:
        assembly=lambda w: layout.path("assembly", assembly=study.case(w.case).assembly),
        modes=lambda w: layout.path(
            "modes", assembly=study.case(w.case).assembly, basis=w.basis
        ),
        preload=lambda w: preload_of(w.case),
    output:
        joint=node_to_node("{case}", "{basis}"),
    log:
        "results/logs/connect_nodes/{case}_{basis}.log",
    conda:
        "../envs/boltjoint.yaml"
    resources:
        **SMALL,
    params:
        library=lambda w: library(
            "connect_nodes.py", [maker_of(study.case(w.case).assembly)]
        ),
        contact=lambda w: study.case(w.case).contact.options,
        excitation=lambda w: study.case(w.case).excitation,
        sensors=lambda w: (*study.case(w.case).sensors, *study.case(w.case).outputs),
        of_sweep=lambda w: is_of_sweep(w.case, w.basis, REFERENCE[0]),
    script:
        "../scripts/connect_nodes.py"


rule partition_regions:
    input:
        joint=node_to_node("{case}", "{basis}"),
        preload=lambda w: preload_of(w.case),
    output:
        joint=layout.PATHS["joint"],
    log:
        "results/logs/partition_regions/{case}_{basis}_{joint}.log",
    wildcard_constraints:
        joint="(regions|clusters)=[^/]+",
    conda:
        "../envs/boltjoint.yaml"
    resources:
        **SMALL,
    params:
        library=library("partition_regions.py"),
        regions=lambda w: study.case(w.case).partition(w.joint),
        of_sweep=lambda w: is_of_sweep(w.case, w.basis, w.joint),
    script:
        "../scripts/partition_regions.py"


rule weigh_pairs:
    input:
        joint=node_to_node("{case}", "{basis}"),
    output:
        joint=layout.PATHS["joint"],
    log:
        "results/logs/weigh_pairs/{case}_{basis}_{joint}.log",
    benchmark:
        "results/benchmarks/weigh_pairs/{case}_{basis}_{joint}.tsv"
    wildcard_constraints:
        joint="hyper=[^/]+",
    conda:
        "../envs/boltjoint.yaml"
    resources:
        **SMALL,
    params:
        library=library("weigh_pairs.py"),
        problem=lambda w: problem(w.case, w.basis),
        accuracy=lambda w: study.hyper_reduction.options(w.joint),
    script:
        "../scripts/weigh_pairs.py"


rule reduce_joint:
    input:
        joint=regions_of_joint,
    output:
        joint=layout.PATHS["joint"],
        timing=layout.PATHS["fit_timing"],
        checksum=layout.beside(layout.PATHS["fit_timing"]),
    log:
        "results/logs/reduce_joint/{case}_{basis}_{joint}.log",
    benchmark:
        "results/benchmarks/reduce_joint/{case}_{basis}_{joint}.tsv"
    wildcard_constraints:
        joint=".+/.+",
    conda:
        "../envs/boltjoint.yaml"
    resources:
        mem_mb=lambda w: resources_of("fit", w.case, f"{w.basis}/{w.joint}")["mem_mb"],
        runtime=lambda w: resources_of("fit", w.case, f"{w.basis}/{w.joint}")["runtime"],
    params:
        library=library("reduce_joint.py"),
        reduction=lambda w: study.fitting.options(w.joint),
        of_sweep=lambda w: is_of_sweep(w.case, w.basis, w.joint),
    script:
        "../scripts/reduce_joint.py"
