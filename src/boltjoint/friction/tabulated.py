"""Tabulated describing function of any number of friction elements on one contact point.

Elements under constant normal load on one point have its amplitude A in common, so their force is
one complex describing function of A, evaluated at the cost of one element. Its quadrature part, the
dissipation, has a closed form between the amplitudes at which elements begin to slip; its in-phase
part is interpolated.
"""

from dataclasses import dataclass
from functools import cached_property
from math import hypot, log, pi, sqrt
from typing import ClassVar

import numpy as np

from boltjoint.compiled import kept_loop
from boltjoint.friction.constant import ConstantLoad
from boltjoint.friction.declarations import TABULATED, LawDeclaration
from boltjoint.friction.forms import CompiledForm
from boltjoint.friction.protocol import Array, Elements, Kernel

#: tolerance of the interpolation, relative to the describing function; half or twice moves peaks by
#: less than 4e-8, as the tolerance of the solvers does
_TOLERANCE = 1e-7

#: amplitude, over that of full slip, above which a series in 1 / A replaces the table: its fourth
#: term, which is truncated, is 3e-9 of the describing function there, and half or twice moves peaks
#: by less than 3e-8
_FAR = 100.0

#: amplitudes at which elements begin to slip are one if their logarithms differ by less: rounding
_SAME = 1e-9


@dataclass(frozen=True)
class TabulatedLoad(ConstantLoad):
    """Friction elements under constant normal load with a tabulated describing function.

    Parameters, states and residual tractions are those of ``ConstantLoad``; forces differ by less
    than 1e-6 of their size and are exact in stick.
    """

    declaration: ClassVar[LawDeclaration] = TABULATED

    @cached_property
    def closed_form(self) -> CompiledForm:
        """The table of the describing function of each point."""
        return CompiledForm(Kernel(_add_forces, self.compiled_elements), self._states)

    @cached_property
    def compiled_elements(self) -> Elements:
        """The tables of the points.

        First knot of each point, and the end of the last; stiffness in stick and three terms of the
        series, by point; knots. A knot has the logarithm of its amplitude, in-phase stiffness and
        its slope by that logarithm, and the sums of slip force and of its square over k of the
        elements in slip.
        """
        points = self.point_of_element.max() + 1
        first, total = np.zeros(points + 1, dtype=np.int64), np.zeros(points)
        knots, far = [np.zeros((0, 5))], np.zeros((3, points))
        for p in range(points):
            on_point = self.point_of_element == p
            k, s = self.tangential_stiffness[on_point], self.slip_force[on_point]
            first[p + 1] = first[p]
            if k.size:
                knots.append(_tabulate(k, s))
                first[p + 1] += len(knots[-1])
                total[p] = k.sum()
                far[:, p] = [(k * (s / k) ** (n + 1.5)).sum() for n in range(3)]
        return Elements.of(first, [total, *far], np.concatenate(knots))


def _tabulate(k: Array, s: Array) -> Array:
    """Knots of the elements of one point, refined to the tolerance, shape (knots, 5)."""
    onset = np.sort(np.log(s / k))
    onset = onset[np.diff(onset, prepend=-np.inf) > _SAME]
    x = np.append(onset, onset[-1] + log(_FAR))
    value, slope, size = _in_phase(x, k, s)
    queue = np.arange(x.size - 1)
    while queue.size:
        width = x[queue + 1] - x[queue]
        coarse = np.zeros(queue.size, dtype=bool)
        for t in (0.25, 0.5, 0.75):
            exact = _in_phase(x[queue] + t * width, k, s)
            interpolated = (
                (1 + 2 * t) * (1 - t) ** 2 * value[queue]
                + t * t * (3 - 2 * t) * value[queue + 1]
                + t * (1 - t) * ((1 - t) * slope[queue] - t * slope[queue + 1]) * width
            )
            coarse |= np.abs(interpolated - exact[0]) > _TOLERANCE * exact[2]
            if t == 0.5:
                middle = exact
        at, new = queue[coarse] + 1, x[queue] + 0.5 * width
        x = np.insert(x, at, new[coarse])
        value, slope, size = (
            np.insert(knots, at, inserted[coarse])
            for knots, inserted in zip((value, slope, size), middle, strict=True)
        )
        halves = at - 1 + np.arange(at.size)
        queue = np.column_stack([halves, halves + 1]).ravel()
    by_onset = np.argsort(np.log(s / k), kind="stable")
    slips = np.searchsorted(np.log(s / k)[by_onset], x + _SAME, side="right")
    sums = [np.append(0.0, np.cumsum(summand[by_onset]))[slips] for summand in (s, s * s / k)]
    return np.column_stack([x, value, slope, *sums])


