"""The mode of a joint over its amplitude: against closed forms, and against what it rebuilds."""

from dataclasses import replace

import numpy as np
import pytest
import xarray as xr
from scipy.optimize import root
from small_joint import make_joint

from boltjoint import dataset
from boltjoint.dynamics.backbone.backbone import (
    backbone_from_dataset,
    find_backbone,
    trace_backbone,
)
from boltjoint.dynamics.backbone.epmc import EPMCEquations
from boltjoint.dynamics.backbone.modal_synthesis import synthesise_response
from boltjoint.dynamics.balance.harmonic_balance import HarmonicBalance
from boltjoint.dynamics.response.complex_rdnm import ComplexRDNM
from boltjoint.dynamics.response.frequency_response import solve_branch, solve_response
from boltjoint.dynamics.response.synthesis import ModalSynthesis
from boltjoint.dynamics.response.windows import Resonance, frequency_window
from boltjoint.friction.constant import ConstantLoad
from boltjoint.joint.model import Joint
from boltjoint.solvers.newton import newton
from boltjoint.solvers.step_control import StepControl

LOSS = 0.01

#: so that a state is as good as rounding lets it be
EXACT = StepControl(tolerance=1e-12)


@pytest.fixture(params=["constant", "variable"])
def any_joint(request):
    return make_joint(law=request.param)


def with_one_mode(joint):
    normal = joint.normal_mode
    return replace(
        joint,
        natural_frequency=joint.natural_frequency[:1],
        excitation_mode=joint.excitation_mode[:1],
        response_mode=joint.response_mode[:1],
        tangential_mode=joint.tangential_mode[:, :1],
        normal_mode=None if normal is None else normal[:, :1],
    )


def mode_at(backbone, amplitude):
    """The mode at an amplitude within a backbone."""
    p, wanted = [state.log_amplitude for state in backbone.states], np.log(amplitude)
    after = np.searchsorted(p, wanted)
    first, second = backbone.states[after - 1 : after + 1]
    share = (wanted - first.log_amplitude) / (second.log_amplitude - first.log_amplitude)
    return backbone.solve_between(first, second, share)


K, SLIP = 1e5, 10.0
"""Stiffness [N/m] and slip force [N] of the element at the tip of the cantilever."""


def cantilever(modes):
    """Bending of a steel cantilever, 400 x 30 x 10 mm, with a friction element under its tip."""
    length, area, inertia, young, density = 0.4, 3e-4, 2.5e-9, 2.1e11, 7850.0
    # roots of cos(x) cosh(x) = -1; every mode has the tip displacement 2 / sqrt(mass)
    x = np.array([1.87510406871196, 4.69409113297417, 7.85475743823761])[:modes]
    frequency = x**2 / (2 * np.pi) * np.sqrt(young * inertia / (density * area * length**4))
    tip = 2 * (-1.0) ** np.arange(modes) / np.sqrt(density * area * length)
    at = np.array([[length, 0.0, 0.0]])
    law = ConstantLoad(np.array([0]), np.array([K]), np.array([SLIP]))
    return Joint(frequency, tip, tip, tip[None, :], at, law, at)


def solve_at_the_tip(joint, amplitudes, start):
    """Eigenvalues from the element's one displacement: 1 + D(A) r^T (L (1 + i eta) - lambda)^-1 r.

    With ``phi ~ (L (1 + i eta) - lambda)^-1 r`` and ``phi^H phi = 1``, A = a |r^T phi|.
    """
    r = joint.tangential_mode[0]
    L = (2 * np.pi * joint.natural_frequency) ** 2 * (1 + 1j * LOSS)

    def left(unknown, a):
        value = complex(*unknown) * start
        phi = r / (L - value)
        phi /= np.linalg.norm(phi)
        amplitude = a * abs(r @ phi)
        ratio = min(SLIP / (K * amplitude), 1.0)
        theta = np.arccos(1 - 2 * ratio)
        secant = K / np.pi * (theta - np.sin(theta) * np.cos(theta))
        secant += 4j * K / np.pi * ratio * (1 - ratio)
        zero = (L - value)[0] / start * (1 + secant * np.sum(r**2 / (L - value)))
        return [zero.real, zero.imag]

    unknown, found = [1.0, LOSS], []
    for a in amplitudes:
        solved = root(left, unknown, args=(a,), tol=1e-14)
        assert np.linalg.norm(solved.fun) < 1e-12
        unknown = solved.x
        found.append(complex(*unknown) * start)
    return np.array(found)


