"""Modes of another program or of a test give the joint that they come from."""

import numpy as np
import pytest
from matrix_files import write_npz
from modal_files import LOAD, NODES, modes_at_nodes, variables, write_universal, written
from test_structure_model import peaks

from boltjoint.config.matrices import Matrices
from boltjoint.damping import ModalDamping
from boltjoint.dynamics.response.frequency_response import solve_response
from boltjoint.joint.node_to_node import connect_nodes
from boltjoint.structure.makers.matrices.structure import structure_of_matrices
from boltjoint.structure.modes import find_modes
from boltjoint.structure.preload import apply_preload
from boltjoint.structure.structure_file import load_structure, save_structure

BASIS = "all-8"


@pytest.fixture(scope="module")
def loaded(structure):
    return apply_preload(structure, LOAD)


@pytest.fixture(scope="module")
def basis(assembly):
    return find_modes(assembly, BASIS)


@pytest.fixture(scope="module")
def expected(basis, loaded):
    joint = connect_nodes(basis, loaded, 1e8, 0.1, 1e8)
    return joint, peaks(joint)


def joint_of(structure, basis=BASIS):
    preload = apply_preload(structure, LOAD)
    return connect_nodes(find_modes(structure, basis), preload, 1e8, 0.1, 1e8)


@pytest.mark.parametrize("form", ["npz", "mat 5", "mat 7.3"])
def test_modes_at_contact_points_give_the_joint_they_come_from(
    form, basis, loaded, expected, tmp_path
):
    found = structure_of_matrices(written(form, tmp_path, variables(basis, loaded)), tmp_path)
    save_structure(found, tmp_path / "structure.nc")
    read = load_structure(tmp_path / "structure.nc")
    assert read.dofs == 8 and not read.bolts and not read.rigid.size
    preload = apply_preload(read, LOAD)
    for name in ("normal_load", "gap", "area", "position"):
        np.testing.assert_array_equal(preload[name], loaded[name], err_msg=name)
    joint = joint_of(read)
    np.testing.assert_allclose(peaks(joint), expected[1], rtol=1e-9)
    if form == "npz":
        curves = [solve_response(each, [20.0], damping=2e-3) for each in (joint, expected[0])]
        for name in ("frequency", "response_amplitude"):
            np.testing.assert_allclose(*(curve[name] for curve in curves), rtol=1e-9)


@pytest.fixture(scope="module")
def test_data(assembly, basis):
    return modes_at_nodes(assembly, basis)


def of_contact(test_data, loaded):
    """Variables beside a universal file."""
    given = {name: loaded[name].to_numpy() for name in ("area", "normal_load", "gap")}
    return given | {side: test_data[side] for side in ("side_a", "side_b")}


def described(test_data, **changes):
    place = {"name": "tip", "node": test_data["tip"], "direction": "z"}
    return Matrices.model_validate({**NODES, "inputs": [place], "outputs": [place], **changes})


def test_a_universal_file_gives_the_joint_of_its_digits(test_data, loaded, expected, tmp_path):
    """Modal masses are divided out; the same shapes in NumPy's file have the same joint."""
    write_universal(tmp_path / "test.unv", test_data)
    contact = of_contact(test_data, loaded)
    write_npz(tmp_path / "joint.npz", contact)
    found = structure_of_matrices(described(test_data), tmp_path)
    np.testing.assert_allclose(found.contact.position, loaded["position"], atol=1e-15)
    of_unit_mass = test_data["mode_shape"] / np.sqrt(test_data["modal_mass"])
    names = ("natural_frequency", "node", "node_position")
    arrays = {"mode_shape": of_unit_mass, **{name: test_data[name] for name in names}}
    write_npz(tmp_path / "joint.npz", contact | arrays)
    modes = {name: name for name in arrays}
    other = structure_of_matrices(described(test_data, modes=modes), tmp_path)
    of_digits = peaks(joint_of(found))
    np.testing.assert_allclose(of_digits, peaks(joint_of(other)), rtol=1e-9)
    # six digits of shapes, of which relative displacements are differences
    np.testing.assert_allclose(of_digits, expected[1], rtol=1e-3)


