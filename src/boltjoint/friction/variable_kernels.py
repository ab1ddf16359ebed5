"""Analytic describing function of friction under variable normal load, with separation.

The steady period of an element is divided at its transitions between stick, positive slip, negative
slip and separation (eq. 2.26 to 2.34 of the thesis; Yang, Chu and Menq 1998), whose phases have
closed forms. The Fourier integrals over the intervals between them are exact.

References
----------
B. D. Yang, M. L. Chu, C. H. Menq: Stick-slip-separation analysis and non-linear stiffness and
damping characterization of friction contacts having variable normal load. Journal of Sound and
Vibration 210 (1998) 461-481.
Nonlinear vibrations and reduced order modeling of bolted joints. Thesis, Middle East Technical
University: section 2.2.2.
"""

from math import acos, atan2, cos, pi, sin, sqrt

import numpy as np
from numpy.typing import NDArray

from boltjoint.compiled import kept_loop, loop
from boltjoint.friction.contact_states import SEPARATION, STICK, STICK_SLIP, STICK_SLIP_SEPARATION
from boltjoint.friction.protocol import Array, Elements

Bound = tuple[float, float, float, float]
"""A bound of the slider position: bias, sine, cosine and amplitude."""

#: An event is a transition at a phase, with its sine and cosine. In the interval after it the
#: element either slips, in the direction +1 or -1, or sticks with ``z = x(zeta) + kappa n(zeta)``.
#: Here zeta is the phase, given by sine and cosine, at which slip ended on the bound of kappa = -mu
#: or +mu, or at which the contact closed; moved is 0 for a slider that always stays at z = 0.
_PHASE, _SIN, _COS, _SLIP, _MOVED, _SIN_ZETA, _COS_ZETA, _KAPPA = range(8)

#: the matrices A, B, C of an element: friction ``A x + B n``, normal load ``C n``
_OF_X, _OF_N, _OF_LOAD = range(3)

#: more events than a period can have
_MAXIMUM_EVENTS = 10


@loop
def _set_event(events: Array, i: int, phase: float, sine: float, cosine: float) -> None:
    events[i, _PHASE], events[i, _SIN], events[i, _COS] = phase, sine, cosine


@loop
def _set_stick(
    events: Array, i: int, moved: float, sine: float, cosine: float, kappa: float
) -> None:
    events[i, _SLIP], events[i, _MOVED] = 0.0, moved
    events[i, _SIN_ZETA], events[i, _COS_ZETA], events[i, _KAPPA] = sine, cosine, kappa


@loop
def _phase_to(phase: float, origin: float, largest: float) -> float:
    """Phase difference from an origin, between 0 and the largest, at most a period.

    It is 0 where rounding makes it negative.
    """
    difference = (phase - origin) % (2 * pi)
    return 0.0 if difference > 0.5 * largest + pi else min(difference, largest)


@loop
def _cosine(level: float, amplitude: float) -> float:
    """Cosine of the phase, from its maximum, at which a sinusoid passes a level.

    That of the maximum or minimum where the level lies beyond.
    """
    if abs(level) < amplitude:
        return level / amplitude
    return 1.0 if level > 0 else -1.0


@loop
def _sine(cosine: float) -> float:
    """Sine of a phase up to half a period by its cosine, without cancellation near 0."""
    return sqrt((1 - cosine) * (1 + cosine))


@loop
def _inverse(amplitude: float) -> float:
    """Inverse of an amplitude, 0 of none: a constant bound has its extremes at every phase."""
    return 1 / amplitude if amplitude > 0 else 0.0


@loop
def _sticks(x: Array, n: Array, mu: float) -> bool:
    """Whether an element never slips from the assembled state nor separates."""
    low_s, low_c = x[1] - mu * n[1], x[2] - mu * n[2]
    high_s, high_c = x[1] + mu * n[1], x[2] + mu * n[2]
    reach = mu * n[0]
    return (
        n[0] > sqrt(n[1] * n[1] + n[2] * n[2])
        and x[0] - reach + sqrt(low_s * low_s + low_c * low_c) <= 0
        and x[0] + reach - sqrt(high_s * high_s + high_c * high_c) >= 0
    )