@pytest.mark.parametrize("modes", [1, 2, 3])
def test_cantilever_from_stick_to_slip(modes):
    joint = cantilever(modes)
    equations = EPMCEquations(joint, LOSS)
    slips_at = SLIP / K / abs(joint.tangential_mode[0] @ equations.stuck)
    backbone = trace_backbone(equations, (0.5 * slips_at, 2e4 * slips_at), EXACT)
    assert backbone.complete
    amplitude = np.array([state.amplitude for state in backbone.states])
    expected = solve_at_the_tip(joint, amplitude, equations.scale)
    frequency = np.array([state.frequency for state in backbone.states])
    damping = np.array([state.damping_ratio for state in backbone.states])
    np.testing.assert_allclose(frequency, np.sqrt(expected.real) / (2 * np.pi), rtol=1e-9)
    np.testing.assert_allclose(damping, expected.imag / (2 * expected.real), rtol=1e-9)
    # the amplitudes reach from where nothing slips to where the element hardly matters
    assert damping[0] < LOSS / 2 < 10 * LOSS < damping.max()
    assert frequency[-1] == pytest.approx(joint.natural_frequency[0], rel=1e-3)


def test_jacobian_and_parameter_derivative_equal_differences(any_joint):
    equations = EPMCEquations(any_joint, LOSS)
    random = np.random.default_rng(7)
    x = equations.start() + 0.3 * random.normal(size=equations.start().size)
    p = np.log(3e-5)
    state = any_joint.law.contact_state(equations.balance.motion(np.exp(p) * x[:-2]))
    assert np.unique(state).size > 1
    jacobian = equations.evaluate(x, p)[1]()

    def difference(dx, dp):
        ahead, behind = (equations.evaluate(x + s * dx, p + s * dp)[0] for s in (1e-5, -1e-5))
        return (ahead - behind) / 2e-5

    # second differences of a force that is smooth twice, relative to the stiffest entry
    tolerance = 1e-6 * np.abs(jacobian).max()
    for j, unit in enumerate(np.eye(x.size)):
        np.testing.assert_allclose(jacobian[:, j], difference(unit, 0.0), atol=tolerance)
    by_amplitude = equations.parameter_derivative(x, p)
    np.testing.assert_allclose(by_amplitude, difference(0.0 * x, 1.0), atol=tolerance)
    assert np.linalg.norm(by_amplitude) > 100 * tolerance


@pytest.mark.parametrize("resonance", [1, 2, 3])
def test_while_all_sticks_the_mode_is_that_of_the_stuck_structure(any_joint, resonance):
    equations = EPMCEquations(any_joint, LOSS, resonance)
    state = trace_backbone(equations, (1e-11, 2e-11), EXACT).states[0]
    L = np.diag((2 * np.pi * any_joint.natural_frequency) ** 2)
    stuck = L + any_joint.stuck_stiffness()
    values = np.linalg.eigvals(stuck + 1j * LOSS * L)
    expected = values[np.argsort(values.real)][resonance - 1]
    # at this amplitude nothing slips, opens or closes; what the corrector leaves is of this size
    assert state.eigenvalue == pytest.approx(expected, rel=1e-12)
    squared, vectors = np.linalg.eigh(stuck)
    squared, phi = squared[resonance - 1], vectors[:, resonance - 1]
    # without the second order of the loss factor
    assert state.frequency == pytest.approx(np.sqrt(squared) / (2 * np.pi), rel=LOSS**2)
    assert state.damping_ratio == pytest.approx(LOSS * phi @ L @ phi / squared / 2, rel=LOSS**2)


def test_when_all_slips_friction_is_a_constant_force(joint):
    """Im lambda a, beyond the structure's, goes to 4/pi times the slip forces on the free mode."""
    backbone = trace_backbone(EPMCEquations(joint, LOSS), (1e-4, 1e3))
    assert backbone.complete
    free = (2 * np.pi * joint.natural_frequency[0]) ** 2
    expected = 4 / np.pi * joint.law.slip_force @ abs(joint.tangential_mode[:, 0])
    last = backbone.states[-1]
    assert last.eigenvalue == pytest.approx(free * (1 + 1j * LOSS), rel=1e-6)
    errors = []
    for amplitude in (1.0, 10.0):
        state = mode_at(backbone, amplitude)
        errors.append(abs((state.eigenvalue.imag - LOSS * free) * amplitude / expected - 1))
    # the share mu N / (k A) of the stroke that sticks falls with the amplitude, and the error too
    assert errors[1] < 1e-5
    assert errors[0] / errors[1] == pytest.approx(10, rel=0.01)


