"""The preload of each bolt from backbones: of the two bolts of a coarse half lap."""

from dataclasses import replace
from functools import cache
from types import SimpleNamespace

import numpy as np
import pytest
from calibrated_joint import backbones_of
from scipy.spatial import cKDTree
from small_study import ASSEMBLY, mesh_of

from boltjoint import (
    Parameter,
    apply_preload,
    connect_nodes,
    find_modes,
    fit,
)
from boltjoint.calibration import fit_preloads as fit_preloads_module
from boltjoint.calibration.bolt_preloads import BoltPreloads
from boltjoint.calibration.fit import CalibrationOptions
from boltjoint.calibration.fit_preloads import fit_preloads, loosest_bolt
from boltjoint.calibration.level_path import NotReached
from boltjoint.calibration.parameters import Prior
from boltjoint.damping import as_damping
from boltjoint.structure.makers.registry import structure_of

#: a model around a loose bolt
LOOSE = SimpleNamespace(state=np.array([0.1, 1.0]))
PRELOAD, DAMPING, LEVELS = 10e3, as_damping(0.002), (0.1, 0.25, 0.5, 1.0, 1.25)
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
    return BoltPreloads(structure(), PRELOAD, connect, DAMPING, LEVELS)


def backbones(ratios, noise=0.0, seed=0):
    """Those of a joint whose contact is solved with these preloads."""
    joint = connect(apply_preload(structure(), PRELOAD * np.array(ratios)))
    return backbones_of(joint, DAMPING, AMPLITUDES, noise, seed)


def test_loads_are_those_of_one_loose_bolt():
    loads = apply_preload(structure(), [PRELOAD, 0.25 * PRELOAD])["normal_load"].to_numpy()
    joint, damping = model()({"preload_ratios[1]": 0.25})
    assert damping == DAMPING
    solved = joint.law.slip_force / 0.3
    # pairs that another preload closes have an element without load
    at = cKDTree(modes()["position"]).query(joint.position)[1]
    np.testing.assert_allclose(solved, loads[at], atol=1e-6 * loads.max())
    assert solved.sum() == pytest.approx(float(loads.sum()), rel=1e-8)
    # between the levels it is interpolated
    between = apply_preload(structure(), [PRELOAD, 0.17 * PRELOAD])["normal_load"].to_numpy()
    joint, _ = model()({"preload_ratios[1]": 0.17})
    # worst for a pair that only then begins to carry load
    np.testing.assert_allclose(joint.law.slip_force / 0.3, between[at], atol=0.02 * loads.max())
    assert joint.law.slip_force.sum() / 0.3 == pytest.approx(float(between.sum()), rel=5e-3)


def test_both_preloads_are_found_without_noise():
    ratios = 0.4, 1.05
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
    found = fit_preloads(model(), backbones(ratios, noise=0.01, seed=3))
    off = (found.scaled - np.array(ratios)) / found.standard_error
    assert np.all(abs(off) < 3)
    assert loosest_bolt(found)["preload_ratios[1]"] > 0.99
    low, high = found.profile("preload_ratios[1]")
    assert low < 0.55 < high


def test_what_does_not_tell_two_bolts_apart_gives_both_the_same_probability():
    found = fit_preloads(model(), backbones((1.0, 1.0)), repetitions=0)
    # as if nothing had been measured
    root = np.diag([1e3, 1e3])
    found.__dict__["covariance_root"] = root
    assert list(loosest_bolt(found).values()) == pytest.approx([0.5, 0.5], abs=0.03)


def test_scales_do_not_matter_and_priors_are_no_measurement():
    linear = fit_preloads(model(), backbones((1.0, 0.9), noise=0.01), repetitions=0)
    first, second = model().parameters()
    mixed = [first, replace(second, logarithmic=True)]
    logarithmic = fit_preloads(model(), backbones((1.0, 0.9), noise=0.01), mixed, repetitions=0)
    assert logarithmic.best_values == pytest.approx(linear.best_values, rel=1e-4)
    told = loosest_bolt(logarithmic)
    assert told == pytest.approx(loosest_bolt(linear), abs=0.03)
    # nothing slips, so that only priors know of preloads
    known = [replace(p, prior=Prior(1.0, 0.2)) for p in (first, second)]
    tiny = {number: 1e-4 * levels for number, levels in AMPLITUDES.items()}
    joint = connect(apply_preload(structure(), PRELOAD))
    stuck = backbones_of(joint, DAMPING, tiny)
    found = fit(model(), stuck, known, options=CalibrationOptions(starts=1))
    with pytest.raises(ValueError, match="does not depend on any preload"):
        loosest_bolt(found)


def test_a_state_that_cannot_be_solved_leaves_the_others(monkeypatch):
    settled = fit_preloads_module._settled

    def refuses_loose_states(begun, *others):
        if begun.state.min() < 0.9:
            raise NotReached("no motion was found")
        return settled(begun, *others)

    monkeypatch.setattr(fit_preloads_module, "_settled", refuses_loose_states)
    found = fit_preloads(model(), backbones((0.97, 0.95)), repetitions=0)
    assert found.best_values["preload_ratios[0]"] == pytest.approx(0.97, abs=0.05)
    monkeypatch.setattr(fit_preloads_module, "_settled", lambda *_: refuses_loose_states(LOOSE))
    with pytest.raises(NotReached):
        fit_preloads(model(), backbones((0.97, 0.95)), repetitions=0)


def test_a_bolt_that_is_held_stays_where_the_model_has_it():
    held = BoltPreloads(structure(), PRELOAD, connect, DAMPING, LEVELS, around=(0.6, 1.0))
    second = held.parameters()[1:]
    found = fit(held, backbones((0.6, 0.8)), second, options=CalibrationOptions(starts=1))
    assert found.best_values["preload_ratios[1]"] == pytest.approx(0.8, abs=0.02)
    assert found.compared.model({})[0].law.slip_force.sum() / 0.3 == pytest.approx(
        float(apply_preload(structure(), [0.6 * PRELOAD, PRELOAD])["normal_load"].sum())
    )


def test_where_the_model_cannot_be_right_no_bolt_is_named():
    curves = [replace(curve, frequency=1.05 * curve.frequency) for curve in backbones((1.0, 0.5))]
    found = fit_preloads(model(), curves, starts=1, repetitions=0)
    with pytest.raises(ValueError, match="the model cannot be right: mode 1: the frequency is off"):
        loosest_bolt(found)


def test_what_is_no_bolt_is_refused():
    with pytest.raises(ValueError, match=r"parameter 'preload_ratios\[2\]' is not known"):
        model()({"preload_ratios[2]": 0.5})
    joint, measured = connect(apply_preload(structure(), PRELOAD)), backbones((1.0, 1.0))
    of_joint = fit(joint, measured, [Parameter("slip_force", 1e2, 1e5)], damping=DAMPING)
    with pytest.raises(ValueError, match="no preload_ratios are among the parameters slip_force"):
        loosest_bolt(of_joint)
    with pytest.raises(ValueError, match="levels are"):
        BoltPreloads(structure(), PRELOAD, connect, DAMPING, levels=(0.0, 1.0))
    with pytest.raises(ValueError, match="around"):
        BoltPreloads(structure(), PRELOAD, connect, DAMPING, around=(1.0,))