@loop
def _divide_period(x: Array, n: Array, mu: float, events: Array) -> tuple[int, int]:
    """Events of the steady period of an element; number of intervals, and contact state.

    ``x = k_u u`` and ``n = n0 + k_v v`` hold bias, sine and cosine. Separation is left out. An
    element that always sticks has one interval without phases.
    """
    n_amplitude = sqrt(n[1] * n[1] + n[2] * n[2])
    if n[0] <= -n_amplitude:
        return 0, SEPARATION
    # bounds of z: k_u u - mu n, amplitude a_l around l_0, and k_u u + mu n, a_u around u_0
    l_0, l_s, l_c = x[0] - mu * n[0], x[1] - mu * n[1], x[2] - mu * n[2]
    u_0, u_s, u_c = x[0] + mu * n[0], x[1] + mu * n[1], x[2] + mu * n[2]
    a_l, a_u = sqrt(l_s * l_s + l_c * l_c), sqrt(u_s * u_s + u_c * u_c)
    if n[0] < n_amplitude:
        return _divide_with_separation(
            x, n, mu, n_amplitude, (l_0, l_s, l_c, a_l), (u_0, u_s, u_c, a_u), events
        )
    highest, lowest = l_0 + a_l, u_0 - a_u
    of_l, of_u = _inverse(a_l), _inverse(a_u)
    l_s, l_c, u_s, u_c = l_s * of_l, l_c * of_l, u_s * of_u, u_c * of_u
    if highest <= lowest or of_l == 0 or of_u == 0:  # a constant z lies between the bounds
        if highest > 0:
            _set_stick(events, 0, 1.0, l_s, l_c, -mu)
        elif lowest < 0:
            _set_stick(events, 0, 1.0, -u_s, -u_c, mu)
        else:
            _set_stick(events, 0, 0.0, 0.0, 0.0, 0.0)
        return 1, STICK
    # positive slip ends at the maximum of the lower bound, stick where the upper bound reaches z;
    # negative slip and the second stick likewise
    cos_fall, cos_rise = _cosine(highest - u_0, a_u), _cosine(lowest - l_0, a_l)
    sin_fall, sin_rise = _sine(cos_fall), _sine(cos_rise)
    fall, rise = acos(cos_fall), acos(cos_rise)
    between = atan2(u_s * l_c - u_c * l_s, u_s * l_s + u_c * l_c)
    stick = pi - rise + fall
    above = _phase_to(between + fall, 0.0, stick)
    below = stick - above
    _set_event(events, 0, 0.0, l_s, l_c)
    _set_stick(events, 0, 1.0, l_s, l_c, -mu)
    sine, cosine = u_s * cos_fall + u_c * sin_fall, u_c * cos_fall - u_s * sin_fall
    _set_event(events, 1, above, sine, cosine)
    events[1, _SLIP] = -1
    _set_event(events, 2, above + pi - fall, -u_s, -u_c)
    _set_stick(events, 2, 1.0, -u_s, -u_c, mu)
    sine, cosine = l_s * cos_rise - l_c * sin_rise, l_c * cos_rise + l_s * sin_rise
    _set_event(events, 3, above + pi - fall + below, sine, cosine)
    events[3, _SLIP] = 1
    _set_event(events, 4, above + pi - fall + below + rise, l_s, l_c)
    return 4, STICK_SLIP


