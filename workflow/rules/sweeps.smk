rule list_designs:
    input:
        table=lambda w: table_of(w.sweep) or [],
    output:
        designs=layout.PATHS["designs"],
    log:
        "results/logs/list_designs/{sweep}.log",
    conda:
        "../envs/boltjoint.yaml"
    resources:
        mem_mb=lambda w: resources_of("sweep", w.sweep)["mem_mb"],
        runtime=lambda w: resources_of("sweep", w.sweep)["runtime"],
    params:
        library=library("list_designs.py"),
        vary=lambda w: study.sweeps[w.sweep].vary,
        design=lambda w: study.sweeps[w.sweep].design,
        case=lambda w: study.base_of_sweep(w.sweep),
        variants=lambda w: [
            {"values": each.values, "reason": each.reason}
            for each in study.swept[w.sweep].variants
        ],
        quantities=lambda w: study.quantities(w.sweep),
        table=lambda w: hash_of_table(table_of(w.sweep)),
    script:
        "../scripts/list_designs.py"


rule weigh_pairs_of_sweep:
    input:
        joint=node_to_node("{case}", "{basis}"),
        designs=layout.PATHS["designs"],
    output:
        joint=layout.PATHS["weighted_joint"],
    log:
        "results/logs/weigh_pairs_of_sweep/{sweep}_{case}_{basis}_{joint}.log",
    benchmark:
        "results/benchmarks/weigh_pairs_of_sweep/{sweep}_{case}_{basis}_{joint}.tsv"
    conda:
        "../envs/boltjoint.yaml"
    resources:
        mem_mb=lambda w: resources_of("weights", w.sweep, w.basis)["mem_mb"],
        runtime=lambda w: resources_of("weights", w.sweep, w.basis)["runtime"],
    params:
        library=library("weigh_pairs_of_sweep.py"),
        case=lambda w: study.base_of_sweep(w.sweep),
        values=lambda w: variants_by_case(w.sweep)[w.case][0][1].values,
        variants=lambda w: [n for n, _ in variants_by_case(w.sweep)[w.case]],
        steps=study.solver.steps,
        accuracy=lambda w: study.hyper_reduction.options(w.joint),
    script:
        "../scripts/weigh_pairs_of_sweep.py"


rule solve_designs:
    input:
        designs=layout.PATHS["designs"],
        joints=lambda w: sum(contents.joints_of_sweep(w.sweep), start=[]),
    output:
        chunk=layout.PATHS["chunk"],
    log:
        "results/logs/solve_designs/{sweep}_{chunk}.log",
    benchmark:
        "results/benchmarks/solve_designs/{sweep}_{chunk}.tsv"
    conda:
        "../envs/boltjoint.yaml"
    resources:
        # chunks of several sweeps may be tasks of one job array, which all have the same
        mem_mb=lambda w: resources_needed.of_any("designs")["mem_mb"],
        runtime=lambda w: resources_needed.of_any("designs")["runtime"],
    params:
        library=library("solve_designs.py"),
        case=lambda w: study.base_of_sweep(w.sweep),
        variants=lambda w: variants_of_sweep(w.sweep),
        observed=lambda w: study.sweeps[w.sweep].observed,
        sampling=study.solver.sampling,
        steps=study.solver.steps,
        harmonics=study.solver.harmonic_convergence,
        highest=lambda w: study.sweeps[w.sweep].harmonics,
        chunk=lambda w: contents.chunk(w.sweep, int(w.chunk)),
    script:
        "../scripts/solve_designs.py"


rule check_sweep:
    input:
        designs=layout.PATHS["designs"],
        joints=lambda w: sum(contents.joints_of_sweep(w.sweep, checking=True), start=[]),
    output:
        check=layout.PATHS["sweep_check"],
    log:
        "results/logs/check_sweep/{sweep}.log",
    benchmark:
        "results/benchmarks/check_sweep/{sweep}.tsv"
    conda:
        "../envs/boltjoint.yaml"
    resources:
        mem_mb=lambda w: resources_of("sweep_check", w.sweep)["mem_mb"],
        runtime=lambda w: resources_of("sweep_check", w.sweep)["runtime"],
    params:
        library=library("solve_designs.py"),
        case=lambda w: study.base_of_sweep(w.sweep, checking=True),
        variants=lambda w: variants_of_sweep(w.sweep, checking=True),
        check=lambda w: {
            "number": study.sweeps[w.sweep].check.designs,
            "seed": study.sweeps[w.sweep].check.seed,
            "error_bars": study.sweeps[w.sweep].error_bars,
            "converged_designs": study.sweeps[w.sweep].designs_by_harmonics,
        },
        sampling=study.solver.sampling,
        steps=study.solver.steps,
        harmonics=study.solver.harmonic_convergence,
        highest=lambda w: study.sweeps[w.sweep].check.harmonics,
    script:
        "../scripts/solve_designs.py"


rule gather_sweep:
    input:
        designs=layout.PATHS["designs"],
        chunks=lambda w: data("chunk", sweep=w.sweep),
        check=lambda w: data("sweep_check", sweep=w.sweep),
    output:
        sweep=layout.PATHS["sweep"],
    log:
        "results/logs/gather_sweep/{sweep}.log",
    benchmark:
        "results/benchmarks/gather_sweep/{sweep}.tsv"
    conda:
        "../envs/boltjoint.yaml"
    resources:
        mem_mb=lambda w: resources_of("sweep", w.sweep)["mem_mb"],
        runtime=lambda w: resources_of("sweep", w.sweep)["runtime"],
    params:
        library=library("gather_sweep.py"),
        grid=lambda w: study.sweeps[w.sweep].grid,
        case=lambda w: study.base_of_sweep(w.sweep),
    script:
        "../scripts/gather_sweep.py"


rule write_page_of_sweep:
    input:
        sweep=layout.PATHS["sweep"],
        # where the base case has no page, the page of the sweep finds the indices itself
        indices=lambda w: contents.files(
            "sweep_sensitivity", form="table", sweep=w.sweep
        ),
    output:
        page=layout.PATHS["sweep_page"],
    log:
        "results/logs/write_page_of_sweep/{sweep}.log",
    benchmark:
        "results/benchmarks/write_page_of_sweep/{sweep}.tsv"
    conda:
        "../envs/boltjoint.yaml"
    resources:
        mem_mb=lambda w: resources_of("sweep", w.sweep)["mem_mb"],
        runtime=lambda w: resources_of("sweep", w.sweep)["runtime"],
    params:
        library=library("write_page_of_sweep.py"),
        # no words of the configuration stand on the page
        sweep=lambda w: study.sweeps[w.sweep].model_dump(
            include={
                *("case", "vary", "design", "basis", "joint", "check"),
                *("observe", "harmonics", "error_bars", "converged_designs"),
            }
        ),
        largest_error=study.solver.largest_error,
        reported=lambda w: study.sweeps[w.sweep].case in study.cases,
    script:
        "../scripts/write_page_of_sweep.py"
