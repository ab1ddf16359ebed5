"""Backbone at given amplitudes of the output point, so that those of many designs compare."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from boltjoint import checks
from boltjoint.damping import Damping
from boltjoint.dynamics.backbone.backbone import trace_backbone
from boltjoint.dynamics.backbone.epmc import EPMCEquations, ModalState
from boltjoint.joint.model import Joint
from boltjoint.solvers.step_control import StepControl

Array = NDArray[np.float64]

#: factor between the amplitudes that are traced and those that are wanted
_BEYOND = 1.5


def backbone_at(
    joint: Joint,
    amplitudes: Sequence[float] | Array,
    *,
    damping: Damping | float,
    resonance: int = 1,
    control: StepControl | None = None,
) -> tuple[Array, Array]:
    """Natural frequency [Hz] and damping ratio at given amplitudes of the output point.

    Parameters
    ----------
    joint
        The joint and its structure.
    amplitudes
        Ascending [m], shape (amplitudes,); at least 1e-100, as squares of smaller ones are zero.
    damping, resonance, control
        As for ``find_backbone``.

    Returns
    -------
    tuple of ndarray
        Each of shape (amplitudes,); not a number where the backbone does not reach.

    Raises
    ------
    ValueError
        If the amplitudes do not ascend or are too small, the output point does not move in the
        mode, or as for ``find_backbone``.
    """
    checks.instance("joint", joint, Joint)
    wanted = checks.array("amplitudes", amplitudes, ("amplitudes",), at_least=checks.SMALLEST_LEVEL)
    if wanted.size == 0 or np.any(np.diff(wanted) <= 0):
        raise ValueError("amplitudes must ascend")
    equations = EPMCEquations(joint.distinct, damping, resonance)
    output = equations.balance.joint.response_mode

    def size(state: ModalState) -> float:
        return state.log_amplitude + float(np.log(abs(state.mode @ output)))

    # the output point moves more or less with the mode as this changes its shape
    per_modal = abs(equations.stuck @ output)
    if per_modal == 0:
        raise ValueError(f"the output point does not move in mode {resonance}")
    bounds = wanted[0] / _BEYOND / per_modal, wanted[-1] * _BEYOND / per_modal
    backbone = trace_backbone(equations, bounds, control)
    sizes = [size(state) for state in backbone.states]
    curves = np.full((2, wanted.size), np.nan)
    for place, target in enumerate(np.log(wanted)):
        after = next((n for n, size_of_state in enumerate(sizes) if size_of_state >= target), 0)
        if after:
            first, second = backbone.states[after - 1 : after + 1]

            def beyond(at: ModalState, wanted: float = target) -> float:
                return size(at) - wanted

            state = backbone.solve_root(beyond, first, second, 1.0)
            curves[:, place] = state.frequency, state.damping_ratio
    return curves[0], curves[1]