@loop
def _divide_with_separation(
    x: Array, n: Array, mu: float, n_amplitude: float, lower: Bound, upper: Bound, events: Array
) -> tuple[int, int]:
    """As ``_divide_period``, of an element that separates within the period."""
    l_0, l_s, l_c, a_l = lower
    u_0, u_s, u_c, a_u = upper
    phi_l, phi_u = atan2(l_s, l_c), atan2(u_s, u_c)
    half_width = acos(-n[0] / n_amplitude)
    closing, duration = atan2(n[1], n[2]) - half_width, 2 * half_width
    sin_zeta, cos_zeta = sin(closing), cos(closing)
    _set_event(events, 0, closing, sin_zeta, cos_zeta)
    # Where the contact closes, mu n grows from zero: the element slips if x changes faster, and
    # else sticks with the slider position of that phase. (Time integration with the position of the
    # last open sample has an error of first order.)
    z = x[0] + x[1] * sin_zeta + x[2] * cos_zeta
    kappa = -(x[1] * cos_zeta - x[2] * sin_zeta) / (n_amplitude * sin(half_width))
    slip = 0 if abs(kappa) <= mu else 1 if kappa < 0 else -1
    last_bound = 0
    phase, count = 0.0, 0
    while phase < duration and count < _MAXIMUM_EVENTS - 1:
        interval = duration - phase
        if slip != 0:
            # slip ends at the extreme of its bound, at most half a period later
            to_event = _phase_to(phi_l if slip > 0 else phi_u + pi, closing + phase, pi)
            interval = min(interval, to_event)
            events[count, _SLIP] = slip
            kappa = -slip * mu
            if slip > 0:
                of_l = _inverse(a_l)
                z, sin_zeta, cos_zeta = l_0 + a_l, l_s * of_l, l_c * of_l
            else:
                of_u = _inverse(a_u)
                z, sin_zeta, cos_zeta = u_0 - a_u, -u_s * of_u, -u_c * of_u
            last_bound, slip = slip, 0
        else:
            _set_stick(events, count, 1.0, sin_zeta, cos_zeta, kappa)
            # the bound on which slip ended at its extreme does not reach the slider there again
            if last_bound != 1 and z - l_0 < a_l:
                angle = acos(_cosine(z - l_0, a_l))
                to_event = _phase_to(phi_l - angle, closing + phase, 2 * (pi - angle))
                if to_event < interval:
                    interval, slip = to_event, 1
            if last_bound != -1 and z - u_0 > -a_u:
                angle = acos(_cosine(z - u_0, a_u))
                to_event = _phase_to(phi_u + angle, closing + phase, 2 * angle)
                if to_event < interval:
                    interval, slip = to_event, -1
        phase += interval
        count += 1
        _set_event(events, count, closing + phase, sin(closing + phase), cos(closing + phase))
    return count, STICK_SLIP_SEPARATION


@loop
def _add_moments(events: Array, i: int, j: int, factor: float, to: int, secants: Array) -> None:
    """Add, from event i to j, a factor times integrals of (1/2, sin, cos) (1, sin, cos)^T/pi."""
    s_b, c_b, s_e, c_e = events[i, _SIN], events[i, _COS], events[j, _SIN], events[j, _COS]
    half = 0.5 * factor / pi
    length = half * (events[j, _PHASE] - events[i, _PHASE])
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


