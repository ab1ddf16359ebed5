"""Examples of Python on the pages run as they stand there, one after another on each page."""

import re
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from boltjoint import ConstantLoad, Joint, dataset, simulate_ring_down, solve_branch, solve_response
from boltjoint.friction.iwan import FourParameterIwan
from boltjoint.joint.io import joint_to_dataset

DOCS = Path(__file__).parents[2] / "docs"
#: run by tests of their own, which hold what comes out
ELSEWHERE = {"index": 1, "library": 1, "structures": 2}


def blocks(page):
    """The examples of a page that no other test runs."""
    found = re.findall(r"```python\n(.*?)```", (DOCS / f"{page}.md").read_text(), re.DOTALL)
    return found[ELSEWHERE.get(page, 0) :]


@pytest.fixture
def joint():
    one, place = np.ones(1), np.zeros((1, 3))
    law = ConstantLoad([0], [1e5], [20.0])
    return Joint(70 * one, 2 * one, 2 * one, np.array([[0.5]]), place, law, place)


@pytest.fixture
def study(tmp_path, monkeypatch, joint):
    """A folder with the results that pages name."""
    monkeypatch.chdir(tmp_path)
    case = tmp_path / "results/cases/three_bolt_constant/free-4"
    (case / "regions=6").mkdir(parents=True)
    dataset.save(joint_to_dataset(joint), case / "regions=6/joint.nc", {})
    (case / "node-to-node/linear/resonance=1").mkdir(parents=True)
    response = solve_response(joint, [1.0, 5.0], damping=2e-3)
    dataset.save(response, case / "node-to-node/linear/resonance=1/response.nc", {})
    return tmp_path


def test_pages_with_examples_are_those_here():
    pages = {path.stem for path in DOCS.glob("*.md") if "```python" in path.read_text()}
    assert pages == {"index", "library", "measurement", "structures", "studies"}


@pytest.mark.usefixtures("study")
def test_the_library_in_notebooks_and_with_files(joint, capsys):
    names = {"joint": joint, "response": solve_response(joint, [1.0, 5.0], damping=2e-3)}
    in_notebook, with_files = blocks("library")
    exec(in_notebook, names)
    peak = names["five"]["peak_amplitude"].item()
    along = abs(names["five"]["complex_amplitude"]).max().item()
    assert along == pytest.approx(peak, rel=1e-6)
    exec(with_files, names)
    frequency, amplitude = map(float, capsys.readouterr().out.split())
    assert frequency == pytest.approx(names["five"]["peak_frequency"].item(), rel=1e-6)
    assert amplitude == pytest.approx(peak, rel=1e-6)


@pytest.mark.usefixtures("study")
def test_results_are_read(capsys):
    (example,) = blocks("studies")
    exec(example, {})
    assert "peak_frequency" in capsys.readouterr().out


def test_a_ring_down_is_identified_and_a_joint_fitted_to_it(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    count = 30
    one, places = np.ones(1), np.zeros((count, 3))
    slip = 40 / count * np.linspace(0.02, 1.0, count) ** 2
    sliders = ConstantLoad(np.arange(count), np.full(count, 2e5 / count), slip)
    measured = Joint(75 * one, one, one, np.full((count, 1), 0.5), places, sliders, places)
    decay = simulate_ring_down(measured, 0.008, impulse=0.3, duration=1.5, sampling_rate=4096.0)
    columns = {"time_s": decay.time, "acceleration_m_per_s2": np.ravel(decay.values)}
    pd.DataFrame(columns).to_csv("decay.csv", index=False)
    place = np.zeros((1, 3))
    law = FourParameterIwan([0], [1e7], [100.0], [-0.5], [1.0])
    joint = Joint(75 * one, one, one, np.array([[0.1]]), place, law, place)
    names = {"joint": joint}
    identify, calibrate, with_sine = blocks("measurement")
    exec(identify, names)
    mode = names["mode"]
    assert 75 < mode.frequency.min() < mode.frequency.max() < 90
    exec(calibrate, names)
    ((of_frequency, of_damping),) = names["found"].rms_errors
    assert of_frequency < 2e-3
    assert of_damping < 0.2
    assert "tangential_stiffness" in capsys.readouterr().out
    branch = solve_branch(measured, 0.3, damping=0.008)
    every = branch.frequency.size // 20
    names["frequency"] = branch.frequency[::every]
    names["acceleration"] = branch.amplitude[::every] * (2 * np.pi * names["frequency"]) ** 2
    names["force"] = np.full(len(names["frequency"]), 0.3)
    # that of the acceleration: half a turn behind at rest, a quarter at the peak
    off = branch.frequency[::every] - branch.peak_frequency
    names["phase"] = np.pi / 2 - np.arctan(off / 0.5)
    exec(with_sine, names)
    assert [len(errors) for errors in names["found"].rms_errors] == [2, 2]
