from dataclasses import replace

import numpy as np
import pytest
from figure_parts import curves, legend_texts
from small_joint import make_joint, make_preload

from boltjoint.joint.derived import merge_points
from boltjoint.joint.hysteresis import loading_curve
from boltjoint.joint.io import joint_to_dataset
from boltjoint.joint.partition import partition_regions
from boltjoint.joint.reduced import fit_reduced_joint
from boltjoint.report.figures.contact import plot_loops


def test_loops_are_whole_and_end_on_the_loading_curve(reduced, regions):
    (axes,) = plot_loops(reduced, joint_to_dataset(regions), region=2).axes
    drawn = curves(axes)
    assert len(drawn) == 3 * 2
    of = regions.law.point_of_element == 1
    law = regions.law.tangential_stiffness[of], regions.law.slip_force[of]
    for loop in range(3):
        amplitude = reduced["loop_amplitude"].to_numpy()[1, loop]
        many = drawn[f"region 2, all {of.sum()} elements, {amplitude * 1e6:.3g} μm"]
        half = len(many) // 2
        np.testing.assert_allclose(many[:half], -many[half:])
        tip = [amplitude * 1e6, loading_curve(np.array(amplitude), *law)]
        np.testing.assert_allclose(many[0], tip)
        # from tip to tip and back
        np.testing.assert_allclose(many[half - 1], many[half], rtol=1e-9)
        few = drawn[f"2 fitted elements, {amplitude * 1e6:.3g} μm"]
        np.testing.assert_allclose(
            few[:half, 1], reduced["loop_force_of_fit"].to_numpy()[1, loop], rtol=1e-12
        )
    assert axes.get_xlabel() == "relative displacement (μm)"
    assert axes.get_ylabel() == "friction force (N)"
    texts = legend_texts(axes)
    assert f"region 2, all {of.sum()} elements" in texts
    assert "2 fitted elements" in texts


def test_open_elements_have_no_part_in_loops():
    nodes = make_joint(law="variable")
    regions = partition_regions(nodes, make_preload(nodes), 3)
    fitted, fit = fit_reduced_joint(regions, 2, starts=2)
    reduced = joint_to_dataset(fitted).merge(fit)
    (axes,) = plot_loops(reduced, joint_to_dataset(regions)).axes
    first = regions.law.point_of_element == 0
    loaded = np.sum(regions.law.normal_load[first] > 0)
    assert loaded < first.sum()
    expected = f"region 1, {loaded} of {first.sum()} elements under load"
    assert expected in legend_texts(axes)


def test_a_region_without_load_has_no_loops():
    nodes = make_joint(law="variable")
    region = np.repeat([0, 1], [20, nodes.points - 20])
    load = np.where(region == 0, -1.0, nodes.law.normal_load)
    regions = merge_points(replace(nodes, law=replace(nodes.law, normal_load=load)), region)
    fitted, fit = fit_reduced_joint(regions, 2, starts=2)
    reduced = joint_to_dataset(fitted).merge(fit)
    (axes,) = plot_loops(reduced, joint_to_dataset(regions)).axes
    assert not axes.lines
    assert "region 1, 0 of 20 elements under load" in legend_texts(axes)


@pytest.mark.parametrize("region", [0, 4])
def test_loops_need_a_region(reduced, regions, region):
    with pytest.raises(ValueError, match=f"region {region} of 3"):
        plot_loops(reduced, joint_to_dataset(regions), region)
