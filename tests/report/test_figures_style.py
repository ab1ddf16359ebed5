import re
import subprocess
import sys
from pathlib import Path

from fresh_imports import modules_loaded_by

from boltjoint import dataset
from boltjoint.report.figures.contact import plot_contact
from boltjoint.report.figures.responses import plot_response
from boltjoint.report.figures.style import save_figure


def test_the_same_figure_has_the_same_bytes(assembly, preload, tmp_path):
    for name in ("first", "second"):
        save_figure(plot_contact(assembly, preload), tmp_path / f"{name}.svg")
    written = (tmp_path / "first.svg").read_bytes()
    assert written == (tmp_path / "second.svg").read_bytes()
    assert not re.search(rb"<dc:date>", written)


def test_another_process_writes_the_same_bytes(response, reference, tmp_path):
    figure = plot_response(response, "regions=3", "linear", reference)
    save_figure(figure, tmp_path / "here.svg")
    dataset.save(response, tmp_path / "response.nc")
    dataset.save(reference, tmp_path / "reference.nc")
    program = (
        "from boltjoint import dataset\n"
        "from boltjoint.report.figures.responses import plot_response\n"
        "from boltjoint.report.figures.style import save_figure\n"
        "response, reference = (dataset.load(f'{n}.nc') for n in ('response', 'reference'))\n"
        "figure = plot_response(response, 'regions=3', 'linear', reference)\n"
        "save_figure(figure, 'there.svg')\n"
    )
    subprocess.run([sys.executable, "-c", program], cwd=tmp_path, check=True)
    assert Path(tmp_path, "here.svg").read_bytes() == Path(tmp_path, "there.svg").read_bytes()


def test_figures_import_no_compiler():
    names = "backbones, contact, convergence, responses"
    loaded = modules_loaded_by(f"from boltjoint.report.figures import {names}")
    assert not {"numba", "scipy"} & loaded


def test_pages_import_neither_compiler_nor_figures():
    loaded = modules_loaded_by(
        "from boltjoint.report.pages import accuracy, overview, structure\n"
        "from boltjoint.report.pages.case import page"
    )
    assert not {"numba", "scipy", "matplotlib"} & loaded
