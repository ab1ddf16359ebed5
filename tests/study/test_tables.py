from itertools import product
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from small_joint import make_joint, make_preload

from boltjoint import csv_files
from boltjoint.dataset import DamagedFile
from boltjoint.dynamics.response.converged_peaks import converge_peaks
from boltjoint.dynamics.response.error_bars import add_converged_peaks
from boltjoint.dynamics.response.frequency_response import solve_response
from boltjoint.dynamics.response.methods import LinearModes
from boltjoint.friction import contact_states
from boltjoint.joint.io import joint_to_dataset
from boltjoint.joint.partition import partition_regions
from boltjoint.joint.reduced import fit_reduced_joint
from boltjoint.reproduction import comparison
from boltjoint.reproduction.published import Published
from boltjoint.study.tables import html as tables
from boltjoint.study.tables.accuracy import (
    curve_error,
    tabulate_accuracy,
    tabulate_models,
    upper_branch,
)
from boltjoint.study.tables.harmonic_peaks import tabulate_harmonic_peaks
from boltjoint.study.tables.joints import (
    tabulate_elements,
    tabulate_fits,
    tabulate_regions,
    tabulate_states,
)
from boltjoint.study.timing import Timed, tabulate_times
from boltjoint.verification.residual_in_time import check_solutions

SOURCE = Path(__file__).parents[2] / "resources" / "source"
JACOBIANS = ("analytic", "forward-difference")
FORCES = [0.001, 1.0, 5.0]


@pytest.fixture(scope="module")
def study():
    """Joints and responses of a tiny study, as a case would have them."""
    nodes = make_joint()
    regions = partition_regions(nodes, make_preload(nodes), 6)
    reduced, _ = fit_reduced_joint(regions, 4, starts=4)
    found = {"node-to-node": nodes, "regions=6": regions, "regions=6/elements=4": reduced}
    solved = {
        (name, coordinates, 1): solve_response(one, FORCES, method=coordinates, damping=0.01)
        for name, one in found.items()
        for coordinates in ("linear", "rdnm-1")
    }
    return found, solved


def times_of(joint, forces, jacobian):
    """Times of the responses of a joint in linear modes."""
    method = Timed.of(LinearModes(jacobian=jacobian))
    solve_response(joint, forces, method, damping=0.01)
    return method.times


@pytest.fixture(scope="module")
def variable():
    """Joints under variable normal load."""
    nodes = make_joint(law="variable")
    regions = partition_regions(nodes, make_preload(nodes), 4)
    reduced, _ = fit_reduced_joint(regions, 2, starts=2)
    return {"node-to-node": nodes, "regions=4": regions, "regions=4/elements=2": reduced}


def test_upper_branch_of_a_folded_curve():
    frequency = np.array([0.0, 2.0, 1.0, 3.0])
    amplitude = np.array([0.0, 2.0, 3.0, 5.0])
    grid = np.array([0.5, 1.0, 1.5, 2.5])
    np.testing.assert_allclose(upper_branch(frequency, amplitude, grid), [0.5, 3.0, 3.5, 4.5])


def test_curve_error_of_a_scaled_curve():
    frequency = np.linspace(50, 100, 3000)
    amplitude = 1 / (1 + (frequency - 80) ** 2)
    reference = frequency, amplitude
    assert curve_error(reference, reference) == 0
    tenfold = curve_error((frequency, 10 * amplitude), reference)
    assert tenfold == pytest.approx(20.0)
    other = np.linspace(40, 90, 3710)
    same = other, 1 / (1 + (other - 80) ** 2)
    assert curve_error(same, reference) < 1e-3  # straight lines between solutions


def test_accuracy_table_measures_against_node_to_node(study):
    _, solved = study
    table = tabulate_accuracy(solved, {}).set_index(["joint", "coordinates", "force_N"])
    assert len(table) == 6 * len(FORCES)
    own = table.loc[("node-to-node", "linear")]
    for name in ("peak_frequency_error_percent", "peak_amplitude_error_percent", "curve_error_dB"):
        assert (own[name] == 0).all()
    row = table.loc[("regions=6", "linear", 5.0)]
    nodes, reduced = solved["node-to-node", "linear", 1], solved["regions=6", "linear", 1]
    expected = 100 * (reduced["peak_amplitude"][2] / nodes["peak_amplitude"][2] - 1)
    assert row["peak_amplitude_error_percent"] == pytest.approx(float(expected))
    assert row["peak_mm_per_N"] == pytest.approx(float(reduced["peak_amplitude"][2]) * 1e3 / 5)


