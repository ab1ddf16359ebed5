"""Peaks with all harmonics of many designs from those of some."""

import numpy as np
import pytest
import xarray as xr

from boltjoint.dataset import quantity
from boltjoint.study.regression_of_peaks import spread_designs, with_predicted_peaks

DESIGNS, SOLVED = 600, 120


def sweep_of(change, seed=0):
    """Designs of two levels whose peaks change by harmonics, some of which are solved."""
    random = np.random.default_rng(seed)
    friction, loss = random.lognormal(0, 0.4, DESIGNS), random.uniform(1, 4, DESIGNS)
    single = np.column_stack([5 / (loss + friction), 80 / (loss + friction**2)])
    frequency = 70 + np.column_stack([friction, 2 * friction])
    solved = np.zeros(DESIGNS, bool)
    solved[random.choice(DESIGNS, SOLVED, replace=False)] = True
    truth = {
        "amplitude": single * np.exp(change(np.log(friction), np.log(single))),
        "frequency": frequency * (1 + 1e-2 * np.column_stack([friction, loss])),
    }
    of_all = {"frequency": frequency, "amplitude": single}
    along = "design", "force"
    variables = {f"peak_{name}": (along, of_all[name]) for name in of_all}
    for name, values in truth.items():
        converged = np.where(solved[:, None], values, np.nan)
        variables[f"peak_{name}_converged"] = (along, converged)
        variables[f"harmonic_peak_{name}"] = ((*along, "harmonics"), converged[..., None])
    variables["peak_stress_over_strength"] = (along, single / 100)
    variables["is_predicted"] = ("design", (~solved).astype(np.int8))
    return xr.Dataset(variables), (friction, loss), solved, truth


def smooth(friction, single):
    return 0.3 * np.sin(2 * friction)[:, None] + 0.2 * np.tanh(single - 1)


def test_what_harmonics_change_is_predicted_within_its_error():
    sweep, values, solved, truth = sweep_of(smooth)
    found = with_predicted_peaks(sweep, values)
    for what, expected in truth.items():
        peak = found[f"peak_{what}_converged"].to_numpy()
        np.testing.assert_array_equal(peak[solved], expected[solved])
        error = abs(peak / expected - 1)[~solved]
        told = found[f"peak_{what}_regression_error"].to_numpy()
        assert np.all((error < told).mean(axis=0) > 0.9)
        # without regression they were off by half, and by some per cent
        assert np.all(told < (0.03 if what == "amplitude" else 1e-3))
    # shares of limits are those of these amplitudes
    share = found["peak_stress_over_strength"].to_numpy()[~solved]
    peak = found["peak_amplitude_converged"].to_numpy()[~solved]
    np.testing.assert_allclose(share, peak / 100)


def test_few_designs_with_most_harmonics_are_enough_beside_many_with_fewer():
    sweep, values, solved, truth = sweep_of(lambda friction, single: smooth(2.5 * friction, single))
    few = solved & (np.cumsum(solved) <= 30)
    ratio = {"amplitude": 1.02 + 0.01 * np.tanh(values[1] - 2), "frequency": 1 - 1e-4 * values[0]}
    last = {what: truth[what] * ratio[what][:, None] for what in truth}
    with_two = sweep.drop_dims("harmonics").assign(is_predicted=("design", 1 - few.astype(np.int8)))
    for what, expected in last.items():
        at_last = np.where(few[:, None], expected, np.nan)
        before = sweep[f"harmonic_peak_{what}"].to_numpy()
        both = np.concatenate([before, at_last[..., None]], axis=-1)
        with_two[f"peak_{what}_converged"][:] = at_last
        with_two[f"harmonic_peak_{what}"] = ("design", "force", "harmonics"), both
    found = with_predicted_peaks(with_two, values)
    alone = with_predicted_peaks(with_two.isel(harmonics=[1]), values)
    told = found["peak_amplitude_regression_error"].to_numpy()
    errors = [
        abs(one["peak_amplitude_converged"].to_numpy() / last["amplitude"] - 1)[~few]
        for one in (found, alone)
    ]
    assert np.all((errors[0] < told).mean(axis=0) > 0.9)
    # as few designs with one harmonic and with most tell less
    within, of_few = (np.quantile(error, 0.95, axis=0) for error in errors)
    assert np.all(within < of_few)


