"""Response of a structure with two interfaces of different laws, one tilted, against matrices.

The independent solution knows the matrices alone: harmonic balance in the degrees of freedom
themselves, sliders followed sample by sample, and a general solver of nonlinear equations.
"""

from dataclasses import replace

import numpy as np
import pytest
from examples import block_with_two_interfaces
from scipy.linalg import eigh
from scipy.optimize import root

from boltjoint.dynamics.response.frequency_response import solve_branch, solve_response
from boltjoint.friction.aft import AlternatingFrequencyTime
from boltjoint.friction.contact_states import STICK_SLIP, STICK_SLIP_SEPARATION
from boltjoint.joint.node_to_node import connect_pairs
from boltjoint.solvers.step_control import StepControl
from boltjoint.structure.model import Structure
from boltjoint.structure.modes import find_modes
from boltjoint.structure.preload import apply_preload

PRELOAD, LOSS_FACTOR, SHAKER = 5e3, 0.02, 2
#: law of the level and of the tilted interface, and the force [N] with which both slip, or one of
#: them separates, and no branch folds
BOTH = {
    "constant": ("constant", "constant", 30e3),
    "variable": ("variable", "variable", 6e3),
    "constant on the level one": ("constant", "variable", 20e3),
    "constant on the tilted one": ("variable", "constant", 6e3),
}
#: of the two interfaces: k_u and k_v [N/m], mu [-]
TANGENTIAL, NORMAL, FRICTION = (np.array(each) for each in ([2e8, 5e8], [1e8, 5e7], [0.4, 0.15]))


@pytest.fixture(scope="module")
def block():
    """Matrices, contact, structure, modes and preload of the block."""
    K, M, contact, bolt = block_with_two_interfaces()
    rows = {"inputs": {"shaker": SHAKER}, "outputs": {"sensor": SHAKER}}
    structure = Structure.from_matrices(K, M, contact, bolts={"one": bolt}, **rows)
    modes = find_modes(structure, f"all-{len(K)}")
    return K, M, contact, modes, apply_preload(structure, PRELOAD, tolerance=1e-13)


def joint_of(block, laws):
    """Each interface has its own law, stiffness and friction coefficient."""
    *_, modes, preload = block
    values = {"tangential_stiffness": TANGENTIAL, "friction_coefficient": FRICTION}
    level, tilted = ({name: each[i] for name, each in values.items()} for i in (0, 1))
    for i, keys in enumerate((level, tilted)):
        if laws[i] == "variable":
            keys["normal_stiffness"] = NORMAL[i]
    if laws[1] != laws[0]:
        tilted["law"] = laws[1]
    return connect_pairs(modes, preload, laws[0], surfaces={"tilted": tilted}, **level)


