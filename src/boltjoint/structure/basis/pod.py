"""Contact-adapted basis: POD modes of snapshots of a contact that sticks, slips and opens.

The snapshots are solved in candidates that resolve whatever the contact does. Their proper
orthogonal decomposition (POD) in the norm of strain energy keeps the vectors they have most in
common. Any first N of these POD modes make the basis ``enriched-N``.

References
----------
G. Berkooz, P. Holmes, J. L. Lumley: The proper orthogonal decomposition in the analysis of
turbulent flows. Annual Review of Fluid Mechanics 25 (1993) 539-575.
"""

import logging
from typing import TYPE_CHECKING

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
    Candidates,
    find_candidates,
    stuck_spring_stiffness,
)
from boltjoint.structure.basis.snapshots import slipping_snapshots, stuck_snapshots
from boltjoint.structure.constraints import check_held
from boltjoint.structure.symmetry import symmetric_half

if TYPE_CHECKING:
    from boltjoint.config.contact_adapted_basis import ContactAdaptedBasis

logger = logging.getLogger(__name__)

Array = NDArray[np.float64]


# one thread: sums in another order would change the last digits from machine to machine
@threadpool_limits.wrap(limits=1, user_api="blas")
def find_pod_modes(
    assembly: xr.Dataset, preload: xr.Dataset, options: "ContactAdaptedBasis"
) -> xr.Dataset:
    """POD modes of an assembly whose contact sticks, slips and opens.

    Parameters
    ----------
    assembly, preload
        As from ``build_assembly`` and ``apply_preload``. Only the ratios of the loads matter, not
        their size.
    options
        Contact, resonances and slip levels of the snapshots, and the number of POD modes; there are
        fewer where the snapshots span fewer.

    Returns
    -------
    Dataset
        ``pod_mode_shape`` (node, axis, pod_mode) [m J^-1/2], by decreasing energy, orthonormal in
        strain energy (``v^T K v = 1``, K with springs on the loaded pairs); ``energy_share``
        (pod_mode): energy of the weighted snapshots along it, over all of theirs; ``position``
        (pair, axis) [m].

    Raises
    ------
    ValueError
        If preload and assembly do not hold the same pairs, no pair carries load, or the mesh is not
        symmetric about y = 0.
    RuntimeError
        If the assembly is not held, or the snapshots are lost in rounding.
    """
    half = symmetric_half(assembly)
    candidates = find_candidates(assembly, preload, half, options.free_modes)
    try:
        snapshots = np.concatenate(
            [*stuck_snapshots(candidates, options), *slipping_snapshots(candidates, options)],
            axis=1,
        )
        pod_modes, share = proper_orthogonal_modes(
            candidates, snapshots, options.maximum_vectors, options.contact_stiffness_N_per_m
        )
    except (ArpackError, ValueError) as error:
        # SciPy's refusal of matrices that overflowed, or that rounding has made indefinite
        raise RuntimeError(
            f"the snapshots of {options!r} are lost in rounding ({error}): choose the values of "
            "contact_adapted_basis nearer to their defaults"
        ) from error
    logger.info(
        "contact-adapted basis: %d candidates, %d snapshots, %d POD modes",
        len(candidates.mass),
        snapshots.shape[1],
        len(share),
    )
    shape = half.displacement @ (candidates.vector @ (candidates.coordinate @ pod_modes))
    return xr.Dataset(
        {
            "pod_mode_shape": quantity(
                ("node", "axis", "pod_mode"),
                shape.reshape(-1, 3, len(share)),
                "m J^-1/2",
                "POD mode, of unit strain energy with the contact stuck",
            ),
            "energy_share": quantity(
                "pod_mode", share, "1", "strain energy of the snapshots along it, over all of it"
            ),
            "position": assembly["position"].variable,
        },
        coords={"axis": assembly["axis"].variable},
    )


def basis_of_pod_modes(
    assembly: xr.Dataset, pod_modes: xr.Dataset, number: int
) -> tuple[Array, Array]:
    """The first POD modes of an assembly as a basis that is used like modes.

    Parameters
    ----------
    assembly, pod_modes
        As from ``build_assembly`` and, for the same assembly, ``find_pod_modes``.
    number
        Number of vectors.

    Returns
    -------
    tuple
        Frequencies of the vectors without contact, ascending, shape (number,) [Hz], and their
        shapes (nodes, 3, number) [kg^-1/2], orthonormal in M and diagonal in K.

    Raises
    ------
    ValueError
        If the POD modes are of another mesh, or there are fewer of them.
    RuntimeError
        If a frequency is no number or zero within rounding: the assembly is not held.
    """
    number = checks.whole("number", number, at_least=1)
    position = checks.variable("pod_modes", pod_modes, "position", ("pair", "axis"))
    if pod_modes.sizes["node"] != assembly.sizes["node"] or not np.array_equal(
        position, assembly["position"].to_numpy()
    ):
        raise ValueError("the POD modes were found on a different mesh")
    if number > pod_modes.sizes["pod_mode"]:
        raise ValueError(
            f"enriched-{number}: there are {pod_modes.sizes['pod_mode']} POD modes; keep more of "
            "them, or find them for more slip levels if the snapshots span no more"
        )
    half = symmetric_half(assembly)
    shape = pod_modes["pod_mode_shape"].transpose("node", "axis", "pod_mode")[..., :number]
    vector = half.unknowns(shape.to_numpy().reshape(-1, number))
    squared, share = eigh(vector.T @ (half.stiffness @ vector), vector.T @ (half.mass @ vector))
    check_held(squared, half.stiffness, half.mass)
    shape = half.displacement @ (vector @ share)
    return np.sqrt(squared) / (2 * np.pi), shape.reshape(-1, 3, number)


def proper_orthogonal_modes(
    candidates: Candidates, snapshots: Array, maximum: int, contact_stiffness: float
) -> tuple[Array, Array]:
    """Proper orthogonal decomposition of snapshots in the norm of strain energy.

    The strain energy is that with springs on all loaded pairs: the error of a resonance is about
    the squared error of its mode in that norm.

    Parameters
    ----------
    candidates
        The space of the snapshots.
    snapshots
        Weighted, shape (candidates, snapshots).
    maximum
        POD modes kept, or as many as the snapshots span if those are fewer.
    contact_stiffness
        Of the springs, along x and z [N/m].

    Returns
    -------
    tuple
        POD modes, orthonormal in that norm, by decreasing energy, shape (candidates, POD modes);
        and the energy of the snapshots along each over all of it, shape (POD modes,).
    """
    moved = candidates.rows @ snapshots
    spring = stuck_spring_stiffness(candidates, contact_stiffness)
    energy, turn = eigh(snapshots.T @ snapshots + moved.T @ (spring[:, None] * moved))
    energy, turn = energy[::-1], turn[:, ::-1]
    number = min(maximum, np.count_nonzero(energy > DEPENDENT_SHARE * energy[0]))
    pod_modes = snapshots @ (turn[:, :number] / np.sqrt(energy[:number]))
    return pod_modes, energy[:number] / energy.sum()
