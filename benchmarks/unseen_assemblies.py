"""Error of bases enriched-auto on assemblies that they were not developed on, and on the study's.

    python benchmarks/unseen_assemblies.py [NAME ...]

For each assembly and law, and each case of the study: the vectors that a basis chooses, the errors
that it estimates, and how far peaks move when its vectors are doubled, at twelve forces a decade
around the onset of full slip.
"""

import logging
import sys
import time
from collections.abc import Mapping
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import numpy as np

from boltjoint.config.lap_joint import LapJoint
from boltjoint.config.numerical_options import ContactAdaptedBasis
from boltjoint.config.study import load_study
from boltjoint.damping import Damping
from boltjoint.dynamics.backbone.backbone import trace_for_forces
from boltjoint.dynamics.reduction.basis_from_backbones import find_pod_modes
from boltjoint.dynamics.reduction.contact_condition import ContactCondition
from boltjoint.dynamics.response.windows import frequency_window
from boltjoint.joint.model import Joint
from boltjoint.structure.makers.half_lap.mesh import build_assembly
from boltjoint.structure.modes import find_modes
from boltjoint.structure.preload import apply_preload
from boltjoint.study.convergence import peaks_near

ALUMINIUM = {"youngs_modulus_GPa": 70, "poissons_ratio": 0.33, "density_kg_per_m3": 2700}
STEEL = {"youngs_modulus_GPa": 206, "poissons_ratio": 0.3, "density_kg_per_m3": 7850}
#: shank, hole, head, height of head and nut of metric bolts [mm]
BOLTS = {
    5: (5, 5.5, 8, 3.5, 4.7),
    6: (6, 6.6, 10, 4, 5.2),
    8: (8, 9, 13, 5.3, 6.8),
    10: (10, 11, 16, 6.4, 8.4),
    12: (12, 13.5, 18, 7.5, 10.8),
    16: (16, 17.5, 24, 10, 14.8),
}
#: share of the load that slips where full slip begins: single pairs at rest never slip
FULL_SLIP = 0.999


@dataclass(frozen=True)
class Unseen:
    """An assembly with its contact; lengths in mm, cells of the mesh in numbers."""

    material: dict[str, float]
    section: tuple[float, float]
    free_length: tuple[float, float]
    bolt: int
    count: int
    pitch: float
    cell: float
    columns_at_each_lap_end: int
    ring_cells: tuple[int, int]
    rings: int
    layers: int
    element_length: float
    preload: float
    stiffness: float
    friction_coefficient: float
    loss_factor: float

    def assembly(self) -> LapJoint:
        """The assembly as a file of ``config/assemblies`` describes it."""
        shank, hole, head, head_height, nut_height = BOLTS[self.bolt]
        first = max(4.0, 0.3 * self.cell) + self.cell / 2
        return LapJoint.model_validate(
            {
                "description": "",
                "bar": {
                    "width_mm": self.section[0],
                    "height_mm": self.section[1],
                    "free_length_mm": self.free_length,
                    "lap_mm": 2 * first + (self.count - 1) * self.pitch,
                },
                "material": self.material,
                "bolts": {
                    "positions_from_lap_start_mm": [
                        first + index * self.pitch for index in range(self.count)
                    ],
                    "shank_diameter_mm": shank,
                    "hole_diameter_mm": hole,
                    "head_diameter_mm": head,
                    "head_height_mm": head_height,
                    "nut_height_mm": nut_height,
                },
                "mesh": {
                    "ring_cells_across_width": self.ring_cells[0],
                    "ring_cells_along_bar": self.ring_cells[1],
                    "rings_under_head": 2,
                    "rings_head_to_cell_edge": self.rings,
                    "bolt_cell_length_mm": self.cell,
                    "columns_between_bolt_cells": 2,
                    "columns_at_each_lap_end": self.columns_at_each_lap_end,
                    "layers_per_half_height": self.layers,
                    "element_length_free_mm": self.element_length,
                    "rings_in_shank": 1,
                    "layers_in_head": 1,
                },
            }
        )

    def cases(self) -> dict[str, tuple[float, ContactCondition]]:
        """Preload and contact condition under constant and variable load, by the law."""
        coulomb = {
            "tangential_stiffness_N_per_m": self.stiffness,
            "friction_coefficient": self.friction_coefficient,
        }
        variable = {**coulomb, "law": "variable", "normal_stiffness_N_per_m": self.stiffness}
        return {
            contact["law"]: (self.preload, ContactCondition.of(contact, self.loss_factor))
            for contact in ({**coulomb, "law": "constant"}, variable)
        }


