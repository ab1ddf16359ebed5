"""Sampled forces against exact ones; peaks and resonances of bases against the largest."""

from dataclasses import replace

import numpy as np
import pytest
import xarray as xr
from small_joint import make_joint, make_preload

from boltjoint.dynamics.balance.harmonic_balance import HarmonicBalance
from boltjoint.dynamics.response.frequency_response import solve_branch, solve_response
from boltjoint.dynamics.response.windows import Resonance, frequency_window
from boltjoint.friction.aft import AlternatingFrequencyTime
from boltjoint.friction.contact_states import STICK_SLIP, STICK_SLIP_SEPARATION
from boltjoint.joint.partition import partition_regions, region_error
from boltjoint.structure.patterns import resonances_in
from boltjoint.study import convergence
from boltjoint.study.convergence import (
    peaks_near,
    tabulate_basis_peaks,
    tabulate_divisions,
    tabulate_patterns,
    tabulate_reductions,
    tabulate_sampling,
)

LOSS = 0.01
FORCES = [1.0, 20.0]
PEAK = ["peak_frequency_Hz", "peak_mm_per_N"]
ERRORS = ["peak_frequency_error_percent", "peak_amplitude_error_percent"]
SAMPLES = (64, 128, 256, 512, 1024)


@pytest.fixture(scope="module", params=["constant", "variable"])
def solved(request):
    joint = make_joint(law=request.param)
    return joint, solve_response(joint, FORCES, damping=LOSS)


def test_table_has_a_row_for_every_force_and_number_of_samples(solved):
    table = tabulate_sampling({"one": solved, "other": solved}, samples=(32, 64))
    assert list(table) == ["case", "law", "samples", "force_N", "error_relative"]
    rows = [(case, force, n) for case in ("one", "other") for force in FORCES for n in (32, 64)]
    assert list(zip(table["case"], table["force_N"], table["samples"], strict=True)) == rows
    assert set(table["law"]) == {solved[0].law.name}


def test_error_is_that_of_the_forces_at_the_largest_response(solved):
    joint, response = solved
    table = tabulate_sampling({"joint": solved}, samples=(64,)).set_index("force_N")
    for force in FORCES:
        at = response.isel(solution=(response["excitation_force"] == force).to_numpy())
        at = at.isel(solution=int(np.argmax(at["response_amplitude"].to_numpy())))
        q = at["modal_coordinate"].sel(component=list(joint.law.components))
        x = q.transpose("component", ...).to_numpy().ravel()
        motion = HarmonicBalance(joint, LOSS, force).motion(x)
        exact = joint.law.force(motion)
        error = AlternatingFrequencyTime(joint.law, samples=64).force(motion) - exact
        expected = np.sqrt((error**2).sum() / (exact**2).sum())
        # differences of nearly equal forces, 1e-4 of them
        assert table["error_relative"][force] == pytest.approx(expected, rel=1e-9)


def test_error_falls_with_the_square_of_the_samples(solved):
    table = tabulate_sampling({"joint": solved}, SAMPLES)
    for _, of_force in table.groupby("force_N"):
        error = of_force["error_relative"].to_numpy()
        slope = np.polyfit(np.log(of_force["samples"]), np.log(error), 1)[0]
        # how far transitions lie from samples scatters the errors; first order would have -1
        assert slope == pytest.approx(-2, abs=0.3)
        assert (error > 0).all()
        # the corners of a slipping force are missed by a sample in 64, squared
        assert 1e-4 < error[0] < 1e-2


def test_error_of_responses_that_were_sampled_is_also_against_exact_forces(solved):
    joint, _ = solved
    sampled = replace(joint, law=AlternatingFrequencyTime(joint.law, 3, samples=64))
    response = solve_response(sampled, [20.0], damping=LOSS)
    error = tabulate_sampling({"joint": (joint, response)}, (64, 1024))["error_relative"]
    # against those of 64 samples the first would be nothing, and the second the larger
    assert error[0] > 50 * error[1] > 0


def test_sampling_a_joint_that_sticks_errs_by_rounding_only(solved):
    joint, _ = solved
    response = solve_response(joint, [1e-4], damping=LOSS)
    assert not response["contact_state"].isin([STICK_SLIP, STICK_SLIP_SEPARATION]).any()
    error = tabulate_sampling({"joint": (joint, response)}, (64,))["error_relative"].item()
    # rounding of the normal loads, of which the forces are more than 1e-4
    assert error < 1e-11


@pytest.fixture
def followed(monkeypatch):
    """The branches that are solved while a test runs."""
    branches = []

    def solve(*args, **options):
        branches.append(solve_branch(*args, **options))
        return branches[-1]

    monkeypatch.setattr(convergence, "solve_branch", solve)
    return branches


