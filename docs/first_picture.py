"""Draw the picture of the first page, a measured backbone and the joint fitted to it.

``python docs/first_picture.py`` writes ``docs/figures/measured.svg``.
"""

from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd

from boltjoint import Joint, MeasuredBackbone, Parameter, fit
from boltjoint.calibration.calibration import Calibration
from boltjoint.friction.iwan import FourParameterIwan
from boltjoint.report.figures.style import figure_style

HERE = Path(__file__).parent
TABLE = HERE.parent / "resources/measured/four_bolt_and_three_bolt_assemblies_20Nm_backbones.csv"


def measured_curve() -> MeasuredBackbone:
    """The first mode of the beam CD1, with 2 % of the frequency's range and 5 % of the damping."""
    table = pd.read_csv(TABLE).query("configuration == 'CD1'")
    amplitude, frequency, damping = table.to_numpy()[:, 1:].T.astype(float)
    deviations = 0.02 * np.ptp(frequency), 0.05 * damping
    return MeasuredBackbone(
        amplitude, frequency, deviations[0], damping, deviations[1], quantity="modal", name="CD1"
    )


def fitted(curve: MeasuredBackbone) -> Calibration:
    """One Iwan element on one mode, within bounds that the measured curve tells."""
    f, largest = curve.frequency, curve.amplitude.max()
    shift = (2 * np.pi) ** 2 * (f.max() ** 2 - f.min() ** 2)
    one, place = np.ones(1), np.zeros((1, 3))
    law = FourParameterIwan([0], [shift], [shift * largest], [-0.5], [1.0])
    joint = Joint(f.min() * one, one, one, one[:, None], place, law, place)
    return fit(
        joint,
        curve,
        [
            Parameter(
                "natural_frequency[1]", np.sqrt(10 * f.min() ** 2 - 9 * f.max() ** 2), f.min()
            ),
            Parameter("tangential_stiffness", shift, 10 * shift),
            Parameter("slip_force", 0.01 * shift * largest, 10 * shift * largest),
            Parameter("chi", -0.99, 0, logarithmic=False),
            Parameter("beta", 0.01, 100),
            Parameter("loss_factor", 1e-5, 2 * curve.damping_ratio.min()),
        ],
    )


@figure_style
def draw(path: Path) -> None:
    """Write the picture."""
    curve = measured_curve()
    calibration = fitted(curve)
    amplitude = np.geomspace(curve.amplitude.min(), curve.amplitude.max(), 120)
    (value,), (deviation,) = calibration.curves([amplitude]), calibration.bands([amplitude])
    figure, axes = plt.subplots(1, 2, figsize=(8.2, 3.0), layout="constrained")
    quantities = (
        (curve.frequency, 1, "Natural frequency (Hz)"),
        (curve.damping_ratio, 100, "Damping ratio (%)"),
    )
    for n, (axis, (points, factor, label)) in enumerate(zip(axes, quantities, strict=True)):
        middle, reach = factor * value[:, n], 2 * factor * deviation[:, n]
        axis.fill_between(
            1e6 * amplitude, middle - reach, middle + reach, color="#9ecae1", linewidth=0
        )
        axis.semilogx(1e6 * amplitude, middle, color="#08519c", label="fitted joint, 95 % band")
        axis.plot(
            1e6 * curve.amplitude,
            factor * points,
            "o",
            ms=3.5,
            mfc="white",
            mec="black",
            label="measured",
        )
        axis.set(xlabel="Modal amplitude (10$^{-6}$ kg$^{1/2}$ m)", ylabel=label)
        axis.set_xticks([6, 10, 20, 40], ["6", "10", "20", "40"])
        axis.minorticks_off()
        axis.grid(True)
    axes[0].legend()
    figure.savefig(path, metadata={"Date": None})
    plt.close(figure)


if __name__ == "__main__":
    draw(HERE / "figures/measured.svg")
