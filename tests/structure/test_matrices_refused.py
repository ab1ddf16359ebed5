"""Files of matrices that are no structure, damaged or too large: one line with its place."""

import io
import os
import zipfile

import h5py
import numpy as np
import pytest
from matrix_files import DOFS, SMALL, blocks, write_hdf5
from pydantic import ValidationError
from scipy import sparse
from scipy.io import mmwrite, savemat

from boltjoint.config.error_messages import explain
from boltjoint.config.matrices import Matrices
from boltjoint.structure.makers.matrices import reader
from boltjoint.structure.makers.matrices.structure import structure_of_matrices


def changed(matrix, place, value):
    found = np.array(blocks()[matrix], dtype=float)
    found[place] = value
    return {matrix: found}


#: of nodes that hang together in pairs, as those of the contact do, and that nothing holds
FLOATING = 1e7 * np.kron(np.eye(2), np.kron([[1.0, -1], [-1, 1]], np.eye(3)))


def with_contact(**contact):
    return {"contact": {**SMALL["contact"], **contact}}


def sparse_parts(**changes):
    """Parts of a sparse stiffness, of which some are wrong."""
    matrix = sparse.csc_array(blocks()["K"])
    parts = {part: getattr(matrix, part) for part in ("data", "indices", "indptr", "shape")}
    return {"K": None, **{f"K_{key}": value for key, value in {**parts, **changes}.items()}}


