rule plot_modes:
    input:
        assembly="results/assemblies/{assembly}/assembly.nc",
        modes="results/assemblies/{assembly}/{modes}/modes.nc",
    output:
        figure="results/figures/modes_{assembly}_{modes}.svg",
    log:
        "results/logs/plot_modes/{assembly}_{modes}.log",
    conda:
        "../envs/boltjoint.yaml"
    params:
        library=library("plot_modes.py"),
    script:
        "../scripts/plot_modes.py"


rule plot_contact:
    input:
        assembly="results/assemblies/{assembly}/assembly.nc",
        preload="results/assemblies/{assembly}/preload={newton}/preload.nc",
    output:
        figure="results/figures/contact_{assembly}_preload={newton}.svg",
    log:
        "results/logs/plot_contact/{assembly}_{newton}.log",
    conda:
        "../envs/boltjoint.yaml"
    params:
        library=library("plot_contact.py"),
    script:
        "../scripts/plot_contact.py"


rule plot_regions:
    input:
        assembly=lambda w: layout.assembly(case_of(w).assembly),
        joint="results/cases/{case}/{modes}/{regions}/joint.nc",
    output:
        figure="results/figures/regions_{case}_{modes}_{regions}.svg",
    log:
        "results/logs/plot_regions/{case}_{modes}_{regions}.log",
    conda:
        "../envs/boltjoint.yaml"
    params:
        library=library("plot_regions.py"),
    script:
        "../scripts/plot_regions.py"


rule plot_loops:
    input:
        reduced="results/cases/{case}/{modes}/{regions}/{fit}/joint.nc",
        regions="results/cases/{case}/{modes}/{regions}/joint.nc",
    output:
        figure="results/figures/loops_{case}_{modes}_{regions}_{fit}.svg",
    log:
        "results/logs/plot_loops/{case}_{modes}_{regions}_{fit}.log",
    conda:
        "../envs/boltjoint.yaml"
    params:
        library=library("plot_loops.py"),
        region=lambda w: source_of(w).region_of_loops(f"{w.regions}/{w.fit}"),
    script:
        "../scripts/plot_loops.py"


rule plot_response:
    input:
        response=lambda w: layout.response(
            w.case, w.modes, layout.unflat(w.flat), w.coordinates, int(w.resonance)
        ),
        reference=reference_of,
    output:
        figure="results/figures/response_{case}_{modes}_{flat}_{coordinates}_resonance={resonance}.svg",
    log:
        "results/logs/plot_response/{case}_{modes}_{flat}_{coordinates}_{resonance}.log",
    conda:
        "../envs/boltjoint.yaml"
    params:
        library=library("plot_response.py"),
        joint=lambda w: layout.unflat(w.flat),
    script:
        "../scripts/plot_response.py"


rule plot_mesh:
    input:
        assembly="results/assemblies/{assembly}/assembly.nc",
    output:
        figure="results/figures/mesh_{assembly}.svg",
    log:
        "results/logs/plot_mesh/{assembly}.log",
    conda:
        "../envs/boltjoint.yaml"
    params:
        library=library("plot_mesh.py"),
    script:
        "../scripts/plot_mesh.py"


rule plot_deformation:
    input:
        assembly="results/assemblies/{assembly}/assembly.nc",
        preload="results/assemblies/{assembly}/preload={newton}/preload.nc",
    output:
        figure="results/figures/deformation_{assembly}_preload={newton}.svg",
    log:
        "results/logs/plot_deformation/{assembly}_{newton}.log",
    conda:
        "../envs/boltjoint.yaml"
    params:
        library=library("plot_deformation.py"),
    script:
        "../scripts/plot_deformation.py"


rule plot_states:
    input:
        assembly=lambda w: layout.assembly(case_of(w).assembly),
        joint=lambda w: layout.joint(w.case, w.modes, layout.unflat(w.flat)),
        response=lambda w: layout.response(
            w.case, w.modes, layout.unflat(w.flat), w.coordinates, int(w.resonance)
        ),
    output:
        figure="results/figures/states_{case}_{modes}_{flat}_{coordinates}_resonance={resonance}.svg",
    log:
        "results/logs/plot_states/{case}_{modes}_{flat}_{coordinates}_{resonance}.log",
    conda:
        "../envs/boltjoint.yaml"
    params:
        library=library("plot_states.py"),
    script:
        "../scripts/plot_states.py"


rule plot_times:
    input:
        table="results/tables/times_{case}_{modes}.csv",
    output:
        figure="results/figures/times_{case}_{modes}_resonance={resonance}.svg",
    log:
        "results/logs/plot_times/{case}_{modes}_{resonance}.log",
    conda:
        "../envs/boltjoint.yaml"
    params:
        library=library("plot_times.py"),
    script:
        "../scripts/plot_times.py"


rule plot_backbones:
    input:
        backbones=lambda w: [
            layout.backbone(w.case, w.modes, name, int(w.resonance))
            for name in backbones(w)
        ],
    output:
        figure="results/figures/backbone_{case}_{modes}_resonance={resonance}.svg",
    log:
        "results/logs/plot_backbones/{case}_{modes}_{resonance}.log",
    conda:
        "../envs/boltjoint.yaml"
    params:
        library=library("plot_backbones.py"),
        joints=lambda w: backbones(w),
        forces=lambda w: case_of(w).forces_N,
    script:
        "../scripts/plot_backbones.py"


rule plot_table:
    input:
        table="results/tables/{drawn}.csv",
    output:
        figure="results/figures/{drawn}.svg",
    log:
        "results/logs/plot_table/{drawn}.log",
    wildcard_constraints:
        drawn="(bases|divisions|models|patterns)_.+|sampling",
    conda:
        "../envs/boltjoint.yaml"
    params:
        library=library("plot_table.py"),
    script:
        "../scripts/plot_table.py"
