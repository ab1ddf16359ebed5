"""Frequency responses of joints against those of NLvib, a program for MATLAB that runs in Octave.

    git clone https://github.com/maltekrack/NLvib
    python benchmarks/compare_nlvib.py --nlvib NLvib

hands the modes and friction elements of the joint of the first page and of random ones to NLvib,
which follows them by its own continuation with its own AFT. At the frequency of each of its
solutions the balance is solved here, from that solution. Printed are the largest difference of the
output point's amplitude, over the largest, and the solutions, evaluations of the equations and
processor time of both programs. Octave interprets loops and MATLAB compiles them: NLvib is faster
there.

References
----------
M. Krack, J. Gross: Harmonic Balance for Nonlinear Vibration Problems. Springer, 2019.
"""

import argparse
import subprocess
import tempfile
import time
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pandas as pd
from numpy.typing import NDArray
from random_joints import random_joint
from scipy.io import loadmat, savemat
from scipy.optimize import root
from threadpoolctl import threadpool_limits

from boltjoint import ConstantLoad, Joint, frequency_window, solve_branch
from boltjoint.damping import ModalDamping
from boltjoint.dynamics.balance.harmonic_balance import HarmonicBalance, OutputPoint
from boltjoint.friction.aft import AlternatingFrequencyTime

Array = NDArray[np.float64]

HARMONICS = (1, 7)
SAMPLES = 256
#: of every mode
DAMPING_RATIO = 0.005

#: reads problem.mat, whose times are in units of the first mode and lengths in those of the stuck
#: response, and writes solutions.mat
PROGRAM = """
load('problem.mat');
addpath(fullfile(nlvib, 'SRC'));
addpath(fullfile(nlvib, 'SRC', 'MechanicalSystems'));
elements = cell(1, numel(stiffness));
for i = 1:numel(stiffness)
  elements{i} = struct('type', 'elasticDryFriction', 'ishysteretic', true, ...
    'stiffness', stiffness(i), 'friction_limit_force', slip_force(i), ...
    'force_direction', direction(:, i));
end
n = numel(square);
K = diag(square);
system = MechanicalSystem(eye(n), diag(damping), K, elements, force(:));
stuck = K + direction * diag(stiffness) * direction';
Q1 = (stuck - low^2 * eye(n) + 1i * low * diag(damping)) \\ force(:);
x0 = zeros((2 * H + 1) * n, 1);
x0(n + (1:2 * n)) = [real(Q1); -imag(Q1)];
how = struct('jac', 'full', 'stepmax', 3000, 'dynamicDscale', 1, ...
  'Dscale', [1e-1 * ones(size(x0)); 1]);
solver = optimset('Display', 'off', 'Jacobian', 'on', 'MaxIter', 50, 'TolFun', 1e-12, ...
  'TolX', 1e-12);
begin = cputime;
[X, told] = solve_and_continue(x0, @(X) HB_residual(X, system, H, N), low, high, step, how, {}, ...
  solver);
seconds = cputime - begin;
evaluations = told.FCtotal;
save('-v6', 'solutions.mat', 'X', 'seconds', 'evaluations');
"""


class Problem(NamedTuple):
    """A joint with a force [N]."""

    name: str
    joint: Joint
    force: float


def first_page() -> Joint:
    """The joint of the first page of the documentation."""
    relative_mode = np.array([[0.05, -0.1], [0.2, 0.65], [0.35, 1.4]])
    tip, place = np.array([2.0, -1.9]), np.array([[0.0, 0, 0], [0.05, 0, 0], [0.1, 0, 0]])
    friction = ConstantLoad([0, 1, 2], [5e6, 5e6, 5e6], [2.0, 7.0, 12.0])
    return Joint(np.array([70.0, 360.0]), tip, tip, relative_mode, place, friction, place)


def problems(count: int, seed: int) -> Iterator[Problem]:
    """The joint of the first page, then random ones at the onset of slip of many elements."""
    for force in (1.0, 2.0, 4.0):
        yield Problem("first page", first_page(), force)
    for index in range(count):
        drawn = random_joint("constant", index, seed)
        yield Problem(f"random {seed}/{index}", drawn.joint, drawn.force)


class Followed(NamedTuple):
    """Solutions of NLvib: coefficients [kg^1/2 m] and frequencies [rad/s]."""

    motion: Array
    frequency: Array
    evaluations: float
    seconds: float