RELATIVE = {"relative": "C"}
#: sentence; variables in place of those of ``blocks``, without those that are None; keys
REFUSALS = [
    ("joint.npz: K: stiffness is not symmetric: entries at", changed("K", (0, 1), 1e5), {}),
    ("joint.npz: K is not positive: its diagonal is -5 at degree of freedom 3",
     changed("K", (3, 3), -5), {}),
    ("joint.npz: M is not positive: its diagonal is -1 at degree of freedom 3",
     changed("M", (3, 3), -1), {}),
    ("joint.npz: M is not positive: its diagonal is 0 at degree of freedom 0, and",
     {"M": np.diag([0.0] + 11 * [1]) + np.eye(DOFS, k=11) + np.eye(DOFS, k=-11)},
     {}),
    ("joint.npz: M: mass is not positive: it has a negative eigenvalue",
     {"M": np.eye(DOFS) + np.eye(DOFS, k=11) * 1.1 + np.eye(DOFS, k=-11) * 1.1}, {}),
    ("joint.npz: K: stiffness is not positive", {"K": blocks()["K"] - 2.9e7 * np.eye(DOFS)}, {}),
    ("joint.npz: K must be finite, but is nan at index (2, 3)", changed("K", (2, 3), np.nan), {}),
    ("joint.npz: K must be finite, but is inf at index", sparse_parts(
        data=np.full(sparse.csc_array(blocks()["K"]).nnz, np.inf)), {}),
    ("joint.npz: K: degree of freedom 11 has neither stiffness nor mass",
     {"K": np.pad(blocks()["K"][:11, :11], (0, 1)), "M": np.diag([1.0] * 11 + [0])}, {}),
    ("joint.npz: K has shape (12, 11): it must be square", {"K": np.ones((12, 11))}, {}),
    ("joint.npz: M has shape (5, 5), expected (12, 12)", {"M": np.eye(5)}, {}),
    ("joint.npz: M is not there; there are: K, area, mass_, position",
     {"M": None, "mass_": np.eye(DOFS)}, {}),
    ("joint.npz: Pull is not there; did you mean pull", {},
     {"bolts": [{"name": "bolt", "load": "Pull"}]}),
    ("joint.npz: K has shape (0, 0): it must be square", {"K": np.zeros((0, 0))}, {}),
    ("joint.npz: K holds complex", {"K": blocks()["K"] * 1j}, {}),
    ("joint.npz: K holds text", {"K": np.array([["a", "b"]])}, {}),
    ("joint.npz: K holds Python objects", {"K": np.array([[{}, 1], [1, 2]], dtype=object)}, {}),
    ("joint.npz: K is no sparse matrix", sparse_parts(indices=np.full(30, 99)), {}),
    ("joint.npz: K is no sparse matrix", sparse_parts(indptr=np.array([0, 3])), {}),
    ("joint.npz: K is no sparse matrix", sparse_parts(indices=np.full(30, 0.5)), {}),
    ("joint.npz: K is no sparse matrix: K_indices is not there", sparse_parts(indices=None), {}),
    ("joint.npz: K is no sparse matrix: its shape", sparse_parts(shape=[3.5, 2]), {}),
    ("joint.npz: K has shape (-1, 12)", sparse_parts(shape=[-1, 12]), {}),
    ("joint.npz: K is a sparse matrix of format 'bsr'", sparse_parts(format="bsr"), {}),
    ("joint.npz: K has 5000000 degrees of freedom: it needs some",
     sparse_parts(shape=[5_000_000, 5_000_000], indptr=np.zeros(5_000_001, np.int32)), {}),
    ("joint.npz: area must be positive, but is 0 at index 0", {"area": [0.0]}, {}),
    ("joint.npz: area must be finite", {"area": [np.nan]}, {}),
    ("joint.npz: position has shape (2, 3), expected (1, 3)", {"position": np.ones((2, 3))}, {}),
    ("joint.npz: side_b holds 12: it must hold whole numbers from 0 to 11, with numbered_from: 0",
     {"side_b": [[3, 4, 12]]}, {}),
    ("joint.npz: side_a holds 0: it must hold whole numbers from 1 to 12", {},
     {"numbered_from": 1}),
    ("joint.npz: side_a holds 0.5", {"side_a": [[0.5, 1, 2]]}, {}),
    ("joint.npz: side_b: pair 0 has a degree of freedom that side_a has too",
     {"side_b": [[0, 4, 5]]}, {}),
    ("joint.npz: C has shape (2, 12), expected (3, 12)", {"C": np.ones((2, DOFS))},
     {"contact": RELATIVE}),
    ("joint.npz: C: point 0 has a direction in which no degree",
     {"C": np.eye(DOFS)[:3] * [[1], [1], [0]]}, {"contact": RELATIVE}),
    ("joint.npz: Q: directions of point 0 are not orthonormal", {"Q": np.ones((1, 9))},
     with_contact(frame="Q")),
    ("joint.npz: g must be at least 0", {"g": [-1e-6]}, with_contact(gap="g")),
    ("joint.npz: s holds 2: it must hold whole numbers from 0 to 1", {"s": [2]},
     with_contact(surface="s", surfaces=[{"name": "one"}, {"name": "two"}])),
    ("joint.npz: K has degrees of freedom from 0 to 11: locked of bolt one is 12", {},
     {"bolts": [{"name": "one", "locked": 12}]}),
    ("joint.npz: K has degrees of freedom from 0 to 11: dof of tip is 40", {},
     {"outputs": [{"name": "tip", "dof": 40}]}),
    ("joint.npz: pull has shape (5,), expected (12,)", {"pull": np.ones((5,))}, {}),
    ("joint.npz: pull has shape (12, 2): column must be from 0 to 1", {"pull": np.ones((DOFS, 2))},
     {}),
    ("joint.npz: pull has shape (12, 2): column must be from 0 to 1, not 2",
     {"pull": np.ones((DOFS, 2))}, {"bolts": [{"name": "bolt", "load": "pull", "column": 2}]}),
    ("joint.npz: pull is zero", {"pull": np.zeros(DOFS)}, {}),
    ("joint.npz: r is zero", {"r": np.zeros(DOFS)}, {"inputs": [{"name": "shaker", "row": "r"}]}),
    ("joint.npz: pull: load of bolt is not in equilibrium with itself",
     {"K": FLOATING, "pull": np.ones(DOFS)}, {}),
    ("joint.npz: K: the structure has 7 rigid-body motions: more than 6",
     {"K": np.diag([1e7] * 5 + [0.0] * 7)}, {}),
    ("joint.npz: F has shape (2, 12), expected (3, 12)", {"F": np.ones((2, DOFS))},
     {"support": "F"}),
    ("there is no such file in", {}, {"file": "elsewhere.npz"}),
    ("outside.npz: lies outside the folder of the study", {}, {"file": "outside.npz"}),
    ("pipe.npz: is no regular file", {}, {"file": "pipe.npz"}),
    ("folder.npz: cannot be read: IsADirectoryError", {}, {"file": "folder.npz"}),
]  # fmt: skip


