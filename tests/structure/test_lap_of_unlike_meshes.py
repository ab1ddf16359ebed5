"""A lap of two bars, 2:3 meshes in contact: loads and peaks are those of meshes that match."""

import numpy as np
import pytest
from element_meshes import faces_where
from examples import build_assembly, coarse_assembly
from scipy import sparse

from boltjoint.dynamics.response.frequency_response import solve_response
from boltjoint.joint.node_to_node import connect_nodes
from boltjoint.structure.elements.assembly import ElementBlock, assemble
from boltjoint.structure.elements.kinds import KINDS
from boltjoint.structure.elements.matrices import IsotropicMaterial
from boltjoint.structure.model import Structure
from boltjoint.structure.modes import find_modes
from boltjoint.structure.nonmatching_faces.weighted_points import weighted_points
from boltjoint.structure.preload import apply_preload

STEEL = IsotropicMaterial(200e9, 0.3, 7800.0)
#: of the lap [m], where bolts are, and a radius between those of their heads and the next nodes
START, END, BOLTS, HEAD = 0.09, 0.16, (0.109, 0.139), 0.007


def bar(part, cells):
    """Nodes and bricks of one bar, with a number of cells in each direction of the lap."""
    mesh = dict.fromkeys(("ring_cells_across_width", "ring_cells_along_bar"), 2 * cells)
    names = ("columns_between_bolt_cells", "columns_at_each_lap_end", "rings_head_to_cell_edge")
    built = build_assembly(coarse_assembly(**mesh, **dict.fromkeys(names, cells)))
    own = built["connectivity"].to_numpy()[built["part"].to_numpy() == part]
    nodes, connectivity = np.unique(own, return_inverse=True)
    return built["coordinate"].to_numpy()[nodes], connectivity.reshape(own.shape)


def lap(cells):
    """Two bars, held at their far ends and pressed together by constant forces under heads."""
    (lower, of_lower), (upper, of_upper) = (bar(part, count) for part, count in enumerate(cells))
    node = np.concatenate([lower, upper])
    blocks = [
        ElementBlock(KINDS["C3D8I"], each, STEEL) for each in (of_lower, of_upper + len(lower))
    ]
    K, M = assemble(node, blocks)
    sides = [faces_where(node, block, lambda x: np.isclose(x[..., 2], 0)) for block in blocks]
    points = weighted_points(node, *sides, [1, 0, 0], weighting="dual")
    free = np.repeat((node[:, 0] > 0) & (node[:, 0] < node[:, 0].max() - 1e-9), 3)
    bolts = {}
    for number, place in enumerate(BOLTS):
        force = np.zeros(node.shape)
        for block, z in zip(blocks, (-0.01, 0.01), strict=True):

            def is_under_head(x, place=place, z=z):
                near = np.hypot(x[..., 0] - place, x[..., 1]) < HEAD
                return near & np.isclose(x[..., 2], z)

            (faces,) = faces_where(node, block, is_under_head)
            diagonal = node[faces[:, 2:]] - node[faces[:, :2]]
            area = np.linalg.norm(np.cross(diagonal[:, 0], diagonal[:, 1]), axis=1)
            share = np.repeat(area / (4 * area.sum()), 4)
            np.add.at(force[:, 2], faces.ravel(), -np.sign(z) * share)
        bolts[f"bolt-{number}"] = force.ravel()[free]
    corner = np.flatnonzero(np.isclose(node, [END, 0.01, -0.01]).all(axis=1))[0]
    row = np.zeros(free.size)
    row[3 * corner + 2] = 1.0
    displacement = sparse.eye_array(free.size, format="csc")[:, free]
    contact = points.contact_points(displacement, friction_coefficient=0.1)
    K, M = (each[free][:, free].tocsc() for each in (K, M))
    tip = {"tip": row[free]}
    return Structure.from_matrices(K, M, contact, bolts=bolts, inputs=tip, outputs=tip)


def loads_on_areas(preload, side=0.01):
    """Normal loads on areas of 1 cm2 that pass into each other."""
    x, load = preload["position"].to_numpy(), preload["normal_load"].to_numpy()
    hats = [
        np.maximum(0, 1 - abs(x[:, [axis]] - np.arange(low, high + side / 2, side)) / side)
        for axis, (low, high) in enumerate(((START, END), (-0.01, 0.01)))
    ]
    return np.einsum("p,pi,pj->ij", load, *hats)


def test_meshes_of_two_to_three():
    matching, unlike = (lap(cells) for cells in ((2, 2), (2, 3)))
    assert len(unlike.contact) == len(matching.contact)
    entries = [np.diff(each.contact.relative.indptr) for each in (matching, unlike)]
    assert set(entries[0]) == {2}
    assert entries[1].max() > 6
    preloads = [apply_preload(each, 8e3) for each in (matching, unlike)]
    expected, loads = (loads_on_areas(each) for each in preloads)
    np.testing.assert_allclose(loads, expected, atol=0.02 * expected.max(), rtol=0)
    peaks = [
        solve_response(
            connect_nodes(find_modes(each, "free-4"), preload, 1e8, 0.1),
            [2.0, 20.0],
            damping=2e-3,
        )
        for each, preload in zip((matching, unlike), preloads, strict=True)
    ]
    for name, tolerance in (("peak_frequency", 2e-3), ("peak_amplitude", 2e-2)):
        expected, found = (each[name].to_numpy() for each in peaks)
        assert found == pytest.approx(expected, rel=tolerance)
    # and these peaks are those of friction
    assert peaks[0]["peak_frequency"][0] > 1.01 * peaks[0]["peak_frequency"][1]
