"""How the cost grows: with elements, vectors of the basis, forces and designs."""

from dataclasses import replace
from functools import cache, partial

import numpy as np
import pytest
from least_work import LOSS_FACTOR
from numpy_aft import with_numpy_aft
from study_joints import RESULTS, joint_of

from boltjoint import dataset
from boltjoint.dynamics.backbone.backbone import trace_for_forces
from boltjoint.dynamics.balance.compiled_balance import (
    balance_arrays,
    evaluate_balance,
    form_jacobian_of_balance,
)
from boltjoint.dynamics.balance.harmonic_balance import HarmonicBalance
from boltjoint.dynamics.response.frequency_response import solve_branch
from boltjoint.dynamics.response.synthesis import synthesise_branch
from boltjoint.dynamics.response.windows import Resonance, frequency_window
from boltjoint.joint.model import Joint
from boltjoint.joint.node_to_node import connect_nodes
from boltjoint.structure.modes import find_modes

CONSTANT, VARIABLE = "three_bolt_constant", "three_bolt_variable"

#: force of the motion in which elements are evaluated: about half of them slip at its peak
FORCE = 10.0


@cache
def peak(case: str) -> tuple[np.ndarray, float]:
    """Modal coordinates and circular frequency at a peak."""
    branch = solve_branch(joint_of(case, "free-4", "node-to-node"), FORCE, damping=LOSS_FACTOR)
    return branch.modal_coordinate[branch.peak], 2 * np.pi * branch.frequency[branch.peak]


def finer(joint: Joint, elements: int) -> Joint:
    """The joint with as many elements: pairs drawn at random, no two alike, as stiff in sum."""
    random = np.random.default_rng(elements)
    pair = np.sort(random.integers(0, joint.points, elements))
    share = joint.points / elements
    size = random.uniform(0.5, 1.5, elements)
    law = joint.law
    quantities = {
        name: getattr(law, name)[pair] * (1.0 if unit == "1" else share * size)
        for name, (unit, _) in law.quantities.items()
    }
    position = joint.position[pair]
    return replace(
        joint,
        law=type(law)(np.arange(elements), **quantities),
        tangential_mode=joint.tangential_mode[pair],
        normal_mode=None if joint.normal_mode is None else joint.normal_mode[pair],
        position=position,
        element_position=position,
        places=joint.places and joint.places.at(pair),
    )


@pytest.mark.parametrize("elements", [100, 1000, 10_000, 100_000, 1_000_000])
@pytest.mark.parametrize("case", [CONSTANT, VARIABLE])
def test_elements(measure, case, elements):
    x, w = peak(case)
    joint = finer(joint_of(case, "free-4", "node-to-node"), elements)
    balance = HarmonicBalance(joint, LOSS_FACTOR, FORCE)
    arrays = balance_arrays(balance)
    residual, jacobian = np.empty(x.size), np.empty((x.size, x.size))

    def evaluate():
        evaluate_balance(arrays, x, w, residual)
        form_jacobian_of_balance(arrays, x, w, jacobian)

    model = arrays.rows, arrays.elements.indices, arrays.elements.quantities, arrays.stuck_tangent
    work = sum(each.nbytes for each in arrays if isinstance(each, np.ndarray))
    work -= sum(each.nbytes for each in model if any(each is array for array in arrays))
    measure(
        evaluate,
        rounds=7,
        kind="growth",
        by="elements",
        what=f"residual and tangent, {joint.law.name} load",
        number=elements,
        bytes_per_element=work / elements,
    )


@pytest.mark.parametrize("elements", [100, 1000, 10_000, 100_000])
def test_elements_by_aft(measure, elements):
    x, w = peak(CONSTANT)
    joint = with_numpy_aft(finer(joint_of(CONSTANT, "free-4", "node-to-node"), elements))
    balance = HarmonicBalance(joint, LOSS_FACTOR, FORCE)

    def evaluate():
        balance.residual_and_jacobian(x, w)[1]()

    measure(
        evaluate,
        rounds=3,
        kind="growth",
        by="elements",
        what="residual and tangent, AFT in NumPy",
        number=elements,
    )


@cache
def joint_in(basis: str, law: str) -> Joint:
    assembly = dataset.load(RESULTS / "assemblies/three_bolt/assembly.nc")
    pod_modes = dataset.load(RESULTS / "assemblies/three_bolt/pod_modes.nc")
    preload = dataset.load(RESULTS / "assemblies/three_bolt/preload=10000/preload.nc")
    normal = 1e8 if law == "variable" else None
    return connect_nodes(find_modes(assembly, basis, pod_modes), preload, 1e8, 0.1, normal)


@pytest.mark.parametrize("vectors", [4, 8, 16, 40, 80])
@pytest.mark.parametrize("law", ["constant", "variable"])
def test_vectors(measure, law, vectors):
    joint = joint_in(f"enriched-{vectors}", law)
    measure(
        partial(solve_branch, joint, FORCE, damping=LOSS_FACTOR),
        rounds=3,
        kind="growth",
        by="vectors",
        what=f"response, {law} load",
        number=vectors,
    )


@pytest.mark.parametrize("count", [1, 2, 4, 8, 16, 32])
@pytest.mark.parametrize("solver", ["linear modes", "backbone"])
def test_forces(measure, solver, count):
    joint = joint_of(CONSTANT, "free-4", "node-to-node")
    forces, window = np.geomspace(1.0, 50.0, count), frequency_window(joint)
    around = Resonance(1, window)

    def solve():
        if solver == "backbone":
            backbone = trace_for_forces(joint, forces, damping=LOSS_FACTOR, window=window)
            for force in forces:
                synthesise_branch(backbone, force, window)
        else:
            for force in forces:
                solve_branch(joint, force, damping=LOSS_FACTOR, resonance=around)

    measure(solve, rounds=3, kind="growth", by="forces", what=solver, number=count)
