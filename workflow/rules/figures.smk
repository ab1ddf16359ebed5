for assembly in study.assemblies:

    rule:
        name:
            f"draw_structure_{assembly}"
        input:
            data("assembly", assembly=assembly),
            data("modes", assembly=assembly),
            data("preload", assembly=assembly),
        output:
            contents.files(form="figure", assembly=assembly, page="structure"),
        log:
            f"results/logs/draw_structure/{assembly}.log",
        conda:
            "../envs/boltjoint.yaml"
        resources:
            **SMALL,
        params:
            library=library("draw_figures.py"),
            artefacts=contents.select(
                form="figure", assembly=assembly, page="structure"
            ),
            options={},
        script:
            "../scripts/draw_figures.py"


for case, basis in contents.cases_and_bases():
    of_basis = {"case": case, "basis": basis, "page": case}

    rule:
        name:
            f"draw_responses_{case}_{basis}"
        input:
            layout.path("assembly", assembly=study.case(case).assembly),
            data("joint", case=case, basis=basis),
            data("response", case=case, basis=basis),
            data("backbone", case=case, basis=basis),
            times=[
                each.path
                for each in contents.select("times", form="table", **of_basis)
            ],
        output:
            contents.files(form="figure", **of_basis),
        log:
            f"results/logs/draw_responses/{case}_{basis}.log",
        conda:
            "../envs/boltjoint.yaml"
        resources:
            **SMALL,
        params:
            library=library("draw_figures.py"),
            artefacts=contents.select(form="figure", **of_basis),
            options={
                "assembly": study.case(case).assembly,
                "forces": study.case(case).levels,
                "joints": {
                    resonance: contents.backbones(case, basis, resonance)
                    for resonance in study.case(case).resonances(basis)
                },
                "regions": {
                    joint: published_of(case).region_of_loops(joint)
                    for joint in contents.fitted(case, basis)
                },
            },
        script:
            "../scripts/draw_figures.py"


rule draw_convergence:
    input:
        [each.path for each in drawn_tables],
    output:
        [each.path for each in drawn],
    log:
        "results/logs/draw_convergence.log",
    conda:
        "../envs/boltjoint.yaml"
    resources:
        **SMALL,
    params:
        library=library("draw_figures.py"),
        artefacts=drawn,
        options={},
    script:
        "../scripts/draw_figures.py"
