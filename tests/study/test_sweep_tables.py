"""Statistics and Sobol indices of sweeps, against closed forms."""

import numpy as np
import pytest
import xarray as xr

from boltjoint.config.distributions import Linear
from boltjoint.config.sampling import Saltelli, exchanged
from boltjoint.study.designs import list_designs
from boltjoint.study.tables.sobol_indices import tabulate_sensitivity
from boltjoint.study.tables.sweeps import tabulate_extremes, tabulate_statistics

#: of the Ishigami function with a = 7 and b = 0.1
FIRST_ORDER, TOTAL = (0.3139, 0.4424, 0.0), (0.5576, 0.4424, 0.2437)


def ishigami(x):
    return np.sin(x[0]) + 7 * np.sin(x[1]) ** 2 + 0.1 * x[2] ** 4 * np.sin(x[0])


@pytest.fixture(scope="module")
def sweep():
    """A sweep of three keys, whose peaks are those of known functions."""
    from scipy.stats import qmc

    samples = 2048
    first, second = np.split(qmc.Sobol(6, rng=0).random(samples).T, 2)
    x = np.pi * (2 * exchanged(first, second) - 1)
    amplitude = np.column_stack([ishigami(x), 1e-3 * (3 * x[0] + x[2])])
    return xr.Dataset(
        {
            "peak_frequency": (("design", "force"), np.full_like(amplitude, 70.0)),
            "peak_amplitude": (("design", "force"), amplitude),
            "reason": ("design", np.full(len(amplitude), "")),
        },
        coords={
            **{f"x{place}": ("design", values, {"units": "1"}) for place, values in enumerate(x)},
            "force_level": ("force", [1.0, 10.0]),
        },
        attrs={"saltelli_samples": samples, "varied": "x0 x1 x2"},
    )


def test_indices_of_the_ishigami_function_lie_in_their_intervals(sweep):
    table = tabulate_sensitivity(sweep)
    found = table[(table["observed"] == "peak_mm") & (table["force_N"] == 1)].set_index("key")
    for order, exact in (("first_order", FIRST_ORDER), ("total", TOTAL)):
        for key, value in zip(("x0", "x1", "x2"), exact, strict=True):
            row = found.loc[key]
            assert row[f"{order}_low"] <= value <= row[f"{order}_high"], (order, key)
            assert row[order] == pytest.approx(value, abs=0.03)
            assert row[f"{order}_high"] - row[f"{order}_low"] < 0.13
    assert (found["samples"] == 2048).all()


def test_of_a_sum_the_keys_have_the_shares_of_their_variances(sweep):
    table = tabulate_sensitivity(sweep)
    found = table[(table["observed"] == "peak_mm") & (table["force_N"] == 10)]
    np.testing.assert_allclose(found["first_order"], [0.9, 0.0, 0.1], atol=0.02)
    np.testing.assert_allclose(found["total"], [0.9, 0.0, 0.1], atol=0.005)


def test_indices_are_those_of_scipy(sweep):
    from scipy.stats import sobol_indices

    amplitude = sweep["peak_amplitude"].to_numpy()[:, 0].reshape(5, 2048)
    given = {"f_A": amplitude[:1], "f_B": amplitude[1:2], "f_AB": amplitude[2:, None]}
    expected = sobol_indices(func=given, n=2048)
    table = tabulate_sensitivity(sweep)
    found = table[(table["observed"] == "peak_mm") & (table["force_N"] == 1)]
    np.testing.assert_allclose(found["first_order"], expected.first_order, rtol=1e-12, atol=1e-12)
    np.testing.assert_allclose(found["total"], expected.total_order, rtol=1e-12, atol=1e-12)


def test_all_variance_is_that_of_the_only_key():
    from scipy.stats import qmc

    first, second = np.split(qmc.Sobol(2, rng=0).random(64).T, 2)
    (x,) = exchanged(first, second)
    swept = xr.Dataset(
        {
            "peak_frequency": ("design", 70 - x),
            "peak_amplitude": ("design", np.exp(3 * x)),
            "reason": ("design", np.full(x.size, "")),
        },
        coords={"x": ("design", x, {"units": "1"})},
        attrs={"saltelli_samples": 64, "varied": "x"},
    )
    table = tabulate_sensitivity(swept)
    assert list(table["observed"]) == ["peak_frequency_Hz", "peak_mm"]
    for order in ("first_order", "total"):
        assert (table[[order, f"{order}_low", f"{order}_high"]] == 1).all(axis=None)
    # what does not vary has no shares, be it with one key or with many
    still = swept.assign(peak_amplitude=("design", np.ones(x.size)))
    assert np.isnan(tabulate_sensitivity(still).set_index("observed").loc["peak_mm", "total"])


