"""Which few vectors let a contact stick, slip and open? A reduction basis that converges.

Modes of the structure without contact cannot follow the compliance around a bolt. Here the
candidates are such modes and the static shapes of unit forces on every contact pair, which together
resolve whatever the contact does. Patterns of stick, slip and opening are solved in them, and the
vectors that these motions have most in common are kept (proper orthogonal decomposition).

Only motion symmetric about the width is held: force, response and normal load are symmetric.
"""

import logging
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
import xarray as xr
from numpy.typing import NDArray
from scipy import sparse
from scipy.linalg import cho_factor, cho_solve, eigh
from scipy.sparse.linalg import ArpackError, LinearOperator, SuperLU, eigsh
from scipy.spatial import cKDTree
from threadpoolctl import threadpool_limits

from boltjoint import checks
from boltjoint.dataset import quantity
from boltjoint.structure.constraints import (
    assemble_assembly,
    check_held,
    factorise,
    free_displacements,
    relative_displacements,
)

logger = logging.getLogger(__name__)

Array = NDArray[np.float64]

#: right sides solved for at a time: enough for the factors to be read seldom, few enough to be held
_BLOCK = 64
#: candidates, or snapshots, whose share of the largest is below this depend on the others
_DEPENDENT = 1e-12
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


@dataclass(frozen=True)
class Enrichment:
    """What an enriched basis is made for.

    Parameters
    ----------
    contact_stiffness
        Of each contact pair, along the bar and across the contact [N/m].
    friction_coefficient
        mu [-]: decides whether pairs slip before they open.
    loss_factor
        Of the structure [-]: friction counts by what it adds to that.
    free_modes
        Symmetric modes without contact among the candidates.
    resonances
        The resonances whose motion the basis is to hold, from the first.
    levels
        Steps by which the load that slips grows from none to all of it.

    Raises
    ------
    ValueError
        If one of them is not positive, modes, resonances or levels are not whole numbers, or there
        are fewer free modes than resonances.
    """

    contact_stiffness: float = 1e8
    friction_coefficient: float = 0.1
    loss_factor: float = 0.002
    free_modes: int = 12
    resonances: int = 2
    levels: int = 14

    def __post_init__(self) -> None:
        """Refuse sizes that make no basis."""
        for name, value in vars(self).items():
            if name in ("free_modes", "resonances", "levels"):
                checks.whole(name, value, above=0)
            else:
                checks.number(name, value, above=0)
        if self.free_modes < self.resonances:
            raise ValueError(
                f"free_modes is {self.free_modes}: it must be at least resonances, "
                f"which is {self.resonances}"
            )


@dataclass(frozen=True)
class SymmetricHalf:
    """An assembly whose motion is symmetric about the width, without contact.

    Attributes
    ----------
    displacement
        T of ``u = T q`` from the unknowns to all nodes, shape (3 * nodes, unknowns).
    stiffness, mass
        K and M of the unknowns, for the whole assembly.
    """

    displacement: sparse.csc_array
    stiffness: sparse.csc_array
    mass: sparse.csc_array

    def unknowns(self, displacement: Array) -> Array:
        """The unknowns of symmetric displacements, shape (3 * nodes, motions)."""
        first = self.displacement.indptr[:-1]
        sign = self.displacement.data[first]
        return sign[:, None] * displacement[self.displacement.indices[first]]

    def modes(
        self, factors: SuperLU, stiffness: sparse.csc_array, count: int
    ) -> tuple[Array, Array]:
        """The first modes with a stiffness and its factors: squared frequencies and vectors.

        Raises
        ------
        RuntimeError
            If one of the frequencies is no number or zero within rounding.
        """
        # a fixed start that no mode is orthogonal to repeats the result
        start = np.random.default_rng(0).standard_normal(stiffness.shape[0])
        inverse = LinearOperator(stiffness.shape, factors.solve, dtype=float)
        squared, q = eigsh(stiffness, k=count, M=self.mass, sigma=0.0, OPinv=inverse, v0=start)
        check_held(squared, stiffness, self.mass)
        order = np.argsort(squared)
        return squared[order], q[:, order]


