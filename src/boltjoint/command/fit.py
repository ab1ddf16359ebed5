"""Files of the workflow that the fit of a case to its measurement makes."""

from pathlib import Path

from boltjoint import checks


def files_of_fit(folder: str | Path, case: str) -> list[str]:
    """The calibration of a case, the fitted case, and their figure and tables.

    Parameters
    ----------
    folder
        The folder that holds ``config/``.
    case
        Name of the case.

    Raises
    ------
    ConfigError
        If the configuration cannot be used.
    ValueError
        If there is no such case, or it has no measurement.
    """
    from boltjoint.config.study import load_study
    from boltjoint.report.displays import DISPLAYS
    from boltjoint.report.displays.calibration import SECTION
    from boltjoint.study.artefact_list import Contents

    study = load_study(checks.path("folder", folder))
    checks.choice("case", case, tuple(study.cases))
    if study.cases[case].measured is None:
        raise ValueError(f"config/cases/{case}.yaml has no key measured: there is nothing to fit")
    contents = Contents(study, DISPLAYS)
    shown = [
        path
        for each in DISPLAYS.on_page(contents, case)
        if DISPLAYS.of(each).section == SECTION
        for path in each.paths
    ]
    return [*contents.files("calibration", "fitted_case", case=case), *shown]