def test_millimetres_and_tonnes_are_metres_and_kilogrammes(test_data, loaded, tmp_path):
    contact = of_contact(test_data, loaded)
    found = []
    for unit, metre, tonne in (("m", 1, 1), ("mm", 1e3, 1e-3)):
        scaled = test_data["node_position"] * metre
        mass = test_data["modal_mass"] * tonne
        changed = test_data | {"node_position": scaled, "modal_mass": mass}
        write_universal(tmp_path / "test.unv", changed, units=(metre, 1.0))
        lengths = {"area": contact["area"] * metre**2, "gap": contact["gap"] * metre}
        write_npz(tmp_path / "joint.npz", contact | lengths)
        found.append(structure_of_matrices(described(test_data, length_unit=unit), tmp_path))
    one, other = (find_modes(each, BASIS) for each in found)
    for name in ("natural_frequency", "relative_mode", "excitation_mode", "position"):
        largest = abs(one[name]).max()
        np.testing.assert_allclose(other[name], one[name], rtol=1e-9, atol=1e-12 * largest)
    one, other = (apply_preload(each, LOAD) for each in found)
    for name in ("normal_load", "gap"):
        np.testing.assert_allclose(other[name], one[name], rtol=1e-12)


def test_damping_ratios_are_those_of_their_modes(test_data, loaded, tmp_path):
    """In a basis without the modes across the bar too."""
    write_universal(tmp_path / "test.unv", test_data, ratio=1e-3)
    write_npz(tmp_path / "joint.npz", of_contact(test_data, loaded))
    modes = {"file": "test.unv", "damping_ratio": "damping_ratio"}
    given = described(test_data, modes=modes).in_folder(tmp_path)
    ratios = 1e-3 * np.arange(1, 9)
    np.testing.assert_allclose(given.damping_ratios, ratios, rtol=1e-12)
    joint = joint_of(structure_of_matrices(given, tmp_path), "free-3")
    frequency = joint.natural_frequency
    place = [np.argmin(abs(test_data["natural_frequency"] - each)) for each in frequency]
    assert place != [0, 1, 2]
    matrix = ModalDamping(given.damping_ratios).matrix(joint.structure()).at(1.0)
    expected = 2 * ratios[place] * 2 * np.pi * frequency
    np.testing.assert_allclose(matrix, np.diag(expected), atol=1e-9 * expected.max())


def test_rigid_body_modes_have_no_frequency_and_no_relative_motion(basis, loaded, tmp_path):
    content = variables(basis, loaded)
    content["natural_frequency"] = np.array([0.0, 0.0, *content["natural_frequency"]])
    content["relative"] = np.pad(content["relative"], [(0, 0), (2, 0)])
    content["tip"] = np.array([0.3, -0.2, *content["tip"]])
    found = structure_of_matrices(written("npz", tmp_path, content), tmp_path)
    assert found.rigid.shape == (10, 2)
    modes = find_modes(found, BASIS)
    assert modes["natural_frequency"].to_numpy()[:3] == pytest.approx(
        [0, 0, basis["natural_frequency"][0].item()], rel=1e-9
    )
    content["relative"][5, 0] = 0.1
    given = written("npz", tmp_path, content)
    with pytest.raises(ValueError, match="connected by the contact alone"):
        structure_of_matrices(given, tmp_path)


def row(*values):
    return np.array(values, dtype=float)


#: sentence; changes of variables from those there; changes of keys
REFUSALS = [
    ("joint.npz: natural_frequency must be at least 0, but is -5 at index 1",
     lambda v: {"natural_frequency": row(60, -5, *v["natural_frequency"][2:])}, {}),
    ("joint.npz: natural_frequency must be finite, but is nan at index 0",
     lambda v: {"natural_frequency": row(np.nan, *v["natural_frequency"][1:])}, {}),
    ("joint.npz: natural_frequency has shape (2, 4): it must be a vector",
     lambda v: {"natural_frequency": v["natural_frequency"].reshape(2, 4)}, {}),
    ("joint.npz: natural_frequency is not there; did you mean frequency?",
     lambda v: {"natural_frequency": None, "frequency": v["natural_frequency"]}, {}),
    ("joint.npz: relative has shape (", lambda v: {"relative": v["relative"][:, :7]}, {}),
    ("joint.npz: tip has shape (7,), expected (8,)", lambda v: {"tip": v["tip"][:7]}, {}),
    ("joint.npz: tip is zero: nothing moves at shaker", lambda v: {"tip": 0 * v["tip"]}, {}),
    ("joint.npz: relative must be finite, but is inf at index (0, 0)",
     lambda v: {"relative": np.where(np.indices(v["relative"].shape).sum(0) == 0, np.inf,
                                     v["relative"])}, {}),
    ("joint.npz: normal_load must be at least 0, but is -1 at index 0",
     lambda v: {"normal_load": row(-1, *v["normal_load"][1:])}, {}),
    ("joint.npz: normal_load has shape (", lambda v: {"normal_load": v["normal_load"][1:]}, {}),
    ("joint.npz: normal_load is zero: nothing is pressed together",
     lambda v: {"normal_load": 0 * v["normal_load"]}, {}),
    ("joint.npz: normal_load: point 0 has a load of 9 and a gap",
     lambda v: {"normal_load": row(9, *v["normal_load"][1:]), "gap": 1e-6 + v["gap"]}, {}),
    ("joint.npz: mode_shape has shape (24, 7), expected 8 columns, as natural_frequency has modes",
     lambda v: {"mode_shape": np.ones((24, 7))}, {"modes": {"mode_shape": "mode_shape"}}),
    ("joint.npz: node has 7 numbers: mode_shape has 24 rows, and needs three of each node",
     lambda v: {"mode_shape": np.ones((24, 8)), "node": np.arange(7)},
     {"modes": {"mode_shape": "mode_shape", "node": "node"}}),
    ("joint.npz: natural_frequency has degrees of freedom from 0 to 7: dof of end is 8",
     lambda v: {}, {"inputs": [{"name": "end", "dof": 8}]}),
]  # fmt: skip


