"""Weighted snapshots: displacement fields of a contact that sticks, slips and opens.

They are solved in candidates, where contact is cheap. Weights say how much a snapshot matters
against a mode of the first resonance; they were found by trial, for 40 vectors on the assemblies of
the study.

References
----------
Nonlinear vibrations and reduced order modeling of bolted joints. Thesis, Middle East Technical
University: eq. 2.5 and 2.25.
"""

from collections.abc import Iterator
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from boltjoint.structure.basis.candidates import Candidates, SpringContact, stuck_spring_stiffness

if TYPE_CHECKING:
    from boltjoint.config.contact_adapted_basis import ContactAdaptedBasis

Array = NDArray[np.float64]

#: stride of the slip levels at which single bolts stick, or one side of each: enough to hold these
#: patterns without crowding out the others
_STRIDE = 3

#: fixed-point iterations of stick and slip at each amplitude, from the state at the one before
_SLIP_ITERATIONS = 3

#: factor of the amplitude, and number of steps, once most of the contact slips: under variable load
#: it opens until it rattles, and then changes no more
_AMPLITUDE_GROWTH, _GROWTH_STEPS = 1.35, 20

#: maximum iterations of the bias equilibrium, and tolerance of its relative change
_BIAS_ITERATIONS, _BIAS_TOLERANCE = 12, 1e-3

#: snapshot weight of each resonance after the first, against the one before
_RESONANCE_WEIGHT = 0.2

#: snapshot weight of bias positions, per amplitude
_BIAS_WEIGHT = 2.7

#: snapshot weight of gradients of the loss, relative to the loss and, to this power, to the growth
#: of the damping force, which decides how far the loss moves the amplitude
_LOSS_WEIGHT, _GROWTH_EXPONENT = 0.02, 0.62


def stuck_snapshots(candidates: Candidates, options: "ContactAdaptedBasis") -> Iterator[Array]:
    """Modes while a part of the loaded pairs sticks and the others are released.

    The part shrinks towards the bolts, once by pressure and once by distance, on the whole lap and
    on either half of it, and in fewer steps around one bolt alone and on one side of each bolt,
    with springs along x only and along x and z.

    Yields
    ------
    ndarray
        Weighted modes, shape (candidates, resonances).
    """
    start = _start(candidates)
    weight = _RESONANCE_WEIGHT ** np.arange(options.resonances)
    count, levels = options.resonances, options.slip_levels
    k = options.contact_stiffness_N_per_m
    x = candidates.position[:, 0]
    middle = (x.min() + x.max()) / 2
    to_bolts = candidates.position[:, None, :2] - candidates.bolt_position[:, :2]
    distances = np.linalg.norm(to_bolts, axis=-1)
    nearest, distance = np.argmin(distances, axis=1), distances.min(axis=1)
    beside = to_bolts[np.arange(len(x)), nearest, 0]
    halves = [np.ones(len(x), dtype=bool), x < middle, x > middle]
    around = [nearest == bolt for bolt in range(distances.shape[1])]
    sides = [beside < 0, beside > 0]
    none = np.zeros(len(x))

    def weighted_modes(tangential: Array, normal: Array) -> Array:
        mode = SpringContact(candidates, tangential, normal).modes(count, start)[1]
        return mode * (weight / _energy_norm(candidates, mode, k))

    yield weighted_modes(none, none)
    for grade in (-candidates.pressure, distance):
        for level in range(levels):
            # the pairs on the rim of the pressure are many and carry little
            share = 1 - (level / levels) ** 2
            inside = candidates.loaded & (grade <= _load_quantile(candidates, grade, share))
            for part in [*halves, *(around + sides if level % _STRIDE == 0 else [])]:
                spring = k * (inside & part)
                for normal in (none, spring):
                    yield weighted_modes(spring, normal)


def slipping_snapshots(candidates: Candidates, options: "ContactAdaptedBasis") -> Iterator[Array]:
    """Motion at resonances while the slip fraction grows, under constant and variable load.

    Each comes with the gradients of its loss. The error of the loss in a basis is the product, in
    strain energy, of the errors of the motion and of the static response to the gradient of the
    loss, so a few weak pairs matter although their energy is small.

    Yields
    ------
    ndarray
        Weighted snapshots, shape (candidates, 5): as from ``_SlippingMode.snapshots``.
    """
    levels = options.slip_levels
    # the first pairs that slip are few and weak
    slip_fractions = (np.arange(1, levels + 1) / (levels + 1)) ** 3
    for variable in (False, True):
        for resonance in range(options.resonances):
            mode = _SlippingMode(candidates, options, resonance, variable)
            for slip_fraction in slip_fractions:
                mode.slip(slip_fraction)
                yield mode.snapshots()
            for _ in range(_GROWTH_STEPS):
                mode.grow()
                yield mode.snapshots()


