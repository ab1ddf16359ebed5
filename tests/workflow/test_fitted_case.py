"""A joint that is fitted to its measurement, in the workflow and by the command."""

import re

import numpy as np
import pytest
from planned import planned
from small_study import CASE, CASES, run, write_config

from boltjoint import apply_preload, backbone_at, dataset, solve_branch
from boltjoint.calibration.response_points import solve_motions
from boltjoint.command.main import files_of_fit
from boltjoint.config import strict_yaml
from boltjoint.config.case import Case
from boltjoint.config.conflicts_of_measured import calibrated_content
from boltjoint.config.study import load_study
from boltjoint.dynamics.balance.harmonic_balance import HarmonicBalance
from boltjoint.joint.io import load_joint
from boltjoint.joint.node_to_node import connect_pairs
from boltjoint.structure.excitation import place_excitation
from boltjoint.structure.structure_file import load_structure
from boltjoint.study.calibrated_joint import CalibratedJoint

FOLDER = "results/cases/small/enriched-8/node-to-node"
FILE, BEYOND = "config/measured/tip.csv", "config/measured/beyond.csv"
MEASURED = {
    "basis": "enriched-8",
    "curves": [
        {
            "file": FILE,
            "resonance": 1,
            "frequency_error_percent": 0.02,
            "damping_error_percent": 1,
        }
    ],
    "parameters": {
        "contact.tangential_stiffness_N_per_m": {"low": 1e7, "high": 1e10},
        "contact.friction_coefficient": {"low": 0.02, "high": 1},
        "loss_factor": {"low": 5e-4, "high": 0.05},
    },
    "predicted": [
        {
            "file": BEYOND,
            "name": "beyond",
            "resonance": 1,
            "frequency_error_percent": 0.02,
            "damping_error_percent": 1,
        }
    ],
    "starts": 2,
}
#: in place of 1e9 N/m, 0.1 and 0.005
TRUTH = {
    "contact.tangential_stiffness_N_per_m": 3e8,
    "contact.friction_coefficient": 0.25,
    "loss_factor": 0.003,
}


def simulate(folder):
    """A measured backbone of the joint with other parameters, with 1 % noise."""
    case = Case.model_validate(CASE | {"measured": MEASURED})
    model = CalibratedJoint(load_joint(folder / FOLDER / "joint.nc"), calibrated_content(case))
    joint, damping = model(TRUTH)
    amplitudes = np.geomspace(1e-6, 6e-4, 30)
    curves = backbone_at(joint, amplitudes, resonance=1, damping=damping)
    noise = np.random.default_rng(1).standard_normal((2, 30)) * [[2e-4], [0.01]]
    f, z = np.array(curves) * (1 + noise)
    rows = [f"{1e3 * a},{x},{y}" for a, x, y in zip(amplitudes, f, z, strict=True)]
    (folder / FILE).parent.mkdir(exist_ok=True)
    head = "displacement_mm,frequency_Hz,damping_ratio"
    for file, own in ((FILE, rows[:25]), (BEYOND, rows[25:])):
        (folder / file).write_text("\n".join([head, *own]) + "\n", encoding="utf-8")


def test_a_measurement_gives_back_the_parameters_of_its_joint(copied):
    simulate(copied)
    write_config(copied, CASES | {"small": CASE | {"measured": MEASURED}})
    files = files_of_fit(copied, "small")
    other = copied / "config/other.yaml"
    other.write_text("cases: [variable]\n", encoding="utf-8")
    with pytest.raises(ValueError, match="variable"):
        files_of_fit(copied, "small", "config/other.yaml")
    other.unlink()
    assert all("calibration/" in each or "small_enriched-8_node-to-node" in each for each in files)
    page, overview = "results/report/small.html", "results/report/overview.html"
    new = set(planned(copied))
    # nothing that was solved before depends on it
    assert {each for each in new if not each.startswith("results/report/")} == set(files)
    said = run(copied, *files, page, overview)
    calibration = dataset.load(copied / FOLDER / "calibration/calibration.nc")
    for name, value in TRUTH.items():
        found = calibration.sel(parameter=name)
        assert found["interval_low"] < value < found["interval_high"]
    prediction = dataset.load(copied / FOLDER / "calibration/prediction.nc")
    # two parameters go together beyond the amplitudes that were fitted
    assert (prediction["points_within"] >= 4).all()
    answer = f"{calibration.attrs['answer']} {prediction.attrs['answer']}"
    assert f"small: {answer}" in said
    for path in (page, overview):
        text = (copied / path).read_text(encoding="utf-8")
        lead = text[text.index("<h1") : text.index("<h2")]
        words = " ".join(re.sub("<[^>]+>", " ", lead).split())
        unfitted = "All that follows has the values of the case, not the fitted ones. With the"
        assert f"{answer} {unfitted}" in words
    text = (copied / page).read_text(encoding="utf-8")
    first, rest = re.findall("<p>(.*?)</p>", text[text.index("<h1") :], re.DOTALL)[:2]
    assert first.startswith("<strong>Fitted to ") and "<strong>" not in rest
    assert 'id="measured"' in text
    assert "calibration/fitted.yaml" in text
    # the fitted case is one of a study
    fitted = (copied / FOLDER / "calibration/fitted.yaml").read_text(encoding="utf-8")
    (copied / "config/cases/small.yaml").write_text(fitted, encoding="utf-8")
    contact = load_study(copied).case("small").contact
    assert 0.24 < contact.friction_coefficient < 0.26
    # what is held aside changes nothing of the fit
    other = MEASURED | {"predicted": [MEASURED["predicted"][0] | {"damping_error_percent": 2}]}
    write_config(copied, CASES | {"small": CASE | {"measured": other}})
    again = {each for each in planned(copied) if "calibration/" in each}
    assert again == {f"{FOLDER}/calibration/prediction.nc"}
    # another content of the file, whatever its date
    write_config(copied, CASES | {"small": CASE | {"measured": MEASURED}})
    lines = (copied / FILE).read_text(encoding="utf-8").splitlines()
    (copied / FILE).write_text("\n".join(lines[:-1]) + "\n", encoding="utf-8")
    assert set(files) <= set(planned(copied))


