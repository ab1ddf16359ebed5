"""Sweeps: each design is what it is as a case of its own; impossible ones are named."""

from dataclasses import replace

import numpy as np
import pytest
import xarray as xr
from small_joint import connect_small, make_joint

from boltjoint import backbone_at
from boltjoint.config.case import Case
from boltjoint.config.distributions import Linear, Lognormal, Normal, Triangular
from boltjoint.config.sampling import Grid, Saltelli, Samples, Table
from boltjoint.config.varied_case import with_values
from boltjoint.config.varied_keys import Quantity
from boltjoint.dynamics.backbone.backbone import find_backbone
from boltjoint.dynamics.response.converged_peaks import converge_peaks
from boltjoint.dynamics.response.error_bars import ConvergedPeak, add_converged_peaks
from boltjoint.dynamics.response.frequency_response import solve_branch, solve_response
from boltjoint.dynamics.response.harmonic_convergence import HarmonicConvergence
from boltjoint.dynamics.response.limits_at_peaks import KnownLimits, add_limits
from boltjoint.dynamics.response.methods import LinearModes
from boltjoint.dynamics.response.windows import Resonance, frequency_window
from boltjoint.friction.aft import AlternatingFrequencyTime
from boltjoint.friction.registry import LAWS
from boltjoint.joint.derived import rescale_contact
from boltjoint.joint.io import ImpossibleJoint, model_errors
from boltjoint.joint.partition import partition_regions
from boltjoint.joint.reduced import fit_reduced_joint
from boltjoint.solvers.step_control import StepControl
from boltjoint.structure.model_limits import DISPLACEMENT, LIMITS, STRESS
from boltjoint.study import solved_designs
from boltjoint.study.designs import SweptJoint, list_designs, values_of
from boltjoint.study.errors_of_sweep import error_of_sweep
from boltjoint.study.solved_designs import (
    check_designs,
    gather_sweep,
    solve_designs,
)
from boltjoint.study.tables.sobol_indices import tabulate_sensitivity
from boltjoint.study.tables.sweeps import tabulate_statistics
from boltjoint.study.weights_of_sweep import weigh_pairs_of_designs

GRID = Grid(kind="grid")
_TO_PEAK = LinearModes.to_peak
#: of the peaks with all harmonics
CONVERGED = (
    "peak_frequency_converged",
    "peak_amplitude_converged",
    "peak_harmonics",
    "peak_frequency_truncation_error",
    "peak_amplitude_truncation_error",
    "peak_frequency_inertia_error",
    "peak_amplitude_inertia_error",
)
KEYS = {
    "constant": {"tangential_stiffness_N_per_m": 5e6, "friction_coefficient": 0.1},
    "variable": {
        "tangential_stiffness_N_per_m": 5e6,
        "friction_coefficient": 0.1,
        "normal_stiffness_N_per_m": 1e7,
    },
}
VARY = {
    "constant": {
        "preload_N": Normal(kind="normal", mean=1000.0, standard_deviation=200.0),
        "contact.tangential_stiffness_N_per_m": Linear(kind="linear", lowest=2e6, highest=1e7),
        "contact.friction_coefficient": Lognormal(
            kind="lognormal", mean=0.1, coefficient_of_variation=0.5
        ),
        "forces_N": (2.0, 40.0),
        "loss_factor": Triangular(kind="triangular", lowest=0.002, likeliest=0.003, highest=0.01),
    },
    "variable": {
        "preload_N": Linear(kind="linear", lowest=500.0, highest=1500.0),
        "contact.normal_stiffness_N_per_m": Linear(kind="linear", lowest=5e6, highest=2e7),
    },
}


def base(law, **changed):
    case = {
        "assembly": "bar",
        "preload_N": 1000.0,
        "contact": {"law": law, **KEYS[law]},
        "loss_factor": 0.003,
        "forces_N": (5.0, 30.0),
        "modes": ("free-3",),
        "coordinates": ("linear",),
        "solve": ({"resonance": 1, "joints": ("regions=3/elements=4",)},),
    }
    return Case.model_validate(case | changed).model_dump()


def joints(case):
    """Node-to-node joint, regions and fitted elements of a case."""
    keys = dict(case.contact.options)
    nodes, preload = connect_small(keys.pop("law"), keys, case.preload_N / 1000.0)
    regions = partition_regions(nodes, preload, 3)
    # as many starts find the same elements of all designs
    return [nodes, regions, fit_reduced_joint(regions, 4, starts=2)[0]]