def test_what_does_not_vary_has_no_indices(sweep):
    table = tabulate_sensitivity(sweep)
    assert table[table["observed"] == "peak_frequency_Hz"]["total"].isna().all()


def test_designs_without_a_peak_leave_the_indices(sweep):
    lost = sweep.copy(deep=True)
    lost["peak_amplitude"][{"design": 5}] = np.nan
    table = tabulate_sensitivity(lost)
    found = table[(table["observed"] == "peak_mm") & (table["force_N"] == 1)]
    assert (found["samples"] == 1024).all()
    np.testing.assert_allclose(found["total"], TOTAL, atol=0.05)


def test_only_a_saltelli_design_has_indices(sweep):
    with pytest.raises(ValueError, match="of the kind saltelli only"):
        tabulate_sensitivity(sweep.drop_attrs())


def test_statistics_are_those_of_the_two_samples(sweep):
    table = tabulate_statistics(sweep)
    row = table[(table["observed"] == "peak_mm") & (table["force_N"] == 10)].iloc[0]
    assert (row["designs"], row["with_peak"]) == (4096, 4096)
    assert row["mean"] == pytest.approx(0, abs=0.02)
    assert row["standard_deviation"] == pytest.approx(np.pi * np.sqrt(10 / 3), rel=0.01)
    assert row["p05"] == pytest.approx(-row["p95"], rel=0.02)


def drawn(kind, count=4096):
    """A sweep of two keys on 0 to 1 whose peaks are 70 + 4 x0 Hz and exp(3 x0 - x1) mm."""
    from scipy.stats import qmc

    draw = {"sobol": qmc.Sobol, "latin-hypercube": qmc.LatinHypercube}[kind]
    x = draw(2, rng=3).random(count).T
    return of_peaks("design", [("design", x[0]), ("design", x[1])], x)


def of_peaks(dims, keys, x):
    return xr.Dataset(
        {
            "peak_frequency": (dims, 70 + 4 * x[0]),
            "peak_amplitude": (dims, 1e-3 * np.exp(3 * x[0] - x[1])),
            "reason": (dims, np.full(x[0].shape, "")),
        },
        coords={f"x{place}": (*key, {"units": "1"}) for place, key in enumerate(keys)},
        attrs={"varied": "x0 x1"},
    )


def extremes_of(sweep, observed, key):
    table = tabulate_extremes(sweep)
    return table[(table["observed"] == observed) & (table["key"] == key)].iloc[0]


@pytest.mark.parametrize("kind", ["sobol", "latin-hypercube"])
def test_extremes_are_conditional_means(kind):
    sweep = drawn(kind)
    frequency = extremes_of(sweep, "peak_frequency_Hz", "x0")
    # of a uniform key the tenths have the means 0.05 and 0.95
    assert frequency["low_mean"] == pytest.approx(70.2, abs=0.01)
    assert frequency["high_mean"] == pytest.approx(73.8, abs=0.01)
    assert (frequency["low_bound"], frequency["high_bound"]) == pytest.approx((0.1, 0.9), abs=1e-3)
    assert frequency["low_designs"] == pytest.approx(410, abs=1)
    for key, of_key, of_other in (("x0", 3, -1), ("x1", -1, 3)):
        row = extremes_of(sweep, "peak_mm", key)
        for end, (a, b) in {"low": (0, 0.1), "high": (0.9, 1)}.items():
            exact = (np.exp(of_key * b) - np.exp(of_key * a)) / (of_key * 0.1)
            exact *= (np.exp(of_other) - 1) / of_other
            # random designs of this number would be off by more than twice in 20 000 cases
            assert abs(row[f"{end}_mean"] - exact) < 2 * row[f"{end}_half_width"]
    assert extremes_of(sweep, "peak_frequency_Hz", "x1")["low_half_width"] > 0


