"""Structures as data: files, matrices, turned, free, with two interfaces, and what is refused."""

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from examples import block_with_two_interfaces, craig_bampton, freed
from scipy import sparse
from scipy.linalg import eigh
from scipy.optimize import root
from scipy.spatial.transform import Rotation

from boltjoint.dynamics.reduction.basis_from_backbones import find_pod_modes
from boltjoint.dynamics.reduction.contact_condition import ContactCondition
from boltjoint.dynamics.response.converged_peaks import converge_peaks, find_converged_peaks
from boltjoint.dynamics.response.frequency_response import solve_response
from boltjoint.joint.node_to_node import connect_nodes
from boltjoint.structure.contact_equilibrium import contact_force
from boltjoint.structure.contact_points import ContactPoints
from boltjoint.structure.geometry import Geometry
from boltjoint.structure.makers.registry import structure_of
from boltjoint.structure.model import Structure
from boltjoint.structure.modes import find_modes
from boltjoint.structure.preload import apply_preload
from boltjoint.structure.structure_file import load_structure, save_structure

LOAD = 8e3


@pytest.fixture(scope="module")
def free(assembly):
    return structure_of(freed(assembly))


@pytest.fixture(scope="module")
def loaded(structure):
    return apply_preload(structure, LOAD, tolerance=1e-12)


def joint_of(structure, preload, basis="free-4", normal_stiffness=1e8):
    return connect_nodes(find_modes(structure, basis), preload, 1e8, 0.1, normal_stiffness)


def peaks(joint, forces=(2.0, 20.0)):
    """Frequencies and amplitudes of responses in linear modes, the backbone, and all harmonics."""
    of_modes, of_backbone = (
        solve_response(joint, list(forces), method=coordinates, damping=2e-3)
        for coordinates in ("linear", "backbone")
    )
    converged = converge_peaks(joint, of_modes.isel(force=[0]))
    names = ("peak_frequency", "peak_amplitude")
    found = [each[name].to_numpy() for each in (of_modes, of_backbone) for name in names]
    return np.concatenate([*found, *(converged[f"{name}_converged"].to_numpy() for name in names)])


def as_matrices(structure, transform=None):
    """What another program would know of a structure, in its dofs or combinations of them."""
    T = sparse.eye_array(structure.dofs, format="csc") if transform is None else transform
    contact = structure.contact
    return Structure.from_matrices(
        T.T @ structure.stiffness @ T,
        T.T @ structure.mass @ T,
        replace(contact, relative=sparse.csr_array(contact.relative @ T)),
        bolts={
            bolt.name: int(np.argmax(T.T @ bolt.load)) if bolt.locked else T.T @ bolt.load
            for bolt in structure.bolts
        },
        inputs={name: T.T @ row.row for name, row in structure.inputs.items()},
        outputs={name: T.T @ row.row for name, row in structure.outputs.items()},
    )


def test_a_file_holds_the_structure_to_the_bit(structure, free, tmp_path):
    for each in (structure, free, as_matrices(structure)):
        save_structure(each, tmp_path / "structure.nc")
        found = load_structure(tmp_path / "structure.nc")
        for name in ("stiffness", "mass"):
            assert abs(getattr(found, name) - getattr(each, name)).max() == 0
        assert abs(found.contact.relative - each.contact.relative).max() == 0
        np.testing.assert_array_equal(found.rigid, each.rigid)
        np.testing.assert_array_equal(found.contact.surface, each.contact.surface)
        for bolt, other in zip(found.bolts, each.bolts, strict=True):
            np.testing.assert_array_equal(bolt.load, other.load)
            shank = ("section", "youngs_modulus", "yield_strength", "hole_clearance")
            for name in ("name", "locked", *shank):
                assert getattr(bolt, name) == getattr(other, name)
        assert (found.geometry is None) == (each.geometry is None)
        if each.geometry is not None:
            np.testing.assert_array_equal(found.geometry.material, each.geometry.material)
        assert (found.support is None) == (each.support is None)