@pytest.mark.parametrize("law", ["constant", "variable"])
def test_a_design_is_what_it_is_as_a_case_of_its_own(law):
    content = base(law)
    designs = list_designs(VARY[law], Samples(kind="latin-hypercube", number=6, seed=3), content)
    problem = SweptJoint(content, joints(Case.model_validate(content)))
    found = solve_designs([problem], designs, range(6), states=True)
    assert found["complete"].all()
    for row, values in enumerate(values_of(designs)):
        case = Case.model_validate(with_values(content, values))
        made = joints(case)
        alone = solve_response(
            made[-1],
            case.levels,
            damping=case.structural_damping,
            resonance=Resonance(1, frequency_window(*made)),
        )
        for name in ("peak_frequency", "peak_amplitude"):
            np.testing.assert_allclose(found[name][row], alone[name], rtol=1e-9)
        np.testing.assert_array_equal(found["contact_state"][row], alone["contact_state"])


def test_a_stiffness_per_area_varies_too():
    contact = {"law": "constant", "friction_coefficient": 0.1}
    content = base("constant", contact={**contact, "tangential_stiffness_N_per_m3": 5e12})
    problem = SweptJoint(content, joints(Case.model_validate(content)))
    vary = {"contact.tangential_stiffness_N_per_m3": (2e12, 1e14)}
    designs = list_designs(vary, Grid(kind="grid"), content)
    assert designs["tangential_stiffness_per_area"].attrs["units"] == "N/m3"
    found = solve_designs([problem], designs, range(2), frequencies=40)
    windows = []
    for row, values in enumerate(values_of(designs)):
        case = Case.model_validate(with_values(content, values))
        made = joints(case)
        windows.append(frequency_window(*made))
        alone = solve_response(
            made[-1],
            case.levels,
            damping=case.structural_damping,
            resonance=Resonance(1, windows[-1]),
        )
        for name in ("peak_frequency", "peak_amplitude"):
            np.testing.assert_allclose(found[name][row], alone[name], rtol=1e-9)
    # the grid of responses holds the resonance of the stiffest design
    np.testing.assert_allclose(found["frequency"][[0, -1]], windows[-1], rtol=1e-9)


@pytest.mark.parametrize("stiffness", [3e12, 1e13, 4e13])
def test_each_response_has_the_whole_grid(stiffness):
    contact = {"law": "constant", "friction_coefficient": 0.1}
    content = base("constant", contact={**contact, "tangential_stiffness_N_per_m3": 5e12})
    problem = SweptJoint(content, joints(Case.model_validate(content)))
    designs = list_designs(
        {"contact.tangential_stiffness_N_per_m3": (2e12, stiffness)}, GRID, content
    )
    found = solve_designs([problem], designs, range(2), frequencies=40)
    assert np.isfinite(found["response_amplitude"]).all()


@pytest.mark.parametrize("law", ["constant", "variable"])
def test_responses_that_end_behind_their_peaks_have_those_of_whole_ones(law, monkeypatch):
    content = base(law)
    problem = SweptJoint(content, joints(Case.model_validate(content)))
    values = {"preload_N": 1200.0}
    _, ended = problem.solve(values)
    monkeypatch.setattr(LinearModes, "to_peak", lambda self, task, force: None)
    _, whole = problem.solve(values)
    for short, long in zip(ended, whole, strict=True):
        assert short.complete and long.complete
        # a little behind the peak
        assert 0.9 > short.amplitude[-1] / short.peak_amplitude > 0.5
        assert short.frequency.size < 0.6 * long.frequency.size
        np.testing.assert_allclose(short.peak_frequency, long.peak_frequency, rtol=1e-9)
        np.testing.assert_allclose(short.peak_amplitude, long.peak_amplitude, rtol=1e-9)


def test_a_response_that_may_hold_another_resonance_is_followed_to_its_end():
    content = base("constant", forces_N=(30.0,))
    known = joints(Case.model_validate(content))
    # the second mode is as high without contact as the first in stick, and higher at the output
    near, scale = np.array([70.0, 90.0, 950.0]), np.array([0.3, 1.0, 1.0])
    close = [
        replace(joint, natural_frequency=near, excitation_mode=joint.excitation_mode * scale)
        for joint in known
    ]
    problem = SweptJoint(content, close)
    joint, (found,) = problem.solve({"preload_N": 1000.0})
    whole = solve_branch(
        joint,
        30.0,
        damping=problem.base.structural_damping,
        resonance=Resonance(1, problem.window({})),
    )
    highest = {branch.located.sum() for branch in (found, whole)}
    assert highest == {2}
    np.testing.assert_allclose(found.peak_amplitude, whole.peak_amplitude, rtol=1e-9)


def test_a_level_without_a_regular_course_leaves_the_others_as_they_are(problem, monkeypatch):
    def to_peak(self, task, force):
        return None if force == 30.0 else _TO_PEAK(self, task, force)

    _, regular = problem.solve({"preload_N": 1200.0})
    monkeypatch.setattr(LinearModes, "to_peak", to_peak)
    _, found = problem.solve({"preload_N": 1200.0})
    assert found[0].frequency.size == regular[0].frequency.size
    for one, other in zip(found, regular, strict=True):
        np.testing.assert_allclose(one.peak_amplitude, other.peak_amplitude, rtol=1e-9)
    assert found[1].frequency.size > regular[1].frequency.size


