"""Error bars of peaks on joints that nothing was tuned to: how many hold, and how wide they are.

    python benchmarks/error_bars.py small --seed 1 --count 75
    python benchmarks/error_bars.py assemblies --seed 1 --bolts 2 3

The first converges peaks of random small joints of each friction law, the second those of random
assemblies of numbers of bolts under constant and variable load, node to node and in clusters.
All are sought again with three times the harmonics, and at least 1024 samples. Printed for each
group: how many error bars of converged peaks (truncation) and of peaks of one harmonic hold that
peak, and the median of a bar over the error that it stands for. Those that do not hold are listed.
"""

import argparse
import time
import warnings
from collections.abc import Iterator, Mapping
from dataclasses import replace
from itertools import chain, product
from types import MappingProxyType

import numpy as np
import pandas as pd
import xarray as xr
from numpy.typing import NDArray
from random_joints import random_joint
from unseen_assemblies import ALUMINIUM, BOLTS, STEEL, Unseen, onset_of_full_slip

from boltjoint.config.numerical_options import ContactAdaptedBasis
from boltjoint.damping import Damping, as_damping
from boltjoint.dynamics.balance.periodic_motion import motion_at_peak
from boltjoint.dynamics.reduction.basis_from_backbones import find_pod_modes
from boltjoint.dynamics.response.converged_peaks import converge_peaks
from boltjoint.dynamics.response.error_bars import add_converged_peaks
from boltjoint.dynamics.response.frequency_response import solve_response
from boltjoint.dynamics.response.harmonic_convergence import converge_peak
from boltjoint.dynamics.response.phase_resonance import PeakSearch, find_peak
from boltjoint.friction.aft import AlternatingFrequencyTime, without_sampling
from boltjoint.friction.coupled import CoupledConstantLoad, CoupledVariableLoad
from boltjoint.joint.model import Joint
from boltjoint.joint.partition import partition_regions
from boltjoint.structure.makers.half_lap.mesh import build_assembly
from boltjoint.structure.modes import find_modes
from boltjoint.structure.preload import apply_preload

LAWS = ("constant", "variable", "iwan", "coupled-constant", "coupled-variable")
ELEMENTS = ("node-to-node", "clusters=8")
QUANTITIES = ("frequency", "amplitude")
#: errors below are those of the solver, where all sticks
SMALLEST = 1e-6
#: of the reference, so that it is not off by its own search
SEARCH = PeakSearch(width=3e-4, tolerance=1e-8)
#: metric bolts that assemblies are drawn with
BOLT_SIZES = (5, 6, 8, 10, 12)


def random_assembly(bolts: int, seed: int) -> Unseen:
    """An assembly of a number of bolts of random size, with dimensions drawn around usual ones."""
    random = np.random.default_rng([seed, bolts])
    size = int(random.choice(BOLT_SIZES))
    head = BOLTS[size][2]
    cell = head * random.uniform(1.5, 2.0)
    return Unseen(
        material=(ALUMINIUM, STEEL)[random.integers(2)],
        section=(head * random.uniform(1.9, 2.5), size * random.uniform(1.2, 2.4)),
        free_length=tuple(size * random.uniform(10, 22, 2)),
        bolt=size,
        count=bolts,
        pitch=cell * random.uniform(1.25, 1.6),
        cell=cell,
        columns_at_each_lap_end=int(random.integers(2, 4)),
        ring_cells=(8, 8),
        rings=3,
        layers=3 if bolts < 4 else 2,
        element_length=size * random.uniform(0.8, 1.2),
        preload=200 * size**2 * random.uniform(0.5, 1.2),
        stiffness=10 ** random.uniform(7, 8.7),
        friction_coefficient=random.uniform(0.1, 0.5),
        loss_factor=10 ** random.uniform(-3.3, -2),
    )


