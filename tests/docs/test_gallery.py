"""Each example of the gallery runs, draws a picture and prints a number, which is held here."""

import ast
import runpy
import sys
import time
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
import pytest
from second_way import OneHarmonic, force_at_peaks, total_indices

from boltjoint import solve_response

FOLDER = Path(__file__).parents[2] / "docs/gallery"
EXAMPLES = sorted(path.stem for path in FOLDER.glob("[0-9]*.py"))
#: processor time of those that ran here [s]
SPENT = {}


def assert_peaks_of_one_harmonic(joint, response, loss_factor):
    """Peaks are those of equations in which nothing is the library's."""
    one = OneHarmonic(joint, loss_factor)
    for place in range(response.sizes["force"]):
        one.check_peak(response, place)


def response(names):
    L = np.diag((2 * np.pi * np.array([70.0, 360.0])) ** 2)
    rows = names["relative_mode"]
    stuck = np.sqrt(np.linalg.eigvalsh(L + 5e6 * rows.T @ rows)[0]) / (2 * np.pi)
    peak = names["peak"]
    # the first pair begins to slip; at 10 N all slip
    assert peak[0.01] == pytest.approx(stuck, rel=2e-3)
    assert peak[10.0] == pytest.approx(70.0, rel=1e-4)
    assert peak[0.01] > peak[1.0] > peak[3.0] > peak[10.0]


def backbone(names):
    # in one mode of two, near the resonance
    assert names["difference"].max() < 1e-4
    assert names["damping"].max() == pytest.approx(7.7, abs=0.05)
    on_it = np.interp(
        np.log(1e3 * names["response"]["peak_amplitude"]),
        np.log(names["amplitude"]),
        names["backbone"]["natural_frequency"],
    )
    np.testing.assert_allclose(names["response"]["peak_frequency"], on_it, rtol=5e-3)


def preload(names):
    low, middle, high = names["peaks"].values()
    assert 100 < low < middle < high < 180
    assert (low, middle, high) == pytest.approx((151.5, 159.1, 162.3), abs=0.1)
    # the last once more, by equations that the library has no part in
    assert_peaks_of_one_harmonic(names["joint"], names["response"], 0.001)


def friction_law(names):
    # forty sliders stand for infinitely many
    own, iwan = names["peak"].values()
    assert own == pytest.approx(iwan, rel=1e-3)


def damping(names):
    # all sticks: the structure alone dissipates, in proportion to a power of the frequency
    peak, ratio = names["peak"], names["stuck"] / 70.0
    assert peak["fractional"] * ratio**0.5 == pytest.approx(peak["loss factor"], rel=5e-3)
    assert peak["viscous"] * ratio == pytest.approx(peak["loss factor"], rel=5e-3)


def matrices(names):
    # equilibrium of the bars across the lap
    assert names["preload"]["normal_load"].sum().item() == pytest.approx(10e3, rel=1e-9)
    peaks = names["response"]["peak_frequency"].to_numpy()
    low, high = names["joint"].resonance_range()[0]
    assert low < peaks[2] < peaks[1] < peaks[0] <= high * 1.0001


def deck(names):
    assert names["structure"].dofs == 1840
    assert names["preload"]["normal_load"].sum().item() == pytest.approx(8e3, rel=1e-9)
    small, large = names["response"]["peak_frequency"].to_numpy()
    assert large < small < names["joint"].resonance_range()[0, 1]


def faces(names):
    assert names["points"].area.sum() == pytest.approx(0.05 * 0.03, rel=1e-12)
    lower, upper = names["resultants"]
    np.testing.assert_allclose(lower, [0, 0, 1500], atol=1e-9)
    np.testing.assert_allclose(upper, [0, 0, -1500], atol=1e-9)


def flange(names):
    totals = [names[each]["normal_load"].sum().item() for each in ("tight", "loose")]
    assert totals == pytest.approx([40e3, 35e3], rel=1e-9)
    # of the last, with one loose bolt
    small, large = names["response"]["peak_frequency"].to_numpy()
    low, high = names["joint"].resonance_range()[0]
    assert low < large < small < high
    assert small == pytest.approx(2393.5, rel=1e-3)
    assert_peaks_of_one_harmonic(names["joint"], names["response"], 0.01)


def reduction(names):
    largest = {name: abs(values).max() for name, values in names["error"].items()}
    assert largest["weighted pairs"] < 1
    assert largest["4 clusters"] < largest["4 bands"]
    assert largest["4 clusters, 4 elements"] == pytest.approx(largest["4 clusters"], rel=0.05)
    assert len(names["joints"]["weighted pairs"].law.slip_force) < 60


def harmonics(names):
    error = 100 * (names["one"] / names["last"] - 1).to_numpy()
    assert names["peaks"]["peak_harmonics"].to_numpy().min() >= 17
    assert error[1] == pytest.approx(-27.4, abs=0.5)
    # one harmonic once more, by equations that the library has no part in
    response = solve_response(names["joint"], names["forces"], damping=0.001)
    assert_peaks_of_one_harmonic(names["joint"], response, 0.001)
    np.testing.assert_allclose(response["peak_amplitude"], names["one"], rtol=1e-4)