@pytest.mark.parametrize("law", ["constant", "variable"])
def test_peaks_are_those_of_the_whole_response(law, followed):
    joint, forces = make_joint(law=law), [0.001, 1.0, 5.0, 20.0, 100.0]
    peaks = peaks_near(joint, forces, LOSS)
    assert list(peaks) == ["force_N", "peak_frequency_Hz", "peak_mm_per_N"]
    response = solve_response(joint, forces, damping=LOSS)
    # a maximum is located within 1e-6 of a step of some 1e-2 of the frequency
    np.testing.assert_allclose(peaks["peak_frequency_Hz"], response["peak_frequency"], rtol=1e-8)
    expected = 1e3 * response["peak_amplitude"] / forces
    np.testing.assert_allclose(peaks["peak_mm_per_N"], expected, rtol=1e-8)
    # and with a few of the solutions: one stretch for each force
    assert len(followed) == len(forces)
    assert sum(branch.frequency.size for branch in followed) < 0.3 * response.sizes["solution"]


def test_peaks_of_a_higher_resonance(joint):
    peaks = peaks_near(joint, [1.0], LOSS, resonance=2).iloc[0]
    branch = solve_branch(joint, 1.0, damping=LOSS, resonance=2)
    assert peaks["peak_frequency_Hz"] == pytest.approx(branch.frequency[branch.peak], rel=1e-8)
    assert peaks["peak_mm_per_N"] == pytest.approx(1e3 * branch.amplitude[branch.peak], rel=1e-8)


def test_a_peak_that_is_not_inside_is_looked_for_further_out(joint, followed, monkeypatch):
    expected = peaks_near(joint, [5.0], LOSS)

    def misled(*args):
        """The synthesised response, its frequencies too high for the nearest interval."""
        found = synthesise_response(*args)
        near = np.linalg.norm(found.modal_coordinate, axis=1)
        first = np.flatnonzero(near <= 0.9 * near[found.peak])
        width = np.ptp(found.frequency[[first[first < found.peak][-1], found.peak]])
        return replace(found, frequency=found.frequency + 1.2 * width)

    synthesise_response = convergence.synthesise_response
    followed.clear()
    monkeypatch.setattr(convergence, "synthesise_response", misled)
    found = peaks_near(joint, [5.0], LOSS)
    assert len(followed) > 1
    np.testing.assert_allclose(found, expected, rtol=1e-8)


@pytest.mark.parametrize("shift", [0.0, 30.0])
def test_without_a_peak_where_it_is_expected_all_of_the_response_is_followed(
    joint, followed, monkeypatch, shift
):
    expected = peaks_near(joint, [5.0], LOSS)
    synthesise_response = convergence.synthesise_response

    def misled(*args):
        found = synthesise_response(*args)
        peak = found.peak if shift else None
        return replace(found, peak=peak, frequency=found.frequency + shift)

    followed.clear()
    monkeypatch.setattr(convergence, "synthesise_response", misled)
    np.testing.assert_allclose(peaks_near(joint, [5.0], LOSS), expected, rtol=1e-8)
    whole = solve_branch(joint, 5.0, damping=LOSS)
    np.testing.assert_array_equal(followed[-1].frequency, whole.frequency)


def test_a_response_without_a_peak_has_none(joint):
    # observed where the second mode alone moves, and damped so much that it shows no resonance
    elsewhere = replace(joint, response_mode=np.array([0.0, 1.0, 0.0]))
    peaks = peaks_near(elsewhere, [1.0], 0.5)
    assert peaks.iloc[0, 1:].isna().all()


def test_bases_are_against_the_last_at_each_force(joint):
    fewer = replace(
        joint,
        **{
            name: getattr(joint, name)[..., :2]
            for name in ("natural_frequency", "excitation_mode", "response_mode", "tangential_mode")
        },
    )
    alone, last = (peaks_near(each, FORCES, LOSS) for each in (fewer, joint))
    table = tabulate_basis_peaks({"free-2": alone, "enriched-3": last})
    assert list(table["basis"]) == ["free-2"] * 2 + ["enriched-3"] * 2
    assert list(table["vectors"]) == [2, 2, 3, 3]
    assert list(table["force_N"]) == FORCES * 2
    np.testing.assert_array_equal(table.loc[table["basis"] == "enriched-3", ERRORS], 0)
    of_two = table[table["basis"] == "free-2"].reset_index()
    np.testing.assert_array_equal(of_two[list(alone)], alone)
    for name, error in zip(PEAK, ERRORS, strict=True):
        np.testing.assert_allclose(last[name] * (1 + of_two[error] / 100), alone[name], rtol=1e-12)


