import re

import numpy as np
from page_examples import edit, figure, plain, write

from boltjoint.config.numerical_options import Solver
from boltjoint.report.pages.document import compressed_page


def test_a_figure_tells_its_number_in_the_source_and_its_errors(page):
    response = figure(page, "response_mine_free-4_node-to-node_linear_resonance=1")
    assert "Figure 3.9 of the source" in response
    assert "70.6 Hz and 1.5 mm/N at 0.001 N with one harmonic, whose error is not" in response
    reduced = figure(page, "response_mine_free-4_regions=6_elements=4_rdnm-1_resonance=1")
    assert "Figure 3.21 of the source" in reduced
    assert "20 % in amplitude (at 0.001 N)" in reduced
    assert "Broken off at 50 N: the branch would turn back." in reduced
    assert "of the source" not in figure(
        page, "response_mine_free-4_node-to-node_rdnm-1_resonance=2"
    )


def test_a_figure_of_several_in_the_source_tells_all_their_numbers(artefacts):
    states = "states_mine_free-4_node-to-node_linear_resonance=1"
    page = write(artefacts, published="three_bolt_variable")
    assert "Figures 3.46 to 3.51 of the source" in figure(page, states)
    assert "of the source" not in figure(write(artefacts), states)


def with_all_harmonics(frame, estimate=2.37):
    """The table of accuracy with converged peaks; in a basis whose error is estimated, or not."""
    return frame.assign(
        converged_peak_frequency_Hz=70.5,
        converged_frequency_error_bar_percent=0.04,
        converged_peak_mm_per_N=1.2,
        converged_amplitude_error_bar_percent=2.9,
        basis_amplitude_error_percent=estimate,
    )


def test_the_first_number_is_the_converged_one_with_its_bar(artefacts):
    edit("accuracy", with_all_harmonics)
    page = plain(write(artefacts))
    lead = plain(re.search("<h1>.*?<section", page, re.DOTALL)[0])
    assert "With the structure as modelled, whose error is not tested, resonance 1" in lead
    assert "lies at 102 Hz while the contact sticks and at 70.6 Hz without" in lead
    assert "70.5 Hz (± 0.04 %) and 1.2 mm/N (± 2.9 %) at 0.001 N; 70.5 Hz (±" in lead
    # the first table has it too, and what one harmonic leaves out beside it
    first = plain(re.sub("<.*?>", " ", page.split("<table")[1]))
    assert "70.50 0.04 1.2 2.9 70.61 1.5 25" in first
    assert page.index("estimated to be off by up to 2.4 %") < page.index("Configuration")
    # but for the mesh
    assert page.count("not tested") == 1 and "converged_peaks: true" not in page
    assert "of its length at the peak" not in page and "yield strength" not in page
    share = {"displacement_over_length_percent": [0.01, 91.3] * 6}
    edit("accuracy", lambda frame: frame.assign(**share))
    page = plain(write(artefacts))
    assert "At 50 N the structure moves by 91 % of its length at the peak" in page
    first = page.split("<table")[1].split("</table>")[0]
    assert re.findall('<tr class="marked"><td class="number first">([^<]*)', first) == ["50"]
    assert "Rows that are marked are beyond a limit" in page
    assert "of the yield strength" not in page and "355 MPa" not in page
    shares = {
        "slip_over_clearance_percent": [9.0] * 12,
        "stress_over_strength_percent": [131.0] * 12,
    }
    edit("accuracy", lambda frame: frame.assign(**shares))
    page = plain(write(artefacts))
    assert "the nominal stress reaches 131 % of the yield strength" in page and "355 MPa" in page
    # of several forces the farthest is told, and then the others
    edit("accuracy", lambda frame: frame.assign(displacement_over_length_percent=[30.0, 91.3] * 6))
    page = plain(write(artefacts))
    assert "At 50 N the structure moves by 91 % of its length" in page
    assert "those of small displacements; the same holds at 0.001 N." in page
    assert "bodies slip at a bolt" not in page
    edit("accuracy", lambda frame: with_all_harmonics(frame, np.nan))
    page = plain(write(artefacts))
    assert "The error of the basis free-4 is not tested" in page
    # a bar without the basis would say too little
    assert "70.5 Hz and 1.2 mm/N at 0.001 N" in page and "±\u00a0" not in page and "(± " not in page
    of_responses = page.split("Errors of every response")[1].split("</table>")[0]
    assert "±" in of_responses and "not tested" in of_responses and "2.9" not in of_responses


