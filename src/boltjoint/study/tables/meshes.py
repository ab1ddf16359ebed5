"""Tables of a mesh study: the contact of each mesh, and how peaks and backbone converge.

References
----------
P. J. Roache: Quantification of uncertainty in computational fluid dynamics. Annual Review of Fluid
Mechanics 29 (1997) 123-160.
"""

from collections.abc import Iterator, Sequence
from typing import Any, NamedTuple

import numpy as np
import pandas as pd
import xarray as xr
from numpy.typing import NDArray
from scipy.optimize import brentq

from boltjoint import checks
from boltjoint.joint.io import joint_from_dataset
from boltjoint.structure.elasticity import element_mass
from boltjoint.study.designs import places_of
from boltjoint.study.tables.sweeps import peaks_by_level

Array = NDArray[np.float64]

#: what is told of a backbone, by the columns of the table
_OF_BACKBONE = {"natural_frequency_Hz": "natural_frequency", "damping_ratio": "damping_ratio"}
#: highest order that is sought: differences that fall faster come to nothing by chance
_HIGHEST_ORDER = 20.0


class Mesh(NamedTuple):
    """A mesh of a sweep: assembly, preload of its contact and node-to-node joint, as stored."""

    assembly: xr.Dataset
    preload: xr.Dataset
    joint: xr.Dataset


def element_size(mesh: Mesh) -> float:
    """Size of the elements [m]: the cube root of their mean volume."""
    coordinate = checks.variable("assembly", mesh.assembly, "coordinate", ("node", "axis"))
    dims = ("element", "corner")
    connectivity = checks.index_variable("assembly", mesh.assembly, "connectivity", dims)
    # the mass matrix of an element of density 1 adds up to its volume
    volume = element_mass(coordinate[connectivity], 1.0).sum(axis=(1, 2))
    return float(np.cbrt(volume.mean()))


def tabulate_meshes(meshes: Sequence[Mesh]) -> pd.DataFrame:
    """The contact of each mesh.

    Parameters
    ----------
    meshes
        At least one.

    Returns
    -------
    DataFrame
        A row for each mesh, the coarsest first: ``elements``, ``element_size_mm``
        (``element_size``), ``pairs``, those under load and their area, their stiffness while all
        stick, that per area, and the slip displacement: slip force of all over this stiffness, the
        displacement at which a contact with equal pressure slips. With a stiffness per area it is
        mu p / k of the mean pressure p.
    """
    rows = []
    for mesh in sorted(meshes, key=element_size, reverse=True):
        law = joint_from_dataset(mesh.joint).law
        loaded, area = mesh.preload["normal_load"].to_numpy() > 0, mesh.preload["area"].to_numpy()
        loaded_area = area[loaded].sum()
        stiffness = law.tangential_stiffness[law.slip_force > 0].sum()
        rows.append(
            {
                "elements": mesh.assembly.sizes["element"],
                "element_size_mm": 1e3 * element_size(mesh),
                "pairs": area.size,
                "loaded_pairs": np.count_nonzero(loaded),
                "loaded_area_mm2": 1e6 * loaded_area,
                "stiffness_kN_per_mm": 1e-6 * stiffness,
                "stiffness_N_per_mm3": 1e-9 * stiffness / loaded_area,
                "slip_displacement_um": 1e6 * law.slip_force.sum() / stiffness,
            }
        )
    return pd.DataFrame(rows)


def tabulate_convergence(
    sweep: xr.Dataset, size: Sequence[float], amplitudes: int = 7
) -> pd.DataFrame:
    """Peaks and backbone in the three finest meshes, and the order at which they converge.

    Parameters
    ----------
    sweep
        ``sweep.nc`` of designs that differ in their mesh alone.
    size
        Element size of each design, in their order; NaN of one that is impossible.
    amplitudes
        Number of amplitudes at which the backbones are compared, from all of them.

    Returns
    -------
    DataFrame
        A row for each observed quantity at each level of the excitation, or amplitude of the output
        point: its values ``coarse``, ``medium`` and ``fine``, the changes between two meshes and
        the ``order`` (``observed_order``); then ``extrapolated``, the value of vanishing elements
        by this order (Richardson), and how far the finest mesh is from it. NaN without an order.

    Raises
    ------
    ValueError
        If fewer than three designs have a size.
    """
    places_of(sweep)
    checks.whole("amplitudes", amplitudes, at_least=1)
    sizes = checks.array("size", size, (sweep["reason"].size,), finite=False)
    meshes = np.argsort(-sizes, kind="stable")[: np.count_nonzero(np.isfinite(sizes))][-3:]
    if meshes.size < 3:
        raise ValueError(f"size is {sizes.tolist()}: orders are found from three meshes")
    h = sizes[meshes]
    rows = []
    for told, values in _observed(sweep, amplitudes):
        f = values[meshes]
        order = observed_order(h, f)
        limit = f[2] + (f[2] - f[1]) / ((h[1] / h[2]) ** order - 1)
        rows.append(
            {
                **told,
                **dict(zip(("coarse", "medium", "fine"), f, strict=True)),
                "change_to_medium_percent": 100 * (f[1] / f[0] - 1),
                "change_to_fine_percent": 100 * (f[2] / f[1] - 1),
                "order": order,
                "extrapolated": limit,
                "error_of_fine_percent": 100 * (f[2] / limit - 1),
            }
        )
    return pd.DataFrame(rows)


def observed_order(size: Array, value: Array) -> float:
    """Order p of convergence of values f = f_0 + C h^p in three meshes (Roache 1997).

    Parameters
    ----------
    size, value
        h and f of the coarse, the medium and the fine mesh, shape (3,).

    Returns
    -------
    float
        NaN if the values do not converge so: if they change in both directions, or more from the
        medium to the fine mesh than by any order above 0.
    """
    h, first, last = size / size[2], value[0] - value[1], value[1] - value[2]

    def excess(p: float) -> float:
        return last * (h[0] ** p - h[1] ** p) - first * (h[1] ** p - 1)

    # both terms vanish with p: by their slopes there
    at_zero = last * np.log(h[0] / h[1]) - first * np.log(h[1])
    lowest = 1e-6
    if not np.isfinite(at_zero) or at_zero * excess(_HIGHEST_ORDER) >= 0:
        return np.nan
    if at_zero * excess(lowest) <= 0:
        return np.nan
    return float(brentq(excess, lowest, _HIGHEST_ORDER))


def _observed(sweep: xr.Dataset, amplitudes: int) -> Iterator[tuple[dict[str, Any], Array]]:
    """Observed quantity with its level, and its values by design."""
    for column, level, values in peaks_by_level(sweep):
        yield {"observed": column, "force_N": np.nan, **level, "amplitude_mm": np.nan}, values
    if "amplitude" not in sweep.dims:
        return
    at = np.unique(np.linspace(0, sweep.sizes["amplitude"] - 1, amplitudes).round().astype(int))
    amplitude = 1e3 * checks.variable("sweep", sweep, "amplitude", ("amplitude",))
    dims = ("amplitude", *places_of(sweep))
    for column, name in _OF_BACKBONE.items():
        values = checks.variable("sweep", sweep, name, dims, finite=False)
        for number in at:
            told = {"observed": column, "force_N": np.nan, "amplitude_mm": amplitude[number]}
            yield told, values[number].ravel()
