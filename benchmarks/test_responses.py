"""Frequency responses, by joint, force and solver, beside the least work that they need."""

import pytest
from least_work import LOSS_FACTOR, LeastWork
from numpy_aft import with_numpy_aft
from study_joints import joint_of

from boltjoint.dynamics.backbone.backbone import find_backbone
from boltjoint.dynamics.balance import balance_equations
from boltjoint.dynamics.response.frequency_response import solve_branch
from boltjoint.dynamics.response.windows import Resonance, frequency_window

CONSTANT, VARIABLE = "three_bolt_constant", "three_bolt_variable"
FORCES = (1.0, 10.0, 50.0)

#: with the solvers that are compared in each
JOINTS = [
    (CONSTANT, "free-4", "node-to-node", ("least work", "compiled", "general")),
    (CONSTANT, "free-4", "regions=6", ("compiled",)),
    (CONSTANT, "free-4", "regions=6/elements=7", ("least work", "compiled", "general", "aft")),
    (CONSTANT, "free-4", "regions=6/table", ("compiled",)),
    (CONSTANT, "free-4", "regions=6/iwan", ("compiled",)),
    (CONSTANT, "enriched-40", "node-to-node", ("compiled", "complex-rdnm-1", "backbone")),
    (CONSTANT, "enriched-40", "hyper=auto", ("compiled", "backbone")),
    (VARIABLE, "free-4", "node-to-node", ("least work", "compiled", "general")),
    (VARIABLE, "free-4", "regions=12/elements=4", ("least work", "compiled", "general")),
    (VARIABLE, "enriched-40", "node-to-node", ("compiled", "backbone")),
    (VARIABLE, "enriched-40", "hyper=auto", ("compiled", "backbone")),
]
#: solvers that take seconds
SLOW = ("aft", "complex-rdnm-1")


@pytest.mark.parametrize("force", FORCES)
@pytest.mark.parametrize(
    ("case", "basis", "name", "solver"),
    [(*joint, solver) for *joint, solvers in JOINTS for solver in solvers],
)
def test_response(measure, monkeypatch, case, basis, name, solver, force):
    joint = joint_of(case, basis, name)
    window = frequency_window(joint)
    options = {"damping": LOSS_FACTOR, "resonance": Resonance(1, window)}
    if solver == "least work":
        solve = LeastWork(joint, force, window).solve
    else:
        if solver == "general":
            monkeypatch.setattr(balance_equations, "balance_system", lambda balance: None)
        if solver == "aft":
            joint = with_numpy_aft(joint)
        if solver in ("complex-rdnm-1", "backbone"):
            options["method"] = solver

        def solve():
            branch = solve_branch(joint, force, **options)
            assert branch.complete

    measure(
        solve,
        rounds=3 if solver in SLOW else 9,
        kind="response",
        case=case,
        basis=basis,
        joint=name,
        solver=solver,
        force_N=force,
        elements=joint.law.point_of_element.size,
    )


@pytest.mark.parametrize("name", ["node-to-node", "hyper=auto"])
@pytest.mark.parametrize("case", [CONSTANT, VARIABLE])
def test_backbone(measure, case, name):
    joint = joint_of(case, "enriched-40", name)
    window = frequency_window(joint)
    measure(
        lambda: find_backbone(joint, FORCES, damping=LOSS_FACTOR, window=window),
        rounds=5,
        kind="backbone",
        case=case,
        basis="enriched-40",
        joint=name,
        elements=joint.law.point_of_element.size,
    )
