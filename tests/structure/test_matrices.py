"""Structures from files of matrices have the numbers of the assembly that they come from."""

import modal_files
import numpy as np
import pytest
from examples import freed
from matrix_files import KEYS, SMALL, blocks, described, exported, write_npz, written
from scipy import sparse
from scipy.spatial.transform import Rotation

from boltjoint.config.matrices import Matrices
from boltjoint.structure.makers.matrices import check
from boltjoint.structure.makers.matrices.source import sizes_of_matrices
from boltjoint.structure.makers.matrices.structure import structure_of_matrices
from boltjoint.structure.makers.registry import structure_of
from boltjoint.structure.modes import find_modes
from boltjoint.structure.preload import apply_preload

LOAD = 8e3


@pytest.fixture(scope="module")
def expected(structure):
    """Natural frequencies and normal loads of the assembly itself."""
    frequency = find_modes(structure, "all-8")["natural_frequency"].to_numpy()
    return frequency, apply_preload(structure, LOAD, tolerance=1e-12)["normal_load"].to_numpy()


def assert_same(found, expected):
    frequency, load = expected
    modes = find_modes(found, "all-8")
    np.testing.assert_allclose(modes["natural_frequency"], frequency, rtol=1e-9)
    preload = apply_preload(found, LOAD, tolerance=1e-12)
    np.testing.assert_allclose(preload["normal_load"], load, rtol=0, atol=1e-8 * load.max())


@pytest.mark.parametrize("form", ["npz", "mat 5", "mat 7.3", "mtx"])
def test_files_give_frequencies_and_loads_of_the_assembly(form, structure, expected, tmp_path):
    description = written(form, tmp_path, structure)
    found = structure_of_matrices(description, tmp_path)
    for name in ("stiffness", "mass"):
        assert abs(getattr(found, name) - getattr(structure, name)).max() == 0
    assert abs(found.contact.relative - structure.contact.relative).max() == 0
    np.testing.assert_array_equal(found.inputs["shaker"].row, structure.inputs["excitation"].row)
    # the seventh degree of freedom from 1 is the sixth from 0
    assert np.flatnonzero(found.outputs["sensor"].row) == [7 - description.numbered_from]
    assert [found.inputs["shaker"].direction, found.outputs["sensor"].direction] == ["z", "x"]
    assert found.maker == "matrices" and not found.rigid.size
    sizes = structure.dofs, len(structure.contact), 2
    assert sizes_of_matrices(description, tmp_path) == sizes
    assert_same(found, expected)


@pytest.mark.parametrize("form", ["npz", "mat 5", "mat 7.3", "mtx"])
def test_bolts_are_vectors_of_their_forces_too(form, structure, expected, tmp_path):
    """Shanks that are whole, and the forces of their shortening."""
    preload = apply_preload(structure, LOAD, tolerance=1e-12)
    moving, held = structure.moving, structure.held
    K = structure.stiffness[moving]
    loads = -K[:, held].toarray() * preload["shank_shortening"].to_numpy() / LOAD
    first = 0 if form == "npz" else 1
    variables = exported(structure, first)
    # the shortenings are the last degrees of freedom
    assert held.min() > moving.max()
    variables |= {
        "K": K[:, moving],
        "M": structure.mass[moving][:, moving],
        "loads": loads,
        "tip": variables["tip"][moving],
    }
    bolts = [{"name": f"bolt-{n}", "load": "loads", "column": n + first} for n in (1, 0)]
    found = structure_of_matrices(
        written(form, tmp_path, structure, variables, bolts=bolts), tmp_path
    )
    assert [bolt.locked for bolt in found.bolts] == [None, None]
    np.testing.assert_array_equal(np.transpose([bolt.load for bolt in found.bolts]), loads[:, ::-1])
    if form == "npz":
        assert_same(found, expected)


@pytest.mark.parametrize("kind", ["csr", "csc", "coo"])
def test_matrices_of_scipy_have_files_of_their_own(kind, structure, tmp_path):
    write_npz(tmp_path / "joint.npz", exported(structure))
    matrix = structure.stiffness + sparse.eye_array(structure.dofs)
    sparse.save_npz(tmp_path / "K.npz", matrix.asformat(kind))
    files = [{"variable": "K", "file": "K.npz"}]
    found = structure_of_matrices(described(structure, files=files), tmp_path)
    assert abs(found.stiffness - matrix).max() == 0


def rows_of_relative(structure, along, by, turn):
    """Rows of relative displacements in space, or in frames that are turned."""
    points = len(structure.contact)
    relative = structure.contact.relative
    if along == "frame":
        relative = sparse.block_diag([turn] * points, format="csr") @ relative
    order = np.arange(3 * points)
    return relative[order if by == "point" else order.reshape(points, 3).T.ravel()]