def symmetric_half(assembly: xr.Dataset) -> SymmetricHalf:
    """The assembly in unknowns that move both halves of its width alike.

    Raises
    ------
    ValueError
        If the mesh is not symmetric about y = 0.
    """
    T = symmetric_displacements(assembly)
    K, M = assemble_assembly(assembly)
    return SymmetricHalf(T, (T.T @ K @ T).tocsc(), (T.T @ M @ T).tocsc())


def symmetric_displacements(assembly: xr.Dataset) -> sparse.csc_array:
    """The matrix T of ``u = T q`` whose motions are symmetric about the width.

    Raises
    ------
    ValueError
        If the mesh is not symmetric about y = 0.
    """
    T = free_displacements(assembly, tightened=False)
    return (T @ _symmetric_unknowns(T, _mirrored_nodes(assembly))).tocsc()


@dataclass(frozen=True)
class Candidates:
    """Motions from which a basis is chosen, in coordinates a in which K is the unit matrix.

    Pairs are those on one side of the plane of symmetry and on it.

    Attributes
    ----------
    vector
        Modes and static shapes, shape (unknowns, vectors).
    coordinate
        What turns a into shares of the vectors, shape (vectors, candidates).
    mass
        M in these coordinates, shape (candidates, candidates).
    tangential, normal
        Relative displacement of the pairs along x and z, shape (pairs, candidates).
    weight
        2 for a pair that stands for its mirror image too, else 1, shape (pairs,).
    normal_load, gap
        Of the pairs after tightening [N], [m].
    pressure
        [Pa].
    position
        [m], shape (pairs, 3).
    bolt_position
        [m], shape (bolts, 3).
    """

    vector: Array
    coordinate: Array
    mass: Array
    tangential: Array
    normal: Array
    weight: Array
    normal_load: Array
    gap: Array
    pressure: Array
    position: Array
    bolt_position: Array

    @cached_property
    def rows(self) -> Array:
        """Tangential rows, then normal ones, shape (2 * pairs, candidates)."""
        return np.concatenate([self.tangential, self.normal])

    @cached_property
    def flexibility(self) -> Array:
        """Relative displacements for unit forces [m/N], shape (2 * pairs, 2 * pairs)."""
        return self.rows @ self.rows.T

    @property
    def loaded(self) -> NDArray[np.bool_]:
        """The pairs that carry load."""
        return self.normal_load > 0


class SpringContact:
    """The candidates with a linear spring on each pair.

    Parameters
    ----------
    candidates
        The motions.
    tangential, normal
        Stiffness of the pairs along x and z [N/m], shape (pairs,).
    """

    def __init__(self, candidates: Candidates, tangential: Array, normal: Array) -> None:
        self.candidates = candidates
        stiffness = np.concatenate([tangential, normal]) * np.tile(candidates.weight, 2)
        # springs that are weak against all others only spoil the condition of what follows
        acting = np.flatnonzero(stiffness > 1e-6 * stiffness.max(initial=0.0))
        self._acting = acting
        self._stiffness, self._rows = stiffness[acting], candidates.rows[acting]

    @cached_property
    def _factors(self) -> tuple[Array, bool]:
        """Of the compliance of the springs and what is between them, if any is asked for."""
        compliance = self.candidates.flexibility[np.ix_(self._acting, self._acting)]
        compliance[np.diag_indices(self._acting.size)] += 1 / self._stiffness
        return cho_factor(compliance, overwrite_a=True)

    def displacement(self, force: Array) -> Array:
        """(1 + R^T D R)^-1 times a force, by Woodbury's formula over the springs that act."""
        if not (self._acting.size and force.any()):
            return force
        return force - self._rows.T @ cho_solve(self._factors, self._rows @ force)

    def modes(self, count: int, start: Array) -> tuple[Array, Array]:
        """Squared frequencies and modes of unit strain energy, from a first guess."""
        n = len(self.candidates.mass)
        stiffness = LinearOperator(
            (n, n),
            lambda a: a + self._rows.T @ (self._stiffness * (self._rows @ a)),
            dtype=float,
        )
        inverse = LinearOperator((n, n), self.displacement, dtype=float)
        # low modes have the largest ratio of mass to stiffness
        ratio, a = eigsh(
            self.candidates.mass,
            k=count,
            M=stiffness,
            Minv=inverse,
            v0=start,
            ncv=min(n, 2 * count + 8),
        )
        order = np.argsort(-ratio)
        return 1 / ratio[order], a[:, order]


