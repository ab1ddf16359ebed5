"""Draw the packages of the library, highest first, for the page of its architecture.

``python docs/rooms_picture.py`` writes ``docs/figures/rooms.svg``.
"""

from pathlib import Path

import matplotlib.pyplot as plt

from boltjoint.report.figures.style import figure_style

HERE = Path(__file__).parent
#: packages that import only from those below, highest first, by what they are for
LAYERS = (
    ("what people use", (("command", "the command boltjoint"),)),
    (
        "what a study says",
        (
            ("reproduction", "values of the published study"),
            ("report", "figures and pages"),
            ("study", "files, tables, sweeps"),
        ),
    ),
    (
        "what is measured and checked",
        (
            ("calibration", "joints fitted to backbones"),
            ("measurement", "ring-downs, stepped sines"),
            ("verification", "time integration"),
        ),
    ),
    (
        "mechanics",
        (
            ("dynamics", "responses, backbones"),
            ("structure", "matrices, preload, modes"),
            ("joint", "contact points, regions"),
        ),
    ),
    (
        "laws and solvers",
        (
            ("config", "YAML files, typed"),
            ("friction", "friction laws"),
            ("damping", "of the structure"),
            ("solvers", "Newton, arc length"),
        ),
    ),
    (
        "basis",
        (
            ("provenance", "environment, logs"),
            ("harmonics", "periodic motions"),
            ("names", "names of joints"),
            ("dataset", "netCDF files"),
        ),
    ),
)
_COLOURS = ("#fde0c5", "#f8cbb6", "#e6d5e8", "#c9dff0", "#cfe8d5", "#e8e8e8")


@figure_style
def draw(path: Path) -> None:
    """Write the picture."""
    figure, axes = plt.subplots(figsize=(8.4, 4.6), layout="constrained")
    for row, ((title, rooms), colour) in enumerate(zip(LAYERS, _COLOURS, strict=True)):
        bottom, width = -row * 1.2, 8.0 / len(rooms)
        axes.text(-0.15, bottom + 0.5, title, ha="right", va="center")
        for n, (name, words) in enumerate(rooms):
            left = n * width
            axes.add_patch(
                plt.Rectangle((left, bottom), width - 0.1, 1.0, fc=colour, ec="0.4", lw=0.6)
            )
            axes.text(
                left + width / 2, bottom + 0.63, name, ha="center", va="center", weight="bold"
            )
            axes.text(left + width / 2, bottom + 0.3, words, ha="center", va="center", size=7.5)
    axes.annotate(
        "imports", (8.25, -6.0), (8.25, 1.0), ha="center", arrowprops={"arrowstyle": "->"}
    )
    axes.set(xlim=(-2.6, 8.7), ylim=(-6.1, 1.3))
    axes.axis("off")
    figure.savefig(path, metadata={"Date": None})
    plt.close(figure)


if __name__ == "__main__":
    draw(HERE / "figures/rooms.svg")