def test_a_study_without_converged_peaks_claims_none(artefacts):
    page = plain(write(artefacts))
    assert "70.6 Hz and 1.5 mm/N at 0.001 N with one harmonic, whose error is not" in page
    assert "Peaks with all harmonics and error bars are not computed" in page
    assert "converged in" not in page and "±" not in page


def test_published_times_stand_beside_ours(page):
    nodes = figure(page, "table-3.3-free-4")
    assert "0.001 0.3 685.3 0.3 295.8 40.00 56.84" in nodes
    regions = figure(page, "table-3.4-free-4")
    assert "50 40.00 99.74 40.00 99.90" in regions


def test_sums_of_slip_forces_stand_beside_each_other(page):
    elements = figure(page, "table-3.5-free-4")
    assert "3 kN/mm here, 4 kN/mm in the source (-25 %)" in elements
    assert "slip forces are 300 N here and 700 N in the source; they agree by construction" in (
        elements
    )


def test_facts_stand_beside_those_of_the_source(page):
    facts = figure(page, "case-table")
    assert "preload per bolt (N) 37976 10000" in facts
    assert "friction elements, node to node 1178 1183" in facts
    assert "loss factor 0.002 not given" in facts
    assert "add up to what 37976 N per bolt would give" in plain(page)


def test_another_joint_than_that_of_the_source_is_told(artefacts, page):
    told = "another joint than that of the source"
    assert "preload per bolt (N) is 37976, 10000 in the source. Values of" in plain(
        re.sub("<.*?>", "", page)
    )
    assert told in page and told not in write(artefacts, preload_N=10000)
    assert told not in write(artefacts, published=None)


def test_a_stiffness_per_area_is_told_as_such(artefacts, page):
    assert "tangential stiffness of a pair (kN/mm) 100 100 friction" in figure(page, "case-table")
    contact = {
        "law": "variable",
        "tangential_stiffness_N_per_m3": 6.8e13,
        "normal_stiffness_N_per_m": 5e7,
        "friction_coefficient": 0.2,
        "surfaces": [
            {"name": "lap", "friction_coefficient": 0.3, "normal_stiffness_N_per_m3": 1e13}
        ],
    }
    facts = figure(write(artefacts, contact=contact), "case-table")
    assert "lap: friction coefficient 0.3" in facts
    assert "lap: normal stiffness per area (N/m³) 1 × 10¹³" in facts
    assert "tangential stiffness per area (N/m³) 6.8 × 10¹³ not given friction" in facts
    assert "normal stiffness of a pair (kN/mm) 50" in facts


def test_facts_tell_how_friction_is_solved(artefacts):
    exact = write(artefacts)
    assert "friction forces closed form (analytic) – harmonics of the response 1" in figure(
        exact, "case-table"
    )
    assert "time samples per period" not in exact
    assert "first-harmonic" not in exact
    sampled = write(artefacts, Solver(friction_force="aft", harmonics=3, time_samples=128))
    facts = figure(sampled, "case-table")
    assert "friction forces AFT, sampled in time – harmonics of the response 3" in facts
    assert "time samples per period 128" in facts
    assert "those of its first-harmonic amplitude" in plain(sampled)
    chosen = write(artefacts, Solver(friction_force="aft", harmonics="auto"))
    facts = figure(chosen, "case-table")
    assert "harmonics of the response as many as change a peak by less than 0.5 %" in facts
    assert "as many harmonics as its peak needs" in plain(chosen)


