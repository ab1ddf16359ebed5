"""Calibration of a case: joints with other values, the dataset, the tables and the fitted case."""

import numpy as np
import pytest
from measured_bar import (
    CASE,
    FILE,
    FRICTION,
    MEASURED,
    MODEL,
    TRUTH,
    backbone,
    calibration_of_truth,
    case_with,
    content_of,
    fitted,
    written,
)
from small_joint import make_joint

from boltjoint import solve_branch
from boltjoint.config.case import Case
from boltjoint.config.measured import Measured
from boltjoint.config.strict_yaml import parse_mapping
from boltjoint.study.calibration_of_case import calibrate
from boltjoint.study.fitted_case import fitted_case
from boltjoint.study.tables.calibration import (
    tabulate_correlation,
    tabulate_parameters,
    tabulate_posterior,
    tabulate_residuals,
)


@pytest.fixture
def calibration():
    return calibration_of_truth()


def test_parameters_of_a_simulated_backbone_lie_in_their_intervals(calibration):
    assert (calibration["is_determined"] == 1).all()
    for name, value in TRUTH.items():
        found = calibration.sel(parameter=name)
        assert found["interval_low"] < value < found["interval_high"]
        assert found["interval_high"] < 1.2 * value
        # what the data tell well is told alike by covariance, profile and posterior
        width = float(found["interval_high"] - found["interval_low"])
        profile = float(found["profile_high"] - found["profile_low"])
        assert profile == pytest.approx(width, rel=0.1)
        drawn = np.quantile(found["draws"], [0.025, 0.975])
        assert np.ptp(drawn) == pytest.approx(width, rel=0.25)
    assert calibration.attrs["pareto_k"] < 0.7 and calibration.attrs["effective_draws"] > 60
    posterior = tabulate_posterior(calibration).set_index("parameter")
    assert (posterior["2.5_%"] < posterior["97.5_%"]).all() and list(posterior.index) == list(TRUTH)
    # numbers that do not stand for the posterior are none
    poor = tabulate_posterior(calibration.assign_attrs(pareto_k=0.71))
    assert poor[["2.5_%", "median", "97.5_%"]].isna().all(axis=None)
    assert (poor["pareto_k"] == 0.71).all()
    assert calibration.attrs["p_value"] > 0.01
    assert calibration.attrs["refusals"] == ""
    # both starts meet in one minimum
    cost = calibration["cost"].to_numpy()
    assert np.ptp(cost) < 1e-6 * cost.min()


def test_the_answer_has_values_intervals_and_errors(calibration):
    said = calibration.attrs["answer"]
    assert said.startswith("Fitted to 20 measured points: ")
    first = said.partition(" (95 % intervals)")[0]
    assert first.count(" to ") == 4
    assert all(name in first for name in TRUTH)
    assert "% in frequency and" in said
    assert said.endswith("Nothing in the residuals speaks against the model.")


def test_a_model_that_cannot_be_right_says_so_first():
    f, z = backbone(TRUTH)
    # a joint that stiffens again
    stiffening = np.append(f[:12], f[11] + np.linspace(0.2, 3, 8)), z
    found = fitted(case_with(starts=1), written(stiffening))
    said = found.attrs["answer"]
    assert said.startswith("The model cannot be right: ")
    assert "the frequency rises by" in said
    assert "friction only softens a joint" in said
    assert "Nothing in the residuals" not in said
    assert (tabulate_residuals(found)["over_stated_scatter"] > 3).any()


def test_parameters_that_go_together_are_not_told():
    # only the product of preload and friction is in a limit of friction
    together = MEASURED["parameters"] | {"preload_N": {"low": 500, "high": 2000}}
    case = case_with(parameters=together, starts=1)
    found = fitted(case, written(backbone(TRUTH), seed=1))
    table = tabulate_parameters(found).set_index("parameter")
    assert "preload_N" in table.index[table["not_determined"] != ""]
    assert np.isnan(table.loc["preload_N", ["fitted", "95_%_from", "95_%_to"]].astype(float)).all()
    # its profile does not close within the bounds
    assert table.loc["preload_N", ["profile_from", "profile_to"]].tolist() == pytest.approx(
        [500, 2000]
    )
    assert table.loc["loss_factor", "not_determined"] == ""
    told = found.attrs["answer"].partition(" Cannot be told: ")[2]
    assert "preload_N (its 95 % interval " in told
    correlation = tabulate_correlation(found).set_index("parameter")
    assert correlation.loc["preload_N", FRICTION] < -0.99