def test_peaks_are_predicted_by_the_slip_force_over_the_excitation(problem, monkeypatch):
    taken = []

    def predicted(sweep, values):
        taken.extend(values)
        return sweep

    monkeypatch.setattr(solved_designs, "with_predicted_peaks", predicted)
    vary = {"preload_N": (500.0, 1000.0), "forces_N": (2.0, 4.0)}
    designs = list_designs(vary, GRID, problem.case)
    solved = solve_designs([problem], designs, range(4), converged=True, converged_designs={33: 2})
    gather_sweep(problem.case, designs, [solved], {})
    *_, ratio = taken
    np.testing.assert_allclose(ratio / ratio[0], [1.0, 0.5, 2.0, 1.0], rtol=1e-9)
    # all friction that the base case has
    (base_case,) = np.flatnonzero(designs["preload"].to_numpy() == 1000.0)[:1]
    expected = problem.joints[-1].law.slip_force.sum() / 2.0
    np.testing.assert_allclose(ratio[base_case], expected, rtol=1e-9)


def test_designs_whose_harmonics_were_not_found_are_not_predicted(problem, monkeypatch):
    designs = list_designs({"loss_factor": tuple(np.linspace(2e-3, 1e-2, 40))}, GRID, problem.case)
    monkeypatch.setattr(SweptJoint, "converge", lambda *_, **__: [ConvergedPeak(), ConvergedPeak()])
    of_some = {"converged": True, "converged_designs": {9: 30, 17: 10}}
    found = solve_designs([problem], designs, range(40), **of_some)
    # those that were not tried are
    assert int(found["is_predicted"].sum()) == 10
    for wrong in ({}, {9: 0}):
        with pytest.raises(ValueError, match="converged_designs"):
            solve_designs([problem], designs, range(40), converged=True, converged_designs=wrong)
    with pytest.raises(ValueError, match="converged be true"):
        solve_designs([problem], designs, range(40), converged_designs={9: 30})


def test_converged_peaks_of_designs_are_those_of_their_responses():
    content = base("variable", forces_N=(5.0,))
    designs = list_designs(VARY["variable"], Samples(kind="sobol", number=2, seed=3), content)
    problem = SweptJoint(content, joints(Case.model_validate(content))[:1])
    solved = solve_designs([problem], designs, range(2), converged=True)
    for row, values in enumerate(values_of(designs)):
        case = Case.model_validate(with_values(content, values))
        nodes = joints(case)[:1]
        resonance = Resonance(1, frequency_window(*nodes))
        how = {"damping": case.structural_damping, "resonance": resonance}
        alone = converge_peaks(nodes[0], solve_response(nodes[0], case.levels, **how))
        for name in CONVERGED:
            assert np.isfinite(alone[name]).all()
            # errors are changes of 1e-3 and less, of solutions to 1e-6
            rtol = 1e-3 if "error" in name else 1e-6
            np.testing.assert_allclose(solved[name][row], alone[name], rtol=rtol, atol=1e-6)


def test_limits_of_the_model_are_told_of_designs_as_of_responses():
    content = base("constant", forces_N=(0.1, 30.0))
    designs = list_designs({"loss_factor": (0.002, 0.01)}, Grid(kind="grid"), content)
    (nodes, *_) = joints(Case.model_validate(content))
    modes = np.random.default_rng(0).normal(size=(4, 3, nodes.natural_frequency.size))
    stored = xr.Dataset(
        {
            DISPLACEMENT.modes: (("place", "component", "mode"), modes),
            DISPLACEMENT.limit: 0.4,
        }
    )
    swept = SweptJoint(content, [nodes], limits=KnownLimits.of(stored))
    for converged in (False, True):
        solved = solve_designs([swept], designs, range(2), converged=converged)
        for row, loss_factor in enumerate((0.002, 0.01)):
            alone = solve_response(nodes, (0.1, 30.0), damping=loss_factor)
            if converged:
                alone = add_converged_peaks(alone, converge_peaks(nodes, alone))
            alone = add_limits(alone, stored)
            name = f"peak_{DISPLACEMENT.name}"
            np.testing.assert_allclose(solved[name][row], alone[name], rtol=1e-6)
        assert f"peak_{STRESS.name}" not in solved
    unknown = solve_designs([SweptJoint(content, [nodes])], designs, range(2))
    assert not any(name in unknown for name in (f"peak_{limit.name}" for limit in LIMITS))


