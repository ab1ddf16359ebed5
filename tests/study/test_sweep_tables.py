"""Statistics and Sobol indices of sweeps, against closed forms."""

import numpy as np
import pytest
import xarray as xr

from boltjoint.config.design_columns import exchanged
from boltjoint.config.distributions import Linear
from boltjoint.config.sweep import Saltelli
from boltjoint.study.designs import list_designs
from boltjoint.study.tables.sweeps import tabulate_sensitivity, tabulate_statistics

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
        },
        coords={
            **{f"x{place}": ("design", values) for place, values in enumerate(x)},
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
