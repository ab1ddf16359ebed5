rule write_overview:
    input:
        artefacts=[each.path for each in on_overview],
        joints=[node_to_node(*each) for each in contents.cases_and_bases()],
        backbones=data("backbone", joint=REFERENCE[0]),
        fits=data("calibration") + data("prediction"),
        environment="results/environment.json",
        published=published,
    output:
        page="results/report/overview.html",
        packed=report(
            "results/report/packed/overview.html",
            caption="../report/overview.rst",
            category="1. Overview",
            labels={"page": "Overview"},
        ),
    log:
        "results/logs/write_overview.log",
    conda:
        "../envs/boltjoint.yaml"
    resources:
        **SMALL,
    params:
        library=library("write_overview.py", CAPTIONS),
        study=study.model_dump(),
        artefacts=on_overview,
        all_artefacts=contents.select(form="figure") + contents.select(form="table"),
    script:
        "../scripts/write_overview.py"


rule write_page_of_accuracy:
    input:
        artefacts=[each.path for each in on_accuracy],
        published=published,
    output:
        page="results/report/accuracy.html",
        packed=report(
            "results/report/packed/accuracy.html",
            caption="../report/accuracy.rst",
            category="1. Overview",
            labels={"page": "Accuracy"},
        ),
    log:
        "results/logs/write_page_of_accuracy.log",
    conda:
        "../envs/boltjoint.yaml"
    resources:
        **SMALL,
    params:
        library=library("write_page_of_accuracy.py", CAPTIONS),
        artefacts=on_accuracy,
        cases={name: found.model_dump() for name, found in study.cases.items()},
    script:
        "../scripts/write_page_of_accuracy.py"


rule write_page_of_structure:
    input:
        artefacts=[each.path for each in DISPLAYS.on_page(contents, "structure")],
        meshes=data("assembly"),
        published=published,
    output:
        page="results/report/structure.html",
        packed=report(
            "results/report/packed/structure.html",
            caption="../report/structure.rst",
            category="2. Structure",
            labels={"page": "Structure"},
        ),
    log:
        "results/logs/write_page_of_structure.log",
    conda:
        "../envs/boltjoint.yaml"
    resources:
        **SMALL,
    params:
        library=library(
            "write_page_of_structure.py",
            [
                *CAPTIONS,
                *sorted(
                    {
                        makers.page_of(each.type).__name__
                        for each in study.assemblies.values()
                    }
                ),
            ],
        ),
        artefacts=DISPLAYS.on_page(contents, "structure"),
        assemblies={
            name: found.model_dump() for name, found in study.assemblies.items()
        },
        cases=list(study.cases),
    script:
        "../scripts/write_page_of_structure.py"


rule write_page_of_case:
    input:
        artefacts=lambda w: [each.path for each in DISPLAYS.on_page(contents, w.case)],
        joints=lambda w: [
            node_to_node(w.case, basis) for basis in study.case(w.case).bases
        ],
        drawn=lambda w: drawn_on_page(w.case),
        published=lambda w: published if contents.is_compared(w.case) else [],
    output:
        page="results/report/{case}.html",
        packed=report(
            "results/report/packed/{case}.html",
            caption="../report/case.rst",
            category="3. Case studies",
            labels={"page": "{case}"},
        ),
    log:
        "results/logs/write_page_of_case/{case}.log",
    conda:
        "../envs/boltjoint.yaml"
    resources:
        **SMALL,
    params:
        library=library("write_page_of_case.py", CAPTIONS),
        artefacts=lambda w: DISPLAYS.on_page(contents, w.case),
        case=lambda w: study.case(w.case).model_dump(),
        # no more of it: other options do not stand on the page
        solver=study.solver.model_dump(
            include={"friction_force", "harmonics", "time_samples"}
        ),
        cases=list(study.cases),
    script:
        "../scripts/write_page_of_case.py"