@loop
def _find_secants(x: Array, n: Array, mu: float, events: Array, secants: Array) -> int:
    """Matrices A, B, C of one element: friction ``A x + B n``, normal load ``C n``; its state.

    They are the exact derivatives as well: the forces are continuous at transitions, so these
    contribute nothing; and z is stationary in zeta, at an extreme of its bound or, by kappa, where
    the contact closes.
    """
    count, state = _divide_period(x, n, mu, events)
    if state == SEPARATION:
        return state
    secants[:] = 0.0
    if state == STICK_SLIP_SEPARATION:
        _add_moments(events, 0, count, 1.0, _OF_LOAD, secants)
    else:
        for j in range(3):
            secants[_OF_LOAD, j, j] = 1.0
    if state == STICK:
        for j in range(3):
            secants[_OF_X, j, j] = 1.0
        if events[0, _MOVED] == 1.0:
            _subtract_position(events, 0, 1.0, 0.0, 0.0, secants)
        return state
    for i in range(count):
        if events[i, _SLIP] != 0:
            _add_moments(events, i, i + 1, events[i, _SLIP] * mu, _OF_N, secants)
        else:
            _add_moments(events, i, i + 1, 1.0, _OF_X, secants)
            mean = (events[i + 1, _PHASE] - events[i, _PHASE]) / (2 * pi)
            mean_sin = (events[i, _COS] - events[i + 1, _COS]) / pi
            mean_cos = (events[i + 1, _SIN] - events[i, _SIN]) / pi
            _subtract_position(events, i, mean, mean_sin, mean_cos, secants)
    return state


@loop
def _subtract_position(
    events: Array, i: int, mean: float, mean_sin: float, mean_cos: float, secants: Array
) -> None:
    """Subtract the slider position z, constant over an interval of these harmonics."""
    at_zeta = (1.0, events[i, _SIN_ZETA], events[i, _COS_ZETA])
    harmonics = (mean, mean_sin, mean_cos)
    for j in range(3):
        for k in range(3):
            product = harmonics[j] * at_zeta[k]
            secants[_OF_X, j, k] -= product
            secants[_OF_N, j, k] -= product * events[i, _KAPPA]


@loop
def _quantities(elements: Elements) -> tuple[Array, Array, Array, Array]:
    """By element k_u, k_v, n0 and mu."""
    quantities = elements.quantities
    return quantities[0], quantities[1], quantities[2], quantities[3]


@kept_loop
def add_forces(elements: Elements, motion: Array, force: Array, tangent: Array) -> None:
    """Add the forces of all elements, and the tangents where their array is not empty."""
    point_of_element = elements.indices
    k_u, k_v, normal_load, friction_coefficient = _quantities(elements)
    x, n, above = np.empty(3), np.empty(3), np.empty(3)
    events, secants = np.empty((_MAXIMUM_EVENTS, 8)), np.empty((3, 3, 3))
    for e in range(point_of_element.size):
        p = point_of_element[e]
        # the load of the assembled state apart, or small changes of it would lose their digits
        assembled = max(normal_load[e], 0.0)
        for j in range(3):
            x[j] = k_u[e] * motion[p, j]
            above[j] = k_v[e] * motion[p, 3 + j]
        above[0] += min(normal_load[e], 0.0)
        n[0], n[1], n[2] = assembled + above[0], above[1], above[2]
        if _sticks(x, n, friction_coefficient[e]):
            for j in range(3):
                force[p, j] += x[j]
                force[p, 3 + j] += above[j]
                if tangent.size > 0:
                    tangent[p, j, j] += k_u[e]
                    tangent[p, 3 + j, 3 + j] += k_v[e]
            continue
        if _find_secants(x, n, friction_coefficient[e], events, secants) == SEPARATION:
            force[p, 3] -= assembled
            continue
        for j in range(3):
            change = secants[_OF_LOAD, j, 0] - (1.0 if j == 0 else 0.0)
            force[p, 3 + j] += change * assembled
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


@kept_loop
def find_states(elements: Elements, motion: Array, state: NDArray[np.int8]) -> None:
    """Contact state of every element over the period."""
    point_of_element = elements.indices
    k_u, k_v, normal_load, friction_coefficient = _quantities(elements)
    x, n, events = np.empty(3), np.empty(3), np.empty((_MAXIMUM_EVENTS, 8))
    for e in range(point_of_element.size):
        p = point_of_element[e]
        for j in range(3):
            x[j] = k_u[e] * motion[p, j]
            n[j] = k_v[e] * motion[p, 3 + j]
        n[0] += normal_load[e]
        state[e] = _divide_period(x, n, friction_coefficient[e], events)[1]
