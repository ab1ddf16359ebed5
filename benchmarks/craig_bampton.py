"""A Craig-Bampton model of a shipped assembly beside the full one, both by matrices alone.

    python benchmarks/craig_bampton.py [ASSEMBLY]

The reduced model keeps all degrees of freedom of the contact, the bolts and the excitation, and
some modes of the rest with these held. Three bolts keep 8224 of 89,691: the static modes take 6 GB,
the whole an hour of one thread. Each model has a preload, a contact-adapted basis and responses of
its own. Printed are their differences, beside the errors that both bases estimate and, of converged
peaks, the error bars of both.
"""

import sys
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy import sparse
from scipy.sparse.linalg import LinearOperator, eigsh

from boltjoint.config.numerical_options import ContactAdaptedBasis
from boltjoint.config.study import load_study
from boltjoint.dynamics.reduction.basis_from_backbones import find_pod_modes
from boltjoint.dynamics.reduction.contact_condition import ContactCondition
from boltjoint.dynamics.response.converged_peaks import converge_peaks
from boltjoint.dynamics.response.frequency_response import solve_response
from boltjoint.structure.factors import factorise
from boltjoint.structure.makers.registry import make
from boltjoint.structure.model import Structure
from boltjoint.structure.modes import find_modes
from boltjoint.structure.preload import apply_preload

ROOT = Path(__file__).parents[1]
PRELOAD, FORCES, LOSS_FACTOR = 8e3, [5.0, 20.0, 60.0], 2e-3  # N, N
CONTACT = {
    "law": "constant",
    "tangential_stiffness_N_per_m": 1e8,
    "friction_coefficient": 0.1,
}
#: modes of the rest, and columns that are solved and multiplied at a time
HELD_MODES, AT_ONCE = 30, 200
QUANTITIES = ("frequency", "amplitude")
Array = NDArray[np.float64]


def as_matrices(structure: Structure) -> Structure:
    """What another program would know of a structure."""
    return Structure.from_matrices(
        structure.stiffness,
        structure.mass,
        structure.contact,
        bolts={bolt.name: bolt.locked for bolt in structure.bolts},
        inputs={name: row.row for name, row in structure.inputs.items()},
        outputs={name: row.row for name, row in structure.outputs.items()},
    )


def craig_bampton(structure: Structure) -> Structure:
    """The reduced model of a structure."""
    contact = structure.contact
    excited = np.flatnonzero(structure.inputs["excitation"].row)
    kept = np.unique(np.concatenate([contact.relative.indices, structure.held, excited]))
    rest = np.setdiff1d(np.arange(structure.dofs), kept)
    size = kept.size + HELD_MODES
    inside, beside = (
        {name: getattr(structure, name)[rest][:, columns].tocsc() for name in ("stiffness", "mass")}
        for columns in (rest, kept)
    )
    factors = factorise(inside["stiffness"], "nested-dissection")
    vectors = np.empty((rest.size, size), order="F")
    for first in range(0, kept.size, AT_ONCE):
        columns = slice(first, min(first + AT_ONCE, kept.size))
        vectors[:, columns] = -factors.solve(beside["stiffness"][:, columns].toarray())
    inverse = LinearOperator(inside["stiffness"].shape, factors.solve, dtype=float)
    start = np.ones(rest.size)
    K, M = inside["stiffness"], inside["mass"]
    held = eigsh(K, HELD_MODES, M, sigma=0, OPinv=inverse, v0=start)
    vectors[:, kept.size :] = held[1]
    reduced = {}
    for name in ("stiffness", "mass"):
        matrix = np.zeros((size, size))
        matrix[: kept.size, : kept.size] = getattr(structure, name)[kept][:, kept].toarray()
        across = beside[name].T @ vectors
        matrix[: kept.size] += across
        matrix[:, : kept.size] += across.T
        for first in range(0, size, AT_ONCE):
            columns = slice(first, first + AT_ONCE)
            matrix[:, columns] += vectors.T @ (inside[name] @ vectors[:, columns])
        reduced[name] = sparse.csc_array((matrix + matrix.T) / 2)

    def row(full: Array) -> Array:
        own = full[rest] @ vectors
        own[: kept.size] += full[kept]
        return own

    relative = sparse.csr_array(contact.relative[:, kept])
    relative.resize(relative.shape[0], size)
    return Structure.from_matrices(
        reduced["stiffness"],
        reduced["mass"],
        replace(contact, relative=relative),
        bolts={bolt.name: int(np.searchsorted(kept, bolt.locked)) for bolt in structure.bolts},
        inputs={name: row(of.row) for name, of in structure.inputs.items()},
        outputs={name: row(of.row) for name, of in structure.outputs.items()},
        # its matrices are full
        factorisation="superlu",
    )


def solve(name: str, structure: Structure) -> Mapping[str, Array]:
    """Frequencies without contact, loads, errors of the basis, peaks and their bars."""
    found = {"free": find_modes(structure, "all-4")["natural_frequency"].to_numpy()}
    preload = apply_preload(structure, PRELOAD, tolerance=1e-12)
    found["load"] = preload["normal_load"].to_numpy()
    condition = ContactCondition.of(CONTACT, LOSS_FACTOR)
    pod_modes = find_pod_modes(structure, preload, [condition], ContactAdaptedBasis())
    modes = find_modes(structure, "enriched-auto", pod_modes)
    joint = condition.connect(preload, modes)
    responses = {
        method: solve_response(joint, FORCES, method=method, damping=LOSS_FACTOR)
        for method in ("linear", "backbone")
    }
    converged = converge_peaks(joint, responses["linear"])
    for what in QUANTITIES:
        found[f"estimated {what}"] = np.array(modes.attrs[f"estimated_{what}_error"])
        for method, response in responses.items():
            found[f"{method} {what}"] = response[f"peak_{what}"].to_numpy()
        found[f"converged {what}"] = converged[f"peak_{what}_converged"].to_numpy()
        found[f"bar {what}"] = converged[f"peak_{what}_truncation_error"].to_numpy()
    print(f"{name}: {structure.dofs} degrees of freedom, {modes.attrs['vectors']} vectors")
    return found


def main(assembly: str = "three_bolt") -> None:
    """Print how far the reduced model is off."""
    structure = make(load_study(ROOT).assemblies[assembly], ROOT)[1]
    full = solve("full", as_matrices(structure))
    reduced = solve("Craig-Bampton", craig_bampton(structure))
    print(f"frequencies without contact: {abs(reduced['free'] / full['free'] - 1).max():.1e}")
    load = abs(reduced["load"] - full["load"]).max() / full["load"].max()
    print(f"normal loads over the largest: {load:.1e}")
    for what in QUANTITIES:
        for of in ("linear", "backbone", "converged"):
            off = abs(reduced[f"{of} {what}"] / full[f"{of} {what}"] - 1)
            allowed = full[f"estimated {what}"] + reduced[f"estimated {what}"]
            if of == "converged":
                allowed = allowed + full[f"bar {what}"] + reduced[f"bar {what}"]
            share = (off / allowed).max()
            print(f"{of} {what}: off by up to {off.max():.1e}, {share:.2f} of what is allowed")


if __name__ == "__main__":
    main(*sys.argv[1:])
