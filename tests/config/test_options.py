"""Numerical options: what the library gets of them, and its own defaults."""

import inspect
from typing import get_args

import pytest
from pydantic import ValidationError

from boltjoint.config.numerical_options import Fitting, Solver
from boltjoint.config.sweep import Harmonics, Sweep
from boltjoint.dynamics.response.harmonic_convergence import HarmonicConvergence
from boltjoint.friction.aft import AlternatingFrequencyTime
from boltjoint.joint.reduced import fit_reduced_joint
from boltjoint.options import CONVERGING
from boltjoint.solvers.step_control import StepControl
from boltjoint.study import memory_and_time_of_jobs
from boltjoint.verification.multi_harmonic import tabulate_steady_states


def test_how_elements_are_fitted():
    loops = {"starts": 3, "load_fractions": (0.3, 0.6, 0.9)}
    fitting = Fitting(initial_guesses=3)
    found = fitting.options("regions=6/elements=7")
    assert found == {"reduction": "elements", "count": 7, **loops}
    # at all amplitudes, and from one initial guess
    found = fitting.options("clusters=auto/harmonic=4")
    assert found == {"reduction": "harmonic", "count": 4}
    assert fitting.options("clusters=2/table") == {"reduction": "table"}


def test_defaults_are_those_of_the_library():
    assert StepControl(**Solver().steps) == StepControl()
    fit = inspect.signature(fit_reduced_joint).parameters
    for key, value in Fitting().options("regions=1/elements=1").items():
        assert key in ("count", "reduction") or fit[key].default == value
    samples = inspect.signature(AlternatingFrequencyTime).parameters["samples"].default
    assert Solver().time_samples == samples
    assert HarmonicConvergence(**Solver().harmonic_convergence) == HarmonicConvergence()
    told = Solver.model_fields["harmonics"].description
    assert f"up to {CONVERGING[-1]}:" in told
    # of sweeps they are chosen among these
    assert get_args(Harmonics) == CONVERGING
    assert Sweep.model_fields["harmonics"].default == CONVERGING[-1]
    harmonics = inspect.signature(tabulate_steady_states).parameters["harmonics"].default
    assert max(harmonics) == memory_and_time_of_jobs.MANY_ENRICHED


def test_friction_forces_by_aft_may_have_more_harmonics():
    solver = Solver(friction_force="aft", harmonics=3)
    assert solver.sampling == {"harmonics": 3, "samples": 256}
    assert solver.steps == Solver().steps
    assert Solver().sampling is None
    assert Solver(friction_force="aft", harmonics="auto").sampling["harmonics"] == "auto"
    with pytest.raises(ValidationError, match="must be at least 264, 8 for each harmonic"):
        Solver(friction_force="aft", harmonics=33)
