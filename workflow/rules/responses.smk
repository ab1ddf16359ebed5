# One job for each case and basis: a response takes less than the start of a job.
for case, basis in contents.cases_and_bases():
    of_basis = {"case": case, "basis": basis}

    rule:
        name:
            f"solve_responses_{case}_{basis}"
        input:
            joints=data("joint", **of_basis),
        output:
            responses=data("response", **of_basis),
            backbones=data("backbone", **of_basis),
            timings=data("timing", **of_basis),
            checksums=list(map(layout.beside, data("timing", **of_basis))),
        log:
            f"results/logs/solve_responses/{case}_{basis}.log",
        benchmark:
            f"results/benchmarks/solve_responses/{case}_{basis}.tsv"
        conda:
            "../envs/boltjoint.yaml"
        resources:
            **resources_of("responses", case, basis),
        params:
            library=library("solve_responses.py"),
            case=problem(case, basis),
            responses=contents.responses(case, basis),
            backbones=[
                each
                for each in contents.responses(case, basis)
                if each.coordinates.kind == "backbone"
            ],
            harmonics=study.harmonic_convergence,
            options={
                "jacobian": study.solver.jacobian,
                "basis_update": study.solver.basis_update,
                "quasi_static_correction": study.solver.quasi_static_correction,
                "largest_error": study.solver.largest_error,
                "fallback": study.solver.fallback,
            },
        script:
            "../scripts/solve_responses.py"

    rule:
        name:
            f"time_by_differences_{case}_{basis}"
        input:
            joints=data("joint", **of_basis),
        output:
            timings=data("forward_differences", **of_basis),
            checksums=list(map(layout.beside, data("forward_differences", **of_basis))),
        log:
            f"results/logs/time_by_differences/{case}_{basis}.log",
        # no answer waits for it
        priority: -1
        conda:
            "../envs/boltjoint.yaml"
        # measured: up to a fourth of what the responses take
        resources:
            **resources_of("responses", case, basis, share=0.25),
        params:
            library=library("time_by_differences.py"),
            case=problem(case, basis),
            responses=contents.by_differences(case, basis),
            options={
                "basis_update": study.solver.basis_update,
                "quasi_static_correction": study.solver.quasi_static_correction,
            },
        script:
            "../scripts/time_by_differences.py"

    rule:
        name:
            f"check_responses_{case}_{basis}"
        input:
            joints=data("joint", **of_basis),
            responses=[
                path
                for each in contents.checked(case, basis)
                for path in data("response", case=case, **each._asdict())
            ],
        output:
            checks=data("check", **of_basis),
            checksums=list(map(layout.beside, data("check", **of_basis))),
        log:
            f"results/logs/check_responses/{case}_{basis}.log",
        conda:
            "../envs/boltjoint.yaml"
        # as above
        resources:
            **resources_of("responses", case, basis, share=0.25),
        params:
            library=library("check_responses.py"),
            joints=[
                layout.path("joint", **of_basis, joint=each.joint)
                for each in contents.checked(case, basis)
            ],
        script:
            "../scripts/check_responses.py"


rule find_peaks:
    input:
        joint=layout.PATHS["joint"],
    output:
        peaks=layout.PATHS["peaks"],
        checksum=layout.beside(layout.PATHS["peaks"]),
    log:
        "results/logs/find_peaks/{case}_{basis}_{joint}.log",
    benchmark:
        "results/benchmarks/find_peaks/{case}_{basis}_{joint}.tsv"
    conda:
        "../envs/boltjoint.yaml"
    resources:
        **SMALL,
    params:
        library=library("find_peaks.py"),
        options=lambda w: {
            "forces": study.case(w.case).levels,
            "damping": study.case(w.case).structural_damping,
        },
        steps=study.solver.steps,
    script:
        "../scripts/find_peaks.py"


rule record_environment:
    output:
        environment=layout.PATHS["environment"],
        checksum=layout.beside(layout.PATHS["environment"]),
    log:
        "results/logs/record_environment.log",
    # of the machine on which the run is started: nodes of a cluster may differ from each other
    localrule: True
    conda:
        "../envs/boltjoint.yaml"
    resources:
        **SMALL,
    params:
        library=library("record_environment.py"),
        record=environment.record(),
    script:
        "../scripts/record_environment.py"