def test_accuracy_table_tells_what_the_march_in_time_found(study):
    found, solved = study
    which = ("regions=6/elements=4", "linear", 1)
    check = check_solutions(joint_to_dataset(found[which[0]]), solved[which])
    table = tabulate_accuracy(solved, {which: check})
    mine = (table["joint"] == which[0]) & (table["coordinates"] == "linear")
    np.testing.assert_array_equal(table.loc[mine, "residual_in_time"], check["residual_in_time"])
    np.testing.assert_array_equal(table.loc[mine, "worst_in_time_Hz"], check["frequency_Hz"])
    assert table.loc[~mine, "residual_in_time"].isna().all()


def test_a_broken_path_has_no_errors_but_a_reason(study):
    _, solved = study
    broken = solved["regions=6", "rdnm-1", 1].copy(deep=True)
    broken["complete"][1] = 0
    broken["reason"] = ("force", np.array(["", "no solution found near the last one", ""]))
    table = tabulate_accuracy({**solved, ("regions=6", "rdnm-1", 1): broken}, {})
    row = table.query("joint == 'regions=6' and coordinates == 'rdnm-1' and force_N == 1").iloc[0]
    assert np.isnan(row["peak_frequency_error_percent"])
    assert row["reason"] == "no solution found near the last one"
    assert not row["complete"]


def test_nothing_is_compared_with_a_reference_that_broke_off(study):
    _, solved = study
    broken = solved["node-to-node", "linear", 1].copy(deep=True)
    broken["complete"][2] = 0
    table = tabulate_accuracy({**solved, ("node-to-node", "linear", 1): broken}, {})
    errors = table.set_index("force_N")["curve_error_dB"]
    assert errors.loc[5.0].isna().all()
    assert errors.loc[1.0].notna().all()


def test_without_a_reference_there_are_no_errors(study):
    _, solved = study
    only = {("regions=6", "linear", 1): solved["regions=6", "linear", 1]}
    table = tabulate_accuracy(only, {})
    assert table["peak_frequency_Hz"].notna().all()
    of_itself = table.filter(regex="estimated|energy")
    against_reference = table.filter(like="error").drop(columns=of_itself.columns)
    assert against_reference.isna().all(axis=None)
    assert of_itself.notna().all(axis=None)


def test_accuracy_table_tells_estimated_errors_and_folds(study):
    _, solved = study
    which = ("node-to-node", "rdnm-1", 1)
    response = solved[which].copy(deep=True)
    level = 1
    response["turning_points"][level] = 2
    response["folded_from"][level], response["folded_to"][level] = 61.0, 62.5
    response["folded_from_converged"][level] = 61.5
    response["folded_to_converged"][level] = 62.0
    response["isolated_branch"][level] = 1
    response["fell_back"][level] = 1
    response["wrong"][level] = 1
    table = tabulate_accuracy({which: response}, {})
    row = table.iloc[level]
    estimate = 100 * float(response["peak_error_estimate"][level])
    assert estimate > 0
    assert row["estimated_peak_error_percent"] == estimate
    assert row["estimated_largest_error_percent"] == pytest.approx(
        100 * float(response["largest_error_estimate"][level])
    )
    assert (row["turning_points"], row["folded_from_Hz"], row["folded_to_Hz"]) == (2, 61.0, 62.5)
    converged = row["folded_from_converged_Hz"], row["folded_to_converged_Hz"]
    assert converged == (61.5, 62.0)
    assert row["fell_back"]
    assert row["wrong"]
    mine = response["excitation_force"] == FORCES[level]
    response["largest_multiplier"][np.flatnonzero(mine)[3:5]] = [1.25, 0.75]
    response["stable"][np.flatnonzero(mine)[3:5]] = [0, 1]
    response["stability_harmonics"][np.flatnonzero(mine)[3:5]] = [15, 1]
    table = tabulate_accuracy({which: response}, {})
    expected = [1.25 if force == FORCES[level] else np.nan for force in FORCES]
    np.testing.assert_array_equal(table["largest_multiplier"], expected)
    # the fewest harmonics with which the stability of a motion is known
    expected = [1 if force == FORCES[level] else 0 for force in FORCES]
    np.testing.assert_array_equal(table["stability_harmonics"], expected)
    known = [True if force == FORCES[level] else None for force in FORCES]
    assert table["isolated_branch"].tolist() == known
    assert row["residual"] == float(response["residual"][mine.to_numpy()].max()) > 1e-6


