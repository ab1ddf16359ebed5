"""Responses and backbones of random small joints: which branches break off, which peaks are missed.

    python benchmarks/random_joints.py --count 1000

solves as many joints of each friction law in linear modes, with a complex response-dependent mode
and by their backbone, and prints how many branches are complete, every one that is not with its
reason, every peak that is lower than its own branch, and the residual in time at the peaks; but for
backbones, which leave other modes out, every peak with a large one or another than in linear modes.
"""

import argparse
import time
import warnings
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from typing import NamedTuple

import numpy as np
import pandas as pd
from numpy.typing import NDArray
from threadpoolctl import threadpool_limits

from boltjoint.dynamics.response.frequency_response import solve_branch
from boltjoint.dynamics.response.response_file import to_dataset
from boltjoint.dynamics.response.stability import StabilityOptions
from boltjoint.friction.constant import ConstantLoad
from boltjoint.friction.iwan import FourParameterIwan
from boltjoint.friction.variable import VariableLoad
from boltjoint.joint.io import joint_to_dataset
from boltjoint.joint.model import Joint
from boltjoint.verification import residual_in_time

LAWS = ("constant", "variable", "iwan")
COORDINATES = ("linear", "complex-rdnm-1", "backbone")
SEED = 20261122
#: residual in time over the force, above which a peak in all modes is none
LARGEST_RESIDUAL = 1e-5
#: relative difference of amplitudes above which a peak is another than in linear modes
LARGEST_DIFFERENCE = 1e-7


class RandomJoint(NamedTuple):
    """A joint with a force [N] and a loss factor."""

    joint: Joint
    force: float
    loss_factor: float