def test_friction_dissipation_is_the_area_of_the_loop():
    """Of one element of amplitude A: 4 mu N (A - mu N / k), and nothing while it sticks."""
    joint = cantilever(2)
    found = find_backbone(joint, [0.5, 100.0], damping=LOSS, window=(40.0, 90.0))
    mode = found["mode_shape"].sel(part="real") + 1j * found["mode_shape"].sel(part="imaginary")
    amplitude = found["modal_amplitude"] * abs(mode.to_numpy() @ joint.tangential_mode[0])
    slipped = np.maximum(amplitude - SLIP / K, 0)
    assert (slipped == 0).any() and (slipped > SLIP / K).any()
    # rounding of the strain energy of the element
    np.testing.assert_allclose(
        found["friction_dissipation"], 4 * SLIP * slipped, rtol=1e-9, atol=1e-15 * SLIP**2 / K
    )


def test_dissipation_of_friction_and_structure_is_the_damping_of_the_mode(any_joint):
    found = find_backbone(any_joint, [0.01, 50.0], damping=LOSS, window=(60.0, 90.0))
    w, a = 2 * np.pi * found["natural_frequency"], found["modal_amplitude"]
    L = xr.DataArray((2 * np.pi * any_joint.natural_frequency) ** 2, dims="mode")
    structural = LOSS * (L * (found["mode_shape"] ** 2).sum("part")).sum("mode")
    total = 2 * found["damping_ratio"] * w**2
    expected = np.pi * a**2 * (total - structural)
    # the tolerance of the solver, on the residual over the stiffness of the stuck mode
    scale = np.pi * a**2 * w**2
    assert float(abs(found["friction_dissipation"] - expected).max() / scale.max()) < 1e-8
    assert float((abs(found["friction_dissipation"] - expected) / scale).max()) < 1e-6


def test_damping_is_what_is_lost_in_a_period(joint):
    """Im lambda is the loss over pi a^2 phi^H phi: loops of the elements, and the structure's."""
    backbone = trace_backbone(EPMCEquations(joint, LOSS), (1e-6, 1e-2), EXACT)
    k, slip = joint.law.tangential_stiffness, joint.law.slip_force
    L = (2 * np.pi * joint.natural_frequency) ** 2
    for state in backbone.states:
        q = state.amplitude * state.mode
        loops = 4 * slip @ np.maximum(abs(joint.tangential_mode @ q) - slip / k, 0)
        lost = loops + np.pi * LOSS * L @ abs(q) ** 2
        expected = lost / (np.pi * np.sum(abs(q) ** 2))
        # what the corrector leaves, 1e-12 of the eigenvalue, is 1e-9 of its smallest loss
        assert state.eigenvalue.imag == pytest.approx(expected, rel=1e-8)


def test_twice_the_load_and_the_amplitude_change_nothing(any_joint):
    law = any_joint.law
    if any_joint.normal_mode is None:
        twice = replace(law, slip_force=2 * law.slip_force)
    else:
        twice = replace(law, normal_load=2 * law.normal_load)
    one = trace_backbone(EPMCEquations(any_joint, LOSS), (1e-6, 1e-2), EXACT)
    other = trace_backbone(
        EPMCEquations(replace(any_joint, law=twice), LOSS), (2 * 1e-6, 2 * 1e-2), EXACT
    )
    for amplitude in np.geomspace(2e-6, 5e-3, 20):
        at_one, at_other = mode_at(one, amplitude), mode_at(other, 2 * amplitude)
        # what the corrector leaves, over the smallest damping ratio
        assert at_other.frequency == pytest.approx(at_one.frequency, rel=1e-9)
        assert at_other.damping_ratio == pytest.approx(at_one.damping_ratio, rel=1e-8)


