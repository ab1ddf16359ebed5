"""Proper orthogonal decomposition (POD) of snapshots into a contact-adapted basis."""

import logging

import numpy as np
import xarray as xr
from numpy.typing import NDArray
from scipy.linalg import eigh
from scipy.sparse.linalg import ArpackError
from threadpoolctl import threadpool_limits

from boltjoint import checks
from boltjoint.dataset import quantity
from boltjoint.structure.basis.candidates import (
    DEPENDENT_SHARE,
    BasisOptions,
    Candidates,
    find_candidates,
    stuck_spring_stiffness,
)
from boltjoint.structure.basis.snapshots import slipping_snapshots, stuck_snapshots
from boltjoint.structure.constraints import check_held
from boltjoint.structure.symmetry import symmetric_half

logger = logging.getLogger(__name__)


Array = NDArray[np.float64]


# one thread: sums in another order would change the last digits from machine to machine
@threadpool_limits.wrap(limits=1, user_api="blas")
def find_pod_modes(
    assembly: xr.Dataset,
    preload: xr.Dataset,
    options: BasisOptions | None = None,
    most: int = 80,
) -> xr.Dataset:
    """Vectors that an assembly's motions have most in common while its contact sticks and slips.

    Any first N of them make a basis ``enriched-N``, so they are found once for all N.

    Parameters
    ----------
    assembly, preload
        As from ``build_assembly`` and ``apply_preload``. Only the ratios of the loads matter, not
        how tight the bolts are.
    options
        What they are made for; the defaults of ``BasisOptions`` if left out.
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
    options = BasisOptions() if options is None else options
    checks.instance("options", options, BasisOptions)
    half = symmetric_half(assembly)
    candidates = find_candidates(assembly, preload, half, options.free_modes)
    try:
        motion = np.concatenate(
            [*stuck_snapshots(candidates, options), *slipping_snapshots(candidates, options)],
            axis=1,
        )
        kept, share = proper_orthogonal_modes(candidates, motion, most, options.contact_stiffness)
    except (ArpackError, ValueError) as error:
        # SciPy's refusal of matrices that overflowed, or that rounding has made indefinite
        raise RuntimeError(
            f"the motions of {options} are lost in rounding ({error}): choose the values of "
            "contact_adapted_basis nearer to their defaults"
        ) from error
    logger.info(
        "contact-adapted basis: %d candidates, %d snapshots, %d POD modes",
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
        As from ``build_assembly`` and, for the same assembly, ``find_pod_modes``.
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


def proper_orthogonal_modes(
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
    moved, spring = candidates.rows @ motion, stuck_spring_stiffness(candidates, contact_stiffness)
    energy, turn = eigh(motion.T @ motion + moved.T @ (spring[:, None] * moved))
    energy, turn = energy[::-1], turn[:, ::-1]
    number = min(most, np.count_nonzero(energy > DEPENDENT_SHARE * energy[0]))
    vector = motion @ (turn[:, :number] / np.sqrt(energy[:number]))
    return vector, energy[:number] / energy.sum()