def test_accuracy_table_has_the_largest_energy_error_of_what_converged(study):
    _, solved = study
    which = ("regions=6", "linear", 1)
    response = solved[which].copy(deep=True)
    at_level = np.flatnonzero(response["excitation_force"] == FORCES[1])
    response["energy_error"][at_level] = 1e-9
    response["energy_error"][at_level[3]] = -1e-3
    response["energy_error"][at_level[5]] = 0.5
    response["converged"][at_level[5]] = 0
    found = tabulate_accuracy({which: response}, {}).set_index("force_N")["energy_error"]
    assert found[FORCES[1]] == 1e-3
    # elsewhere the tolerance of the solver, over the largest response to which it is relative
    assert found.drop(FORCES[1]).max() < 1e-6


def test_models_of_any_basis_are_against_the_converged_one(study):
    _, solved = study
    converged = ("enriched-40", "node-to-node", "linear", 1)
    broken = solved["regions=6", "linear", 1].copy(deep=True)
    broken["complete"][2] = 0
    responses = {
        ("free-4", "regions=6", "linear", 1): broken,
        converged: solved["node-to-node", "linear", 1],
    }
    timing = pd.DataFrame({"force_N": FORCES, "cpu_s": [2.0, 3.0, 5.0]})
    table = tabulate_models(responses, dict.fromkeys(responses, timing), converged)
    table = table.set_index(["modes", "force_N"])
    assert list(table.index) == [(name, f) for name in ("free-4", "enriched-40") for f in FORCES]
    own = table.loc["enriched-40"].filter(like="error")
    assert (own == 0).all(axis=None)
    peaks = (found["peak_amplitude"][1].item() for found in responses.values())
    row = table.loc["free-4", 1.0]
    assert row["peak_amplitude_error_percent"] == pytest.approx(
        100 * (next(peaks) / next(peaks) - 1)
    )
    assert row["cpu_s"] == 3
    assert table["complete"].tolist() == [True, True, False, True, True, True]
    assert table.loc["free-4", 5.0].filter(like="error").isna().all()


def test_models_are_compared_with_the_converged_peaks_of_the_reference(study):
    joints, solved = study
    response = solved["node-to-node", "linear", 1]
    found = add_converged_peaks(response, converge_peaks(joints["node-to-node"], response))
    which = ("enriched-40", "node-to-node", "linear", 1)
    timing = pd.DataFrame({"force_N": FORCES, "cpu_s": 1.0})
    table = tabulate_models({which: found}, {which: timing}, which).set_index("force_N")
    accuracy = tabulate_accuracy({which[1:]: found}, {}).set_index("force_N")
    by_harmonics = tabulate_harmonic_peaks(found).set_index(["force_N", "harmonics"])
    for place, force in enumerate(FORCES):
        at, row = found.isel(force=place), table.loc[force]
        most = int(at["peak_harmonics"])
        for what in ("frequency", "amplitude"):
            error = at[f"peak_{what}"].item() / at[f"peak_{what}_converged"].item() - 1
            assert row[f"peak_{what}_error_percent"] == pytest.approx(100 * error)
            # the same in the table by harmonics, where the last has none
            in_harmonics = by_harmonics.loc[force][f"peak_{what}_error_percent"]
            assert in_harmonics[1] == pytest.approx(100 * error)
            assert in_harmonics[most] == 0
            assert in_harmonics.index[-1] == most
            of_converged = accuracy.loc[force, f"converged_{what}_error_bar_percent"]
            assert of_converged == pytest.approx(100 * at[f"peak_{what}_converged_error"].item())
            bar = accuracy.loc[force, f"{what}_error_bar_percent"]
            left_out = by_harmonics.loc[(force, most), f"{what}_truncation_error_percent"]
            # over the smaller of both, and of their product
            apart = max(1 + error, 1 / (1 + error))
            assert bar == pytest.approx(100 * (apart * (1 + left_out / 100) - 1))
        assert accuracy.loc[force, "harmonics"] == most
        assert accuracy.loc[force, "response_harmonics"] == 1


