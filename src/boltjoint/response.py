"""How does the assembly respond? Frequency responses over force levels, and their peaks."""

import logging
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from boltjoint.backbone import Backbone, ModeAtAmplitude, rebuild
from boltjoint.balance import HarmonicBalance
from boltjoint.continuation import Path, StepControl, newton, trace
from boltjoint.coordinates import (
    ComplexModes,
    Jacobian,
    LinearModes,
    Loading,
    Renewal,
    ResponseDependentModes,
    pose,
)
from boltjoint.dataset import quantity
from boltjoint.friction import states
from boltjoint.joint import Joint

logger = logging.getLogger(__name__)

#: share of the window that counts, in arc length, as much as doubling the response
_WINDOW_SHARE = 1 / 15

#: share of a force under which little slips, so that a corrector finds the solution
_UNDER_LITTLE_FORCE = 1e-3

#: harmonic components that the result files begin with; further ones follow as they were solved for
_COMPONENTS = ("bias", "sin", "cos")


@dataclass(frozen=True)
class Branch:
    """The response at one force level, in linear modal coordinates.

    ``amplitude`` [m] is that of the first harmonic at the observed point; ``modal_coordinate`` has
    the shape (solutions, components * modes); frequencies are in Hz; ``located`` marks local maxima
    that were solved for.
    """

    force: float
    frequency: NDArray[np.float64]
    modal_coordinate: NDArray[np.float64]
    amplitude: NDArray[np.float64]
    iterations: NDArray[np.int64]
    converged: NDArray[np.bool_]
    located: NDArray[np.bool_]
    complete: bool
    reason: str

    @property
    def peak(self) -> int | None:
        """Index of the largest maximum that was located; None if the branch shows none."""
        if not self.located.any():
            return None
        return int(np.argmax(np.where(self.located, self.amplitude, -1.0)))


def frequency_window(
    *joints: Joint, resonance: int = 1, given: tuple[float, float] | None = None
) -> tuple[float, float]:
    """Frequencies to follow a resonance through: from 0.85 of the contact-free one to 1.05 stuck.

    Parameters
    ----------
    *joints
        One joint, or several on the same structure whose responses are to be compared: their
        windows together.
    resonance
        Which natural frequency, counted from 1.
    given
        A window [Hz] to take instead, if the resonance can lie in it.

    Returns
    -------
    tuple of float
        Lowest and highest frequency [Hz].

    Raises
    ------
    ValueError
        If the structure has fewer modes, or the resonance lies outside the window given, however
        much of the contact slips.
    """
    lowest, highest = np.inf, 0.0
    for joint in joints:
        if not 1 <= resonance <= joint.natural_frequency.size:
            raise ValueError(f"resonance {resonance} of {joint.natural_frequency.size} modes")
        stuck = np.diag((2 * np.pi * joint.natural_frequency) ** 2) + joint.stuck_stiffness()
        frequency = np.sqrt(np.linalg.eigvalsh(stuck)[resonance - 1]) / (2 * np.pi)
        highest = max(highest, float(frequency))
        lowest = min(lowest, float(np.sort(joint.natural_frequency)[resonance - 1]))
    if given is None:
        return 0.85 * lowest, 1.05 * highest
    if given[1] < lowest or given[0] > highest:
        raise ValueError(
            f"the window from {given[0]:g} to {given[1]:g} Hz contains no resonance {resonance}: "
            f"it lies between {lowest:.5g} Hz without contact and {highest:.5g} Hz stuck"
        )
    return given


