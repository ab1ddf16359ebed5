"""What README and docs show is what a reader gets: examples run, and their files are a study."""

import re

import numpy as np
import pytest
import yaml
from small_study import ROOT

from boltjoint.config.study import load_study
from boltjoint.report.displays import DISPLAYS
from boltjoint.study.artefact_list import Contents

README = (ROOT / "README.md").read_text(encoding="utf-8")
LIBRARY, STUDIES = (
    (ROOT / f"docs/{name}.md").read_text(encoding="utf-8") for name in ("library", "studies")
)


def blocks(language):
    return re.findall(rf"```{language}\n(.*?)```", LIBRARY, re.DOTALL)


def test_the_readme_is_one_screen_and_its_links_lead_somewhere():
    assert len(README.split()) < 700
    pages = [ROOT / "README.md", *(ROOT / "docs").glob("*.md")]
    for page in pages:
        text = page.read_text(encoding="utf-8")
        for link in re.findall(r"\]\(([^)#]+)(?:#[^)]*)?\)", text):
            if not re.match("[a-z]+:", link):
                assert (page.parent / link).exists(), (page.name, link)


def test_arrays_become_responses_and_a_backbone(capsys):
    (example,) = [block for block in blocks("python") if "import numpy" in block]
    names = {}
    exec(example, names)
    peaks = np.array([line.split() for line in capsys.readouterr().out.splitlines()[:3]], float)
    assert peaks[:, 0].tolist() == [0.01, 1.0, 10.0]
    # stuck and without contact: eigenvalues of two matrices of two modes
    L = np.diag((2 * np.pi * np.array([70.0, 360.0])) ** 2)
    rows = names["relative_mode"]
    stuck = np.sqrt(np.linalg.eigvalsh(L + 5e6 * rows.T @ rows)[0]) / (2 * np.pi)
    backbone = names["backbone"]
    # the loss factor couples modes to its second order
    assert stuck == pytest.approx(float(backbone["natural_frequency"][0]), rel=4e-6)
    assert f"{stuck:.2f} Hz" in LIBRARY
    assert f"{peaks[0, 1]:.2f} Hz" in LIBRARY
    # at 0.01 N the first pair has begun to slip; at 10 N all slip nearly all the time
    assert peaks[0, 1] == pytest.approx(stuck, rel=2e-3)
    assert peaks[2, 1] == pytest.approx(70.0, rel=1e-4)
    amplitude, frequency = backbone["response_amplitude"], backbone["natural_frequency"]
    on_backbone = np.interp(np.log(peaks[:, 2]), np.log(amplitude), frequency)
    # one mode of two, between its states
    np.testing.assert_allclose(peaks[:, 1], on_backbone, rtol=5e-3)


def test_the_example_is_short():
    (example,) = [block for block in blocks("python") if "import numpy" in block]
    assert len(example.splitlines()) <= 20


def test_the_files_of_ones_own_joint_are_a_study_without_another(tmp_path):
    files = re.findall(
        r"`config/(assemblies|cases)/mine\.yaml`:\n\n```yaml\n(.*?)```", STUDIES, re.S
    )
    assert [folder for folder, _ in files] == ["assemblies", "cases"]
    for folder, content in files:
        path = tmp_path / f"config/{folder}/mine.yaml"
        path.parent.mkdir(parents=True)
        path.write_text(content)
    (tmp_path / "config/config.yaml").write_text("cases: [another]\n")
    assert '--config "cases=[mine]"' in STUDIES
    study = load_study(tmp_path, {"cases": yaml.safe_load("[mine]")})
    contents = Contents(study, DISPLAYS)
    assert not contents.is_compared()
    kinds = {each.kind for each in contents.select(form="figure")}
    assert {"mesh", "contact", "response", "states", "backbone", "microslip", "models"} <= kinds
