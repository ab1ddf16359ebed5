"""Compiled loops of friction under variable normal load: transitions, moments and tangents."""

from math import acos, atan2, cos, pi, sin, sqrt

import numpy as np
from numba import njit
from numpy.typing import NDArray

from boltjoint.friction.contact_states import SEPARATION, STICK, STICK_SLIP, STICK_SLIP_SEPARATION

Array = NDArray[np.float64]


#: The steady period of an element is divided by marks, of which each has a phase with its sine and
#: cosine. The piece that begins at a mark either slips, in the direction +1 or -1, or sticks with
#: ``z = x(zeta) + kappa n(zeta)``. Here zeta is the phase, given by sine and cosine, at which the
#: slider came to rest on the bound of kappa = -mu or +mu, or at which the surfaces met; and held is
#: 0 for a slider that never left z = 0.
_PHASE, _SIN, _COS, _SLIP, _HELD, _SIN_ZETA, _COS_ZETA, _KAPPA = range(8)


#: the matrices A, B, C of an element: friction ``A x + B n``, normal load ``C n``
_OF_X, _OF_N, _OF_LOAD = range(3)


#: more marks than a period can have
_MOST_MARKS = 10


@njit(cache=True)
def _mark(marks: Array, i: int, phase: float, sine: float, cosine: float) -> None:
    marks[i, _PHASE], marks[i, _SIN], marks[i, _COS] = phase, sine, cosine


@njit(cache=True)
def _slip(marks: Array, i: int, direction: int) -> None:
    marks[i, _SLIP] = direction


@njit(cache=True)
def _stick(marks: Array, i: int, held: float, sine: float, cosine: float, kappa: float) -> None:
    marks[i, _SLIP], marks[i, _HELD] = 0.0, held
    marks[i, _SIN_ZETA], marks[i, _COS_ZETA], marks[i, _KAPPA] = sine, cosine, kappa


@njit(cache=True)
def _ahead(phase: float, now: float, most: float) -> float:
    """How far a phase is ahead of another; one that rounding left behind it is no way ahead.

    The true answer is from 0 to ``most``, which is a period at most.
    """
    ahead = (phase - now) % (2 * pi)
    return 0.0 if ahead > 0.5 * most + pi else min(ahead, most)


@njit(cache=True)
def _cosine(level: float, amplitude: float) -> float:
    """Cosine of the phase, counted from its top, at which a sinusoid passes a level.

    That of the top or bottom where the level is beyond.
    """
    if abs(level) < amplitude:
        return level / amplitude
    return 1.0 if level > 0 else -1.0


@njit(cache=True)
def _sine(cosine: float) -> float:
    """Sine to a cosine, of phases up to half a period; also next to 0 as exact as the phase."""
    return sqrt((1 - cosine) * (1 + cosine))


@njit(cache=True)
def _inverse(amplitude: float) -> float:
    """One over it, or 0: what does not move is as high at every phase as in the mean."""
    return 1 / amplitude if amplitude > 0 else 0.0


@njit(cache=True)
def _divide_period(x: Array, n: Array, mu: float, marks: Array) -> tuple[int, int]:
    """Divide the steady period of an element at its transitions; number of pieces, and its state.

    ``x = k_u u`` and ``n = n0 + k_v v`` hold bias, sine and cosine. Phases of separation are left
    out. An element that never leaves its place has one piece and no marks around it.
    """
    swing = sqrt(n[1] * n[1] + n[2] * n[2])
    if n[0] <= -swing:
        return 0, SEPARATION
    # the bounds k_u u - mu n and k_u u + mu n swing by a_l and a_u around l_0 and u_0
    l_0, l_s, l_c = x[0] - mu * n[0], x[1] - mu * n[1], x[2] - mu * n[2]
    u_0, u_s, u_c = x[0] + mu * n[0], x[1] + mu * n[1], x[2] + mu * n[2]
    a_l, a_u = sqrt(l_s * l_s + l_c * l_c), sqrt(u_s * u_s + u_c * u_c)
    if n[0] < swing:
        return _divide_with_separation(
            x, n, mu, swing, (l_0, l_s, l_c, a_l), (u_0, u_s, u_c, a_u), marks
        )
    highest, lowest = l_0 + a_l, u_0 - a_u
    of_l, of_u = _inverse(a_l), _inverse(a_u)
    l_s, l_c, u_s, u_c = l_s * of_l, l_c * of_l, u_s * of_u, u_c * of_u
    if highest <= lowest or of_l == 0 or of_u == 0:  # there is room for a slider at rest
        if highest > 0:
            _stick(marks, 0, 1.0, l_s, l_c, -mu)
        elif lowest < 0:
            _stick(marks, 0, 1.0, -u_s, -u_c, mu)
        else:
            _stick(marks, 0, 0.0, 0.0, 0.0, 0.0)
        return 1, STICK
    # pushed up to where one bound is highest, left there until the other comes down, and back
    cos_fall, cos_rise = _cosine(highest - u_0, a_u), _cosine(lowest - l_0, a_l)
    sin_fall, sin_rise = _sine(cos_fall), _sine(cos_rise)
    fall, rise = acos(cos_fall), acos(cos_rise)
    between = atan2(u_s * l_c - u_c * l_s, u_s * l_s + u_c * l_c)
    stuck = pi - rise + fall
    above = _ahead(between + fall, 0.0, stuck)
    below = stuck - above
    _mark(marks, 0, 0.0, l_s, l_c)
    _stick(marks, 0, 1.0, l_s, l_c, -mu)
    _mark(
        marks,
        1,
        above,
        u_s * cos_fall + u_c * sin_fall,
        u_c * cos_fall - u_s * sin_fall,
    )
    _slip(marks, 1, -1)
    _mark(marks, 2, above + pi - fall, -u_s, -u_c)
    _stick(marks, 2, 1.0, -u_s, -u_c, mu)
    _mark(
        marks,
        3,
        above + pi - fall + below,
        l_s * cos_rise - l_c * sin_rise,
        l_c * cos_rise + l_s * sin_rise,
    )
    _slip(marks, 3, 1)
    _mark(marks, 4, above + pi - fall + below + rise, l_s, l_c)
    return 4, STICK_SLIP