def sweep(names):
    friction, stiffness, loss_factor = names["indices"].total_order
    assert (friction, stiffness) == pytest.approx((0.25, 0.76), abs=0.02)
    assert loss_factor < 0.02
    # by quadrature, which has converged to 0.01; the rest is the scatter of 64 samples
    exact = total_indices(names["peaks"], names["distributions"], 5)
    np.testing.assert_allclose(names["indices"].total_order, exact, atol=0.03)


def loosened_bolt(names):
    # of the last, with one loose bolt
    small, large = names["peaks"].to_numpy()
    assert (small, large) == pytest.approx((141.7, 132.5), abs=0.1)
    response = solve_response(names["joint"], [1.0, 20.0], damping=0.001)
    assert_peaks_of_one_harmonic(names["joint"], response, 0.001)


def which_bolt(names):
    found = names["found"]
    assert np.all(abs(found.scaled - names["truth"]) < 3 * found.standard_error)
    assert found.scaled[1] == pytest.approx(0.4, abs=0.03)
    assert names["probability"]["preload_ratios[1]"] > 0.999


def calibration(names):
    ((of_frequency, of_damping),) = names["calibration"].rms_errors
    assert of_frequency < 2e-4
    assert of_damping < 0.05


def ring_down(names):
    mode, known = names["mode"], np.log(names["amplitude"])
    for values, name, most in (
        (mode.frequency, "natural_frequency", 1e-3),
        (mode.damping_ratio, "damping_ratio", 0.06),
    ):
        expected = np.interp(np.log(mode.amplitude), known, names["backbone"][name])
        assert np.median(abs(values / expected - 1)) < most


def stability(names):
    folds = names["response"]["fold_frequency"].to_numpy()
    assert folds == pytest.approx([55.51, 50.87], abs=0.01)
    # between the turning points, of the motion with more harmonics, which lie apart
    unstable = names["frequency"][np.isfinite(names["unstable"])]
    assert unstable.size > 10
    assert folds[1] - 1 < unstable.min() < unstable.max() < folds[0] + 1


def isola(names):
    assert 14.1 < names["low"] < 14.3 < names["high"] < 14.5
    assert names["peak"] == pytest.approx(0.340, abs=1e-3)
    assert names["peak"] < names["appears"] == pytest.approx(0.603, abs=1e-3)
    # the same from samples of the hysteresis, at each state of the backbone
    shown, expected = names["amplitude"].to_numpy(), names["force"].to_numpy()
    states = (shown > 0.15) & (shown < 1.5)
    force = force_at_peaks(1e-3 * shown[states] / 1.5, names["joint"], 0.001)
    np.testing.assert_allclose(force, expected[states], rtol=2e-3)
    # and between them, where the range of an isolated branch ends at extremes of the force
    amplitude = np.geomspace(0.15, 1.5, 40)
    force = force_at_peaks(1e-3 * amplitude / 1.5, names["joint"], 0.001)
    highest, lowest = np.flatnonzero(np.diff(np.sign(np.diff(force)))) + 1
    assert force[lowest] == pytest.approx(names["low"], rel=2e-3)
    assert force[highest] == pytest.approx(names["high"], rel=2e-3)
    rising = slice(0, highest + 1)
    peak = np.interp(14.3, force[rising], amplitude[rising])
    assert peak == pytest.approx(names["peak"], rel=5e-3)


def clusters(names):
    bands, of_motion = np.abs(list(names["error"].values()))
    assert np.all(of_motion <= bands)
    assert np.all(np.diff(of_motion) < 0)
    assert of_motion[-1] < 0.5


@pytest.mark.parametrize("example", EXAMPLES)
def test_an_example_draws_a_picture_and_prints_its_number(example, capsys, monkeypatch):
    plt.switch_backend("agg")
    plt.close("all")
    monkeypatch.chdir(FOLDER)
    begun = time.process_time()
    names = runpy.run_path(str(FOLDER / f"{example}.py"))
    SPENT[example] = time.process_time() - begun
    assert plt.get_fignums()
    assert all(figure.axes for figure in map(plt.figure, plt.get_fignums()))
    plt.close("all")
    assert any(letter.isdigit() for letter in capsys.readouterr().out)
    globals()[example.split("_", 1)[1]](names)


@pytest.mark.parametrize("example", EXAMPLES)
def test_an_example_uses_the_library_and_its_dependencies_alone(example):
    tree = ast.parse((FOLDER / f"{example}.py").read_text(encoding="utf-8"))
    modules = [
        name
        for node in ast.walk(tree)
        if isinstance(node, ast.Import | ast.ImportFrom)
        for name in (
            [node.module] if isinstance(node, ast.ImportFrom) else [a.name for a in node.names]
        )
    ]
    known = {"boltjoint", "matplotlib", "numpy", "scipy", *sys.stdlib_module_names}
    assert {name.split(".")[0] for name in modules} <= known
    assert not [name for name in modules if any(part.startswith("_") for part in name.split("."))]


def test_the_gallery_is_quick():
    # all of it where the tests run in one process; without compiled loops, which are kept
    assert len(EXAMPLES) >= 15
    assert sum(SPENT.values()) < 300