def test_matrices_give_the_numbers_of_the_assembly(structure, loaded):
    matrices = as_matrices(structure)
    assert not matrices.rigid.size
    preload = apply_preload(matrices, LOAD, tolerance=1e-12)
    np.testing.assert_allclose(
        preload["normal_load"], loaded["normal_load"], atol=1e-8 * loaded["normal_load"].max()
    )
    # of those it does not know the family, the ones in the plane take part
    modes = find_modes(matrices, "free-4")
    expected = find_modes(structure, "all-12")
    in_plane = expected["symmetric_share"].to_numpy() > 0.5
    np.testing.assert_allclose(
        modes["natural_frequency"], expected["natural_frequency"][in_plane][:4], rtol=1e-9
    )
    bending = find_modes(structure, "free-2")["natural_frequency"]
    assert np.isin(np.round(bending, 5), np.round(modes["natural_frequency"], 5)).all()
    found = peaks(joint_of(matrices, preload, "free-2"))
    np.testing.assert_allclose(found, peaks(joint_of(structure, loaded, "free-2")), rtol=1e-6)


def test_the_example_of_the_docs_runs(structure, tmp_path, monkeypatch, capsys):
    page = Path(__file__).parents[2] / "docs" / "structures.md"
    example, *others = re.findall(
        r"```python\n(.*?)```", page.read_text(encoding="utf-8"), re.DOTALL
    )
    monkeypatch.chdir(tmp_path)
    for name, matrix in (("K", structure.stiffness), ("M", structure.mass)):
        sparse.save_npz(f"{name}.npz", matrix)
    # each row is the difference of two degrees of freedom
    sides = [
        structure.contact.relative.indices[structure.contact.relative.data == sign].reshape(-1, 3)
        for sign in (1, -1)
    ]
    np.savez(
        "contact.npz",
        a=sides[0],
        b=sides[1],
        position=structure.contact.position,
        area=structure.contact.area,
        dofs=[np.flatnonzero(structure.inputs["excitation"].row)[0], *structure.held],
    )
    exec(example, {})
    condition = ContactCondition.of(
        {"law": "constant", "tangential_stiffness_N_per_m": 1e8, "friction_coefficient": 0.1}, 2e-3
    )
    plain = as_matrices(structure)
    load = apply_preload(plain, LOAD)
    pod_modes = find_pod_modes(plain, load, [condition])
    joint = connect_nodes(find_modes(plain, "enriched-24", pod_modes), load, 1e8, 0.1)
    expected = find_converged_peaks(joint, [5.0], damping=2e-3)["peak_frequency_converged"].item()
    assert float(capsys.readouterr().out) == pytest.approx(expected, rel=1e-4)
    for other in others:
        exec(other, {})
    assert capsys.readouterr().out == "[1.] [0.] (3, 48)\n"


def test_a_reduced_model_that_keeps_the_contact_is_the_whole_in_statics(tiny):
    """Craig-Bampton with all dofs of contact, bolts and excitation, and modes of the rest."""
    whole = structure_of(tiny)
    loaded = apply_preload(whole, LOAD, tolerance=1e-12)
    reduced = as_matrices(whole, craig_bampton(whole, 30))
    assert reduced.dofs < whole.dofs
    preload = apply_preload(reduced, LOAD, tolerance=1e-12)
    np.testing.assert_allclose(
        preload["normal_load"], loaded["normal_load"], atol=1e-8 * loaded["normal_load"].max()
    )
    found = peaks(joint_of(reduced, preload, "free-2"))
    # modes of the rest hold the first ones to a millionth
    np.testing.assert_allclose(found, peaks(joint_of(whole, loaded, "free-2")), rtol=1e-4)


