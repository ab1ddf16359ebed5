"""Files of matrices that the tests write: of a half lap and of a small structure."""

import h5py
import numpy as np
from scipy import sparse
from scipy.io import mmwrite, savemat

from boltjoint.config.matrices import Matrices

#: keys for the files that ``exported`` fills
KEYS = {
    "type": "matrices",
    "file": "joint.npz",
    "contact": {"side_a": "side_a", "side_b": "side_b"},
    "inputs": [{"name": "shaker", "row": "tip", "direction": "z"}],
    "outputs": [{"name": "sensor", "dof": 7, "direction": "x"}],
}


def pairs(structure):
    """Degrees of freedom of the nodes on sides A and B, of rows that each hold 1 and -1."""
    relative = structure.contact.relative.tocoo()
    sides = []
    for sign in (1, -1):
        is_side = relative.data == sign
        dof = np.zeros(relative.shape[0], dtype=np.int64)
        dof[relative.row[is_side]] = relative.col[is_side]
        sides.append(dof.reshape(-1, 3))
    return sides


def exported(structure, first=0):
    """Variables of a structure as another program writes them."""
    side_a, side_b = pairs(structure)
    contact = structure.contact
    return {
        "K": structure.stiffness,
        "M": structure.mass,
        "side_a": side_a + first,
        "side_b": side_b + first,
        "area": contact.area,
        "position": contact.position,
        "tip": structure.inputs["excitation"].row,
        "relative": contact.relative,
    }


def keys(structure, **changes):
    """Keys with the numbers of this structure, and others in their place."""
    first = changes.get("numbered_from", 0)
    bolts = [
        {"name": f"bolt-{number}", "locked": bolt.locked + first}
        for number, bolt in enumerate(structure.bolts, 1)
    ]
    return {**KEYS, "bolts": bolts, **changes}


def described(structure, **changes):
    return Matrices.model_validate(keys(structure, **changes))


def write_npz(path, variables):
    """Sparse matrices in parts, by columns."""
    arrays = {}
    for name, value in variables.items():
        if not sparse.issparse(value):
            arrays[name] = value
            continue
        matrix = value.tocsc()
        arrays |= {
            f"{name}_{part}": getattr(matrix, part) for part in ("data", "indices", "indptr")
        }
        arrays |= {f"{name}_shape": matrix.shape, f"{name}_format": "csc"}
    np.savez(path, **arrays)


def write_hdf5(path, variables):
    """As MATLAB does in version 7.3: a user block, columns first, and vectors as matrices."""
    with h5py.File(path, "w", userblock_size=512) as file:
        for name, value in variables.items():
            if sparse.issparse(value):
                matrix = value.tocsc()
                group = file.create_group(name)
                group.attrs["MATLAB_sparse"] = np.uint64(matrix.shape[0])
                if matrix.nnz:
                    group.create_dataset("data", data=matrix.data, chunks=True, compression=3)
                    group["ir"] = matrix.indices.astype(np.uint64)
                group["jc"] = matrix.indptr.astype(np.uint64)
            else:
                array = np.asarray(value)
                array = array[:, None] if array.ndim == 1 else array
                group = file.create_dataset(name, data=array.T)
            group.attrs["MATLAB_class"] = np.bytes_("double")
        # what MATLAB keeps of cells, and a structure
        reference = file.create_group("#refs#").create_dataset("a", data=np.ones(3)).ref
        file.create_dataset("cell", (1, 1), dtype=h5py.ref_dtype)[0, 0] = reference
        file.create_group("settings").attrs["MATLAB_class"] = np.bytes_("struct")
    with open(path, "r+b") as file:
        file.write(b"MATLAB 7.3 MAT-file, Platform: GLNXA64".ljust(124) + b"\x00\x02IM")


def write_markets(folder, variables):
    """A file for each matrix; symmetric ones as a triangle."""
    for name, value in variables.items():
        array = value if sparse.issparse(value) else np.atleast_2d(value).T
        if name.startswith(("side", "position", "loads")):
            array = value
        symmetry = "symmetric" if name in "KM" else "general"
        mmwrite(folder / f"{name}.mtx", array, symmetry=symmetry, precision=17)


def written(form, folder, structure, variables=None, **changes):
    """A description of files in one of the forms."""
    first = 0 if form == "npz" else 1
    variables = variables or exported(structure, first)
    if form == "npz":
        write_npz(folder / "joint.npz", variables)
    elif form == "mat 5":
        savemat(folder / "joint.mat", variables, do_compression=True, oned_as="column")
    elif form == "mat 7.3":
        write_hdf5(folder / "joint.mat", variables)
    else:
        write_markets(folder, variables)
        del variables["relative"]
        changes["files"] = [{"variable": name, "file": f"{name}.mtx"} for name in variables]
    file = {"npz": "joint.npz", "mtx": None}.get(form, "joint.mat")
    return described(structure, file=file, numbered_from=first, **changes)


#: a chain of two blocks between two walls, of which the blocks meet
DOFS = 12


def blocks():
    """Variables of a small structure: two nodes that meet, and two beside them."""
    K = 1e7 * (4 * np.eye(DOFS) - np.eye(DOFS, k=3) - np.eye(DOFS, k=-3))
    return {
        "K": K,
        "M": np.eye(DOFS),
        "side_a": [[0, 1, 2]],
        "side_b": [[3, 4, 5]],
        "area": [1e-4],
        "position": [[0.0, 0, 0]],
        "pull": np.eye(DOFS)[2] - np.eye(DOFS)[5],
    }


SMALL = {
    **{"type": "matrices", "file": "joint.npz"},
    "contact": {"side_a": "side_a", "side_b": "side_b"},
    "bolts": [{"name": "bolt", "load": "pull"}],
}