class DenseBalance:
    """Harmonic balance of M q'' + K (1 + i eta sign(w)) q + C^T f(C q) = F sin(wt) b."""

    def __init__(self, block, laws, force, harmonics, samples):
        self.K, self.M, contact, _, preload = block
        C = contact.relative.toarray()
        self.along, self.normal = C[0::3], C[2::3]
        self.load = preload["normal_load"].to_numpy()
        # whose load stays has no normal spring
        self.normal_stiffness = NORMAL * [each == "variable" for each in laws]
        self.force = force
        phase = 2 * np.pi * np.arange(samples) / samples
        self.harmonics = np.arange(1, harmonics + 1)
        angle = np.outer(self.harmonics, phase)
        self.waves = np.vstack([np.ones((1, samples)), np.sin(angle), np.cos(angle)])

    def contact_force(self, q):
        """Fourier coefficients (..., 1 + 2 harmonics, dofs) of the contact, q alike."""
        u, v = (np.moveaxis(q @ row.T, -2, -1) @ self.waves for row in (self.along, self.normal))
        load = self.load[:, None] + self.normal_stiffness[:, None] * v
        limit, stretch = FRICTION[:, None] * np.maximum(load, 0), TANGENTIAL[:, None] * u
        friction, slider = np.zeros_like(stretch), np.zeros(stretch.shape[:-1])
        for _ in range(2):
            for t in range(stretch.shape[-1]):
                spring, bound = stretch[..., t], limit[..., t]
                # closing is found between two samples, so that their error is of second order
                before, now = load[..., t - 1], load[..., t]
                closes = (before <= 0) & (now > 0)
                share = np.where(closes, before / np.where(closes, before - now, 1), 0)
                start = stretch[..., t - 1] + share * (spring - stretch[..., t - 1])
                slider = np.where(closes, start, slider)
                slider = np.minimum(np.maximum(slider, spring - bound), spring + bound)
                friction[..., t] = spring - slider
        excess = np.maximum(load, 0) - self.load[:, None]
        transform = self.waves.T * 2 / self.waves.shape[1]
        transform[:, 0] /= 2
        of_friction, of_load = (
            np.moveaxis(force @ transform, -1, -2) for force in (friction, excess)
        )
        return of_friction @ self.along + of_load @ self.normal

    def residual(self, q, w):
        """Shape of q, by the frequencies w [rad/s] (...,)."""
        H = self.harmonics.size
        mean, sin, cos = q[..., :1, :], q[..., 1 : 1 + H, :], q[..., 1 + H :, :]
        inertia = (np.multiply.outer(w, self.harmonics) ** 2)[..., None]
        damping = LOSS_FACTOR * self.K
        linear = [
            mean @ self.K,
            sin @ self.K - inertia * (sin @ self.M) - cos @ damping,
            cos @ self.K - inertia * (cos @ self.M) + sin @ damping,
        ]
        residual = np.concatenate(linear, axis=-2) + self.contact_force(q)
        residual[..., 1, SHAKER] -= self.force
        return residual

    def stuck(self, w):
        """The linear response while nothing slips, as an initial guess."""
        D = (1 + 1j * LOSS_FACTOR) * self.K - w**2 * self.M
        D = D + self.along.T @ (TANGENTIAL[:, None] * self.along)
        D = D + self.normal.T @ (self.normal_stiffness[:, None] * self.normal)
        z = np.linalg.solve(D, self.force * np.eye(len(D))[SHAKER])
        q = np.zeros((len(self.waves), len(D)))
        q[1], q[1 + self.harmonics.size] = z.real, z.imag
        return q

    def jacobian(self, q, w):
        """Derivative of the residual by forward differences."""
        step = 1e-7 * abs(q).max()
        changes = step * np.eye(q.size).reshape(-1, *q.shape)
        changed = self.residual(np.concatenate([q[None], q + changes]), w)
        return (changed[1:] - changed[0]).reshape(q.size, -1).T / step

    def solve(self, w):
        """Coefficients (1 + 2 harmonics, dofs) at one frequency [rad/s]."""
        start = self.stuck(w)
        scale, shape = abs(start).max(), start.shape
        solution = root(
            lambda x: self.residual(scale * x.reshape(shape), w).ravel() / self.force,
            (start / scale).ravel(),
            jac=lambda x: self.jacobian(scale * x.reshape(shape), w) * scale / self.force,
            tol=1e-13,
        )
        assert abs(solution.fun).max() < 1e-11
        return scale * solution.x.reshape(shape)


def near_the_peak(branch):
    """Places of a branch on both flanks and at the peak."""
    assert branch.complete
    peak = branch.peak
    height = branch.amplitude / branch.amplitude[peak]
    below = np.argmin(abs(height[:peak] - 0.8))
    above = peak + np.argmin(abs(height[peak:] - 0.8))
    return int(below), peak, int(above)


def in_freedoms(block, joint, branch, at):
    """Coefficients in degrees of freedom of a solution of the library, (components, dofs)."""
    K, M, *_ = block
    squared, shape = eigh(K, M)
    np.testing.assert_allclose(2 * np.pi * joint.natural_frequency, np.sqrt(squared), rtol=1e-10)
    # the library's modes have signs of their own
    sign = np.sign(shape[SHAKER] * joint.response_mode)
    return branch.modal_coordinate[at].reshape(-1, squared.size) @ (shape * sign).T