# one thread: sums in another order would change the last digits from machine to machine
@threadpool_limits.wrap(limits=1, user_api="blas")
def find_principal_motions(
    assembly: xr.Dataset,
    preload: xr.Dataset,
    enrichment: Enrichment | None = None,
    most: int = 80,
) -> xr.Dataset:
    """Vectors that an assembly's motions have most in common while its contact sticks and slips.

    Any first N of them make a basis ``enriched-N``, so they are found once for all N.

    Parameters
    ----------
    assembly, preload
        As from ``build_assembly`` and ``apply_preload``. Only the ratios of the loads matter, not
        how tight the bolts are.
    enrichment
        What they are made for; the defaults of ``Enrichment`` if left out.
    most
        Vectors kept, or as many as the motions span if those are fewer.

    Returns
    -------
    Dataset
        ``principal_motion`` (node, axis, motion) [m J^-1/2], the most common first, orthonormal in
        strain energy (``v^T K v = 1``, K with springs on the loaded pairs); ``energy_share``
        (motion): energy that all motions, as they count, have along it, over all of theirs;
        ``position`` (pair, axis) [m].

    Raises
    ------
    ValueError
        If preload and assembly do not hold the same pairs, no pair carries load, the mesh is not
        symmetric about y = 0, or ``most`` is not positive.
    RuntimeError
        If the assembly is not held, or the motions are lost in rounding.
    """
    most = checks.whole("most", most, above=0)
    enrichment = Enrichment() if enrichment is None else enrichment
    checks.instance("enrichment", enrichment, Enrichment)
    half = symmetric_half(assembly)
    candidates = find_candidates(assembly, preload, half, enrichment.free_modes)
    try:
        motion = np.concatenate(
            [*stuck_motions(candidates, enrichment), *slipping_motions(candidates, enrichment)],
            axis=1,
        )
        kept, share = principal_motions(candidates, motion, most, enrichment.contact_stiffness)
    except (ArpackError, ValueError) as error:
        # SciPy's refusal of matrices that overflowed, or that rounding has made indefinite
        raise RuntimeError(
            f"the motions of {enrichment} are lost in rounding ({error}): choose the values of "
            "enrichment nearer to their defaults"
        ) from error
    logger.info(
        "enrichment: %d candidates, %d motions, %d principal ones",
        len(candidates.mass),
        motion.shape[1],
        len(share),
    )
    vector = half.displacement @ (candidates.vector @ (candidates.coordinate @ kept))
    return xr.Dataset(
        {
            "principal_motion": quantity(
                ("node", "axis", "motion"),
                vector.reshape(-1, 3, len(share)),
                "m J^-1/2",
                "principal motion, of unit strain energy with the contact stuck",
            ),
            "energy_share": quantity(
                "motion", share, "1", "strain energy of all motions along it, over all of theirs"
            ),
            "position": assembly["position"].variable,
        },
        coords={"axis": assembly["axis"].variable},
    )