def follow(
    balance: HarmonicBalance, harmonics: int, window: tuple[float, float], nlvib: Path
) -> Followed:
    """Solutions of NLvib across a window [Hz], as vectors of the balance."""
    joint, law = balance.joint, balance.joint.law
    w = 2 * np.pi * joint.natural_frequency
    time_unit, low, high = 1 / w[0], *(2 * np.pi * f / w[0] for f in window)
    length = np.linalg.norm(balance.stuck_solution(2 * np.pi * window[0]))
    content = {
        "square": (w * time_unit) ** 2,
        "damping": 2 * DAMPING_RATIO * w * time_unit,
        "direction": joint.tangential_mode[law.point_of_element].T,
        "stiffness": law.tangential_stiffness * time_unit**2,
        "slip_force": law.slip_force * time_unit**2 / length,
        "force": balance.excitation_force * joint.excitation_mode * time_unit**2 / length,
        "low": low,
        "high": high,
        "step": 0.02 * (high - low),
        "H": float(harmonics),
        "N": float(SAMPLES),
        "nlvib": str(nlvib.resolve()),
    }
    with tempfile.TemporaryDirectory() as folder:
        savemat(Path(folder) / "problem.mat", content)
        (Path(folder) / "program.m").write_text(PROGRAM)
        # objects that still live at its end are an error to Octave, when all is done
        run = subprocess.run(
            ["octave-cli", "program.m"], cwd=folder, capture_output=True, text=True, check=False
        )
        if not (solutions := Path(folder) / "solutions.mat").exists():
            raise SystemExit(run.stderr)
        told = loadmat(solutions)
    # mean, then cosine and sine of each harmonic, of all modes
    Q = length * told["X"][:-1].reshape(2 * harmonics + 1, w.size, -1)
    motion = np.empty((len(balance.components), *Q.shape[1:]))
    for number, sine, cosine in balance.components.harmonics:
        # its force is a cosine: all happens a quarter of a period earlier
        later = (Q[2 * number - 1] - 1j * Q[2 * number]) * np.exp(-0.5j * np.pi * number)
        motion[sine], motion[cosine] = -later.imag, later.real
    return Followed(
        motion.reshape(-1, Q.shape[2]).T,
        told["X"][-1] / time_unit,
        told["evaluations"].item(),
        told["seconds"].item(),
    )


def compare(problem: Problem, harmonics: int, nlvib: Path) -> dict[str, object]:
    """A row of the table."""
    law = AlternatingFrequencyTime(problem.joint.law, harmonics, SAMPLES)
    joint = replace(problem.joint, law=law).distinct
    damping = ModalDamping((DAMPING_RATIO,))
    balance = HarmonicBalance(joint, damping, problem.force)
    window = frequency_window(joint)
    solve_branch(joint, problem.force, damping=damping)  # compiled from here on
    begin = time.process_time()
    branch = solve_branch(joint, problem.force, damping=damping)
    seconds = time.process_time() - begin
    followed = follow(balance, harmonics, window, nlvib)
    output, differences = OutputPoint(balance), []
    for x, w in zip(followed.motion, followed.frequency, strict=True):
        solved = root(
            lambda q, w=w: balance.residual(q, w),
            x,
            jac=lambda q, w=w: balance.residual_and_jacobian(q, w)[1](),
            options={"xtol": 1e-12},
        )
        differences.append(abs(output(solved.x) - output(x)))
    largest = output.amplitudes(followed.motion).max()
    return {
        "joint": problem.name,
        "force_N": problem.force,
        "elements": joint.law.slip_force.size,
        "harmonics": harmonics,
        "difference": max(differences) / largest,
        "solutions": len(differences),
        "solutions_here": branch.frequency.size,
        "evaluations": followed.evaluations,
        "evaluations_here": int(branch.iterations.sum()),
        "seconds": followed.seconds,
        "seconds_here": seconds,
    }


def main() -> None:
    """Compare, and print the table."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--nlvib", type=Path, required=True, help="folder of its checkout")
    parser.add_argument("--count", type=int, default=5, help="random joints")
    parser.add_argument("--seed", type=int, default=1)
    args = parser.parse_args()
    with threadpool_limits(1):
        rows = []
        for problem in problems(args.count, args.seed):
            rows += [compare(problem, harmonics, args.nlvib) for harmonics in HARMONICS]
            print(problem.name, flush=True)
    print(pd.DataFrame(rows).to_string(index=False, float_format="{:.3g}".format))


if __name__ == "__main__":
    main()
