"""What a dry friction element under variable normal load does in one period of harmonic motion.

A tangential spring in series with a slider, pressed together by a normal spring that the motion
loads, unloads and lets go (eq. 2.26 to 2.34 of the source study). Forces are exact: the period is
divided at the phases where the element changes between stick, slip and separation.
"""

from dataclasses import dataclass
from math import acos, atan2, cos, hypot, pi, sin
from typing import ClassVar

import numpy as np
from numba import njit
from numpy.typing import NDArray

from boltjoint.friction.states import SEPARATION, STICK, STICK_SLIP, STICK_SLIP_SEPARATION

Array = NDArray[np.float64]


@dataclass(frozen=True)
class VariableLoad:
    """Friction elements under variable normal load, any number of them on each contact point.

    With tangential displacement u and normal displacement v, positive when closing, the normal load
    is ``n = max(n0 + k_v v, 0)`` and the friction force ``f = k_u u - z``. The slider, at z / k_u,
    rests while ``|f| < mu n`` and is pushed along by whichever bound it meets: z is a play between
    ``k_u u - mu n`` and ``k_u u + mu n``. Where the bounds close upon each other, in separation, it
    follows u.

    The slider starts without traction at the assembled state and is moved as little as the periodic
    motion demands. This decides the residual traction of a contact that never slips through: if the
    bounds leave room for a slider at rest, z is the value in that room that is nearest to zero. In
    all other motions the steady state does not depend on the start.

    Parameters
    ----------
    point_of_element
        The contact point each element acts on, counted from 0, shape (elements,).
    tangential_stiffness, normal_stiffness
        k_u and k_v of each element [N/m], shape (elements,).
    normal_load
        n0 of each element [N], shape (elements,); negative for a gap, of ``-n0 / k_v``.
    friction_coefficient
        mu of each element [-], shape (elements,).

    Raises
    ------
    ValueError
        If they differ in length, a stiffness or mu is not positive, or a load is not finite.
    """

    point_of_element: NDArray[np.int64]
    tangential_stiffness: NDArray[np.float64]
    normal_stiffness: NDArray[np.float64]
    normal_load: NDArray[np.float64]
    friction_coefficient: NDArray[np.float64]

    name: ClassVar[str] = "variable"
    #: directions of motion that the law needs
    directions: ClassVar[tuple[str, ...]] = ("tangential", "normal")
    #: harmonic coefficients of the motion that the law needs
    components: ClassVar[tuple[str, ...]] = ("bias", "sin", "cos")
    #: what describes each element, with unit and meaning
    quantities: ClassVar[dict[str, tuple[str, str]]] = {
        "tangential_stiffness": ("N/m", "tangential contact stiffness"),
        "normal_stiffness": ("N/m", "normal contact stiffness"),
        "normal_load": ("N", "normal load of the assembled state, negative for a gap"),
        "friction_coefficient": ("1", "friction coefficient"),
    }

    def __post_init__(self) -> None:
        """Refuse what is no friction element."""
        count = self.point_of_element.shape
        for name in self.quantities:
            values = getattr(self, name)
            if values.shape != count:
                raise ValueError(f"{name} has shape {values.shape}, point_of_element {count}")
            if name != "normal_load" and not np.all(values > 0):
                raise ValueError(f"{name} must be positive on every element")
        if not np.all(np.isfinite(self.normal_load)):
            raise ValueError("normal_load must be finite on every element")

    @property
    def slip_force(self) -> NDArray[np.float64]:
        """Mu n0 of each element in the assembled state [N], 0 where it is open."""
        return self.friction_coefficient * np.maximum(self.normal_load, 0.0)

    def force(self, motion: NDArray[np.float64]) -> NDArray[np.float64]:
        """First-harmonic forces of all elements on each point.

        Parameters
        ----------
        motion
            Bias, sine and cosine coefficients of u, then those of v [m], shape (points, 6).

        Returns
        -------
        ndarray
            Those of the friction force, then those by which the normal load exceeds that of the
            assembled state, ``max(n0, 0)``, with which the structure is in equilibrium
            [N], shape (points, 6).
        """
        force = np.zeros_like(motion)
        _add_forces(*self._arrays(), motion, force, np.zeros((0, 6, 6)))
        return force

    def force_and_tangent(
        self, motion: NDArray[np.float64]
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """First-harmonic forces on each point and their derivative by the motion of that point.

        Parameters
        ----------
        motion
            As for ``force``.

        Returns
        -------
        force : ndarray
            Shape (points, 6) [N].
        tangent : ndarray
            ``tangent[p, i, j]`` is d force_i / d motion_j [N/m], shape (points, 6, 6).
        """
        force = np.zeros_like(motion)
        tangent = np.zeros((*motion.shape, 6))
        _add_forces(*self._arrays(), motion, force, tangent)
        return force, tangent

    def stuck_stiffness(self, points: int) -> NDArray[np.float64]:
        """Stiffness of the points while closed elements stick and open ones stay open [N/m].

        Shape (points, directions).
        """
        closed = self.normal_load > 0
        return np.column_stack(
            [
                np.bincount(self.point_of_element, stiffness * closed, minlength=points)
                for stiffness in (self.tangential_stiffness, self.normal_stiffness)
            ]
        )

    def contact_state(self, motion: NDArray[np.float64]) -> NDArray[np.int8]:
        """State of every element over the period (``boltjoint.friction.states``).

        An element that touches and lets go within the period counts as one with separation, whether
        or not it slips while it touches.
        """
        state = np.empty(self.point_of_element.size, dtype=np.int8)
        _find_states(*self._arrays(), motion, state)
        return state

    def replaced_by(
        self,
        point_of_element: NDArray[np.int64],
        tangential_stiffness: NDArray[np.float64],
        slip_force: NDArray[np.float64],
    ) -> "VariableLoad":
        """Other elements on the same points, by stiffness [N/m] and slip force [N] of each.

        On every point, k_v stands to k_u and n0 to mu n0 as they do for its closed elements now.
        """
        closed = self.normal_load > 0
        sums = [
            np.bincount(self.point_of_element, values * closed)[point_of_element]
            for values in (
                self.tangential_stiffness,
                self.normal_stiffness,
                self.normal_load,
                self.slip_force,
            )
        ]
        return VariableLoad(
            point_of_element=point_of_element,
            tangential_stiffness=tangential_stiffness,
            normal_stiffness=tangential_stiffness * sums[1] / sums[0],
            normal_load=slip_force * sums[2] / sums[3],
            friction_coefficient=sums[3] / sums[2],
        )

    def _arrays(self) -> tuple[NDArray, ...]:
        return (self.point_of_element, *(getattr(self, name) for name in self.quantities))


#: A piece of the period: phases of its begin and end, +1 or -1 where the element slips that way and
#: 0 where it sticks. Where it sticks, ``z = x(zeta) + kappa n(zeta)``: zeta is the phase at which
#: the slider came to rest, on the bound kappa = -mu or +mu, or where the surfaces met. ``held`` is
#: 0 for a slider that never left z = 0.
_BEGIN, _END, _SLIP, _HELD, _ZETA, _KAPPA = range(6)

#: more pieces than a period can have
_MOST_PIECES = 8


@njit(cache=True)
def _add_piece(
    pieces: Array,
    count: int,
    begin: float,
    length: float,
    slip: int,
    held: float,
    zeta: float,
    kappa: float,
) -> int:
    piece = pieces[count]
    piece[_BEGIN], piece[_END], piece[_SLIP] = begin, begin + length, slip
    piece[_HELD], piece[_ZETA], piece[_KAPPA] = held, zeta, kappa
    return count + 1


@njit(cache=True)
def _ahead(phase: float, now: float) -> float:
    """How far a phase is ahead of another, from 0 to a period."""
    return (phase - now) % (2 * pi)


@njit(cache=True)
def _find_pieces(x: Array, n: Array, mu: float, pieces: Array) -> tuple[int, int]:
    """Divide the steady period of an element at its transitions; number of pieces, and its state.

    ``x = k_u u`` and ``n = n0 + k_v v`` hold bias, sine and cosine of what the springs want; phases
    of separation are left out.
    """
    swing = hypot(n[1], n[2])
    if n[0] <= -swing:
        return 0, SEPARATION
    # the bounds k_u u -+ mu n are sinusoids of amplitude a_l, a_u that are highest at phi_l, phi_u
    l_0, l_s, l_c = x[0] - mu * n[0], x[1] - mu * n[1], x[2] - mu * n[2]
    u_0, u_s, u_c = x[0] + mu * n[0], x[1] + mu * n[1], x[2] + mu * n[2]
    a_l, phi_l = hypot(l_s, l_c), atan2(l_s, l_c)
    a_u, phi_u = hypot(u_s, u_c), atan2(u_s, u_c)
    if n[0] >= swing:
        return _find_pieces_in_contact(l_0, phi_l, a_l, u_0, phi_u, a_u, mu, pieces)
    half = acos(-n[0] / swing)
    meet, span = atan2(n[1], n[2]) - half, 2 * half
    x_meet = x[0] + x[1] * sin(meet) + x[2] * cos(meet)
    # where they meet, mu n grows from zero: the slider is taken along if x moves faster, and else
    # keeps where it was at that very phase (a march in time that only knows the last open sample
    # errs by first order)
    kappa = -(x[1] * cos(meet) - x[2] * sin(meet)) / (swing * sin(half))
    slip, zeta, z = 0, meet, x_meet
    if abs(kappa) > mu:
        slip = 1 if kappa < 0 else -1
    now, count = 0.0, 0
    while now < span and count < _MOST_PIECES:
        length = span - now
        if slip != 0:
            # a bound that pushes is at most half a period from its turning point, where it rests
            turn = phi_l if slip > 0 else phi_u + pi
            until = _ahead(turn, meet + now)
            length = min(length, until if until < pi else 0.0)
            count = _add_piece(pieces, count, meet + now, length, slip, 0.0, 0.0, 0.0)
            zeta, kappa = turn, -slip * mu
            z = l_0 + a_l if slip > 0 else u_0 - a_u
            slip = 0
        else:
            # a bound that came to rest at its turning point does not meet the slider there again
            if kappa != -mu and abs(z - l_0) < a_l:
                until = _ahead(phi_l - acos((z - l_0) / a_l), meet + now)
                if until < length:
                    length, slip = until, 1
            if kappa != mu and abs(z - u_0) < a_u:
                until = _ahead(phi_u + acos((z - u_0) / a_u), meet + now)
                if until < length:
                    length, slip = until, -1
            count = _add_piece(pieces, count, meet + now, length, 0, 1.0, zeta, kappa)
        now += length
    return count, STICK_SLIP_SEPARATION


@njit(cache=True)
def _find_pieces_in_contact(
    l_0: float,
    phi_l: float,
    a_l: float,
    u_0: float,
    phi_u: float,
    a_u: float,
    mu: float,
    pieces: Array,
) -> tuple[int, int]:
    """The same for an element that does not separate."""
    highest, lowest = l_0 + a_l, u_0 - a_u
    if highest <= lowest:  # there is room for a slider at rest
        held = 1.0 if highest > 0 or lowest < 0 else 0.0
        zeta, kappa = (phi_l, -mu) if highest > 0 else (phi_u + pi, mu)
        return _add_piece(pieces, 0, 0.0, 2 * pi, 0, held, zeta, kappa), STICK
    # pushed up to where one bound is highest, left there until the other comes down, and back
    fall = acos(min(max((highest - u_0) / a_u, -1.0), 1.0))
    rise = acos(min(max((lowest - l_0) / a_l, -1.0), 1.0))
    above = _ahead(phi_u + fall, phi_l)
    below = _ahead(phi_l - rise, phi_u + pi)
    if above + below + rise + (pi - fall) > 3 * pi:  # one of them is no time at all, but rounding
        above, below = (0.0, below) if above > below else (above, 0.0)
    count = _add_piece(pieces, 0, phi_l, above, 0, 1.0, phi_l, -mu)
    count = _add_piece(pieces, count, phi_u + fall, pi - fall, -1, 0.0, 0.0, 0.0)
    count = _add_piece(pieces, count, phi_u + pi, below, 0, 1.0, phi_u + pi, mu)
    count = _add_piece(pieces, count, phi_l - rise, rise, 1, 0.0, 0.0, 0.0)
    return count, STICK_SLIP


@njit(cache=True)
def _add_moments(begin: float, end: float, factor: float, moments: Array) -> None:
    """Add a factor times the integrals over a piece of (1/2, sin, cos) (1, sin, cos)^T / pi."""
    s_b, c_b, s_e, c_e = sin(begin), cos(begin), sin(end), cos(end)
    length = end - begin
    factor /= pi
    of_sin, of_cos = factor * (c_b - c_e), factor * (s_e - s_b)
    of_both = factor * 0.5 * (s_e * s_e - s_b * s_b)
    twice = factor * 0.5 * (s_e * c_e - s_b * c_b)
    moments[0, 0] += 0.5 * factor * length
    moments[0, 1] += 0.5 * of_sin
    moments[0, 2] += 0.5 * of_cos
    moments[1, 0] += of_sin
    moments[1, 1] += 0.5 * factor * length - twice
    moments[1, 2] += of_both
    moments[2, 0] += of_cos
    moments[2, 1] += of_both
    moments[2, 2] += 0.5 * factor * length + twice


@njit(cache=True)
def _find_secants(x: Array, n: Array, mu: float, pieces: Array, secants: Array) -> int:
    """Matrices A, B, C of one element: friction ``A x + B n``, normal load ``C n``; its state.

    They are the exact derivatives as well. The forces are continuous, so moving a transition
    changes no integral; and zeta is where the bound that left the slider is at rest, or moves along
    with the meeting of the surfaces as kappa says.
    """
    count, state = _find_pieces(x, n, mu, pieces)
    of_x, of_n, of_load = secants
    secants[:] = 0.0
    for i in range(count):
        begin, end, slip = pieces[i, _BEGIN], pieces[i, _END], pieces[i, _SLIP]
        _add_moments(begin, end, 1.0, of_load)
        if slip != 0:
            _add_moments(begin, end, slip * mu, of_n)
            continue
        _add_moments(begin, end, 1.0, of_x)
        if pieces[i, _HELD] == 0.0:
            continue
        zeta, kappa = pieces[i, _ZETA], pieces[i, _KAPPA]
        at_rest = (1.0, sin(zeta), cos(zeta))
        mean = (
            (end - begin) / (2 * pi),
            (cos(begin) - cos(end)) / pi,
            (sin(end) - sin(begin)) / pi,
        )
        for j in range(3):
            for k in range(3):
                of_x[j, k] -= mean[j] * at_rest[k]
                of_n[j, k] -= mean[j] * at_rest[k] * kappa
    return state


@njit(cache=True)
def _add_forces(
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
    x, n = np.empty(3), np.empty(3)
    pieces, secants = np.empty((_MOST_PIECES, 6)), np.empty((3, 3, 3))
    of_x, of_n, of_load = secants
    for e in range(point_of_element.size):
        p = point_of_element[e]
        for j in range(3):
            x[j] = k_u[e] * motion[p, j]
            n[j] = k_v[e] * motion[p, 3 + j]
        n[0] += normal_load[e]
        _find_secants(x, n, friction_coefficient[e], pieces, secants)
        for j in range(3):
            for k in range(3):
                force[p, j] += of_x[j, k] * x[k] + of_n[j, k] * n[k]
                force[p, 3 + j] += of_load[j, k] * n[k]
        force[p, 3] -= max(normal_load[e], 0.0)
        if tangent.size == 0:
            continue
        for j in range(3):
            for k in range(3):
                tangent[p, j, k] += k_u[e] * of_x[j, k]
                tangent[p, j, 3 + k] += k_v[e] * of_n[j, k]
                tangent[p, 3 + j, 3 + k] += k_v[e] * of_load[j, k]


@njit(cache=True)
def _find_states(
    point_of_element: NDArray[np.int64],
    k_u: Array,
    k_v: Array,
    normal_load: Array,
    friction_coefficient: Array,
    motion: Array,
    state: NDArray[np.int8],
) -> None:
    x, n, pieces = np.empty(3), np.empty(3), np.empty((_MOST_PIECES, 6))
    for e in range(point_of_element.size):
        p = point_of_element[e]
        for j in range(3):
            x[j] = k_u[e] * motion[p, j]
            n[j] = k_v[e] * motion[p, 3 + j]
        n[0] += normal_load[e]
        state[e] = _find_pieces(x, n, friction_coefficient[e], pieces)[1]