def enriched_basis(assembly: xr.Dataset, principal: xr.Dataset, number: int) -> tuple[Array, Array]:
    """The first principal motions of an assembly as vectors that can be used like modes.

    Parameters
    ----------
    assembly, principal
        As from ``build_assembly`` and, for the same assembly, ``find_principal_motions``.
    number
        Vectors in all.

    Returns
    -------
    tuple
        Frequencies of the vectors without contact, ascending, shape (number,) [Hz], and their
        shapes (nodes, 3, number) [kg^-1/2], orthonormal in M and diagonal in K.

    Raises
    ------
    ValueError
        If assembly and principal motions do not belong together, or there are fewer of them.
    RuntimeError
        If a frequency is no number or zero within rounding: the assembly is not held.
    """
    number = checks.whole("number", number, at_least=1)
    position = checks.variable("principal", principal, "position", ("pair", "axis"))
    if principal.sizes["node"] != assembly.sizes["node"] or not np.array_equal(
        position, assembly["position"].to_numpy()
    ):
        raise ValueError("the principal motions were found on a different mesh")
    if number > principal.sizes["motion"]:
        raise ValueError(
            f"enriched-{number}: there are {principal.sizes['motion']} principal motions; keep "
            "more of them, or find them for more levels if they span no more"
        )
    half = symmetric_half(assembly)
    motion = principal["principal_motion"].transpose("node", "axis", "motion")[..., :number]
    vector = half.unknowns(motion.to_numpy().reshape(-1, number))
    squared, share = eigh(vector.T @ (half.stiffness @ vector), vector.T @ (half.mass @ vector))
    check_held(squared, half.stiffness, half.mass)
    shape = half.displacement @ (vector @ share)
    return np.sqrt(squared) / (2 * np.pi), shape.reshape(-1, 3, number)


def find_candidates(
    assembly: xr.Dataset, preload: xr.Dataset, half: SymmetricHalf, free_modes: int
) -> Candidates:
    """Modes without contact and the static shapes of unit forces on every pair along x and z.

    The shapes make the contact's flexibility exact, the modes the inertia at low frequency.

    Parameters
    ----------
    assembly, preload
        As from ``build_assembly`` and ``apply_preload``.
    half
        From ``symmetric_half``.
    free_modes
        Number of modes.

    Raises
    ------
    ValueError
        If the datasets do not hold the same pairs, or no pair carries load.
    """
    position = assembly["position"].to_numpy()
    if not np.array_equal(position, preload["position"].to_numpy()):
        raise ValueError("assembly and preload have different contact pairs")
    if not np.any(preload["normal_load"] > 0):
        raise ValueError("no contact pair carries load")
    across = 1e-9 * np.ptp(position[:, 1])
    pair = np.flatnonzero(position[:, 1] > -across)
    K, M = half.stiffness, half.mass
    C = (relative_displacements(assembly) @ half.displacement).tocsr()
    C = C[np.concatenate([3 * pair, 3 * pair + 2])]

    factors = factorise(K)
    squared, mode = half.modes(factors, K, free_modes)
    vector = np.empty((K.shape[0], free_modes + C.shape[0]), order="F")
    vector[:, :free_modes] = mode
    for first in range(0, C.shape[0], _BLOCK):
        force = C[first : first + _BLOCK].T.toarray()
        vector[:, free_modes + first :][:, : force.shape[1]] = factors.solve(force)

    # K times a static shape is its force, and modes are orthogonal
    moved = C @ vector
    stiffness = np.empty((vector.shape[1], vector.shape[1]))
    stiffness[:free_modes, :free_modes] = np.diag(squared)
    stiffness[free_modes:] = moved
    stiffness[:free_modes, free_modes:] = moved[:, :free_modes].T
    stiffness, mass = _symmetric(stiffness), _projected(M, vector)
    scale = 1 / np.sqrt(np.diag(stiffness))
    share, turn = eigh(scale[:, None] * stiffness * scale)
    independent = share > _DEPENDENT * share[-1]
    coordinate = scale[:, None] * turn[:, independent] / np.sqrt(share[independent])
    tangential, normal = np.split(moved @ coordinate, 2)
    load = preload["normal_load"].to_numpy()[pair]
    return Candidates(
        vector=vector,
        coordinate=coordinate,
        mass=_symmetric(coordinate.T @ mass @ coordinate),
        tangential=tangential,
        normal=normal,
        weight=np.where(position[pair, 1] > across, 2.0, 1.0),
        normal_load=load,
        gap=preload["gap"].to_numpy()[pair],
        pressure=load / assembly["area"].to_numpy()[pair],
        position=position[pair],
        bolt_position=assembly["bolt_position"].to_numpy(),
    )