def test_what_is_known_beforehand_tells_parameters_that_go_together():
    of_torque = {"mean": 1000, "standard_deviation": 0.1}
    preload = {"low": 500, "high": 2000, "prior": of_torque}
    case = case_with(parameters=MEASURED["parameters"] | {"preload_N": preload}, starts=1)
    found = fitted(case, written(backbone(TRUTH), seed=1))
    table = tabulate_parameters(found).set_index("parameter")
    assert (table["not_determined"] == "").all()
    # the measurement adds nothing to it, and both parameters have its scatter
    for name, value in (("preload_N", 1000), (FRICTION, TRUTH[FRICTION])):
        low, high = table.loc[name, ["95_%_from", "95_%_to"]]
        assert low < value < high
        assert np.log(high / low) == pytest.approx(4 * 0.1, rel=0.05)
    assert table.loc["preload_N", ["prior_mean", "prior_deviation"]].tolist() == [1000, 0.1]
    assert np.isnan(table.loc[FRICTION, "prior_mean"])


def test_values_of_the_case_leave_its_joint_as_it_is():
    joint, damping = MODEL({name: MODEL.value(name) for name in (*TRUTH, "preload_N")})
    own = make_joint()
    for name in own.law.quantities:
        assert joint.law.quantity(name) == pytest.approx(own.law.quantity(name), rel=1e-12)
    # the default of a case that says nothing of damping
    assert damping.loss_factor == 0.002
    assert MODEL.value("frequency_ratio") == MODEL.value("amplitude_scale[mode-1]") == 1


def test_ratios_of_frequencies_and_regions():
    key = "joint.regions[{}].{}".format
    values = {
        "frequency_ratio": 1.1,
        key(0, "tangential_stiffness"): 2.0,
        key(3, "friction_coefficient"): 0.5,
        FRICTION: 0.2,
    }
    joint, _ = MODEL(values)
    own = make_joint()
    assert joint.natural_frequency == pytest.approx(1.1 * own.natural_frequency)
    stiffness = joint.law.tangential_stiffness / own.law.tangential_stiffness
    assert stiffness[0] == pytest.approx(2)
    assert stiffness[1:] == pytest.approx(np.ones(59))
    limit = joint.law.slip_force / own.law.slip_force
    # friction of all pairs is twice that of before
    assert limit[3] == pytest.approx(1)
    assert np.delete(limit, 3) == pytest.approx(2 * np.ones(59))


def test_a_mode_at_another_frequency_is_refused():
    f, z = backbone(TRUTH)
    with pytest.raises(
        ValueError, match=r"mode-1: mode at .* Hz is not in the model, whose mode 1"
    ):
        fitted(case_with(), written((10 * f, z)))


def test_the_fitted_case_is_a_case_with_fitted_values(calibration):
    case = Case.model_validate(case_with())
    text = fitted_case("bar", case.model_dump(mode="json", exclude_unset=True), calibration)
    content = parse_mapping(text)
    fitted = Case.model_validate(content)
    assert fitted.measured is None
    assert fitted.contact.friction_coefficient == pytest.approx(
        float(calibration["value"].sel(parameter=FRICTION)), rel=1e-5
    )
    assert fitted.loss_factor == pytest.approx(
        float(calibration["value"].sel(parameter="loss_factor")), rel=1e-5
    )
    rest = {key: content[key] for key in ("assembly", "preload_N", "forces_N", "modes", "solve")}
    assert rest == {key: CASE[key] for key in rest}
    assert text.startswith("# bar, fitted to its measurement.\n# ")


def test_ratios_stand_in_the_comments_of_the_fitted_case(calibration):
    renamed = calibration.assign_coords(
        parameter=["frequency_ratio", "amplitude_scale", "loss_factor"]
    )
    case = Case.model_validate(case_with())
    text = fitted_case("bar", case.model_dump(mode="json", exclude_unset=True), renamed)
    assert "is no key of a case: it is not in this file." in text
    content = parse_mapping(text)
    assert content["contact"] == CASE["contact"]
    assert not {"frequency_ratio", "amplitude_scale"} & set(content)


def test_profiles_and_draws_are_those_of_a_loss_that_leaves_outliers_aside():
    f, z = backbone(TRUTH)
    z = z.copy()
    z[[3, 12]] *= 1.5
    found = fitted(case_with(loss="soft_l1", starts=1), written((f, z), seed=2))
    for name in TRUTH:
        one = found.sel(parameter=name)
        assert one["profile_low"] < one["value"] < one["profile_high"]
        low, high = np.quantile(one["draws"], [0.005, 0.995])
        assert low < one["value"] < high
        width = float(one["interval_high"] - one["interval_low"])
        assert float(one["profile_high"] - one["profile_low"]) < 4 * width


