"""Responses of a study for other programs: CSV, MATLAB and universal files, motion for ParaView."""

import logging
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pandas as pd
import xarray as xr
from numpy.typing import NDArray

from boltjoint import checks, dataset
from boltjoint.config.study import load_study
from boltjoint.config.types import ConfigError
from boltjoint.harmonics import Components
from boltjoint.joint.surface_places import pairs_of_elements
from boltjoint.names import REFERENCE
from boltjoint.structure.model_limits import LIMITS
from boltjoint.structure.vtu import write_period
from boltjoint.study import layout

logger = logging.getLogger(__name__)

_CASES = "results/cases"
#: every response, and those of all contact pairs in linear modes, whose motion the bodies have
_EVERY, _OF_PAIRS = "**/response.nc", f"*/*/{'/'.join(REFERENCE)}/*/response.nc"

#: of each peak, in files that have it
_OF_PEAKS = (
    *("peak_frequency_converged", "peak_frequency_converged_error"),
    *("peak_amplitude_converged", "peak_amplitude_converged_error"),
    *("peak_frequency", "peak_frequency_error", "peak_amplitude", "peak_amplitude_error"),
    *(f"peak_{limit.name}" for limit in LIMITS),
    "complete",
)


def export_responses(folder: str | Path, to: str | Path, form: str = "csv") -> list[Path]:
    """Write all frequency responses of a study, their peaks, and backbones.

    Results of a case that its configuration names no more are left out, which is logged.

    Parameters
    ----------
    folder
        Folder of the study, with ``results/cases``.
    to
        Folder of the files, each named by case, basis, joint, coordinates and resonance.
    form
        ``csv``: a table of solutions and one of peaks, and one of the backbone where there is one;
        ``mat``: a file of MATLAB with arrays of them; ``uff``: a universal file with a data set 58
        for each force, the displacement of the output point over the force, which needs pyuff;
        ``pvd``: of node-to-node joints in linear modes, a period of motion at the peak of each
        force, for ParaView.

    Returns
    -------
    list of Path
        The files.

    Raises
    ------
    ValueError
        If the form is not known, there is no response, or none can be written in it, as without
        pyuff, or of a structure without nodes; what others are written without is logged.
    """
    (places, write), cases = _FORMS[checks.choice("form", form, _FORMS)], Path(folder) / _CASES
    written, reason = [], f"{cases} has no response.nc: run the study first"
    named = _named_responses(Path(folder))
    for path in sorted(cases.glob(places)):
        parts = path.relative_to(cases).parent.parts
        name = "_".join(parts)
        if path not in named.get(parts[0], {path}):
            reason = f"the case names {name} no more"
            logger.warning("not written: %s", reason)
            continue
        Path(to).mkdir(parents=True, exist_ok=True)
        try:
            written += write(Path(to) / name, path)
        except (_NotDrawnError, OSError) as problem:
            reason = f"{name}: {problem}"
            logger.warning("not written: %s", reason)
    if not written:
        raise ValueError(reason)
    for missing in sorted(set().union(*named.values())):
        place = missing.relative_to(cases)
        if place.match(places.removeprefix("**/")) and not missing.exists():
            name = "_".join(place.parent.parts)
            logger.warning("not written: %s has no results yet: run the study", name)
    return written


def _named_responses(folder: Path) -> dict[str, set[Path]]:
    """Files of the responses that each case of a study names; nothing of one that is not valid."""
    try:
        cases = load_study(folder, {}).cases
    except ConfigError as problem:
        logger.warning("all results are written, whatever cases name: %s", problem)
        return {}
    keys = ("basis", "joint", "coordinates", "resonance")
    return {
        name: {
            folder / layout.path("response", case=name, **dict(zip(keys, one, strict=True)))
            for one in case.responses
        }
        for name, case in cases.items()
    }


def _response_and_joint(path: Path) -> tuple[xr.Dataset, xr.Dataset]:
    return dataset.load(path), dataset.load(path.parents[2] / "joint.nc")


def _tables(path: Path) -> dict[str, pd.DataFrame]:
    """Solutions and peaks of a response, and the backbone that it is made of."""
    response, joint = _response_and_joint(path)
    tables = {"response": _solutions(response, joint), "peaks": _peaks(response)}
    if (of_mode := path.with_name("backbone.nc")).exists():
        tables["backbone"] = _backbone(dataset.load(of_mode))
    return tables


def _solutions(response: xr.Dataset, joint: xr.Dataset) -> pd.DataFrame:
    """Force, frequency and first harmonic of the output point at all solutions."""
    components = Components(map(str, response["component"].to_numpy()))
    amplitude = response["modal_coordinate"].transpose("component", "solution", "mode").to_numpy()
    sine, cosine = (
        amplitude[place] @ joint["response_mode"].to_numpy()
        for place in (components.sin(), components.cos())
    )
    unit = response["excitation_force"].attrs["units"].replace("/", "_per_")
    columns = {
        f"excitation_{unit}": response["excitation_force"].to_numpy(),
        "frequency_Hz": response["frequency"].to_numpy(),
        "amplitude_m": np.hypot(sine, cosine),
        "sine_m": sine,
        "cosine_m": cosine,
        "converged": response["converged"].to_numpy(),
    }
    return pd.DataFrame(columns)


def _peaks(response: xr.Dataset) -> pd.DataFrame:
    """Peaks by force level, with the units of what is no number alone."""
    unit = response["excitation_force"].attrs["units"].replace("/", "_per_")
    columns = {f"excitation_{unit}": response["force_level"].to_numpy()}
    for name in _OF_PEAKS:
        if name in response:
            unit = response[name].attrs["units"]
            columns[name if unit == "1" else f"{name}_{unit}"] = response[name].to_numpy()
    return pd.DataFrame(columns)


