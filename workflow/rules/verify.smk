# What CalculiX finds in an assembly, beside the library's own: made by `make verify`, not by `all`.

DECKS = ("modes", "preload", "prestressed")
CALCULIX = "results/verification/{assembly}/"
OURS = {
    "assembly": layout.PATHS["assembly"],
    "structure": layout.PATHS["structure"],
    "modes": layout.path("modes", assembly="{assembly}", basis="free-4"),
    "preload": lambda w: preload_of_assembly(w.assembly),
}


rule write_decks:
    input:
        **OURS,
        files=lambda w: study.assembly(w.assembly).named_files,
    output:
        **{deck: f"{CALCULIX}{deck}/calculix.inp" for deck in DECKS},
    log:
        "results/logs/write_decks/{assembly}.log",
    conda:
        "../envs/boltjoint.yaml"
    resources:
        **SMALL,
    params:
        library=lambda w: library("write_decks.py", calculix_of(w.assembly)),
        assembly=content_of,
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
        deck="|".join(DECKS),
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
        **OURS,
        **{f"printed_{deck}": f"{CALCULIX}{deck}/calculix.dat" for deck in DECKS},
        files=lambda w: study.assembly(w.assembly).named_files,
    output:
        csv=f"{CALCULIX}calculix.csv",
        html=f"{CALCULIX}calculix.html",
        checksum=layout.beside(f"{CALCULIX}calculix.csv"),
    log:
        "results/logs/compare_calculix/{assembly}.log",
    conda:
        "../envs/boltjoint.yaml"
    resources:
        mem_mb=lambda w: resources_of("preload", w.assembly)["mem_mb"],
        runtime=lambda w: resources_of("preload", w.assembly)["runtime"],
    params:
        library=lambda w: library("compare_calculix.py", calculix_of(w.assembly)),
        assembly=content_of,
        decks=DECKS,
    script:
        "../scripts/compare_calculix.py"
