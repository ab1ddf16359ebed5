"""Stability marks at folds of random small joints, against the motions in time.

    python benchmarks/stability_at_folds.py --count 100 --seed 1

takes responses that fold, and of each some random solutions: marked ones, ones near a turning
point, ones between two. A motion is found in time by shooting from the motion with 15 harmonics
that belongs to a solution, and its Floquet multipliers by differences of a period. Printed are all
marks that differ from it, and how many of one harmonic agree. Shooting from the solution itself may
reach another motion: how many marks agree with that is printed too. Where a slider only touches
its limit, a multiplier has two values, by the sense of the change: where a mark differs, the motion
is disturbed in both senses and integrated, and ``returns`` tells whether it comes back.
"""

import argparse
import warnings
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
import pandas as pd
from numpy.typing import NDArray
from periodic_orbits import find_orbit
from random_joints import relative_rows

from boltjoint.damping import Damping, ModalDamping
from boltjoint.dynamics.balance.harmonic_balance import HarmonicBalance
from boltjoint.dynamics.balance.periodic_motion import PeriodicMotion
from boltjoint.dynamics.response.folds import FoldedBranch, find_folds
from boltjoint.dynamics.response.frequency_response import solve_branch
from boltjoint.dynamics.response.stability import StabilityOptions, find_stability
from boltjoint.friction.variable import VariableLoad
from boltjoint.joint.model import Joint
from boltjoint.verification.time_integration import Integration

#: a multiplier as near to 1 is that of a slider which rests wherever it is
_AT_REST = 1e-6


class FoldingJoint(NamedTuple):
    """A joint with a force [N], and damping that is viscous: the same in time."""

    joint: Joint
    force: float
    damping: Damping