@njit(cache=True)
def _divide_with_separation(
    x: Array,
    n: Array,
    mu: float,
    swing: float,
    lower: tuple[float, float, float, float],
    upper: tuple[float, float, float, float],
    marks: Array,
) -> tuple[int, int]:
    """The same for an element that separates within the period."""
    l_0, l_s, l_c, a_l = lower
    u_0, u_s, u_c, a_u = upper
    phi_l, phi_u = atan2(l_s, l_c), atan2(u_s, u_c)
    half = acos(-n[0] / swing)
    meet, span = atan2(n[1], n[2]) - half, 2 * half
    sin_zeta, cos_zeta = sin(meet), cos(meet)
    _mark(marks, 0, meet, sin_zeta, cos_zeta)
    # Where the surfaces meet, mu n grows from zero: the slider is taken along if x moves faster,
    # and else keeps the place it has at that very phase. (A march in time that only knows the last
    # open sample errs by first order.)
    z = x[0] + x[1] * sin_zeta + x[2] * cos_zeta
    kappa = -(x[1] * cos_zeta - x[2] * sin_zeta) / (swing * sin(half))
    slip = 0 if abs(kappa) <= mu else 1 if kappa < 0 else -1
    rested = 0
    now, count = 0.0, 0
    while now < span and count < _MOST_MARKS - 1:
        length = span - now
        if slip != 0:
            # a bound that pushes is at most half a period from its turning point, where it rests
            until = _ahead(phi_l if slip > 0 else phi_u + pi, meet + now, pi)
            length = min(length, until)
            _slip(marks, count, slip)
            kappa = -slip * mu
            if slip > 0:
                of_l = _inverse(a_l)
                z, sin_zeta, cos_zeta = l_0 + a_l, l_s * of_l, l_c * of_l
            else:
                of_u = _inverse(a_u)
                z, sin_zeta, cos_zeta = u_0 - a_u, -u_s * of_u, -u_c * of_u
            rested, slip = slip, 0
        else:
            _stick(marks, count, 1.0, sin_zeta, cos_zeta, kappa)
            # a bound that came to rest at its turning point does not meet the slider there again
            if rested != 1 and z - l_0 < a_l:
                angle = acos(_cosine(z - l_0, a_l))
                until = _ahead(phi_l - angle, meet + now, 2 * (pi - angle))
                if until < length:
                    length, slip = until, 1
            if rested != -1 and z - u_0 > -a_u:
                angle = acos(_cosine(z - u_0, a_u))
                until = _ahead(phi_u + angle, meet + now, 2 * angle)
                if until < length:
                    length, slip = until, -1
        now += length
        count += 1
        _mark(marks, count, meet + now, sin(meet + now), cos(meet + now))
    return count, STICK_SLIP_SEPARATION


@njit(cache=True)
def _add_moments(marks: Array, i: int, j: int, factor: float, to: int, secants: Array) -> None:
    """Add, from mark i to j, a factor times the integrals of (1/2, sin, cos) (1, sin, cos)^T/pi."""
    s_b, c_b, s_e, c_e = marks[i, _SIN], marks[i, _COS], marks[j, _SIN], marks[j, _COS]
    half = 0.5 * factor / pi
    length = half * (marks[j, _PHASE] - marks[i, _PHASE])
    of_sin, of_cos = half * (c_b - c_e), half * (s_e - s_b)
    of_both = half * (s_e - s_b) * (s_e + s_b)
    twice = half * (s_e * c_e - s_b * c_b)
    secants[to, 0, 0] += length
    secants[to, 0, 1] += of_sin
    secants[to, 0, 2] += of_cos
    secants[to, 1, 0] += 2 * of_sin
    secants[to, 1, 1] += length - twice
    secants[to, 1, 2] += of_both
    secants[to, 2, 0] += 2 * of_cos
    secants[to, 2, 1] += of_both
    secants[to, 2, 2] += length + twice


