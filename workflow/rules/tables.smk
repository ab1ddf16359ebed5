rule tabulate_structure:
    input:
        modes=data("modes"),
        preloads=data("preload"),
        published=published,
    output:
        reported(tables_of("contact", "natural_frequencies"), "Structure"),
        html_of(tables_of("contact", "natural_frequencies")),
    log:
        "results/logs/tabulate_structure.log",
    conda:
        "../envs/boltjoint.yaml"
    resources:
        **SMALL,
    params:
        library=library("tabulate_structure.py"),
        assemblies=list(study.assemblies),
        preloads=contents.preloads(),
        artefacts=tables_of("contact", "natural_frequencies"),
    script:
        "../scripts/tabulate_structure.py"


for case, basis in contents.cases_and_bases():
    of_basis = {"case": case, "basis": basis}
    tables = tables_of(*TABLES_OF_BASIS, **of_basis)

    rule:
        name:
            f"tabulate_basis_{case}_{basis}"
        input:
            data("joint", **of_basis),
            data("fit_timing", **of_basis),
            data("response", **of_basis),
            data("timing", **of_basis),
            data("check", **of_basis),
            published=published,
        output:
            reported(tables, case),
            html_of(tables),
        log:
            f"results/logs/tabulate_basis/{case}_{basis}.log",
        conda:
            "../envs/boltjoint.yaml"
        resources:
            **SMALL,
        params:
            library=library("tabulate_basis.py"),
            artefacts=tables,
            of_basis=of_basis | {"responses": contents.responses(case, basis)},
            published=study.case(case).published,
        script:
            "../scripts/tabulate_basis.py"


rule tabulate_models:
    input:
        responses=lambda w: [
            response(w.case, each) for each in contents.compared(w.case)
        ],
        timings=lambda w: [
            layout.path("timing", case=w.case, **each._asdict())
            for each in contents.compared(w.case)
        ],
    output:
        **table("models", "{case}", case="{case}"),
    log:
        "results/logs/tabulate_models/{case}.log",
    conda:
        "../envs/boltjoint.yaml"
    resources:
        **SMALL,
    params:
        library=library("tabulate_models.py"),
        compared=lambda w: contents.compared(w.case),
        converged=lambda w: contents.converged(w.case),
    script:
        "../scripts/tabulate_models.py"


rule integrate_in_time:
    input:
        joint=node_to_node("{case}", "{basis}"),
        response=lambda w: response(w.case, contents.integrated(w.case)),
    output:
        **table("harmonics", "{case}", case="{case}", basis="{basis}"),
    log:
        "results/logs/integrate_in_time/{case}_{basis}.log",
    benchmark:
        "results/benchmarks/integrate_in_time/{case}_{basis}.tsv"
    conda:
        "../envs/boltjoint.yaml"
    resources:
        mem_mb=lambda w: resources_of("harmonics", w.case)["mem_mb"],
        runtime=lambda w: resources_of("harmonics", w.case)["runtime"],
    params:
        library=library("integrate_in_time.py"),
        forces=lambda w: study.case(w.case).verification_forces_N,
    script:
        "../scripts/integrate_in_time.py"


rule balance_harmonics:
    input:
        joint=node_to_node("{case}", "{basis}"),
        response=lambda w: response(w.case, contents.in_harmonics(w.case)[w.basis]),
    output:
        **table("harmonic_peaks", "{case}", case="{case}", basis="{basis}"),
    log:
        "results/logs/balance_harmonics/{case}_{basis}.log",
    benchmark:
        "results/benchmarks/balance_harmonics/{case}_{basis}.tsv"
    conda:
        "../envs/boltjoint.yaml"
    resources:
        mem_mb=lambda w: resources_of("harmonics", w.case)["mem_mb"],
        runtime=lambda w: resources_of("harmonics", w.case)["runtime"],
    params:
        library=library("balance_harmonics.py"),
        forces=lambda w: study.case(w.case).verification_forces_N,
    script:
        "../scripts/balance_harmonics.py"


rule tabulate_sampling:
    input:
        joints=[
            layout.path("joint", case=case, basis=each.basis, joint=each.joint)
            for case, each in references.items()
        ],
        responses=[response(case, each) for case, each in references.items()],
    output:
        **table("sampling", "All cases"),
    log:
        "results/logs/tabulate_sampling.log",
    conda:
        "../envs/boltjoint.yaml"
    resources:
        **SMALL,
    params:
        library=library("tabulate_sampling.py"),
        cases=list(references),
    script:
        "../scripts/tabulate_sampling.py"


rule tabulate_patterns:
    input:
        modes=[
            layout.path("modes", assembly="{assembly}", basis=basis)
            for basis in study.convergence.bases
        ],
        patterns=layout.PATHS["patterns"],
    output:
        **table("patterns", "Structure", assembly="{assembly}"),
    log:
        "results/logs/tabulate_patterns/{assembly}.log",
    conda:
        "../envs/boltjoint.yaml"
    resources:
        **SMALL,
    params:
        library=library("tabulate_patterns.py"),
        bases=study.convergence.bases,
    script:
        "../scripts/tabulate_patterns.py"


rule tabulate_bases:
    input:
        peaks=[
            layout.path("peaks", case="{case}", basis=basis, joint=REFERENCE[0])
            for basis in study.convergence.bases
        ],
    output:
        **table("bases", "{case}", case="{case}"),
    log:
        "results/logs/tabulate_bases/{case}.log",
    conda:
        "../envs/boltjoint.yaml"
    resources:
        **SMALL,
    params:
        library=library("tabulate_bases.py"),
        bases=study.convergence.bases,
    script:
        "../scripts/tabulate_bases.py"


rule tabulate_divisions:
    input:
        joint=node_to_node("{case}", "{basis}"),
        preload=lambda w: preload_of(w.case),
        peaks=layout.path("peaks", case="{case}", basis="{basis}", joint=REFERENCE[0]),
    output:
        **table("divisions", "{case}", case="{case}", basis="{basis}"),
    log:
        "results/logs/tabulate_divisions/{case}_{basis}.log",
    benchmark:
        "results/benchmarks/tabulate_divisions/{case}_{basis}.tsv"
    conda:
        "../envs/boltjoint.yaml"
    resources:
        **SMALL,
    params:
        library=library("tabulate_divisions.py"),
        options=lambda w: {
            "counts": study.convergence.regions,
            "damping": study.case(w.case).structural_damping,
            "division": study.case(w.case).regions.division,
        },
        steps=study.solver.steps,
    script:
        "../scripts/tabulate_divisions.py"
