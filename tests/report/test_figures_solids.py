"""Pictures of solid bodies: their outer faces, contact points, modes and shape under preload."""

import numpy as np
import pytest
import xarray as xr

from boltjoint.dataset import quantity
from boltjoint.report.figures.solids import (
    outer_faces,
    plot_solid_deformation,
    plot_solid_modes,
    plot_solids,
)
from boltjoint.structure.elements.kinds import KINDS

CUBE = KINDS["C3D8"].functions.corner
WEDGE = np.array([[-1, -1, -1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1], [1, -1, 1], [-1, 1, 1]])


@pytest.fixture
def bodies():
    """Two cubes that share a face, and a wedge apart from them, as cells in the order of VTK."""
    places = CUBE, CUBE[4:] + np.array([0, 0, 2]), WEDGE + np.array([0.0, 0, 6])
    node = np.concatenate(places)
    wedge = 12 + KINDS["C3D6"].vtk_order
    cell = [range(8), [4, 5, 6, 7, 8, 9, 10, 11], [*wedge, -1, -1]]
    return xr.Dataset(
        {
            "coordinate": quantity(("node", "axis"), node, "m", "position"),
            "connectivity": (("element", "corner"), np.array([list(each) for each in cell])),
            "part": ("element", np.array([0, 0, 1])),
            "position": quantity(("pair", "axis"), np.array([[0.0, 0, 3], [0, 0.1, 3]]), "m", ""),
            "surface": ("pair", np.array(["lap", "head"], dtype=object)),
        },
        coords={"axis": ["x", "y", "z"]},
    )


def test_outer_faces_close_the_bodies_and_look_outward(bodies):
    face, body = outer_faces(bodies)
    # ten of the cubes, five of the wedge
    assert np.bincount(body).tolist() == [10, 5]
    node = bodies["coordinate"].to_numpy()
    corner = node[face]
    area = np.cross(corner[:, 2] - corner[:, 0], corner[:, 3] - corner[:, 1]) / 2
    for number, volume in enumerate((16.0, 4.0)):
        own = body == number
        assert np.allclose(area[own].sum(axis=0), 0)
        # the divergence theorem, of flat faces about a corner of each
        assert np.sum(area[own] * corner[own, 0]) / 3 == pytest.approx(volume)


def test_bodies_are_drawn_with_their_contact_points(bodies):
    figure = plot_solids(bodies)
    above, below = figure.axes
    assert above.get_title() == "bodies"
    labels = [text.get_text() for text in below.get_legend().get_texts()]
    assert labels == ["lap: 1 points", "head: 1 points"]
    polygons = above.collections[0].get_paths()
    # of a convex body those that look at the viewer
    assert 0 < len(polygons) < len(outer_faces(bodies)[0])


def test_modes_and_preload_are_drawn_enlarged(bodies):
    shape = np.zeros((18, 3, 3))
    shape[12:, 2, 2] = 1.0
    modes = xr.Dataset(
        {
            "natural_frequency": ("mode", [0.0, 0.0, 120.5]),
            "mode_shape": (("node", "axis", "mode"), shape),
        }
    )
    (axes,) = plot_solid_modes(bodies, modes).axes
    assert axes.get_title() == "mode 1: 120.5 Hz"
    colours = axes.collections[0].get_facecolor()
    # the wedge moves, the cubes do not
    assert len(np.unique(colours.round(2), axis=0)) >= 2
    displacement = 1e-6 * shape[..., 2]
    preload = xr.Dataset({"displacement": (("node", "axis"), displacement)})
    (axes,) = plot_solid_deformation(bodies, preload).axes
    assert axes.get_title() == "largest displacement 1 μm"