@pytest.mark.parametrize("along", ["xyz", "frame"])
@pytest.mark.parametrize("by", ["point", "direction"])
def test_rows_at_quadrature_points_are_as_good_as_pairs(along, by, structure, expected, tmp_path):
    """Of pairs of nodes, whose frames are turned about the normal, as frames or directions."""
    turn = Rotation.from_euler("z", 25, degrees=True).as_matrix()
    variables = exported(structure)
    variables["relative"] = rows_of_relative(structure, along, by, turn)
    variables["frames"] = np.tile(turn, (len(structure.contact), 1, 1))
    write_npz(tmp_path / "joint.npz", variables)
    contact = {"relative": "relative", "relative_along": along, "relative_by": by}
    of_frames = described(structure, contact={**contact, "frame": "frames"})
    of_directions = described(
        structure, contact={**contact, "normal": [0, 0, 3], "first_tangent": [*turn[0, :2], 5]}
    )
    found = structure_of_matrices(of_frames, tmp_path)
    other = structure_of_matrices(of_directions, tmp_path)
    assert abs(found.contact.relative - other.contact.relative).max() < 1e-15
    np.testing.assert_allclose(found.contact.frame, other.contact.frame, atol=1e-15)
    expected_rows = rows_of_relative(structure, "frame", "point", turn)
    assert abs(found.contact.relative - expected_rows).max() < 1e-15
    if (along, by) == ("xyz", "direction"):
        assert_same(found, expected)


def test_millimetres_and_tonnes_are_metres_and_kilogrammes(structure, tmp_path):
    variables = exported(structure)
    variables["K"], variables["M"] = (variables[name] / 1e3 for name in "KM")
    variables["support"] = structure.support / 1e3
    variables["area"], variables["position"] = variables["area"] * 1e6, variables["position"] * 1e3
    variables["gap"] = np.linspace(0, 1e-3, len(structure.contact))
    write_npz(tmp_path / "joint.npz", variables)
    contact = {**KEYS["contact"], "gap": "gap"}
    found = structure_of_matrices(
        described(structure, length_unit="mm", contact=contact, support="support"), tmp_path
    )
    for name in ("stiffness", "mass"):
        apart = abs(getattr(found, name) - getattr(structure, name)).max()
        assert apart < 1e-15 * abs(getattr(structure, name)).max()
    np.testing.assert_allclose(found.support, structure.support, rtol=1e-15)
    for name in ("area", "position"):
        given = getattr(structure.contact, name)
        np.testing.assert_allclose(getattr(found.contact, name), given, rtol=1e-15, atol=1e-18)
    np.testing.assert_allclose(found.contact.gap, np.linspace(0, 1e-6, len(structure.contact)))


def test_surfaces_have_their_own_contact(structure, tmp_path):
    points = len(structure.contact)
    variables = exported(structure, first=1)
    variables["of"] = np.arange(points) % 2 + 1
    write_npz(tmp_path / "joint.npz", variables)
    surfaces = [
        {"name": "level", "friction_coefficient": 0.4},
        {"name": "tilted", "normal": [1, 0, 1], "penalty_N_per_m3": 2e12},
    ]
    contact = {**KEYS["contact"], "surface": "of", "surfaces": surfaces}
    given = described(structure, numbered_from=1, contact=contact)
    assert given.surface_names == ("level", "tilted")
    found = structure_of_matrices(given, tmp_path).contact
    assert found.surface[:3].tolist() == ["level", "tilted", "level"]
    assert found.friction_coefficient[:2].tolist() == [0.4, 0.1]
    assert found.penalty[:2].tolist() == [1e15, 2e12]
    half = 0.5**0.5
    np.testing.assert_allclose(
        found.frame[1], [[half, 0, -half], [0, 1, 0], [half, 0, half]], atol=1e-15
    )


def test_a_free_structure_has_six_rigid_modes(assembly, expected, tmp_path):
    free = structure_of(freed(assembly))
    found = structure_of_matrices(written("mat 7.3", tmp_path, free), tmp_path)
    assert found.rigid.shape == (free.dofs, 6)
    frequency = find_modes(found, "all-4")["natural_frequency"].to_numpy()
    assert not frequency[:6].any() and frequency[6] > 100
    load = apply_preload(found, LOAD, tolerance=1e-12)["normal_load"]
    # the support is far from the lap, so that it is not felt there
    np.testing.assert_allclose(load, expected[1], rtol=0, atol=1e-6 * expected[1].max())