def test_peaks_of_designs_have_no_more_harmonics_than_a_sweep_asks_for():
    content, options = base("variable", forces_N=(5.0,)), HarmonicConvergence()
    designs = list_designs({"loss_factor": (0.002, 0.01)}, Grid(kind="grid"), content)
    (nodes, *_) = joints(Case.model_validate(content))
    few = SweptJoint(content, [nodes], harmonics=options.up_to(9))
    solved = solve_designs([few], designs, range(2), converged=True)
    assert (solved["peak_harmonics"] == 9).all()
    found = converge_peaks(nodes, solve_response(nodes, [5.0], damping=0.002))
    assert found["peak_harmonics"].item() > 9
    for what in ("frequency", "amplitude"):
        with_9 = found[f"harmonic_peak_{what}"].sel(harmonics=9).item()
        assert solved[f"peak_{what}_converged"][0].item() == pytest.approx(with_9, rel=1e-4)
    assert options.up_to(2).harmonics == (3,)
    assert options.up_to(40) == options


def test_a_check_tells_how_far_the_peaks_are_off():
    content = base("constant", forces_N=(5.0, 30.0))
    of_constant = {"preload_N": (500.0, 1000.0, 1500.0), "loss_factor": (0.002, 0.01)}
    designs = list_designs(of_constant, Grid(kind="grid"), content)
    every = joints(Case.model_validate(content))
    solved = solve_designs([SweptJoint(content, every)], designs, range(6))
    check = check_designs([SweptJoint(content, every[:1])], designs, 4, seed=2)
    rows = check["checked_design"].to_numpy()
    assert rows.size == 4 and (np.diff(rows) > 0).all()
    grid = {"preload_N": 3, "loss_factor": 2}
    sweep = gather_sweep(content, designs, [solved], grid, check)
    assert (sweep["checked_designs"] == 4).all()
    for what in ("frequency", "amplitude"):
        own = solved[f"peak_{what}"].to_numpy()[rows]
        best = check[f"peak_{what}_converged"].to_numpy()
        off = np.maximum(own / best, best / own).max(axis=0) - 1
        error = sweep[f"peak_{what}_error"].to_numpy()
        assert (error >= off).all()
        # beside it there is the truncation error of the larger model only
        assert (error < 1.5 * off + 0.01).all()
    # what is estimated of the larger model counts
    stored = {"weight": 1.0, "basis_amplitude_error": 0.03, "estimated_amplitude_error": 0.01}
    errors = model_errors(xr.Dataset({name: ((), value) for name, value in stored.items()}))
    larger = SweptJoint(content, every[:1], errors=errors)
    estimated = check_designs([larger], designs, 4, seed=2)
    bars = gather_sweep(content, designs, [solved], grid, estimated)
    np.testing.assert_allclose(
        1 + bars["peak_amplitude_error"], 1.03 * 1.01 * (1 + sweep["peak_amplitude_error"])
    )
    np.testing.assert_array_equal(bars["peak_frequency_error"], sweep["peak_frequency_error"])
    told = error_of_sweep(sweep)
    assert told.amplitude == pytest.approx(float(sweep["peak_amplitude_error"].max()))
    assert told.designs == 4
    assert error_of_sweep(gather_sweep(content, designs, [solved], grid)) is None
    statistics = tabulate_statistics(sweep)
    of_amplitude = statistics[statistics["observed"] == "peak_mm"]["error_percent"]
    np.testing.assert_allclose(of_amplitude, 100 * sweep["peak_amplitude_error"])


def test_peaks_with_all_harmonics_count_where_they_are_observed():
    content = base("constant", forces_N=(3.0,))
    designs = list_designs({"loss_factor": (0.002, 0.01)}, Grid(kind="grid"), content)
    problem = SweptJoint(content, joints(Case.model_validate(content)))
    solved = solve_designs([problem], designs, range(2), converged=True)
    check = check_designs([problem], designs, 5)
    sweep = gather_sweep(content, designs, [solved], {"loss_factor": 2}, check)
    # the model is the same: what is left is the truncation error
    np.testing.assert_allclose(
        sweep["peak_amplitude_error"], solved["peak_amplitude_truncation_error"].max("design")
    )
    table = tabulate_statistics(sweep).set_index("observed")
    mean = 1e3 * float(solved["peak_amplitude_converged"].mean())
    assert table.loc["peak_mm", "mean"] == pytest.approx(mean)
    assert mean != pytest.approx(1e3 * float(solved["peak_amplitude"].mean()), rel=1e-4)


