rule calibrate_joint:
    input:
        joint=lambda w: layout.path("joint", **contents.calibrated(w.case)),
        tables=lambda w: measured_files(w.case),
        tightened=lambda w: tightened_of(w.case),
    output:
        calibration=layout.PATHS["calibration"],
    log:
        "results/logs/calibrate_joint/{case}_{basis}_{joint}.log",
    benchmark:
        "results/benchmarks/calibrate_joint/{case}_{basis}_{joint}.tsv"
    conda:
        "../envs/boltjoint.yaml"
    resources:
        mem_mb=lambda w: resources_of("calibration", w.case)["mem_mb"],
        runtime=lambda w: resources_of("calibration", w.case)["runtime"],
    params:
        library=lambda w: library("calibrate_joint.py", maker_of_fit(w.case)),
        case=lambda w: calibrated_content(study.case(w.case)),
        bolts=lambda w: bolts_of(w.case),
        measured=lambda w: study.case(w.case).measured.model_dump(exclude={"predicted"}),
        files=lambda w: {file: study.hashes[file] for file in measured_files(w.case)},
    script:
        "../scripts/calibrate_joint.py"


rule predict_measured:
    input:
        joint=lambda w: layout.path("joint", **contents.calibrated(w.case)),
        calibration=layout.PATHS["calibration"],
        tables=lambda w: measured_files(w.case, "predicted"),
        tightened=lambda w: tightened_of(w.case),
    output:
        prediction=layout.PATHS["prediction"],
    log:
        "results/logs/predict_measured/{case}_{basis}_{joint}.log",
    benchmark:
        "results/benchmarks/predict_measured/{case}_{basis}_{joint}.tsv"
    conda:
        "../envs/boltjoint.yaml"
    resources:
        mem_mb=lambda w: resources_of("calibration", w.case)["mem_mb"],
        runtime=lambda w: resources_of("calibration", w.case)["runtime"],
    params:
        library=lambda w: library("predict_measured.py", maker_of_fit(w.case)),
        case=lambda w: calibrated_content(study.case(w.case)),
        bolts=lambda w: bolts_of(w.case),
        measured=lambda w: study.case(w.case).measured.model_dump(),
        files=lambda w: {
            file: study.hashes[file] for file in measured_files(w.case, "predicted")
        },
    script:
        "../scripts/predict_measured.py"


rule write_fitted_case:
    input:
        calibration=layout.PATHS["calibration"],
    output:
        case=layout.PATHS["fitted_case"],
    log:
        "results/logs/write_fitted_case/{case}_{basis}_{joint}.log",
    conda:
        "../envs/boltjoint.yaml"
    resources:
        **SMALL,
    params:
        library=library("write_fitted_case.py"),
        case=lambda w: told_of_case(w.case),
    script:
        "../scripts/write_fitted_case.py"