def test_matrices_are_looked_at_before_anything_is_solved(structure, expected, tmp_path):
    shank = {"shank_diameter_mm": 8, "axis": [0, 0, 2]}
    described = written("npz", tmp_path, structure)
    first, second = described.bolts
    described = described.model_copy(update={"bolts": (first.model_copy(update=shank), second)})
    facts, doubts = check(described, tmp_path)
    assert not doubts
    assert facts["degrees of freedom"] == str(structure.dofs)
    assert facts["rigid-body motions without contact"] == "0"
    told = facts["natural frequencies without contact (Hz)"].split(", ")
    np.testing.assert_allclose(np.array(told, float), expected[0][:4], rtol=1e-5)
    area = 1e4 * structure.contact.area.sum()
    assert (
        facts["contact"]
        == f"contact: {len(structure.contact)} points, {area:.5g} cm², gaps 0 to 0 mm"
    )
    of_first = "bolt-1, held once tight, axis (0, 0, 1), shank of 50.27 mm²"
    assert facts["bolts"] == f"{of_first}; bolt-2, held once tight"
    assert (facts["inputs"], facts["outputs"]) == ("shaker (z)", "sensor (x)")


def test_a_check_tells_rigid_body_motions(assembly, tmp_path):
    free = structure_of(freed(assembly))
    facts, doubts = check(written("npz", tmp_path, free), tmp_path)
    assert facts["rigid-body motions without contact"] == "6"
    assert float(facts["natural frequencies without contact (Hz)"].split(", ")[0]) > 100
    assert not doubts


AREA = "is contact.area in the square of length_unit?"


@pytest.mark.parametrize(
    ("variable", "factor", "doubts"),
    [
        ("area", 1e6, [AREA]),
        ("position", 1e3, ["is length_unit right?", AREA]),
        ("K", 1e-6, ["do stiffness and mass go together, as N/m with kg or N/mm with t?"]),
    ],
)
def test_a_check_asks_about_units(variable, factor, doubts, structure, tmp_path):
    variables = exported(structure)
    variables[variable] = factor * variables[variable]
    write_npz(tmp_path / "joint.npz", variables)
    _, told = check(described(structure), tmp_path)
    assert [line.partition(" is unusual: ")[2] for line in told] == doubts


def test_a_check_asks_about_lengths_in_mm(structure, tmp_path):
    variables = exported(structure)
    variables |= {"position": 1e3 * variables["position"], "area": 1e6 * variables["area"]}
    write_npz(tmp_path / "joint.npz", variables)
    _, (told,) = check(described(structure), tmp_path)
    assert told.endswith("mm is unusual: is length_unit right?")
    assert not check(described(structure, length_unit="mm"), tmp_path)[1]


def test_a_check_tells_modes_of_several_surfaces_and_given_loads(structure, tmp_path):
    modes, preload = find_modes(structure, "free-2"), apply_preload(structure, LOAD)
    points = len(structure.contact)
    content = modal_files.variables(modes, preload) | {"side": np.arange(points) % 2}
    surfaces = [{"name": name} for name in ("lower", "upper")]
    contact = modal_files.KEYS["contact"] | {"surface": "side", "surfaces": surfaces}
    facts, doubts = check(modal_files.written("npz", tmp_path, content, contact=contact), tmp_path)
    lower, upper = facts["contact"].split("; ")
    assert lower.startswith(f"lower: {points - points // 2} points, ")
    assert upper.startswith(f"upper: {points // 2} points, ")
    loaded = np.count_nonzero(content["normal_load"])
    assert facts["normal loads"].endswith(f" N on {loaded} points")
    assert facts["bolts"] == "none, since normal loads are given"
    frequency = facts["natural frequencies without contact (Hz)"].split(", ")
    assert [float(f) for f in frequency] == pytest.approx(content["natural_frequency"], rel=1e-5)
    assert not doubts
    content["natural_frequency"] = 1e-3 * content["natural_frequency"]
    _, (told,) = check(modal_files.written("npz", tmp_path, content, contact=contact), tmp_path)
    assert told.endswith(" Hz is unusual: is natural_frequency in Hz?")


def test_a_check_finds_frequencies_where_few_degrees_of_freedom_have_mass(tmp_path):
    """Arnoldi's method would take more vectors than there are."""
    variables = blocks()
    variables["M"] = np.diag([1.0] * 8 + [0.0] * 4)
    write_npz(tmp_path / "joint.npz", variables)
    facts, _ = check(Matrices.model_validate(SMALL), tmp_path)
    K = variables["K"]
    condensed = K[:8, :8] - K[:8, 8:] @ np.linalg.solve(K[8:, 8:], K[8:, :8])
    expected = np.sqrt(np.linalg.eigvalsh(condensed)[:4]) / (2 * np.pi)
    told = facts["natural frequencies without contact (Hz)"].split(", ")
    np.testing.assert_allclose(np.array(told, float), expected, rtol=1e-5)
    assert facts["bolts"] == "bolt, a dead load"
