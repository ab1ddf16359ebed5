rule build_assembly:
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
        library=library("build_assembly.py"),
        assembly=lambda w: study.assemblies[w.assembly].model_dump(
            exclude={"preload_N"}
        ),
    script:
        "../scripts/build_assembly.py"


rule apply_preload:
    input:
        assembly="results/assemblies/{assembly}/assembly.nc",
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
        library=library("apply_preload.py"),
        preload=lambda w: float(w.newton),
    script:
        "../scripts/apply_preload.py"


rule find_pod_modes:
    input:
        assembly="results/assemblies/{assembly}/assembly.nc",
        preload=lambda w: layout.contact_of_basis(study, w.assembly),
    output:
        principal="results/assemblies/{assembly}/principal.nc",
    log:
        "results/logs/find_pod_modes/{assembly}.log",
    benchmark:
        "results/benchmarks/find_pod_modes/{assembly}.tsv"
    conda:
        "../envs/boltjoint.yaml"
    params:
        library=library("find_pod_modes.py"),
        contact_adapted_basis=study.contact_adapted_basis.options,
        most=study.contact_adapted_basis.most,
    script:
        "../scripts/find_pod_modes.py"


rule find_modes:
    input:
        assembly="results/assemblies/{assembly}/assembly.nc",
        principal=lambda w: (
            layout.principal(w.assembly) if is_enriched(w.modes) else []
        ),
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
        library=library("find_modes.py"),
        family="{modes}",
    script:
        "../scripts/find_modes.py"


rule find_patterns:
    input:
        assembly="results/assemblies/{assembly}/assembly.nc",
        preload=lambda w: layout.contact_of_basis(study, w.assembly),
    output:
        patterns="results/assemblies/{assembly}/patterns.nc",
    log:
        "results/logs/find_patterns/{assembly}.log",
    benchmark:
        "results/benchmarks/find_patterns/{assembly}.tsv"
    conda:
        "../envs/boltjoint.yaml"
    params:
        library=library("find_patterns.py"),
        options={
            "stiffness": study.contact_adapted_basis.contact_stiffness_N_per_m,
            "number": COMPARED_RESONANCES,
        },
    script:
        "../scripts/find_patterns.py"
