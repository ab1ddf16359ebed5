"""Joints in files."""

from dataclasses import fields

import numpy as np
import pytest
import xarray as xr

from boltjoint import dataset
from boltjoint.dynamics.response.windows import frequency_window
from boltjoint.joint.derived import merge_points
from boltjoint.joint.io import (
    ImpossibleJoint,
    basis_errors_and_limits,
    free_mode_quantities,
    joint_from_dataset,
    joint_to_dataset,
    load_joint,
    model_errors,
    save_joint,
)
from boltjoint.structure.model_limits import LIMITS


def test_joint_survives_its_file(either, tmp_path):
    dataset.save(joint_to_dataset(either), tmp_path / "joint.nc")
    again = load_joint(tmp_path / "joint.nc")
    assert type(again.law) is type(either.law)
    for one, other in ((again, either), (again.law, either.law)):
        for name in (field.name for field in fields(other)):
            if name != "law":
                np.testing.assert_array_equal(getattr(one, name), getattr(other, name))


def test_a_joint_of_sweeps_that_is_impossible_has_its_reason_in_its_file(either, tmp_path):
    def regions():
        raise ValueError("72 places do not divide into 77 regions")

    with pytest.raises(ValueError, match="72 places"):
        save_joint(regions, tmp_path / "joint.nc", {})
    assert not (tmp_path / "joint.nc").exists()
    save_joint(regions, tmp_path / "joint.nc", {}, of_sweep=True)
    with pytest.raises(ImpossibleJoint, match=r"^72 places do not divide into 77 regions$"):
        load_joint(tmp_path / "joint.nc")

    # what would be reduced from it is impossible for the same reason
    def elements():
        return joint_to_dataset(load_joint(tmp_path / "joint.nc"))

    save_joint(elements, tmp_path / "reduced.nc", {}, of_sweep=True)
    with pytest.raises(ImpossibleJoint, match=r"^72 places do not divide into 77 regions$"):
        load_joint(tmp_path / "reduced.nc")
    save_joint(lambda: joint_to_dataset(either), tmp_path / "joint.nc", {}, of_sweep=True)
    assert load_joint(tmp_path / "joint.nc").points == either.points


def test_axes_of_a_joint_file_may_be_in_any_order(either):
    stored = joint_to_dataset(either)
    again = joint_from_dataset(stored.transpose(*sorted(stored.dims)))
    for one, other in zip(again.rows, either.rows, strict=True):
        np.testing.assert_array_equal(one, other)
    np.testing.assert_array_equal(again.position, either.position)


def test_every_quantity_of_a_joint_file_has_a_unit_and_a_meaning(either):
    stored = joint_to_dataset(either)
    assert set(either.law.quantities) < set(stored)
    for name in stored.data_vars:
        assert {"units", "long_name"} <= set(stored[name].attrs), name


def test_unknown_law_is_refused(joint):
    with pytest.raises(ValueError, match="'magic' is not known; allowed: constant, variable"):
        joint_from_dataset(joint_to_dataset(joint).assign_attrs(law="magic"))


def test_the_range_of_resonances_is_that_of_the_joint_and_of_what_it_was_reduced_from(either):
    stored = joint_to_dataset(either)
    window = frequency_window(either, resonance=2)
    lowest, highest = stored["resonance_range"].to_numpy()[1]
    assert (0.85 * lowest, 1.05 * highest) == window
    regions = merge_points(either, np.arange(either.points) // 20)
    reduced = joint_to_dataset(regions, stored)
    np.testing.assert_allclose(
        [0.85, 1.05] * reduced["resonance_range"].to_numpy()[1],
        frequency_window(either, regions, resonance=2),
        rtol=1e-15,
    )
    # the mean of a region moves less than its points: the range of the regions alone is smaller
    alone = joint_to_dataset(regions)["resonance_range"].to_numpy()
    assert alone[0, 1] < reduced["resonance_range"].to_numpy()[0, 1]


def test_participation_has_the_unit_of_its_vectors():
    of_pod_modes = free_mode_quantities([50.0], np.ones((1, 2)), of="pod_mode", unit="s")
    assert of_pod_modes["free_participation"].attrs["units"] == "s"
    assert of_pod_modes["free_participation"].dims == ("free_mode", "pod_mode")
    assert free_mode_quantities([50.0], [[1.0]])["free_participation"].attrs["units"] == "1"


def test_the_error_of_the_basis_is_kept_by_what_is_reduced(either):
    modes = xr.Dataset(attrs={"estimated_frequency_error": 1e-3, "estimated_amplitude_error": 0.02})
    stored = joint_to_dataset(either).assign(basis_errors_and_limits(modes))
    regions = merge_points(either, np.arange(either.points) // 30)
    reduced = joint_to_dataset(regions, stored)
    for each in (stored, reduced):
        errors = model_errors(each)
        assert errors["basis_frequency_error"] == 1e-3
        assert errors["basis_amplitude_error"] == 0.02
        assert errors["weights_amplitude_error"] == 0
    limits = xr.Dataset(
        {limit.limit: 1.0 for limit in LIMITS}
        | {limit.modes: (("place", "component", "mode"), np.ones((1, 2, 3))) for limit in LIMITS}
    )
    of_modes = basis_errors_and_limits(limits)
    assert set(of_modes) == set(limits)
    assert set(limits) <= set(joint_to_dataset(regions, stored.assign(of_modes)))
    # of weights there is an estimate, or it is not known
    weighted = stored.assign(weight=("point", np.ones(either.points)))
    assert np.isnan(model_errors(weighted)["weights_amplitude_error"])
    estimated = weighted.assign(estimated_amplitude_error=0.007)
    assert model_errors(estimated)["weights_amplitude_error"] == 0.007
    # nothing is estimated of a basis without contact
    assert not basis_errors_and_limits(xr.Dataset())
    assert np.isnan(model_errors(joint_to_dataset(either))["basis_amplitude_error"])