def test_without_error_bars_the_last_change_of_harmonics_is_extrapolated():
    content = base("constant", forces_N=(3.0,))
    designs = list_designs({"loss_factor": (0.002, 0.01)}, Grid(kind="grid"), content)
    every = joints(Case.model_validate(content))[:1]
    problem = SweptJoint(content, every, harmonics=HarmonicConvergence().up_to(9))
    larger = SweptJoint(content, every, harmonics=HarmonicConvergence().up_to(17))
    solved, check = (
        solve_designs([one], designs, range(2), converged=True, error_bars=False)
        for one in (problem, larger)
    )
    for what in ("frequency", "amplitude"):
        assert f"peak_{what}_inertia_error" not in solved
        peaks = [one[f"peak_{what}_converged"] for one in (solved, check)]
        change = abs(peaks[1] / peaks[0] - 1)
        # it falls with the square of the harmonics
        told = check[f"peak_{what}_truncation_error"]
        of_phase = told - change / ((17 / 9) ** 2 - 1)
        # and what the phase of the peaks is off
        assert ((of_phase > 0) & (of_phase < 2e-3)).all()
    checked = check_designs([larger], designs, 2, error_bars=False)
    sweep = gather_sweep(content, designs, [solved], {"loss_factor": 2}, checked)
    off = float((change + told).max())
    assert 0 < sweep["peak_amplitude_error"].item() == pytest.approx(off, rel=0.05)


def test_peaks_of_most_designs_follow_from_those_of_some():
    content = base("constant", forces_N=(5.0, 30.0))
    vary = {"preload_N": Linear(kind="linear", lowest=500, highest=1500)}
    designs = list_designs(vary, Samples(kind="sobol", number=64, seed=3), content)
    problem = SweptJoint(content, joints(Case.model_validate(content))[:1])
    of_some = {"converged": True, "converged_designs": {17: 40, 33: 32}}
    some = solve_designs([problem], designs, range(64), **of_some)
    assert (some["peak_harmonics"].notnull().sum("design") == 32).all()
    np.testing.assert_array_equal(some["harmonics"], [17, 33])
    solved = some["harmonic_peak_amplitude"].notnull().sum("design")
    np.testing.assert_array_equal(solved, [[40, 32], [40, 32]])
    with_most = some["harmonic_peak_amplitude"][..., 1].drop_vars("harmonics")
    xr.testing.assert_equal(with_most, some["peak_amplitude_converged"])
    # in chunks the same designs are drawn
    chunks = [
        solve_designs([problem], designs, chunk, **of_some) for chunk in (range(40), range(40, 64))
    ]
    xr.testing.assert_identical(some, xr.concat(chunks, "design", combine_attrs="override"))
    sweep = gather_sweep(content, designs, chunks, {})
    whole = solve_designs([problem], designs, range(64), converged=True)
    for what in ("frequency", "amplitude"):
        error = abs(sweep[f"peak_{what}_converged"] / whole[f"peak_{what}_converged"] - 1)
        told = sweep[f"peak_{what}_regression_error"]
        # a superharmonic resonance moves some designs, which the error knows
        assert ((error <= told).sum("design") >= 60).all()
        assert (told < 0.1).all()
    assert int(sweep["is_predicted"].sum()) == 32
    # it counts in the error of the sweep, whose checked designs are among those solved
    check = check_designs([problem], designs, 4, seed=2, converged_designs={17: 40, 33: 32})
    assert not sweep["is_predicted"][check["checked_design"].to_numpy()].any()
    told = gather_sweep(content, designs, chunks, {}, check)
    for what in ("frequency", "amplitude"):
        regression = told[f"peak_{what}_regression_error"].to_numpy()
        assert np.all(told[f"peak_{what}_error"].to_numpy() > regression)
    # what tells what it is made of is of the level with the largest error
    error, known = error_of_sweep(told), gather_sweep(content, designs, [whole], {}, check)
    worst = int(told["peak_amplitude_error"].to_numpy().argmax())
    assert error.regression == float(told["peak_amplitude_regression_error"][worst]) > 0
    assert error.model == pytest.approx(float(known["peak_amplitude_error"][worst]), rel=1e-9)
    alone = error_of_sweep(known)
    assert alone.regression is None and alone.model == pytest.approx(alone.amplitude, rel=1e-12)


@pytest.fixture(scope="module")
def problem():
    content = base("constant", forces_N=(5.0, 30.0))
    return SweptJoint(content, joints(Case.model_validate(content)))


