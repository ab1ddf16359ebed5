"""Sentences on peaks."""

import numpy as np
import pandas as pd
import pytest
from small_joint import make_joint

from boltjoint.dynamics.response.converged_peaks import converge_peaks
from boltjoint.dynamics.response.error_bars import add_converged_peaks
from boltjoint.dynamics.response.frequency_response import solve_response
from boltjoint.names import REFERENCE, Basis
from boltjoint.report.pages.document import prose
from boltjoint.report.pages.peaks import (
    ALL,
    LARGE_BASIS_ERROR,
    NOT_TESTED,
    SOLVED,
    basis_error,
    peak_in_words,
    peaks_of_coordinates,
    peaks_of_reference,
    statement_of,
)
from boltjoint.study.response_list import by_trust
from boltjoint.study.tables.accuracy import tabulate_accuracy

ROWS = pd.DataFrame(
    {
        "force_N": [1.0, 10.0],
        "complete": True,
        "response_harmonics": 1,
        "peak_frequency_Hz": [75.4, 71.9],
        "peak_mm_per_N": [0.85, 0.35],
        "converged_peak_frequency_Hz": [75.18, None],
        "converged_frequency_error_bar_percent": [0.04, None],
        "converged_peak_mm_per_N": [0.928, None],
        "converged_amplitude_error_bar_percent": [2.4, None],
        "basis_amplitude_error_percent": [2.37, 2.37],
    }
)


@pytest.mark.parametrize(("unit", "per"), [("N", "mm/N"), ("m/s²", "mm/(m/s²)")])
def test_a_peak_has_its_bar_and_the_unit_of_its_excitation(unit, per):
    peaks = peaks_of_coordinates(ROWS)
    words = peak_in_words(peaks.iloc[0], unit).replace("\u00a0", " ")
    assert words == f"75.2 Hz (± 0.04 %) and 0.928 {per} (± 2.4 %) at 1 {unit}"
    # where no peak with all harmonics was found, there is one of one harmonic
    assert peak_in_words(peaks.iloc[1], unit) == (
        f"71.9 Hz and 0.35 {per} at 10 {unit} with one harmonic, whose error is not tested"
    )


def test_pages_say_where_most_of_the_bars_is_the_basis():
    rough = ROWS.assign(basis_amplitude_error_percent=53.0)
    assert basis_error(rough) > LARGE_BASIS_ERROR > basis_error(ROWS)
    advice = "enriched-auto, narrow them"
    for is_rough in (False, True):
        notes = prose("peaks").bars("enriched-24", "53", True, is_rough)
        words = " ".join(notes.striptags().split())
        assert (advice in words) == is_rough
        assert ". They do not hold" in words


def test_a_peak_tells_the_harmonics_it_is_solved_with():
    of_few = ROWS.drop(columns=[name for name in ROWS if name.startswith("converged")])
    sentence = statement_of(of_few.assign(response_harmonics=[1, 5])).replace("\u00a0", " ")
    assert "0.85 mm/N at 1 N with one harmonic, whose error is not tested" in sentence
    assert "0.35 mm/N at 10 N with 5 harmonics, whose error is not tested" in sentence


def test_harmonics_of_a_table_are_those_of_its_branches():
    joint = make_joint()
    response = solve_response(joint, [1.0, 10.0], damping=0.01)
    found = add_converged_peaks(response, converge_peaks(joint, response))
    # no motion with further harmonics is found at the second force
    for name in ("frequency_converged", "amplitude_converged", "harmonics"):
        found[f"peak_{name}"][1] = np.nan
    table = tabulate_accuracy({(*REFERENCE, 1): found}, {})
    peaks = peaks_of_reference(table, 1)
    assert found["peak_harmonics"][0] > 1
    assert peaks[SOLVED, "harmonics"].tolist() == [1, 1]
    words = statement_of(table).replace("\u00a0", " ")
    assert "at 10 N with one harmonic, whose error is not tested" in words
    # of tables from before nobody knows
    assert statement_of(table.drop(columns="response_harmonics")).endswith("not tested.")


def test_bars_are_numbers_and_only_one_that_is_not_known_is_told_in_words():
    with_all = {"converged_peak_frequency_Hz": 75.18, "converged_peak_mm_per_N": 0.928}
    one_unknown = ROWS.assign(**with_all)
    both_known = one_unknown.ffill()
    for what in ("frequency", "response"):
        column = ALL, f"{what}_±_percent"
        assert peaks_of_coordinates(both_known)[column].dtype == float
        bars = peaks_of_coordinates(one_unknown)[column].tolist()
        assert [bar == NOT_TESTED for bar in bars] == [False, True]
        untested = both_known.assign(basis_amplitude_error_percent=None)
        assert peaks_of_coordinates(untested)[column].tolist() == [NOT_TESTED] * 2
    # told once of all, where no error of the basis is known
    sentence = statement_of(untested).replace("\u00a0", " ")
    assert sentence.endswith("0.928 mm/N at 10 N, in a basis whose error is not tested.")
    assert sentence.count("not tested") == 1
    of_one = "75.2 Hz and 0.928 mm/N at 10 N, whose error is not tested"
    assert peak_in_words(peaks_of_coordinates(one_unknown).iloc[1]) == of_one
    assert statement_of(one_unknown).replace("\u00a0", " ").count(of_one) == 1


def test_a_window_without_a_peak_is_no_branch_that_broke_off():
    none = peaks_of_coordinates(ROWS.assign(peak_mm_per_N=None, peak_frequency_Hz=None)).iloc[1]
    assert peak_in_words(none) == "none at 10 N: the window has none"
    assert peak_in_words(none, is_complete=False) == "none at 10 N: the branch broke off"


def test_contact_adapted_bases_come_first_and_the_largest_of_them():
    bases = [Basis(name) for name in ("free-16", "enriched-8", "all-4", "enriched-40")]
    assert by_trust(bases)[:2] == ["enriched-40", "enriched-8"]