SINE = "config/measured/sine.csv"
#: in place of 1 and 1
RATIOS = {"preload_ratios[0]": 0.4, "preload_ratios[1]": 1.05}
OF_BOLTS = {
    "basis": "enriched-8",
    "curves": [MEASURED["curves"][0]],
    "responses": [
        {"file": SINE, "name": "sine", "excitation_error_percent": 1, "phase_error_deg": 1}
    ],
    "parameters": {
        **{key: {"low": 0.1, "high": 1.2, "log": False} for key in RATIOS},
        "loss_factor": MEASURED["parameters"]["loss_factor"],
    },
    "starts": 1,
}


def loosened(folder):
    """The joint of a loose bolt, whose contact is solved anew."""
    at = folder / "results/assemblies/two_bolt"
    case = Case.model_validate(CASE)
    ratios = np.array(list(RATIOS.values()))
    contact = apply_preload(load_structure(at / "structure.nc"), case.preload_N * ratios)
    assembly, modes = dataset.load(at / "assembly.nc"), dataset.load(at / "enriched-8/modes.nc")
    excited = place_excitation(assembly, modes, case.excitation, (*case.sensors, *case.outputs))
    return connect_pairs(excited, contact, **case.contact.options)


def test_a_loose_bolt_is_found_by_a_backbone_and_a_stepped_sine(copied):
    joint, damping = loosened(copied), 0.003
    random = np.random.default_rng(4)
    amplitudes = np.geomspace(1e-6, 6e-4, 25)
    curves = np.array(backbone_at(joint, amplitudes, resonance=1, damping=damping))
    f, z = curves * (1 + random.standard_normal(curves.shape) * [[2e-4], [0.01]])
    branch = solve_branch(joint, 20.0, damping=damping)
    every = slice(None, None, max(1, branch.frequency.size // 30))
    frequency, amplitude = branch.frequency[every], branch.amplitude[every]
    solved = solve_motions(
        HarmonicBalance(joint, damping, 1.0),
        joint.response_mode,
        "displacement",
        frequency,
        amplitude,
    )
    phase = np.rad2deg(solved.values[:, 1]) + random.standard_normal(frequency.size)
    force = 20 * (1 + 0.01 * random.standard_normal(frequency.size))
    (copied / FILE).parent.mkdir(exist_ok=True)
    for file, head, columns in (
        (FILE, "displacement_mm,frequency_Hz,damping_ratio", (1e3 * amplitudes, f, z)),
        (
            SINE,
            "frequency_Hz,displacement_mm,force_N,phase_deg",
            (frequency, 1e3 * amplitude, force, phase),
        ),
    ):
        rows = [",".join(map(str, row)) for row in zip(*columns, strict=True)]
        (copied / file).write_text("\n".join([head, *rows]) + "\n", encoding="utf-8")
    write_config(copied, CASES | {"small": CASE | {"measured": OF_BOLTS}})
    files = files_of_fit(copied, "small")
    run(copied, *files)
    calibration = dataset.load(copied / FOLDER / "calibration/calibration.nc")
    assert calibration.attrs["refusals"] == ""
    for name, value in RATIOS.items():
        found = calibration.sel(parameter=name)
        error = float(found["interval_high"] - found["interval_low"]) / 4
        assert float(found["value"]) == pytest.approx(value, abs=3 * error)
    assert calibration["loosest_probability"].sel(parameter="preload_ratios[0]") > 0.99
    said = "Of the fitted preloads preload_ratios[0] is the lowest, by 100 % probability."
    assert said in calibration.attrs["answer"]
    fitted = (copied / FOLDER / "calibration/fitted.yaml").read_text(encoding="utf-8")
    ratios = strict_yaml.parse_mapping(fitted)["preload_ratios"]
    assert ratios == pytest.approx(list(RATIOS.values()), rel=0.2)
