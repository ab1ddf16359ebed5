"""The layout of a study on disk: where each kind of file lies, in folders named by what is varied.

A file sits in the folder of what it depends on, so that a new force never touches the preload and
a new stiffness never touches the mesh.
"""

from typing import Any

from boltjoint.checksums import BESIDE

#: the page that a report opens on
OVERVIEW = "results/report/overview.html"

_ASSEMBLY = "results/assemblies/{assembly}"
_PRELOAD = _ASSEMBLY + "/preload={preload_N}"
_BASIS = "results/cases/{case}/{basis}"
_JOINT = _BASIS + "/{joint}"
_SWEEP = "results/sweeps/{sweep}"
_SOLVED = _JOINT + "/{coordinates}/resonance={resonance}"

#: by kind; the braces are wildcards of the workflow
PATHS = {
    "environment": "results/environment.json",
    "assembly": _ASSEMBLY + "/assembly.nc",
    "structure": _ASSEMBLY + "/structure.nc",
    "mesh_view": _ASSEMBLY + "/mesh.vtu",
    "modes": _ASSEMBLY + "/{basis}/modes.nc",
    "modes_view": _ASSEMBLY + "/{basis}/modes.vtu",
    "pod_modes": _ASSEMBLY + "/pod_modes.nc",
    "patterns": _ASSEMBLY + "/patterns.nc",
    "preload": _PRELOAD + "/preload.nc",
    "preload_view": _PRELOAD + "/preload.vtu",
    "joint": _JOINT + "/joint.nc",
    "peaks": _JOINT + "/peaks.csv",
    "fit_timing": _JOINT + "/fit_timing.csv",
    "response": _SOLVED + "/response.nc",
    "timing": _SOLVED + "/timing.csv",
    "forward_differences": _SOLVED + "/forward_differences.csv",
    "check": _SOLVED + "/check.csv",
    "backbone": _JOINT + "/backbone/resonance={resonance}/backbone.nc",
    "calibration": _JOINT + "/calibration/calibration.nc",
    "prediction": _JOINT + "/calibration/prediction.nc",
    "fitted_case": _JOINT + "/calibration/fitted.yaml",
    "designs": _SWEEP + "/designs.nc",
    "weighted_joint": _SWEEP + "/joints/{case}/{basis}/{joint}/joint.nc",
    "chunk": _SWEEP + "/chunks/{chunk}.nc",
    "sweep_check": _SWEEP + "/checked.nc",
    "sweep": _SWEEP + "/sweep.nc",
    "sweep_page": _SWEEP + "/explore.html",
}
_FOLDERS = {"figure": ("figures", "svg"), "table": ("tables", "csv"), "html": ("tables", "html")}


def path(kind: str, **fields: object) -> str:
    """The file of a kind of data.

    Parameters
    ----------
    kind
        One of ``PATHS``.
    fields
        What the kind is named by: ``assembly``, ``preload_N`` (``names.Preload``), ``case``,
        ``basis``, ``joint``, ``coordinates``, ``resonance``, ``sweep``, and ``chunk`` from 0.
    """
    return PATHS[kind].format(**fields)


def shown(form: str, kind: str, **fields: Any) -> str:  # noqa: ANN401
    """The file of a figure or table, named by its kind and by whatever it is of.

    Parameters
    ----------
    form
        ``figure``, ``table`` (CSV) or ``html``.
    kind
        What it shows, as ``response`` or ``accuracy``.
    fields
        As for ``path``; a joint is a ``names.JointName``.
    """
    folder, suffix = _FOLDERS[form]
    parts = [kind]
    for key, value in fields.items():
        if key == "joint":
            parts.append(value.file_name)
        elif key == "preload_N":
            parts.append(f"preload={value}")
        elif key == "resonance":
            parts.append(f"resonance={value}")
        else:
            parts.append(str(value))
    return f"results/{folder}/{'_'.join(parts)}.{suffix}"


def beside(text: str) -> str:
    """The file with the checksum of a CSV or JSON file."""
    return text + BESIDE


def page(name: str, packed: bool = False) -> str:
    """A page of the report, by itself or as the report of the workflow embeds it."""
    return f"results/report/{'packed/' if packed else ''}{name}.html"