#: of more entries than lines
MARKET = "%%MatrixMarket matrix coordinate real symmetric\n9 9 99999\n1 1 1\n"


def write_small(path, changes):
    variables = {**blocks(), **changes}
    np.savez(path, **{name: value for name, value in variables.items() if value is not None})


def refusal(description, folder):
    with pytest.raises(ValueError) as refused:
        structure_of_matrices(Matrices.model_validate(description), folder)
    text = str(refused.value)
    assert "\n" not in text and len(text) < 400
    return text


def test_the_small_structure_is_one(tmp_path):
    write_small(tmp_path / "joint.npz", {})
    assert structure_of_matrices(Matrices.model_validate(SMALL), tmp_path).dofs == DOFS
    write_small(tmp_path / "joint.npz", {"K": FLOATING})
    assert structure_of_matrices(Matrices.model_validate(SMALL), tmp_path).rigid.shape == (DOFS, 6)
    write_small(tmp_path / "joint.npz", {**sparse_parts(), "M": np.eye(DOFS, dtype=np.int32)})
    found = structure_of_matrices(Matrices.model_validate(SMALL), tmp_path)
    np.testing.assert_array_equal(found.stiffness.toarray(), blocks()["K"])


@pytest.mark.parametrize(("sentence", "variables", "changes"), REFUSALS)
def test_what_is_no_structure_is_one_line(sentence, variables, changes, tmp_path):
    folder = tmp_path / "study"
    folder.mkdir()
    write_small(folder / "joint.npz", variables)
    (folder / "outside.npz").symlink_to("/etc/hosts")
    os.mkfifo(folder / "pipe.npz")
    (folder / "folder.npz").mkdir()
    assert sentence in refusal({**SMALL, **changes}, folder)


def test_a_matrix_is_bounded_before_it_is_read(tmp_path, monkeypatch):
    """Arrays that declare more than their file holds, or more than the machine has memory."""
    write_small(tmp_path / "joint.npz", {})
    head = io.BytesIO()
    np.lib.format.write_array_header_1_0(
        head, {"descr": "<f8", "fortran_order": False, "shape": (10**6, 10**6)}
    )
    with zipfile.ZipFile(tmp_path / "large.npz", "w") as archive:
        archive.writestr("K.npy", head.getvalue())
    assert "large.npz: cannot be read" not in refusal({**SMALL, "file": "large.npz"}, tmp_path)
    assert "holds fewer numbers of K than it declares" in refusal(
        {**SMALL, "file": "large.npz"}, tmp_path
    )
    with h5py.File(tmp_path / "large.mat", "w") as file:
        file.create_dataset("K", (10**6, 10**6), chunks=(100, 100), dtype="f8")
    assert "K declares more numbers than its file can hold" in refusal(
        {**SMALL, "file": "large.mat", "numbered_from": 0}, tmp_path
    )
    (tmp_path / "K.mtx").write_text(MARKET)
    files = {"files": [{"variable": "K", "file": "K.mtx"}]}
    assert "K.mtx: K holds fewer entries than it declares" in refusal({**SMALL, **files}, tmp_path)
    monkeypatch.setattr(reader, "machine_memory", lambda: 9e3)
    assert refusal(SMALL, tmp_path).startswith("joint.npz: K has 12 degrees of freedom: it needs")


