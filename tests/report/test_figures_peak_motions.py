"""Time history and spectrum of the motion at the peaks of responses with several harmonics."""

from dataclasses import replace

import numpy as np
import pytest
from figure_parts import curves, legend_texts, texts_in
from harmonic_names import parse_component
from page_examples import figure, save, write
from small_joint import make_joint
from small_study import CASE, write_config

from boltjoint.config.study import load_study
from boltjoint.dynamics.balance.periodic_motion import motion_at_peak
from boltjoint.dynamics.response.converged_peaks import converge_peaks, find_converged_peak
from boltjoint.dynamics.response.error_bars import add_converged_peaks
from boltjoint.dynamics.response.frequency_response import solve_response
from boltjoint.friction.aft import AlternatingFrequencyTime
from boltjoint.names import REFERENCE, Basis
from boltjoint.report.displays import DISPLAYS
from boltjoint.report.figures.peak_motions import plot_peak_motions
from boltjoint.report.figures.style import save_figure
from boltjoint.study.artefact_list import Artefact, Contents

LEVELS = [0.01, 5.0]
AFT = {"friction_force": "aft", "harmonics": 3}
AUTO = {"solver": AFT | {"harmonics": "auto"}, "omit": ["timing"]}


def solve(law, harmonics=3):
    """A joint of few elements, and its response in several harmonics."""
    joint = make_joint(12, law=law)
    sampled = AlternatingFrequencyTime(joint.law, harmonics, samples=64)
    return joint, solve_response(replace(joint, law=sampled), LEVELS, damping=0.01)


@pytest.fixture(scope="module", params=["constant", "variable"])
def solved(request):
    return solve(request.param)


@pytest.fixture(scope="module")
def under_variable_load():
    return solve("variable")


def coefficients_at_peak(joint, response, level):
    """Sine and cosine coefficient of the output point by harmonic [m], its mean as a cosine."""
    motion = motion_at_peak(response, level)[1]
    displacement = motion.modal_coordinate @ joint.response_mode
    found = np.zeros((4, 2))
    for name, value in zip(motion.components, displacement, strict=True):
        part, number = parse_component(name)
        found[number, 0 if part == "sin" else 1] = value
    return found


def test_curves_are_those_of_the_motions_at_the_peaks(solved):
    joint, response = solved
    history, spectrum = plot_peak_motions(response, joint.response_mode).axes
    in_time, by_harmonic = curves(history), curves(spectrum)
    assert list(in_time) == list(by_harmonic) == ["0.01 N", "5 N"]
    for level, name in zip(LEVELS, in_time, strict=True):
        found = coefficients_at_peak(joint, response, level)
        amplitude = np.hypot(*found.T)
        phase = 2 * np.pi * np.outer(np.arange(4), in_time[name][:, 0])
        displacement = found[:, 0] @ np.sin(phase) + found[:, 1] @ np.cos(phase)
        np.testing.assert_allclose(in_time[name][:, 1], displacement / amplitude[1], atol=1e-12)
        np.testing.assert_array_equal(in_time[name][[0, -1], 0], [0, 1])
        there = np.flatnonzero(amplitude)
        expected = np.c_[there, amplitude[there] / amplitude[1]]
        np.testing.assert_allclose(by_harmonic[name], expected, rtol=1e-12)


def test_only_what_moves_under_variable_load_has_a_mean_and_even_harmonics(solved):
    joint, response = solved
    spectrum = plot_peak_motions(response, joint.response_mode).axes[1]
    numbers = [1, 3] if "cos2" not in response["component"] else [0, 1, 2, 3]
    for curve in curves(spectrum).values():
        np.testing.assert_array_equal(curve[:, 0], numbers)


def test_axes_and_legend_tell_amplitudes_and_frequencies(under_variable_load):
    joint, response = under_variable_load
    history, spectrum = plot_peak_motions(response, joint.response_mode).axes
    assert history.get_xlabel() == "time / period of the excitation"
    assert spectrum.get_xlabel() == "harmonic"
    assert (history.get_yscale(), spectrum.get_yscale()) == ("linear", "log")
    frequency, amplitude = (
        response[f"peak_{name}"].to_numpy()[1] for name in ("frequency", "amplitude")
    )
    assert f"5 N\n{frequency:.1f} Hz, {1e3 * amplitude:.3g} mm" in legend_texts(history)


def test_harmonics_of_rounding_are_out_of_view(under_variable_load):
    joint, response = under_variable_load
    vanishing = response.copy(deep=True)
    vanishing["modal_coordinate"].loc[{"component": ["sin2", "cos2"]}] *= 1e-12
    spectrum = plot_peak_motions(vanishing, joint.response_mode).axes[1]
    assert spectrum.get_ylim()[0] == pytest.approx(1e-8)