def test_a_fit_that_leaves_no_draws_within_its_bounds_has_an_answer():
    narrow = {
        "preload_N": {"low": 990, "high": 1010},
        "amplitude_scale": {"low": 0.99, "high": 1.01},
    }
    case = case_with(parameters=MEASURED["parameters"] | narrow, starts=1)
    found = fitted(case, written(backbone(TRUTH), seed=1))
    assert " Cannot be told: preload_N (" in found.attrs["answer"]
    posterior = tabulate_posterior(found)
    assert len(posterior) == len(found["parameter"])


def stepped_sine(values, force, **changes):
    """The file of a response of the joint with other parameters."""
    joint, damping = MODEL(values)
    branch = solve_branch(joint, force, damping=damping)
    every = slice(None, None, max(1, branch.frequency.size // 25))
    pairs = zip(branch.frequency[every], 1e3 * branch.amplitude[every], strict=True)
    rows = [f"{f:.17g},{a:.17g},{force}" for f, a in pairs]
    return "\n".join(["frequency_Hz,displacement_mm,force_N", *rows]) + "\n"


SINES = {"low": 1.0, "high": 12.0}
RESPONSES = [
    {"file": f"config/{name}.csv", "name": name, "excitation_error_percent": 1} for name in SINES
]


def test_stepped_sines_alone_give_back_the_parameters():
    measured = MEASURED | {"curves": [], "responses": RESPONSES, "starts": 3}
    texts = {f"config/{name}.csv": stepped_sine(TRUTH, force) for name, force in SINES.items()}
    case = CASE | {"measured": measured}
    found = calibrate(make_joint(), content_of(case), Measured.model_validate(measured), texts)
    for name, value in TRUTH.items():
        assert found["value"].sel(parameter=name) == pytest.approx(value, rel=1e-5)
    assert list(found["response"].to_numpy()) == list(SINES)
    assert found["model_excitation"].to_numpy() == pytest.approx(
        found["response_excitation"].to_numpy(), rel=1e-6
    )
    assert np.isnan(found["model_phase"]).all()
    points = found.sizes["response_point"]
    assert found.attrs["answer"].startswith(f"Fitted to {points} measured points: ")
    assert " % in excitation (low); " in found.attrs["answer"]
    assert found.sizes["curve"] == found.sizes["grid"] == 0
    residuals = tabulate_residuals(found)
    assert residuals["curve"].tolist() == list(SINES)
    assert residuals["quantity"].tolist() == ["excitation", "excitation"]
    assert residuals["resonance"].isna().all()
    assert residuals["points"].sum() == points
    assert (residuals["rms_error_percent"] < 1e-3).all()


def test_a_scale_of_amplitudes_goes_with_responses():
    parameters = MEASURED["parameters"] | {"amplitude_scale[high]": {"low": 0.5, "high": 2}}
    measured = {"responses": RESPONSES, "parameters": parameters, "starts": 3}
    texts = {f"config/{name}.csv": stepped_sine(TRUTH, force) for name, force in SINES.items()}
    content = content_of(CASE | {"measured": measured})
    found = calibrate(make_joint(), content, Measured.model_validate(measured), texts)
    assert found["value"].sel(parameter="amplitude_scale[high]") == pytest.approx(1.0, rel=1e-4)
    assert found["response_excitation"].attrs["units"] == "N"


def test_a_configuration_of_its_own_is_that_of_a_curve():
    """Both at once: the preload is halved in one test, and fitted in neither."""
    half = backbone(TRUTH | {"preload_N": 500.0})
    loose = MEASURED["curves"][0] | {
        "name": "loose",
        "file": "config/loose.csv",
        "configuration": {"preload_N": 500},
    }
    measured = MEASURED | {"curves": [MEASURED["curves"][0], loose], "starts": 1}
    texts = {FILE: written(backbone(TRUTH)), "config/loose.csv": written(half)}
    content = content_of(CASE | {"measured": measured})
    found = calibrate(make_joint(), content, Measured.model_validate(measured), texts)
    for name, value in TRUTH.items():
        assert found["value"].sel(parameter=name) == pytest.approx(value, rel=1e-4)
    assert found.attrs["refusals"] == ""
