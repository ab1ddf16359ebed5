"""Convergence of forces over time samples, and of peaks over vectors and regions."""

import logging
from collections.abc import Mapping, Sequence
from typing import get_args

import numpy as np
import pandas as pd
import xarray as xr

from boltjoint import checks
from boltjoint.damping import Damping, as_damping
from boltjoint.dynamics.backbone.backbone import Backbone, trace_for_forces
from boltjoint.dynamics.backbone.modal_synthesis import synthesise_response
from boltjoint.dynamics.balance.periodic_motion import motion_at_peak
from boltjoint.dynamics.response.frequency_response import Branch, solve_branch
from boltjoint.dynamics.response.methods import LinearModes, Problem
from boltjoint.dynamics.response.windows import Resonance, frequency_window
from boltjoint.friction.aft import AlternatingFrequencyTime
from boltjoint.joint.model import Joint
from boltjoint.joint.partition import Division, Motion, partition_regions, region_error
from boltjoint.names import Basis
from boltjoint.solvers.step_control import StepControl
from boltjoint.structure.patterns import resonances_in
from boltjoint.study.timing import Timed

logger = logging.getLogger(__name__)

#: amplitude of the modal coordinates, over that at the peak, at the ends of the window of a peak;
#: the next where the window does not hold the peak: the maximum located is the same in each
_AROUND_PEAK = (0.9, 0.6, 0.3)


def tabulate_sampling(
    solved: Mapping[str, tuple[Joint, xr.Dataset]],
    samples: Sequence[int] = (64, 128, 256, 512, 1024),
) -> pd.DataFrame:
    """Error of forces by AFT against the closed form, at the largest response to each force.

    Parameters
    ----------
    solved
        Joint and ``response.nc`` of each case by its name, solved with the closed form.
    samples
        Samples a period.

    Returns
    -------
    DataFrame
        Columns ``case, law, samples, force_N, error_relative``: the error of the forces on all
        points in the Euclidean norm, relative to the closed form.

    Raises
    ------
    ValueError
        If there are too few samples for a harmonic, or the forces are those of AFT already.
    """
    checks.mapping("solved", solved)
    samples = checks.indices("samples", samples, ("counts",)).tolist()
    for count in samples:
        checks.whole("samples", count, at_least=3)
    rows = []
    for case, (joint, response) in solved.items():
        for force, motion in _largest_motions(joint, response).items():
            exact = joint.law.force(motion)
            for count in samples:
                elements = joint.contact.element_law
                sampled = AlternatingFrequencyTime(elements, samples=count).force(motion)
                rows.append(
                    {
                        "case": case,
                        "law": joint.law.name,
                        "samples": count,
                        "force_N": force,
                        "error_relative": np.linalg.norm(sampled - exact) / np.linalg.norm(exact),
                    }
                )
    return pd.DataFrame(rows, columns=["case", "law", "samples", "force_N", "error_relative"])


def _largest_motions(joint: Joint, response: xr.Dataset) -> dict[float, np.ndarray]:
    """Motion of the contact points where the response to each force is largest, by force."""
    motions = {}
    for force in response["force_level"].to_numpy():
        if largest := motion_at_peak(response, force):
            q = largest[1].in_components(joint.law.components).T
            motions[float(force)] = np.hstack([row @ q for row in joint.rows])
    return motions


def peaks_near(
    joint: Joint,
    forces: Sequence[float],
    damping: Damping | float,
    resonance: int = 1,
    control: StepControl | None = None,
) -> pd.DataFrame:
    """Peaks of the response, each in a narrow window that modal synthesis predicts.

    Nonlinear modal synthesis from the joint's backbone gives the window; the solutions in it are
    those of ``solve_branch`` in linear modes, and so is the maximum located among them. Where the
    synthesis has no peak, or the response none in the window, the whole response is followed.

    Parameters
    ----------
    joint, resonance, control
        As for ``solve_branch``.
    damping
        Damping of the structure; a number is a loss factor.
    forces
        Amplitudes of the excitation [N].

    Returns
    -------
    DataFrame
        Columns ``force_N, peak_frequency_Hz, peak_mm_per_N``, by force; NaN where the response
        shows no peak.

    Raises
    ------
    ValueError
        As for ``solve_branch``.
    """
    forces = checks.levels("forces", forces)
    checks.instance("joint", joint, Joint)
    damping = as_damping(damping)
    window = frequency_window(joint, resonance=resonance)
    backbone = trace_for_forces(
        joint, forces, window=window, damping=damping, resonance=resonance, control=control
    )
    rows = []
    for force in forces:
        branch = _near_peak(backbone, force, window, resonance, control)
        if branch is None:
            logger.info("%g N: no peak in the window predicted from the backbone", force)
            around = Resonance(resonance, window)
            branch = solve_branch(joint, force, damping=damping, resonance=around, control=control)
        row = {"force_N": force, "peak_frequency_Hz": np.nan, "peak_mm_per_N": np.nan}
        if branch.peak is not None:
            row["peak_frequency_Hz"] = branch.frequency[branch.peak]
            row["peak_mm_per_N"] = 1e3 * branch.amplitude[branch.peak] / force
        rows.append(row)
    return pd.DataFrame(rows)