def test_a_level_without_a_peak_is_named_and_not_drawn(under_variable_load):
    joint, response = under_variable_load
    lost = response.copy(deep=True)
    lost["peak_frequency"][1], lost["peak_amplitude"][1] = np.nan, np.nan
    history, spectrum = plot_peak_motions(lost, joint.response_mode).axes
    assert list(curves(history)) == list(curves(spectrum)) == ["0.01 N"]
    assert "5 N\nno such peak found" in legend_texts(history)


def test_a_response_without_peaks_has_a_figure_that_says_so(under_variable_load, tmp_path):
    joint, response = under_variable_load
    nan = np.nan * response["peak_frequency"]
    lost = response.assign(converged=0 * response["converged"], peak_frequency=nan)
    made = plot_peak_motions(lost, joint.response_mode)
    save_figure(made, tmp_path / "peak_motions.svg")
    assert texts_in(made) == ["no results"]
    assert "5 N\nno such peak found" in legend_texts(made.axes[0])


def test_motions_of_one_harmonic_are_not_drawn():
    for law in ("constant", "variable"):
        joint, response = solve(law, harmonics=1)
        made = plot_peak_motions(response, joint.response_mode)
        assert curves(made.axes[0]) == curves(made.axes[1]) == {}
        assert "5 N\nno such peak found" in legend_texts(made.axes[0])


@pytest.mark.parametrize("law", ["constant", "variable"])
def test_peaks_with_all_harmonics_come_first(law):
    joint = make_joint(12, law=law)
    response = solve_response(joint, LEVELS, damping=0.01)
    found = add_converged_peaks(response, converge_peaks(joint, response))
    history, spectrum = plot_peak_motions(found, joint.response_mode).axes
    for place, (level, name) in enumerate(zip(LEVELS, curves(history), strict=True)):
        peak = find_converged_peak(
            joint, *motion_at_peak(response, level), level, 0.01
        ).sequence.peaks[-1]
        in_time = peak.motion.in_time(512) @ joint.response_mode / peak.amplitude
        np.testing.assert_allclose(curves(history)[name][:-1, 1], in_time, atol=1e-12)
        assert (
            f"{peak.frequency:.1f} Hz, {1e3 * peak.amplitude:.3g} mm"
            in legend_texts(history)[-len(LEVELS) + place]
        )
        assert curves(spectrum)[name][-1, 0] > 2


def test_a_case_without_converged_peaks_stores_no_motion():
    joint = make_joint(12)
    response = solve_response(joint, LEVELS, damping=0.01)
    lost = response.assign(peak_frequency=np.nan * response["peak_frequency"])
    assert "peak_motion_converged" not in converge_peaks(joint, lost)


@pytest.mark.parametrize(
    ("changes", "resonances"),
    [
        ({"converged_peaks": False}, []),
        ({"solver": AFT | {"harmonics": 1}, "converged_peaks": False}, []),
        ({}, [1, 2]),
        ({"solver": AFT, "converged_peaks": False}, [1, 2]),
        (AUTO, [1, 2]),
    ],
)
def test_studies_with_several_harmonics_have_a_figure_for_each_resonance(
    tmp_path, changes, resonances
):
    blocks = [{"resonance": at, "joints": ["node-to-node", "regions=2"]} for at in (1, 2)]
    write_config(tmp_path, {"small": CASE | {"solve": blocks}})
    study = load_study(tmp_path, {"sweeps": [], "converged_peaks": True} | changes)
    contents = Contents(study, DISPLAYS)
    found = contents.select("peak_motions")
    assert [artefact.resonance for artefact in found] == resonances
    assert all((artefact.joint, artefact.coordinates) == REFERENCE for artefact in found)
    files = {path for path in contents.files() if path.endswith(".nc")}
    for artefact in found:
        display = DISPLAYS.of(artefact)
        read = [each for reads in display.reads for each in reads(contents, artefact)]
        assert [each.kind for each in read] == ["joint", "response"]
        assert {each.path for each in read} <= files
        assert display.title_of(artefact).endswith(
            f"around resonance {artefact.resonance} in free-2"
        )


def test_the_page_of_a_case_shows_them_after_its_responses(artefacts):
    solved = {"joint": REFERENCE[0], "coordinates": REFERENCE[1], "resonance": 1}
    of_bases = [
        Artefact("peak_motions", "figure", case="mine", basis=Basis(name), **solved)
        for name in ("free-4", "free-2")
    ]
    page = write([*artefacts, *map(save, of_bases)], modes=["free-4", "free-2"])
    sections = [page.index(f'<section id="{anchor}">') for anchor in ("answer", "motion", "case")]
    first, other = (
        page.index(f'id="peak_motions_mine_{basis}_node-to-node_linear_resonance=1"')
        for basis in ("free-4", "free-2")
    )
    assert sections[1] < first < sections[2] < page.index('<section id="motion-free-2">') < other
    anchor = "peak_motions_mine_free-4_node-to-node_linear_resonance=1"
    assert "over one period, from phase 0 of the excitation" in figure(page, anchor)
    assert 'id="motion' not in write(artefacts)
