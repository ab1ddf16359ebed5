"""A study small enough to run in a minute, which asks for everything once; and how to run it."""

import os
import subprocess
import sys
from pathlib import Path

import yaml
from started import run_snakemake

from boltjoint.config.makers import description_of, maker

ROOT = Path(__file__).parents[1]

ASSEMBLY = {
    "bar": {"width_mm": 20, "height_mm": 20, "free_length_mm": [60, 60], "lap_mm": 62},
    "material": {"youngs_modulus_GPa": 190, "poissons_ratio": 0.3, "density_kg_per_m3": 7900},
    "bolts": {
        "positions_from_lap_start_mm": [16, 46],
        "shank_diameter_mm": 8,
        "hole_diameter_mm": 9,
        "head_diameter_mm": 13,
        "head_height_mm": 5,
        "nut_height_mm": 6,
    },
    "mesh": {
        "ring_cells_across_width": 4,
        "ring_cells_along_bar": 4,
        "rings_under_head": 1,
        "rings_head_to_cell_edge": 2,
        "bolt_cell_length_mm": 24,
        "columns_between_bolt_cells": 1,
        "columns_at_each_lap_end": 1,
        "layers_per_half_height": 2,
        "element_length_free_mm": 15,
        "rings_in_shank": 1,
        "layers_in_head": 1,
    },
}
REGIONS = ["regions=2", "regions=2/elements=2"]
CASE = {
    "assembly": "two_bolt",
    "preload_N": 10000,
    "contact": {
        "law": "constant",
        "tangential_stiffness_N_per_m": 1e9,
        "friction_coefficient": 0.1,
    },
    "loss_factor": 0.005,
    "forces_N": [0.01, 20],
    "verification_forces_N": [20],
    "modes": ["free-2"],
    "coordinates": ["linear", "rdnm-1"],
    "solve": [
        {"resonance": 1, "joints": ["node-to-node"]},
        {
            "resonance": 1,
            "coordinates": ["linear"],
            "joints": [*REGIONS, "regions=2/table", "clusters=2/harmonic=2"],
        },
        {
            "resonance": 1,
            "modes": ["enriched-8"],
            "coordinates": ["linear", "complex-rdnm-1", "backbone"],
            "joints": ["node-to-node"],
        },
    ],
}
#: the same assembly under variable load, divided by the pressure along its middle
VARIABLE = CASE | {
    "contact": {
        "law": "variable",
        "tangential_stiffness_N_per_m": 1e8,
        "normal_stiffness_N_per_m": 1e8,
        "friction_coefficient": 0.1,
    },
    "regions": {"division": "equal-middle-load"},
    "forces_N": [20],
    "verification_forces_N": [],
    "coordinates": ["linear"],
    "solve": [{"resonance": 1, "joints": ["node-to-node", *REGIONS]}],
}
CASES = {"small": CASE, "variable": VARIABLE}
#: in a joint that the case has not, with two designs that are impossible
SWEEP = {
    "case": "small",
    "vary": {
        "preload_N": [0, 10000, 12000],
        "contact.friction_coefficient": {
            "kind": "linear",
            "lowest": 0.1,
            "highest": 0.3,
            "number": 2,
        },
    },
    "design": {"kind": "grid"},
    "basis": "free-2",
    "joint": "regions=3/elements=2",
    "observe": ["peaks", "responses", "contact-states", "backbone"],
    "designs_per_job": 4,
}
SETTINGS = {
    "cases": ["small"],
    "converged_peaks": True,
    "contact_adapted_basis": {
        "resonances": 1,
        "states": 6,
        "adaptations": 1,
        "trial_step": 72,
        "maximum_vectors": 8,
    },
    "fitting": {"initial_guesses": 2},
    "convergence": {
        "bases": ["free-2", "enriched-8"],
        "regions": [2],
        "reductions": ["clusters=3", "clusters=2/table"],
        "time_integration_N": [20],
    },
}

#: a joint in two kinds of coordinates, four in one, and one in three; three joints in one
RESPONSES = {"small": 9, "variable": 3}
#: of linear coordinates: five joints, and one in the other basis; three joints
CHECKS = {"small": 6, "variable": 3}

COMMAND = [sys.executable, "-m", "snakemake", "--cores", "2"]


def write(path, content):
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(yaml.safe_dump(content))


#: with Sobol indices
SALTELLI = {
    "case": "small",
    "vary": {
        "contact.friction_coefficient": {"kind": "linear", "lowest": 0.1, "highest": 0.3},
        "loss_factor": {"kind": "log", "lowest": 0.002, "highest": 0.02},
    },
    "levels": [20],
    "design": {"kind": "saltelli", "number": 4},
    "basis": "free-2",
    "joint": "hyper=20",
    "observe": ["peaks", "converged-peaks"],
    "check": {"designs": 3, "basis": "free-4"},
}
SWEEPS = {"grid": SWEEP, "shares": SALTELLI}


def write_config(folder, cases=CASES, settings=SETTINGS):
    """Configuration of a study of some cases, with its sweeps."""
    write(folder / "config/assemblies/two_bolt.yaml", ASSEMBLY)
    for name, case in cases.items():
        write(folder / f"config/cases/{name}.yaml", case)
    for name, sweep in SWEEPS.items():
        write(folder / f"config/sweeps/{name}.yaml", sweep)
    write(folder / "config/config.yaml", settings | {"cases": list(cases), "sweeps": list(SWEEPS)})


def mesh_of(content):
    """The mesh of the assembly with this content of a file."""
    description = description_of(content)
    return maker(description.type).make(description, Path())


def environment(folder):
    """With the library of a folder, where it has one."""
    library = folder if (folder / "src").exists() else ROOT
    return os.environ | {"PYTHONPATH": str(library / "src")}


def snakemake(folder, *options, seed=1):
    if (folder / "src").exists():
        return subprocess.run(
            [*COMMAND, *options],
            cwd=folder,
            env=environment(folder),
            capture_output=True,
            text=True,
            check=False,
        )
    return run_snakemake([*COMMAND[3:], *options], folder, environment(folder), seed)


def run(folder, *options, seed=1):
    """Run the workflow to its end, and return all that it says."""
    ran = snakemake(folder, *options, seed=seed)
    assert ran.returncode == 0, ran.stderr
    return ran.stdout + ran.stderr