def components(harmonics):
    """Names of the coefficients of the dense balance in their order."""
    numbers = [str(h) if h > 1 else "" for h in range(1, harmonics + 1)]
    return ["bias", *(part + number for part in ("sin", "cos") for number in numbers)]


@pytest.mark.parametrize("name", BOTH)
def test_the_response_of_three_harmonics_is_that_of_matrices_and_sliders_alone(block, name):
    *laws, force = BOTH[name]
    joint = joint_of(block, laws)
    # the same samples, so that the two differ by rounding alone
    harmonics, samples = 3, 128
    sampled = replace(joint, law=AlternatingFrequencyTime(joint.law, harmonics, samples))
    control = StepControl(tolerance=1e-11)
    branch = solve_branch(sampled, force, damping=LOSS_FACTOR, control=control)
    balance = DenseBalance(block, laws, force, harmonics, samples)
    for at in near_the_peak(branch):
        expected = balance.solve(2 * np.pi * branch.frequency[at])
        motion = dict(zip(components(harmonics), expected, strict=True))
        own = dict(zip(sampled.law.components, in_freedoms(block, joint, branch, at), strict=True))
        for name, coefficients in motion.items():
            np.testing.assert_allclose(
                own.get(name, 0 * coefficients),
                coefficients,
                rtol=0,
                atol=1e-8 * abs(expected).max(),
            )
        amplitude = np.hypot(motion["sin"], motion["cos"])[SHAKER]
        assert branch.amplitude[at] == pytest.approx(amplitude, rel=1e-8)


@pytest.mark.parametrize("name", BOTH)
def test_the_response_of_closed_forms_is_that_of_many_samples(block, name):
    *laws, force = BOTH[name]
    joint = joint_of(block, laws)
    control = StepControl(tolerance=1e-11)
    branch = solve_branch(joint, force, damping=LOSS_FACTOR, control=control)
    # sampling has an error of second order: by the most samples below 1e-8
    balance, coarse = (DenseBalance(block, laws, force, 1, samples) for samples in (2**16, 2**8))
    places = near_the_peak(branch)
    w = 2 * np.pi * branch.frequency[list(places)]
    motion = []
    for at in places:
        own = dict(zip(joint.law.components, in_freedoms(block, joint, branch, at), strict=True))
        motion.append([own.get(name, np.zeros(len(block[0]))) for name in components(1)])
    motion = np.array(motion)
    for at, q, residual in zip(w, motion, balance.residual(motion, w), strict=True):
        error = np.linalg.solve(coarse.jacobian(q, at), residual.ravel())
        assert abs(error).max() < 1e-8 * abs(q).max()
        # another start leads there, too
        np.testing.assert_allclose(coarse.solve(at), q, rtol=0, atol=1e-3 * abs(q).max())
    rows = [row @ branch.modal_coordinate[branch.peak].reshape(-1, 12).T for row in joint.rows]
    state = joint.law.contact_state(np.hstack(rows))
    of_points = dict(zip(joint.law.point_of_element.tolist(), state.tolist(), strict=True))
    separates = laws[0] == "variable"
    assert of_points == {0: STICK_SLIP_SEPARATION if separates else STICK_SLIP, 1: STICK_SLIP}


@pytest.mark.parametrize("name", ["variable", "constant on the tilted one"])
def test_responses_to_several_forces_hold_the_same_amplitudes(block, name):
    *laws, _ = BOTH[name]
    joint = joint_of(block, laws)
    forces = [3e3, 6e3]
    found = solve_response(joint, forces, damping=LOSS_FACTOR)
    for force, amplitude, frequency in zip(
        forces, found["peak_amplitude"], found["peak_frequency"], strict=True
    ):
        balance = DenseBalance(block, laws, force, 1, 2**10)
        _, sin, cos = balance.solve(2 * np.pi * float(frequency))
        # a peak is flat: its frequency hardly matters; the samples do
        assert np.hypot(sin, cos)[SHAKER] == pytest.approx(float(amplitude), rel=1e-4)
