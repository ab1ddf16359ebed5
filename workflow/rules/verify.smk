# What CalculiX finds in an assembly, beside the library's own: made by `make verify`, not by `all`.

#: those that the study has, with 10 kN in each bolt
VERIFIED = [
    name for name in ("three_bolt", "three_bolt_aluminium") if name in study.assemblies
] or ["three_bolt"]
OURS = {
    "assembly": layout.PATHS["assembly"],
    "modes": layout.path("modes", assembly="{assembly}", basis="free-4"),
    "preload": layout.path("preload", assembly="{assembly}", preload_N=10000),
}
DECKS = {
    name: f"results/verification/{{assembly}}/{name}/calculix.inp"
    for name in ("modes", "preload")
}
PRINTED = {
    f"printed_{name}": path.replace(".inp", ".dat") for name, path in DECKS.items()
}


rule write_decks:
    input:
        **OURS,
    output:
        **DECKS,
    log:
        "results/logs/write_decks/{assembly}.log",
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
        deck="results/verification/{assembly}/{deck}/calculix.inp",
    output:
        printed="results/verification/{assembly}/{deck}/calculix.dat",
    log:
        job="results/logs/run_calculix/{assembly}_{deck}.log",
        program="results/logs/run_calculix/{assembly}_{deck}_ccx.log",
    benchmark:
        "results/benchmarks/run_calculix/{assembly}_{deck}.tsv"
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
        **{
            name: expand(path, assembly=VERIFIED)
            for name, path in (OURS | PRINTED).items()
        },
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
        assemblies=VERIFIED,
    script:
        "../scripts/compare_calculix.py"
