rule write_overview:
    input:
        shown=shown_on("overview")
        + [each.path for each in tables_of("accuracy", "times", "harmonic_peaks")],
        joints=[path for case in study.cases for path in nodes_of(case)],
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
    params:
        library=library("write_overview.py"),
        study=study.model_dump(),
        shown=[path for page in (*PAGES, *study.cases) for path in shown_on(page)],
    script:
        "../scripts/write_overview.py"


rule write_page_of_accuracy:
    input:
        shown=shown_on("accuracy") + [each.path for each in tables_of("harmonic_peaks")],
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
    params:
        library=library("write_page_of_accuracy.py"),
        cases=list(study.cases),
    script:
        "../scripts/write_page_of_accuracy.py"


rule write_page_of_structure:
    input:
        shown=shown_on("structure"),
        meshes=[layout.path("assembly", assembly=name) for name in study.assemblies],
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
    params:
        library=library("write_page_of_structure.py"),
        assemblies={
            name: found.model_dump() for name, found in study.assemblies.items()
        },
        cases=list(study.cases),
    script:
        "../scripts/write_page_of_structure.py"


rule write_page_of_case:
    input:
        shown=lambda w: shown_on(w.case),
        joints=lambda w: nodes_of(w.case),
        published=published,
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
    params:
        library=library("write_page_of_case.py"),
        case=lambda w: study.case(w.case).model_dump(),
        # no more of it: other options do not stand on the page
        solver=study.solver.model_dump(
            include={"friction_force", "harmonics", "time_samples"}
        ),
        cases=list(study.cases),
    script:
        "../scripts/write_page_of_case.py"
