rule tabulate_frequencies:
    input:
        modes=lambda w: [layout.modes(name, w.modes) for name in study.assemblies],
        published=published,
    output:
        csv=report(
            "results/tables/natural_frequencies_{modes}.csv",
            category="4. Tables",
            subcategory="Structure",
            labels={"table": "natural frequencies of {modes}"},
        ),
        html="results/tables/natural_frequencies_{modes}.html",
    log:
        "results/logs/tabulate_frequencies/{modes}.log",
    conda:
        "../envs/boltjoint.yaml"
    params:
        library=library("tabulate_frequencies.py"),
        assemblies=list(study.assemblies),
    script:
        "../scripts/tabulate_frequencies.py"


rule tabulate_contact:
    input:
        preloads=[layout.preload(*which) for which in layout.preloads(study)],
        published=published,
    output:
        csv=report(
            "results/tables/contact.csv",
            category="4. Tables",
            subcategory="Structure",
            labels={"table": "contact under preload"},
        ),
        html="results/tables/contact.html",
    log:
        "results/logs/tabulate_contact.log",
    conda:
        "../envs/boltjoint.yaml"
    params:
        library=library("tabulate_contact.py"),
        preloads=layout.preloads(study),
    script:
        "../scripts/tabulate_contact.py"


rule tabulate_regions:
    input:
        joint="results/cases/{case}/{modes}/{regions}/joint.nc",
    output:
        csv=report(
            "results/tables/regions_{case}_{modes}_{regions}.csv",
            category="4. Tables",
            subcategory="{case}",
            labels={"table": "{regions} in {modes}"},
        ),
        html="results/tables/regions_{case}_{modes}_{regions}.html",
    log:
        "results/logs/tabulate_regions/{case}_{modes}_{regions}.log",
    conda:
        "../envs/boltjoint.yaml"
    params:
        library=library("tabulate_regions.py"),
    script:
        "../scripts/tabulate_regions.py"


rule tabulate_elements:
    input:
        joint="results/cases/{case}/{modes}/{regions}/{fit}/joint.nc",
        published=published,
    output:
        csv=report(
            "results/tables/elements_{case}_{modes}_{regions}_{fit}.csv",
            category="4. Tables",
            subcategory="{case}",
            labels={"table": "elements of {regions}, {fit} in {modes}"},
        ),
        html="results/tables/elements_{case}_{modes}_{regions}_{fit}.html",
    log:
        "results/logs/tabulate_elements/{case}_{modes}_{regions}_{fit}.log",
    conda:
        "../envs/boltjoint.yaml"
    params:
        library=library("tabulate_elements.py"),
        joint="{regions}/{fit}",
        case_study=lambda w: case_of(w).published,
    script:
        "../scripts/tabulate_elements.py"


rule compare_fits:
    input:
        fits=lambda w: [
            layout.joint(w.case, w.modes, name)
            for name in layout.fitted(study, w.case, w.modes)
        ],
        timings=lambda w: [
            layout.fit_timing(w.case, w.modes, name)
            for name in layout.fitted(study, w.case, w.modes)
        ],
        responses=lambda w: [
            layout.response(w.case, w.modes, name, REFERENCE[1], 1)
            for name in solved_in_linear_modes(w)
        ],
    output:
        csv=report(
            "results/tables/fits_{case}_{modes}.csv",
            category="4. Tables",
            subcategory="{case}",
            labels={"table": "fits of elements in {modes}"},
        ),
        html="results/tables/fits_{case}_{modes}.html",
    log:
        "results/logs/compare_fits/{case}_{modes}.log",
    conda:
        "../envs/boltjoint.yaml"
    params:
        library=library("compare_fits.py"),
        fitted=lambda w: layout.fitted(study, w.case, w.modes),
        solved=solved_in_linear_modes,
    script:
        "../scripts/compare_fits.py"


