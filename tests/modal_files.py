"""Files of modal data that the tests write: modes at contact points, or at nodes as of a test."""

import numpy as np
import pyuff
from matrix_files import write_hdf5, write_npz
from scipy.io import savemat

from boltjoint.config.matrices import Matrices

LOAD = 8e3
#: keys for modes at contact points, inputs and outputs
KEYS = {
    "type": "matrices",
    "file": "joint.npz",
    "modes": {},
    "contact": {
        "relative": "relative",
        "relative_along": "frame",
        "normal_load": "normal_load",
        "gap": "gap",
        "preload_N": LOAD,
    },
    "inputs": [{"name": "shaker", "row": "tip", "direction": "z"}],
    "outputs": [{"name": "sensor", "row": "tip", "direction": "z"}],
}
#: keys for modes at nodes, in a universal file
NODES = KEYS | {
    "modes": {"file": "test.unv"},
    "contact": {
        "side_a": "side_a",
        "side_b": "side_b",
        "normal_load": "normal_load",
        "gap": "gap",
        "preload_N": LOAD,
    },
}
#: number of the first node of a mesh in a test
FIRST_NODE = 11


def variables(modes, preload):
    """Modal data as another program writes it."""
    relative = modes["relative_mode"].transpose("pair", "axis", "mode").to_numpy()
    return {
        "natural_frequency": modes["natural_frequency"].to_numpy(),
        "relative": relative.reshape(-1, relative.shape[-1]),
        "tip": modes["excitation_mode"].to_numpy(),
        **{name: preload[name].to_numpy() for name in ("area", "position", "normal_load", "gap")},
    }


def written(form, folder, content, **changes):
    """A description of modal data in a file of this form."""
    if form == "npz":
        write_npz(folder / "joint.npz", content)
    elif form == "mat 5":
        savemat(folder / "joint.mat", content, oned_as="column")
    else:
        write_hdf5(folder / "joint.mat", content)
    file = "joint.npz" if form == "npz" else "joint.mat"
    return Matrices.model_validate({**KEYS, "file": file, **changes})


def six_digits(values):
    """Values as data sets 55 hold them."""
    return np.vectorize(lambda value: float(f"{value:.5e}"), otypes=[float])(values)


def modes_at_nodes(assembly, modes):
    """Shapes of modes at the nodes of the contact and the excited one, in six digits.

    Numbers and positions of these nodes, pairs by number, shapes (3 * nodes, modes) with a largest
    entry of one, modal masses, frequencies.
    """
    pair_node = assembly["pair_node"].transpose("pair", "side").to_numpy()
    shape = modes["mode_shape"].transpose("node", "axis", "mode").to_numpy()
    tip = abs(shape[:, 2] - modes["excitation_mode"].to_numpy()).max(axis=1).argmin()
    kept = np.unique([*pair_node.ravel(), tip])
    at_nodes = shape[kept].reshape(3 * len(kept), -1)
    largest = abs(at_nodes).max(axis=0)
    return {
        "node": kept + FIRST_NODE,
        "node_position": assembly["coordinate"].to_numpy()[kept],
        "side_a": pair_node[:, 0] + FIRST_NODE,
        "side_b": pair_node[:, 1] + FIRST_NODE,
        "tip": int(tip) + FIRST_NODE,
        "mode_shape": six_digits(at_nodes / largest),
        "modal_mass": six_digits(1 / largest**2),
        "natural_frequency": six_digits(modes["natural_frequency"].to_numpy()),
    }


def write_universal(path, test, ratio=0.0, units=(1.0, 1.0), system=0, **changes):
    """A file with data sets 164, 2411 and 55; changes of all modes."""
    path.unlink(missing_ok=True)
    file, nodes = pyuff.UFF(str(path)), len(test["node"])
    length, force = units
    file.write_sets(
        {
            **{"type": 164, "units_code": 1, "units_description": "SI", "temp_mode": 1},
            **{"length": length, "force": force, "temp": 1.0, "temp_offset": 273.15},
        },
        "overwrite",
    )
    node = {
        **{"type": 2411, "node_nums": test["node"].tolist(), "def_cs": [0] * nodes},
        **{"disp_cs": [system] * nodes, "color": [1] * nodes},
        **dict(zip("xyz", test["node_position"].T.tolist(), strict=True)),
    }
    file.write_sets(node, "add")
    shapes = np.moveaxis(test["mode_shape"].reshape(nodes, 3, -1), -1, 0)
    for number, shape in enumerate(shapes):
        mode = {
            **{"type": 55, "analysis_type": 2, "data_ch": 2, "spec_data_type": 8, "load_case": 1},
            **{"mode_n": number + 1, "node_nums": test["node"].tolist(), "model_type": 1},
            **{"freq": test["natural_frequency"][number], "modal_damp_his": 0.0},
            **{"modal_m": test["modal_mass"][number], "modal_damp_vis": ratio * (number + 1)},
            **dict(zip(("r1", "r2", "r3"), shape.T.tolist(), strict=True)),
        }
        file.write_sets(mode | changes, "add")
