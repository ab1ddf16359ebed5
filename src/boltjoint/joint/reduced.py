"""Reduced joints: a few fitted elements, or a tabulated law, for the many of a region."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from boltjoint import checks
from boltjoint.dataset import quantities
from boltjoint.friction.element_law import ElementLaw
from boltjoint.friction.tabulated import TabulatedLoad
from boltjoint.joint.fit_jenkins import Fit, Method, check_fit_options, fit_elements
from boltjoint.joint.hysteresis import FitOptions, LoopError, loop_error, unloading_branch
from boltjoint.joint.model import Joint
from boltjoint.names import CONSTANT_NORMAL_LOAD, COULOMB_ELEMENTS

Array = NDArray[np.float64]


def fit_reduced_joint(
    joint: Joint,
    count: int,
    *,
    method: Method = "loops",
    load_fractions: Sequence[float] = (0.3, 0.6, 0.9),
    starts: int = 16,
    options: FitOptions = FitOptions(),
) -> tuple[Joint, xr.Dataset]:
    """Replace the elements of every region by ``count`` fitted ones.

    The loops are those of constant normal load under either law: elements without load in the
    assembled state take no part, and a region without load has no elements then.

    Parameters
    ----------
    joint
        A joint of regions.
    count, method, load_fractions, starts, options
        As for ``fit_elements``.

    Returns
    -------
    joint : Joint
        On the same points, with ``count`` elements each.
    fit : Dataset
        Cost, loop errors, amplitudes and the loops of region and fit, by point; not a number where
        a region has no load.

    Raises
    ------
    ValueError
        If a region has elements under load but fewer than ``count``, or as for ``fit_elements``.
    """
    law = check_capabilities(joint, COULOMB_ELEMENTS)
    count = checks.whole("count", count, at_least=1)
    fractions = check_fit_options(method, load_fractions, starts)
    checks.instance("options", options, FitOptions)
    fits, errors = [], []
    of_region: list[Array] = []
    of_fit: list[Array] = []
    displacement: list[Array] = []
    phase = np.linspace(0, np.pi, options.loop_samples)
    unknown = np.full((fractions.size, phase.size), np.nan)
    for point in range(joint.points):
        mine = (law.point_of_element == point) & (law.slip_force > 0)
        k, s = law.tangential_stiffness[mine], law.slip_force[mine]
        if not k.size:
            fits.append(Fit(k, s, unknown[:, 0], np.nan))
            errors.append(LoopError(np.nan, np.nan))
            for loops in (displacement, of_region, of_fit):
                loops.append(unknown)
            continue
        _refuse_few(k.size, count, point)
        fit = fit_elements(
            k,
            s,
            count,
            method=method,
            load_fractions=fractions.tolist(),
            starts=starts,
            options=options,
        )
        fits.append(fit)
        errors.append(loop_error(k, s, fit.tangential_stiffness, fit.slip_force, options))
        u = np.outer(fit.amplitude, np.cos(phase))
        displacement.append(u)
        of_region.append(_loops(fit.amplitude, u, k, s))
        of_fit.append(_loops(fit.amplitude, u, fit.tangential_stiffness, fit.slip_force))
    dataset = fit_dataset(
        cost=[f.cost for f in fits],
        error=errors,
        amplitude=[f.amplitude for f in fits],
        displacement=displacement,
        force_of_region=of_region,
        force_of_fit=of_fit,
        options=options,
    )
    return _with_elements(joint, fits), dataset


def _refuse_few(elements: int, count: int, point: int) -> None:
    if elements < count:
        raise ValueError(
            f"cannot fit {count} elements to region {point + 1}, which has {elements} under load: "
            "ask for fewer elements or fewer regions"
        )


def _with_elements(joint: Joint, fits: Sequence[Fit]) -> Joint:
    """The joint with the fitted elements of each point."""
    point_of_element = np.repeat(np.arange(joint.points), [f.slip_force.size for f in fits])
    fitted = joint.contact.element_law.replaced_by(
        point_of_element,
        np.concatenate([f.tangential_stiffness for f in fits]),
        np.concatenate([f.slip_force for f in fits]),
    )
    # elements of several laws stand in the order of these
    position = joint.position[fitted.point_of_element]
    return replace(joint, law=fitted, element_position=position)


def fit_dataset(
    *,
    cost: Sequence[float],
    error: Sequence[LoopError],
    amplitude: Sequence[Array],
    displacement: Sequence[Array],
    force_of_region: Sequence[Array],
    force_of_fit: Sequence[Array],
    options: FitOptions,
) -> xr.Dataset:
    """What is known of the fits of all regions, by point, as it stands in ``joint.nc``.

    Parameters
    ----------
    cost
        Cost of eq. 3.3 [N^2], minimised or not.
    error
        Error of the loops at all amplitudes.
    amplitude
        Amplitude of the compared loops [m], shape (loops,).
    displacement, force_of_region, force_of_fit
        Along their unloading branches [m], [N], shape (loops, samples).
    options
        With which they were fitted.
    """
    largest, rms = [e.largest for e in error], [e.rms for e in error]
    of_all, of_mean = "largest force difference of all loops", "mean force difference of loops"
    loop, over = ("point", "loop", "sample"), "over the slip force"
    rows = (
        ("fit_cost", "point", cost, "N2", "cost of eq. 3.3"),
        ("largest_loop_error", "point", largest, "1", f"{of_all} {over}"),
        ("rms_loop_error", "point", rms, "1", f"{of_mean} at all amplitudes {over}"),
        ("loop_amplitude", ("point", "loop"), amplitude, "m", "amplitude of a compared loop"),
        ("loop_displacement", loop, displacement, "m", "displacement along the unloading branch"),
        ("loop_force_of_region", loop, force_of_region, "N", "force of all elements of the region"),
        ("loop_force_of_fit", loop, force_of_fit, "N", "force of the fitted elements"),
    )
    return xr.Dataset(quantities(rows), attrs={"options": options.stored()})


def tabulate_joint(joint: Joint) -> Joint:
    """Joint of the same elements with tabulated forces: as fast as one element a point.

    Parameters
    ----------
    joint
        A joint of regions, or any other under constant normal load.

    Raises
    ------
    ValueError
        If the normal load varies: the force is then no function of one amplitude.
    """
    law = check_capabilities(joint, COULOMB_ELEMENTS, CONSTANT_NORMAL_LOAD)
    elements = law.point_of_element, law.tangential_stiffness, law.slip_force
    return replace(joint, law=TabulatedLoad(*elements))


def check_capabilities(joint: Joint, *needs: str) -> ElementLaw:
    """The law of a joint; refused where it lacks what a reduction needs (``names.Reduction``)."""
    law = checks.instance("joint", joint, Joint).contact.element_law
    declaration = law.declaration
    if missing := [need for need in needs if need not in declaration.capabilities]:
        raise ValueError(
            f"the law {declaration.name!r} of the joint cannot be reduced so: "
            f"that needs {' and '.join(missing)}"
        )
    return law


def _loops(amplitude: Array, displacement: Array, k: Array, s: Array) -> Array:
    """Force along the unloading branch of the loop of each amplitude."""
    loops = zip(amplitude, displacement, strict=True)
    return np.array([unloading_branch(a, u, k, s) for a, u in loops])