def tabulate_basis_peaks(peaks: Mapping[str, pd.DataFrame]) -> pd.DataFrame:
    """Peaks of the same joint in several bases, against those in the last of them.

    Parameters
    ----------
    peaks
        As from ``peaks_near``, of the same forces, by the name of the basis, the largest last.

    Returns
    -------
    DataFrame
        Columns ``basis, vectors, force_N, peak_frequency_Hz, peak_mm_per_N,
        peak_frequency_error_percent, peak_amplitude_error_percent``.
    """
    table = pd.concat(peaks, names=["basis"]).reset_index(level="basis")
    table.insert(1, "vectors", [Basis(basis).vectors for basis in table["basis"]])
    return _against(table, peaks[list(peaks)[-1]])


def tabulate_divisions(
    joint: Joint,
    preload: xr.Dataset,
    counts: Sequence[int],
    reference: pd.DataFrame,
    damping: Damping | float,
    division: Division = "equal-load",
    control: StepControl | None = None,
) -> pd.DataFrame:
    """Peaks of a joint's regions against those of its pairs, for several divisions.

    Bands of the division given, with the displacement of a region as the mean of its pairs, as the
    load-weighted mean, and as a straight line; bands divided across the width; and clusters.

    Parameters
    ----------
    joint, preload
        Node-to-node joint and the contact it was made from.
    counts
        Numbers of regions; one that a division cannot have is left out.
    reference
        Peaks of the joint, as from ``peaks_near``: the forces are its own.
    damping, control
        As for ``peaks_near``.
    division
        As for ``partition.partition_regions``.

    Returns
    -------
    DataFrame
        Columns ``division, motion, regions, region_error_percent, force_N, peak_frequency_Hz,
        peak_mm_per_N, peak_frequency_error_percent, peak_amplitude_error_percent``.

    Raises
    ------
    ValueError
        If the division is not known, no division has such a number of regions, or as for
        ``peaks_near``.
    """
    checks.instance("joint", joint, Joint)
    checks.choice("division", division, get_args(Division))
    checks.instance("reference", reference, pd.DataFrame)
    if missing := {"force_N", "peak_frequency_Hz", "peak_mm_per_N"}.difference(reference):
        raise ValueError(f"reference has no column {', '.join(sorted(missing))}")
    counts = checks.indices("counts", counts, ("divisions",)).tolist()
    for count in counts:
        checks.whole("counts", count, at_least=1)
    parts = []
    divisions: list[tuple[Division, Motion]] = [
        (division, "mean"),
        (division, "load-weighted"),
        (division, "linear"),
        ("inner-outer", "mean"),
        ("clusters", "mean"),
    ]
    for how, motion in divisions:
        for count in counts:
            try:
                regions = partition_regions(joint, preload, count, how, motion)
            except ValueError as error:
                logger.info("%s, %s: %s", how, motion, error)
                continue
            made = {
                "division": how,
                "motion": motion,
                "regions": count,
                "region_error_percent": 100 * region_error(joint, regions),
            }
            peaks = peaks_near(regions, reference["force_N"], damping, control=control)
            parts.append(pd.DataFrame({**made, **peaks}))
    if not parts:
        raise ValueError(f"counts are {counts}: no division has as many regions")
    return _against(pd.concat(parts), reference)