@pytest.mark.parametrize("of", ["structure", "free"])
def test_a_structure_turned_in_space_has_the_same_numbers(of, request):
    # families are those of a bar along x
    structure = replace(request.getfixturevalue(of), maker="")
    turn = Rotation.from_euler("xyz", [31, -17, 64], degrees=True).as_matrix()
    geometry = structure.geometry
    nodes = len(geometry.node)
    turned = replace(
        structure,
        symmetry=None,
        maker="",
        contact=replace(
            structure.contact,
            position=structure.contact.position @ turn.T,
            frame=structure.contact.frame @ turn.T,
        ),
        bolts=[
            replace(bolt, axis=turn @ bolt.axis, position=turn @ bolt.position)
            for bolt in structure.bolts
        ],
        geometry=Geometry(
            geometry.node @ turn.T,
            sparse.csc_array(sparse.block_diag([turn] * nodes) @ geometry.displacement),
            geometry.cell,
            geometry.part,
        ),
    )
    plain, other = (apply_preload(each, LOAD, tolerance=1e-12) for each in (structure, turned))
    largest = plain["normal_load"].max()
    np.testing.assert_allclose(
        other["normal_load"], plain["normal_load"], atol=1e-8 * largest, rtol=0
    )
    np.testing.assert_allclose(
        other["displacement"],
        plain["displacement"].to_numpy() @ turn.T,
        atol=1e-7 * abs(plain["displacement"]).max().item(),
    )
    found = peaks(joint_of(turned, other, "free-2"))
    np.testing.assert_allclose(found, peaks(joint_of(structure, plain, "free-2")), rtol=1e-7)


def test_a_free_assembly_has_six_rigid_modes_and_the_loads_of_the_held_one(free, loaded, tiny):
    assert free.rigid.shape[1] == 6
    modes = find_modes(free, "free-4")
    frequency = modes["natural_frequency"].to_numpy()
    assert not frequency[:6].any() and frequency[6] > 100
    # Rayleigh's quotient of what is taken as rigid
    energy = np.einsum("im,im->m", free.rigid, free.stiffness @ free.rigid)
    inertia = np.einsum("im,im->m", free.rigid, free.mass @ free.rigid)
    assert np.sqrt(abs(energy / inertia)).max() < 1e-3 * 2 * np.pi * frequency[6]
    preload = apply_preload(free, LOAD, tolerance=1e-12)
    # the support is far from the lap, so that it is not felt there
    np.testing.assert_allclose(
        preload["normal_load"], loaded["normal_load"], atol=1e-6 * loaded["normal_load"].max()
    )


def test_a_free_assembly_against_dense_matrices(tiny):
    """A mesh of few elements, whose eigenproblem and statics are solved without the library."""
    free = structure_of(freed(tiny))
    K, M = (getattr(free, name).toarray() for name in ("stiffness", "mass"))
    moving = free.moving
    squared = eigh(K[np.ix_(moving, moving)], M[np.ix_(moving, moving)], eigvals_only=True)
    expected = np.sqrt(squared[6:30]) / (2 * np.pi)
    found = find_modes(free, "all-10")["natural_frequency"].to_numpy()[6:]
    np.testing.assert_allclose(found, expected[:10], rtol=1e-8)

    preload = apply_preload(free, LOAD, tolerance=1e-12)
    C = free.contact.relative
    stiffness = free.contact.penalty * free.contact.area
    force = LOAD * sum(bolt.load for bolt in free.bolts)
    q = np.zeros(free.dofs)
    # Newton's method with a pseudo-inverse, which has no rigid-body motion
    for _ in range(30):
        contact, tangent = contact_force((C @ q).reshape(-1, 3), stiffness, 0.1)
        residual = force - K @ q - C.T @ contact.ravel()
        if abs(residual).max() < 1e-9 * LOAD:
            break
        if not q.any():
            tangent = stiffness[:, None, None] * np.eye(3)
        J = K + C.T @ sparse.block_diag(list(tangent)) @ C
        q = q + np.linalg.lstsq(J + 1e6 * free.rigid @ free.rigid.T, residual)[0]
    mu = tiny["friction_coefficient"].item()
    contact = contact_force((C @ q).reshape(-1, 3), stiffness, mu)[0]
    assert mu == 0.1
    np.testing.assert_allclose(preload["normal_load"], contact[:, 2], atol=1e-6 * contact.max())