def test_regions_whose_number_a_tolerance_decides_stand_after_numbers(artefacts):
    joints = ["node-to-node", "regions=auto", "regions=12", "regions=6"]
    facts = figure(write(artefacts, solve=[{"resonance": 1, "joints": joints}]), "case-table")
    assert "regions 6, 12, auto" in facts


def test_folds_wrong_peaks_and_replaced_responses_are_named(artefacts):
    def doubt(frame):
        rdnm = frame["coordinates"] == "rdnm-1"
        estimate = np.where(rdnm & (frame["force_N"] == 50), 832.0, 0.7)
        instead = rdnm & (frame["force_N"] == 0.001)
        wrong = rdnm & (frame["force_N"] == 50)
        errors = {
            "estimated_peak_error_percent": estimate,
            "estimated_largest_error_percent": 2 * estimate,
        }
        isolated = np.where(wrong, True, None)
        return frame.assign(**errors, wrong=wrong, fell_back=instead, isolated_branch=isolated)

    edit("accuracy", doubt)
    page = write(artefacts)
    of_regions = figure(page, "response_mine_free-4_regions=6_linear_resonance=1")
    assert (
        "There are several solutions at the same frequency: at 50 N between 71.25 and 72.50 Hz "
        "(2 turning points). Sweeps with rising and with falling frequency follow different ones. "
        "At 50 N motions with 15 harmonics are unstable, where the line is broken, with Floquet "
        "multipliers up to 1.25. There are several such motions between 71.50 and 72.75 Hz at 50 N."
    ) in of_regions
    assert "isolated branch" not in of_regions
    in_one_mode = figure(page, "response_mine_free-4_node-to-node_rdnm-1_resonance=1")
    assert "several solutions" not in in_one_mode
    assert "The response to 50 N is wrong" in in_one_mode
    assert "At 50 N there is an isolated branch too, with a higher peak" in in_one_mode
    assert "is up to 1664 % of the peak, and up to 832 % at the peak." in in_one_mode
    assert "At 0.001 N it is replaced by the response in linear modes." in in_one_mode
    assert "is wrong" not in of_regions


def test_folds_without_unstable_solutions_are_named(artefacts):
    edit("accuracy", lambda frame: frame.assign(largest_multiplier=0.9 * (frame["force_N"] == 50)))
    of_regions = figure(write(artefacts), "response_mine_free-4_regions=6_linear_resonance=1")
    assert "At 50 N no motions with 15 harmonics are unstable." in of_regions
    assert "are unstable, where" not in of_regions


def test_stability_of_one_harmonic_is_named(artefacts):
    edit("accuracy", lambda frame: frame.assign(stability_harmonics=(frame["force_N"] == 50) * 1))
    of_regions = figure(write(artefacts), "response_mine_free-4_regions=6_linear_resonance=1")
    assert "At 50 N motions with one harmonic are unstable, where the line is broken" in of_regions
    assert "several such motions" not in of_regions


def test_what_comes_from_results_is_escaped(artefacts):
    hostile = "<script>alert(1)</script>"

    def attack(frame):
        return frame.assign(reason=np.where(frame["complete"], None, hostile))

    edit("accuracy", attack)
    page = write(artefacts)
    assert hostile not in page
    # in the verdict and in the table
    assert page.count("&lt;script&gt;alert(1)&lt;/script&gt;") >= 2


def test_what_no_section_expects_is_shown_at_the_end(page):
    assert page.index('id="times-free-4"') < page.index('<section id="bases">')
    assert page.index('<section id="bases">') < page.index('id="bases_mine_free-4"')


def test_what_a_case_lacks_is_left_out(artefacts):
    some = [each for each in artefacts if each.kind != "times" and "regions=6" not in each.path]
    page = write(some, published=None)
    assert 'id="times-free-4"' not in page
    assert "in the source" not in page
    assert 'id="response_mine_free-4_node-to-node_linear_resonance=1"' in page


def test_the_same_files_give_the_same_page(artefacts):
    assert write(artefacts) == write(artefacts)
    assert compressed_page(write(artefacts)) == compressed_page(write(artefacts))
