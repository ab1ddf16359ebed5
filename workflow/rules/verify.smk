# What CalculiX finds in an assembly, beside the library's own: made by `make verify`, not by `all`.

VERIFIED = {
    "assembly": layout.path("assembly", assembly="three_bolt"),
    "modes": layout.path("modes", assembly="three_bolt", basis="free-4"),
    "preload": layout.path("preload", assembly="three_bolt", preload_N=10000),
}


rule write_decks:
    input:
        **VERIFIED,
    output:
        modes="results/verification/modes/calculix.inp",
        preload="results/verification/preload/calculix.inp",
    log:
        "results/logs/write_decks.log",
    conda:
        "../envs/boltjoint.yaml"
    resources:
        **SMALL,
    params:
        library=library("write_decks.py"),
    script:
        "../scripts/write_decks.py"


rule run_calculix:
    input:
        deck="results/verification/{deck}/calculix.inp",
    output:
        printed="results/verification/{deck}/calculix.dat",
    log:
        job="results/logs/run_calculix/{deck}.log",
        program="results/logs/run_calculix/{deck}_ccx.log",
    benchmark:
        "results/benchmarks/run_calculix/{deck}.tsv"
    wildcard_constraints:
        deck="modes|preload",
    conda:
        "../envs/boltjoint.yaml"
    resources:
        mem_mb=4000,
        runtime=20,
    params:
        library=library("run_calculix.py"),
    script:
        "../scripts/run_calculix.py"


rule compare_calculix:
    input:
        **VERIFIED,
        printed_modes="results/verification/modes/calculix.dat",
        printed_preload="results/verification/preload/calculix.dat",
    output:
        csv="results/verification/calculix.csv",
        html="results/verification/calculix.html",
        checksum=layout.beside("results/verification/calculix.csv"),
    log:
        "results/logs/compare_calculix.log",
    conda:
        "../envs/boltjoint.yaml"
    resources:
        **SMALL,
    params:
        library=library("compare_calculix.py"),
    script:
        "../scripts/compare_calculix.py"