def test_an_error_that_no_variable_tells_is_told():
    random = np.random.default_rng(5)
    rough = lambda friction, single: 0.1 * random.standard_normal(single.shape)  # noqa: E731
    sweep, values, solved, truth = sweep_of(rough)
    found = with_predicted_peaks(sweep, values)
    error = abs(found["peak_amplitude_converged"].to_numpy() / truth["amplitude"] - 1)[~solved]
    within = (error < found["peak_amplitude_regression_error"].to_numpy()).mean(axis=0)
    assert np.all((within > 0.85) & (within < 0.995))


def test_peaks_that_are_not_there_are_not_predicted():
    sweep, values, solved, _ = sweep_of(smooth)
    without, lost = np.flatnonzero(~solved)[0], np.flatnonzero(solved)[0]
    for what in ("frequency", "amplitude"):
        sweep[f"peak_{what}"][without] = np.nan
        for name in (f"peak_{what}_converged", f"harmonic_peak_{what}"):
            sweep[name][lost] = np.nan
    found = with_predicted_peaks(sweep, values)["peak_amplitude_converged"]
    assert np.isnan(found[[without, lost]]).all()
    assert np.isnan(found).sum() == 4


def test_values_that_follow_from_others_and_rare_ones_are_no_variables():
    sweep, (friction, loss), solved, truth = sweep_of(smooth)
    rare = np.zeros(DESIGNS)
    rare[np.flatnonzero(solved)[:2]] = 1.0
    tied = friction, loss, 3 * friction, friction * loss, np.ones(DESIGNS), rare
    found = with_predicted_peaks(sweep, tied)
    error = abs(found["peak_amplitude_converged"].to_numpy() / truth["amplitude"] - 1)[~solved]
    told = found["peak_amplitude_regression_error"].to_numpy()
    assert np.all((error < told).mean(axis=0) > 0.9)
    assert np.all(told < 0.05)


def test_too_few_designs_predict_nothing(caplog):
    sweep, values, solved, _ = sweep_of(smooth)
    few = solved & (np.cumsum(solved) <= 10)
    sweep = sweep.assign(
        {
            name: sweep[name].where(xr.DataArray(few, dims="design"))
            for name in sweep
            if str(name).startswith("harmonic") or str(name).endswith("converged")
        }
    )
    found = with_predicted_peaks(sweep, values)
    assert np.isnan(found["peak_amplitude_regression_error"]).all()
    assert np.isfinite(found["peak_amplitude_converged"]).sum() == 20
    assert "level 2: 10 designs have a peak with more harmonics, too few" in caplog.text


@pytest.mark.parametrize(("number", "drawn"), [(None, 40), (100, 40), (20, 20)])
def test_designs_with_harmonics_are_spread_over_the_possible(number, drawn):
    reason = np.full(50, "", dtype=object)
    reason[::5] = "impossible"
    load = np.random.default_rng(1).permutation(np.linspace(1, 2, 50))
    preload = quantity("design", load, "N", "preload")
    designs = xr.Dataset({"reason": ("design", reason), "preload": preload})
    designs.attrs["varied"] = "preload"
    rows = spread_designs(designs, number)
    assert rows.sum() == drawn
    assert not rows[::5].any()
    # 20 at random leave gaps of 0.2
    assert np.diff(np.sort(load[rows]), prepend=1, append=2).max() < 0.12
    # the same each time: jobs of a sweep choose them on their own
    np.testing.assert_array_equal(rows, spread_designs(designs, number))
