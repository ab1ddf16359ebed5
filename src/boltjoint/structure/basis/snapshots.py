"""Snapshots: displacement fields of a joint that sticks, slips and opens."""

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from boltjoint.structure.basis.candidates import (
    BasisOptions,
    Candidates,
    SpringContact,
    stuck_spring_stiffness,
)

Array = NDArray[np.float64]


#: corrections of stick and slip at each amplitude; the next amplitude goes on from there
_CORRECTIONS = 3


#: by how much, and how often, the amplitude grows once most of the contact slips: under variable
#: load it opens on until it rattles, and then changes no more
_GROWTH, _GROWN = 1.35, 20


#: levels from one to the next at which single bolts stick, or one side of each: enough to hold them
#: without crowding out the rest
_STRIDE = 3


#: corrections of the mean position, and the change of it, over its size, that is none
_MOST_MEANS, _MEAN_FOUND = 12, 1e-3


# How much motions count, against a mode of the first resonance: found by trial, for 40 vectors on
# the assemblies of the study.
#: the motion of each resonance after the first, against the one before
_LATER = 0.2


#: mean positions, per amplitude
_MEAN = 2.7


#: what a change of the loss depends on, per change relative to the loss and, to this power, to the
#: growth of the damping force, which decides how far the loss moves the amplitude
_LOSS, _TO_GROWTH = 0.02, 0.62


def stuck_snapshots(candidates: Candidates, options: BasisOptions) -> Iterator[Array]:
    """Modes while a part of the loaded pairs sticks and the others bear nothing.

    The part shrinks towards the bolts, once by pressure and once by distance, on the whole lap and
    on either half of it, and in fewer steps around one bolt alone and on one side of each bolt,
    with springs along x only and along x and z.

    Yields
    ------
    ndarray
        Motions, as they count, shape (candidates, resonances).
    """
    start = _start(candidates)
    weight = _LATER ** np.arange(options.resonances)
    count, k = options.resonances, options.contact_stiffness
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

    def counting(tangential: Array, normal: Array) -> Array:
        mode = SpringContact(candidates, tangential, normal).modes(count, start)[1]
        return mode * (weight / _size(candidates, mode, k))

    yield counting(none, none)
    for grade in (-candidates.pressure, distance):
        for level in range(options.levels):
            # the pairs on the rim of the pressure are many and carry little
            share = 1 - (level / options.levels) ** 2
            inside = candidates.loaded & (grade <= _load_quantile(candidates, grade, share))
            for part in [*halves, *(around + sides if level % _STRIDE == 0 else [])]:
                spring = k * (inside & part)
                for normal in (none, spring):
                    yield counting(spring, normal)


def slipping_snapshots(candidates: Candidates, options: BasisOptions) -> Iterator[Array]:
    """Motion at resonances while slip grows with the amplitude, under constant and variable load.

    With each comes what its loss depends on. The loss of a basis is wrong by the product, in strain
    energy, of what the basis misses of the motion and of what it misses of the static shape of the
    loss's gradient, so a few weak pairs count although their energy is small.

    Yields
    ------
    ndarray
        Motions, as they count, shape (candidates, 5): as from ``_SlippingMode.motions``.
    """
    # the first pairs that slip are few and weak
    shares = (np.arange(1, options.levels + 1) / (options.levels + 1)) ** 3
    for variable in (False, True):
        for resonance in range(options.resonances):
            mode = _SlippingMode(candidates, options, resonance, variable)
            for share in shares:
                mode.slip(share)
                yield mode.motions()
            for _ in range(_GROWN):
                mode.grow()
                yield mode.motions()