@pytest.mark.parametrize("force", [0.5, 5.0, 50.0])
def test_with_one_mode_the_synthesised_response_solves_the_balance(any_joint, force):
    joint = with_one_mode(any_joint)
    response, full = (
        solve_branch(joint, force, method=coordinates, damping=LOSS, control=EXACT)
        for coordinates in ("backbone", "linear")
    )
    balance = HarmonicBalance(joint, LOSS, force)
    left = [
        np.linalg.norm(balance.residual(x, 2 * np.pi * f))
        for f, x in zip(response.frequency, response.modal_coordinate, strict=True)
    ]
    # what the corrector leaves, 1e-12 of the eigenvalue, over the loss that limits the response
    assert max(left) < 1e-9 * np.linalg.norm(balance.modal_force)
    assert response.amplitude[response.peak] == pytest.approx(full.amplitude[full.peak], rel=1e-10)
    # the maximum of the balance is located to 1e-6 of a step
    assert response.frequency[response.peak] == pytest.approx(full.frequency[full.peak], rel=1e-7)


@pytest.mark.parametrize(("force", "resonance"), [(0.5, 1), (2.0, 1), (10.0, 1), (50.0, 2)])
def test_with_more_modes_the_synthesised_response_is_near(any_joint, force, resonance):
    response, full = (
        solve_branch(any_joint, force, method=coordinates, damping=LOSS, resonance=resonance)
        for coordinates in ("backbone", "linear")
    )
    # the other modes see a contact that one mode alone makes slip, and do not act on it; where the
    # observed point moves most they move it too, which shifts a flat maximum more than it raises it
    peak = response.peak
    assert response.amplitude[peak] == pytest.approx(full.amplitude[full.peak], rel=2e-3)
    assert response.frequency[peak] == pytest.approx(full.frequency[full.peak], rel=1e-2)


def test_one_complex_mode_of_its_own_motion_is_that_of_the_backbone(any_joint):
    force = 5.0
    equations = EPMCEquations(any_joint, LOSS)
    backbone = trace_backbone(equations, (1e-6, 1e-3), EXACT)
    state = mode_at(backbone, 2e-5)
    excitation = any_joint.excitation_mode * force
    # a mode of the complex symmetric matrix is normalised without conjugate
    phi = state.mode / np.sqrt(state.mode @ state.mode)
    share = phi @ excitation
    distance = state.excited_distance(excitation)
    w = np.sqrt(state.eigenvalue.real + np.sqrt(distance**2 - state.eigenvalue.imag**2))
    y = share / (state.eigenvalue - w**2)
    assert np.linalg.norm(phi * y) == pytest.approx(state.amplitude, rel=1e-12)

    one = ComplexRDNM(HarmonicBalance(any_joint, LOSS, force), 1, quasi_static_correction=False)
    one.basis = phi[:, None], np.zeros(3, dtype=complex)
    x = np.concatenate([state.modal_coordinate[:-2].ravel(), [y.real, y.imag]])
    q = one.to_fixed(x)
    # of the corrector, and of eigenvectors next to eigenvalues that are well apart
    assert np.linalg.norm(one.evaluate(x, w)[0]) < 1e-9 * abs(share)
    one.update(q, w)
    np.testing.assert_allclose(one.basis[0][:, 0], phi, atol=1e-9)
    assert np.linalg.norm(one.evaluate(one.from_fixed(q), w)[0]) < 1e-9 * abs(share)


@pytest.mark.parametrize("force", [1e-3, 1.0, 30.0])
def test_the_window_is_covered_from_end_to_end(any_joint, force):
    window = frequency_window(any_joint)
    branch = solve_branch(any_joint, force, method="backbone", damping=LOSS)
    assert branch.complete
    assert branch.reason == ""
    assert (branch.frequency[0], branch.frequency[-1]) == pytest.approx(window, rel=1e-12)
    assert np.all(np.diff(branch.frequency) > 0)
    assert branch.located.sum() == 1
    assert branch.converged.all()


@pytest.mark.parametrize(
    ("shares", "reason"),
    [
        ((0.4, 0.5), "the backbone ends below the peak"),
        ((0.4, 5.0), "the backbone begins above the response at an end of the window"),
    ],
)
def test_a_response_that_the_backbone_does_not_cover_says_why(joint, shares, reason):
    force, window = 5.0, frequency_window(joint)
    equations = EPMCEquations(joint, LOSS)
    whole = synthesise_response(trace_backbone(equations, (1e-6, 1e-2)), force, window)
    assert whole.complete
    amplitude = np.linalg.norm(whole.modal_coordinate[whole.peak])
    part = synthesise_response(
        trace_backbone(equations, tuple(amplitude * s for s in shares)), force, window
    )
    assert not part.complete
    assert part.reason == reason
    assert (part.peak is None) == (shares[1] < 1)
    # a part of the window is covered, and no more is claimed
    assert window[0] < part.frequency[0] < part.frequency[-1] < window[1]


