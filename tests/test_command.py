"""The command ``boltjoint``, in a checkout and from a wheel."""

import os
import re
import shutil
import site
import subprocess
import sys
import venv
from pathlib import Path

import meshio
import numpy as np
import pandas as pd
import pytest
import pyuff
from scipy.io import loadmat

from boltjoint import dataset
from boltjoint.command.main import main, without_usage
from boltjoint.config.study import load_study
from boltjoint.study.export import export_responses
from boltjoint.study.implausible_values import implausible

ROOT = Path(__file__).parents[1]


def test_a_new_study_is_complete_and_plausible(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert main(["new", "my_joint"]) == 0
    study = load_study(tmp_path / "my_joint")
    assert list(study.cases) == ["my_joint"]
    assert not list(implausible(study))
    # what is commented out is right, too
    case = tmp_path / "my_joint/config/cases/my_joint.yaml"
    text = case.read_text()
    case.write_text(text.replace("# excitation:", "excitation:").replace("# sensors:", "sensors:"))
    assert load_study(tmp_path / "my_joint").case("my_joint").sensors[0].name == "tip"
    case.write_text(text)
    with_sweep = load_study(tmp_path / "my_joint", {"sweeps": ["my_joint"]})
    assert list(with_sweep.sweeps) == ["my_joint"]
    capsys.readouterr()
    # what is there is never overwritten
    assert main(["new", "my_joint"]) == 1
    assert "is there already: nothing was written" in capsys.readouterr().err
    assert main(["new", "my joint"]) == 1
    assert "is no name of a study" in capsys.readouterr().err
    assert not (tmp_path / "my joint").exists()


def test_check_says_what_is_wrong_or_needed(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    main(["new", "mine"])
    capsys.readouterr()
    assert main(["check", str(tmp_path / "mine")]) == 0
    assert "Estimate: 8 frequency responses in less than a minute" in capsys.readouterr().out
    (tmp_path / "mine/config/other.yaml").write_text("cases: [nowhere]\n")
    assert main(["check", str(tmp_path / "mine"), "--study", "config/other.yaml"]) == 1
    assert "nowhere" in capsys.readouterr().err
    assembly = tmp_path / "mine/config/assemblies/mine.yaml"
    text = assembly.read_text()
    assembly.write_text(text.replace("modulus_GPa: 70 ", "modulus_GPa: 70000 "))
    assembly.write_text(text.replace("youngs_modulus_GPa: 70", "youngs_modulus_GPa: 70000"))
    assert main(["check", str(tmp_path / "mine")]) == 0
    assert "is this in MPa?" in capsys.readouterr().out
    assembly.write_text(text.replace("youngs_modulus_GPa", "young_modulus_GPa"))
    assert main(["check", str(tmp_path / "mine")]) == 1
    assert "did you mean youngs_modulus_GPa?" in capsys.readouterr().err


def test_what_is_not_there_is_said_with_what_to_do(tmp_path, capsys):
    assert main(["run", str(tmp_path)]) == 1
    assert "has no config/config.yaml: boltjoint new" in capsys.readouterr().err
    assert main(["check", str(tmp_path / "nowhere")]) == 1
    assert "has no config/config.yaml: boltjoint new" in capsys.readouterr().err
    assert main(["open", str(tmp_path)]) == 1
    assert "overview.html is not there: boltjoint run" in capsys.readouterr().err
    assert main(["export", str(tmp_path)]) == 1
    assert "has no config/config.yaml: boltjoint new" in capsys.readouterr().err
    main(["new", str(tmp_path / "mine")])
    assert main(["export", str(tmp_path / "mine")]) == 1
    assert "run the study first" in capsys.readouterr().err
    assert main([]) == 0
    assert "write a commented assembly, case and sweep" in capsys.readouterr().out
    with pytest.raises(SystemExit):
        main(["open", str(tmp_path), "--forceall"])


def test_an_option_that_snakemake_does_not_know_is_one_line():
    lines = """usage: __main__.py [-h] [--dry-run]
  --dry-run   Do not execute anything.
__main__.py: error: unrecognized arguments: --fast"""
    assert list(without_usage(f"{line}\n" for line in lines.splitlines())) == [
        "__main__.py: error: unrecognized arguments: --fast",
    ]


@pytest.mark.workflow
def test_a_wheel_runs_a_new_study_in_an_empty_folder(tmp_path, caplog):
    """In an environment of its own, with the dependencies of this one and no checkout."""
    source = tmp_path / "source"
    source.mkdir()
    # pip builds in the folder of the project
    for name in ("pyproject.toml", "README.md", "LICENSE"):
        (source / name).write_bytes((ROOT / name).read_bytes())
    for name in ("src", "workflow", "profiles", "resources"):
        (source / name).symlink_to(ROOT / name)
    pip = [sys.executable, "-m", "pip", "--quiet", "wheel", "--no-deps", str(source)]
    subprocess.run([*pip, "--wheel-dir", str(tmp_path)], check=True, capture_output=True)
    (wheel,) = tmp_path.glob("*.whl")
    venv.create(tmp_path / "venv", with_pip=True)
    python = tmp_path / "venv/bin/python"
    install = [str(python), "-m", "pip", "--quiet", "install", "--no-deps", str(wheel)]
    subprocess.run(install, check=True, capture_output=True)
    copy_machine_code(ROOT / "src/boltjoint", tmp_path)
    kept = {name: os.environ[name] for name in ("PATH", "OMP_NUM_THREADS") if name in os.environ}
    (dependencies,) = site.getsitepackages()
    environment = kept | {"PYTHONPATH": dependencies, "HOME": str(tmp_path)}
    folder = tmp_path / "empty"
    folder.mkdir()

    def call(*arguments):
        return subprocess.run(
            [str(python.with_name("boltjoint")), *arguments],
            cwd=folder,
            env=environment,
            capture_output=True,
            text=True,
            check=False,
        )

    # the commands of the first screen, and what they show
    readme = (ROOT / "README.md").read_text(encoding="utf-8")
    pip, *commands = re.search(r"```sh\n(.*?)```", readme, re.DOTALL)[1].splitlines()
    assert pip.startswith("pip install")
    browser = tmp_path / "browser"
    browser.write_text(f'#!/bin/sh\necho "$1" > {tmp_path}/opened\n')
    browser.chmod(0o755)
    environment["BROWSER"] = f"{browser} %s"
    done = {}
    for program, command, *arguments in map(str.split, commands):
        assert program == "boltjoint"
        done[command] = call(command, *arguments)
        assert done[command].returncode == 0, done[command].stderr
    assert list(done) == ["new", "run", "open"]
    assert "wrote mine/config/cases/mine.yaml" in done["new"].stdout
    page = folder / "mine/results/report/overview.html"
    assert (tmp_path / "opened").read_text().strip() == page.as_uri()
    ran = done["run"]
    compare_answers(ran.stdout, re.search(r"```text\n(.*?)```", readme, re.DOTALL)[1])
    assert ran.stdout.rstrip().splitlines()[-1] == "Open mine/results/report/overview.html"
    said = (ran.stdout + ran.stderr).splitlines()
    assert len(said) < 40, "\n".join(said)
    again = call("run", "mine")
    assert "Nothing to be done" in again.stderr
    assert again.stdout == ran.stdout
    # the page is told as seen from where the user stands
    last = call("run", "../empty/mine").stdout.rstrip().splitlines()[-1]
    assert last == "Open ../empty/mine/results/report/overview.html"
    check_exports(folder / "mine", caplog)
    # what is exported of an edited study is told to be of before
    assert "edited since" not in call("export", "mine").stderr
    (folder / "mine/config/cases/mine.yaml").touch()
    assert "config was edited since the last run" in call("export", "mine").stderr


def compare_answers(said, shown):
    """Words are the same, and numbers but for rounding on other machines; bars move more."""
    said, shown = said.split(), shown.split()
    assert len(said) == len(shown)
    for place, (own, other) in enumerate(zip(said, shown, strict=True)):
        if own != other:
            is_bar = shown[place - 1] == "(±"
            assert float(own) == pytest.approx(float(other), rel=0.5 if is_bar else 0.01)


def copy_machine_code(package, environment):
    """Give an installed package what is compiled of this one: of its files and their dates."""
    (installed,) = environment.glob("venv/lib/python*/site-packages/boltjoint")
    for path in package.rglob("*.nb?"):
        to = installed / path.relative_to(package)
        to.parent.mkdir(exist_ok=True)
        shutil.copy(path, to)
    for path in package.rglob("*.py"):
        to = installed / path.relative_to(package)
        assert to.read_bytes() == path.read_bytes()
        shutil.copystat(path, to)


def check_exports(folder, caplog):
    """Files for other programs hold what the results do."""
    of_response = "mine_enriched-40_node-to-node_linear_resonance=1"
    path = "results/cases/mine/enriched-40/node-to-node/linear/resonance=1/response.nc"
    response = dataset.load(folder / path)
    to = folder / "export"
    written = export_responses(folder, to)
    assert {file.suffix for file in written} == {".csv"}
    table = pd.read_csv(to / f"{of_response}_response.csv")
    assert table["amplitude_m"].to_numpy() == pytest.approx(
        response["response_amplitude"].to_numpy(), rel=1e-9
    )
    peaks = pd.read_csv(to / f"{of_response}_peaks.csv")
    converged = response["peak_amplitude_converged"].to_numpy()
    assert peaks["peak_amplitude_converged_m"].to_numpy() == pytest.approx(converged)
    of_mode = path.replace("linear/resonance=1/response", "backbone/resonance=1/backbone")
    backbone = dataset.load(folder / of_mode)
    table = pd.read_csv(to / f"{of_response.replace('linear', 'backbone')}_backbone.csv")
    for column, name in (("damping_ratio",) * 2, ("amplitude_m", "response_amplitude")):
        assert table[column].to_numpy() == pytest.approx(backbone[name].to_numpy())
    export_responses(folder, to, "mat")
    arrays = loadmat(to / f"{of_response}.mat", simplify_cells=True)
    assert arrays["peaks"]["peak_amplitude_converged_m"] == pytest.approx(converged)
    assert arrays["response"]["frequency_Hz"] == pytest.approx(response["frequency"].to_numpy())
    export_responses(folder, to, "uff")
    sets = pyuff.UFF(str(to / f"{of_response}.uff")).read_sets()
    assert len(sets) == response.sizes["force"]
    mine = response["excitation_force"] == response["force_level"][0]
    over_force = response["response_amplitude"][mine] / response["force_level"][0]
    assert abs(sets[0]["data"]) == pytest.approx(over_force.to_numpy(), rel=1e-5)
    # abscissas have five decimals in the format
    assert sets[0]["x"] == pytest.approx(response["frequency"][mine].to_numpy(), rel=1e-5)
    # the displacement lags behind the force, by a quarter of a period at the peak
    assert (sets[0]["data"].imag < 0).all()
    peak = sets[0]["data"][abs(sets[0]["data"]).argmax()]
    assert abs(peak.real) < 0.1 * abs(peak)
    written = export_responses(folder, to, "pvd")
    assert len(written) == response.sizes["force"]
    assembly = dataset.load(folder / "results/assemblies/mine/assembly.nc")
    of_last = to / f"{of_response}_{float(response['force_level'][-1]):g}"
    motion = [meshio.read(of_last / f"{instant:03d}.vtu").point_data for instant in range(16)]
    output = [at["displacement"][int(assembly["response_node"]), 2] for at in motion]
    # the first harmonic of the output point
    amplitude = 2 * abs(np.fft.rfft(output)[1]) / 16
    assert amplitude == pytest.approx(float(response["peak_amplitude"][-1]), rel=1e-5)
    joint = dataset.load(folder / path.split("/linear")[0] / "joint.nc")
    place = joint["element_position"][0].to_numpy()
    (pair,) = np.flatnonzero(abs(assembly["position"] - place).max("axis") < 1e-9)
    node = int(assembly["pair_node"].sel(side="A")[pair])
    assert motion[0]["contact_state"][node] == int(response["contact_state"][-1, 0])
    # what a case names no more is left out, and told
    case = folder / "config/cases/mine.yaml"
    text, dates = case.read_text(), case.stat()
    case.write_text(text.replace("coordinates: [linear, backbone]", "coordinates: [backbone]"))
    assert all("_backbone_" in file.name for file in export_responses(folder, to))
    case.write_text(text)
    os.utime(case, ns=(dates.st_atime_ns, dates.st_mtime_ns))
    # what is not there is told
    aside = (folder / path).rename(folder / "response.nc")
    assert all("_backbone_" in file.name for file in export_responses(folder, to))
    assert f"{of_response} has no results yet: run the study" in caplog.text
    aside.rename(folder / path)
    # a case that is configured no more is not drawn, and says so
    case.rename(case.with_name("other.yaml"))
    with pytest.raises(ValueError, match="its configuration cannot be read"):
        export_responses(folder, to, "pvd")
    case.with_name("other.yaml").rename(case)