def test_a_grid_has_the_dimensions_of_its_keys(problem):
    vary = {
        "preload_N": (800.0, 1000.0, 1200.0),
        "contact.friction_coefficient": Linear(kind="linear", lowest=0.1, highest=0.2, number=2),
    }
    designs = list_designs(vary, GRID, problem.case)
    chunks = [
        solve_designs([problem], designs, range(*each), frequencies=50) for each in ((0, 4), (4, 6))
    ]
    sizes = {"preload_N": 3, "contact.friction_coefficient": 2}
    sweep = gather_sweep(problem.case, designs, chunks, sizes)
    assert sweep["peak_amplitude"].dims == ("preload", "friction_coefficient", "force")
    assert sweep["response_amplitude"].shape == (3, 2, 2, 50)
    np.testing.assert_array_equal(sweep["preload"], [800, 1000, 1200])
    np.testing.assert_array_equal(sweep["friction_coefficient"], [0.1, 0.2])
    np.testing.assert_array_equal(sweep["force_level"], [5, 30])
    assert sweep["preload"].attrs["units"] == "N"
    assert sweep["peak_amplitude"].attrs["units"] == "m"
    assert sweep.attrs == {"varied": "preload friction_coefficient"}
    values = {"preload_N": 1200.0, "contact.friction_coefficient": 0.1}
    window = tuple(sweep["frequency"].to_numpy()[[0, -1]])
    _, (_, branch) = problem.solve(values, window)
    here = sweep.isel(preload=2, friction_coefficient=0, force=1)
    assert float(here["peak_amplitude"]) == pytest.approx(branch.amplitude[branch.peak], rel=1e-9)
    # the grid passes the peak near by
    assert 0.5 < here["response_amplitude"].max() / here["peak_amplitude"] <= 1 + 1e-6


def test_impossible_designs_are_named_and_the_rest_is_solved(problem):
    designs = list_designs({"preload_N": (0.0, 1000.0, -5.0)}, GRID, problem.case)
    found = solve_designs([problem], designs, range(3))
    sweep = gather_sweep(problem.case, designs, [found], {"preload_N": 3})
    assert sweep["reason"].to_numpy().tolist() == [
        "preload_N: 0.0 must be greater than 0",
        "",
        "preload_N: -5.0 must be greater than 0",
    ]
    np.testing.assert_array_equal(
        np.isnan(sweep["peak_amplitude"]).all("force"), [True, False, True]
    )
    np.testing.assert_array_equal(sweep["complete"][:, 0], [0, 1, 0])


STIFFNESS = "contact.tangential_stiffness_N_per_m"


def test_a_design_that_is_too_stiff_leaves_the_window_of_the_others(problem):
    designs = list_designs({STIFFNESS: (5e6, 1e30, 1e7)}, GRID, problem.case)
    found = solve_designs([problem], designs, range(3), frequencies=40)
    possible = list_designs({STIFFNESS: (5e6, 1e7)}, GRID, problem.case)
    alone = solve_designs([problem], possible, range(2), frequencies=40)
    assert np.isfinite(found["frequency"]).all()
    assert found.isel(design=[0, 2]).identical(alone)
    reason = found["reason"].to_numpy()[1]
    assert reason.startswith("the contact is too stiff: it raises resonance 1 from ")
    assert np.isnan(found["response_amplitude"][1]).all()
    # the same where each design has a window of its own
    peaks = solve_designs([problem], designs, range(3))
    assert peaks["reason"].to_numpy().tolist() == ["", reason, ""]
    np.testing.assert_array_equal(np.isnan(peaks["peak_frequency"][:, 0]), [False, True, False])


def test_a_window_of_no_design_is_refused_with_the_reason(problem):
    designs = list_designs({STIFFNESS: (1e28, 1e30)}, GRID, problem.case)
    with pytest.raises(ValueError, match=r"no design is possible: the contact is too stiff"):
        solve_designs([problem], designs, range(2), frequencies=40)
    designs = list_designs({"preload_N": (0.0, -5.0)}, GRID, problem.case)
    with pytest.raises(ValueError, match=r"no design is possible: preload_N: 0.0 must be greater"):
        solve_designs([problem], designs, range(2), frequencies=40)


def test_designs_of_an_impossible_joint_are_impossible(problem):
    reason = "100 pairs in 72 places along the bar do not divide into 77 regions"
    vary = {"joint.regions": (3.0, 77.0), "preload_N": (900.0, 1000.0)}
    quantities = {
        "joint.regions": Quantity("joint_regions", "1", "number of regions"),
        "preload_N": Quantity("preload", "N", "preload of each bolt"),
    }
    variants = [{"values": {"joint.regions": n}, "reason": ""} for n in (3.0, 77.0)]
    designs = list_designs(vary, GRID, problem.case, variants, quantities)
    joints = [problem, ImpossibleJoint(reason)]
    everything = {"frequencies": 20, "amplitudes": 5, "states": True}
    found = solve_designs(joints, designs, range(4), **everything)
    assert found["reason"].to_numpy().tolist() == ["", "", reason, reason]
    assert found["peak_amplitude"][:2].notnull().all()
    assert found["peak_amplitude"][2:].isnull().all()
    with pytest.raises(ValueError, match=r"no design is possible: 100 pairs in 72 places"):
        solve_designs([ImpossibleJoint(reason)], designs, range(4))


def test_impossible_designs_do_not_count_in_the_amplitudes_of_backbones(problem, tmp_path):
    def list_rows(*rows):
        table = tmp_path / "designs.csv"
        table.write_text("\n".join(["forces_N,loss_factor", *rows]))
        return list_designs({}, Table(kind="table", file="designs.csv"), problem.case, table=table)

    # a loss factor of 2 is impossible
    one = solve_designs([problem], list_rows("20,0.003"), range(1), amplitudes=5)
    two = solve_designs([problem], list_rows("20,0.003", "1e9,2"), range(2), amplitudes=5)
    np.testing.assert_array_equal(two["amplitude"], one["amplitude"])