def test_fits_are_compared_with_their_own_regions(study):
    found, solved = study
    fits, timings = {}, {}
    methods = {"regions=6/elements=4": "loops", "regions=6/harmonic=4": "describing-function"}
    for name, method in methods.items():
        _, fits[name] = fit_reduced_joint(found["regions=6"], 4, method=method, starts=4)
        timings[name] = pd.DataFrame({"cpu_s": [0.5]})
    names = ("regions=6", "regions=6/elements=4")
    responses = {name: solved[name, "linear", 1] for name in names}
    table = tabulate_fits(fits, timings, responses).set_index("joint")
    for name, fit in fits.items():
        row = table.loc[name]
        assert row["cpu_s"] == 0.5
        assert row["cost_N2"] == pytest.approx(fit["fit_cost"].sum().item())
        largest = fit["largest_loop_error"].max().item()
        assert row["largest_loop_error_percent"] == pytest.approx(100 * largest)
    # the source's cost is what its method minimises
    assert table["cost_N2"].idxmin() == "regions=6/elements=4"
    ratio = np.divide(*(responses[name]["peak_amplitude"].to_numpy() for name in reversed(names)))
    row = table.loc["regions=6/elements=4"]
    expected = 100 * np.abs(ratio - 1).max()
    assert row["peak_amplitude_error_percent"] == pytest.approx(expected)
    # what is not solved has no peak to compare
    assert table.loc["regions=6/harmonic=4"].filter(like="peak").isna().all()


def test_times_stand_beside_the_published_ones(study):
    found, _ = study
    timed = pd.concat(times_of(found["regions=6"], FORCES, jacobian) for jacobian in JACOBIANS)
    # as if each took another time
    timings = {
        (name, coordinates, 1): timed.assign(cpu_s=(1 + place) * timed["cpu_s"])
        for place, (name, coordinates) in enumerate(product(found, ("linear", "rdnm-1")))
    }
    table = comparison.times_beside(
        tabulate_times(timings), Published(SOURCE, "three_bolt_constant")
    )
    table = table.set_index(["joint", "coordinates", "force_N"])
    assert len(table) == 6 * len(FORCES)
    assert table.loc[("node-to-node", "linear", 1.0), "published_s"] == 695.3
    assert table.loc[("node-to-node", "rdnm-1", 1.0), "published_reduction_percent"] == (
        pytest.approx(55.11, abs=0.01)
    )
    row = table.loc[("regions=6", "rdnm-1", 5.0)]
    assert row["published_reduction_percent"] == 99.91
    assert row["source_table"] == "3.4"
    reference = timings["node-to-node", "linear", 1].query("force_N == 5")
    mine = timings["regions=6", "rdnm-1", 1].query("force_N == 5")
    for way, column in (
        ("analytic", "reduction_percent"),
        ("forward-difference", "reduction_forward_difference_percent"),
    ):
        ratio = mine.query(f"jacobian == {way!r}")["cpu_s"].item() / (
            reference.query(f"jacobian == {way!r}")["cpu_s"].item()
        )
        assert row[column] == pytest.approx(100 * (1 - ratio))


def test_elements_stand_beside_the_published_ones_in_order_of_slip(study):
    found, _ = study
    dataset = joint_to_dataset(found["regions=6/elements=4"])
    table = comparison.elements_beside(
        tabulate_elements(dataset), "regions=6/elements=4", Published(SOURCE, "three_bolt_constant")
    )
    assert len(table) == 24
    assert table["published_slip_force_N"].sum() == pytest.approx(11392.8)
    slips_at = table["slip_force_N"] / table["k_kN_per_mm"]
    assert (slips_at.groupby(table["region"]).diff().dropna() >= 0).all()
    theirs = table["published_slip_force_N"] / table["published_k_kN_per_mm"]
    assert (theirs.groupby(table["region"]).diff().dropna() >= 0).all()