def test_without_structural_damping_friction_limits_the_response_or_the_reason_says_so(joint):
    slight = solve_branch(joint, 5.0, method="backbone", damping=1e-9)
    none = solve_branch(joint, 5.0, method="backbone", damping=0.0)
    assert none.complete
    assert none.amplitude[none.peak] == pytest.approx(slight.amplitude[slight.peak], rel=1e-4)

    sum_of_slip_forces = joint.law.slip_force.sum()
    slipping = solve_branch(joint, 10 * sum_of_slip_forces, method="backbone", damping=0.0)
    assert not slipping.complete
    assert slipping.peak is None
    assert slipping.reason == "friction alone does not limit the response to this force"
    window = frequency_window(joint)
    found = find_backbone(joint, [10 * sum_of_slip_forces], damping=0.0, window=window)
    assert found["complete"] == 1
    assert found.sizes["state"] < 100
    assert all(np.isfinite(found[name]).all() for name in found if found[name].dtype.kind == "f")


@pytest.mark.parametrize("resonance", [0, 4])
def test_a_mode_that_is_not_there_is_refused(joint, resonance):
    with pytest.raises(
        ValueError, match=f"resonance is {resonance}: it must be at least 1 and at most 3"
    ):
        EPMCEquations(joint, LOSS, resonance)


def test_forces_of_a_backbone_rise_and_cover_what_was_asked_for(any_joint, tmp_path):
    forces, window = [0.01, 1.0, 50.0], frequency_window(any_joint)
    found = find_backbone(any_joint, forces, damping=LOSS, window=window)
    assert found["complete"] == 1
    assert found["reason"] == ""
    units = {name: found[name].attrs["units"] for name in found}
    bias = {"bias": "kg^1/2 m"} if any_joint.normal_mode is not None else {}
    assert units == bias | {
        "modal_amplitude": "kg^1/2 m",
        "response_amplitude": "m",
        "natural_frequency": "Hz",
        "damping_ratio": "1",
        "friction_dissipation": "J",
        "peak_force": "N",
        "mode_shape": "1",
        "isolated_from": "N",
        "isolated_to": "N",
        "isolated_amplitude": "m",
        "complete": "1",
        "reason": "1",
    }
    force = found["peak_force"].to_numpy()
    assert np.all(np.diff(force) > 0)
    assert force[0] < forces[0] < forces[-1] < force[-1]
    assert np.all(np.diff(found["response_amplitude"]) > 0)
    mode = found["mode_shape"].sel(part="real") + 1j * found["mode_shape"].sel(part="imaginary")
    np.testing.assert_allclose((abs(mode) ** 2).sum("mode"), 1.0, atol=1e-8)
    dataset.save(found, tmp_path / "backbone.nc")
    xr.testing.assert_equal(dataset.load(tmp_path / "backbone.nc"), found)


@pytest.mark.parametrize("modes", [1, 3])
def test_the_peak_force_of_a_state_gives_its_amplitude_back(any_joint, modes):
    joint = with_one_mode(any_joint) if modes == 1 else any_joint
    window = frequency_window(joint)
    found = find_backbone(joint, [0.1, 10.0], damping=LOSS, window=window)
    backbone = trace_backbone(EPMCEquations(joint, LOSS), (1e-8, 1.0))
    for i in range(2, found.sizes["state"], 4):
        at = found.isel(state=i)
        response = synthesise_response(backbone, float(at["peak_force"]), window)
        s, c = response.modal_coordinate[response.peak].reshape(-1, modes)[-2:]
        mode = at["mode_shape"].to_numpy() @ [1, 1j]
        # of the corrector's tolerance, 1e-9 of the eigenvalue, over the damping ratio; with others
        # that respond to the excitation too, the output point is largest beside the mode's peak
        near = 1e-6 if modes == 1 else 3e-3
        assert response.frequency[response.peak] == pytest.approx(
            float(at["natural_frequency"]), rel=10 * near
        )
        assert abs(mode @ (s + 1j * c)) == pytest.approx(float(at["modal_amplitude"]), rel=near)
        response = abs((s + 1j * c) @ joint.response_mode)
        assert response == pytest.approx(float(at["response_amplitude"]), rel=near)