def solve_branch(
    joint: Joint,
    force: float,
    *,
    loss_factor: float,
    window: tuple[float, float] | None = None,
    coordinates: str = "linear",
    resonance: int = 1,
    jacobian: Jacobian = "analytic",
    renewal: Renewal = "within",
    static_share: bool = True,
    control: StepControl | None = None,
    start: NDArray[np.float64] | None = None,
) -> Branch:
    """Frequency response of a joint at one force level, by harmonic balance and arc length.

    The path starts from the stuck linear solution at the lower end of the window, or, where that is
    too far from the solution, from one to which the force was raised. Local maxima of the response
    are located, not only sampled.

    Parameters
    ----------
    joint
        The joint and its structure.
    force
        Amplitude of the excitation [N].
    loss_factor
        Structural damping eta [-].
    window
        Lowest and highest frequency [Hz]; by default ``frequency_window`` of the resonance.
    coordinates
        As for ``coordinates.pose``; or ``backbone``, to rebuild the response from the joint's mode
        at given amplitudes.
    resonance
        Which resonance is followed, from 1: it sets the window and the mode ``rdnm-N`` must hold.
    jacobian
        ``analytic`` or ``forward-difference``.
    renewal, static_share
        Of response-dependent modes, as for ``coordinates.pose``.
    control
        Tolerance and step lengths.
    start
        A guess of the modal coordinates at the lower end of the window, shape (components *
        modes,), as ``Branch`` holds them, so that the window may lie close around a peak: steps are
        as long as in the default window, however narrow it is. Not for ``backbone``.

    Raises
    ------
    ValueError
        If a start is given for ``backbone``.
    """
    control = control or StepControl()
    window = window or frequency_window(joint, resonance=resonance)
    if coordinates == "backbone":
        if start is not None:
            raise ValueError("a response rebuilt from the backbone has no start")
        return _rebuilt(joint, force, loss_factor, window, resonance, control)
    balance = HarmonicBalance(joint, loss_factor, force)
    equations = pose(coordinates, balance, resonance, jacobian, renewal, static_share)
    low, high = (2 * np.pi * f for f in window)
    if start is None:
        start, width = _start(equations, balance, low, control), high - low
    else:
        whole = frequency_window(joint, resonance=resonance)
        start, width = equations.from_fixed(start), 2 * np.pi * (whole[1] - whole[0])
    observe = _Observed(balance)

    def amplitude_slope(x: NDArray[np.float64], dx: NDArray[np.float64]) -> float:
        at, along = observe(equations.to_fixed(x)), observe(equations.change_to_fixed(dx))
        return float((at.conjugate() * along).real)

    path = trace(
        equations,
        start,
        (low, high),
        control,
        scale=_WINDOW_SHARE * width,
        event=amplitude_slope,
    )
    return _branch(force, path, observe)


def solve_response(
    joint: Joint,
    forces: Sequence[float],
    *,
    loss_factor: float,
    window: tuple[float, float] | None = None,
    coordinates: str = "linear",
    resonance: int = 1,
    jacobian: Jacobian = "analytic",
    renewal: Renewal = "within",
    static_share: bool = True,
    control: StepControl | None = None,
) -> xr.Dataset:
    """Frequency responses at several force levels, as the result files keep them.

    Parameters
    ----------
    joint, loss_factor, window, coordinates, resonance, jacobian, renewal, static_share, control
        As for ``solve_branch``.
    forces
        Amplitudes of the excitation [N].

    Returns
    -------
    Dataset
        ``response.nc``: all solutions one after another, and by force level the peak (NaN where
        the branch shows none), whether the branch is complete, and the contact states at the peak.
    """
    window = window or frequency_window(joint, resonance=resonance)
    branches = []
    for force in forces:
        branch = solve_branch(
            joint,
            force,
            loss_factor=loss_factor,
            window=window,
            coordinates=coordinates,
            resonance=resonance,
            jacobian=jacobian,
            renewal=renewal,
            static_share=static_share,
            control=control,
        )
        branches.append(branch)
        logger.info(
            "%g N: %d solutions, %s, %s",
            force,
            branch.frequency.size,
            "no peak"
            if branch.peak is None
            else f"peak {branch.amplitude[branch.peak]:.4g} m "
            f"at {branch.frequency[branch.peak]:.2f} Hz",
            "complete" if branch.complete else branch.reason,
        )
    return to_dataset(joint, branches, loss_factor).assign_attrs(
        coordinates=coordinates,
        resonance=resonance,
        jacobian=jacobian,
        window_Hz=window,
    )