@njit(cache=True)
def _find_secants(x: Array, n: Array, mu: float, marks: Array, secants: Array) -> int:
    """Matrices A, B, C of one element: friction ``A x + B n``, normal load ``C n``; its state.

    They are the exact derivatives as well. The forces are continuous, so moving a transition
    changes no integral; and zeta is where the bound that left the slider is at rest, or moves along
    with the meeting of the surfaces as kappa says.
    """
    count, state = _divide_period(x, n, mu, marks)
    if state == SEPARATION:
        return state
    secants[:] = 0.0
    if state == STICK_SLIP_SEPARATION:
        _add_moments(marks, 0, count, 1.0, _OF_LOAD, secants)
    else:
        for j in range(3):
            secants[_OF_LOAD, j, j] = 1.0
    if state == STICK:
        for j in range(3):
            secants[_OF_X, j, j] = 1.0
        if marks[0, _HELD] == 1.0:
            _hold(marks, 0, 1.0, 0.0, 0.0, secants)
        return state
    for i in range(count):
        if marks[i, _SLIP] != 0:
            _add_moments(marks, i, i + 1, marks[i, _SLIP] * mu, _OF_N, secants)
        else:
            _add_moments(marks, i, i + 1, 1.0, _OF_X, secants)
            mean = (marks[i + 1, _PHASE] - marks[i, _PHASE]) / (2 * pi)
            mean_sin = (marks[i, _COS] - marks[i + 1, _COS]) / pi
            mean_cos = (marks[i + 1, _SIN] - marks[i, _SIN]) / pi
            _hold(marks, i, mean, mean_sin, mean_cos, secants)
    return state


@njit(cache=True)
def _hold(
    marks: Array, i: int, mean: float, mean_sin: float, mean_cos: float, secants: Array
) -> None:
    """Take away the slider's place z, held over a piece of these harmonic coefficients."""
    at_zeta = (1.0, marks[i, _SIN_ZETA], marks[i, _COS_ZETA])
    held = (mean, mean_sin, mean_cos)
    for j in range(3):
        for k in range(3):
            place = held[j] * at_zeta[k]
            secants[_OF_X, j, k] -= place
            secants[_OF_N, j, k] -= place * marks[i, _KAPPA]


@njit(cache=True)
def add_forces(
    point_of_element: NDArray[np.int64],
    k_u: Array,
    k_v: Array,
    normal_load: Array,
    friction_coefficient: Array,
    motion: Array,
    force: Array,
    tangent: Array,
) -> None:
    """Add forces, and tangents where there is room for them."""
    x, n, above = np.empty(3), np.empty(3), np.empty(3)
    marks, secants = np.empty((_MOST_MARKS, 8)), np.empty((3, 3, 3))
    for e in range(point_of_element.size):
        p = point_of_element[e]
        # beside the load of the assembled state a small change of it would lose its digits
        assembled = max(normal_load[e], 0.0)
        for j in range(3):
            x[j] = k_u[e] * motion[p, j]
            above[j] = k_v[e] * motion[p, 3 + j]
        above[0] += min(normal_load[e], 0.0)
        n[:] = above
        n[0] += assembled
        if _find_secants(x, n, friction_coefficient[e], marks, secants) == SEPARATION:
            force[p, 3] -= assembled
            continue
        for j in range(3):
            missing = secants[_OF_LOAD, j, 0] - (1.0 if j == 0 else 0.0)
            force[p, 3 + j] += missing * assembled
            for k in range(3):
                force[p, j] += secants[_OF_X, j, k] * x[k] + secants[_OF_N, j, k] * n[k]
                force[p, 3 + j] += secants[_OF_LOAD, j, k] * above[k]
        if tangent.size == 0:
            continue
        for j in range(3):
            for k in range(3):
                tangent[p, j, k] += k_u[e] * secants[_OF_X, j, k]
                tangent[p, j, 3 + k] += k_v[e] * secants[_OF_N, j, k]
                tangent[p, 3 + j, 3 + k] += k_v[e] * secants[_OF_LOAD, j, k]


@njit(cache=True)
def find_states(
    point_of_element: NDArray[np.int64],
    k_u: Array,
    k_v: Array,
    normal_load: Array,
    friction_coefficient: Array,
    motion: Array,
    state: NDArray[np.int8],
) -> None:
    x, n, marks = np.empty(3), np.empty(3), np.empty((_MOST_MARKS, 8))
    for e in range(point_of_element.size):
        p = point_of_element[e]
        for j in range(3):
            x[j] = k_u[e] * motion[p, j]
            n[j] = k_v[e] * motion[p, 3 + j]
        n[0] += normal_load[e]
        state[e] = _divide_period(x, n, friction_coefficient[e], marks)[1]