def test_responses_from_the_file_are_those_from_the_backbone(any_joint, tmp_path):
    forces, window = [0.5, 5.0], frequency_window(any_joint)
    dataset.save(
        find_backbone(any_joint, forces, damping=LOSS, window=window), tmp_path / "backbone.nc"
    )
    stored = dataset.load(tmp_path / "backbone.nc")
    known = backbone_from_dataset(any_joint, stored)
    how = {"damping": LOSS, "resonance": Resonance(1, window)}
    response = solve_response(any_joint, forces, ModalSynthesis(stored), **how)
    traced = solve_response(any_joint, forces, ModalSynthesis(), **how)
    assert len(known.states) == stored.sizes["state"]
    for i, force in enumerate(forces):
        alone = synthesise_response(known, force, window)
        assert response["peak_frequency"][i] == alone.frequency[alone.peak]
        # each is solved to the tolerance of the equations, over the damping ratio
        np.testing.assert_allclose(
            response["peak_amplitude"][i], traced["peak_amplitude"][i], rtol=1e-7
        )


def test_a_file_of_another_joint_is_refused(any_joint):
    window = frequency_window(any_joint)
    found = find_backbone(any_joint, [1.0], damping=LOSS, window=window)
    with pytest.raises(ValueError, match="stored has 3 modes, the joint 1"):
        backbone_from_dataset(with_one_mode(any_joint), found)


def test_a_backbone_that_begins_above_the_peak_is_told(joint):
    backbone = trace_backbone(EPMCEquations(joint, LOSS), (1e-4, 3e-4))
    part = synthesise_response(backbone, 5.0, frequency_window(joint))
    assert not part.complete
    assert part.frequency.size == 0
    assert "begins above" in part.reason


def test_a_mode_that_slips_from_the_first_is_followed_from_where_it_sticks(joint):
    mode, amplitudes = EPMCEquations(joint, LOSS), (5e-4, 1e-2)
    few = StepControl(maximum_iterations=3, target_iterations=1)
    assert not newton(mode, mode.start(), np.log(amplitudes[0]), few)[0].converged
    backbone = trace_backbone(mode, amplitudes, few)
    assert backbone.complete
    assert backbone.states[0].amplitude < amplitudes[0]
    known = mode_at(trace_backbone(mode, (1e-6, 1e-2)), 1e-3)
    assert mode_at(backbone, 1e-3).eigenvalue == pytest.approx(known.eigenvalue, rel=1e-7)


def test_a_mode_that_is_not_found_at_all_is_told(joint):
    hopeless = StepControl(maximum_iterations=1, target_iterations=1)
    window = frequency_window(joint)
    # all slips at the lowest amplitude too, so that the stuck mode is none
    part = synthesise_response(
        trace_backbone(EPMCEquations(joint, LOSS), (1e6, 1e7), hopeless), 5.0, window
    )
    assert (part.complete, part.peak, part.frequency.size) == (False, None, 0)
    assert part.reason == "no solution found at the start of the window"
    found = find_backbone(joint, [1e15], damping=LOSS, window=window, control=hopeless)
    assert (found["complete"], found.sizes["state"]) == (0, 0)
    assert found["reason"] == part.reason


@pytest.mark.parametrize("window", [(60.0, 90.0), (130.0, 170.0)])
def test_a_window_beside_the_peak_is_covered(joint, window):
    # the response to 5 N is largest at 110 Hz
    branch = solve_branch(
        joint, 5.0, method="backbone", damping=LOSS, resonance=Resonance(1, window)
    )
    assert (branch.frequency[0], branch.frequency[-1]) == pytest.approx(window)
    assert branch.complete
    assert branch.peak is None


@pytest.mark.parametrize("force", [0.5, 2.0, 5.0])
def test_the_peak_is_the_largest_response(joint, force):
    branch = solve_branch(joint, force, method="backbone", damping=LOSS)
    full = solve_branch(joint, force, damping=LOSS)
    assert branch.amplitude[branch.peak] == branch.amplitude.max()
    # what is left is that the other modes do not act back on the contact
    assert branch.frequency[branch.peak] == pytest.approx(full.frequency[full.peak], rel=3e-3)


def test_what_breaks_off_beyond_the_peak_does_not_matter(joint):
    window = frequency_window(joint)
    backbone = trace_backbone(EPMCEquations(joint, LOSS), (1e-6, 1e-2))
    whole = synthesise_response(backbone, 5.0, window)
    ended = replace(backbone, complete=False, reason="broke off at the far end")
    again = synthesise_response(ended, 5.0, window)
    np.testing.assert_array_equal(again.frequency, whole.frequency)
    assert again.complete