def small_joint(law: str, index: int, seed: int) -> tuple[Joint, float, float]:
    """A random small joint of a law, with a force [N] and a loss factor."""
    if not law.startswith("coupled"):
        return random_joint(law, index, seed)
    underlying = law.removeprefix("coupled-")
    joint, force, loss_factor = random_joint(underlying, index, seed)
    coulomb = joint.law
    random = np.random.default_rng([seed, index, 7])
    kind = CoupledConstantLoad if underlying == "constant" else CoupledVariableLoad
    lateral = random.normal(size=joint.tangential_mode.shape) * joint.tangential_mode
    values = {name: getattr(coulomb, name) for name in kind.quantities}
    elements = kind(coulomb.point_of_element, **values)
    # without a closed form for one harmonic
    joint = replace(joint, law=AlternatingFrequencyTime(elements), lateral_mode=lateral)
    return joint, force, loss_factor


def small_joints(
    laws: list[str], count: int, seed: int
) -> Iterator[tuple[str, str, Joint, list[float], float]]:
    """Group, name, joint, forces and loss factor of random small joints."""
    for law, index in product(laws, range(count)):
        joint, force, loss_factor = small_joint(law, index, seed)
        yield law, f"{law} {index}", joint, [force], loss_factor


def assembled_joints(
    bolts: int, seed: int, vectors: tuple[int, ...], laws: list[str], elements: list[str]
) -> Iterator[tuple[str, str, Joint, NDArray[np.float64], Damping]]:
    """Group, name, joint, forces and damping of a random assembly, in bases of numbers of vectors.

    Of ``laws`` and ``elements``: ``node-to-node`` and ``clusters=8``.
    """
    unseen = random_assembly(bolts, seed)
    name = f"{bolts} bolts, seed {seed}"
    assembly = build_assembly(unseen.assembly())
    preload = apply_preload(assembly, unseen.preload)
    cases = unseen.cases()
    conditions = [condition for _, condition in cases.values()]
    pod_modes = find_pod_modes(assembly, preload, conditions, ContactAdaptedBasis())
    for number, (law, (_, condition)) in product(vectors, cases.items()):
        if law not in laws:
            continue
        basis = find_modes(assembly, f"enriched-{number}", pod_modes)
        nodes = condition.connect(preload, basis)
        forces = onset_of_full_slip(nodes, condition.damping) * np.array([0.1, 0.4, 1.2])
        clusters = partition_regions(nodes, preload, 8, division="clusters")
        joints = {"node-to-node": nodes, "clusters=8": clusters}
        for kind in elements:
            label = f"{name} {law} enriched-{number} {kind}"
            yield name, label, joints[kind], forces, condition.damping


def check(
    group: str,
    name: str,
    joint: Joint,
    forces: list[float],
    damping: Damping | float,
    known: Mapping[tuple[str, int, str], float] = MappingProxyType({}),
) -> list[dict[str, object]]:
    """Bars and errors of the peaks of a joint, a row for each force and quantity.

    References that are ``known``, by name, place of the force and quantity, are not sought again.
    """
    damping = as_damping(damping)
    response = solve_response(joint, list(forces), damping=damping)
    begun = time.process_time()
    converged = converge_peaks(joint, response)
    seconds = (time.process_time() - begun) / len(forces)
    # references are in the same basis: what that asks for is no part of their difference
    of_basis = [f"peak_{what}_inertia_error" for what in QUANTITIES]
    both = add_converged_peaks(response, converged.drop_vars(of_basis))
    rows = []
    for place, force in enumerate(forces):
        at = both.isel(force=place)
        if np.isnan(at["peak_harmonics"]):
            rows.append(
                {"group": group, "name": name, "place": place, "force_N": force, "harmonics": 0}
            )
            continue
        harmonics = int(at["peak_harmonics"])
        reference = [known.get((name, place, what), np.nan) for what in QUANTITIES]
        if np.isnan(reference).any():
            reference = reference_peak(joint, response, force, damping, 3 * harmonics)
        for what, best in zip(QUANTITIES, reference, strict=True):
            rows.append(
                {
                    "group": group,
                    "name": name,
                    "place": place,
                    "force_N": force,
                    "harmonics": harmonics,
                    "what": what,
                    "reference": best,
                    "error": abs(best / float(at[f"peak_{what}_converged"]) - 1),
                    "bar": float(at[f"peak_{what}_truncation_error"]),
                    "error_of_one": abs(best / float(at[f"peak_{what}"]) - 1),
                    "bar_of_one": float(at[f"peak_{what}_error"]),
                    "seconds": seconds,
                }
            )
    return rows