class _SlippingMode:
    """A mode while the contact slips, and opens under variable load, at a growing amplitude.

    Each pair acts by its describing function: a spring in phase with the motion, and in quadrature
    the friction. Under variable load the mean force of the pairs moves the bias. All of it scales
    with the load of the bolts.
    """

    def __init__(
        self, candidates: Candidates, options: "ContactAdaptedBasis", resonance: int, variable: bool
    ) -> None:
        self._candidates, self._resonance = candidates, resonance
        self._stiffness = k = options.contact_stiffness_N_per_m
        self._friction_coefficient = options.friction_coefficient
        self._loss_factor = options.loss_factor
        self._at_rest = np.maximum(candidates.normal_load, 0.0)
        self._normal_stiffness = k * variable
        # as in a joint under variable load: a negative load is a gap
        self._load = self._at_rest - self._normal_stiffness * candidates.gap
        self._in_phase = k * candidates.loaded
        self._contact = SpringContact(
            candidates, self._in_phase, self._normal_stiffness * candidates.loaded
        )
        self._mode = self._solve_mode(_start(candidates))
        self._bias = np.zeros_like(self._mode)
        self._amplitude = 0.0

    def slip(self, slip_fraction: float) -> None:
        """Solve at the amplitude where pairs that carry this fraction of the load slip."""
        for _ in range(_SLIP_ITERATIONS):
            self._amplitude = _load_quantile(self._candidates, self._onset(), slip_fraction)
            self._iterate()

    def grow(self) -> None:
        """Solve at a larger amplitude."""
        self._amplitude *= _AMPLITUDE_GROWTH
        for _ in range(_SLIP_ITERATIONS):
            self._iterate()

    def snapshots(self) -> Array:
        """The mode, its bias, and the gradients of its loss and stiffness, weighted.

        Returns
        -------
        ndarray
            Shape (candidates, 5): the mode; the bias per amplitude; the static responses to the
            gradients of the loss by either, and of the stiffness by the mode, which moves the bias.
            The second, fourth and fifth vanish under constant load.
        """
        found = self._sensitivity()
        structure = self._loss_factor
        loss, growth = structure + found.loss, structure + max(found.growth, 0.0)
        relative = _LOSS_WEIGHT / (loss ** (1 - _GROWTH_EXPONENT) * growth**_GROWTH_EXPONENT)
        snapshots = np.stack(
            [
                self._mode,
                _BIAS_WEIGHT * self._bias / self._amplitude,
                relative * found.loss_by_mode,
                _BIAS_WEIGHT * relative * found.loss_by_bias,
                found.stiffness_by_mode,
            ],
            axis=1,
        )
        norm = _energy_norm(self._candidates, self._mode, self._stiffness)
        return snapshots * (_RESONANCE_WEIGHT**self._resonance / norm)

    def _sensitivity(self) -> "_Sensitivity":
        c, k = self._candidates, self._stiffness
        mu, kn = self._friction_coefficient, self._normal_stiffness
        u, v = c.tangential @ self._mode, c.normal @ self._mode
        load = self._normal_load(v)
        slip = mu * load.sliding
        slips = k * self._amplitude * abs(u) > slip
        ratio = np.ones_like(u)
        np.divide(slip, k * self._amplitude * abs(u), out=ratio, where=slips)
        by_motion = 4 / np.pi * slips * slip / self._amplitude
        by_load = 4 / np.pi * slips * mu * abs(u) * (1 - 2 * ratio)

        held = SpringContact(c, self._in_phase, kn * load.closed)
        loss_by_bias = held.displacement(
            c.normal.T @ (c.weight * kn * load.sliding_by_load * by_load)
        )
        stiffness_by_bias = held.displacement(
            c.normal.T @ (c.weight * kn * 2 * load.by_amplitude * abs(v))
        )
        # a larger normal motion changes the load directly, and by the bias that it moves
        through_load = kn * (
            load.sliding_by_amplitude * by_load - load.by_amplitude * (c.normal @ loss_by_bias)
        )
        through_bias = kn * load.by_amplitude * (c.normal @ stiffness_by_bias)
        return _Sensitivity(
            loss=by_motion @ (c.weight * abs(u) * (1 - ratio)),
            growth=by_motion @ (c.weight * abs(u) * ratio) + through_load @ (c.weight * abs(v)),
            loss_by_mode=self._contact.displacement(
                c.tangential.T @ (c.weight * by_motion * np.sign(u))
                + c.normal.T @ (c.weight * through_load * np.sign(v))
            ),
            loss_by_bias=loss_by_bias,
            stiffness_by_mode=self._contact.displacement(
                c.normal.T @ (c.weight * through_bias * np.sign(v))
            ),
        )

    def _onset(self) -> Array:
        """The amplitude from which each pair slips: k |u| = mu n."""
        c, k = self._candidates, self._stiffness
        u = abs(c.tangential @ self._mode)
        onset = np.full(len(u), np.inf)
        slip = self._friction_coefficient * self._at_rest
        np.divide(slip, k * u, out=onset, where=c.loaded & (u > 0))
        return onset

    def _normal_load(self, v: Array) -> "_NormalLoad":
        c, kn = self._candidates, self._normal_stiffness
        return _NormalLoad(self._load + kn * (c.normal @ self._bias), kn * self._amplitude * abs(v))

    def _iterate(self) -> None:
        """Solve the bias equilibrium under the present mode, then the mode under its loads."""
        c, kn = self._candidates, self._normal_stiffness
        u, v = c.tangential @ self._mode, c.normal @ self._mode
        for _ in range(_BIAS_ITERATIONS):
            load = self._normal_load(v)
            force = c.normal.T @ (c.weight * (load.mean - self._at_rest)) + c.tangential.T @ (
                c.weight * self._in_phase * (c.tangential @ self._bias)
            )
            held = SpringContact(c, self._in_phase, kn * load.closed)
            change = held.displacement(self._bias + force)
            self._bias = self._bias - change
            if np.linalg.norm(change) <= _BIAS_TOLERANCE * np.linalg.norm(self._bias):
                break
        load = self._normal_load(v)
        self._in_phase = _describing_function(
            self._stiffness, self._friction_coefficient * load.sliding, self._amplitude * abs(u)
        )
        self._contact = SpringContact(c, self._in_phase, kn * load.secant)
        mode = self._solve_mode(self._mode)
        self._mode = mode * np.sign(mode @ self._mode)

    def _solve_mode(self, start: Array) -> Array:
        return self._contact.modes(self._resonance + 1, start)[1][:, self._resonance]