def test_regions_are_against_all_pairs_in_every_way_that_there_is():
    joint = make_joint(pairs=12)
    reference = peaks_near(joint, FORCES, LOSS)
    table = tabulate_divisions(joint, make_preload(joint), [3, 4, 12], reference, LOSS)
    ways = table.drop_duplicates(["division", "motion", "regions"])
    made = [("equal-load", motion) for motion in ("mean", "load-weighted", "linear")]
    every = [(*way, count) for way in [*made, ("clusters", "mean")] for count in (3, 4, 12)]
    # neither three nor twelve regions are an inner and an outer one in every band of these pairs
    every.insert(-3, ("inner-outer", "mean", 4))
    assert list(ways[["division", "motion", "regions"]].itertuples(False, None)) == every
    assert list(table["force_N"]) == FORCES * len(ways)
    # a region for every pair is the joint itself
    whole = table[table["regions"] == 12]
    np.testing.assert_allclose(whole[[*ERRORS, "region_error_percent"]], 0, atol=1e-6)
    few = table[(table["regions"] == 3) & (table["motion"] == "load-weighted")]
    regions = partition_regions(joint, make_preload(joint), 3, motion="load-weighted")
    assert few["region_error_percent"].to_numpy() == pytest.approx(
        100 * region_error(joint, regions)
    )
    found = peaks_near(regions, FORCES, LOSS)
    for name, error in zip(PEAK, ERRORS, strict=True):
        expected = 100 * (found[name] / reference[name] - 1)
        np.testing.assert_allclose(few[error], expected, rtol=1e-9)


@pytest.mark.parametrize("law", ["constant", "variable"])
def test_reductions_are_against_the_first_joint(law):
    joint = make_joint(pairs=12, law=law)
    few = partition_regions(joint, make_preload(joint), 3, "clusters")
    table = tabulate_reductions({"node-to-node": joint, "clusters=3": few}, FORCES, LOSS)
    assert list(table["joint"]) == ["node-to-node"] * 2 + ["clusters=3"] * 2
    assert list(table["force_N"]) == FORCES * 2
    assert set(zip(table["points"], table["elements"], strict=True)) == {(12, 12), (3, 12)}
    assert table["complete"].all()
    assert np.all(table["cpu_s"] > 0)
    np.testing.assert_array_equal(table.loc[:1, ERRORS], 0)
    window = frequency_window(joint)
    for row in table[2:].itertuples():
        branch = solve_branch(few, row.force_N, damping=LOSS, resonance=Resonance(1, window))
        assert row.peak_frequency_Hz == branch.frequency[branch.peak]
        whole = table["peak_frequency_Hz"][FORCES.index(row.force_N)]
        error = 100 * (row.peak_frequency_Hz / whole - 1)
        assert row.peak_frequency_error_percent == pytest.approx(error)


def test_patterns_have_a_row_for_every_resonance():
    rng = np.random.default_rng(4)
    position = (("pair", "axis"), rng.random((5, 3)))
    coords = {"axis": ["x", "y", "z"]}

    def basis(vectors):
        return xr.Dataset(
            {
                "natural_frequency": ("mode", np.linspace(50, 500, vectors)),
                "relative_mode": (("pair", "axis", "mode"), rng.random((5, 3, vectors))),
                "position": position,
            },
            coords=coords,
        )

    patterns = xr.Dataset(
        {
            "frequency": (
                ("pattern", "springs", "resonance"),
                rng.uniform(60, 90, (2, 2, 2)),
            ),
            "stuck": (("pattern", "pair"), np.array([[1, 1, 1, 1, 1], [1, 0, 1, 0, 0]])),
            "stiffness": 1e4,
            "position": position,
        },
        coords={"pattern": ["all", "two"], "springs": ["x", "xz"], **coords},
    )
    modes = {"small": basis(3), "large": basis(6)}
    table = tabulate_patterns(modes, patterns)
    keys = ["basis", "springs", "pattern", "resonance"]
    assert len(table) == len(table[keys].drop_duplicates()) == 2 * 8
    assert list(table.groupby("basis")["vectors"].first()[["small", "large"]]) == [3, 6]
    for name, of_basis in modes.items():
        found = resonances_in(of_basis, patterns).sel(pattern="two", springs="xz")
        row = table.set_index(keys).loc[name, "xz", "two", 2]
        assert row["frequency_Hz"] == found["frequency"][1].item()
        assert row["error_percent"] == pytest.approx(100 * found["error"][1].item(), rel=1e-12)
