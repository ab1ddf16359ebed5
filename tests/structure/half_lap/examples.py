"""Small structures that the tests share: plain bars of bricks, and a coarse two-bolt assembly."""

from pathlib import Path

import numpy as np
import yaml
from scipy import sparse
from scipy.sparse.linalg import eigsh, splu

from boltjoint.config.lap_joint import LapJoint
from boltjoint.structure.contact_points import ContactPoints
from boltjoint.structure.elasticity import assemble
from boltjoint.structure.elements.kinds import FACES_OF_HEXAHEDRON
from boltjoint.structure.extrusion.blocks import extrude
from boltjoint.structure.extrusion.plan import Plan, rectangle_plan, tributary_area
from boltjoint.structure.makers.half_lap.calculix import faces_among_nodes
from boltjoint.structure.makers.half_lap.mesh import build_assembly
from boltjoint.structure.makers.half_lap.structure import (
    assemble_assembly,
    free_displacements,
    relative_displacements,
    structure_of,
)
from boltjoint.structure.subspaces import symmetric

#: matrices of a mesh by its nodes, beside which its structure is held
__all__ = ["assemble_assembly", "build_assembly", "free_displacements", "relative_displacements"]

COARSE = {
    "description": "two bolts, coarse mesh",
    "bar": {"width_mm": 20, "height_mm": 20, "free_length_mm": [90, 110], "lap_mm": 70},
    "material": {"youngs_modulus_GPa": 200, "poissons_ratio": 0.3, "density_kg_per_m3": 7800},
    "bolts": {
        "positions_from_lap_start_mm": [19, 49],
        "shank_diameter_mm": 8,
        "hole_diameter_mm": 9,
        "head_diameter_mm": 13,
        "head_height_mm": 5,
        "nut_height_mm": 7,
    },
    "mesh": {
        "ring_cells_across_width": 4,
        "ring_cells_along_bar": 5,
        "rings_under_head": 1,
        "rings_head_to_cell_edge": 2,
        "bolt_cell_length_mm": 22,
        "columns_between_bolt_cells": 2,
        "columns_at_each_lap_end": 3,
        "layers_per_half_height": 2,
        "element_length_free_mm": 14,
        "rings_in_shank": 1,
        "layers_in_head": 1,
    },
}
#: fewer elements cannot be
FEWEST = {
    "ring_cells_across_width": 2,
    "ring_cells_along_bar": 2,
    "columns_between_bolt_cells": 1,
    "columns_at_each_lap_end": 1,
    "layers_per_half_height": 1,
    "element_length_free_mm": 50,
}


def coarse_assembly(**mesh):
    """The coarse assembly with other divisions of its mesh."""
    return LapJoint.model_validate({**COARSE, "mesh": {**COARSE["mesh"], **mesh}})


def freed(assembly):
    """An assembly that nothing holds."""
    return assembly.isel(clamped=slice(0))


def study_assembly(name):
    """An assembly as the configuration of the study describes it."""
    folder = Path(__file__).parents[3] / "config" / "assemblies"
    return LapJoint.model_validate(yaml.safe_load((folder / f"{name}.yaml").read_text()))


def brick_bar(length, width, height, elements):
    """Nodes and hexahedra of a bar from x = 0, centred at y = z = 0."""
    along, across, through = elements
    plan = rectangle_plan(
        np.linspace(0, length, along + 1), np.linspace(-width / 2, width / 2, across + 1)
    )
    return extrude(plan, np.linspace(-height / 2, height / 2, through + 1))


def symmetric_part(assembly):
    """The symmetric motion of an assembly, and the displacements of its nodes by the unknowns."""
    structure = structure_of(assembly)
    part = symmetric(structure)
    return part, structure.geometry.displacement @ part.basis


def block_on_ground(elements, youngs_modulus, penalty):
    """A block of 40 x 10 x 20 mm on rigid ground: its K, C, pair areas and coordinates."""
    coordinate, connectivity = brick_bar(0.04, 0.01, 0.02, elements)
    K, _ = assemble(coordinate, connectivity, youngs_modulus, 0.3, 1.0)
    base = np.flatnonzero(np.isclose(coordinate[:, 2], -0.01))
    x, y = coordinate[base, 0], coordinate[base, 1]
    weight = np.where(np.isclose(x, 0) | np.isclose(x, 0.04), 0.5, 1.0)
    weight *= np.where(np.isclose(abs(y), 0.005), 0.5, 1.0)
    area = weight / weight.sum() * 0.04 * 0.01
    # closing is downward
    C = sparse.csr_array(
        (
            np.tile([1.0, 1.0, -1.0], len(base)),
            (np.arange(3 * len(base)), (3 * base[:, None] + np.arange(3)).ravel()),
        ),
        shape=(3 * len(base), K.shape[0]),
    )
    return K, C, penalty * area, area, coordinate, base


