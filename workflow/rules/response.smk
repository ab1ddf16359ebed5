rule solve_response:
    input:
        joint="results/cases/{case}/{modes}/{joint}/joint.nc",
        nodes="results/cases/{case}/{modes}/node-to-node/joint.nc",
    output:
        response="results/cases/{case}/{modes}/{joint}/{coordinates}/resonance={resonance}/response.nc",
    log:
        "results/logs/solve_response/{case}_{modes}_{joint}_{coordinates}_{resonance}.log",
    benchmark:
        "results/benchmarks/solve_response/{case}_{modes}_{joint}_{coordinates}_{resonance}.tsv"
    conda:
        "../envs/boltjoint.yaml"
    params:
        library=library("solve_response.py"),
        window=lambda w: {
            "resonance": int(w.resonance),
            "given": case_of(w).window_around(int(w.resonance)),
        },
        options=lambda w: {
            "coordinates": w.coordinates,
            "resonance": int(w.resonance),
            "forces": case_of(w).forces_N,
            "loss_factor": case_of(w).loss_factor,
            "jacobian": study.solver.jacobian,
            "basis_update": study.solver.basis_update,
            "quasi_static_correction": study.solver.quasi_static_correction,
            "largest_error": study.solver.largest_error,
            "fallback": study.solver.fallback,
        },
        sampling=study.solver.sampling,
        steps=study.solver.steps,
    script:
        "../scripts/solve_response.py"


rule time_solver:
    input:
        joint="results/cases/{case}/{modes}/{joint}/joint.nc",
        nodes="results/cases/{case}/{modes}/node-to-node/joint.nc",
    output:
        timing="results/cases/{case}/{modes}/{joint}/{coordinates}/resonance={resonance}/timing.csv",
    log:
        "results/logs/time_solver/{case}_{modes}_{joint}_{coordinates}_{resonance}.log",
    conda:
        "../envs/boltjoint.yaml"
    # all cores, so that nothing else runs on the machine meanwhile
    threads: workflow.cores
    params:
        library=library("time_solver.py"),
        window=lambda w: {
            "resonance": int(w.resonance),
            "given": case_of(w).window_around(int(w.resonance)),
        },
        options=lambda w: {
            "coordinates": w.coordinates,
            "resonance": int(w.resonance),
            "forces": case_of(w).forces_N,
            "loss_factor": case_of(w).loss_factor,
            "basis_update": study.solver.basis_update,
            "quasi_static_correction": study.solver.quasi_static_correction,
            "jacobians": layout.jacobians(w.modes, w.joint, w.coordinates),
            **study.timing.model_dump(),
        },
        sampling=study.solver.sampling,
        steps=study.solver.steps,
    script:
        "../scripts/time_solver.py"


rule check_solutions:
    input:
        joint="results/cases/{case}/{modes}/{joint}/joint.nc",
        response="results/cases/{case}/{modes}/{joint}/{coordinates}/resonance={resonance}/response.nc",
    output:
        check="results/cases/{case}/{modes}/{joint}/{coordinates}/resonance={resonance}/check.csv",
    log:
        "results/logs/check_solutions/{case}_{modes}_{joint}_{coordinates}_{resonance}.log",
    conda:
        "../envs/boltjoint.yaml"
    params:
        library=library("check_solutions.py"),
    script:
        "../scripts/check_solutions.py"


rule find_backbone:
    input:
        joint="results/cases/{case}/{modes}/{joint}/joint.nc",
        nodes="results/cases/{case}/{modes}/node-to-node/joint.nc",
    output:
        backbone="results/cases/{case}/{modes}/{joint}/backbone/resonance={resonance}/backbone.nc",
    log:
        "results/logs/find_backbone/{case}_{modes}_{joint}_{resonance}.log",
    conda:
        "../envs/boltjoint.yaml"
    params:
        library=library("find_backbone.py"),
        window=lambda w: {
            "resonance": int(w.resonance),
            "given": case_of(w).window_around(int(w.resonance)),
        },
        options=lambda w: {
            "resonance": int(w.resonance),
            "forces": case_of(w).forces_N,
            "loss_factor": case_of(w).loss_factor,
        },
        sampling=study.solver.sampling,
        steps=study.solver.steps,
    script:
        "../scripts/find_backbone.py"


rule find_peaks:
    input:
        joint="results/cases/{case}/{modes}/{joint}/joint.nc",
    output:
        peaks="results/cases/{case}/{modes}/{joint}/peaks.csv",
    log:
        "results/logs/find_peaks/{case}_{modes}_{joint}.log",
    benchmark:
        "results/benchmarks/find_peaks/{case}_{modes}_{joint}.tsv"
    conda:
        "../envs/boltjoint.yaml"
    params:
        library=library("find_peaks.py"),
        options=lambda w: {
            "forces": case_of(w).forces_N,
            "loss_factor": case_of(w).loss_factor,
        },
        steps=study.solver.steps,
    script:
        "../scripts/find_peaks.py"


rule record_environment:
    output:
        "results/environment.json",
    log:
        "results/logs/record_environment.log",
    conda:
        "../envs/boltjoint.yaml"
    params:
        library=library("record_environment.py"),
        record=environment.record(),
    script:
        "../scripts/record_environment.py"