def test_joint_that_was_not_published_stands_alone(study):
    found, _ = study
    dataset = joint_to_dataset(found["regions=6/elements=4"])
    for published in (Published(SOURCE), Published(SOURCE, "four_bolt_constant")):
        table = comparison.elements_beside(
            tabulate_elements(dataset), "regions=6/elements=4", published
        )
        assert "published_k_kN_per_mm" not in table


def test_unknown_case_study_is_refused():
    with pytest.raises(ValueError, match=r"no case study 'five_bolt'.*three_bolt_constant"):
        Published(SOURCE, "five_bolt")


def test_published_table_3_11_has_six_elements():
    printed = Published(SOURCE, "four_bolt_constant").parameters("regions=8/elements=6")
    assert printed["element"].max() == 6
    assert printed["mu_n_N"].sum() == pytest.approx(15194.7, abs=0.05)


def test_published_tables_in_two_parts_are_joined():
    printed = Published(SOURCE, "four_bolt_variable").parameters("regions=16/elements=4")
    assert printed[["k_kN_per_mm", "mu_n_N"]].notna().all(axis=None)
    assert set(printed["source_table"]) == {"3.21 and 3.22"}


def test_regions_table(study):
    found, _ = study
    table = tabulate_regions(joint_to_dataset(found["regions=6"]))
    assert table["elements"].sum() == 60
    assert table["share_of_load_percent"].sum() == pytest.approx(100)
    assert (table["from_x_mm"].diff().dropna() > 0).all()


def test_regions_table_tells_open_elements_from_loaded_ones(variable):
    law = variable["regions=4"].law
    table = tabulate_regions(joint_to_dataset(variable["regions=4"]))
    closed = law.normal_load > 0
    assert table["elements"].sum() == 60
    assert table["loaded_elements"].sum() == closed.sum() < 60
    assert table["slip_force_N"].sum() == pytest.approx(law.slip_force.sum())
    assert table["stiffness_kN_per_mm"].sum() == pytest.approx(5 * closed.sum())
    np.testing.assert_allclose(
        table["normal_stiffness_kN_per_mm"], 2 * table["stiffness_kN_per_mm"]
    )


def test_elements_under_variable_load_have_normal_stiffnesses(variable):
    name = "regions=4/elements=2"
    table = tabulate_elements(joint_to_dataset(variable[name]))
    law = variable[name].law
    assert len(table) == 8
    np.testing.assert_allclose(table["normal_k_kN_per_mm"], 2 * table["k_kN_per_mm"])
    expected = law.friction_coefficient * law.normal_load
    assert table["slip_force_N"].sum() == pytest.approx(expected.sum())


@pytest.mark.parametrize(
    ("case", "regions", "tables"),
    [("three_bolt_variable", 12, "3.16"), ("four_bolt_variable", 16, "3.21 and 3.22")],
)
def test_elements_under_variable_load_stand_beside_the_published_ones(case, regions, tables):
    nodes = make_joint(400, law="variable")
    of_regions = partition_regions(nodes, make_preload(nodes), regions)
    reduced, _ = fit_reduced_joint(of_regions, 4, starts=1)
    name = f"regions={regions}/elements=4"
    table = tabulate_elements(joint_to_dataset(reduced))
    table = comparison.elements_beside(table, name, Published(SOURCE, case))
    assert len(table) == 4 * regions
    assert table[["k_ratio", "slip_force_ratio"]].notna().all(axis=None)
    assert set(table["source_table"]) == {tables}


