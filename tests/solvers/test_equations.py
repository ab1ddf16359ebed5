"""Classes of equations must define what solvers call."""

import pytest
from curves import FOLDED

from boltjoint.solvers.equations import Equations
from boltjoint.solvers.lagged_basis import LaggedEquations


@pytest.mark.parametrize(
    ("base", "needed"),
    [
        (Equations, {"evaluate", "parameter_derivative"}),
        (
            LaggedEquations,
            {
                *("evaluate", "parameter_derivative", "update"),
                *("from_fixed", "to_fixed", "change_from_fixed", "change_to_fixed"),
            },
        ),
    ],
)
def test_equations_without_a_method_that_solvers_call_are_refused(base, needed):
    for forgotten in needed:
        methods = {name: lambda self, *_: None for name in needed - {forgotten}}
        incomplete = type("Incomplete", (base,), methods)
        with pytest.raises(TypeError, match=forgotten):
            incomplete()
    type("Complete", (base,), {name: lambda self, *_: None for name in needed})()


def test_equations_that_keep_nothing_of_their_solutions_need_not_say_so():
    FOLDED.accept(None)
    FOLDED.restore(FOLDED.state())
    assert FOLDED.state() is None
