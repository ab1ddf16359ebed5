"""Mesh, modes and contact as VTU files for ParaView, deterministic to the byte."""

from collections.abc import Mapping
from pathlib import Path

import meshio
import numpy as np
import xarray as xr
from numpy.typing import NDArray

from boltjoint import checks
from boltjoint.harmonics import Components
from boltjoint.structure.elements.kinds import FACES_OF_HEXAHEDRON

Array = NDArray[np.float64]

#: kinds of elements by their number of corners
_KINDS = {
    **{4: "tetra", 5: "pyramid", 6: "wedge", 8: "hexahedron", 10: "tetra10", 13: "pyramid13"},
    **{15: "wedge15", 20: "hexahedron20", 27: "hexahedron27"},
}


def write_mesh(assembly: xr.Dataset, path: str | Path) -> None:
    """Write the elements, coloured by ``part``, of half laps 0 and 1 the bars, then bolts, washers.

    Of structures from matrices the contact points, as all that is known of their place.

    Parameters
    ----------
    assembly
        As from ``build_assembly``, or ``assembly.nc``.
    path
        The file to write, ending in ``.vtu``; its folder is made.
    """
    _write(path, assembly, {})


def write_modes(assembly: xr.Dataset, modes: xr.Dataset, path: str | Path) -> None:
    """Write mass-normalised modes [kg^-1/2] as displacements of the nodes, to warp the mesh by.

    Where there are no nodes, relative displacements of the contact points.

    Parameters
    ----------
    assembly, modes
        As from ``build_assembly`` and ``find_modes``, of the same mesh.
    path
        The file to write, ending in ``.vtu``; its folder is made.

    Raises
    ------
    ValueError
        If the modes are of another mesh.
    """
    if "mode_shape" in modes:
        shape = _of(assembly, "node", modes["mode_shape"].transpose("mode", "node", "axis"), 1)
    else:
        relative = modes["relative_mode"].transpose("mode", "pair", "axis")
        along = _of(assembly, "pair", relative, 1)
        shape = np.einsum("mpd,pda->mpa", along, assembly["frame"].to_numpy())
    frequency = modes["natural_frequency"].to_numpy()
    names = [f"mode {i + 1}, {f:.1f} Hz" for i, f in enumerate(frequency)]
    _write(path, assembly, dict(zip(names, shape, strict=True)))


def write_preload(assembly: xr.Dataset, preload: xr.Dataset, path: str | Path) -> None:
    """Write the preloaded assembly: displacement [m] of all nodes, and the state of the contact.

    The contact is the ``part`` after the last other: faces of half laps, else its points. It has
    ``normal_load`` [N], ``pressure`` [Pa] and ``gap`` [m]; elsewhere they are NaN.

    Parameters
    ----------
    assembly, preload
        As from ``build_assembly`` and ``apply_preload``, of the same mesh.
    path
        The file to write, ending in ``.vtu``; its folder is made.

    Raises
    ------
    ValueError
        If the preload is of another mesh.
    """
    of_nodes = {}
    if "displacement" in preload:
        displacement = preload["displacement"].transpose("node", "axis")
        of_nodes["displacement"] = _of(assembly, "node", displacement, 0)
    load = _of(assembly, "pair", preload["normal_load"], 0)
    of_pairs = {
        "normal_load": load,
        "pressure": load / assembly["area"].to_numpy(),
        "gap": preload["gap"].to_numpy(),
    }
    _write(path, assembly, of_nodes, of_pairs)