def reference_peak(
    joint: Joint, response: xr.Dataset, force: float, damping: Damping, harmonics: int
) -> tuple[float, float]:
    """Frequency [Hz] and amplitude [m] of a peak with a number of harmonics."""
    joint = replace(joint, law=without_sampling(joint.law)).distinct
    start = converge_peak(joint, *motion_at_peak(response, force), force, damping).peaks[-1]
    samples = max(1024, 16 * harmonics)
    peak = find_peak(
        joint,
        start.frequency,
        force,
        damping,
        start.motion,
        harmonics=harmonics,
        samples=samples,
        search=SEARCH,
    )
    if peak is None:
        return np.nan, np.nan
    return peak.frequency, abs(peak.motion.amplitude(joint.response_mode))


def known_references(path: str) -> dict[tuple[str, int, str], float]:
    """References of a table of an earlier run, by name, place of the force and quantity."""
    table = pd.read_csv(path).dropna(subset="reference")
    keys = zip(table["name"], table["place"], table["what"], strict=True)
    return dict(zip(keys, table["reference"], strict=True))


def summarize(rows: list[dict[str, object]]) -> None:
    """Print how many bars hold and how wide they are, and those that do not."""
    table = pd.DataFrame(rows)
    none = table[table["harmonics"] == 0]
    table = table[table["harmonics"] > 0].copy()
    found = table.dropna(subset="error")
    print(f"{len(none)} without a peak, {len(table) - len(found)} without a reference")
    for bar, error in (("bar", "error"), ("bar_of_one", "error_of_one")):
        found[f"{bar}_holds"] = found[error] <= found[bar]
        for (group, what), some in found.groupby(["group", "what"], sort=False):
            off = some[some[error] > SMALLEST]
            width = (off[bar] / off[error]).median()
            held = some[f"{bar}_holds"].sum()
            print(
                f"{group}, {what}, {bar}: {held} of {len(some)} hold, "
                f"median bar over error {width:.1f} of {len(off)} errors above {SMALLEST:g}, "
                f"median error {some[error].median():.1e}"
            )
        for _, row in found[~found[f"{bar}_holds"]].iterrows():
            print(
                f"  does not hold: {row['name']}, {row.force_N:.4g} N, {row.what}: {bar} "
                f"{row[bar]:.2e}, {error} {row[error]:.2e}, {row.harmonics} harmonics"
            )
    print(f"median time of a converged peak {found['seconds'].median():.2f} s")


def main() -> None:
    """Check the joints that are asked for."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("kind", choices=("small", "assemblies"))
    parser.add_argument("--count", type=int, default=60, help="small joints of each law")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--bolts", type=int, nargs="+", default=[2, 3, 4, 5])
    parser.add_argument("--law", nargs="+", default=LAWS, choices=LAWS)
    parser.add_argument("--elements", nargs="+", default=ELEMENTS, choices=ELEMENTS)
    parser.add_argument("--vectors", nargs="+", type=int, default=[24, 40])
    parser.add_argument("--csv", help="file for a row of each peak")
    parser.add_argument("--references", help="such a file, whose references are taken")
    args = parser.parse_args()
    warnings.simplefilter("ignore")
    known = known_references(args.references) if args.references else {}
    rows: list[dict[str, object]] = []
    if args.kind == "small":
        joints = small_joints(args.law, args.count, args.seed)
    else:
        kinds = tuple(args.vectors), args.law, args.elements
        joints = chain.from_iterable(
            assembled_joints(bolts, args.seed, *kinds) for bolts in args.bolts
        )
    for joint in joints:
        rows += check(*joint, known)
        if args.csv:
            pd.DataFrame(rows).to_csv(args.csv, index=False)
    summarize(rows)


if __name__ == "__main__":
    main()
