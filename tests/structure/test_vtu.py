"""VTU files: what ParaView reads is what the datasets hold, and bytes repeat."""

import xml.etree.ElementTree as ElementTree

import meshio
import numpy as np
import pytest

from boltjoint.harmonics import Components
from boltjoint.structure.vtu import write_mesh, write_modes, write_period, write_preload


def test_mesh_by_part(assembly, tmp_path):
    write_mesh(assembly, tmp_path / "new folder" / "mesh.vtu")
    read = meshio.read(tmp_path / "new folder" / "mesh.vtu")
    np.testing.assert_array_equal(read.points, assembly["coordinate"])
    np.testing.assert_array_equal(read.cells_dict["hexahedron"], assembly["connectivity"])
    np.testing.assert_array_equal(read.cell_data_dict["part"]["hexahedron"], assembly["part"])


def test_modes_as_displacements(assembly, modes, tmp_path):
    write_modes(assembly, modes, tmp_path / "modes.vtu")
    read = meshio.read(tmp_path / "modes.vtu").point_data
    assert len(read) == modes.sizes["mode"]
    first = f"mode 1, {modes['natural_frequency'][0]:.1f} Hz"
    np.testing.assert_array_equal(read[first], modes["mode_shape"].sel(mode=0))


def test_contact_as_a_surface(assembly, coarse, preload, tmp_path):
    write_preload(assembly, preload, tmp_path / "preload.vtu")
    read = meshio.read(tmp_path / "preload.vtu")
    np.testing.assert_array_equal(read.point_data["displacement"], preload["displacement"])
    assert np.nansum(read.point_data["normal_load"]) == pytest.approx(16e3)
    quad = read.cells_dict["quad"]
    part = read.cell_data_dict["part"]["quad"]
    assert np.unique(part).tolist() == [2 + assembly.sizes["bolt"]]
    np.testing.assert_array_equal(
        np.unique(quad), np.sort(assembly["pair_node"].sel(side="A").to_numpy())
    )
    # Gauss: the resultant of the pressure over the quads is that of the pairs, up to how pressure
    # varies within a quad
    corner = read.points[quad]
    area = (
        np.linalg.norm(
            np.cross(corner[:, 2] - corner[:, 0], corner[:, 3] - corner[:, 1]), axis=1
        ).sum()
        / 2
    )
    assert area == pytest.approx(float(assembly["area"].sum()), rel=1e-12)


def test_a_period_as_a_time_series(assembly, modes, tmp_path):
    components = Components.up_to(3)
    motion = np.random.default_rng(3).normal(size=(len(components), modes.sizes["mode"]))
    state = np.full(assembly.sizes["pair"], np.nan)
    state[[0, 2]] = 1, 3
    at_50_Hz = motion, components, 50.0, state, tmp_path / "peak.pvd"
    write_period(assembly, modes, *at_50_Hz, instants=8)
    steps = ElementTree.parse(tmp_path / "peak.pvd").getroot().findall("Collection/DataSet")
    assert [float(step.get("timestep")) for step in steps] == pytest.approx(np.arange(8) / 400)
    shape = modes["mode_shape"].transpose("mode", "node", "axis").to_numpy()
    mean, sine, cosine, _, cosine2, sine3, cosine3 = motion
    quarter, half = mean + sine - cosine2 - sine3, mean - cosine + cosine2 - cosine3
    for place, expected in ((2, quarter), (4, half)):
        read = meshio.read(tmp_path / steps[place].get("file"))
        displacement = np.einsum("m,mna->na", expected, shape)
        size = abs(displacement).max()
        np.testing.assert_allclose(
            read.point_data["displacement"], displacement, rtol=0, atol=1e-6 * size
        )
    pair = assembly["pair_node"].sel(side="A").to_numpy()
    np.testing.assert_array_equal(read.point_data["contact_state"][pair], state)
    with pytest.raises(ValueError, match="has no nodes"):
        write_period(assembly, modes.drop_vars("mode_shape"), *at_50_Hz)


def test_bytes_repeat(assembly, modes, preload, tmp_path):
    for name in ("a", "b"):
        write_mesh(assembly, tmp_path / name / "mesh.vtu")
        write_modes(assembly, modes, tmp_path / name / "modes.vtu")
        write_preload(assembly, preload, tmp_path / name / "preload.vtu")
    for file in (tmp_path / "a").iterdir():
        assert file.read_bytes() == (tmp_path / "b" / file.name).read_bytes()


def test_refuses_results_of_another_mesh(assembly, modes, preload, tmp_path):
    nodes = {"node": slice(0, 10)}
    with pytest.raises(ValueError, match="mode_shape has 10 nodes"):
        write_modes(assembly, modes.isel(nodes), tmp_path / "modes.vtu")
    with pytest.raises(ValueError, match="displacement has 10 nodes"):
        write_preload(assembly, preload.isel(nodes), tmp_path / "preload.vtu")