@pytest.mark.parametrize(("sentence", "changes", "keys"), REFUSALS)
def test_what_is_no_modal_data_is_refused_in_a_line(
    sentence, changes, keys, basis, loaded, tmp_path
):
    content = variables(basis, loaded)
    content |= changes(content)
    content = {name: value for name, value in content.items() if value is not None}
    given = written("npz", tmp_path, content, **keys)
    with pytest.raises(ValueError) as refused:
        structure_of_matrices(given, tmp_path)
    said = str(refused.value)
    assert sentence in said and "\n" not in said


#: sentence; changes of what is written; of all modes in the file; of variables; of keys
REFUSED_TESTS = [
    ("test.unv: mode_shape has no modal mass in the mode of ", {}, {"modal_m": 0.0}, {}, {}),
    ("test.unv: mode_shape has no modal mass in the mode of ", {}, {"modal_m": -1.0}, {}, {}),
    ("test.unv: natural_frequency must be at least 0, but is -3 at index 0", {}, {"freq": -3.0},
     {}, {}),
    ("test.unv: natural_frequency is of analysis type 3 in data set 55 number 1: it must be",
     {}, {"analysis_type": 3, "eig": 1j, "modal_a": 1j, "modal_b": 1j}, {}, {}),
    ("test.unv: node_position is in coordinate system 7 at node ", {"system": 7}, {}, {}, {}),
    ("joint.npz: side_b: one of them is node 999999, which test.unv: node does not hold", {}, {},
     {"side_b": 999999}, {}),
    ("node of far is node 888888, which test.unv: node does not hold", {}, {}, {},
     {"outputs": [{"name": "far", "node": 888888, "direction": "x"}]}),
    ("test.unv: has 1000 of its lengths in a metre and 1 of its forces in a newton: with length",
     {"units": (1e3, 1.0)}, {}, {}, {}),
    ("test.unv: damping_ratio is zero: elastic modes have damping", {}, {}, {},
     {"modes": {"file": "test.unv", "damping_ratio": "damping_ratio"}}),
]  # fmt: skip


@pytest.mark.parametrize(("sentence", "writing", "of_modes", "others", "keys"), REFUSED_TESTS)
def test_what_is_no_modal_test_is_refused_in_a_line(
    sentence, writing, of_modes, others, keys, test_data, loaded, tmp_path
):
    write_universal(tmp_path / "test.unv", test_data, **writing, **of_modes)
    contact = of_contact(test_data, loaded)
    for name, number in others.items():
        contact[name] = np.array([number, *contact[name][1:]])
    write_npz(tmp_path / "joint.npz", contact)
    given = described(test_data, **keys).in_folder(tmp_path)
    problems = [line for _, line in given.conflicts_of_files()]
    try:
        structure_of_matrices(given, tmp_path)
    except ValueError as refused:
        problems.append(str(refused))
    assert problems and sentence in problems[0] and "\n" not in problems[0]


def test_a_damaged_universal_file_is_said_in_a_line(test_data, loaded, tmp_path):
    write_npz(tmp_path / "joint.npz", of_contact(test_data, loaded))
    write_universal(tmp_path / "test.unv", test_data)
    whole = (tmp_path / "test.unv").read_text()
    for text in ("no universal file\n", whole[: len(whole) // 2], whole.replace("e", "q"), ""):
        (tmp_path / "test.unv").write_text(text)
        with pytest.raises(ValueError, match=r"^test\.unv: ") as refused:
            structure_of_matrices(described(test_data), tmp_path)
        assert "\n" not in str(refused.value)