_A, _S = ALUMINIUM, STEEL
ASSEMBLIES = {
    "one_m5_aluminium": Unseen(
        _A, (14, 6), (60, 70), 5, 1, 0, 14, 3, (10, 10), 4, 2, 5, 3e3, 1e7, 0.6, 5e-4
    ),
    "one_m16_steel": Unseen(
        _S, (50, 40), (250, 250), 16, 1, 0, 50, 3, (12, 12), 6, 4, 12, 6e4, 1e9, 0.05, 1e-3
    ),
    "two_m10_aluminium": Unseen(
        _A, (30, 12), (150, 150), 10, 2, 40, 32, 3, (10, 10), 4, 3, 7, 12e3, 2e7, 0.3, 1e-3
    ),
    "two_m16_steel": Unseen(
        _S, (40, 32), (200, 300), 16, 2, 60, 48, 2, (10, 10), 4, 3, 10, 5e4, 1e9, 0.1, 1e-2
    ),
    "three_m8_aluminium": Unseen(
        _A, (25, 20), (150, 150), 8, 3, 35, 28, 3, (8, 8), 3, 3, 7, 8e3, 5e7, 0.4, 2e-3
    ),
    "four_m12_steel": Unseen(
        _S, (35, 30), (250, 200), 12, 4, 45, 38, 2, (8, 8), 3, 3, 9, 3e4, 5e8, 0.15, 5e-3
    ),
    "five_m6_steel": Unseen(
        _S, (18, 8), (120, 120), 6, 5, 25, 20, 2, (6, 8), 3, 2, 6, 5e3, 1e8, 0.2, 5e-4
    ),
    "six_m5_aluminium": Unseen(
        _A, (15, 6), (100, 100), 5, 6, 20, 16, 2, (6, 6), 3, 2, 5, 3e3, 1e7, 0.6, 1e-2
    ),
}


def onset_of_full_slip(joint: Joint, damping: Damping) -> float:
    """Force of the first peak at which ``FULL_SLIP`` of the load slips [N]."""
    # whose balance has one of two mirror images
    joint = joint.distinct
    law = joint.law
    load = law.slip_force if law.name == "constant" else np.maximum(law.normal_load, 0.0)
    forces = [1e-5 * load.sum(), 10 * load.sum()]
    window = frequency_window(joint)
    backbone = trace_for_forces(joint, forces, damping=damping, window=window)
    before = None
    for state in backbone.states:
        motion = backbone.equations.balance.motion(state.modal_coordinate.ravel())
        slips = law.contact_state(motion) > 0
        share = load[slips].sum() / load.sum()
        force = state.eigenvalue.imag / state.excited_distance(joint.excitation_mode)
        if share > FULL_SLIP:
            return float(np.interp(FULL_SLIP, [before[0], share], [before[1], force]))
        before = share, force
    raise RuntimeError("the backbone ends before all slips")


def report(
    name: str, description: LapJoint, cases: Mapping[str, tuple[float, ContactCondition]]
) -> None:
    """Print the row of each case of an assembly, of a preload [N] and a contact condition."""
    assembly = build_assembly(description)
    preloads = {
        force: apply_preload(assembly, force)
        for force in dict.fromkeys(force for force, _ in cases.values())
    }
    conditions = [condition for _, condition in cases.values()]
    find = partial(find_pod_modes, assembly, next(iter(preloads.values())), conditions)
    began = time.process_time()
    pod_modes = find(ContactAdaptedBasis())
    seconds = time.process_time() - began
    number = pod_modes.attrs["automatic_vectors"]
    doubled = 2 * number
    bases = [find_modes(assembly, f"enriched-{number}", pod_modes)]
    if doubled > pod_modes.sizes["pod_mode"]:
        pod_modes = find(ContactAdaptedBasis(maximum_vectors=doubled))
    bases.append(find_modes(assembly, f"enriched-{doubled}", pod_modes))
    estimated = [
        100 * bases[0].attrs[f"estimated_{what}_error"] for what in ("frequency", "amplitude")
    ]
    for case, (preload, condition) in cases.items():
        few, many = (condition.connect(preloads[preload], basis) for basis in bases)
        onset = onset_of_full_slip(few, condition.damping)
        forces = onset * 10 ** np.linspace(-0.5, 0.5, 13)
        found, expected = (peaks_near(joint, forces, condition.damping) for joint in (few, many))
        moved = [
            100 * abs(found[column] / expected[column] - 1).max()
            for column in ("peak_frequency_Hz", "peak_mm_per_N")
        ]
        print(
            f"| {name} | {case} | {number} | {moved[0]:.4f} | {estimated[0]:.4f} | "
            f"{moved[1]:.3f} | {estimated[1]:.3f} | {seconds:.0f} |",
            flush=True,
        )


def main() -> None:
    """Print the table of the assemblies named, or of all."""
    logging.basicConfig(level=logging.WARNING)
    study = load_study(Path(__file__).parents[1])
    known = [*ASSEMBLIES, *study.assemblies]
    if unknown := sorted(set(sys.argv[1:]) - set(known)):
        sys.exit(f"{', '.join(unknown)}: there are {', '.join(known)}")
    print("| assembly | case | vectors | frequency % | estimated | amplitude % | estimated | s |")
    print("|---|---|---|---|---|---|---|---|")
    for name in sys.argv[1:] or known:
        if name in ASSEMBLIES:
            report(name, ASSEMBLIES[name].assembly(), ASSEMBLIES[name].cases())
            continue
        cases = {
            key: (case.preload_N, ContactCondition(case.contact, case.structural_damping))
            for key, case in study.cases.items()
            if case.assembly == name
        }
        report(name, study.assemblies[name], cases)


if __name__ == "__main__":
    main()