def block_with_two_interfaces():
    """A body of three masses between two grounds: one level, the other tilted by 30 degrees."""
    rng = np.random.default_rng(3)
    dofs = 12
    root_of_K = rng.standard_normal((dofs, dofs))
    K = 1e7 * (root_of_K @ root_of_K.T + dofs * np.eye(dofs))
    M = np.diag(rng.uniform(0.5, 2.0, dofs))
    angle = np.deg2rad(30)
    tilted = np.array(
        [[np.cos(angle), 0, np.sin(angle)], [0, 1, 0], [-np.sin(angle), 0, np.cos(angle)]]
    )
    contact = ContactPoints.of_pairs(
        np.arange(12).reshape(4, 3)[:2],
        np.arange(12).reshape(4, 3)[2:],
        dofs,
        position=np.arange(6.0).reshape(2, 3),
        area=[1e-4, 2e-4],
        frame=[np.eye(3), tilted],
        surface=["level", "tilted"],
        penalty=[1e12, 2e12],
        friction_coefficient=[0.4, 0.1],
    )
    bolt = 1e3 * rng.standard_normal(dofs)
    # presses both interfaces together, and shears them
    bolt = bolt + 3e3 * (contact.relative.T @ np.array([0.02, 0, 1, 0.3, 0.1, 1]))
    return K, M, contact, bolt / 3e3


def off_centre(assembly):
    """The mesh of a half lap with its two bolts beside the centre line, on either side of it.

    All nodes move across the bar, by at most 3 mm and smoothly; its sides stay where they are.
    """
    first, last = assembly["bolt_position"].to_numpy()[:, 0]
    half_width = assembly["coordinate"].to_numpy()[:, 1].max()

    def moved(coordinate):
        x, y, z = np.moveaxis(coordinate, -1, 0)
        shift = 3e-3 * np.cos(np.pi * (np.clip(x, first, last) - first) / (last - first))
        return np.stack([x, y + shift * (1 - (y / half_width) ** 2), z], axis=-1)

    changed = {
        name: (assembly[name].dims, moved(assembly[name].to_numpy()), assembly[name].attrs)
        for name in ("coordinate", "position", "bolt_position")
    }
    # consistent nodal areas of the faces of bar A
    side_a = assembly["pair_node"].sel(side="A").to_numpy()
    element, face = faces_among_nodes(assembly, side_a).T
    quad = assembly["connectivity"].to_numpy()[element[:, None], FACES_OF_HEXAHEDRON[face]]
    place = np.zeros(assembly.sizes["node"], dtype=int)
    place[side_a] = np.arange(len(side_a))
    # seen from above corners turn the other way
    plan = Plan(changed["position"][1][:, :2], place[quad])
    changed["area"] = ("pair", tributary_area(plan), assembly["area"].attrs)
    return assembly.assign(changed)


def craig_bampton(structure, number):
    """Craig-Bampton vectors that keep the contact, the bolts and the excitation, (dofs, vectors).

    Static modes of these degrees of freedom, and so many modes of the rest with them held.
    """
    excited = np.flatnonzero(structure.inputs["excitation"].row)
    of_contact = structure.contact.relative.indices
    kept = np.unique(np.concatenate([of_contact, structure.held, excited]))
    rest = np.setdiff1d(np.arange(structure.dofs), kept)
    K, M = structure.stiffness, structure.mass
    inside = K[rest][:, rest].tocsc()
    vectors = np.zeros((structure.dofs, kept.size + number))
    vectors[kept, np.arange(kept.size)] = 1
    vectors[rest, : kept.size] = -splu(inside).solve(K[rest][:, kept].toarray())
    if number:
        start = np.ones(rest.size)
        _, modes = eigsh(inside, number, M[rest][:, rest], sigma=0, v0=start)
        vectors[rest, kept.size :] = modes
    return sparse.csc_array(vectors)
