import numpy as np
import pytest
import xarray as xr
from figure_parts import FORCES, curves, legend_texts, marks, texts_in
from small_joint import make_joint

from boltjoint.dynamics.backbone.backbone import find_backbone
from boltjoint.dynamics.response.frequency_response import solve_response
from boltjoint.dynamics.response.windows import frequency_window
from boltjoint.report.figures.backbones import plot_backbones
from boltjoint.report.figures.responses import plot_response
from boltjoint.report.figures.style import save_figure
from boltjoint.solvers.step_control import StepControl


def test_a_response_is_drawn_over_its_reference(response, reference):
    (axes,) = plot_response(response, "regions=3", "linear", reference).axes
    drawn = curves(axes)
    assert len(drawn) == 2 * len(FORCES)
    for name, solved in (("3 regions", response), ("node-to-node", reference)):
        for force in FORCES:
            mine = solved["excitation_force"].to_numpy() == force
            expected = [solved["frequency"], solved["response_amplitude"] * 1e3 / force]
            found = drawn[f"{name}, linear modes, {force:g} N"]
            np.testing.assert_allclose(found, np.stack(expected, axis=-1)[mine])
    assert axes.get_xlabel() == "frequency (Hz)"
    assert axes.get_ylabel() == "response / force (mm/N)"
    assert axes.get_yscale() == "log"
    texts = legend_texts(axes)
    assert texts[:2] == ["node-to-node, linear modes", "3 regions, linear modes"]
    assert texts[-3:] == ["0.01 N", "5 N", "20 N"]
    assert "branch breaks off" not in texts
    assert not marks(axes, "X")


def test_peaks_are_marked_and_in_view(response, reference):
    (axes,) = plot_response(response, "regions=3", "linear", reference).axes
    expected = [
        (frequency, 1e3 * amplitude / force)
        for solved in (reference, response)
        for frequency, amplitude, force in zip(
            *(solved[name].to_numpy() for name in ("peak_frequency", "peak_amplitude")),
            FORCES,
            strict=True,
        )
    ]
    np.testing.assert_allclose(marks(axes, "o"), expected)
    low, high = axes.get_xlim()
    assert all(low < frequency < high for frequency, _ in expected)


def test_only_what_is_near_a_peak_is_in_view():
    stuck = solve_response(make_joint(), [1e-4], damping=0.01)
    (axes,) = plot_response(stuck, "node-to-node", "linear").axes
    peak = stuck["peak_frequency"].item()
    low, high = axes.get_xlim()
    assert stuck["frequency"].min() < 0.9 * peak < low < peak < high
    # a sharp peak still has something on both sides
    assert low < 0.985 * peak


def test_a_level_has_one_colour_in_both_methods(response, reference):
    (axes,) = plot_response(response, "regions=3", "linear", reference).axes
    colours = {}
    for line in axes.get_lines():
        if not line.get_label().startswith("_"):
            level = line.get_label().rpartition(", ")[2]
            colours.setdefault(level, set()).add(tuple(line.get_color()))
    assert [len(found) for found in colours.values()] == [1, 1, 1]
    assert len(set.union(*colours.values())) == 3


def test_a_broken_branch_ends_in_a_cross_and_is_named(regions, reference):
    short = StepControl(maximum_solutions=12)
    broken = solve_response(regions, FORCES, damping=0.01, control=short)
    (axes,) = plot_response(broken, "regions=3", "linear", reference).axes
    crosses = marks(axes, "X")
    assert len(crosses) == len(FORCES)
    for force, cross in zip(FORCES, crosses, strict=True):
        np.testing.assert_allclose(cross, curves(axes)[f"3 regions, linear modes, {force:g} N"][-1])
        assert axes.get_xlim()[0] <= cross[0] <= axes.get_xlim()[1]
    texts = legend_texts(axes)
    assert "branch breaks off" in texts
    assert f"5 N\nbreaks off at {crosses[1][0]:.1f} Hz" in texts


def test_what_did_not_converge_is_not_drawn_as_a_solution(reference):
    failed = reference.assign(
        converged=reference["converged"] * (reference["excitation_force"] != 5.0),
        complete=reference["complete"] * (reference["force_level"] != 5.0),
    )
    (axes,) = plot_response(failed, "node-to-node", "linear").axes
    assert len(curves(axes)["node-to-node, linear modes, 5 N"]) == 0
    assert "5 N\nno solution found" in legend_texts(axes)


@pytest.mark.parametrize(
    ("joint", "coordinates", "words"),
    [
        ("node-to-node", "linear", "node-to-node, linear modes"),
        ("regions=6", "rdnm-1", "6 regions, 1 RDNM"),
        ("clusters=auto", "complex-rdnm-2", "clusters to tolerance, 2 complex RDNM"),
        ("regions=6/table", "backbone", "6 regions, tabulated, backbone"),
        (
            "clusters=2/harmonic=3",
            "linear",
            "2 clusters of 3 elements, harmonic fit, linear modes",
        ),
    ],
)
def test_methods_are_named_in_words(reference, joint, coordinates, words):
    (axes,) = plot_response(reference, joint, coordinates).axes
    assert legend_texts(axes)[0] == words
    assert len(curves(axes)) == len(FORCES)


def test_response_and_reference_need_the_same_forces(response, reference):
    other = reference.assign(force_level=reference["force_level"] * 2)
    with pytest.raises(ValueError, match="different forces"):
        plot_response(response, "regions=3", "linear", other)