def _in_phase(x: Array, k: Array, s: Array) -> tuple[Array, Array, Array]:
    """In-phase stiffness at log amplitudes, its slope by them, and the describing function's size.

    Of each element ``k/pi (theta - sin theta cos theta)`` with the angle of ``friction.constant``.
    """
    ratio = np.minimum(np.exp(np.log(s / k) - x[:, None]), 1.0)
    sine = 2 * np.sqrt(ratio * (1 - ratio))
    theta = 2 * np.arctan2(np.sqrt(ratio), np.sqrt(1 - ratio))
    value = (theta - sine * (1 - 2 * ratio)) @ k / pi
    return value, -4 / pi * (ratio * sine) @ k, np.hypot(value, sine * sine @ k / pi)


@kept_loop
def _add_forces(elements: Elements, motion: Array, force: Array, tangent: Array) -> None:
    """Add the forces of all points, and the tangents where their array is not empty."""
    first, quantities, knots = elements
    total, far = quantities[0], quantities[1:]
    for p in range(total.size):
        s, c = motion[p, 0], motion[p, 1]
        amplitude = hypot(s, c)
        low, high = first[p], first[p + 1] - 1
        x = log(amplitude) if amplitude > 0.0 else -np.inf
        if low > high or x <= knots[low, 0]:
            real, imag, d_real, d_imag = total[p], 0.0, 0.0, 0.0
        else:
            at = high
            if x < knots[high, 0]:
                at = low
                while high - at > 1:
                    middle = (at + high) // 2
                    if knots[middle, 0] <= x:
                        at = middle
                    else:
                        high = middle
            # dissipation of the elements in slip: the sum of 4/pi (mu N / A - (mu N)^2 / (k A^2))
            once = 4.0 / pi * knots[at, 3] / amplitude
            twice = 4.0 / pi * knots[at, 4] / (amplitude * amplitude)
            imag, d_imag = once - twice, 2.0 * twice - once
            if at == first[p + 1] - 1:
                # k/pi (theta - sin theta cos theta) as a series in mu N / (k A)
                scale = 8.0 / (pi * amplitude * sqrt(amplitude))
                a = scale * far[0, p] * 2.0 / 3.0
                b = scale * far[1, p] / (5.0 * amplitude)
                e = scale * far[2, p] / (28.0 * amplitude * amplitude)
                real, d_real = a - b - e, -1.5 * a + 2.5 * b + 3.5 * e
            else:
                h = knots[at + 1, 0] - knots[at, 0]
                t = (x - knots[at, 0]) / h
                v_0, v_1 = knots[at, 1], knots[at + 1, 1]
                m_0, m_1 = h * knots[at, 2], h * knots[at + 1, 2]
                # cubic through values and slopes at both ends
                square = 3.0 * (v_1 - v_0) - 2.0 * m_0 - m_1
                cube = 2.0 * (v_0 - v_1) + m_0 + m_1
                real = v_0 + t * (m_0 + t * (square + t * cube))
                d_real = (m_0 + t * (2.0 * square + 3.0 * t * cube)) / h
        force[p, 0] += real * s - imag * c
        force[p, 1] += real * c + imag * s
        if tangent.size == 0:
            continue
        # as in friction.constant, with slopes by log A: dA / A = q . dq / A^2
        inverse = 1.0 / (amplitude * amplitude) if amplitude > 0.0 else 0.0
        g_s = (d_real * s - d_imag * c) * inverse
        g_c = (d_real * c + d_imag * s) * inverse
        tangent[p, 0, 0] += real + g_s * s
        tangent[p, 0, 1] += -imag + g_s * c
        tangent[p, 1, 0] += imag + g_c * s
        tangent[p, 1, 1] += real + g_c * c