def test_two_interfaces_of_different_laws_one_of_them_tilted():
    K, M, contact, bolt = block_with_two_interfaces()
    structure = Structure.from_matrices(
        *(K, M, contact), bolts={"one": bolt}, inputs={"shaker": 2}, outputs={"sensor": 2}
    )
    found = apply_preload(structure, 5e3, tolerance=1e-13)
    C, stiffness = contact.relative.toarray(), contact.penalty * contact.area

    def unbalanced(q):
        relative = (C @ q).reshape(-1, 3)
        # each point by Coulomb's law alone, written out again
        force = np.zeros((2, 3))
        for i, (u, k, mu) in enumerate(
            zip(relative, stiffness, contact.friction_coefficient, strict=True)
        ):
            n = k * max(u[2], 0.0)
            t = k * u[:2] if u[2] > 0 else np.zeros(2)
            size = np.linalg.norm(t)
            force[i] = *(t * min(1.0, mu * n / size if size else 1.0)), n
        return (K @ q + C.T @ force.ravel() - 5e3 * bolt) / 5e3, force

    solved = root(lambda q: unbalanced(q)[0], np.linalg.solve(K, 5e3 * bolt), tol=1e-13)
    force = unbalanced(solved.x)[1]
    largest = abs(force).max()
    np.testing.assert_allclose(found["normal_load"], force[:, 2], atol=1e-8 * largest)
    np.testing.assert_allclose(found["friction_force"], force[:, :2], atol=1e-8 * largest)
    # one sticks with shear left in it, the other slips
    shear = np.linalg.norm(force[:, :2], axis=1)
    limit = contact.friction_coefficient * force[:, 2]
    assert 0 < shear[0] < 0.99 * limit[0]
    assert shear[1] == pytest.approx(limit[1])
    modes = find_modes(structure, "free-9")
    np.testing.assert_allclose(
        (2 * np.pi * modes["natural_frequency"]) ** 2,
        eigh(K, M, eigvals_only=True)[:9],
        rtol=1e-9,
    )


def refusals():
    K, M, contact, bolt = block_with_two_interfaces()
    skew, holed = K.copy(), K.copy()
    skew[0, 1] *= 1.01
    holed[0, 0] = np.nan
    apart = np.zeros_like(K)
    options = {"bolts": {"one": bolt}}
    yield (
        "stiffness is not symmetric: entries at",
        lambda: Structure.from_matrices(skew, M, contact),
    )
    yield "stiffness must be finite", lambda: Structure.from_matrices(holed, M, contact)
    yield "not positive", lambda: Structure.from_matrices(K, -M, contact)
    yield "mass has shape", lambda: Structure.from_matrices(K, M[:5, :5], contact)
    yield "stiffness is zero", lambda: Structure.from_matrices(apart, M, contact)
    yield (
        "12 degrees of freedom",
        lambda: Structure.from_matrices(K, M, replace(contact, relative=contact.relative[:, :5])),
    )
    yield "area of the contact points", lambda: replace(contact, area=[0.0, 1e-4])
    yield "not orthonormal", lambda: replace(contact, frame=np.ones((2, 3, 3)))
    yield (
        "6 rows",
        lambda: ContactPoints(
            contact.relative, [[0, 0, 0]], [np.eye(3)], [1e-4], "one", [0], [1e12], [0.1]
        ),
    )
    yield (
        "shaker is degree of freedom 12",
        lambda: Structure.from_matrices(K, M, contact, inputs={"shaker": 12}),
    )
    yield (
        "load of one is zero",
        lambda: Structure.from_matrices(K, M, contact, bolts={"one": 0 * bolt}),
    )
    floating = np.kron(np.array([[1, -1], [-1, 1]]), 1e7 * np.eye(6))
    yield "not in equilibrium", lambda: Structure.from_matrices(floating, M, contact, **options)
    # one side is held, the other lies on it
    laid = np.kron(np.diag([1, 0]), 1e7 * np.eye(6))
    yield "connected by the contact alone", lambda: Structure.from_matrices(laid, M, contact)
    loose = np.diag([1e7] * 5 + [0.0] * 7)
    yield "7 rigid-body motions", lambda: Structure.from_matrices(loose, M, contact)
    yield "no bolts", lambda: apply_preload(Structure.from_matrices(K, M, contact), 1e3)


@pytest.mark.parametrize(("sentence", "call"), list(refusals()))
def test_what_is_no_structure_is_refused(sentence, call):
    with pytest.raises(ValueError, match=sentence):
        call()