rule tabulate_patterns:
    input:
        modes=lambda w: [
            layout.modes(w.assembly, family) for family in study.convergence.bases
        ],
        patterns="results/assemblies/{assembly}/patterns.nc",
    output:
        csv=report(
            "results/tables/patterns_{assembly}.csv",
            category="4. Tables",
            subcategory="Structure",
            labels={"table": "resonances of {assembly} by basis"},
        ),
        html="results/tables/patterns_{assembly}.html",
    log:
        "results/logs/tabulate_patterns/{assembly}.log",
    conda:
        "../envs/boltjoint.yaml"
    params:
        library=library("tabulate_patterns.py"),
        bases=study.convergence.bases,
    script:
        "../scripts/tabulate_patterns.py"


rule tabulate_bases:
    input:
        peaks=lambda w: [
            layout.peaks(w.case, family, REFERENCE[0])
            for family in study.convergence.bases
        ],
    output:
        csv=report(
            "results/tables/bases_{case}.csv",
            category="4. Tables",
            subcategory="{case}",
            labels={"table": "peaks by basis"},
        ),
        html="results/tables/bases_{case}.html",
    log:
        "results/logs/tabulate_bases/{case}.log",
    conda:
        "../envs/boltjoint.yaml"
    params:
        library=library("tabulate_bases.py"),
        bases=study.convergence.bases,
    script:
        "../scripts/tabulate_bases.py"


rule tabulate_divisions:
    input:
        joint="results/cases/{case}/{modes}/node-to-node/joint.nc",
        preload=lambda w: layout.preload_of_case(study, w.case),
        peaks="results/cases/{case}/{modes}/node-to-node/peaks.csv",
    output:
        csv=report(
            "results/tables/divisions_{case}_{modes}.csv",
            category="4. Tables",
            subcategory="{case}",
            labels={"table": "regions, by way and number"},
        ),
        html="results/tables/divisions_{case}_{modes}.html",
    log:
        "results/logs/tabulate_divisions/{case}_{modes}.log",
    benchmark:
        "results/benchmarks/tabulate_divisions/{case}_{modes}.tsv"
    conda:
        "../envs/boltjoint.yaml"
    params:
        library=library("tabulate_divisions.py"),
        options=lambda w: {
            "counts": study.convergence.regions,
            "loss_factor": case_of(w).loss_factor,
            "division": case_of(w).regions.division,
        },
        steps=study.solver.steps,
    script:
        "../scripts/tabulate_divisions.py"


rule compare_accuracy:
    input:
        responses=lambda w: [
            layout.response(w.case, w.modes, *which) for which in solved(w)
        ],
        checks=lambda w: [layout.check(w.case, w.modes, *which) for which in checked(w)],
    output:
        csv=report(
            "results/tables/accuracy_{case}_{modes}.csv",
            category="4. Tables",
            subcategory="{case}",
            labels={"table": "accuracy in {modes}"},
        ),
        html="results/tables/accuracy_{case}_{modes}.html",
    log:
        "results/logs/compare_accuracy/{case}_{modes}.log",
    conda:
        "../envs/boltjoint.yaml"
    params:
        library=library("compare_accuracy.py"),
        solved=solved,
        checked=checked,
    script:
        "../scripts/compare_accuracy.py"


rule compare_times:
    input:
        timings=lambda w: [
            layout.timing(w.case, w.modes, *which) for which in solved(w)
        ],
        published=published,
    output:
        csv=report(
            "results/tables/times_{case}_{modes}.csv",
            category="4. Tables",
            subcategory="{case}",
            labels={"table": "times in {modes}"},
        ),
        html="results/tables/times_{case}_{modes}.html",
    log:
        "results/logs/compare_times/{case}_{modes}.log",
    conda:
        "../envs/boltjoint.yaml"
    params:
        library=library("compare_times.py"),
        solved=solved,
        case_study=lambda w: case_of(w).published,
    script:
        "../scripts/compare_times.py"