def _backbone(backbone: xr.Dataset) -> pd.DataFrame:
    """Natural frequency and damping ratio over the amplitude of the output point."""
    force = backbone["peak_force"].attrs["units"].replace("/", "_per_")
    columns = {
        "amplitude_m": backbone["response_amplitude"].to_numpy(),
        "natural_frequency_Hz": backbone["natural_frequency"].to_numpy(),
        "damping_ratio": backbone["damping_ratio"].to_numpy(),
        f"excitation_at_peak_{force}": backbone["peak_force"].to_numpy(),
    }
    return pd.DataFrame(columns)


def _write_csv(stem: Path, path: Path) -> list[Path]:
    files = []
    for what, table in _tables(path).items():
        files.append(stem.with_name(f"{stem.name}_{what}.csv"))
        table.to_csv(files[-1], index=False)
    return files


def _write_mat(stem: Path, path: Path) -> list[Path]:
    from scipy.io import savemat

    file = stem.with_name(f"{stem.name}.mat")
    content = {what: _arrays(table) for what, table in _tables(path).items()}
    savemat(file, content, long_field_names=True, oned_as="column")
    return [file]


def _arrays(table: pd.DataFrame) -> dict[str, NDArray]:
    return {name: column.to_numpy() for name, column in table.items()}


#: data set 58 of a universal file: displacement over force along z, over uneven frequencies
_DATA_SET = {
    "type": 58,
    "binary": 0,
    **{f"id{place}": "NONE" for place in range(1, 6)},
    **{"func_type": 4, "func_id": 0, "ver_num": 0, "load_case_id": 0},
    **{"rsp_ent_name": "NONE", "rsp_node": 1, "rsp_dir": 3},
    **{"ref_ent_name": "NONE", "ref_node": 1, "ref_dir": 3},
    **{"ord_data_type": 6, "abscissa_spacing": 0, "abscissa_min": 0.0, "abscissa_inc": 0.0},
    "z_axis_value": 0.0,
    **{
        f"{axis}_{name}": value
        for axis, kind, label, unit in (
            ("abscissa", 18, "Frequency", "Hz"),
            ("ordinate", 8, "Displacement", "m"),
            ("orddenom", 13, "Excitation Force", "N"),
            ("z_axis", 0, "NONE", "NONE"),
        )
        for name, value in {
            "spec_data_type": kind,
            "len_unit_exp": 0,
            "force_unit_exp": 0,
            "temp_unit_exp": 0,
            "axis_lab": label,
            "axis_units_lab": unit,
        }.items()
    },
}


def _write_uff(stem: Path, path: Path) -> list[Path]:
    try:
        import pyuff
    except ImportError:
        raise ValueError("uff needs pyuff: pip install boltjoint[uff]") from None
    file = stem.with_name(f"{stem.name}.uff")
    file.unlink(missing_ok=True)
    solutions = _solutions(*_response_and_joint(path))
    excitation, universal = solutions.columns[0], pyuff.UFF(str(file))
    for force, branch in solutions.groupby(excitation):
        # excitation goes with the sine: as multiples of e^(i w t) both are sine + i cosine
        response = (branch["sine_m"] + 1j * branch["cosine_m"]).to_numpy() / force
        data = {
            **_DATA_SET,
            "id1": f"{stem.name} {force:g}"[:80],
            "data": response,
            "x": branch["frequency_Hz"].to_numpy(),
            "num_pts": len(branch),
        }
        universal.write_sets(data, mode="add")
    return [file]


class _NotDrawnError(ValueError):
    """Why the motion of a response is not drawn, as those of others may be."""


def _write_pvd(stem: Path, path: Path) -> list[Path]:
    """A period of motion at each peak, with the harmonics that the response was solved with."""
    response, joint = _response_and_joint(path)
    basis, case, *_, folder = (path.parents[place] for place in range(3, 8))
    try:
        # whether it is one that runs or not
        name = load_study(folder, {"cases": [case.name]}).case(case.name).assembly
    except ConfigError as problem:
        raise _NotDrawnError(f"its configuration cannot be read: {problem}") from None
    assembly, modes = (
        dataset.load(folder / layout.path(kind, assembly=name, basis=basis.name))
        for kind in ("assembly", "modes")
    )
    if "mode_shape" not in modes:
        raise _NotDrawnError("the structure has no nodes")
    pair = pairs_of_elements(assembly["position"].to_numpy(), joint)
    components = Components(map(str, response["component"].to_numpy()))
    files = []
    for place, force in enumerate(response["force_level"].to_numpy()):
        at = response.isel(force=place)
        of_force = response["excitation_force"] == force
        peak = np.flatnonzero(of_force & (response["frequency"] == at["peak_frequency"]))
        if not peak.size:
            continue
        motion = response["modal_coordinate"].isel(solution=peak[0]).transpose("component", "mode")
        state = np.full(assembly.sizes["pair"], np.nan)
        state[pair] = at["contact_state"]
        files.append(stem.with_name(f"{stem.name}_{force:g}.pvd"))
        frequency = float(at["peak_frequency"])
        write_period(assembly, modes, motion.to_numpy(), components, frequency, state, files[-1])
    if not files:
        raise _NotDrawnError("no level has a peak")
    return files


#: where the responses of each form are, and what writes one of them
_FORMS: dict[str, tuple[str, Callable[[Path, Path], list[Path]]]] = {
    "csv": (_EVERY, _write_csv),
    "mat": (_EVERY, _write_mat),
    "uff": (_EVERY, _write_uff),
    "pvd": (_OF_PAIRS, _write_pvd),
}
