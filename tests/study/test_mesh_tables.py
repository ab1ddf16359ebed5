"""Tables of mesh studies, against orders of convergence that are known."""

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
import xarray as xr
from small_joint import connect_small

from boltjoint.joint.io import joint_to_dataset
from boltjoint.study.tables.meshes import (
    Mesh,
    observed_order,
    tabulate_convergence,
    tabulate_meshes,
)

SIZE = np.array([3e-3, 2e-3, 1.5e-3])
KEYS = {"tangential_stiffness_per_area": 6.8e13, "friction_coefficient": 0.1}


@pytest.mark.parametrize("order", [0.3, 1.0, 2.0, 3.7])
@pytest.mark.parametrize("constant", [-2.0, 0.5])
def test_the_order_of_a_power_of_the_size_is_found(order, constant):
    value = 70 + constant * (SIZE / SIZE[0]) ** order
    assert observed_order(SIZE, value) == pytest.approx(order, rel=1e-9)
    # whatever the units
    assert observed_order(1e3 * SIZE, value - 70) == pytest.approx(order, rel=1e-9)


@pytest.mark.parametrize(
    "value",
    [
        [1.0, 2.0, 1.5],
        [1.0, 1.0, 1.0],
        [1.0, 2.0, 4.0],
        [1.0, 2.0, np.nan],
        # a divergent power
        SIZE**-2.0,
        # as the logarithm of the size, of order 0
        np.log(SIZE),
    ],
)
def test_what_does_not_converge_has_no_order(value):
    assert np.isnan(observed_order(SIZE, np.array(value)))


def sweep_of(order):
    """Peaks and backbones that converge with this order, of designs in any order."""
    size = np.append(SIZE[::-1], 5e-3)
    error = 0.1 * (size / SIZE[0]) ** order
    force, amplitude = np.array([1.0, 10.0]), np.geomspace(1e-6, 1e-3, 4)
    by_force = np.outer(1 + error, force)
    return size, xr.Dataset(
        {
            "peak_frequency": (("design", "force"), 70 + by_force),
            "peak_amplitude": (("design", "force"), 1e-3 * by_force),
            "natural_frequency": (("design", "amplitude"), np.outer(1 + error, 70 + amplitude)),
            "damping_ratio": (("design", "amplitude"), np.outer(1 + error, amplitude)),
            "reason": ("design", np.full(len(size), "")),
        },
        {"force_level": ("force", force), "amplitude": amplitude},
    )


def test_peaks_and_backbones_are_compared_in_the_three_finest_meshes():
    size, sweep = sweep_of(2.0)
    table = tabulate_convergence(sweep, size, amplitudes=3)
    counts = {"peak_frequency_Hz": 2, "peak_mm": 2, "natural_frequency_Hz": 3, "damping_ratio": 3}
    assert table["observed"].value_counts().to_dict() == counts
    np.testing.assert_allclose(table["order"], 2.0, rtol=1e-6)
    peak = table[(table["observed"] == "peak_mm") & (table["force_N"] == 10)].iloc[0]
    coarse, medium, fine = 10 * (1 + 0.1 * (SIZE / SIZE[0]) ** 2)
    np.testing.assert_allclose(
        [peak["coarse"], peak["medium"], peak["fine"], peak["extrapolated"]],
        [coarse, medium, fine, 10],
    )
    assert peak["change_to_medium_percent"] == pytest.approx(100 * (medium / coarse - 1))
    assert peak["change_to_fine_percent"] == pytest.approx(100 * (fine / medium - 1))
    assert peak["error_of_fine_percent"] == pytest.approx(100 * (fine / 10 - 1))
    of_backbone = table[table["observed"] == "damping_ratio"]
    np.testing.assert_allclose(of_backbone["amplitude_mm"], [1e-3, 0.1, 1])
    assert of_backbone["force_N"].isna().all()


def test_the_designs_may_be_those_of_a_grid():
    size, sweep = sweep_of(2.0)
    grid = sweep.assign_coords(layers=("design", [1, 1, 2, 2]), rings=("design", [3, 4, 3, 4]))
    grid = grid.set_index(design=["layers", "rings"]).unstack("design")  # noqa: PD010 - no table
    table, expected = (tabulate_convergence(each, size) for each in (grid, sweep))
    pd.testing.assert_frame_equal(table, expected)


