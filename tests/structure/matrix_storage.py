"""Matrices of bodies as CalculiX assembles them."""

import numpy as np
from scipy import sparse

from boltjoint.structure.calculix_program import run


def matrices_of_calculix(node, block, folder):
    """K and M of a body of one material, unknowns node by node as of ``assemble``.

    After these come unknowns that are internal to elements, of incompatible modes.
    """
    lines = ["*NODE, NSET=ALL"]
    # CalculiX reads no more than 20 characters of a number
    lines += [f"{i + 1}, {', '.join(f'{x:.13e}' for x in xyz)}" for i, xyz in enumerate(node)]
    lines.append(f"*ELEMENT, TYPE={block.kind.name}, ELSET=BODY")
    for i, nodes in enumerate(block.connectivity):
        fields = [str(each) for each in (i + 1, *(nodes + 1))]
        lines.append(", ".join(fields[:15]) + ("," if fields[15:] else ""))
        lines += [", ".join(fields[15:])] if fields[15:] else []
    material = block.material
    lines += [
        "*MATERIAL, NAME=M",
        "*ELASTIC",
        f"{material.youngs_modulus}, {material.poissons_ratio}",
        "*DENSITY",
        f"{material.density}",
        "*SOLID SECTION, ELSET=BODY, MATERIAL=M",
        "*STEP",
        "*FREQUENCY, SOLVER=MATRIXSTORAGE",
        "1",
        "*END STEP",
    ]
    (folder / "body.inp").write_text("\n".join(lines) + "\n")
    run(folder / "body.inp", folder / "body.log")
    dof = np.loadtxt(folder / "body.dof", dtype=str)
    label, direction = np.array([each.split(".") for each in dof], dtype=int).T
    unknown = 3 * (label - 1) + direction - 1
    beyond = unknown >= 3 * len(node)
    unknown[beyond] = 3 * len(node) + np.arange(beyond.sum())
    matrices = []
    for suffix in ("sti", "mas"):
        row, column, value = np.loadtxt(folder / f"body.{suffix}").T
        row, column = unknown[row.astype(int) - 1], unknown[column.astype(int) - 1]
        shape = 3 * len(node) + beyond.sum(), 3 * len(node) + beyond.sum()
        triangle = sparse.coo_array((value, (row, column)), shape=shape).tocsc()
        matrices.append((triangle + triangle.T - sparse.diags_array(triangle.diagonal())).tocsc())
    return matrices
