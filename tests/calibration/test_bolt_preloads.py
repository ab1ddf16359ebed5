"""The preload of each bolt from backbones: of the two bolts of a coarse half lap."""

from functools import cache

import numpy as np
import pytest
from scipy.spatial import cKDTree
from small_study import ASSEMBLY, mesh_of

from boltjoint import (
    MeasuredBackbone,
    Parameter,
    apply_preload,
    backbone_at,
    connect_nodes,
    find_modes,
    fit,
)
from boltjoint.calibration.bolt_preloads import BoltPreloads, fit_preloads, loosest_bolt
from boltjoint.damping import as_damping
from boltjoint.structure.makers.registry import structure_of

PRELOAD, DAMPING = 10e3, as_damping(0.002)
#: microslip to macroslip of two modes at the output point [m]
AMPLITUDES = {1: np.geomspace(1e-6, 1e-4, 8), 2: np.geomspace(2e-7, 2e-5, 8)}


@cache
def structure():
    return structure_of(mesh_of(ASSEMBLY))


@cache
def modes():
    return find_modes(structure(), "free-6")


def connect(preload):
    return connect_nodes(modes(), preload, 2e13 * preload["area"].to_numpy(), 0.3)


@cache
def model():
    return BoltPreloads(structure(), PRELOAD, connect, DAMPING)


def backbones(ratios, noise=0.0, seed=0):
    """Those of a joint whose contact is solved with these preloads."""
    joint = connect(apply_preload(structure(), PRELOAD * np.array(ratios)))
    random, curves = np.random.default_rng(seed), []
    for resonance, amplitudes in AMPLITUDES.items():
        exact = np.column_stack(
            backbone_at(joint, amplitudes, damping=DAMPING, resonance=resonance)
        )
        deviation = np.array([1e-3, 1e-2]) * exact
        values = exact + noise * deviation * random.standard_normal(exact.shape)
        (f, z), (of_f, of_z) = values.T, deviation.T
        name = f"mode {resonance}"
        curves.append(
            MeasuredBackbone(amplitudes, f, of_f, z, of_z, resonance=resonance, name=name)
        )
    return curves


def test_loads_are_those_of_one_loose_bolt():
    loads = apply_preload(structure(), [PRELOAD, 0.25 * PRELOAD])["normal_load"].to_numpy()
    joint, _ = model()({"preload_ratios[1]": 0.25})
    solved = joint.law.slip_force / 0.3
    # pairs that another preload closes have an element without load
    at = cKDTree(modes()["position"]).query(joint.position)[1]
    np.testing.assert_allclose(solved, loads[at], atol=1e-6 * loads.max())
    assert solved.sum() == pytest.approx(float(loads.sum()), rel=1e-8)


@pytest.mark.parametrize("ratios", [(0.95, 0.3), (0.4, 1.05)])
def test_both_preloads_are_found_without_noise(ratios):
    found = fit_preloads(model(), backbones(ratios))
    # repeated until it changes by a fifth of the standard error, which a stated scatter has
    assert np.all(abs(found.scaled - ratios) < 0.5 * found.standard_error)
    assert np.all(found.standard_error < 0.03)
    assert found.p_value > 0.99
    probability = loosest_bolt(found)
    assert max(probability, key=probability.get) == f"preload_ratios[{int(np.argmin(ratios))}]"
    assert sum(probability.values()) == pytest.approx(1.0)


def test_under_noise_the_preloads_are_within_their_intervals_and_the_loose_one_is_told():
    ratios = (0.97, 0.55)
    found = fit_preloads(model(), backbones(ratios, noise=1.0, seed=3))
    off = (found.scaled - np.array(ratios)) / found.standard_error
    assert np.all(abs(off) < 3)
    assert loosest_bolt(found)["preload_ratios[1]"] > 0.99
    # nothing told apart: as likely as not
    alike = fit_preloads(model(), backbones((1.0, 1.0), noise=1.0, seed=4))
    assert max(loosest_bolt(alike).values()) < 0.999


def test_what_is_no_bolt_is_refused():
    with pytest.raises(ValueError, match=r"parameter 'preload_ratios\[2\]' is not known"):
        model()({"preload_ratios[2]": 0.5})
    joint, measured = connect(apply_preload(structure(), PRELOAD)), backbones((1.0, 1.0))
    of_joint = fit(joint, measured, [Parameter("slip_force", 1e2, 1e5)], damping=DAMPING)
    with pytest.raises(ValueError, match="no preload_ratios are among the parameters slip_force"):
        loosest_bolt(of_joint)
    with pytest.raises(ValueError, match="levels are"):
        BoltPreloads(structure(), PRELOAD, connect, DAMPING, levels=(-0.1, 1.0))
    with pytest.raises(ValueError, match="around"):
        BoltPreloads(structure(), PRELOAD, connect, DAMPING, around=(1.0,))