def test_an_impossible_design_is_no_mesh():
    size, sweep = sweep_of(1.0)
    lost = np.where(size == SIZE[2], np.nan, size)
    table = tabulate_convergence(sweep, lost)
    fine = table[table["observed"] == "peak_frequency_Hz"]["fine"]
    np.testing.assert_array_equal(fine, sweep["peak_frequency"][1])
    np.testing.assert_allclose(table["order"], 1.0, rtol=1e-6)
    with pytest.raises(ValueError, match="from three meshes"):
        tabulate_convergence(sweep, np.where(size < 2.5e-3, np.nan, size))


def blocks(count):
    """Bricks of 3, 2 and 1 mm in a row, as many of them shorter ones, as of an assembly."""
    x, y, z = np.linspace(0, 3e-3, count + 1), [0, 2e-3], [0, 1e-3]
    corner = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]])
    corner = np.vstack([corner, corner + np.array([0, 0, 1])])
    coordinate = np.array([[i, j, k] for k in z for j in y for i in x])
    first = np.arange(count)[:, None]
    nodes = corner @ [1, count + 1, 2 * (count + 1)]
    return xr.Dataset(
        {
            "coordinate": (("node", "axis"), coordinate),
            "connectivity": (("element", "corner"), first + nodes),
        }
    )


def mesh(law, keys, parts):
    """The small joint with each pair in equal parts, as in a finer mesh."""
    joint, preload = connect_small(law, keys)
    share = np.repeat(1 / parts, parts * preload.sizes["pair"])
    finer = preload.isel(pair=np.repeat(np.arange(preload.sizes["pair"]), parts))
    for name in ("normal_load", "area"):
        finer[name] = finer[name] * share
    elements = joint.law
    on_area = "tangential_stiffness_per_area" in keys
    quantities = {
        name: np.repeat(getattr(elements, name), parts)
        / (parts if name == "slip_force" or on_area else 1)
        for name in elements.quantities
    }
    on = np.repeat(elements.point_of_element, parts)
    divided = replace(
        joint,
        law=replace(elements, point_of_element=on, **quantities),
        element_position=np.repeat(joint.element_position, parts, axis=0),
    )
    return Mesh(blocks(parts), finer, joint_to_dataset(divided))


def test_the_slip_displacement_is_that_of_every_mesh_with_a_stiffness_per_area():
    table = tabulate_meshes([mesh("constant", KEYS, parts) for parts in (4, 1)])
    assert table["pairs"][1] == 4 * table["pairs"][0]
    assert table["elements"].tolist() == [1, 4]
    np.testing.assert_allclose(table["element_size_mm"], np.cbrt([6, 6 / 4]))
    np.testing.assert_allclose(table["stiffness_N_per_mm3"], 6.8e4, rtol=1e-12)
    for column in ("loaded_area_mm2", "stiffness_kN_per_mm", "slip_displacement_um"):
        np.testing.assert_allclose(table[column][0], table[column][1], rtol=1e-12)
    preload = mesh("constant", KEYS, 1).preload
    pressure = preload["normal_load"].sum() / preload["area"][preload["normal_load"] > 0].sum()
    slip = 1e6 * 0.1 * pressure.item() / 6.8e13
    np.testing.assert_allclose(table["slip_displacement_um"], slip, rtol=1e-12)


def test_with_a_stiffness_of_each_pair_it_goes_to_zero_with_the_elements():
    keys = {"tangential_stiffness": 1e8, "friction_coefficient": 0.1}
    table = tabulate_meshes([mesh("constant", keys, parts) for parts in (1, 4)])
    slip = table["slip_displacement_um"]
    np.testing.assert_allclose(slip[1], slip[0] / 4, rtol=1e-12)
    np.testing.assert_allclose(
        table["stiffness_N_per_mm3"][1], 4 * table["stiffness_N_per_mm3"][0], rtol=1e-12
    )
