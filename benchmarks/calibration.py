"""Calibrations by synthetic and public backbones: how often stated intervals hold, and times.

    python benchmarks/calibration.py --backbones 100

fits four parameters of a small joint with Iwan elements to its backbone under 1 % noise in the
damping and 0.1 % in the frequency, then to amplitudes far below full slip, where slip force and
beta are not determined, and one Iwan element on one mode to public backbones
(``resources/measured``).
"""

import argparse
import sys
import time
from pathlib import Path

import numpy as np
import pandas as pd

sys.path.insert(0, str(Path(__file__).parents[1] / "tests/calibration"))
from calibrated_joint import MODEL, PARAMETERS, TRUTH, curve_of, synthetic
from test_residual_checks import one_mode

from boltjoint import MeasuredBackbone, Parameter, fit
from boltjoint.calibration.fit import CalibrationOptions

TABLE = (
    Path(__file__).parents[1]
    / "resources/measured/four_bolt_and_three_bolt_assemblies_20Nm_backbones.csv"
)


def intervals(count: int) -> None:
    """How often 95 % intervals hold each parameter."""
    starts = [
        Parameter(p.name, p.low, p.high, p.logarithmic, 0.7 * TRUTH[p.name]) for p in PARAMETERS
    ]
    options = CalibrationOptions(starts=1)
    held, begin = np.zeros(len(starts)), time.process_time()
    for seed in range(count):
        found = fit(MODEL, synthetic(seed), starts, options=options)
        truth = found.compared.space.scaled(list(TRUTH.values()))
        held += abs(found.scaled - truth) < 1.96 * found.standard_error
    print(f"{(time.process_time() - begin) / count:.2f} s of processor time a fit")
    for parameter, times in zip(starts, held, strict=True):
        print(f"{parameter.name:24s} within its interval {times:.0f} of {count} times")


def undetermined(count: int) -> None:
    """How often parameters that low amplitudes do not determine are named."""
    amplitudes, named = np.geomspace(1e-7, 1e-6, 15), 0
    starts = [
        Parameter(p.name, p.low, p.high, p.logarithmic, 0.7 * TRUTH[p.name]) for p in PARAMETERS
    ]
    options = CalibrationOptions(starts=1)
    (curves,) = fit(MODEL, synthetic(), starts, options=options).curves([amplitudes])
    parameters = [*starts, Parameter("beta", 1e-3, 1e3)]
    for seed in range(count):
        curve = curve_of(curves, amplitudes, 0.01, seed, resonance=1)
        found = fit(MODEL, curve, parameters, options=options)
        named += {"slip_force", "beta"} <= set(found.undetermined)
    print(f"slip force and beta named as not determined {named} of {count} times")


def public(starts: int) -> None:
    """One Iwan element on one mode, six parameters, by public backbones of assemblies."""
    table = pd.read_csv(TABLE)
    for name in ("CD1", "CD2", "C1"):
        rows = table[table["configuration"] == name]
        a, f, z = rows[["modal_amplitude", "frequency_Hz", "damping_ratio"]].to_numpy().T
        curve = MeasuredBackbone(a, f, 0.02 * np.ptp(f), z, 0.05 * z, quantity="modal", name=name)
        joint, parameters = one_mode(curve)
        begin = time.process_time()
        found = fit(joint, curve, parameters, options=CalibrationOptions(starts=starts))
        seconds = (time.process_time() - begin) / starts
        near = np.count_nonzero(found.costs < 1.1 * found.costs.min())
        ((frequency, damping),) = found.rms_errors
        print(
            f"{name}: {frequency:.4%} in frequency, {damping:.2%} in damping, {near} of {starts} "
            f"starts within 10 % of the least sum, {seconds:.1f} s a start; "
            f"not determined: {', '.join(found.undetermined) or 'none'}"
        )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--backbones", type=int, default=100)
    parser.add_argument("--undetermined", type=int, default=20)
    parser.add_argument("--starts", type=int, default=8)
    given = parser.parse_args()
    intervals(given.backbones)
    undetermined(given.undetermined)
    public(given.starts)


if __name__ == "__main__":
    main()