def tabulate_reductions(
    joints: Mapping[str, Joint],
    forces: Sequence[float],
    damping: Damping | float,
    control: StepControl | None = None,
) -> pd.DataFrame:
    """Peaks of reduced joints against those of the joint they stand for, and the time they take.

    Responses are those of ``solve_branch`` in linear modes in one window, on one thread.

    Parameters
    ----------
    joints
        By name, first the joint that the others stand for.
    forces, damping, control
        As for ``peaks_near``.

    Returns
    -------
    DataFrame
        Columns ``joint, points, elements, cpu_s``, the processor time of the response, ``complete,
        force_N, peak_frequency_Hz, peak_mm_per_N, peak_frequency_error_percent,
        peak_amplitude_error_percent``; NaN without a peak.

    Raises
    ------
    ValueError
        If there is no joint, or as for ``solve_branch``.
    """
    forces = checks.levels("forces", forces)
    checks.mapping("joints", joints)
    for name, joint in joints.items():
        checks.instance(f"joints[{name!r}]", joint, Joint)
    if not joints:
        raise ValueError("joints is empty: the first is the one that the others stand for")
    first = next(iter(joints.values()))
    around = Resonance(1, frequency_window(first))
    rows = []
    for name, joint in joints.items():
        of_joint = {
            "joint": name,
            "points": joint.points,
            "elements": joint.law.point_of_element.size,
        }
        problem = Problem.of(joint, as_damping(damping), around, control)
        timed = Timed.of(LinearModes()).prepared(problem, forces)
        for force in forces:
            branch = timed.solve(problem, force)
            cpu = timed.rows[-1]["cpu_s"]
            row = {**of_joint, "cpu_s": cpu, "complete": branch.complete, "force_N": force}
            row |= {"peak_frequency_Hz": np.nan, "peak_mm_per_N": np.nan}
            if branch.peak is not None:
                row["peak_frequency_Hz"] = branch.frequency[branch.peak]
                row["peak_mm_per_N"] = 1e3 * branch.amplitude[branch.peak] / force
            rows.append(row)
    table = pd.DataFrame(rows)
    return _against(table, table[table["joint"] == next(iter(joints))])


def _against(table: pd.DataFrame, reference: pd.DataFrame) -> pd.DataFrame:
    """The table with the errors of its peaks [%] against those at the same forces."""
    expected = reference.set_index("force_N").loc[table["force_N"]]
    for what, of_peak in (("frequency", "peak_frequency_Hz"), ("amplitude", "peak_mm_per_N")):
        ratio = table[of_peak].to_numpy() / expected[of_peak].to_numpy()
        table[f"peak_{what}_error_percent"] = 100 * (ratio - 1)
    return table.reset_index(drop=True)


def tabulate_patterns(modes: Mapping[str, xr.Dataset], patterns: xr.Dataset) -> pd.DataFrame:
    """Resonances of bases while parts of the contact stick, against those of the full model.

    Parameters
    ----------
    modes
        ``modes.nc`` by the name of the basis.
    patterns
        As from ``structure.patterns.resonances``, for the same pairs.

    Returns
    -------
    DataFrame
        Columns ``basis, vectors, springs, pattern, resonance`` (from 1), ``frequency_Hz,
        error_percent``.
    """
    rows = []
    for basis, of_basis in modes.items():
        resonances = resonances_in(of_basis, patterns)
        for pattern in resonances["pattern"].to_numpy():
            for springs in resonances["springs"].to_numpy():
                at = resonances.sel(pattern=pattern, springs=springs)
                for i, (frequency, error) in enumerate(
                    zip(at["frequency"].to_numpy(), at["error"].to_numpy(), strict=True)
                ):
                    rows.append(
                        {
                            "basis": basis,
                            "vectors": of_basis.sizes["mode"],
                            "springs": springs,
                            "pattern": pattern,
                            "resonance": i + 1,
                            "frequency_Hz": frequency,
                            "error_percent": 100 * error,
                        }
                    )
    return pd.DataFrame(rows)


def _near_peak(
    backbone: Backbone,
    force: float,
    window: tuple[float, float],
    resonance: int,
    control: StepControl | None,
) -> Branch | None:
    """The response in a window around the predicted peak; None where the peak is not in it."""
    predicted = synthesise_response(backbone, force, window)
    if predicted.peak is None:
        return None
    balance = backbone.equations.balance
    size = np.linalg.norm(predicted.modal_coordinate, axis=1)
    for share in _AROUND_PEAK:
        outside = np.flatnonzero(size <= share * size[predicted.peak])
        before, after = outside[outside < predicted.peak], outside[outside > predicted.peak]
        if not (before.size and after.size):
            return None
        first, last = before[-1], after[0]
        if not predicted.frequency[first] < predicted.frequency[last]:
            return None
        branch = solve_branch(
            balance.joint,
            force,
            damping=balance.damping,
            resonance=Resonance(resonance, (predicted.frequency[first], predicted.frequency[last])),
            control=control,
            start=predicted.modal_coordinate[first],
        )
        if branch.complete and branch.peak is not None:
            return branch
    return None
