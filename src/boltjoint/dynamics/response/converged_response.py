"""Frequency responses with as many harmonics as their peaks need, by force level."""

import logging
from collections.abc import Sequence
from dataclasses import replace

import xarray as xr

from boltjoint import checks
from boltjoint.damping import Damping
from boltjoint.dataset import quantity
from boltjoint.dynamics.balance.linear_modes import Jacobian
from boltjoint.dynamics.response.converged_peaks import add_converged_peaks, converge_peaks
from boltjoint.dynamics.response.frequency_response import solve_response
from boltjoint.dynamics.response.method import Method
from boltjoint.dynamics.response.methods import LinearModes, as_method
from boltjoint.dynamics.response.peak_sequence import HarmonicConvergence
from boltjoint.dynamics.response.windows import Resonance
from boltjoint.friction.aft import AlternatingFrequencyTime, without_sampling
from boltjoint.joint.model import Joint
from boltjoint.solvers.equations import StepControl

logger = logging.getLogger(__name__)


def find_converged_peaks(
    joint: Joint,
    forces: Sequence[float],
    *,
    damping: Damping | float,
    resonance: Resonance | int = 1,
    control: StepControl | None = None,
    harmonics: HarmonicConvergence = HarmonicConvergence(),
    jacobian: Jacobian = "analytic",
) -> xr.Dataset:
    """The peaks of a joint with as many harmonics as change nothing, from those with one.

    Parameters
    ----------
    joint
        With the law of its elements, or AFT of it.
    forces
        Amplitudes of the excitation [N].
    damping, resonance, control
        As for ``solve_response``.
    harmonics
        Numbers of harmonics and tolerances.
    jacobian
        As for ``LinearModes``.

    Returns
    -------
    Dataset
        As of ``converge_peaks``.

    Raises
    ------
    ValueError
        As for ``solve_response``.
    """
    checks.instance("joint", joint, Joint)
    joint = replace(joint, law=without_sampling(joint.law))
    how = {"damping": damping, "resonance": resonance, "control": control}
    response = solve_response(joint, forces, LinearModes(jacobian=jacobian), **how)
    return converge_peaks(joint, response, harmonics)


def solve_converged_response(
    joint: Joint,
    forces: Sequence[float],
    method: Method | str = "linear",
    *,
    damping: Damping | float,
    resonance: Resonance | int = 1,
    control: StepControl | None = None,
    harmonics: HarmonicConvergence = HarmonicConvergence(),
    peaks: xr.Dataset | None = None,
) -> xr.Dataset:
    """Frequency responses at several force levels, each with as many harmonics as its peak needs.

    The response to each force is followed with the harmonics of its converged peak, with the most
    of them where there is no peak.

    Parameters
    ----------
    joint
        With the law of its elements, or AFT of it.
    forces
        Amplitudes of the excitation [N].
    method, damping, resonance, control
        As for ``solve_response``.
    harmonics
        Numbers of harmonics and tolerances.
    peaks
        Peaks of ``find_converged_peaks`` for this joint and resonance and these forces, by whatever
        method the response is; found by default.

    Returns
    -------
    Dataset
        As of ``solve_response``, with the components of the most harmonics of any force, zero
        beyond its own, and by ``force`` the ``response_harmonics``; with the converged peaks and
        error bars (``add_converged_peaks``).

    Raises
    ------
    ValueError
        As for ``solve_response``; if the method does not know motions of any number of harmonics
        (``complex-rdnm-N``, ``backbone``).
    """
    checks.instance("joint", joint, Joint)
    forces = checks.levels("forces", forces)
    joint = replace(joint, law=without_sampling(joint.law))
    method = as_method(method)
    if not method.knows_harmonics:
        raise ValueError(f"method is {method.name}: must be linear or rdnm-N")
    how = {"damping": damping, "resonance": resonance, "control": control}
    if peaks is None:
        peaks = find_converged_peaks(
            joint, forces, **how, harmonics=harmonics, jacobian=method.jacobian
        )
    most = max(harmonics.harmonics)
    highest = peaks["peak_harmonics"].fillna(most).to_numpy().astype(int)
    found = []
    for force, number in zip(forces, highest, strict=True):
        logger.info("%g N: response with %d harmonics", force, number)
        law = AlternatingFrequencyTime(joint.law, **harmonics.sampling(int(number)))
        found.append(solve_response(replace(joint, law=law), [force], method, **how))
    response = _concatenate(found)
    numbers = quantity("force", highest, "1", "highest harmonic of the response")
    return add_converged_peaks(response.assign(response_harmonics=numbers), peaks)


def _concatenate(responses: Sequence[xr.Dataset]) -> xr.Dataset:
    """Responses to single forces as one dataset, with the components of all."""
    components = max((each["component"].to_numpy() for each in responses), key=len)
    whole = [each.reindex(component=components, fill_value=0.0) for each in responses]
    parts = []
    for dimension in ("solution", "force", "fold"):
        names = [name for name, values in whole[0].items() if dimension in values.dims]
        rows = [each[names] for each in whole]
        parts.append(xr.concat(rows, dimension, combine_attrs="override"))
    return xr.merge(parts).assign_attrs(whole[0].attrs)