def stuck_motions(candidates: Candidates, enrichment: Enrichment) -> Iterator[Array]:
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
    weight = _LATER ** np.arange(enrichment.resonances)
    count, k = enrichment.resonances, enrichment.contact_stiffness
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
        for level in range(enrichment.levels):
            # the pairs on the rim of the pressure are many and carry little
            share = 1 - (level / enrichment.levels) ** 2
            inside = candidates.loaded & (grade <= _load_quantile(candidates, grade, share))
            for part in [*halves, *(around + sides if level % _STRIDE == 0 else [])]:
                spring = k * (inside & part)
                for normal in (none, spring):
                    yield counting(spring, normal)


def slipping_motions(candidates: Candidates, enrichment: Enrichment) -> Iterator[Array]:
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
    shares = (np.arange(1, enrichment.levels + 1) / (enrichment.levels + 1)) ** 3
    for variable in (False, True):
        for resonance in range(enrichment.resonances):
            mode = _SlippingMode(candidates, enrichment, resonance, variable)
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
        self, candidates: Candidates, enrichment: Enrichment, resonance: int, variable: bool
    ) -> None:
        self._candidates, self._enrichment, self._resonance = candidates, enrichment, resonance
        k = enrichment.contact_stiffness
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
        structure = self._enrichment.loss_factor
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
        size = _size(self._candidates, self._mode, self._enrichment.contact_stiffness)
        return motions * (_LATER**self._resonance / size)

    def _sensitivity(self) -> "_Sensitivity":
        c, k = self._candidates, self._enrichment.contact_stiffness
        mu, kn = self._enrichment.friction_coefficient, self._normal_stiffness
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
        c, k = self._candidates, self._enrichment.contact_stiffness
        u = abs(c.tangential @ self._mode)
        onset = np.full(len(u), np.inf)
        slip = self._enrichment.friction_coefficient * self._at_rest
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
            self._enrichment.contact_stiffness,
            self._enrichment.friction_coefficient * load.sliding,
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


def principal_motions(
    candidates: Candidates, motion: Array, most: int, contact_stiffness: float
) -> tuple[Array, Array]:
    """The vectors that many motions have most in common, by proper orthogonal decomposition.

    The norm is the strain energy with springs on all loaded pairs: an error in a resonance is the
    error of its mode in about that norm, squared.

    Parameters
    ----------
    candidates
        The space of the motions.
    motion
        Shape (candidates, motions), each as large as it counts.
    most
        Vectors kept, or as many as the motions span if those are fewer.
    contact_stiffness
        Of the springs, along x and z [N/m].

    Returns
    -------
    tuple
        The vectors, orthonormal in that norm, the most common first, shape (candidates, vectors);
        and the energy of the motions along each over that of them all, shape (vectors,).
    """
    moved, spring = candidates.rows @ motion, _stuck_springs(candidates, contact_stiffness)
    energy, turn = eigh(motion.T @ motion + moved.T @ (spring[:, None] * moved))
    energy, turn = energy[::-1], turn[:, ::-1]
    number = min(most, np.count_nonzero(energy > _DEPENDENT * energy[0]))
    vector = motion @ (turn[:, :number] / np.sqrt(energy[:number]))
    return vector, energy[:number] / energy.sum()