def test_threads_and_chunks_change_nothing(problem):
    vary = {"preload_N": Linear(kind="linear", lowest=500, highest=1500)}
    designs = list_designs(vary, Samples(kind="sobol", number=8), problem.case)
    one = solve_designs([problem], designs, range(8), frequencies=20)
    two = solve_designs([problem], designs, range(8), 2, frequencies=20)
    assert one.identical(two)
    later = solve_designs([problem], designs, range(5, 8), frequencies=20)
    assert one.isel(design=slice(5, 8)).identical(later)


def test_samples_follow_their_distributions(problem):
    vary = {
        "preload_N": Normal(kind="normal", mean=1000.0, standard_deviation=100.0),
        "contact.friction_coefficient": Lognormal(
            kind="lognormal", mean=0.2, coefficient_of_variation=0.4
        ),
        "loss_factor": Triangular(kind="triangular", lowest=0.001, likeliest=0.002, highest=0.006),
        "forces_N": (1.0, 2.0, 5.0),
    }
    found = list_designs(vary, Samples(kind="sobol", number=4096), problem.case)
    mean = {name: float(found[name].mean()) for name in found if name != "reason"}
    assert mean["preload"] == pytest.approx(1000, rel=1e-4)
    assert float(found["preload"].std()) == pytest.approx(100, rel=2e-3)
    assert mean["friction_coefficient"] == pytest.approx(0.2, rel=1e-3)
    assert float(found["friction_coefficient"].std()) == pytest.approx(0.08, rel=0.01)
    assert mean["loss_factor"] == pytest.approx(0.003, rel=1e-3)
    assert found["loss_factor"].min() >= 0.001
    assert found["loss_factor"].max() <= 0.006
    levels, counts = np.unique(found["force_level"], return_counts=True)
    np.testing.assert_array_equal(levels, [1, 2, 5])
    assert np.ptp(counts) <= 1
    assert not found["reason"].str.len().any()
    # the same seed draws the same
    again = list_designs(vary, Samples(kind="sobol", number=4096), problem.case)
    assert again.identical(found)


def test_a_table_gives_the_designs(problem, tmp_path):
    table = tmp_path / "designs.csv"
    table.write_text("preload_N,contact.friction_coefficient\n900,0.1\n1100,0.3\n")
    found = list_designs({}, GRID, problem.case, table=table)
    assert values_of(found) == [
        {"preload_N": 900.0, "contact.friction_coefficient": 0.1},
        {"preload_N": 1100.0, "contact.friction_coefficient": 0.3},
    ]


def test_backbones_are_those_of_the_designs(problem):
    vary = {"preload_N": (500.0, 1000.0, 0.0), "loss_factor": (0.002, 0.01)}
    designs = list_designs(vary, GRID, problem.case)
    found = solve_designs([problem], designs, range(6), amplitudes=12, between=(1e-6, 1e-3))
    np.testing.assert_allclose(found["amplitude"], np.geomspace(1e-6, 1e-3, 12))
    assert np.isnan(found["damping_ratio"][4:]).all()
    for row in (0, 3):
        joint, _ = problem.solve(values_of(designs)[row])
        loss_factor = values_of(designs)[row]["loss_factor"]
        whole = find_backbone(joint, [0.1, 30.0], damping=loss_factor, window=(30.0, 200.0))
        between = (whole["response_amplitude"] > 1e-6) & (whole["response_amplitude"] < 1e-3)
        states = whole.isel(state=np.flatnonzero(between))
        frequency, damping = backbone_at(joint, states["response_amplitude"], damping=loss_factor)
        np.testing.assert_allclose(frequency, states["natural_frequency"], rtol=1e-9)
        np.testing.assert_allclose(damping, states["damping_ratio"], rtol=1e-7)
        # along the line through these states, which is as near as that
        known = np.log(states["response_amplitude"])
        at = np.log(found["amplitude"])
        inside = (at > known[0]) & (at < known[-1])
        assert inside.sum() > 8
        curve = np.interp(at[inside], known, frequency)
        largest = StepControl().curve_tolerance * np.ptp(whole["natural_frequency"].to_numpy())
        of_design = found["natural_frequency"][row, inside.to_numpy()]
        np.testing.assert_allclose(of_design, curve, rtol=0, atol=largest)