def write_period(
    assembly: xr.Dataset,
    modes: xr.Dataset,
    motion: Array,
    components: Components,
    frequency: float,
    contact_state: Array,
    path: str | Path,
    *,
    instants: int = 16,
) -> None:
    """Write a period of motion as a time series: a PVD file, and beside it a VTU file an instant.

    Each has the ``displacement`` [m] of the nodes from where the preload holds them, under base
    excitation relative to the supports, and the ``contact_state`` of the pairs over the period
    (``friction.contact_states``).

    Parameters
    ----------
    assembly, modes
        As for ``write_modes``, with nodes.
    motion, components
        Modal coordinates by component [kg^1/2 m], shape (components, modes).
    frequency
        Of the motion [Hz].
    contact_state
        States by pair, NaN where a pair has no element, shape (pairs,).
    path
        The file to write, ending in ``.pvd``; the others lie in a folder of its name without that.
    instants
        How many, equally spaced from the begin of the period.

    Raises
    ------
    ValueError
        If the modes are of another mesh or without nodes, or an argument has another shape.
    """
    if "mode_shape" not in modes or "coordinate" not in assembly:
        raise ValueError("the structure has no nodes: its motion cannot be drawn")
    shape = _of(assembly, "node", modes["mode_shape"].transpose("mode", "node", "axis"), 1)
    motion = checks.array("motion", motion, (len(components), modes.sizes["mode"]))
    contact_state = checks.array(
        "contact_state", contact_state, (assembly.sizes["pair"],), finite=False
    )
    period = 1 / checks.number("frequency", frequency, above=0)
    instants = checks.whole("instants", instants, above=0)
    path = Path(path)
    entries = []
    for i, coordinate in enumerate(components.at_samples(instants).T @ motion):
        file = f"{path.stem}/{i:03d}.vtu"
        displacement = np.tensordot(coordinate, shape, 1)
        of_nodes = {"displacement": displacement.astype(np.float32)}
        _write(path.parent / file, assembly, of_nodes, {"contact_state": contact_state})
        entries.append(f'<DataSet timestep="{period * i / instants:.9g}" file="{file}"/>')
    series = "\n".join(entries)
    text = f'<VTKFile type="Collection"><Collection>\n{series}\n</Collection></VTKFile>\n'
    path.write_text(text, encoding="utf-8")


def _write(
    path: str | Path,
    assembly: xr.Dataset,
    of_points: Mapping[str, NDArray],
    of_pairs: Mapping[str, NDArray] | None = None,
) -> None:
    """Write quantities of the nodes, where there are any, else of the pairs; of pairs others."""
    point, cells, parts = np.zeros((0, 3)), [], []
    if has_nodes := "coordinate" in assembly:
        point, part = assembly["coordinate"].to_numpy(), assembly["part"].to_numpy()
        corner = assembly["connectivity"].to_numpy()
        corners = (corner >= 0).sum(axis=1)
        for count in np.unique(corners):
            cells.append((_KINDS[count], corner[corners == count, :count]))
            parts.append(part[corners == count])
    contact = None
    if "pair_node" not in assembly:
        pair = len(point) + np.arange(assembly.sizes["pair"])
        point = np.concatenate([point, assembly["position"].to_numpy()])
        contact = ("vertex", pair[:, None])
    elif of_pairs is not None:
        pair = assembly["pair_node"].sel(side="A").to_numpy()
        contact = ("quad", _faces_on(assembly, pair))
    if contact is not None:
        last = max((int(part.max()) for part in parts), default=-1)
        kind = parts[0].dtype if parts else np.dtype(np.int8)
        cells.append(contact)
        parts.append(np.full(len(contact[1]), last + 1, dtype=kind))
    nodes = np.arange(assembly.sizes["node"]) if has_nodes else pair
    point_data = {name: _spread(value, nodes, len(point)) for name, value in of_points.items()}
    if of_pairs is not None:
        point_data |= {name: _spread(value, pair, len(point)) for name, value in of_pairs.items()}
    mesh = meshio.Mesh(point, cells, point_data=point_data, cell_data={"part": parts})
    Path(path).parent.mkdir(parents=True, exist_ok=True)
    mesh.write(path, file_format="vtu")


def _spread(value: NDArray, place: NDArray[np.int64], points: int) -> NDArray:
    """A quantity at all points, of some of them; NaN at others."""
    whole = np.full((points, *value.shape[1:]), np.nan, np.result_type(value, np.float32))
    whole[place] = value
    return whole


def _of(assembly: xr.Dataset, what: str, values: xr.DataArray, axis: int) -> Array:
    """Quantities of the nodes or pairs of an assembly, which has as many."""
    there = assembly.sizes.get(what, 0)
    if values.shape[axis] != there:
        raise ValueError(f"{values.name} has {values.shape[axis]} {what}s, the assembly {there}")
    return values.to_numpy()


def _faces_on(assembly: xr.Dataset, node: NDArray[np.int64]) -> NDArray[np.int64]:
    """Faces of the hexahedra with all four corners among the nodes, shape (faces, 4)."""
    among = np.zeros(assembly.sizes["node"], dtype=bool)
    among[node] = True
    face = assembly["connectivity"].to_numpy()[:, FACES_OF_HEXAHEDRON].reshape(-1, 4)
    return face[among[face].all(axis=1)]
