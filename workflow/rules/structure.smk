rule build_assembly:
    input:
        files=lambda w: study.assembly(w.assembly).named_files,
    output:
        assembly=layout.PATHS["assembly"],
        structure=layout.PATHS["structure"],
        mesh=layout.PATHS["mesh_view"],
    log:
        "results/logs/build_assembly/{assembly}.log",
    benchmark:
        "results/benchmarks/build_assembly/{assembly}.tsv"
    conda:
        "../envs/boltjoint.yaml"
    resources:
        mem_mb=lambda w: resources_of("build", w.assembly)["mem_mb"],
        runtime=lambda w: resources_of("build", w.assembly)["runtime"],
    params:
        library=lambda w: library("build_assembly.py", [maker_of(w.assembly)]),
        assembly=content_of,
        files=lambda w: [
            study.hashes[file] for file in study.assembly(w.assembly).named_files
        ],
    script:
        "../scripts/build_assembly.py"


rule apply_preload:
    input:
        assembly=layout.PATHS["assembly"],
        structure=layout.PATHS["structure"],
    output:
        preload=layout.PATHS["preload"],
        view=layout.PATHS["preload_view"],
    log:
        "results/logs/apply_preload/{assembly}_{preload_N}.log",
    benchmark:
        "results/benchmarks/apply_preload/{assembly}_{preload_N}.tsv"
    conda:
        "../envs/boltjoint.yaml"
    resources:
        mem_mb=lambda w: resources_of("preload", w.assembly)["mem_mb"],
        runtime=lambda w: resources_of("preload", w.assembly)["runtime"],
    params:
        library=lambda w: library("apply_preload.py", [maker_of(w.assembly)]),
        preload=lambda w: Preload(w.preload_N).of_bolts,
    script:
        "../scripts/apply_preload.py"


rule find_pod_modes:
    input:
        structure=layout.PATHS["structure"],
        preload=lambda w: any_preload(w.assembly),
    output:
        pod_modes=layout.PATHS["pod_modes"],
    log:
        "results/logs/find_pod_modes/{assembly}.log",
    benchmark:
        "results/benchmarks/find_pod_modes/{assembly}.tsv"
    conda:
        "../envs/boltjoint.yaml"
    resources:
        mem_mb=lambda w: resources_of("pod_modes", w.assembly)["mem_mb"],
        runtime=lambda w: resources_of("pod_modes", w.assembly)["runtime"],
    params:
        library=lambda w: library("find_pod_modes.py", [maker_of(w.assembly)]),
        conditions=lambda w: study.contact_conditions(w.assembly),
        contact_adapted_basis=study.contact_adapted_basis.model_dump(),
    script:
        "../scripts/find_pod_modes.py"


rule find_modes:
    input:
        assembly=layout.PATHS["assembly"],
        structure=layout.PATHS["structure"],
        pod_modes=lambda w: (
            layout.path("pod_modes", assembly=w.assembly)
            if Basis(w.basis).is_contact_adapted
            else []
        ),
    output:
        modes=layout.PATHS["modes"],
        view=layout.PATHS["modes_view"],
    log:
        "results/logs/find_modes/{assembly}_{basis}.log",
    benchmark:
        "results/benchmarks/find_modes/{assembly}_{basis}.tsv"
    conda:
        "../envs/boltjoint.yaml"
    resources:
        mem_mb=lambda w: resources_of(w.basis, w.assembly)["mem_mb"],
        runtime=lambda w: resources_of(w.basis, w.assembly)["runtime"],
    params:
        library=lambda w: library("find_modes.py", [maker_of(w.assembly)]),
        family="{basis}",
    script:
        "../scripts/find_modes.py"


rule find_patterns:
    input:
        assembly=layout.PATHS["assembly"],
        structure=layout.PATHS["structure"],
        preload=lambda w: any_preload(w.assembly),
    output:
        patterns=layout.PATHS["patterns"],
    log:
        "results/logs/find_patterns/{assembly}.log",
    benchmark:
        "results/benchmarks/find_patterns/{assembly}.tsv"
    conda:
        "../envs/boltjoint.yaml"
    resources:
        mem_mb=lambda w: resources_of("patterns", w.assembly)["mem_mb"],
        runtime=lambda w: resources_of("patterns", w.assembly)["runtime"],
    params:
        library=lambda w: library("find_patterns.py", [maker_of(w.assembly)]),
        options=lambda w: {
            **study.stuck_stiffness(w.assembly),
            "number": COMPARED_RESONANCES,
        },
    script:
        "../scripts/find_patterns.py"