@pytest.mark.parametrize("form", ["npz", "mat 5", "mat 7.3", "mtx"])
def test_damaged_files_are_one_line(form, tmp_path):
    """Cut at every tenth of their length, of other content, and with two bytes that are others."""
    variables = {name: np.asarray(value) for name, value in blocks().items()}
    changes = {"numbered_from": 0}
    if form == "npz":
        np.savez(tmp_path / "joint.npz", **variables)
    elif form == "mat 5":
        savemat(tmp_path / "joint.mat", variables, do_compression=True)
    elif form == "mat 7.3":
        write_hdf5(tmp_path / "joint.mat", {**variables, "K": sparse.csc_array(variables["K"])})
    else:
        mmwrite(tmp_path / "K.mtx", sparse.coo_array(variables["K"]))
        np.savez(tmp_path / "joint.npz", **variables)
        changes["files"] = [{"variable": "K", "file": "K.mtx"}]
    file = {"npz": "joint.npz", "mtx": "K.mtx"}.get(form, "joint.mat")
    path = tmp_path / file
    content = path.read_bytes()
    changes["file"] = "joint.npz" if form == "mtx" else file
    structure_of_matrices(Matrices.model_validate({**SMALL, **changes}), tmp_path)
    for tenth in range(10):
        path.write_bytes(content[: len(content) * tenth // 10])
        assert file in refusal({**SMALL, **changes}, tmp_path)
    path.write_bytes(b"\x00\xff" * 1000)
    assert file in refusal({**SMALL, **changes}, tmp_path)
    # numbers may be others; lengths and types must not end the process
    rng = np.random.default_rng(1)
    refused = 0
    for _ in range(100):
        damaged = np.frombuffer(content, np.uint8).copy()
        damaged[rng.integers(len(damaged), size=2)] = rng.integers(256, size=2)
        path.write_bytes(damaged.tobytes())
        try:
            structure_of_matrices(Matrices.model_validate({**SMALL, **changes}), tmp_path)
        except ValueError as error:
            assert str(error).startswith(("joint.", "K.mtx")) and "\n" not in str(error)
            refused += 1
    assert refused > 10


def test_kinds_of_matlab_that_are_no_matrices_are_told(tmp_path):
    savemat(tmp_path / "joint.mat", {"K": {"a": 1.0}, "M": "text", "area": blocks()["K"] * 1j})
    write_hdf5(tmp_path / "new.mat", blocks())
    for file, stiffness, sentence in (
        ("joint.mat", "K", "K is of class struct: it must be a matrix of real numbers"),
        ("joint.mat", "M", "M is of class char"),
        ("new.mat", "settings", "settings is a structure"),
    ):
        keys = {**SMALL, "file": file, "stiffness": stiffness, "numbered_from": 0}
        assert sentence in refusal(keys, tmp_path)
    with h5py.File(tmp_path / "new.mat", "a") as file:
        file["Z"] = np.zeros((2, 2), complex)
        file["T"] = np.zeros((2, 2), np.uint16)
        file["T"].attrs["MATLAB_class"] = np.bytes_("char")
        file["E"] = np.zeros(2, np.uint64)
        file["E"].attrs["MATLAB_empty"] = np.uint8(1)
    for name, sentence in (
        ("Z", "Z holds complex"),
        ("T", "T is of class char"),
        ("E", "is empty"),
    ):
        keys = {**SMALL, "file": "new.mat", "stiffness": name, "numbered_from": 0}
        assert sentence in refusal(keys, tmp_path)


def modal(modes=None, **contact):
    """Keys of modal data, with others in their place."""
    own = {"relative": "C", "normal_load": "n0", "preload_N": 8e3, **contact}
    own = {key: value for key, value in own.items() if value is not None}
    return {"modes": modes or {}, "bolts": [], "contact": own}


@pytest.mark.parametrize(
    ("path", "sentence", "changes"),
    [
        ("file", "must be a file .npz, .mat, .mtx, .unv or .uff", {"file": "joint.csv"}),
        ("file", "must be a file .npz, .mat, .mtx, .unv or .uff", {"file": "../joint.npz"}),
        ("file", "is missing", {"file": None}),
        ("stiffness", "has no file", {"file": None, "files": [{"variable": "M", "file": "M.mtx"}]}),
        ("contact", "with relative", with_contact(relative="C")),
        ("contact", "side_a and side_b, or relative", {"contact": {"side_a": "a"}}),
        ("contact", "without relative", with_contact(relative_by="direction")),
        ("contact", "parallel", with_contact(normal=[2, 0, 0])),
        ("contact", "must not be zero", with_contact(normal=[0, 0, 0])),
        ("contact", "with frame", with_contact(normal=[0, 0, 1], frame="Q")),
        ("contact", "number of each", with_contact(surfaces=[{"name": "a"}, {"name": "b"}])),
        ("contact", "two or more surfaces", with_contact(surface="s")),
        ("bolts", "and not both", {"bolts": [{"name": "one", "load": "F", "locked": 3}]}),
        ("bolts", "and not both", {"bolts": [{"name": "one"}]}),
        ("bolts", "is missing: bolts, or contact.normal_load", {"bolts": []}),
        ("bolts", "twice", {"bolts": 2 * [{"name": "one", "load": "F"}]}),
        ("bolts", "numbered_from: 1",
         {"bolts": [{"name": "one", "locked": 0}], "numbered_from": 1}),
        ("numbered_from", "1 if locked counts as in MATLAB, 0 if as in Python; K.mat does not tell",
         {"bolts": [{"name": "one", "locked": 3}], "files": [{"variable": "K", "file": "K.mat"}]}),
        ("numbered_from", "is missing: 1 if side_a counts", {"file": "joint.mat"}),
        ("inputs", "must be the only one of dof, row and node", {"inputs": [{"name": "shaker"}]}),
        ("mass", "must be a name", {"mass": "M 2"}),
        ("mass", "with modes, which stand in its place", {**modal(), "mass": "MM"}),
        ("bolts", "with modes, which have it held",
         {"modes": {}, "contact": {"relative": "C"}, "bolts": [{"name": "one", "locked": 3}]}),
        ("bolts", "with contact.normal_load, which they would make",
         {**modal(), "bolts": [{"name": "one", "load": "F"}]}),
        ("contact", "preload_N is missing: normal_load goes with it", modal(preload_N=None)),
        ("contact", "without modes.mode_shape",
         modal(relative=None, side_a="a", side_b="b")),
        ("contact", "must not be given with modes.node_position",
         modal({"file": "test.unv"}, relative=None, side_a="a", side_b="b", position="p")),
        ("modes", "must not be given with contact.relative", modal({"file": "test.unv"})),
        ("modes", "must not be given without node",
         modal({"mode_shape": "phi", "node_position": "p"})),
        ("modes", "must not be given without mode_shape", modal({"node": "n"})),
        ("modes", "must not have area, which is a variable of another key too",
         modal({"file": "joint.mat", "natural_frequency": "area"})),
        ("inputs", "must not be given without modes.node",
         {**modal(), "inputs": [{"name": "one", "node": 3, "direction": "z"}]}),
        ("inputs", "direction is missing: that of the motion of node",
         {**modal({"mode_shape": "phi", "node": "n"}), "inputs": [{"name": "one", "node": 3}]}),
        ("damping", "not a known key", {"damping": "C"}),
    ],
)  # fmt: skip
def test_wrong_keys_are_one_line_each(path, sentence, changes):
    content = {**SMALL, **changes}
    with pytest.raises(ValidationError) as refused:
        Matrices.model_validate(content)
    problems = list(explain(refused.value, Matrices, content))
    # that a variable has no file is said of each
    assert len(problems) == 1 or "has no file" in sentence
    key, line = problems[0][0], problems[0][1]
    assert key[0] == path and sentence in f"{key[-1]} {line}"