def _mirrored_nodes(assembly: xr.Dataset) -> NDArray[np.int64]:
    """The node on the other side of y = 0 of every node."""
    coordinate = assembly["coordinate"].to_numpy()
    part = assembly["part"].to_numpy().astype(np.int64)
    connectivity = assembly["connectivity"].to_numpy()
    # nodes at one place belong to different bodies, or to the two sides of a pretension section
    body = np.full(len(coordinate), part.max() + 1)
    np.minimum.at(body, connectivity, part[:, None])
    body[assembly["section_node"].to_numpy()[:, 1]] += part.max() + 1
    mirrored = np.empty(len(coordinate), dtype=np.int64)
    for each in np.unique(body):
        node = np.flatnonzero(body == each)
        distance, nearest = cKDTree(coordinate[node]).query(coordinate[node] * [1, -1, 1])
        if distance.max() > 1e-9 * np.ptp(coordinate[:, 1]):
            raise ValueError("the mesh is not symmetric about y = 0")
        mirrored[node] = node[nearest]
    return mirrored


def _symmetric_unknowns(T: sparse.csc_array, mirrored_node: NDArray[np.int64]) -> sparse.csc_array:
    """The matrix that takes unknowns of symmetric motion to those of ``u = T q``."""
    displacement = T.indices[T.indptr[:-1]]
    node, axis = np.divmod(displacement, 3)
    # every displacement follows one unknown; those that are held follow none and are not asked for
    follows = np.zeros(T.shape[0], dtype=np.int64)
    follows[T.indices] = np.repeat(np.arange(T.shape[1]), np.diff(T.indptr))
    image = follows[3 * mirrored_node[node] + axis]
    sign = np.where(axis == 1, -1.0, 1.0)
    own = np.arange(T.shape[1])
    # on the plane of symmetry nothing moves along y
    kept = np.flatnonzero((own < image) | ((own == image) & (sign > 0)))
    column = np.arange(kept.size)
    two = image[kept] != kept
    return sparse.csc_array(
        (
            np.concatenate([np.ones(kept.size), sign[kept][two]]),
            (np.concatenate([kept, image[kept][two]]), np.concatenate([column, column[two]])),
        ),
        shape=(T.shape[1], kept.size),
    )


def _projected(matrix: sparse.csc_array, vector: Array) -> Array:
    """V^T A V of symmetric A, a block of columns at a time, since A V is as large as V."""
    count = vector.shape[1]
    found = np.zeros((count, count))
    for first in range(0, count, _BLOCK):
        block = slice(first, first + _BLOCK)
        found[: first + _BLOCK, block] = vector[:, : first + _BLOCK].T @ (matrix @ vector[:, block])
    upper = np.triu(found)
    return upper + np.triu(upper, 1).T


def _symmetric(matrix: Array) -> Array:
    return (matrix + matrix.T) / 2


def _start(candidates: Candidates) -> Array:
    return np.random.default_rng(0).standard_normal(len(candidates.mass))


def _load_quantile(candidates: Candidates, grade: Array, share: float) -> float:
    """The grade up to which pairs carry a share of the load."""
    order = np.argsort(grade, kind="stable")
    carried = np.cumsum((candidates.normal_load * candidates.weight)[order])
    # the last sum misses the total by rounding only
    reached = np.searchsorted(carried, share * carried[-1] * (1 - 1e-12))
    return grade[order[reached]]


def _stuck_springs(candidates: Candidates, contact_stiffness: float) -> Array:
    """Springs on all loaded pairs along x, then along z [N/m]."""
    return np.tile(contact_stiffness * candidates.loaded * candidates.weight, 2)


def _size(candidates: Candidates, motion: Array, contact_stiffness: float) -> Array:
    """Root of a motion's strain energy, or of each of several, with the contact stuck."""
    moved, spring = candidates.rows @ motion, _stuck_springs(candidates, contact_stiffness)
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