def test_states_are_shares_of_elements_and_of_load(variable):
    name = "node-to-node"
    joint = variable[name]
    response = solve_response(joint, FORCES, damping=0.01)
    stored = {name: joint_to_dataset(joint)}
    table = tabulate_states({(name, "linear", 1): response}, stored)
    assert list(table["force_N"]) == FORCES
    np.testing.assert_array_equal(table["peak_frequency_Hz"], response["peak_frequency"])
    for what in ("elements", "load"):
        assert table.filter(regex=f"^{what}_in").sum(axis=1).to_numpy() == pytest.approx(100)
    slips = response["contact_state"].to_numpy() == contact_states.STICK_SLIP
    load = np.maximum(joint.law.normal_load, 0)
    assert 0 < slips.sum() < slips.size
    np.testing.assert_allclose(table["elements_in_stick_slip_percent"], 100 * slips.mean(axis=1))
    np.testing.assert_allclose(table["load_in_stick_slip_percent"], 100 * slips @ load / load.sum())


def test_without_a_peak_there_are_no_states(study):
    found, solved = study
    which = ("regions=6", "linear", 1)
    response = solved[which].copy(deep=True)
    response["contact_state"][1] = contact_states.UNKNOWN
    stored = {which[0]: joint_to_dataset(found[which[0]])}
    shares = tabulate_states({which: response}, stored).filter(like="_in_")
    assert shares.loc[1].isna().all()
    assert shares.loc[[0, 2]].notna().all(axis=None)


def test_states_need_the_joint_that_was_solved(study):
    found, solved = study
    which = ("regions=6", "linear", 1)
    other = {which[0]: joint_to_dataset(found["regions=6/elements=4"])}
    with pytest.raises(ValueError, match="has 60 elements, the joint 24"):
        tabulate_states({which: solved[which]}, other)


@pytest.mark.parametrize(
    ("case", "joint", "table"),
    [
        ("three_bolt_variable", "regions=12/elements=4", "3.17"),
        ("four_bolt_variable", "regions=16/elements=4", "3.23"),
    ],
)
def test_a_time_that_was_not_printed_leaves_its_row_alone(case, joint, table):
    row = {"repeat": 0, "wall_s": 1.0, "solutions": 9, "iterations": 20, "complete": 1}
    timing = pd.DataFrame(
        [
            {**row, "force_N": force, "cpu_s": 1.0, "jacobian": jacobian}
            for force in (0.001, 1.0)
            for jacobian in ("analytic", "forward-difference")
        ]
    )
    solved = [("node-to-node", "linear", 1), (joint, "linear", 1), (joint, "rdnm-1", 1)]
    times = comparison.times_beside(
        tabulate_times(dict.fromkeys(solved, timing)), Published(SOURCE, case)
    )
    assert len(times) == 6
    times = times.set_index(["joint", "coordinates", "force_N"])
    assert times.loc[(joint, "linear"), "published_reduction_percent"].notna().all()
    reductions = times.loc[(joint, "rdnm-1"), "published_reduction_percent"]
    assert reductions.isna().to_list() == [True, False]
    assert (times.loc[joint, "source_table"] == table).all()
    assert (times["reduction_percent"] == 0).all()


def test_where_no_forward_differences_were_timed_their_columns_are_empty():
    row = {"force_N": 1.0, "repeat": 0, "wall_s": 1.0, "solutions": 9, "iterations": 20}

    def timing(**cpu):
        return pd.DataFrame(
            [
                {**row, "cpu_s": seconds, "jacobian": way.replace("_", "-"), "complete": 1}
                for way, seconds in cpu.items()
            ]
        )

    both = timing(analytic=4.0, forward_difference=20.0)
    timings = {
        ("node-to-node", "linear", 1): both,
        ("node-to-node", "rdnm-1", 1): timing(analytic=2.0, forward_difference=5.0),
        ("node-to-node", "backbone", 1): timing(analytic=1.0),
    }
    table = tabulate_times(timings).set_index("coordinates")
    assert table["reduction_percent"].to_list() == [0.0, 50.0, 75.0]
    by_differences = table["reduction_forward_difference_percent"]
    assert by_differences["rdnm-1"] == 75.0
    assert np.isnan(by_differences["backbone"])
    assert np.isnan(table.loc["backbone", "cpu_forward_difference_s"])
    assert table["complete"].all()
    assert table["complete_forward_difference"].to_list() == [True, True, False]
    # a path that broke off has no reduction, and none has one to it: each Jacobian by itself
    broken = both.assign(complete=(both["jacobian"] == "analytic").astype(int))
    for which, without in (("rdnm-1", ["rdnm-1", "backbone"]), ("linear", list(table.index))):
        changed = tabulate_times(timings | {("node-to-node", which, 1): broken})
        changed = changed.set_index("coordinates")
        by_differences = changed["reduction_forward_difference_percent"]
        assert by_differences.index[by_differences.isna()].to_list() == without
        assert changed["reduction_percent"].notna().all()
        assert not changed.loc[which, "complete_forward_difference"]
        assert changed.loc[which, "complete"]


