"""Peaks and responses with as many harmonics as change nothing: what one harmonic leaves out.

Peaks are sought with more and more harmonics, and the truncation error of the last is estimated
(``harmonic_convergence``); responses are solved with as many as their peaks need.
"""

import logging
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import xarray as xr

from boltjoint import checks
from boltjoint.damping import Damping, damping_of_attributes
from boltjoint.dataset import quantity
from boltjoint.dynamics.balance.balance_equations import Jacobian
from boltjoint.dynamics.balance.periodic_motion import (
    PeriodicMotion,
    find_superharmonic,
    motion_at_peak,
)
from boltjoint.dynamics.response.error_bars import (
    ConvergedPeak,
    add_converged_peaks,
    converged_peaks_to_dataset,
)
from boltjoint.dynamics.response.frequency_response import as_method, solve_response
from boltjoint.dynamics.response.harmonic_convergence import (
    HarmonicConvergence,
    PeakSequence,
    converge_peak,
)
from boltjoint.dynamics.response.inertia_of_basis import inertia_error
from boltjoint.dynamics.response.left_out_harmonics import (
    LeftOutHarmonics,
    change_by_left_out_harmonics,
)
from boltjoint.dynamics.response.methods import LinearModes, Method
from boltjoint.dynamics.response.phase_resonance import PeakSearch
from boltjoint.dynamics.response.windows import Resonance
from boltjoint.friction.aft import AlternatingFrequencyTime, without_sampling
from boltjoint.friction.element_law import ElementLaw
from boltjoint.joint.model import Joint
from boltjoint.solvers.step_control import StepControl

logger = logging.getLogger(__name__)


def converge_peaks(
    joint: Joint,
    response: xr.Dataset,
    options: HarmonicConvergence = HarmonicConvergence(),
    left_out: LeftOutHarmonics | None = LeftOutHarmonics(),
) -> xr.Dataset:
    """The peaks of a response with as many harmonics as change nothing.

    Parameters
    ----------
    joint, response
        A joint and its ``response.nc``.
    options
        Numbers of harmonics and tolerances.
    left_out
        How their truncation errors are estimated; with None only the peaks are found, in half of
        the time or less.

    Returns
    -------
    Dataset
        By ``force``: ``peak_frequency_converged`` [Hz], ``peak_amplitude_converged`` [m] and
        ``peak_harmonics``; ``peak_frequency_truncation_error`` and
        ``peak_amplitude_truncation_error``, relative: beyond the tolerances where the most
        harmonics do not suffice; not a number where the response has no peak, fewer than two with
        more harmonics are found, no motion with further ones or later samples is, or its law has no
        elements that can be followed in time. ``peak_frequency_inertia_error`` and
        ``peak_amplitude_inertia_error``, relative: what inertia of vectors of the basis that are no
        modes changes in further harmonics, 0 in a basis of modes (``inertia_of_basis``).
        ``superharmonic_order``, 0 without one, ``superharmonic_frequency`` [Hz] and
        ``superharmonic_share`` (``balance.periodic_motion``). By ``force`` and
        ``output_component``, the motion of the output point at the peak, ``peak_motion_converged``
        [m]. By ``force`` and ``harmonics``, the peaks on the way: ``harmonic_peak_frequency`` [Hz]
        and ``harmonic_peak_amplitude`` [m].

    Raises
    ------
    ValueError
        If joint or response are of another kind.
    """
    checks.instance("joint", joint, Joint)
    checks.instance("response", response, xr.Dataset)
    peaks = [ConvergedPeak()] * response.sizes["force"]
    damping = damping_of_attributes(response.attrs)
    for place, force in enumerate(response["force_level"].to_numpy()):
        has_peak = np.isfinite(response["peak_frequency"][place])
        if has_peak and (peak := motion_at_peak(response, force)) is not None:
            at = find_converged_peak(joint, *peak, force, damping, options, left_out)
            if left_out is not None and at.sequence.has_more_harmonics:
                _warn(at, force)
            peaks[place] = at
    return converged_peaks_to_dataset(peaks, joint.response_mode)


def _warn(peak: ConvergedPeak, force: float) -> None:
    """Say where the error bar of a peak is wide, or missing."""
    if not peak.sequence.converged:
        logger.warning(
            "%g N: the peak still changes by more than the tolerances with %d harmonics, "
            "the most with which it is found: its error bar is wider",
            force,
            peak.sequence.peaks[-1].harmonics,
        )
    if np.isnan(peak.truncation_error[1]):
        logger.warning(
            "%g N: no motion with more harmonics or later samples was found near: the peak has no "
            "error bar",
            force,
        )
    elif np.isnan(peak.inertia_error[1]):
        logger.warning(
            "%g N: no motion was found near without the inertia of vectors that are no modes: the "
            "peak has no error bar",
            force,
        )