def test_extremes_of_a_grid_are_means_over_its_other_keys():
    sides = np.linspace(0, 1, 4), np.linspace(0, 1, 3)
    x = np.meshgrid(*sides, indexing="ij")
    grid = of_peaks(("x0", "x1"), [("x0", sides[0]), ("x1", sides[1])], x)
    row = extremes_of(grid, "peak_mm", "x1")
    np.testing.assert_allclose(row["low_mean"], np.exp(3 * sides[0]).mean())
    np.testing.assert_allclose(row["high_mean"], np.exp(3 * sides[0] - 1).mean())
    assert (row["low_designs"], row["high_designs"], row["low_half_width"]) == (4, 4, 0)
    assert extremes_of(grid, "peak_frequency_Hz", "x1")["low_mean"] == row_mean(grid)


def row_mean(grid):
    return pytest.approx(float(grid["peak_frequency"].mean()))


def test_keys_changed_one_at_a_time_have_their_extremes():
    x = np.full((2, 41), 0.5)
    x[0, 1], x[0, 2], x[1, 3], x[1, 4] = 0, 1, 0, 1
    row = extremes_of(
        of_peaks("design", [("design", x[0]), ("design", x[1])], x), "peak_frequency_Hz", "x0"
    )
    assert (row["low_mean"], row["high_mean"]) == pytest.approx((70, 74))
    assert (row["low_designs"], row["high_designs"]) == (1, 1)
    assert np.isnan(row["low_half_width"])


def test_extremes_count_designs_with_a_peak_of_the_two_samples_of_saltelli(sweep):
    whole = sweep.copy(deep=True)
    for name in ("x0", "x1", "x2"):
        whole[name].attrs["units"] = "1"
    whole["reason"] = ("design", np.full(whole.sizes["design"], ""))
    lost = int(whole["x0"].to_numpy()[:4096].argmin())
    whole["peak_amplitude"][{"design": lost, "force": 1}] = np.nan
    table = tabulate_extremes(whole).set_index(["observed", "force_N", "key"])
    assert table.loc[("peak_mm", 1, "x0"), "low_designs"] == 410
    assert table.loc[("peak_mm", 10, "x0"), "low_designs"] == 409
    # the mean of 3 x over the tenth next to pi
    assert table.loc[("peak_mm", 10, "x0"), "high_mean"] == pytest.approx(2.7 * np.pi, abs=0.05)


def test_designs_without_any_peak_have_no_part_in_the_ends():
    sides = np.linspace(0, 1, 4), np.linspace(0, 1, 3)
    x = np.meshgrid(*sides, indexing="ij")
    grid = of_peaks(("x0", "x1"), [("x0", sides[0]), ("x1", sides[1])], x)
    for name in ("peak_frequency", "peak_amplitude"):
        grid[name][{"x0": 0}] = np.nan
    row = extremes_of(grid, "peak_frequency_Hz", "x0")
    assert (row["low_bound"], row["low_designs"]) == (pytest.approx(1 / 3), 3)
    assert row["low_mean"] == pytest.approx(70 + 4 / 3)
    nothing = grid.assign(
        {name: grid[name] * np.nan for name in ("peak_frequency", "peak_amplitude")}
    )
    assert tabulate_extremes(nothing).empty


def test_what_has_one_value_only_has_no_extremes():
    x = np.ones((2, 3))
    table = tabulate_extremes(of_peaks("design", [("design", x[0]), ("design", x[1])], x))
    assert table.empty and "key" in table


def test_both_samples_and_every_exchange_are_designs():
    vary = {
        "preload_N": Linear(kind="linear", lowest=1e4, highest=2e4),
        "loss_factor": Linear(kind="linear", lowest=0.001, highest=0.002),
    }
    case = {
        "assembly": "bar",
        "preload_N": 1e4,
        "contact": {
            "law": "constant",
            "tangential_stiffness_N_per_m": 1e8,
            "friction_coefficient": 0.1,
        },
        "forces_N": (5.0,),
        "modes": ("free-3",),
        "coordinates": ("linear",),
        "solve": ({"resonance": 1, "joints": ("node-to-node",)},),
    }
    designs = list_designs(vary, Saltelli(kind="saltelli", number=8), case)
    preload, loss = (designs[name].to_numpy().reshape(4, 8) for name in ("preload", "loss_factor"))
    assert designs.attrs["saltelli_samples"] == 8
    # the first with the preload of the second, then with its loss factor
    np.testing.assert_array_equal(preload[2:], preload[[1, 0]])
    np.testing.assert_array_equal(loss[2:], loss[[0, 1]])
    assert not np.any(preload[0] == preload[1])
