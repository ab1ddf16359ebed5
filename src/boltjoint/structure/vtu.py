"""Mesh, modes and contact as VTU files for ParaView, deterministic to the byte."""

from pathlib import Path

import meshio
import numpy as np
import xarray as xr
from numpy.typing import NDArray

from boltjoint.structure.makers.half_lap.mesh import HEXAHEDRON_FACES


def write_mesh(assembly: xr.Dataset, path: str | Path) -> None:
    """Write the hexahedra, coloured by ``part``: 0 and 1 the bars, then bolts and washers.

    Parameters
    ----------
    assembly
        As from ``build_assembly``.
    path
        The file to write, ending in ``.vtu``; its folder is made.
    """
    _write(path, assembly, point_data={})


def write_modes(assembly: xr.Dataset, modes: xr.Dataset, path: str | Path) -> None:
    """Write mass-normalised modes [kg^-1/2] as displacements of the nodes, to warp the mesh by.

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
    shape = _of_nodes(assembly, modes["mode_shape"].transpose("mode", "node", "axis"), 1)
    frequency = modes["natural_frequency"].to_numpy()
    names = [f"mode {i + 1}, {f:.1f} Hz" for i, f in enumerate(frequency)]
    _write(path, assembly, point_data=dict(zip(names, shape, strict=True)))


def write_preload(assembly: xr.Dataset, preload: xr.Dataset, path: str | Path) -> None:
    """Write the preloaded assembly: displacement [m] of all nodes, and the state of the contact.

    The contact is a separate surface, the ``part`` after the last other. On its nodes are
    ``normal_load`` [N], ``pressure`` [Pa] and ``gap`` [m]; other nodes have NaN.

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
    displacement = _of_nodes(assembly, preload["displacement"].transpose("node", "axis"), 0)
    side_a = assembly["pair_node"].sel(side="A").to_numpy()
    load = preload["normal_load"].to_numpy()
    of_pairs = {
        "normal_load": load,
        "pressure": load / assembly["area"].to_numpy(),
        "gap": preload["gap"].to_numpy(),
    }
    point_data = {"displacement": displacement}
    for name, value in of_pairs.items():
        point_data[name] = np.full(assembly.sizes["node"], np.nan)
        point_data[name][side_a] = value
    _write(path, assembly, point_data, surface=_faces_on(assembly, side_a))


def _write(
    path: str | Path,
    assembly: xr.Dataset,
    point_data: dict[str, NDArray],
    surface: NDArray[np.int64] | None = None,
) -> None:
    part = assembly["part"].to_numpy()
    cells = [("hexahedron", assembly["connectivity"].to_numpy())]
    parts = [part]
    if surface is not None:
        cells.append(("quad", surface))
        parts.append(np.full(len(surface), int(part.max()) + 1, dtype=part.dtype))
    mesh = meshio.Mesh(
        assembly["coordinate"].to_numpy(),
        cells,
        point_data={name: np.ascontiguousarray(value) for name, value in point_data.items()},
        cell_data={"part": parts},
    )
    Path(path).parent.mkdir(parents=True, exist_ok=True)
    mesh.write(path, file_format="vtu")


def _of_nodes(assembly: xr.Dataset, values: xr.DataArray, node_axis: int) -> NDArray[np.float64]:
    if values.shape[node_axis] != assembly.sizes["node"]:
        raise ValueError(
            f"{values.name} has {values.shape[node_axis]} nodes, "
            f"the assembly {assembly.sizes['node']}"
        )
    return values.to_numpy()


def _faces_on(assembly: xr.Dataset, node: NDArray[np.int64]) -> NDArray[np.int64]:
    """Faces of the hexahedra with all four corners among the nodes, shape (faces, 4)."""
    among = np.zeros(assembly.sizes["node"], dtype=bool)
    among[node] = True
    face = assembly["connectivity"].to_numpy()[:, HEXAHEDRON_FACES].reshape(-1, 4)
    return face[among[face].all(axis=1)]
