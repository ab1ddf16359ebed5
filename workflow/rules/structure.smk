rule build_assembly:
    input:
        library=library("build_assembly.py"),
    output:
        assembly="results/assemblies/{assembly}/assembly.nc",
        mesh="results/assemblies/{assembly}/mesh.vtu",
    log:
        "results/logs/build_assembly/{assembly}.log",
    benchmark:
        "results/benchmarks/build_assembly/{assembly}.tsv"
    conda:
        "../envs/boltjoint.yaml"
    params:
        assembly=lambda w: study.assemblies[w.assembly].model_dump(
            exclude={"preload_N"}
        ),
    script:
        "../scripts/build_assembly.py"


rule apply_preload:
    input:
        assembly="results/assemblies/{assembly}/assembly.nc",
        library=library("apply_preload.py"),
    output:
        preload="results/assemblies/{assembly}/preload={newton}/preload.nc",
        view="results/assemblies/{assembly}/preload={newton}/preload.vtu",
    log:
        "results/logs/apply_preload/{assembly}_{newton}.log",
    benchmark:
        "results/benchmarks/apply_preload/{assembly}_{newton}.tsv"
    conda:
        "../envs/boltjoint.yaml"
    params:
        preload=lambda w: float(w.newton),
    script:
        "../scripts/apply_preload.py"


rule find_modes:
    input:
        assembly="results/assemblies/{assembly}/assembly.nc",
        preload=contact_of_basis,
        library=library("find_modes.py"),
    output:
        modes="results/assemblies/{assembly}/{modes}/modes.nc",
        view="results/assemblies/{assembly}/{modes}/modes.vtu",
    log:
        "results/logs/find_modes/{assembly}_{modes}.log",
    benchmark:
        "results/benchmarks/find_modes/{assembly}_{modes}.tsv"
    conda:
        "../envs/boltjoint.yaml"
    params:
        family="{modes}",
        enrichment=lambda w: (
            study.enrichment.options if is_enriched(w.modes) else None
        ),
    script:
        "../scripts/find_modes.py"