class _SlippingMode:
    """A mode while the contact slips, and opens under variable load, at a growing amplitude.

    Each pair acts by its describing function: a spring of the mode's own motion, and in quadrature
    the friction. Under variable load the pairs' mean force moves the mean position. All of it
    scales with the load of the bolts.
    """

    def __init__(
        self, candidates: Candidates, options: BasisOptions, resonance: int, variable: bool
    ) -> None:
        self._candidates, self._options, self._resonance = candidates, options, resonance
        k = options.contact_stiffness
        self._at_rest = np.maximum(candidates.normal_load, 0.0)
        self._normal_stiffness = k * variable
        # as the joint under variable load has it: a negative load is a gap
        self._load = self._at_rest - self._normal_stiffness * candidates.gap
        self._in_phase = k * candidates.loaded
        self._contact = SpringContact(
            candidates, self._in_phase, self._normal_stiffness * candidates.loaded
        )
        self._mode = self._found(_start(candidates))
        self._mean = np.zeros_like(self._mode)
        self._amplitude = 0.0

    def slip(self, share: float) -> None:
        """Settle where pairs that carry this share of the load slip."""
        for _ in range(_CORRECTIONS):
            self._amplitude = _load_quantile(self._candidates, self._onset(), share)
            self._correct()

    def grow(self) -> None:
        """Settle at a larger amplitude."""
        self._amplitude *= _GROWTH
        for _ in range(_CORRECTIONS):
            self._correct()

    def motions(self) -> Array:
        """The mode, its mean position, and what its loss and stiffness depend on.

        Returns
        -------
        ndarray
            Shape (candidates, 5): the mode; the mean position per amplitude; the static shapes of
            the gradients of the loss by either; that of the stiffness by the mode, which moves the
            mean position. Those under variable load alone vanish under constant load.
        """
        found = self._sensitivity()
        structure = self._options.loss_factor
        loss, growth = structure + found.loss, structure + max(found.growth, 0.0)
        relative = _LOSS / (loss ** (1 - _TO_GROWTH) * growth**_TO_GROWTH)
        motions = np.stack(
            [
                self._mode,
                _MEAN * self._mean / self._amplitude,
                relative * found.loss_by_mode,
                _MEAN * relative * found.loss_by_mean,
                found.stiffness_by_mode,
            ],
            axis=1,
        )
        size = _size(self._candidates, self._mode, self._options.contact_stiffness)
        return motions * (_LATER**self._resonance / size)

    def _sensitivity(self) -> "_Sensitivity":
        c, k = self._candidates, self._options.contact_stiffness
        mu, kn = self._options.friction_coefficient, self._normal_stiffness
        u, v = c.tangential @ self._mode, c.normal @ self._mode
        load = self._normal_load(v)
        slip = mu * load.sliding
        slips = k * self._amplitude * abs(u) > slip
        ratio = np.ones_like(u)
        np.divide(slip, k * self._amplitude * abs(u), out=ratio, where=slips)
        by_motion = 4 / np.pi * slips * slip / self._amplitude
        by_load = 4 / np.pi * slips * mu * abs(u) * (1 - 2 * ratio)

        held = SpringContact(c, self._in_phase, kn * load.closed)
        loss_by_mean = held.displacement(
            c.normal.T @ (c.weight * kn * load.sliding_by_load * by_load)
        )
        stiffness_by_mean = held.displacement(
            c.normal.T @ (c.weight * kn * 2 * load.by_amplitude * abs(v))
        )
        # a larger normal motion changes the load directly, and by the mean position that it moves
        through_load = kn * (
            load.sliding_by_amplitude * by_load - load.by_amplitude * (c.normal @ loss_by_mean)
        )
        through_mean = kn * load.by_amplitude * (c.normal @ stiffness_by_mean)
        return _Sensitivity(
            loss=by_motion @ (c.weight * abs(u) * (1 - ratio)),
            growth=by_motion @ (c.weight * abs(u) * ratio) + through_load @ (c.weight * abs(v)),
            loss_by_mode=self._contact.displacement(
                c.tangential.T @ (c.weight * by_motion * np.sign(u))
                + c.normal.T @ (c.weight * through_load * np.sign(v))
            ),
            loss_by_mean=loss_by_mean,
            stiffness_by_mode=self._contact.displacement(
                c.normal.T @ (c.weight * through_mean * np.sign(v))
            ),
        )

    def _onset(self) -> Array:
        """The amplitude from which each pair slips: k |u| = mu n."""
        c, k = self._candidates, self._options.contact_stiffness
        u = abs(c.tangential @ self._mode)
        onset = np.full(len(u), np.inf)
        slip = self._options.friction_coefficient * self._at_rest
        np.divide(slip, k * u, out=onset, where=c.loaded & (u > 0))
        return onset

    def _normal_load(self, v: Array) -> "_NormalLoad":
        c, kn = self._candidates, self._normal_stiffness
        return _NormalLoad(self._load + kn * (c.normal @ self._mean), kn * self._amplitude * abs(v))

    def _correct(self) -> None:
        """The mean position under the present mode, then the mode under the loads at it."""
        c, kn = self._candidates, self._normal_stiffness
        u, v = c.tangential @ self._mode, c.normal @ self._mode
        for _ in range(_MOST_MEANS):
            load = self._normal_load(v)
            force = c.normal.T @ (c.weight * (load.mean - self._at_rest)) + c.tangential.T @ (
                c.weight * self._in_phase * (c.tangential @ self._mean)
            )
            held = SpringContact(c, self._in_phase, kn * load.closed)
            change = held.displacement(self._mean + force)
            self._mean = self._mean - change
            if np.linalg.norm(change) <= _MEAN_FOUND * np.linalg.norm(self._mean):
                break
        load = self._normal_load(v)
        self._in_phase = _describing_function(
            self._options.contact_stiffness,
            self._options.friction_coefficient * load.sliding,
            self._amplitude * abs(u),
        )
        self._contact = SpringContact(c, self._in_phase, kn * load.secant)
        found = self._found(self._mode)
        self._mode = found * np.sign(found @ self._mode)

    def _found(self, start: Array) -> Array:
        return self._contact.modes(self._resonance + 1, start)[1][:, self._resonance]


