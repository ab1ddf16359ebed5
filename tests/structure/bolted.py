"""Small plates and flanges, what they weigh, and what is measured of them."""

import copy

import numpy as np
import pytest
from small_study import CASE, SETTINGS, write

from boltjoint.config.makers import description_of
from boltjoint.config.numerical_options import ContactAdaptedBasis
from boltjoint.config.study import load_study
from boltjoint.config.types import ConfigError
from boltjoint.dynamics.reduction.basis_from_backbones import find_pod_modes
from boltjoint.dynamics.reduction.contact_condition import ContactCondition
from boltjoint.dynamics.response.frequency_response import solve_response
from boltjoint.structure.makers.registry import make
from boltjoint.structure.modes import find_modes
from boltjoint.structure.preload import apply_preload

STEEL = {"youngs_modulus_GPa": 206, "poissons_ratio": 0.3, "density_kg_per_m3": 7850}
BOLTS = {
    "shank_diameter_mm": 8,
    "hole_diameter_mm": 9,
    "head_diameter_mm": 13,
    "head_height_mm": 5,
    "nut_height_mm": 7,
}
WASHERS = {"thickness_mm": 1.6, "diameter_mm": 16, "hole_diameter_mm": 8.5}
PLATES = {
    "type": "plates",
    "plates": {
        "width_mm": 40,
        "thickness_mm": [5, 5],
        "free_length_mm": [50, 50],
        "lap_mm": 60,
    },
    "pattern": {"rows": 2, "columns": 1, "pitch_mm": 26},
    "material": STEEL,
    "bolts": BOLTS,
    "mesh": {"element_length_mm": 10},
    "points": [{"name": "tip", "near_mm": [160, 0, 5], "direction": "z"}],
    "symmetry": "xz",
}
FLANGE = {
    "type": "flange",
    "tubes": {"inner_diameter_mm": 30, "outer_diameter_mm": 40, "length_mm": [90, 90]},
    "flange": {"outer_diameter_mm": 90, "thickness_mm": [8, 8]},
    "bolt_circle": {"diameter_mm": 64, "number": 4},
    "material": STEEL,
    "bolts": BOLTS,
    "mesh": {"element_length_mm": 15},
    "points": [{"name": "tip", "near_mm": [20, 0, 98], "direction": "x"}],
    "symmetry": "xz",
}
WHOLE = {"symmetry": "none"}
LOSS_FACTOR = 2e-3
CONDITION = ContactCondition.of(
    {
        "law": "variable",
        "tangential_stiffness_N_per_m3": 6.8e13,
        "normal_stiffness_N_per_m3": 6.8e13,
        "friction_coefficient": 0.1,
    },
    LOSS_FACTOR,
)
OPTIONS = ContactAdaptedBasis(states=8, adaptations=1, resonances=1, maximum_vectors=40)


def changed(content, **changes):
    """Content with other values, those of a mapping replaced one by one."""
    content = copy.deepcopy(content)
    for key, value in changes.items():
        own = content.get(key)
        merges = isinstance(value, dict) and isinstance(own, dict)
        content[key] = {**own, **value} if merges else value
    return content


def built(content, **changes):
    """Description and structure."""
    description = description_of(changed(content, **changes))
    return description, make(description, None)[1]


def study_of(folder, content, case):
    """The study of one assembly in a folder, with other keys of its case."""
    (folder / "config").mkdir(exist_ok=True)
    write(folder / "config/assemblies/two_bolt.yaml", content)
    write(folder / "config/cases/small.yaml", CASE | dict(case))
    write(folder / "config/config.yaml", SETTINGS)
    return load_study(folder)


def refusal(study, changes):
    """The one line with which a study of a changed assembly is refused."""
    with pytest.raises(ConfigError) as refused:
        study(**changes)
    (said,) = refused.value.problems
    return said


def refined(content, factor):
    """The mesh of content with elements smaller by a factor, but for those in bolts."""
    return {
        "element_length_mm": content["mesh"]["element_length_mm"] / factor,
        "elements_along_cell": round(4 * factor),
        "rings_head_to_cell_edge": round(2 * factor),
        "layers": [round(2 * factor)] * 2,
    }


def mass_of(structure):
    """Mass along x, y and z of a structure that is free [kg]."""
    T = structure.geometry.displacement
    ones = np.tile(np.eye(3), (len(structure.geometry.node), 1))
    # each unknown is the displacement of one node, or moves none along all
    count = np.asarray(abs(T).sum(axis=0))
    motion = (T.T @ ones) / count[:, None]
    motion[structure.held] = 0
    return np.einsum("dk,dk->k", motion, structure.mass @ motion)


def volume_of_bolts(bolts, thickness):
    """Bolts with their washers [mm3], of plates together so thick."""
    washer = bolts.get("washer", {"thickness_mm": 0.0, "diameter_mm": bolts["head_diameter_mm"]})
    hole = washer.get("hole_diameter_mm", bolts["hole_diameter_mm"])
    count = len(washer.get("under", ("head", "nut")))
    shank = bolts["shank_diameter_mm"] ** 2 * (thickness + count * washer["thickness_mm"])
    heads = bolts["head_diameter_mm"] ** 2 * (bolts["head_height_mm"] + bolts["nut_height_mm"])
    washers = count * washer["thickness_mm"] * (washer["diameter_mm"] ** 2 - hole**2)
    return np.pi / 4 * (shank + heads + washers)


def first_peaks(structure, preload, forces, options=OPTIONS):
    """Frequencies without contact, and peaks of the first resonance, node to node [Hz, m]."""
    tightened = apply_preload(structure, preload)
    free = find_modes(structure, "free-4")["natural_frequency"].to_numpy()
    pod_modes = find_pod_modes(structure, tightened, [CONDITION], options)
    modes = find_modes(structure, f"enriched-{options.maximum_vectors}", pod_modes)
    joint = CONDITION.connect(tightened, modes)
    response = solve_response(joint, forces, damping=LOSS_FACTOR)
    assert response["complete"].to_numpy().all()
    peaks = response["peak_frequency"].to_numpy(), response["peak_amplitude"].to_numpy()
    return free[free > 0], *peaks