def folding_joint(random: np.random.Generator) -> FoldingJoint:
    """A random joint whose response may fold: contact that opens, or closes gaps.

    One to three modes, of which neighbours may be close; one to five elements; damping ratios from
    5e-4 to 2e-2, and a force at whose resonance contact opens or closes. Under constant normal load
    none of 1500 responses folded.
    """
    modes, elements = int(random.integers(1, 4)), int(6 ** random.random())
    points = int(random.integers(max(1, elements // 2), elements + 1))
    ratio = np.where(
        random.random(modes - 1) < 0.2,
        1 + 10 ** random.uniform(-2.5, -1, modes - 1),
        random.uniform(1.3, 6.0, modes - 1),
    )
    frequency = 10 ** random.uniform(1.3, 2.5) * np.cumprod(np.append(1.0, ratio))
    squared = (2 * np.pi * frequency) ** 2
    excitation = random.normal(size=modes)
    response = excitation if random.random() < 0.5 else random.normal(size=modes)
    place = np.linspace(0.0, 1.0, points)
    along, across = relative_rows(random, place, modes), relative_rows(random, place, modes)
    on = np.concatenate([np.arange(points), random.integers(0, points, elements - points)])
    # stiffness against that of the first mode
    tangential = 10 ** random.uniform(-0.7, 0.7, elements) * 10 ** random.uniform(-1.5, 1.0)
    tangential *= squared[0] / (tangential @ along[on, 0] ** 2) * 10 ** random.uniform(-1.5, 1.0)
    normal = tangential * 10 ** random.uniform(-1.5, 2.0)
    stiffest = normal @ across[on, 0] ** 2 / squared[0]
    normal *= min(1.0, 10 ** random.uniform(-0.5, 1.5) / stiffest)
    load = 10 ** random.normal(0.0, random.uniform(0.1, 0.7), elements)
    is_open = random.random(elements) < random.choice([0.0, 0.3, 0.7, 1.0])
    friction = np.full(elements, 10 ** random.uniform(-1.3, 0.0))
    position = np.column_stack([place, 0 * place, 0 * place])
    joint = Joint(
        natural_frequency=frequency,
        excitation_mode=excitation,
        response_mode=response,
        tangential_mode=along,
        position=position,
        law=VariableLoad(on, tangential, normal, np.where(is_open, -load, load), friction),
        element_position=position[on],
        normal_mode=across,
    )
    damping_ratio = 10 ** random.uniform(-3.3, -1.7)
    mode = np.linalg.eigh(np.diag(squared) + joint.stuck_stiffness())[1][:, 0]
    by_amplitude = 2 * damping_ratio * mode @ (squared * mode) / abs(mode @ excitation)
    strain = abs(normal * (across[on] @ mode))
    amplitude = np.median(load / np.maximum(strain, 1e-9 * strain.max()))
    force = by_amplitude * amplitude * 10 ** random.uniform(-0.5, 1.5)
    return FoldingJoint(joint, float(force), ModalDamping((damping_ratio,)))


def compare_marks(
    seed: int, index: int, motions: int = 3, steps: int = 2000
) -> list[dict[str, object]]:
    """Marks of some random solutions of a response beside its motions in time.

    Parameters
    ----------
    seed, index
        Of the joint.
    motions
        How many solutions.
    steps
        Of a period in time.

    Returns
    -------
    list
        A row for each solution, none where the response does not fold: its mark and multiplier,
        those of one harmonic, and the multiplier in time, NaN where shooting does not converge.
    """
    random = np.random.default_rng([seed, index])
    joint, force, damping = folding_joint(random)
    branch = solve_branch(joint, force, damping=damping)
    folds = find_folds(branch.frequency)
    if not folds.turning_points:
        return []
    f, x = branch.frequency, branch.modal_coordinate
    balance, options = HarmonicBalance(joint, damping, force), StabilityOptions()
    stability = find_stability(balance, f, x, folds, options)
    of_one = find_stability(balance, f, x, folds, StabilityOptions(harmonics=1))
    finer = FoldedBranch(balance, f, x, folds, options.harmonics, options.samples)
    marked = stability.stable >= 0
    place = np.arange(f.size)
    near = abs(place[:, None] - folds.at).min(axis=1) <= 6
    between = np.diff(f, append=np.inf) < 0
    rows = []
    for kind in range(motions):
        among = np.flatnonzero(marked & (near, between, marked)[kind % 3])
        i = int(random.choice(among))
        period = joint, f[i], force, damping, steps
        own = PeriodicMotion(joint.law.components, x[i].reshape(len(joint.law.components), -1))
        motion, many = own, finer.motion_of(i)
        if many is not None:
            components = finer.balance.components
            motion = PeriodicMotion(components, many.reshape(len(components), -1))
        in_time, moved, orbit = _in_time(*period, motion)
        is_stable = stability.stable[i] == 1
        rows.append(
            {
                "index": index,
                "solution": i,
                "stable": stability.stable[i],
                "multiplier": stability.largest_multiplier[i],
                "harmonics": stability.harmonics[i],
                "of_one": of_one.largest_multiplier[i],
                "in_time": in_time,
                "moved": moved,
                "from_one": _in_time(*period, own)[0],
                "returns": np.nan
                if np.isnan(in_time) or (in_time < 1) == is_stable
                else _returns(*period, orbit),
            }
        )
    return rows


def _in_time(
    joint: Joint,
    frequency: float,
    force: float,
    damping: Damping,
    steps: int,
    motion: PeriodicMotion,
) -> tuple[float, float, NDArray[np.float64]]:
    """Largest multiplier in time of the motion near a given one, its distance from that, and it.

    The multiplier is NaN where shooting does not converge.
    """
    start = motion.in_time(steps)
    orbit = find_orbit(joint, frequency, force, damping, start, steps=steps, maximum_iterations=8)
    size = abs(orbit.multipliers)
    size = size[abs(size - 1) > _AT_REST]
    distance = float(np.linalg.norm(orbit.motion - start) / np.linalg.norm(start))
    largest = float(size.max()) if orbit.converged and size.size else np.nan
    return largest, distance, orbit.motion


def _returns(
    joint: Joint,
    frequency: float,
    force: float,
    damping: Damping,
    steps: int,
    motion: NDArray[np.float64],
    periods: int = 1000,
    disturbance: float = 1e-3,
) -> float:
    """1 where a disturbed motion returns from both senses, 0 where it leaves, NaN between."""
    size, distances = np.linalg.norm(motion), []
    for sense in (-1, 1):
        integration = Integration.of(joint, frequency, force, damping, steps)
        integration.follow(motion)
        integration.q[0] += sense * disturbance * abs(motion).max()
        distance = []
        for _ in range(periods):
            integration.advance()
            distance.append(float(np.linalg.norm(integration.history - motion) / size))
        distances.append(distance[-1] / distance[0])
    return 1.0 if max(distances) < 0.5 else 0.0 if max(distances) > 1 else np.nan


def _rows_of(args: argparse.Namespace) -> Iterator[dict[str, object]]:
    index, count = args.first, 0
    while count < args.count:
        for row in compare_marks(args.seed, index, args.motions)[: args.count - count]:
            count += np.isfinite(row["in_time"])
            print({name: np.round(value, 5) for name, value in row.items()}, flush=True)
            yield row
        index += 1


def main() -> None:
    """Compare, and print what came of it."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--count", type=int, default=100, help="motions found in time")
    parser.add_argument("--motions", type=int, default=3, help="of each response")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--first", type=int, default=0, help="index of the first joint")
    args = parser.parse_args()
    warnings.simplefilter("ignore")
    table = pd.DataFrame(_rows_of(args))
    known = table[table["in_time"].notna()]
    stable = known["in_time"] < 1
    right, of_one = stable == (known["stable"] == 1), stable == (known["of_one"] < 1)
    returned = (known["returns"] == (known["stable"] == 1)) & ~right
    from_one = table[table["from_one"].notna()]
    agree = (from_one["from_one"] < 1) == (from_one["stable"] == 1)
    off = abs(known["multiplier"] - known["in_time"])[right]
    off_of_one = abs(known["of_one"] - known["in_time"])
    print(
        f"{right.sum()} of {len(known)} marks right, {returned.sum()} more by disturbed motions; "
        f"{of_one.sum()} of one harmonic; "
        f"{len(table) - len(known)} motions not found in time, "
        f"{(known['harmonics'] < table['harmonics'].max()).sum()} marks of one harmonic\n"
        f"{agree.sum()} of {len(from_one)} marks agree with shooting from the solution itself\n"
        f"multipliers off by {off.median():.1e} in the median, {off.max():.1e} at most; "
        f"of one harmonic {off_of_one.median():.1e}, {off_of_one.max():.1e}"
    )
    print(known[~right].to_string())


if __name__ == "__main__":
    main()