def without_solutions(response):
    """The same response, of which nothing was found."""
    lost = response.copy(deep=True)
    lost["complete"][:], lost["converged"][:] = 0, 0
    lost["peak_frequency"][:], lost["peak_amplitude"][:] = np.nan, np.nan
    return lost.isel(solution=slice(0))


@pytest.mark.parametrize("lost", ["nothing found", "one solution", "nothing converged"])
def test_a_response_that_failed_has_a_figure_that_says_so(regions, response, lost, tmp_path):
    if lost == "one solution":
        alone = StepControl(maximum_solutions=1)
        solved = solve_response(regions, FORCES, damping=0.01, control=alone)
        assert solved.sizes["solution"] == len(FORCES)
    elif lost == "nothing converged":
        solved = response.assign(converged=0 * response["converged"])
        solved = solved.assign(complete=0 * response["complete"])
    else:
        solved = without_solutions(response)
    figure = plot_response(solved, "regions=3", "linear")
    save_figure(figure, tmp_path / "response.svg")
    texts = legend_texts(figure.axes[0])
    if lost == "one solution":
        assert f"5 N\nbreaks off at {float(solved['frequency'][1]):.1f} Hz" in texts
        low, high = figure.axes[0].get_xlim()
        assert low < float(solved["frequency"][1]) < high
    else:
        assert "5 N\nno solution found" in texts
        assert texts_in(figure) == ["no results"]


@pytest.mark.parametrize(("harmonics", "of"), [(15, "15 harmonics"), (1, "one harmonic")])
def test_unstable_solutions_are_dashed(response, harmonics, of):
    folded = response.copy(deep=True)
    mine = np.flatnonzero(folded["excitation_force"] == 5.0)
    folded["stable"][mine[20:25]] = 0
    folded["stability_harmonics"][mine[18:27]] = harmonics
    (axes,) = plot_response(folded, "regions=3", "linear").axes
    solid = curves(axes)["3 regions, linear modes, 5 N"]
    assert np.isnan(solid[20:25, 1]).all()
    assert np.isfinite(np.delete(solid, slice(20, 25), axis=0)).all()
    (dashed,) = (line for line in axes.get_lines() if line.get_linestyle() == "--")
    shown = np.flatnonzero(np.isfinite(dashed.get_ydata()))
    # joined to the others
    np.testing.assert_array_equal(shown, np.arange(19, 26))
    assert f"unstable ({of})" in legend_texts(axes)
    # where stability was not found a line is solid
    assert (response["stable"] == -1).all()
    without = legend_texts(plot_response(response, "regions=3", "linear").axes[0])
    assert not any(text.startswith("unstable") for text in without)


def test_a_response_replaced_by_linear_modes_is_named(response):
    replaced = response.copy(deep=True)
    replaced["fell_back"][1] = 1
    (axes,) = plot_response(replaced, "node-to-node", "rdnm-1").axes
    assert "5 N\nreplaced by linear modes" in legend_texts(axes)


def test_isolated_branches_of_a_backbone_are_named():
    joint = make_joint()
    found = find_backbone(joint, [5.0], damping=0.01, window=frequency_window(joint))
    assert found.sizes["isola"] == 0
    rows = {"isolated_from": 12.567, "isolated_to": 12.614}
    named = found.drop_dims("isola").assign(
        {name: ("isola", [value], {"units": "N"}) for name, value in rows.items()}
    )
    figure = plot_backbones({"node-to-node": found, "regions=6": named}, [5.0])
    assert legend_texts(figure.axes[0]) == [
        "node-to-node",
        "6 regions\nisolated branch from 12.57 to 12.61 N",
    ]


def test_a_backbone_without_states_has_a_figure(tmp_path):
    joint = make_joint()
    found = find_backbone(joint, [5.0], damping=0.01, window=frequency_window(joint))
    for count in (0, 1):
        some = found.isel(state=slice(count))
        figure = plot_backbones({"node-to-node": some}, [5.0])
        save_figure(figure, tmp_path / "backbone.svg")
        assert texts_in(figure) == ["no results"] * (2 if count == 0 else 0)


def test_a_response_tells_where_the_model_ends(reference):
    far = reference.assign(peak_displacement_over_length=("force", [0.01, 0.05, 0.4]))
    (axes,) = plot_response(far, "node-to-node", "linear").axes
    assert any("the model ends" in text for text in legend_texts(axes))
    level, peak = float(far["force_level"][-1]), float(far["peak_amplitude"][-1])
    heights = [line.get_ydata() for line in axes.get_lines() if len(line.get_ydata()) == 2]
    limit = 1e3 * peak / level / 4
    assert any(np.allclose(each, limit, rtol=1e-9) for each in heights)
    (axes,) = plot_response(reference, "node-to-node", "linear").axes
    assert not any("the model ends" in text for text in legend_texts(axes))


def test_axes_of_backbones_end_beyond_the_model():
    amplitude = np.geomspace(1e-6, 1.0, 50)
    found = xr.Dataset(
        {
            "response_amplitude": ("state", amplitude),
            "natural_frequency": ("state", np.linspace(80.0, 70.0, 50)),
            "damping_ratio": ("state", np.full(50, 1e-3)),
            "peak_force": ("state", amplitude),
            "isolated_from": ("isola", [], {"units": "N"}),
            "isolated_to": ("isola", []),
        }
    )
    for axes in plot_backbones({"node-to-node": found}, [], 30.0).axes:
        assert axes.get_xlim()[1] == pytest.approx(90.0)
    for axes in plot_backbones({"node-to-node": found}, [], None).axes:
        assert axes.get_xlim()[1] > 1e3
