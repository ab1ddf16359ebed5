"""How few elements show the hysteresis of many? Fitting reduced joints (section 3.1.1.4).

The elements of a region see one displacement, so their loops add up. A few elements are sought with
the same loops at three amplitudes, the same total stiffness and the same total slip force.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
import xarray as xr
from numpy.typing import NDArray
from scipy.optimize import least_squares
from scipy.special import softmax

from boltjoint.dataset import quantity
from boltjoint.joint import Joint

#: points along each loop at which forces are compared, evenly in phase over half a period
_SAMPLES = 64


@dataclass(frozen=True)
class Fit:
    """A few elements that stand for many.

    ``tangential_stiffness`` [N/m] and ``slip_force`` [N] have the shape (elements,), ``amplitude``
    [m] that of the loops compared; ``cost`` [N^2] is eq. 3.3.
    """

    tangential_stiffness: NDArray[np.float64]
    slip_force: NDArray[np.float64]
    amplitude: NDArray[np.float64]
    cost: float


def loading_curve(
    displacement: NDArray[np.float64],
    stiffness: NDArray[np.float64],
    slip_force: NDArray[np.float64],
) -> NDArray[np.float64]:
    """Force of elements in parallel on first loading by ``displacement`` [N], of its shape."""
    stuck = np.multiply.outer(displacement, stiffness)
    return np.minimum(stuck, slip_force).sum(axis=-1)


def unloading_branch(
    amplitude: float,
    displacement: NDArray[np.float64],
    stiffness: NDArray[np.float64],
    slip_force: NDArray[np.float64],
) -> NDArray[np.float64]:
    """Force on the way from ``amplitude`` down to ``displacement`` in the steady loop [N].

    Masing's rule: the branch is the loading curve, twice as large and turned around. The other half
    of the loop is the same with both signs changed.
    """
    top = loading_curve(np.array(amplitude), stiffness, slip_force)
    return top - 2 * loading_curve((amplitude - displacement) / 2, stiffness, slip_force)


def amplitude_of_load(
    fraction: float, stiffness: NDArray[np.float64], slip_force: NDArray[np.float64]
) -> float:
    """Displacement [m] at which first loading reaches a fraction of the total slip force."""
    corners = np.append(0.0, np.sort(slip_force / stiffness))
    load = loading_curve(corners, stiffness, slip_force)
    return float(np.interp(fraction * slip_force.sum(), load, corners))


def fit_elements(
    stiffness: NDArray[np.float64],
    slip_force: NDArray[np.float64],
    count: int,
    *,
    load_fractions: Sequence[float] = (0.3, 0.6, 0.9),
    starts: int = 16,
) -> Fit:
    """Find ``count`` elements with the hysteresis loops of many (eq. 3.3).

    Minimises the squared force difference over the loops at the amplitudes where the region
    carries ``load_fractions`` of its slip force, by least squares with the exact Jacobian.
    Stiffness and slip force are shares (softmax) of the region's totals, so the totals hold and
    every parameter is positive wherever the search goes.

    Parameters
    ----------
    stiffness, slip_force
        Of the elements of a region [N/m], [N], shape (many,).
    count
        Number of elements to fit.
    load_fractions
        One for each loop compared, between 0 and 1.
    starts
        Number of deterministic starts, of which the best result is taken.

    Returns
    -------
    Fit
        Elements in the order in which they start to slip.

    Raises
    ------
    ValueError
        If fewer than ``count`` elements are there to be replaced.
    """
    if not 1 <= count <= stiffness.size:
        raise ValueError(f"cannot fit {count} elements to the {stiffness.size} of a region")
    amplitude = np.array([amplitude_of_load(f, stiffness, slip_force) for f in load_fractions])
    loops = _Loops(stiffness, slip_force, amplitude)
    best = min(
        (
            least_squares(loops.residual, start, loops.jacobian, xtol=1e-12, ftol=1e-12, gtol=1e-12)
            for start in _starts(stiffness, slip_force, count, starts)
        ),
        key=lambda result: result.cost,
    )
    k, s = loops.elements(best.x)
    order = np.argsort(s / k, kind="stable")
    # both halves of a loop are compared in eq. 3.3, one is computed; scipy halves its cost
    cost = 2 * 2 * best.cost * slip_force.sum() ** 2
    return Fit(k[order], s[order], amplitude, float(cost))


def fit_reduced_joint(
    joint: Joint,
    count: int,
    *,
    load_fractions: Sequence[float] = (0.3, 0.6, 0.9),
    starts: int = 16,
) -> tuple[Joint, xr.Dataset]:
    """Replace the elements of every region by ``count`` fitted ones.

    Loops are those of constant normal load, whatever the law: elements that carry no load in the
    assembled state do not take part.

    Parameters
    ----------
    joint
        A joint of regions.
    count, load_fractions, starts
        As for ``fit_elements``.

    Raises
    ------
    ValueError
        If a region has fewer elements under load than ``count``.

    Returns
    -------
    joint : Joint
        On the same points, with ``count`` elements each.
    fit : Dataset
        Cost, amplitudes and the loops of region and fit, by point.
    """
    law = joint.law
    fits, of_region, of_fit, displacement = [], [], [], []
    phase = np.linspace(0, np.pi, _SAMPLES)
    for point in range(joint.points):
        mine = (law.point_of_element == point) & (law.slip_force > 0)
        k, s = law.tangential_stiffness[mine], law.slip_force[mine]
        if k.size < count:
            raise ValueError(
                f"cannot fit {count} elements to region {point + 1}, which has {k.size} under "
                "load: ask for fewer elements or fewer regions"
            )
        fit = fit_elements(k, s, count, load_fractions=load_fractions, starts=starts)
        fits.append(fit)
        u = np.outer(fit.amplitude, np.cos(phase))
        displacement.append(u)
        of_region.append(
            [unloading_branch(a, v, k, s) for a, v in zip(fit.amplitude, u, strict=True)]
        )
        of_fit.append(
            [
                unloading_branch(a, v, fit.tangential_stiffness, fit.slip_force)
                for a, v in zip(fit.amplitude, u, strict=True)
            ]
        )
    loop = ("point", "loop", "sample")
    dataset = xr.Dataset(
        {
            "fit_cost": quantity("point", [f.cost for f in fits], "N2", "cost of eq. 3.3"),
            "loop_amplitude": quantity(
                ("point", "loop"), [f.amplitude for f in fits], "m", "amplitude of a compared loop"
            ),
            "loop_displacement": quantity(
                loop, np.array(displacement), "m", "displacement along the unloading branch"
            ),
            "loop_force_of_region": quantity(
                loop, np.array(of_region), "N", "force of all elements of the region"
            ),
            "loop_force_of_fit": quantity(
                loop, np.array(of_fit), "N", "force of the fitted elements"
            ),
        }
    )
    point_of_element = np.repeat(np.arange(joint.points), count)
    reduced = replace(
        joint,
        law=law.replaced_by(
            point_of_element,
            np.concatenate([f.tangential_stiffness for f in fits]),
            np.concatenate([f.slip_force for f in fits]),
        ),
        element_position=joint.position[point_of_element],
    )
    return reduced, dataset


class _Loops:
    """Force differences between loops of a region and of a few elements, over the slip force."""

    def __init__(
        self,
        stiffness: NDArray[np.float64],
        slip_force: NDArray[np.float64],
        amplitude: NDArray[np.float64],
    ) -> None:
        self.total_stiffness, self.total_slip = stiffness.sum(), slip_force.sum()
        drop = np.outer(amplitude, 1 - np.cos(np.linspace(0, np.pi, _SAMPLES))) / 2
        # top of the loop less twice the loading curve over half the drop (Masing)
        self.displacement = np.concatenate([amplitude, drop.ravel()])
        top = np.repeat(np.arange(amplitude.size), _SAMPLES)
        self._combine = np.zeros((top.size, self.displacement.size))
        self._combine[np.arange(top.size), top] = 1.0
        self._combine[np.arange(top.size), amplitude.size + np.arange(top.size)] = -2.0
        self._target = self._combine @ loading_curve(self.displacement, stiffness, slip_force)

    def elements(
        self, unknown: NDArray[np.float64]
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Stiffness and slip force of the elements from the logarithms of their shares."""
        a, b = np.split(unknown, 2)
        return self.total_stiffness * softmax(a), self.total_slip * softmax(b)

    def residual(self, unknown: NDArray[np.float64]) -> NDArray[np.float64]:
        force = self._combine @ loading_curve(self.displacement, *self.elements(unknown))
        return (force - self._target) / self.total_slip

    def jacobian(self, unknown: NDArray[np.float64]) -> NDArray[np.float64]:
        k, s = self.elements(unknown)
        sticks = np.multiply.outer(self.displacement, k) < s
        by_k = np.where(sticks, self.displacement[:, None], 0.0)
        by_s = np.where(sticks, 0.0, 1.0)
        by_a = by_k * k - np.outer(by_k @ k, k) / self.total_stiffness
        by_b = by_s * s - np.outer(by_s @ s, s) / self.total_slip
        return self._combine @ np.hstack([by_a, by_b]) / self.total_slip


def _starts(
    stiffness: NDArray[np.float64], slip_force: NDArray[np.float64], count: int, starts: int
) -> Iterator[NDArray[np.float64]]:
    """Elements grouped in the order in which they slip, in ways that favour early or late ones."""
    order = np.argsort(slip_force / stiffness, kind="stable")
    rank = np.linspace(0, 1, stiffness.size, endpoint=False)
    for bias in np.linspace(0.5, 2.0, starts):
        group = np.floor(count * rank**bias).astype(np.int64)
        k = np.bincount(group, stiffness[order], minlength=count)
        s = np.bincount(group, slip_force[order], minlength=count)
        filled = np.where(k > 0, k, k.max() / stiffness.size), np.where(s > 0, s, s.max() / s.size)
        yield np.log(np.concatenate([filled[0] / k.sum(), filled[1] / s.sum()]))