def to_dataset(joint: Joint, branches: Sequence[Branch], loss_factor: float) -> xr.Dataset:
    """Branches of one joint over force levels as ``response.nc`` holds them."""
    solved = joint.law.components
    components = (*_COMPONENTS, *(name for name in solved if name not in _COMPONENTS))
    modes = joint.natural_frequency.size
    coordinates, states_at_peak, unbalanced = [], [], []
    for branch in branches:
        balance = HarmonicBalance(joint, loss_factor, branch.force)
        unbalanced += [_energy_error(balance, x) for x in branch.modal_coordinate]
        found = branch.modal_coordinate.reshape(-1, len(solved), modes)
        full = np.zeros((len(found), modes, len(components)))
        full[:, :, [components.index(name) for name in solved]] = found.transpose(0, 2, 1)
        coordinates.append(full)
        elements = joint.law.point_of_element.size
        at_peak = np.full(elements, states.UNKNOWN, dtype=np.int8)
        if branch.peak is not None:
            motion = balance.motion(found[branch.peak])
            at_peak = joint.law.contact_state(motion)
        states_at_peak.append(at_peak)

    def along(name: str) -> NDArray:
        return np.concatenate([getattr(branch, name) for branch in branches])

    def of_peak(name: str) -> list[float]:
        return [
            np.nan if branch.peak is None else getattr(branch, name)[branch.peak]
            for branch in branches
        ]

    force = [branch.force for branch in branches]
    count = [branch.frequency.size for branch in branches]
    excitation = np.repeat(force, count)
    return xr.Dataset(
        {
            "excitation_force": quantity("solution", excitation, "N", "excitation amplitude"),
            "frequency": quantity("solution", along("frequency"), "Hz", "excitation frequency"),
            "modal_coordinate": quantity(
                ("solution", "mode", "component"),
                np.concatenate(coordinates),
                "kg^1/2 m",
                "amplitude of the linear modes",
            ),
            "response_amplitude": quantity(
                "solution",
                along("amplitude"),
                "m",
                "first-harmonic amplitude of the observed point",
            ),
            "iterations": quantity("solution", along("iterations"), "1", "corrections"),
            "converged": quantity(
                "solution", along("converged").astype(np.int8), "1", "1 where the equations hold"
            ),
            "energy_error": quantity(
                "solution",
                unbalanced,
                "1",
                "work of the excitation less structural loss and friction, over the larger side",
            ),
            "force_level": quantity("force", force, "N", "excitation amplitude"),
            "peak_frequency": quantity(
                "force", of_peak("frequency"), "Hz", "frequency of the largest maximum"
            ),
            "peak_amplitude": quantity(
                "force", of_peak("amplitude"), "m", "largest maximum of the response amplitude"
            ),
            "complete": quantity(
                "force",
                np.array([branch.complete for branch in branches], dtype=np.int8),
                "1",
                "1 where the branch crosses the whole window",
            ),
            "reason": quantity(
                "force", [branch.reason for branch in branches], "1", "why a branch broke off"
            ),
            "contact_state": xr.Variable(
                ("force", "element"),
                np.array(states_at_peak),
                {
                    "units": "1",
                    "long_name": "contact state at the peak, -1 where the branch shows none",
                    "flag_values": np.arange(len(states.MEANINGS), dtype=np.int8),
                    "flag_meanings": " ".join(m.replace(" ", "_") for m in states.MEANINGS),
                },
            ),
        },
        coords={"component": list(components)},
        attrs={"loss_factor": loss_factor},
    )


def _energy_error(balance: HarmonicBalance, x: NDArray[np.float64]) -> float:
    driven, lost, rubbed = balance.works(x)
    return (driven - lost - rubbed) / max(abs(driven), abs(lost + rubbed))


def _start(
    equations: LinearModes, balance: HarmonicBalance, w: float, control: StepControl
) -> NDArray[np.float64]:
    """Where a path may begin: the stuck linear solution, or what it becomes as the force grows."""
    start = equations.from_fixed(balance.stuck_solution(w))
    # modes that lag behind cannot be followed while they are far from those of the solution
    settles = isinstance(equations, ResponseDependentModes | ComplexModes)
    if settles or newton(equations, start, w, control)[0].converged:
        return start
    begin = np.log(_UNDER_LITTLE_FORCE)
    loading = Loading(equations, w)
    grown = trace(loading, _UNDER_LITTLE_FORCE * start, (begin, 0.0), control, scale=1.0)
    return grown.solutions[-1].x


def _rebuilt(
    joint: Joint,
    force: float,
    loss_factor: float,
    window: tuple[float, float],
    resonance: int,
    control: StepControl,
) -> Branch:
    mode = ModeAtAmplitude(joint, loss_factor, resonance)
    found = rebuild(Backbone(mode, mode.amplitudes_for([force], window), control), force, window)
    count, observe = found.frequency.size, _Observed(mode.balance)
    return Branch(
        force=force,
        frequency=found.frequency,
        modal_coordinate=found.modal_coordinate,
        amplitude=np.array([abs(observe(row)) for row in found.modal_coordinate]),
        iterations=np.zeros(count, dtype=np.int64),
        converged=np.ones(count, dtype=bool),
        located=np.arange(count) == (-1 if found.peak is None else found.peak),
        complete=found.complete,
        reason=found.reason,
    )


def _branch(force: float, path: Path, observe: "_Observed") -> Branch:
    x = np.array([solution.x for solution in path.solutions])
    return Branch(
        force=force,
        frequency=np.array([solution.p for solution in path.solutions]) / (2 * np.pi),
        modal_coordinate=x,
        amplitude=np.array([abs(observe(row)) for row in x]),
        iterations=np.array([solution.iterations for solution in path.solutions]),
        converged=np.array([solution.converged for solution in path.solutions]),
        located=np.array([solution.located for solution in path.solutions]),
        complete=path.complete,
        reason=path.reason,
    )


class _Observed:
    """Complex first-harmonic amplitude of the observed point [m] from modal coordinates."""

    def __init__(self, balance: HarmonicBalance) -> None:
        self._mode = balance.joint.response_mode
        self._sin, self._cos = (balance.components.index(name) for name in ("sin", "cos"))

    def __call__(self, q: NDArray[np.float64]) -> complex:
        amplitude = q.reshape(-1, self._mode.size) @ self._mode
        return complex(amplitude[self._sin], amplitude[self._cos])