def test_table_on_paper(tmp_path):
    table = pd.DataFrame({"peak_frequency_Hz": [70.123456, np.nan], "joint": ["a<b", "c"]})
    tables.write(table, tmp_path / "t.csv", tmp_path / "t.html", "A & B")
    pd.testing.assert_frame_equal(csv_files.read(tmp_path / "t.csv"), table)
    page = (tmp_path / "t.html").read_text()
    for text in ("peak frequency (Hz)", "a&lt;b", "<h1>A &amp; B</h1>", "70.12", "–"):
        assert text in page


#: of more digits than tables have, and two that these do not tell apart
LONG_LEVELS = [0.1, 10.123456789012, 10.123456789013, 1 / 3, 1e-17 / 7, 2e16 + 4]


def test_levels_of_a_table_are_read_as_they_were(tmp_path):
    values = np.array(LONG_LEVELS) / 3
    table = pd.DataFrame({"force_N": [*LONG_LEVELS, np.nan], "peak_mm": [*values, np.nan]})
    tables.write(table, tmp_path / "t.csv", tmp_path / "t.html", "levels")
    found = csv_files.read(tmp_path / "t.csv")
    np.testing.assert_array_equal(found["force_N"], table["force_N"])
    np.testing.assert_allclose(found["peak_mm"], table["peak_mm"], rtol=1e-8)
    lines = (tmp_path / "t.csv").read_text().splitlines()
    # the others have nine digits, as levels have for which these are enough
    assert lines[1] == "0.1,0.0333333333"
    assert lines[2] == "10.123456789012,3.3744856"
    # what pandas itself wrote for later stages is read as exactly
    table.to_csv(tmp_path / "check.csv", index=False)
    found = csv_files.read(tmp_path / "check.csv")
    np.testing.assert_array_equal(found["force_N"], table["force_N"])


def test_residuals_in_time_are_those_of_their_levels(study, tmp_path):
    found, _ = study
    nodes = found["node-to-node"]
    response = solve_response(nodes, [1 / 3, 10.123456789012], damping=0.01)
    check = check_solutions(joint_to_dataset(nodes), response)
    check.to_csv(tmp_path / "check.csv", index=False)
    which = ("node-to-node", "linear", 1)
    table = tabulate_accuracy({which: response}, {which: csv_files.read(tmp_path / "check.csv")})
    assert table["residual_in_time"].notna().all()


def test_times_of_a_case_that_was_not_published_stand_alone(study):
    found, _ = study
    times = times_of(found["node-to-node"], [1.0], "analytic")
    table = tabulate_times({("node-to-node", "linear", 1): times})
    table = comparison.times_beside(table, Published(SOURCE))
    assert not [name for name in table if "published" in name or "source" in name]
    assert table["cpu_s"].item() > 0


@pytest.mark.parametrize(
    "content",
    [b"", b"a,b\n1,2\n3", b"\0" * 40, b"\n", b"a\n1\n\xff\n", b"a\n1,2\n1,2,3\n"],
)
def test_a_damaged_table_is_named(tmp_path, content):
    path = tmp_path / "t.csv"
    path.write_bytes(content)
    with pytest.raises(DamagedFile) as caught:
        csv_files.read(path)
    (sentence,) = str(caught.value).splitlines()
    assert sentence.startswith(f"{path}: ")
    assert sentence.endswith(": delete it and run again")


def test_a_missing_table_is_missing_not_damaged(tmp_path):
    with pytest.raises(FileNotFoundError, match=r"t\.csv: there is no such file"):
        csv_files.read(tmp_path / "t.csv")