class _Sensitivity(NamedTuple):
    """What friction takes from a slipping mode of unit strain energy, and what that depends on.

    Attributes
    ----------
    loss
        Loss factor [-]: the sum of ``4/pi mu n (u - mu n / (k A)) / A`` over the pairs that slip.
    growth
        Derivative of the damping force, loss times amplitude, by the amplitude [-].
    loss_by_mode, loss_by_mean
        Static shapes of the gradient of the loss by the mode and by the mean position per
        amplitude, shape (candidates,).
    stiffness_by_mode
        The same of the stiffness, by way of the mean position that the mode moves.
    """

    loss: float
    growth: float
    loss_by_mode: Array
    loss_by_mean: Array
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
        Share of the period [-], which is the derivative of the mean by n0.
    by_amplitude
        The derivative of the mean by A [-].
    secant
        First harmonic over A [-].
    sliding
        Mean as friction feels it that slides at the rate of a cosine [N]: weighted by its size.
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
    """The grade up to which pairs carry a share of the load."""
    order = np.argsort(grade, kind="stable")
    carried = np.cumsum((candidates.normal_load * candidates.weight)[order])
    # the last sum misses the total by rounding only
    reached = np.searchsorted(carried, share * carried[-1] * (1 - 1e-12))
    return grade[order[reached]]


def _size(candidates: Candidates, motion: Array, contact_stiffness: float) -> Array:
    """Root of a motion's strain energy, or of each of several, with the contact stuck."""
    moved, spring = candidates.rows @ motion, stuck_spring_stiffness(candidates, contact_stiffness)
    return np.sqrt((motion**2).sum(axis=0) + spring @ moved**2)


def _describing_function(k: float, slip_force: Array, amplitude: Array) -> Array:
    """Stiffness in phase of a spring with a slider (Jenkins element) [N/m].

    With ``cos(theta) = 1 - 2 mu n / (k A)``: ``k / pi (theta - sin(theta) cos(theta))`` (eq. 2.5
    over the loop 2.25).
    """
    ratio = np.ones_like(amplitude)
    np.divide(slip_force, k * amplitude, out=ratio, where=k * amplitude > slip_force)
    theta = 2 * np.arcsin(np.sqrt(ratio))
    return k / np.pi * (theta - np.sin(theta) * np.cos(theta))