rule compare_models:
    input:
        responses=lambda w: [
            layout.response(w.case, *which) for which in layout.compared(study, w.case)
        ],
        timings=lambda w: [
            layout.timing(w.case, *which) for which in layout.compared(study, w.case)
        ],
    output:
        csv=report(
            "results/tables/models_{case}.csv",
            category="4. Tables",
            subcategory="{case}",
            labels={"table": "all models against the converged response"},
        ),
        html="results/tables/models_{case}.html",
    log:
        "results/logs/compare_models/{case}.log",
    conda:
        "../envs/boltjoint.yaml"
    params:
        library=library("compare_models.py"),
        compared=lambda w: layout.compared(study, w.case),
        converged=lambda w: layout.converged(study)[w.case],
    script:
        "../scripts/compare_models.py"


rule tabulate_states:
    input:
        joints=lambda w: [
            layout.joint(w.case, w.modes, name) for name in case_of(w).joints(w.modes)
        ],
        responses=lambda w: [
            layout.response(w.case, w.modes, *which) for which in solved(w)
        ],
    output:
        csv=report(
            "results/tables/states_{case}_{modes}.csv",
            category="4. Tables",
            subcategory="{case}",
            labels={"table": "states in {modes}"},
        ),
        html="results/tables/states_{case}_{modes}.html",
    log:
        "results/logs/tabulate_states/{case}_{modes}.log",
    conda:
        "../envs/boltjoint.yaml"
    params:
        library=library("tabulate_states.py"),
        joints=lambda w: case_of(w).joints(w.modes),
        solved=lambda w: solved(w),
    script:
        "../scripts/tabulate_states.py"


rule integrate_in_time:
    input:
        joint="results/cases/{case}/{modes}/node-to-node/joint.nc",
        response=lambda w: layout.response(w.case, *layout.marched(study)[w.case]),
    output:
        csv=report(
            "results/tables/harmonics_{case}_{modes}.csv",
            category="4. Tables",
            subcategory="{case}",
            labels={"table": "more harmonics, and time, in {modes}"},
        ),
        html="results/tables/harmonics_{case}_{modes}.html",
    log:
        "results/logs/integrate_in_time/{case}_{modes}.log",
    benchmark:
        "results/benchmarks/integrate_in_time/{case}_{modes}.tsv"
    conda:
        "../envs/boltjoint.yaml"
    params:
        library=library("integrate_in_time.py"),
        forces=lambda w: case_of(w).verification_forces_N,
    script:
        "../scripts/integrate_in_time.py"


rule balance_harmonics:
    input:
        joint="results/cases/{case}/{modes}/node-to-node/joint.nc",
        response=lambda w: layout.response(
            w.case, *layout.balanced(study, w.case)[w.modes]
        ),
    output:
        csv=report(
            "results/tables/harmonic_peaks_{case}_{modes}.csv",
            category="4. Tables",
            subcategory="{case}",
            labels={"table": "peaks with more harmonics, in {modes}"},
        ),
        html="results/tables/harmonic_peaks_{case}_{modes}.html",
    log:
        "results/logs/balance_harmonics/{case}_{modes}.log",
    benchmark:
        "results/benchmarks/balance_harmonics/{case}_{modes}.tsv"
    conda:
        "../envs/boltjoint.yaml"
    params:
        library=library("balance_harmonics.py"),
        forces=lambda w: case_of(w).verification_forces_N,
    script:
        "../scripts/balance_harmonics.py"


rule tabulate_sampling:
    input:
        joints=[
            layout.joint(case, *which[:2])
            for case, which in layout.references(study).items()
        ],
        responses=[
            layout.response(case, *which)
            for case, which in layout.references(study).items()
        ],
    output:
        csv=report(
            "results/tables/sampling.csv",
            category="4. Tables",
            subcategory="All cases",
            labels={"table": "forces sampled in time"},
        ),
        html="results/tables/sampling.html",
    log:
        "results/logs/tabulate_sampling.log",
    conda:
        "../envs/boltjoint.yaml"
    params:
        library=library("tabulate_sampling.py"),
        cases=list(layout.references(study)),
    script:
        "../scripts/tabulate_sampling.py"
