"""Nonlinear modes with several harmonics: against SciPy, and against the motion they describe."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.linalg import expm
from scipy.optimize import brentq, fsolve, root
from small_joint import make_joint
from test_epmc import EXACT, SLIP, K, cantilever, mode_at, with_one_mode

from boltjoint import dataset
from boltjoint.dynamics.backbone.backbone import (
    backbone_from_dataset,
    find_backbone,
    trace_backbone,
)
from boltjoint.dynamics.backbone.epmc import EPMCEquations
from boltjoint.dynamics.backbone.modal_synthesis import synthesise_response
from boltjoint.dynamics.balance.harmonic_balance import HarmonicBalance
from boltjoint.dynamics.response.frequency_response import solve_branch
from boltjoint.dynamics.response.windows import Resonance, frequency_window
from boltjoint.friction.aft import AlternatingFrequencyTime
from boltjoint.solvers.step_control import StepControl

LOSS = 0.01
SAMPLES = 128


def sampled(joint, harmonics, samples=SAMPLES):
    return replace(joint, law=AlternatingFrequencyTime(joint.law, harmonics, samples))


def jenkins_forces(u, k, slip):
    """Force of a spring with a slider at samples of the second period, one after another."""
    z, force = 0.0, np.zeros(u.size)
    for _ in range(2):
        for i, each in enumerate(u):
            f = min(max(k * each - z, -slip), slip)
            z, force[i] = k * each - f, f
    return force


def solve_by_scipy(joint, harmonics, a, start):
    """Frequency, damping ratio and harmonics of a mode by SciPy, with complex exponentials.

    ``x = sum_h Re(X_h exp(ihwt))`` of odd h, all over again without the code that is tested.
    """
    L, r = (2 * np.pi * joint.natural_frequency) ** 2, joint.tangential_mode[0]
    odd, n = np.arange(1, harmonics + 1, 2), joint.natural_frequency.size
    t = 2 * np.pi * np.arange(SAMPLES) / SAMPLES
    waves = np.exp(1j * np.outer(odd, t))

    def left(unknown):
        w, zeta = unknown[0] * np.sqrt(L[0]), unknown[1]
        X = (unknown[2 : 2 + odd.size * n] + 1j * unknown[2 + odd.size * n :]).reshape(-1, n) * a
        force = jenkins_forces((waves.T @ (X @ r)).real, K, SLIP)
        F = 2 / SAMPLES * waves.conj() @ force
        rows = [
            (L * (1 + 1j * LOSS) - (h * w) ** 2 - 2j * zeta * h * w**2) * X[i] + r * F[i]
            for i, h in enumerate(odd)
        ]
        balance = np.ravel(rows) / (a * L[0])
        norm = np.sum(abs(X[0] / a) ** 2) - 1
        phase = np.sum((X[0] / a) ** 2).imag
        return [*balance.real, *balance.imag, norm, phase]

    found = root(left, start, tol=1e-14)
    assert np.linalg.norm(found.fun) < 1e-11
    return found.x


@pytest.mark.parametrize("modes", [1, 3])
def test_seven_harmonics_are_those_of_scipy(modes):
    joint = cantilever(modes)
    equations = EPMCEquations(sampled(joint, 7), LOSS)
    slips_at = SLIP / K / abs(joint.tangential_mode[0] @ equations.stuck)
    backbone = trace_backbone(equations, (0.5 * slips_at, 100 * slips_at), EXACT)
    assert backbone.complete
    first = 2 * np.pi * joint.natural_frequency[0]
    for times in (1.5, 3.0, 10.0, 50.0):
        state = mode_at(backbone, times * slips_at)
        q = state.modal_coordinate.reshape(4, 2, modes) / state.amplitude
        # Im(phi exp(ihwt)) = Re(-i phi exp(ihwt))
        X = -1j * (q[:, 0] + 1j * q[:, 1])
        start = [2 * np.pi * state.frequency / first, state.damping_ratio]
        start = np.concatenate([start, X.real.ravel(), X.imag.ravel()])
        # from a guess that is not the solution
        found = solve_by_scipy(joint, 7, state.amplitude, start * 1.001)
        np.testing.assert_allclose(found[:2], start[:2], rtol=1e-8)
        # the phase is fixed but for half a turn of the first harmonic
        np.testing.assert_allclose(abs(found[2:]), abs(start[2:]), atol=1e-8)
        assert np.linalg.norm(X[1:]) > 1e-4


def exact_motion(joint, reach, start):
    """Frequency, damping ratio and modal amplitude of the motion without excitation, exactly.

    The motion between changes of contact state is that of a linear system, by the exponential of
    its matrix; it begins where the element turns at the displacement ``reach`` and is its negative
    half a period later, as long as the element slips once in between.
    """
    L, r = (2 * np.pi * joint.natural_frequency) ** 2, joint.tangential_mode[0]
    n = L.size

    def system(stiffness, force, zeta, w):
        """Matrix of the state, its velocity and a constant 1."""
        A = np.zeros((2 * n + 1, 2 * n + 1))
        A[:n, n : 2 * n] = np.eye(n)
        A[n : 2 * n, :n] = -stiffness
        A[n : 2 * n, n : 2 * n] = 2 * zeta * w * np.eye(n)
        A[n : 2 * n, -1] = force
        return A

    def half_period(unknown):
        state, (w, zeta) = np.append(unknown[: 2 * n], 1.0), unknown[2 * n :]
        w = w * np.sqrt(L[0])
        # the slider stays where the force is the slip force now
        held = K * reach - SLIP
        stick = system(np.diag(L) + K * np.outer(r, r), held * r, zeta, w)
        slip = system(np.diag(L), SLIP * r, zeta, w)

        def beyond(t):
            return K * (r @ (expm(stick * t) @ state)[:n]) - held + SLIP

        t = np.linspace(0.0, np.pi / w, 200)
        # the first crossing: stuck for longer, it would swing back
        crossed = next(i for i, each in enumerate(t) if beyond(each) < 0)
        begin = brentq(beyond, t[crossed - 1], t[crossed], xtol=1e-16)
        then = expm(stick * begin) @ state
        return state, begin, then, stick, slip, w, zeta

    def left(unknown):
        state, begin, then, _, slip, w, _ = half_period(unknown)
        last = expm(slip * (np.pi / w - begin)) @ then
        scale = np.append(np.full(n, reach), np.full(n, reach * w))
        periodic = (last + state)[: 2 * n] / scale
        return [*periodic, (r @ state[:n]) / reach - 1, (r @ state[n : 2 * n]) / (reach * w)]

    found, info, success, _ = fsolve(left, start, xtol=1e-13, full_output=True)
    assert success == 1, info
    state, begin, then, stick, slip, w, zeta = half_period(found)
    samples = 2000
    t = np.pi / w * np.arange(samples) / samples
    motion = np.array(
        [
            (expm(stick * each) @ state if each < begin else expm(slip * (each - begin)) @ then)[:n]
            for each in t
        ]
    )
    # of half a period, the other half being its negative
    first = 2 / samples * np.exp(-1j * w * t) @ motion
    return w / (2 * np.pi), zeta, float(np.linalg.norm(first))


@pytest.mark.parametrize("times", [3.0, 10.0])
def test_harmonics_converge_to_the_exact_motion_of_a_cantilever(times):
    joint = cantilever(2)
    slip = SLIP / K
    stuck = EPMCEquations(joint, 0.0)
    slips_at = slip / abs(joint.tangential_mode[0] @ stuck.stuck)
    errors = []
    for harmonics in (1, 7, 31):
        equations = EPMCEquations(sampled(joint, harmonics, 1024), 0.0)
        backbone = trace_backbone(equations, (0.5 * slips_at, 4 * times * slips_at), EXACT)
        state = mode_at(backbone, times * slips_at)
        if harmonics == 1:
            w = 2 * np.pi * state.frequency
            s = (
                state.amplitude
                * state.mode
                * np.exp(-1j * np.angle(joint.tangential_mode[0] @ state.mode))
            )
            q, reach = s.real, abs(joint.tangential_mode[0] @ s)
            start = [*q, *(-w * s.imag), w / (2 * np.pi * joint.natural_frequency[0])]
            exact = exact_motion(joint, reach, [*start, state.damping_ratio])
        state = mode_at(backbone, exact[2])
        found = np.array([state.frequency, state.damping_ratio])
        errors.append(np.abs(found / exact[:2] - 1))
    errors = np.array(errors)
    # of frequency and damping; the second mode is near the sixth harmonic
    assert (errors[1] < [1e-3, 2e-3]).all()
    assert (errors[2] < [5e-6, 2e-5]).all()
    assert (errors[2] < errors[[0, 1]] / 20).all()


@pytest.mark.parametrize("law", ["constant", "variable"])
def test_jacobian_of_several_harmonics_equals_differences(law):
    equations = EPMCEquations(sampled(make_joint(law=law), 3), LOSS)
    random = np.random.default_rng(7)
    x = equations.start() + 0.3 * random.normal(size=equations.start().size)
    p = np.log(3e-5)
    jacobian = equations.evaluate(x, p)[1]()

    def difference(dx, dp):
        ahead, behind = (equations.evaluate(x + s * dx, p + s * dp)[0] for s in (1e-7, -1e-7))
        return (ahead - behind) / 2e-7

    tolerance = 1e-6 * np.abs(jacobian).max()
    for j, unit in enumerate(np.eye(x.size)):
        np.testing.assert_allclose(jacobian[:, j], difference(unit, 0.0), atol=tolerance)
    by_amplitude = equations.parameter_derivative(x, p)
    np.testing.assert_allclose(by_amplitude, difference(0.0 * x, 1.0), atol=tolerance)


@pytest.mark.parametrize("law", ["constant", "variable"])
def test_the_file_holds_all_harmonics(law, tmp_path):
    joint = sampled(make_joint(law=law), 3)
    window = frequency_window(joint)
    stored = find_backbone(joint, [1.0, 5.0], damping=LOSS, window=window)
    dataset.save(stored, tmp_path / "backbone.nc")
    again = backbone_from_dataset(joint, dataset.load(tmp_path / "backbone.nc"))
    for state in again.states[::5]:
        balance = HarmonicBalance(joint, LOSS, 0.0)
        residual = again.equations.evaluate(state.unknown, state.log_amplitude)[0]
        assert np.linalg.norm(residual) < 1e-7
        assert state.modal_coordinate.shape == (len(balance.components), 3)
    with pytest.raises(ValueError, match="stored has the components"):
        backbone_from_dataset(make_joint(law=law), stored)


@pytest.mark.parametrize("law", ["constant", "variable"])
def test_synthesised_response_has_the_harmonics_of_the_response(law):
    joint = sampled(with_one_mode(make_joint(law=law)), 3, 256)
    window = frequency_window(joint)
    branch = solve_branch(joint, 5.0, damping=LOSS, resonance=Resonance(1, window))
    equations = EPMCEquations(joint, LOSS)
    backbone = trace_backbone(equations, equations.amplitudes_for([5.0], window), StepControl())
    found = synthesise_response(backbone, 5.0, window)
    assert found.complete
    peak = found.modal_coordinate[found.peak].reshape(len(joint.law.components), -1)
    expected = branch.modal_coordinate[branch.peak].reshape(peak.shape)
    # the artificial damping of the third harmonic is all that the mode differs by
    assert found.frequency[found.peak] == pytest.approx(branch.frequency[branch.peak], rel=5e-3)
    first, third = (joint.law.components.index(name) for name in ("sin", "sin3"))
    for begin, share in ((first, 0.02), (third, 0.1)):
        of_harmonic = expected[begin : begin + 2]
        difference = np.linalg.norm(peak[begin : begin + 2] - of_harmonic)
        assert difference < share * np.linalg.norm(of_harmonic)
