"""A sweep over keys of all kinds: each design is what it is if everything is made for it."""

import shutil
from copy import deepcopy
from functools import cache

import numpy as np
import pytest
from small_study import ASSEMBLY, CASE, SETTINGS, mesh_of, run, write, write_config

from boltjoint import dataset
from boltjoint.config.case import Case
from boltjoint.config.numerical_options import ContactAdaptedBasis
from boltjoint.dynamics.reduction.basis_from_backbones import find_pod_modes
from boltjoint.dynamics.reduction.contact_condition import ContactCondition
from boltjoint.dynamics.response.frequency_response import solve_response
from boltjoint.dynamics.response.windows import Resonance, frequency_window
from boltjoint.friction.registry import LAWS
from boltjoint.joint.node_to_node import connect_pairs
from boltjoint.joint.partition import partition_regions
from boltjoint.joint.reductions import reduce_joint
from boltjoint.structure.excitation import place_excitation
from boltjoint.structure.modes import find_modes
from boltjoint.structure.preload import apply_preload

#: in a lap of 50 mm the bolt cells lie outside
VARY = {
    "assembly.bar.lap_mm": [50, 62, 66],
    "preload_ratios[1]": [1, 0.25],
    "excitation.points[0].x_mm": [100, 182],
    "joint.elements": [2, 3],
    "preload_N": {"kind": "normal", "mean": 10000, "standard_deviation": 1000},
    "contact.surfaces[0].friction_coefficient": {"kind": "linear", "lowest": 0.1, "highest": 0.3},
    "contact.tangential_stiffness_N_per_m": {"kind": "log", "lowest": 1e8, "highest": 1e9},
    "loss_factor": {"kind": "triangular", "lowest": 0.004, "likeliest": 0.005, "highest": 0.01},
    "forces_N": [5, 20],
}
EXCITATION = {
    "kind": "forces",
    "points": [{"x_mm": 182, "y_mm": 0, "z_mm": 10, "direction": "z"}],
}
#: the coefficient of all counts nowhere
FORCED = CASE | {
    "excitation": EXCITATION,
    "contact": CASE["contact"] | {"surfaces": [{"name": "lap", "friction_coefficient": 0.2}]},
}
SWEEP = {
    "case": "forced",
    "vary": VARY,
    "design": {"kind": "latin-hypercube", "number": 42, "seed": 3},
    "basis": "free-2",
    "joint": "regions=3/elements=2",
    "observe": ["peaks", "contact-states"],
    "designs_per_job": 40,
}


@pytest.fixture(scope="module")
def sweep(project, tmp_path_factory):
    folder = tmp_path_factory.mktemp("kinds") / "study"
    shutil.copytree(project, folder)
    write_config(folder, {"forced": FORCED})
    write(folder / "config/sweeps/kinds.yaml", SWEEP)
    write(folder / "config/config.yaml", SETTINGS | {"cases": ["forced"], "sweeps": ["kinds"]})
    said = run(folder, "results/sweeps/kinds/sweep.nc")
    assert "42 designs with 16 joints (2 meshes, 4 tightenings of bolts)" in said
    return dataset.load(folder / "results/sweeps/kinds/sweep.nc")


@cache
def assembled(lap):
    content = deepcopy(ASSEMBLY)
    content["bar"]["lap_mm"] = lap
    built = mesh_of(content)
    return built, find_modes(built, "free-2")


def alone(design):
    """The response of a design, from the mesh on."""
    built, modes = assembled(round(1e3 * float(design["bar_lap"]), 9))
    excitation = deepcopy(EXCITATION)
    excitation["points"][0]["x_mm"] = 1e3 * float(design["excitation_points_0_x"])
    case = Case.model_validate(CASE | {"excitation": excitation})
    tension = float(design["preload"]) * np.array([1.0, float(design["preload_ratio_1"])])
    preload = apply_preload(built, tension)
    coefficients = {
        "tangential_stiffness": float(design["tangential_stiffness"]),
        "friction_coefficient": float(design["surface_0_friction_coefficient"]),
    }
    placed = place_excitation(built, modes, case.excitation, ())
    nodes = connect_pairs(placed, preload, LAWS["constant"], **coefficients)
    regions = partition_regions(nodes, preload, 3)
    elements = int(design["joint_elements"])
    fitted, _ = reduce_joint(regions, "elements", count=elements, starts=2)
    window = frequency_window(nodes, regions, fitted)
    loss_factor = float(design["loss_factor"])
    levels = [float(design["force_level"])]
    return solve_response(fitted, levels, damping=loss_factor, resonance=Resonance(1, window))


def test_each_design_is_what_it_is_as_a_case_of_its_own(sweep):
    possible = np.flatnonzero(sweep["reason"] == "")
    assert possible.size == 28
    for row in possible:
        design = sweep.isel(design=row)
        response = alone(design)
        for name in ("peak_frequency", "peak_amplitude"):
            np.testing.assert_allclose(design[name], response[name][0], rtol=1e-9)
        states = response["contact_state"][0]
        np.testing.assert_array_equal(design["contact_state"][: states.size], states)


def test_a_loosened_bolt_has_a_basis_of_its_own(project, tmp_path):
    folder = tmp_path / "study"
    shutil.copytree(project, folder)
    loosened = {
        **{"case": "small", "basis": "enriched-8", "joint": "node-to-node"},
        **{"vary": {"preload_ratios[1]": [1, 0.3]}, "observe": ["peaks"]},
    }
    write(folder / "config/sweeps/loosened.yaml", loosened)
    write(folder / "config/config.yaml", SETTINGS | {"sweeps": ["loosened"]})
    run(folder, "results/sweeps/loosened/sweep.nc")
    found = dataset.load(folder / "results/sweeps/loosened/sweep.nc")

    built, case = mesh_of(ASSEMBLY), Case.model_validate(CASE)
    preload = apply_preload(built, case.preload_N * np.array([1.0, 0.3]))
    condition = ContactCondition.of(case.contact.model_dump(), case.structural_damping)
    options = ContactAdaptedBasis(**SETTINGS["contact_adapted_basis"])
    modes = find_modes(built, "enriched-8", find_pod_modes(built, preload, [condition], options))
    joint = condition.connect(preload, modes)
    response = solve_response(joint, case.levels, damping=condition.damping)
    loose = found.sel(preload_ratio_1=0.3)
    for name in ("peak_frequency", "peak_amplitude"):
        np.testing.assert_allclose(loose[name], response[name], rtol=1e-6)
    # in the basis of the tight joint they differ by more
    tight = apply_preload(built, case.preload_N)
    modes = find_modes(built, "enriched-8", find_pod_modes(built, tight, [condition], options))
    other = solve_response(
        condition.connect(preload, modes), case.levels, damping=condition.damping
    )
    assert abs(other["peak_amplitude"] / response["peak_amplitude"] - 1).max() > 1e-4


def test_impossible_designs_are_told(sweep):
    short = sweep.isel(design=np.flatnonzero(sweep["bar_lap"] == 0.05))
    assert short.sizes["design"] == 14
    assert not np.isfinite(short["peak_amplitude"]).any()
    (reason,) = set(short["reason"].to_numpy().tolist())
    assert reason.startswith(
        "assembly.bolts.positions_from_lap_start_mm[1]: 46.0 puts the bolt's cell outside the lap"
    )