def test_backbones_have_the_harmonics_of_the_study(problem):
    designs = list_designs({"preload_N": (500.0, 1000.0)}, GRID, problem.case)
    with_three = replace(problem, sampling={"harmonics": 3, "samples": 128})
    range_of = {"amplitudes": 4, "between": (1e-5, 1e-3)}
    one, three = (
        solve_designs([each], designs, range(2), **range_of)["damping_ratio"].to_numpy()
        for each in (problem, with_three)
    )
    joint = with_three.joints[-1]
    law = AlternatingFrequencyTime(joint.law, harmonics=3, samples=128)
    amplitudes = np.geomspace(1e-5, 1e-3, 4)
    _, damping = backbone_at(
        replace(joint, law=law), amplitudes, damping=problem.base.structural_damping
    )
    # the second design is the base case
    np.testing.assert_allclose(three[1], damping, rtol=1e-7)
    assert abs(three / one - 1).max() > 0.005


def test_backbones_go_up_to_the_largest_peak_of_the_base_case(problem):
    designs = list_designs({"preload_N": (500.0, 1000.0)}, GRID, problem.case)
    found = solve_designs([problem], designs, range(2), amplitudes=5)
    np.testing.assert_allclose(found["amplitude"][-1], found["peak_amplitude"][1, -1])
    np.testing.assert_allclose(found["amplitude"][0], 1e-3 * found["amplitude"][-1])


@pytest.mark.parametrize("amplitudes", [[], [1e-6, 1e-7], [0.0, 1e-6]])
def test_amplitudes_of_a_backbone_ascend_from_above_zero(problem, amplitudes):
    with pytest.raises(ValueError, match="amplitudes"):
        backbone_at(problem.joints[-1], amplitudes, damping=0.01)


def test_indices_of_the_stuck_resonance_follow_from_its_derivatives():
    content = base("variable", forces_N=(1e-6,))
    keys = ("tangential_stiffness_N_per_m", "normal_stiffness_N_per_m")
    means, width = (KEYS["variable"][key] for key in keys), (0.02, 0.04)
    vary = {
        f"contact.{key}": Linear(kind="linear", lowest=(1 - w) * mean, highest=(1 + w) * mean)
        for key, mean, w in zip(keys, means, width, strict=True)
    }
    problem = SweptJoint(content, joints(Case.model_validate(content)))
    designs = list_designs(vary, Saltelli(kind="saltelli", number=256), content)
    found = solve_designs([problem], designs, range(designs.sizes["design"]))
    sweep = gather_sweep(content, designs, [found], {})
    table = tabulate_sensitivity(sweep)
    table = table[table["observed"] == "peak_frequency_Hz"].set_index("key")

    # the stiffness of stuck pairs is linear in each of both
    joint = problem.joints[-1]
    L = np.diag((2 * np.pi * joint.natural_frequency) ** 2)
    squared, vectors = np.linalg.eigh(L + joint.stuck_stiffness())
    frequency = np.sqrt(squared[0]) / (2 * np.pi)
    np.testing.assert_allclose(sweep["peak_frequency"].mean(), frequency, rtol=1e-3)
    variances = []
    for key, w in zip(keys, width, strict=True):
        before = {each.removesuffix("_N_per_m"): of for each, of in KEYS["variable"].items()}
        name = key.removesuffix("_N_per_m")
        after = before | {name: 2 * before[name]}
        twice = rescale_contact(joint, LAWS["variable"], before, after)
        mode = vectors[:, 0]
        # of the square of the circular frequency, by the logarithm of the stiffness
        derivative = mode @ (twice.stuck_stiffness() - joint.stuck_stiffness()) @ mode
        variances.append((derivative * w) ** 2)
    for key, variance in zip(keys, variances, strict=True):
        row = table.loc[key.removesuffix("_N_per_m")]
        expected = variance / sum(variances)
        assert 0.02 < expected < 0.98
        for order in ("first_order", "total"):
            assert row[f"{order}_low"] < expected < row[f"{order}_high"]
            assert row[f"{order}_high"] - row[f"{order}_low"] < 0.3
            assert abs(row[order] - expected) < 0.05


@pytest.mark.parametrize("law", ["constant", "variable"])
def test_weights_of_pairs_hold_peaks_all_over_a_sweep(law):
    content, nodes = base(law), make_joint(300, law=law)
    designs = list_designs(VARY[law], Samples(kind="latin-hypercube", number=40, seed=3), content)
    weighted, fit = weigh_pairs_of_designs(nodes, designs, content, [0])
    assert weighted.points < 0.7 * nodes.points
    whole, few = (
        solve_designs([SweptJoint(content, each)], designs, range(40))
        for each in ([nodes], [nodes, weighted])
    )
    for what, tolerance in (("frequency", 1e-3), ("amplitude", 1e-2)):
        assert float(fit[f"estimated_{what}_error"]) <= tolerance
        of_all, of_few = (each[f"peak_{what}"].to_numpy() for each in (whole, few))
        np.testing.assert_allclose(of_few, of_all, rtol=tolerance)