class _Sensitivity(NamedTuple):
    """Friction loss of a slipping mode of unit strain energy, and its derivatives.

    Attributes
    ----------
    loss
        Loss factor [-]: the sum of ``4/pi mu n (u - mu n / (k A)) / A`` over the pairs that slip.
    growth
        Derivative of the damping force, loss times amplitude, by the amplitude [-].
    loss_by_mode, loss_by_bias
        Static responses to the gradient of the loss by the mode and by the bias per amplitude,
        shape (candidates,).
    stiffness_by_mode
        The same of the stiffness, through the bias that the mode moves.
    """

    loss: float
    growth: float
    loss_by_mode: Array
    loss_by_bias: Array
    stiffness_by_mode: Array


class _NormalLoad:
    """Normal loads ``max(n0 + A sin, 0)`` over a period, of contacts that open and close.

    With ``l = -n0 / A`` between -1 and 1 they are closed while the sine exceeds l.

    Parameters
    ----------
    load
        n0 [N], negative for a gap, shape (pairs,).
    amplitude
        A [N], shape (pairs,).

    Attributes
    ----------
    mean
        [N].
    closed
        Share of the period in contact [-], the derivative of the mean by n0.
    by_amplitude
        Derivative of the mean by A [-].
    secant
        First harmonic over A [-].
    sliding
        Mean weighted by the sliding velocity, the absolute value of a cosine [N].
    sliding_by_load, sliding_by_amplitude
        Its derivatives by n0 and A [-].
    """

    def __init__(self, load: Array, amplitude: Array) -> None:
        moves = amplitude > 0
        level = np.sign(-load)
        np.divide(-load, amplitude, out=level, where=moves)
        opens = moves & (abs(level) < 1)
        level = np.clip(level, -1.0, 1.0)
        root = np.sqrt(1 - level**2)
        self.closed = (np.pi / 2 - np.arcsin(level)) / np.pi
        self.by_amplitude = root / np.pi
        self.mean = load * self.closed + amplitude * self.by_amplitude
        self.secant = self.closed - level * root / np.pi
        self.sliding_by_load = (1 - level) / 2
        self.sliding_by_amplitude = (1 - level**2) / 4
        self.sliding = np.where(opens, amplitude * (1 - level) ** 2 / 4, np.maximum(load, 0.0))


def _start(candidates: Candidates) -> Array:
    return np.random.default_rng(0).standard_normal(len(candidates.mass))


def _load_quantile(candidates: Candidates, grade: Array, share: float) -> float:
    """The value of ``grade`` up to which pairs carry a share of the load."""
    order = np.argsort(grade, kind="stable")
    carried = np.cumsum((candidates.normal_load * candidates.weight)[order])
    # the last sum misses the total by rounding only
    reached = np.searchsorted(carried, share * carried[-1] * (1 - 1e-12))
    return grade[order[reached]]


def _energy_norm(candidates: Candidates, snapshots: Array, contact_stiffness: float) -> Array:
    """Root of the strain energy of one or more snapshots with the contact stuck."""
    moved = candidates.rows @ snapshots
    spring = stuck_spring_stiffness(candidates, contact_stiffness)
    return np.sqrt((snapshots**2).sum(axis=0) + spring @ moved**2)


def _describing_function(k: float, slip_force: Array, amplitude: Array) -> Array:
    """Stiffness in phase of a spring with a slider (Jenkins element) [N/m].

    With ``cos(theta) = 1 - 2 mu n / (k A)``: ``k / pi (theta - sin(theta) cos(theta))`` (eq. 2.5
    over the loop 2.25).
    """
    ratio = np.ones_like(amplitude)
    np.divide(slip_force, k * amplitude, out=ratio, where=k * amplitude > slip_force)
    theta = 2 * np.arcsin(np.sqrt(ratio))
    return k / np.pi * (theta - np.sin(theta) * np.cos(theta))