def random_joint(law: str, index: int, seed: int = SEED) -> RandomJoint:
    """A random joint: the same for the same law, index and seed.

    Two to six modes, of which neighbours may differ by a ten-thousandth in frequency; three to
    forty elements, several of which may share a point; contact that is soft or stiff against the
    structure; under variable load up to a million times as stiff across as along the surface, with
    gaps; Iwan elements of any shape; and a force from stuck to full slip.
    """
    random = np.random.default_rng([seed, LAWS.index(law), index])
    modes, elements = int(random.integers(2, 7)), int(3 * (40.99 / 3) ** random.random())
    points = int(random.integers(max(1, elements // 4), elements + 1))
    close = random.random(modes - 1) < 0.3
    ratio = np.where(
        close,
        1 + 10 ** random.uniform(-4.0, -1.5, modes - 1),
        random.uniform(1.2, 7.0, modes - 1),
    )
    frequency = 10 ** random.uniform(1.0, 3.0) * np.cumprod(np.append(1.0, ratio))
    excitation = random.normal(size=modes)
    response = excitation if random.random() < 0.5 else random.normal(size=modes)

    place = np.linspace(0.0, 1.0, points)
    along = relative_rows(random, place, modes)
    on = np.concatenate([np.arange(points), random.integers(0, points, elements - points)])
    random.shuffle(on)
    squared = (2 * np.pi * frequency) ** 2
    # stiffness against that of the first mode
    weight = 10 ** random.uniform(-0.7, 0.7, elements)
    tangential = weight * 10 ** random.uniform(-1.5, 2.0) * squared[0]
    tangential /= weight @ along[on, 0] ** 2
    load = 10 ** random.normal(0.0, random.uniform(0.1, 1.0), elements)
    friction = 10 ** random.uniform(-1.3, 0.0)
    loss_factor = 10 ** random.uniform(-3.3, -1.5)
    across = None
    if law == "constant":
        elements_of_law = ConstantLoad(on, tangential, friction * load)
    elif law == "iwan":
        chi = random.uniform(-0.95, 0.0, elements)
        beta = random.choice([0.0, 0.1, 1.0, 10.0], elements)
        elements_of_law = FourParameterIwan(on, tangential, friction * load, chi, beta)
    else:
        across = relative_rows(random, place, modes)
        normal = tangential * 10 ** random.uniform(-1.5, random.choice([1.0, 6.0]))
        stiffest = normal @ across[on, 0] ** 2 / squared[0]
        too_stiff = max(1.0, stiffest / 10 ** random.uniform(1.0, 6.0))
        normal, tangential = normal / too_stiff, tangential / too_stiff
        is_open = random.random(elements) < random.choice([0.0, 0.2, 0.5])
        is_open[0] = False
        gap = load / tangential * (tangential / normal) ** random.uniform(0.0, 1.0, elements)
        elements_of_law = VariableLoad(
            point_of_element=on,
            tangential_stiffness=tangential,
            normal_stiffness=normal,
            normal_load=np.where(is_open, -normal * gap, load),
            friction_coefficient=np.full(elements, friction),
        )
    position = np.column_stack([place, 0 * place, 0 * place])
    joint = Joint(
        natural_frequency=frequency,
        excitation_mode=excitation,
        response_mode=response,
        tangential_mode=along,
        position=position,
        law=elements_of_law,
        element_position=position[on],
        normal_mode=across,
    )
    force = _force_at_onset(joint, loss_factor) * 10 ** random.uniform(-2.5, 2.5)
    return RandomJoint(joint, float(force), float(loss_factor))


def relative_rows(
    random: np.random.Generator, place: NDArray[np.float64], modes: int
) -> NDArray[np.float64]:
    """Relative modes that vary along the joint, smoothly or from point to point."""
    phase = np.outer(place, np.arange(1, modes + 1)) * random.uniform(0.2, 3.0)
    smooth = np.cos(phase + random.uniform(0, 2 * np.pi, modes)) * random.normal(size=modes)
    return smooth + 10 ** random.uniform(-2.0, 0.5) * random.normal(size=(place.size, modes))


def _force_at_onset(joint: Joint, loss_factor: float) -> float:
    """The force at whose stuck resonance half of the closed elements would slip [N]."""
    squared = (2 * np.pi * joint.natural_frequency) ** 2
    mode = np.linalg.eigh(np.diag(squared) + joint.stuck_stiffness())[1][:, 0]
    by_force = abs(mode @ joint.excitation_mode) / (loss_factor * mode @ (squared * mode))
    law = joint.law
    closed = law.slip_force > 0
    moved = abs(joint.tangential_mode @ mode)[law.point_of_element]
    onset = law.slip_force[closed] / (law.tangential_stiffness * moved)[closed]
    return float(np.median(onset)) / by_force


def solve(law: str, coordinates: str, index: int, seed: int = SEED) -> dict[str, object]:
    """The branch of a random joint, and its peak beside the highest solution of its own."""
    joint, force, loss_factor = random_joint(law, index, seed)
    begun = time.process_time()
    with threadpool_limits(limits=1):
        branch = solve_branch(joint, force, method=coordinates, damping=loss_factor)
    cpu = time.process_time() - begun
    peak = 0.0 if branch.peak is None else branch.amplitude[branch.peak]
    residual = np.nan
    if branch.peak is not None:
        one_harmonic = StabilityOptions(harmonics=1)
        response = to_dataset(joint, [branch], loss_factor, stability=one_harmonic)
        response = response.isel(solution=[branch.peak])
        residual = residual_in_time.residuals_in_time(joint_to_dataset(joint), response)[0]
    return {
        "law": law,
        "coordinates": coordinates,
        "index": index,
        "complete": branch.complete,
        "reason": branch.reason,
        "solutions": branch.frequency.size,
        "peak": peak,
        "missed": bool(branch.complete and _highest_inside(branch.amplitude) > peak),
        "residual_in_time": residual,
        "cpu_s": cpu,
    }


def _highest_inside(amplitude: NDArray[np.float64]) -> float:
    """The largest solution that is higher than both its neighbours; zero without one."""
    inside = amplitude[1:-1]
    higher = inside[(inside >= amplitude[:-2]) & (inside >= amplitude[2:])]
    return float(higher.max(initial=0.0))


def print_other_peaks(some: pd.DataFrame, linear: pd.DataFrame) -> None:
    """Print those of joints of a law that are not the peak in linear modes."""
    both = some.merge(linear, on=["law", "index"], suffixes=("", "_linear"))
    largest = both[["peak", "peak_linear"]].max(axis=1)
    both["difference"] = (both["peak"] - both["peak_linear"]) / largest.where(largest > 0, 1.0)
    for row in both[abs(both["difference"]) > LARGEST_DIFFERENCE].itertuples():
        print(f"  {row.index}: peak differs by {row.difference:.1e} from that in linear modes")


def _solve(task: tuple[str, str, int, int]) -> dict[str, object]:
    warnings.simplefilter("ignore")
    try:
        return solve(*task)
    except Exception as error:
        law, coordinates, index, _ = task
        names = {"law": law, "coordinates": coordinates, "index": index}
        return names | {"complete": False, "reason": repr(error), "missed": False, "cpu_s": 0.0}


def _tasks(args: argparse.Namespace) -> Iterator[tuple[str, str, int, int]]:
    for law in args.law:
        for coordinates in args.coordinates:
            for index in range(args.first, args.first + args.count):
                yield law, coordinates, index, args.seed


def main() -> None:
    """Solve, and print what came of it."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--count", type=int, default=1000, help="joints of each law")
    parser.add_argument("--first", type=int, default=0, help="index of the first joint")
    parser.add_argument("--seed", type=int, default=SEED)
    parser.add_argument("--law", nargs="+", default=LAWS, choices=LAWS)
    parser.add_argument("--coordinates", nargs="+", default=COORDINATES)
    parser.add_argument("--cores", type=int, default=2)
    parser.add_argument("--csv", help="file for a row of each branch")
    args = parser.parse_args()
    rows: list[dict[str, object]] = []
    with ProcessPoolExecutor(args.cores) as pool:
        for row in pool.map(_solve, _tasks(args), chunksize=4):
            rows.append(row)
            # what is solved is kept where a run is ended
            if args.csv and len(rows) % 20 == 0:
                pd.DataFrame(rows).to_csv(args.csv, index=False)
    table = pd.DataFrame(rows)
    if args.csv:
        table.to_csv(args.csv, index=False)
    for (law, coordinates), some in table.groupby(["law", "coordinates"], sort=False):
        whole = some[some["complete"]]
        print(
            f"{law}, {coordinates}: {len(whole)} of {len(some)} complete "
            f"({100 * len(whole) / len(some):.2f} %), {some['missed'].sum()} peaks missed, "
            f"residual in time at the peaks median {whole['residual_in_time'].median():.1e}, "
            f"largest {whole['residual_in_time'].max():.1e}, {some['cpu_s'].sum():.0f} s"
        )
        for row in some[~some["complete"] | some["missed"]].itertuples():
            print(f"  {row.index}: {row.reason or 'peak missed'}")
        if coordinates != "backbone":
            for row in some[some["residual_in_time"] > LARGEST_RESIDUAL].itertuples():
                print(f"  {row.index}: peak with a residual of {row.residual_in_time:.1e}")
            print_other_peaks(some, table[table["coordinates"] == "linear"])


if __name__ == "__main__":
    main()