def find_converged_peak(
    joint: Joint,
    frequency: float,
    motion: PeriodicMotion,
    force: float,
    damping: Damping | float,
    options: HarmonicConvergence = HarmonicConvergence(),
    left_out: LeftOutHarmonics | None = LeftOutHarmonics(),
    *,
    at_one_phase: bool = False,
) -> ConvergedPeak:
    """The peaks as of ``converge_peak``, with the truncation errors of the last.

    Parameters
    ----------
    joint
        With the law of its elements, or AFT of it.
    frequency, motion, force, damping, options
        As for ``converge_peak``.
    left_out
        How truncation errors are estimated; not with None.
    at_one_phase
        As for ``converge_peak``; not with ``left_out``.

    Returns
    -------
    ConvergedPeak
        Without peaks where the law has no elements that can be followed in time.
    """
    joint = replace(joint, law=without_sampling(joint.law))
    if not isinstance(joint.law, ElementLaw):
        return ConvergedPeak()
    joint = joint.distinct
    if at_one_phase and left_out is not None:
        raise ValueError("the errors of peaks at one phase are not estimated by left-out harmonics")
    near = joint, frequency, motion, force, damping, options
    sequence = converge_peak(*near, at_one_phase=at_one_phase)
    peak = ConvergedPeak(sequence) if left_out is None else _judge(sequence, left_out)
    # motions at other phases, and their factors, have served
    return peak._replace(sequence=sequence._replace(resonance=None))


def _judge(sequence: PeakSequence, left_out: LeftOutHarmonics) -> ConvergedPeak:
    """Truncation errors of a peak sequence, and whether a harmonic of its last is in resonance.

    What the search of the peak left is added: its distance from the peak, and its tolerance.
    """
    resonance, located = sequence.resonance, sequence.peaks[-1].located
    if resonance is None or located is None:
        return ConvergedPeak(sequence)
    located = resonance.with_sampling_error(located)
    change = change_by_left_out_harmonics(resonance, located, left_out)
    at_phase = left_out.safety * np.array(change)
    frequency, amplitude = sequence.extrapolated_change
    frequency += located.frequency_error(*at_phase) + located.sampling_error[0]
    amplitude += at_phase[1] + located.amplitude_error + PeakSearch().tolerance
    amplitude += located.sampling_error[1]
    balance = resonance.balance
    q, w = located.motion.in_components(balance.components), 2 * np.pi * located.frequency
    jacobian = balance.residual_and_jacobian(q.ravel(), w)[1]()
    superharmonic = find_superharmonic(balance, jacobian, located.motion, located.frequency)
    of_inertia = inertia_error(resonance, located, left_out)
    return ConvergedPeak(sequence, (frequency, amplitude), superharmonic, of_inertia)


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
    method = LinearModes(jacobian=jacobian)
    response = solve_response(
        joint, forces, method, damping=damping, resonance=resonance, control=control
    )
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
    if peaks is None:
        peaks = find_converged_peaks(
            joint,
            forces,
            damping=damping,
            resonance=resonance,
            control=control,
            harmonics=harmonics,
            jacobian=method.jacobian,
        )
    most = max(harmonics.harmonics)
    highest = peaks["peak_harmonics"].fillna(most).to_numpy().astype(int)
    responses = []
    for force, number in zip(forces, highest, strict=True):
        logger.info("%g N: response with %d harmonics", force, number)
        elements = joint.contact.element_law
        law = AlternatingFrequencyTime(elements, **harmonics.sampling(int(number)))
        response = solve_response(
            replace(joint, law=law),
            [force],
            method,
            damping=damping,
            resonance=resonance,
            control=control,
        )
        responses.append(response)
    response = _concatenate(responses)
    numbers = quantity("force", highest, "1", "highest harmonic of the response")
    return add_converged_peaks(response.assign(response_harmonics=numbers), peaks)


def _concatenate(responses: Sequence[xr.Dataset]) -> xr.Dataset:
    """Responses to single forces as one dataset, with the components of all."""
    components = max((response["component"].to_numpy() for response in responses), key=len)
    whole = [response.reindex(component=components, fill_value=0.0) for response in responses]
    parts = []
    for dimension in ("solution", "force", "fold"):
        names = [name for name, values in whole[0].items() if dimension in values.dims]
        rows = [response[names] for response in whole]
        parts.append(xr.concat(rows, dimension, combine_attrs="override"))
    return xr.merge(parts).assign_attrs(whole[0].attrs)
