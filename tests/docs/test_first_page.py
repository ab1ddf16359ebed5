"""The first page: its arrays give the output that it shows, and its pictures are of the library."""

import re
from pathlib import Path

import numpy as np
import pytest
from test_rooms import ROOMS

from boltjoint.config.study import load_study
from boltjoint.report.displays import DISPLAYS
from boltjoint.study.artefact_list import Contents

DOCS = Path(__file__).parents[2] / "docs"
PAGE = (DOCS / "index.md").read_text(encoding="utf-8")


def test_the_arrays_give_the_output_that_is_shown(capsys):
    code, output = re.search(r"```python\n(.*?)```\n\n```text\n(.*?)```", PAGE, re.DOTALL).groups()
    names = {}
    exec(code, names)
    assert capsys.readouterr().out == output
    assert len([line for line in code.splitlines() if line]) <= 12
    # stuck and without contact: eigenvalues of two matrices of two modes
    L = np.diag((2 * np.pi * np.array([70.0, 360.0])) ** 2)
    rows = names["relative_mode"]
    stuck = np.sqrt(np.linalg.eigvalsh(L + 5e6 * rows.T @ rows)[0]) / (2 * np.pi)
    first, _, last = (float(line.split()[2]) for line in output.splitlines())
    assert first == pytest.approx(stuck, abs=0.01)
    assert last == pytest.approx(70.0, rel=1e-3)


def test_the_picture_of_the_packages_has_their_order(monkeypatch):
    monkeypatch.syspath_prepend(str(DOCS))
    from rooms_picture import LAYERS

    shown = [name for _, rooms in LAYERS for name, _ in rooms]
    assert shown == [room for room in ROOMS if room in shown]
    packages = {
        path.parent.name for path in Path(DOCS.parent, "src/boltjoint").glob("*/__init__.py")
    }
    assert packages <= set(shown)


def test_the_measured_backbone_is_fitted_as_its_page_says(monkeypatch):
    monkeypatch.syspath_prepend(str(DOCS))
    from first_picture import fitted, measured_curve

    curve = measured_curve()
    ((of_frequency, of_damping),) = fitted(curve).rms_errors
    assert of_frequency < 2e-4
    assert of_damping < 0.05


#: figures that scripts of docs/ draw: the others are copied from results
DRAWN = {
    "growth": "benchmarks",
    "measured": "first_picture",
    "mesh_keys": "mesh_keys_picture",
    "rooms": "rooms_picture",
}


def test_every_figure_of_the_pages_is_drawn_or_copied_by_a_script(monkeypatch):
    monkeypatch.syspath_prepend(str(DOCS))
    from write import FIGURES, SHORTER

    files = set()
    for study in ("convergence", "sweeps"):
        configured = load_study(DOCS.parent, {"study": f"config/{study}.yaml"})
        files |= set(Contents(configured, DISPLAYS).files(form="figure"))
    copied = {name for names in FIGURES.values() for name in names}
    assert not {name for name in copied if f"results/figures/{name}.svg" not in files}
    there = {path.stem for path in DOCS.glob("figures/*.svg")}
    assert there == {*DRAWN, *(SHORTER.get(name, name) for name in copied)}
    for name, script in DRAWN.items():
        assert f"{name}.svg" in (DOCS / f"{script}.py").read_text(encoding="utf-8")
